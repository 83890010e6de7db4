//! Makes the table: many solutions of the exact theory.

use super::coordinates::{Triple, scales, size, unbounded};
use super::layout::{Layout, Slopes};
use super::table::pack;
use crate::contact::creep::exact::patch::{SteadyPatch, extrapolated};
use crate::contact::creep::kalker::KalkerTable;
use crate::contact::half_space::influence::Convolver;
use crate::contact::half_space::tangential::{Limits, MOST_STEPS, Workspace};
use rayon::prelude::*;

const TOLERANCE: f64 = 1e-6;

/// The exact theory of one shape, extrapolated from a grid and one with half as many cells.
#[derive(Debug)]
pub(crate) struct Shape {
    fine: SteadyPatch,
    coarse: SteadyPatch,
    /// (X, Y, Z) over dimensionless creepages.
    scales: Triple,
}

/// Memory and starting points of a sequence of solutions.
pub(crate) struct Solver<'a> {
    shape: &'a Shape,
    workspaces: [Workspace; 2],
    tractions: [Vec<[f64; 2]>; 2],
}

impl Shape {
    pub(crate) fn new(a_over_b: f64, nu: f64, cells: usize) -> Self {
        let [fine, coarse] = [cells, cells / 2].map(|n| SteadyPatch::new(a_over_b, nu, &Convolver::square(n)));
        Shape { fine, coarse, scales: scales(KalkerTable::new(nu).at(a_over_b), a_over_b) }
    }

    pub(crate) fn solver(&self) -> Solver<'_> {
        let workspaces = [&self.fine, &self.coarse].map(|patch| Workspace::new(&patch.convolver));
        Solver { shape: self, workspaces, tractions: Default::default() }
    }

    /// From small creepages, at which almost every cell sticks. Twice the cells of the rest of the table.
    fn slopes(a_over_b: f64, layout: &Layout) -> Slopes {
        let shape = Shape::new(a_over_b, layout.nu, 2 * layout.cells);
        let mut solver = shape.solver();
        let small = 1e-6;
        let mut slope = |v: Triple| solver.force(v).map(|force| force / small);
        let [x, y, z] = [slope([small, 0.0, 0.0]), slope([0.0, small, 0.0]), slope([0.0, 0.0, small])];
        Slopes([-x[0], -y[1], -z[1], y[2], -z[2]])
    }
}

impl Solver<'_> {
    /// Force at (X, Y, Z), starting from the last solution.
    pub(crate) fn force(&mut self, v: Triple) -> Triple {
        let creepage = std::array::from_fn(|k| v[k] / self.shape.scales[k]);
        let limits = Limits { tolerance: TOLERANCE, most_steps: MOST_STEPS };
        let patches = [&self.shape.fine, &self.shape.coarse];
        let [fine, coarse] = std::array::from_fn(|g| patches[g].solve(creepage, &mut self.tractions[g], limits, &mut self.workspaces[g]).0);
        extrapolated(fine, coarse)
    }

    /// K at `u`; beyond the surface of the ball as the straight continuation of its course along the radius.
    pub(crate) fn correction(&mut self, u: Triple, slopes: &Slopes) -> Triple {
        let radius = size(u);
        if radius == 0.0 {
            return [0.0; 3];
        }
        let mut at = |radius_here: f64| -> Triple {
            let here = u.map(|u| u * radius_here / radius);
            let (force, linear) = (self.force(unbounded(here)), slopes.force(here));
            std::array::from_fn(|c| (force[c] - linear[c]) / radius_here)
        };
        if radius <= 1.0 {
            return at(radius);
        }
        let (surface, inside) = (at(1.0), at(2.0 - radius));
        std::array::from_fn(|c| 2.0 * surface[c] - inside[c])
    }
}

/// Computes and packs a table. `done` hears how many of how many parts are ready. The result does not depend on
/// the number of threads: each row of the lattice is one sequence of solutions.
pub fn generate(layout: Layout, done: &(dyn Fn(usize, usize) + Sync)) -> Vec<u8> {
    let points = layout.points();
    let row = layout.steps + 2;
    let ratios: Vec<f64> = (0..layout.shapes).map(|s| layout.ratio(s)).collect();
    let slopes: Vec<Slopes> = ratios.par_iter().map(|ratio| Shape::slopes(*ratio, &layout)).collect();
    let shapes: Vec<Shape> = ratios.iter().map(|ratio| Shape::new(*ratio, layout.nu, layout.cells)).collect();
    let rows = layout.shapes * points / row;
    let ready = std::sync::atomic::AtomicUsize::new(0);
    let values: Vec<Triple> = (0..rows)
        .into_par_iter()
        .flat_map_iter(|part| {
            let (shape, first) = (part * row / points, part * row % points);
            let mut solver = shapes[shape].solver();
            let values: Vec<Triple> = (first..first + row)
                .map(|index| {
                    let u = layout.place(index);
                    if layout.used(u) { solver.correction(u, &slopes[shape]) } else { [0.0; 3] }
                })
                .collect();
            done(ready.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, rows);
            values
        })
        .collect();
    pack(layout, &slopes, &values)
}
