//! Hertz's ellipse functions from elliptic integrals. The build tabulates them ([`super::hertz_table`]); this file stands alone, so that it can.
//!
//! Two smooth bodies with half relative principal curvatures A (along e1) and B (along e2), pressed by N, touch in
//! an ellipse with semi-axes `a = m_a c0`, `b = m_b c0` and approach `delta = xi (A + B) c0^2`, where
//! `c0^3 = 3 N (1 - nu^2) / (2 E (A + B))` for two bodies of equal material. With g = minor / major axis,
//! modulus k^2 = 1 - g^2 and the complete elliptic integrals K, E:
//!
//! ```text
//! (larger / smaller curvature) = (E/g^2 - K) / (K - E)
//! m^3 = 2 E / (pi g^2)  (major axis, in the direction of the smaller curvature),  n = m g,  xi = 2 K / (pi m)
//! ```
//!
//! Near the circle both `E/g^2 - K` and `K - E` vanish; their Carlson forms `k^2/3 R_D(0, 1, g^2)` and
//! `k^2/3 R_D(0, g^2, 1)` share the vanishing factor, so the ratio is computed without cancellation.
//! Source: K.L. Johnson, Contact Mechanics, chapter 4; B.C. Carlson's symmetric integrals.

use ellip::{elliprd, elliprf, elliprg};
use std::f64::consts::{FRAC_2_PI, PI};

/// The three ellipse functions at one ratio of curvatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipseFunctions {
    /// a / c0, the axis along e1.
    pub m_a: f64,
    /// b / c0.
    pub m_b: f64,
    /// delta / ((A + B) c0^2).
    pub approach: f64,
}

/// The integrals accept the arguments that are used here (0 <= x, 0 < y, z); NaN would show any misuse.
fn r_d(x: f64, y: f64, z: f64) -> f64 {
    elliprd(x, y, z).unwrap_or(f64::NAN)
}

/// Ratio of the larger to the smaller curvature for an ellipse with axis ratio `g` in (0, 1].
fn curvature_ratio(g: f64) -> f64 {
    r_d(0.0, 1.0, g * g) / r_d(0.0, g * g, 1.0)
}

/// B / A of the ellipse with semi-axes a (along e1) and b of ratio `a / b`.
pub fn curvature_ratio_of_axes(ratio: f64) -> f64 {
    if ratio >= 1.0 { curvature_ratio(1.0 / ratio) } else { 1.0 / curvature_ratio(ratio) }
}

/// `ln g`, g = minor / major, for `ln(larger / smaller curvature) = x >= 0`, by a chord method from `log_g`.
///
/// The ratio behaves like g^(-3/2) near the circle and like g^-2 for slender ellipses: the secant through a slightly smaller g is slope enough for steps below
/// [`ALIKE`], each of which leaves 1e-4 of the one before; the fixed point is exact.
fn log_axis_ratio(x: f64, mut log_g: f64) -> f64 {
    let residual = |log_g: f64| curvature_ratio(log_g.exp().min(1.0)).ln() - x;
    let mut slope = f64::NAN;
    for _ in 0..60 {
        let here = residual(log_g);
        if slope.is_nan() {
            const BESIDE: f64 = 1e-4;
            slope = (here - residual(log_g - BESIDE)) / BESIDE;
        }
        let step = here / slope;
        log_g = (log_g - step).min(0.0);
        if step.abs() < LAST {
            break;
        }
        if step.abs() > ALIKE {
            slope = f64::NAN;
        }
    }
    log_g
}

/// Steps in ln g over which the slope is alike, and after which the next one would be less than rounding.
const ALIKE: f64 = 1e-3;
const LAST: f64 = 1e-12;

/// The functions straight from the integrals, for `x = ln(B / A)`; used to fill and to check the table.
pub fn ellipse_functions_exact(x: f64) -> EllipseFunctions {
    from_axis_ratio(x, log_axis_ratio(x.abs(), -0.6 * x.abs()).exp())
}

fn from_axis_ratio(x: f64, g: f64) -> EllipseFunctions {
    // K = R_F(0, g^2, 1), E = 2 R_G(0, g^2, 1).
    let k = elliprf(0.0, g * g, 1.0).unwrap_or(f64::NAN);
    let e = 2.0 * elliprg(0.0, g * g, 1.0).unwrap_or(f64::NAN);
    let major = (2.0 * e / (PI * g * g)).cbrt();
    let minor = major * g;
    let (m_a, m_b) = if x >= 0.0 { (major, minor) } else { (minor, major) };
    EllipseFunctions { m_a, m_b, approach: FRAC_2_PI * k / major }
}

/// |ln(B/A)| up to which the table reaches: axis ratios down to about 1:1600.
pub const REACH: f64 = 12.0;
/// Distance of the table's nodes.
pub const STEP: f64 = 0.01;

/// The functions at the table's nodes from x = 0 on: for x < 0 both axes change places.
pub fn nodes() -> Vec<EllipseFunctions> {
    let count = (REACH / STEP).round() as i64;
    // From where the parabola through the last three leads.
    let mut last = [0.0f64; 3];
    let node = |i: i64| {
        let x = i as f64 * STEP;
        let log_g = log_axis_ratio(x, (3.0 * (last[2] - last[1]) + last[0]).min(0.0));
        last = [last[1], last[2], log_g];
        from_axis_ratio(x, log_g.exp())
    };
    (0..=count).map(node).collect()
}
