//! The grid that a case needs.
//!
//! With E(n) the force extrapolated from n and n/2 cells across the patch, |E(n) - E(n/2)| says how far E(n) may still be off: less
//! than that, but for small n only roughly. So the ladder E(32), E(64), E(128), E(256) is climbed while that distance is large, and between
//! two bounds the next value is mixed in by a smooth step: the force stays a continuous function of the creepages.
//!
//! How many cells a case needs is not seen from its numbers: slender patches (a/b or b/a below 0.2) with much spin are the hard ones,
//! but so is pure spin near its largest force at a/b = 5, and neighbours of both need 32.
//!
//! Own arrangement of Richardson's extrapolation.

use super::patch::{SteadyPatch, extrapolated};
use crate::contact::half_space::influence::{Convolver, Pair};
use crate::contact::half_space::tangential::{Limits, Outcome, Workspace};
use crate::math::smooth_step::smooth_step;

/// A dimensionless case, see [`super::patch`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub a_over_b: f64,
    pub nu: f64,
    pub creepage: [f64; 3],
    pub limits: Limits,
}

/// The solution on one grid.
#[derive(Debug)]
pub(super) struct OnGrid {
    pub patch: SteadyPatch,
    /// Tractions.
    pub p: Vec<Pair>,
    pub outcome: Outcome,
    /// Force in mu N, moment in mu N sqrt(a b).
    pub force: [f64; 3],
}

impl OnGrid {
    /// Starts from the tractions of a grid with half as many cells, if there is one.
    pub(super) fn solve(case: &Case, convolver: &Convolver, coarse: Option<&OnGrid>) -> Self {
        let Case { a_over_b, nu, creepage, limits } = *case;
        let patch = SteadyPatch::new(a_over_b, nu, convolver);
        let mut p = coarse.map_or_else(Vec::new, |coarse| coarse.spread(&patch));
        let (force, outcome) = patch.solve(creepage, &mut p, limits, &mut Workspace::new(convolver));
        OnGrid { patch, p, outcome, force }
    }

    /// Tractions on a grid with twice as many cells: each cell takes over its place's, over the bound.
    fn spread(&self, fine: &SteadyPatch) -> Vec<Pair> {
        let (n, coarse) = (self.patch.convolver.columns, &self.patch.pressure);
        let mut shares = vec![[0.0; 2]; n * n];
        for ((cell, p), bound) in coarse.cells.iter().zip(&self.p).zip(&coarse.values) {
            shares[cell.row * n + cell.column] = p.map(|p| p / bound);
        }
        let fine = &fine.pressure;
        fine.cells.iter().zip(&fine.values).map(|(cell, bound)| shares[cell.row / 2 * n + cell.column / 2].map(|p| p * bound)).collect()
    }
}

/// One value of the ladder.
#[derive(Clone, Debug)]
struct Rung {
    convolver: Convolver,
    /// Distances |E(n) - E(n/2)| in mu N up to which the value is taken alone, and from which only the next one is.
    kept: f64,
    left: f64,
}

/// Grids from coarse to fine.
#[derive(Clone, Debug)]
pub(super) struct Ladder {
    /// What the first rung is extrapolated from and judged by.
    below: [Convolver; 2],
    rungs: [Rung; 4],
}

impl Ladder {
    pub(super) fn new() -> Self {
        let rung = |cells, (kept, left)| Rung { convolver: Convolver::square(cells), kept, left };
        let last = (f64::MAX, f64::INFINITY);
        // Chosen so that the error stays below 0.006 mu N: `exact::tests::hard_grids_over_a_sweep` measures it.
        let rungs = [rung(32, (2.5e-3, 5e-3)), rung(64, (6e-3, 1e-2)), rung(128, (6e-3, 1e-2)), rung(256, last)];
        Ladder { below: [8, 16].map(Convolver::square), rungs }
    }

    /// The finest solution that was needed, the best force (mu N, moment in mu N sqrt(a b)) and the largest residual.
    pub(super) fn climb(&self, case: &Case) -> (OnGrid, [f64; 3], f64) {
        let coarsest = OnGrid::solve(case, &self.below[0], None);
        let mut finest = OnGrid::solve(case, &self.below[1], Some(&coarsest));
        let mut before = extrapolated(finest.force, coarsest.force);
        let mut residual = coarsest.outcome.residual.max(finest.outcome.residual);
        let (mut best, mut open) = ([0.0; 3], 1.0);
        for rung in &self.rungs {
            let next = OnGrid::solve(case, &rung.convolver, Some(&finest));
            residual = residual.max(next.outcome.residual);
            let here = extrapolated(next.force, finest.force);
            let further = open * smooth_step((distance(here, before, case.a_over_b) - rung.kept) / (rung.left - rung.kept))[0];
            best = std::array::from_fn(|k| best[k] + (open - further) * here[k]);
            (finest, before, open) = (next, here, further);
            if open == 0.0 {
                break;
            }
        }
        (finest, best, residual)
    }
}

/// How far two forces are apart, in mu N; a moment counts by the longer semi-axis.
fn distance(a: [f64; 3], b: [f64; 3], a_over_b: f64) -> f64 {
    let length = a_over_b.max(1.0 / a_over_b).sqrt();
    (a[0] - b[0]).hypot(a[1] - b[1]).hypot((a[2] - b[2]) / length)
}
