//! Looks again at what is watched.

use super::GlobalSearch;
use super::branch::{Scan, State};
use super::motion::{MOST_STEADY, less};
use super::view::View;
use super::watch::{BITS, Watch};
use crate::contact::search::algebraic::{Pair, SurfaceParameters};

impl GlobalSearch {
    /// Looks at what is watched: for how much motion [m] it stays as it is; `None` when something has been born or has gone. Any
    /// contact tells where on the rail that is.
    pub fn watched(&self, pair: &Pair, watch: &Watch, contact: &SurfaceParameters) -> Option<f64> {
        let (signature, steady) = self.look(pair, watch, contact)?;
        (signature == watch.signature).then_some(steady)
    }

    /// The signature, and for how much motion [m] all stays as it is; `None` when phi has another sign at a point.
    pub(super) fn look(&self, pair: &Pair, watch: &Watch, contact: &SurfaceParameters) -> Option<(u64, f64)> {
        let mut scan = Scan::seen(self, pair, View::new(pair, None), f64::INFINITY);
        let offset = contact.rail - contact.wheel;
        let mut steady = MOST_STEADY;
        for point in watch.points.iter().flatten() {
            let (phi, turning) = scan.extreme(&point.place, offset)?;
            if (phi >= 0.0) != point.above {
                return None;
            }
            steady = less(phi.abs() / turning, steady);
        }
        let mut signature = 0;
        let last = self.wheel.stretches.len();
        for run in watch.runs() {
            // A record of another wheel.
            if run.1 > last {
                return None;
            }
            let before = scan.count;
            let (a, b) = scan.part(run, offset);
            let count = (scan.count - before).min(15) as u64;
            signature = signature << BITS | count << 2 | u64::from(a.phi < 0.0) << 1 | u64::from(b.phi < 0.0);
            let holds = |end: &State| end.phi.abs() / scan.turning_at(end);
            steady = less(less(holds(&a), holds(&b)), steady);
        }
        Some((signature, less(scan.certificates.steady, steady)))
    }
}
