//! Strips of an elliptic patch along the rolling direction, in bundles that the compiler turns into vector instructions.
//!
//! Strips lie at the nodes of Gauss and Legendre's rule across the patch (y in units of b), not at equal distances: polynomials
//! in y, such as the forces of Kalker's simplified theory without slip (1 - y^2), are then exact with few strips. Small
//! multiples of P4(y) and P6(y), to which lower powers are orthogonal, are mixed into the weights so that sqrt(1 - y^2) and
//! (1 - y^2)^(3/2) are exact too: the linear limit of strip theory, and mu N in full sliding on a parabolic bound.

use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use std::f64::consts::PI;

/// Strips that are computed together.
pub(super) const LANES: usize = 10;

/// One number for each strip of a bundle.
pub(super) type Lanes = [f64; LANES];

/// A bundle of strips. Those that fill up the last bundle have no weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bundle {
    /// y / b.
    pub y: Lanes,
    /// Half length over a, sqrt(1 - y^2).
    pub half: Lanes,
    /// Integrates over y / b.
    pub weight: Lanes,
}

/// All strips of a patch.
#[derive(Clone, Debug)]
pub(super) struct Strips(pub Vec<Bundle>);

/// Node and weight number `index` of Gauss and Legendre's rule with `count` nodes on [-1, 1].
fn gauss(index: usize, count: usize) -> (f64, f64) {
    let n = count as f64;
    let mut x = (PI * (index as f64 + 0.75) / (n + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..20 {
        let (mut before, mut here) = (1.0, x);
        for k in 2..=count {
            let k = k as f64;
            (before, here) = (here, ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k);
        }
        slope = n * (x * here - before) / (x * x - 1.0);
        let step = here / slope;
        x -= step;
        if step.abs() < 1e-16 {
            break;
        }
    }
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}

/// Legendre's polynomials of degree 4 and 6.
fn p4(y: f64) -> f64 {
    let y = y * y;
    (y * (35.0 * y - 30.0) + 3.0) / 8.0
}

fn p6(y: f64) -> f64 {
    let y = y * y;
    (y * (y * (231.0 * y - 315.0) + 105.0) - 5.0) / 16.0
}

/// Fewest strips: fewer can't carry the corrections of the weights.
pub(super) const FEWEST: usize = 8;

impl Strips {
    /// `count` strips, [`FEWEST`] or more.
    pub fn new(count: usize) -> Self {
        let mut rule: Vec<(f64, f64)> = (0..count).map(|index| gauss(index, count)).collect();
        let sum = |f: &dyn Fn(f64) -> f64| rule.iter().map(|(y, w)| w * f(*y)).sum::<f64>();
        let (root, slide) = (|y: f64| (1.0 - y * y).sqrt(), |y: f64| (1.0 - y * y).powf(1.5));
        let missing = [PI / 2.0 - sum(&root), 3.0 * PI / 8.0 - sum(&slide)];
        let [m11, m12] = [sum(&|y| p4(y) * root(y)), sum(&|y| p6(y) * root(y))];
        let [m21, m22] = [sum(&|y| p4(y) * slide(y)), sum(&|y| p6(y) * slide(y))];
        let determinant = m11 * m22 - m12 * m21;
        let first = (missing[0] * m22 - missing[1] * m12) / determinant;
        let second = (m11 * missing[1] - m21 * missing[0]) / determinant;
        for (y, weight) in &mut rule {
            *weight *= 1.0 + first * p4(*y) + second * p6(*y);
        }
        let bundles = rule.chunks(LANES).map(|chunk| {
            let mut bundle = Bundle { y: [0.0; LANES], half: [1.0; LANES], weight: [0.0; LANES] };
            for (lane, (y, weight)) in chunk.iter().enumerate() {
                (bundle.y[lane], bundle.half[lane], bundle.weight[lane]) = (*y, (1.0 - y * y).sqrt(), *weight);
            }
            bundle
        });
        Strips(bundles.collect())
    }
}

/// Sum over the strips of a bundle, in a fixed order.
#[inline]
pub(super) fn sum(weight: &Lanes, values: &Lanes) -> f64 {
    weight.iter().zip(values).map(|(w, v)| w * v).sum()
}

/// Most strips or cells.
const MOST: usize = 1000;

/// Reads a whole number of strips or cells.
pub(super) fn count(section: &Section, key: &'static str, default: usize, least: usize) -> Result<usize, SettingsError> {
    let value = section.number_or(key, Dimension::None, default as f64)?;
    if value.fract() != 0.0 || value < least as f64 || value > MOST as f64 {
        return Err(section.error(key, format!("found {value:?}, expected a whole number from {least} to {MOST}")));
    }
    Ok(value as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_integrals_of_full_sliding_and_of_the_linear_theory_are_exact() {
        for count in [FEWEST, 9, 10, 20, 101] {
            let strips = Strips::new(count);
            let integral = |f: fn(f64) -> f64| -> f64 { strips.0.iter().map(|b| sum(&b.weight, &b.half.map(f))).sum() };
            assert!((integral(|h| h * h) - 4.0 / 3.0).abs() < 1e-13, "{count}");
            assert!((integral(|h| h) - PI / 2.0).abs() < 1e-13, "{count}");
            assert!((integral(|h| h * h * h) - 3.0 * PI / 8.0).abs() < 1e-13, "{count}");
            assert_eq!(strips.0.iter().flat_map(|b| b.weight).filter(|w| *w > 0.0).count(), count);
        }
    }
}
