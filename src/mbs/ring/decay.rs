//! How fast waves die out along a rail: how long a ring has to be.
//!
//! With pads, sleepers and ballast spread along the bays, waves `e^(i (w t - k x))` of a Timoshenko beam on the dynamic stiffness s(w) per metre obey
//!
//! ```text
//! (m w^2 - s - GA k^2) (r w^2 - GA - EI k^2) = (GA k)^2,     s = 1 / (L / (k_p + i w c_p) + L / (k_b + i w c_b - m_s w^2))
//! ```
//!
//! with m = rho A, r = rho I, and EI and GA = kappa G A times `1 + i eta`: a quadratic in k^2. The lesser |Im k| is the decay of the wave that goes far. Sleepers one by one change it near the
//! pinned-pinned frequency alone.

use super::Bay;
use nalgebra::Complex;
use std::f64::consts::TAU;

/// Frequencies that are looked at: from this one on, Hz, and how many, each so many times the one before up to the highest.
const LOWEST: f64 = 50.0;
const COUNT: i32 = 80;

impl Bay {
    /// Decay of the wave that goes farthest at a circular frequency `w` [rad/s], 1/m.
    pub fn decay(&self, w: f64) -> f64 {
        let i = Complex::new(0.0, 1.0);
        let pad = self.pad_stiffness + i * (w * self.pad_damping);
        let ballast = self.ballast_stiffness - self.sleeper_mass * w * w + i * (w * self.ballast_damping);
        let support = (pad.inv() + ballast.inv()).inv() / self.spacing;
        let lossy = 1.0 + i * self.loss;
        let (bending, shear) = (lossy * self.bending, lossy * self.shear);
        let (lift, turn) = (self.mass * w * w - support, self.rotary * w * w - shear);
        // shear bending K^2 - (shear rotary w^2 + bending lift) K + lift turn = 0 for K = k^2.
        let (a, b, c) = (shear * bending, shear * (self.rotary * w * w) + bending * lift, lift * turn);
        let root = (b * b - a * c * 4.0).sqrt();
        [b + root, b - root].map(|twice| (twice / (a * 2.0)).sqrt().im.abs()).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The least decay up to a frequency [Hz], 1/m.
    pub fn least_decay(&self, highest: f64) -> f64 {
        let ratio = (highest / LOWEST).max(1.0);
        (0..=COUNT).map(|n| self.decay(TAU * LOWEST * ratio.powf(f64::from(n) / f64::from(COUNT)))).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mbs::ring::{Ring, tests::bay};

    /// Receptances of a long ring, 6 and 18 m from the force, fall by the decay between them; without any loss a wave goes on for ever, and a stiff foundation lets none go.
    #[test]
    fn analytic_waves_die_out_as_a_long_ring_says() {
        let soft = Bay { loss: 0.02, pad_stiffness: 60e6, pad_damping: 6e3, sleeper_mass: 150.0, ..bay() };
        let ring = Ring::new(&soft, 300, TAU * 6000.0);
        for f in [250.0, 500.0, 800.0] {
            let w = TAU * f;
            // Over half a wave: what the near field and waves from behind add goes up and down.
            let size = |x: f64| (0..40).map(|n| ring.receptance(0.15, 0.15 + x + 0.05 * f64::from(n), w).norm().ln()).sum::<f64>() / 40.0;
            let found = (size(6.0) - size(18.0)) / 12.0;
            println!("{f} Hz: {found} of {}", soft.decay(w));
            assert!((found / soft.decay(w) - 1.0).abs() < 0.06, "{f} Hz: {found} {}", soft.decay(w));
        }
        let lossless = Bay { loss: 0.0, pad_damping: 0.0, ballast_damping: 0.0, ..soft };
        assert!(lossless.decay(TAU * 800.0) < 1e-9 && lossless.decay(TAU * 30.0) > 0.3, "{}", lossless.decay(TAU * 30.0));
        assert!((soft.least_decay(3000.0) - 0.071).abs() < 1e-3);
    }
}
