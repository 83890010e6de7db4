//! The normal problem of a patch, and the tangential one on top of it: pressed once, rolled as often as is asked.

use super::surfaces::{Domain, Sample, sample};
use super::{Motion, PatchCell, PatchSolution, Settings};
use crate::contact::Material;
use crate::contact::half_space::cells::Pressure;
use crate::contact::half_space::influence::{Cell, Convolver, Pair as Components};
use crate::contact::half_space::tangential::{Limits, MOST_STEPS, Tangential, Workspace};
use crate::contact::half_space::{normal, rolling};
use crate::contact::search::algebraic::Pair;
use nalgebra::Vector3;

/// A wheel pressed on a rail in a pose; it may roll in any way.
#[derive(Clone, Debug)]
pub struct Pressed {
    /// Of the wheelset, and its axle's direction.
    pub(super) centre: Vector3<f64>,
    pub(super) axle: Vector3<f64>,
    pub(super) material: Material,
    /// Of the tangential iteration.
    tolerance: f64,
    /// `None` where the surfaces do not overlap.
    pub(super) grids: Option<Grids>,
}

#[derive(Clone, Debug)]
pub(super) struct Grids {
    pub domain: Domain,
    /// 1 where outward is to the left, else -1.
    pub left: f64,
    pub fine: Grid,
    /// With half as many cells each way, for the extrapolation of creep forces.
    pub coarse: Option<Grid>,
}

/// Pressed cells of one grid, row by row from right to left, in each row from the front backward.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    columns: usize,
    rows: usize,
    /// Of a cell, m.
    pub size: [f64; 2],
    pub cells: Vec<Cell>,
    /// Lead and arc length across, left positive, m.
    pub places: Vec<[f64; 2]>,
    pub samples: Vec<Sample>,
    /// Over G.
    pub pressures: Vec<f64>,
}

/// What tractions belong to the cells of a grid.
pub(super) struct Rolled {
    /// Over G.
    pub tractions: Vec<Components>,
    slips: Vec<Components>,
    residual: f64,
}

impl Pressed {
    /// Solves the normal problem; `None` where the iteration was given up.
    pub fn new(pair: &Pair, material: Material, settings: Settings) -> Option<Self> {
        Self::within(Domain::find(pair), pair, material, settings)
    }

    /// The same on a grid that resolves each place at which the wheel presses, and is no coarser than the settings'.
    pub fn resolved(pair: &Pair, material: Material, settings: Settings) -> Option<Self> {
        let domain = Domain::find(pair);
        let settings = domain.as_ref().map_or(settings, |domain| domain.resolving(settings));
        Self::within(domain, pair, material, settings)
    }

    fn within(domain: Option<Domain>, pair: &Pair, material: Material, settings: Settings) -> Option<Self> {
        let Settings { columns, rows, extrapolate, tolerance } = settings;
        let grids = match domain {
            None => None,
            Some(domain) => {
                let grid = |columns, rows| Grid::press(pair, &domain, material.poisson_ratio, [columns, rows]);
                let coarse = if extrapolate { Some(grid(columns / 2, rows / 2)?) } else { None };
                let fine = grid(columns, rows)?;
                Some(Grids { domain, left: pair.rail.side.sign(), fine, coarse })
            }
        };
        Some(Pressed { centre: *pair.centre, axle: pair.axes.column(1).into_owned(), material, tolerance, grids })
    }

    /// Settings whose grid resolves each place at which the wheel presses, and is no coarser than theirs.
    pub fn resolving(&self, settings: Settings) -> Settings {
        self.grids.as_ref().map_or(settings, |grids| grids.domain.resolving(settings))
    }

    /// Rail coordinates between which it is pressed, m.
    pub fn on_rail(&self) -> Option<[f64; 2]> {
        let Grids { domain, left, fine, .. } = self.grids.as_ref()?;
        let arcs = fine.places.iter().flat_map(|place| [place[1] - 0.5 * fine.size[1], place[1] + 0.5 * fine.size[1]]);
        let etas = arcs.map(|arc| domain.eta(arc * left));
        etas.fold(None, |reach: Option<[f64; 2]>, eta| Some(reach.map_or([eta; 2], |[from, to]| [from.min(eta), to.max(eta)])))
    }

    /// The patch without tractions.
    pub fn at_rest(&self) -> PatchSolution {
        self.grids.as_ref().map(|grids| self.solution(grids, &grids.fine, &grids.fine.at_rest(), 0.0)).unwrap_or_default()
    }

    /// The patch that rolls; without friction or speed there are no tractions.
    pub fn roll(&self, motion: &Motion, friction: f64) -> PatchSolution {
        let Some(grids) = &self.grids else { return PatchSolution::default() };
        let on = |grid: &Grid| self.solution(grids, grid, &grid.roll(self, motion, &vec![friction; grid.cells.len()]), friction);
        let mut fine = on(&grids.fine);
        if let Some(coarse) = grids.coarse.as_ref().map(on) {
            let force = fine.creep_force * 2.0 - coarse.creep_force;
            // The moment about one and the same place.
            let shifted = coarse.creep_moment + (coarse.centre - fine.centre).cross(&coarse.creep_force);
            fine.creep_moment = fine.creep_moment * 2.0 - shifted;
            let size = force.norm();
            fine.creep_force = if size > 0.0 { force * (friction * fine.load / size).min(1.0) } else { force };
            fine.residual = fine.residual.max(coarse.residual);
        }
        fine
    }

