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
use std::sync::{Arc, Mutex, PoisonError, Weak};

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
pub(super) fn curvature_ratio_of_axes(ratio: f64) -> f64 {
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
const REACH: f64 = 12.0;
const STEP: f64 = 0.01;

/// The functions over `x = ln(B / A)`: relative error below 1e-10 for axis ratios up to 1:100. Beyond the table's reach
/// (axis ratios of about 1:1600) the last ellipse is kept.
#[derive(Debug)]
pub struct EllipseTable {
    /// `m_a`, `m_b` and `approach`.
    splines: [CubicSpline; 3],
}

/// The table is made once and shared while somebody holds it; it is freed with its last user, so that a host that
/// unloads the FMU's library gets its memory back.
static SHARED: Mutex<Weak<EllipseTable>> = Mutex::new(Weak::new());

/// A user's hold on the shared table.
#[derive(Debug)]
pub struct SharedTable(Arc<EllipseTable>);

impl std::ops::Deref for SharedTable {
    type Target = EllipseTable;
    fn deref(&self) -> &EllipseTable {
        &self.0
    }
}

impl Drop for SharedTable {
    /// The last user also lets go of the weak reference, which would keep a block of memory.
    fn drop(&mut self) {
        let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
        if Arc::strong_count(&self.0) == 1 {
            *shared = Weak::new();
        }
    }
}

impl EllipseTable {
    /// The table, made if nobody holds one.
    pub fn shared() -> SharedTable {
        let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
        SharedTable(shared.upgrade().unwrap_or_else(|| {
            let table = Arc::new(Self::fill());
            *shared = Arc::downgrade(&table);
            table
        }))
    }

    /// The functions at `x`.
    #[inline]
    pub fn at(&self, x: f64) -> EllipseFunctions {
        let [m_a, m_b, approach] = CubicSpline::values(&self.splines, x.clamp(-REACH, REACH));
        EllipseFunctions { m_a, m_b, approach }
    }

    fn fill() -> Self {
        let count = (REACH / STEP).round() as i64;
        // From where the parabola through the last three leads.
        let mut last = [0.0f64; 3];
        let half: Vec<EllipseFunctions> = (0..=count)
            .map(|i| {
                let x = i as f64 * STEP;
                let log_g = log_axis_ratio(x, (3.0 * (last[2] - last[1]) + last[0]).min(0.0));
                last = [last[1], last[2], log_g];
                from_axis_ratio(x, log_g.exp())
            })
            .collect();
        // m_b(x) = m_a(-x) and xi is even: half the integrals are enough.
        let at = |i: i64| half[i.unsigned_abs() as usize];
        let spline = |value: &dyn Fn(i64) -> f64| {
            let points: Vec<(f64, f64)> = (-count..=count).map(|i| (i as f64 * STEP, value(i))).collect();
            CubicSpline::natural(&points).unwrap_or_else(|error| unreachable!("Hertz table: {error}"))
        };
        let along = |i: i64| if i >= 0 { at(i).m_a } else { at(i).m_b };
        EllipseTable { splines: [spline(&along), spline(&|i| along(-i)), spline(&|i| at(i).approach)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_table_agrees_with_the_integrals_to_1e_10() {
        let shared = EllipseTable::shared();
        let mut worst: f64 = 0.0;
        for i in 0..2000 {
            // Between knots, down to axis ratios of 1:100 (ln(B/A) = 7.3).
            let x = -7.3 + 14.6 * (i as f64 + 0.37) / 2000.0;
            let (table, exact) = (shared.at(x), ellipse_functions_exact(x));
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
            let found = EllipseTable::shared().at(x);
            for (a, b) in [(found.m_a, m), (found.m_b, n), (found.approach, xi)] {
                assert!((a - b).abs() < 6e-7 * b.max(1.0), "theta {theta}: {a} {b}");
            }
        }
    }
}
