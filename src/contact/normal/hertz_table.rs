//! Hertz's ellipse functions from elliptic integrals, tabulated once over the ratio of curvatures.
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

use crate::math::spline::CubicSpline;
use ellip::{elliprd, elliprf, elliprg};
use std::f64::consts::{FRAC_2_PI, PI};
use std::sync::LazyLock;

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

/// `g = minor / major` for `ln(larger / smaller curvature) = x >= 0`, by Newton in `ln g` from `start`.
fn axis_ratio(x: f64, start: f64) -> f64 {
    let mut log_g = start.ln();
    for _ in 0..60 {
        let g = log_g.exp().min(1.0);
        let residual = curvature_ratio(g).ln() - x;
        // The ratio behaves like g^(-3/2) near the circle and like g^-2 for slender ellipses: the secant through
        // a slightly smaller g is slope enough, the fixed point is exact.
        let h = 1e-4;
        let slope = (curvature_ratio((log_g - h).exp().min(1.0)).ln() - residual - x) / -h;
        let step = residual / slope;
        log_g = (log_g - step).min(0.0);
        if step.abs() < 1e-15 {
            break;
        }
    }
    log_g.exp()
}

/// The functions straight from the integrals, for `x = ln(B / A)`; used to fill and to check the table.
pub fn ellipse_functions_exact(x: f64) -> EllipseFunctions {
    from_axis_ratio(x, axis_ratio(x.abs(), (-0.6 * x.abs()).exp()))
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

/// `m_a`, `m_b` and `approach` over x.
type Table = [CubicSpline; 3];

/// |ln(B/A)| up to which the table reaches: axis ratios down to about 1:1600.
const REACH: f64 = 12.0;
const STEP: f64 = 0.01;

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let count = (REACH / STEP).round() as i64;
    let mut g = 1.0;
    let half: Vec<EllipseFunctions> = (0..=count)
        .map(|i| {
            let x = i as f64 * STEP;
            g = axis_ratio(x, g);
            from_axis_ratio(x, g)
        })
        .collect();
    // m_b(x) = m_a(-x) and xi is even: half the integrals are enough.
    let at = |i: i64| half[i.unsigned_abs() as usize];
    let spline = |value: &dyn Fn(i64) -> f64| {
        let points: Vec<(f64, f64)> = (-count..=count).map(|i| (i as f64 * STEP, value(i))).collect();
        CubicSpline::natural(&points).unwrap_or_else(|error| unreachable!("Hertz table: {error}"))
    };
    let along = |i: i64| if i >= 0 { at(i).m_a } else { at(i).m_b };
    [spline(&along), spline(&|i| along(-i)), spline(&|i| at(i).approach)]
});

/// The functions for `x = ln(B / A)` from the table: relative error below 1e-10 for axis ratios up to 1:100. Beyond the
/// table's reach the last ellipse is kept.
#[inline]
pub fn ellipse_functions(x: f64) -> EllipseFunctions {
    let [m_a, m_b, approach] = CubicSpline::values(&TABLE, x.clamp(-REACH, REACH));
    EllipseFunctions { m_a, m_b, approach }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_table_agrees_with_the_integrals_to_1e_10() {
        let mut worst: f64 = 0.0;
        for i in 0..2000 {
            // Between knots, down to axis ratios of 1:100 (ln(B/A) = 7.3).
            let x = -7.3 + 14.6 * (i as f64 + 0.37) / 2000.0;
            let (table, exact) = (ellipse_functions(x), ellipse_functions_exact(x));
            for (a, b) in [(table.m_a, exact.m_a), (table.m_b, exact.m_b), (table.approach, exact.approach)] {
                worst = worst.max((a / b - 1.0).abs());
            }
        }
        println!("largest relative error of the table: {worst:.1e}");
        assert!(worst < 1e-10);
    }

    #[test]
    fn validate_published_hertz_coefficients() {
        // Johnson's and Harris's tables in finer form: theta, m, n, xi at cos(theta) = (B - A)/(B + A);
        // computed from complete elliptic integrals with mpmath by another program.
        let published = [
            (1.0, 36.931940, 0.131295, 0.121107),
            (5.0, 11.238062, 0.238136, 0.296894),
            (10.0, 6.611455, 0.310983, 0.428013),
            (30.0, 2.730648, 0.493060, 0.726310),
            (45.0, 1.926462, 0.603828, 0.854714),
            (60.0, 1.485824, 0.717100, 0.937592),
            (80.0, 1.127816, 0.892717, 0.993213),
            (90.0, 1.0, 1.0, 1.0),
        ];
        for (theta, m, n, xi) in published {
            let cos = f64::to_radians(theta).cos();
            let x = ((1.0 + cos) / (1.0 - cos)).ln();
            let found = ellipse_functions(x);
            for (a, b) in [(found.m_a, m), (found.m_b, n), (found.approach, xi)] {
                assert!((a - b).abs() < 6e-7 * b.max(1.0), "theta {theta}: {a} {b}");
            }
        }
    }
}