    fn solution(&self, grids: &Grids, grid: &Grid, rolled: &Rolled, friction: f64) -> PatchSolution {
        let shear_modulus = self.material.shear_modulus();
        let cells = grid.samples.iter().enumerate().map(|(k, at)| PatchCell {
            place: [grid.places[k][0] - grids.domain.deepest.0, grid.places[k][1]],
            point: at.between(),
            normal: at.normal,
            pressure: shear_modulus * grid.pressures[k],
            traction: rolled.tractions[k].map(|traction| shear_modulus * traction),
            slip: rolled.slips[k],
            sticks: rolled.tractions[k][0].hypot(rolled.tractions[k][1]) < friction * grid.pressures[k] * (1.0 - 1e-9),
        });
        let forward: Vec<Vector3<f64>> = grid.samples.iter().map(|sample| sample.forward).collect();
        let cells = cells.collect();
        PatchSolution {
            cells,
            cell_size: grid.size,
            overlap: grids.domain.deepest.2,
            residual: rolled.residual,
            ..PatchSolution::default()
        }
        .summed(&forward)
    }

    /// Velocity of the wheel's material past the rail, in the rail's tangent plane, m/s.
    fn rigid_slip(&self, at: &Sample, motion: &Motion) -> Vector3<f64> {
        let arm = at.on_wheel() - self.centre;
        let spin = self.axle * motion.rotation.dot(&self.axle);
        let around = spin.cross(&arm);
        // The smallest rotation that takes the wheel's normal to the rail's.
        let axis = at.wheel_normal.cross(&at.normal);
        let turned = around + axis.cross(&around) + axis.cross(&axis.cross(&around)) / (1.0 + at.wheel_normal.dot(&at.normal));
        turned + motion.velocity + (motion.rotation - spin).cross(&arm)
    }
}

impl Grid {
    fn press(pair: &Pair, domain: &Domain, nu: f64, [columns, rows]: [usize; 2]) -> Option<Grid> {
        let left = pair.rail.side.sign();
        let size = [(domain.lead[1] - domain.lead[0]) / columns as f64, (domain.arc[1] - domain.arc[0]) / rows as f64];
        let right_edge = if left > 0.0 { domain.arc[0] } else { -domain.arc[1] };
        let middle = |cell: &Cell| [domain.lead[0] + size[0] * (cell.column as f64 + 0.5), right_edge + size[1] * (cell.row as f64 + 0.5)];
        let cells: Vec<Cell> = (0..rows).flat_map(|row| (0..columns).rev().map(move |column| Cell { column, row })).collect();
        let at = |cell: &Cell| sample(pair, middle(cell)[0], domain.eta(middle(cell)[1] * left));
        let samples: Vec<Sample> = cells.iter().map(at).collect();
        let overlaps: Vec<f64> = samples.iter().map(|sample| sample.overlap).collect();
        let convolver = Convolver::new(columns, rows);
        let pressures = normal::pressures(&cells, &overlaps, &normal::kernel(size, nu, &convolver), &convolver)?;
        let pressed: Vec<usize> = (0..cells.len()).filter(|k| pressures[*k] > 0.0).collect();
        Some(Grid {
            columns,
            rows,
            size,
            cells: pressed.iter().map(|k| cells[*k]).collect(),
            places: pressed.iter().map(|k| middle(&cells[*k])).collect(),
            samples: pressed.iter().map(|k| samples[*k]).collect(),
            pressures: pressed.iter().map(|k| pressures[*k]).collect(),
        })
    }

    fn at_rest(&self) -> Rolled {
        let none = || vec![[0.0; 2]; self.cells.len()];
        Rolled { tractions: none(), slips: none(), residual: 0.0 }
    }

    /// With the friction of each cell.
    pub(super) fn roll(&self, wheel: &Pressed, motion: &Motion, friction: &[f64]) -> Rolled {
        let mut rolled = self.at_rest();
        if motion.speed == 0.0 || !friction.iter().any(|friction| *friction > 0.0) {
            return rolled;
        }
        // Rolling backward everything turns by 180 degrees about the normal: the leading edge comes first.
        let ahead = if motion.speed < 0.0 { -1.0 } else { 1.0 };
        let backward = ahead < 0.0;
        let order: Vec<usize> = if backward { (0..self.cells.len()).rev().collect() } else { (0..self.cells.len()).collect() };
        let turned = |k: &usize| {
            let Cell { column, row } = self.cells[*k];
            if backward { Cell { column: self.columns - 1 - column, row: self.rows - 1 - row } } else { Cell { column, row } }
        };
        let rigid = |k: &usize| {
            let at = &self.samples[*k];
            let slip = wheel.rigid_slip(at, motion) / motion.speed.abs();
            [slip.dot(&at.forward) * ahead, slip.dot(&at.normal.cross(&at.forward)) * ahead]
        };
        let bound = Pressure {
            size: self.size,
            cells: order.iter().map(turned).collect(),
            places: order.iter().map(|k| self.places[*k].map(|place| ahead * place)).collect(),
            values: order.iter().map(|k| friction[*k] * self.pressures[*k]).collect(),
        };
        let rigid: Vec<Components> = order.iter().map(rigid).collect();
        let convolver = Convolver::new(self.columns, self.rows);
        let kernel = rolling::kernel(self.size, wheel.material.poisson_ratio, &convolver);
        let problem = Tangential { pressure: &bound, convolver: &convolver, kernel: &kernel };
        let (mut workspace, limits) = (Workspace::new(&convolver), Limits { tolerance: wheel.tolerance, most_steps: MOST_STEPS });
        let mut tractions = vec![[0.0; 2]; order.len()];
        rolled.residual = problem.solve(&rigid, &mut tractions, limits, &mut workspace).residual;
        let slips = problem.slip_of(&rigid, &tractions, &mut workspace);
        for (n, k) in order.into_iter().enumerate() {
            rolled.tractions[k] = tractions[n].map(|traction| ahead * traction);
            rolled.slips[k] = slips[n].map(|slip| ahead * slip);
        }
        rolled
    }
}
