//! The greatest eigenvalue of J among bodies.

use super::Tangent;
use crate::mbs::body::COORDINATES;

impl Tangent {
    /// |lambda| [1/s] and damping -Re(lambda) / |lambda| of the eigenvalue of J that is largest in size, with bodies' coordinates and velocities alone: by
    /// `iterations` of x <- J^2 x, whose last three members of a sequence x, J x, J^2 x tell both by least squares. Needs [`Tangent::finish`] and three vectors as long
    /// as the state. Zeros where nothing holds the bodies.
    pub fn fastest(&self, [x, once, twice]: [&mut [f64]; 3], iterations: usize) -> [f64; 2] {
        let count = 2 * COORDINATES * self.mobility.len();
        // Some of each motion.
        for (i, value) in x.iter_mut().enumerate() {
            *value = if i < count { 0.5 + (i * 7919 % 101) as f64 / 101.0 } else { 0.0 };
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for iteration in 0..=iterations {
            self.times(x, once);
            once[count..].fill(0.0);
            self.times(once, twice);
            twice[count..].fill(0.0);
            let size = dot(twice, twice).sqrt();
            if !(size > 0.0 && size.is_finite()) {
                return [0.0; 2];
            }
            if iteration < iterations {
                x.iter_mut().zip(twice.iter()).for_each(|(x, twice)| *x = twice / size);
            }
        }
        let [xx, xp, pp, xr, pr] = [dot(x, x), dot(x, once), dot(once, once), dot(x, twice), dot(once, twice)];
        let determinant = xx * pp - xp * xp;
        // Of one real eigenvalue both vectors are parallel.
        if determinant <= 1e-9 * xx * pp {
            let real = xp / xx;
            return [real.abs(), -real.signum()];
        }
        let twice_real = (xx * pr - xp * xr) / determinant;
        let squared = -(pp * xr - xp * pr) / determinant;
        if squared > 0.0 { [squared.sqrt(), -0.5 * twice_real / squared.sqrt()] } else { [(pp / xx).sqrt(), 0.0] }
    }
}
