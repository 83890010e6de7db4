//! Hertz's ellipse functions ([`super::hertz_integrals`]) tabulated over the ratio of curvatures.
//!
//! The nodes are made when the program is built (`build.rs`): at a start their integrals were a third of all that a wheelset's run of 1 ms computes.

use super::hertz_integrals::{EllipseFunctions, REACH, STEP};
use crate::math::spline::CubicSpline;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// m_a, m_b and approach at each node from x = 0 on, little endian.
static NODES: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/hertz_nodes.bin"));

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

    /// From the numbers that the build has made.
    fn fill() -> Self {
        let number = |bytes: &[u8; 8]| f64::from_le_bytes(*bytes);
        let nodes = NODES.as_chunks::<8>().0.as_chunks::<3>().0;
        let half: Vec<EllipseFunctions> = nodes
            .iter()
            .map(|[m_a, m_b, approach]| EllipseFunctions { m_a: number(m_a), m_b: number(m_b), approach: number(approach) })
            .collect();
        let count = half.len() as i64 - 1;
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
    use super::super::hertz_integrals::ellipse_functions_exact;
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
