//! The patch that really forms between a wheel and a rail: half-space contact of the two real surfaces on a grid.
//!
//! The pose of the undeformed surfaces says by how much they overlap ([`surfaces`]); the elastic half-spaces must yield by that where they press
//! ([`crate::contact::half_space::normal`]), and by no more where they do not. Pressure, patches that join and part, load and its centre follow, for any profiles. Then
//! Kalker's tangential problem is solved on the same cells, with the slip that each cell has, which on a patch that bends around a gauge corner
//! is no constant creepage with a constant spin. The undeformed wheel's material moves with `v + w x r`. The part of the spin about the axle runs along
//! the wheel's surface; where that is pressed flat it runs along the rail's, at the same speed: it is turned from the wheel's tangent plane into
//! the rail's. (Projected instead, x ahead of the deepest place it would lose x^2 / 2 R^2: 8e-5 at 6 mm, 5 % of a creepage of 1.5e-3.) What pressure
//! does to rolling radii is the same strain in both bodies and leaves no slip.
//!
//! *Frame of a cell.* e1 forward along the rail, the rail's normal n(y) out of it, e2 = n x e1 to the left, along the rail's section; y: arc length.
//! *What it leaves out.* Influence numbers are those of flat half-spaces over arc lengths: where the section turns by 90 degrees within the
//! patch, or where a patch is wider than half the radius of the bodies, they are no longer right (compare docs/contact_geometry.md). Wheel and rail
//! of the same material; Coulomb friction with one coefficient.
//!
//! Error of the grid: the load of a Hertzian patch is 0.05 % off with 32 cells across the box of the overlap (23 across the patch), and 0.01 % with 64.
//! Creep forces err in proportion to the cells, by 3 % of mu N with 32: they are extrapolated from two grids.

mod surfaces;
#[cfg(test)]
mod tests;

use crate::contact::Material;
use crate::contact::half_space::cells::Pressure;
use crate::contact::half_space::influence::{Cell, Convolver, Pair as Components};
use crate::contact::half_space::tangential::{Limits, MOST_STEPS, Tangential, Workspace};
use crate::contact::half_space::{normal, rolling};
use crate::contact::search::algebraic::Pair;
use nalgebra::Vector3;
use surfaces::{Domain, Sample, sample};

/// Settings of the numerical solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Cells along e1 over the box within which the undeformed surfaces overlap.
    pub columns: usize,
    /// ... and across.
    pub rows: usize,
    /// Are creep forces extrapolated from this grid (of even numbers) and one with half as many cells each way?
    pub extrapolate: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { columns: 32, rows: 32, extrapolate: true }
    }
}

/// How the wheel's material moves: the wheelset's velocity at its centre [m/s] and angular velocity [rad/s], in the frame of the pose, and the
/// travelling speed [m/s], with the sign of its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    pub velocity: Vector3<f64>,
    pub rotation: Vector3<f64>,
    pub speed: f64,
}

/// One cell in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchCell {
    /// Along e1 from the deepest place of the undeformed surfaces, and across along the rail's section, left positive, m.
    pub place: [f64; 2],
    /// Where the surfaces meet: half way between the undeformed ones, since both bodies yield alike; and the rail's normal.
    pub point: Vector3<f64>,
    pub normal: Vector3<f64>,
    /// Pa.
    pub pressure: f64,
    /// On the wheel along e1, e2, Pa.
    pub traction: [f64; 2],
    /// Of the wheel past the rail along e1, e2, over V, -.
    pub slip: [f64; 2],
    pub sticks: bool,
}

/// A solved patch; all forces act on the wheel.
#[derive(Clone, Debug, Default)]
pub struct PatchSolution {
    /// Cells in contact, strip by strip from right to left, in each strip from the leading edge backward.
    pub cells: Vec<PatchCell>,
    /// Of a cell along e1, e2, m.
    pub cell_size: [f64; 2],
    /// Largest overlap of the undeformed surfaces, m.
    pub overlap: f64,
    /// Sum of pressures, N.
    pub load: f64,
    /// The same with their directions: force on the wheel, N.
    pub pressing: Vector3<f64>,
    /// Where it acts: mean of the places by pressure, m.
    pub centre: Vector3<f64>,
    /// Of the tractions: force [N] and moment about the centre [N m].
    pub creep_force: Vector3<f64>,
    pub creep_moment: Vector3<f64>,
    /// Residual of the friction law over the bound.
    pub residual: f64,
}

impl PatchSolution {
    /// m^2.
    pub fn area(&self) -> f64 {
        self.cells.len() as f64 * self.cell_size[0] * self.cell_size[1]
    }

    /// Pa.
    pub fn highest_pressure(&self) -> f64 {
        self.cells.iter().map(|cell| cell.pressure).fold(0.0, f64::max)
    }

    /// Of the cells in contact.
    pub fn sticking_share(&self) -> f64 {
        self.cells.iter().filter(|cell| cell.sticks).count() as f64 / self.cells.len().max(1) as f64
    }

    /// Patches that do not touch each other.
    pub fn parts(&self) -> usize {
        let mut rows: Vec<f64> = self.cells.iter().map(|cell| cell.place[1]).collect();
        rows.dedup();
        rows.windows(2).filter(|pair| pair[1] - pair[0] > 1.5 * self.cell_size[1]).count() + usize::from(!rows.is_empty())
    }
}

/// Solves the patch of a wheel and a rail in a pose; empty where the surfaces do not overlap, `None` where the iteration was given up.
/// Without a `motion` there are no tractions.
pub fn solve(pair: &Pair, material: Material, friction: f64, motion: Option<&Motion>, settings: Settings) -> Option<PatchSolution> {
    let Some(domain) = Domain::find(pair) else { return Some(PatchSolution::default()) };
    let Settings { columns, rows, extrapolate } = settings;
    let mut fine = on_grid(pair, &domain, (material, friction), motion, [columns, rows])?;
    if extrapolate && motion.is_some() {
        let coarse = on_grid(pair, &domain, (material, friction), motion, [columns / 2, rows / 2])?;
        let force = fine.creep_force * 2.0 - coarse.creep_force;
        // The moment about one and the same place.
        let shifted = coarse.creep_moment + (coarse.centre - fine.centre).cross(&coarse.creep_force);
        fine.creep_moment = fine.creep_moment * 2.0 - shifted;
        fine.creep_force = force * (friction * fine.load / force.norm()).min(1.0);
        fine.residual = fine.residual.max(coarse.residual);
    }
    Some(fine)
}

/// The same on one grid.
fn on_grid(
    pair: &Pair,
    domain: &Domain,
    (material, friction): (Material, f64),
    motion: Option<&Motion>,
    [columns, rows]: [usize; 2],
) -> Option<PatchSolution> {
    let (shear_modulus, nu) = (material.shear_modulus(), material.poisson_ratio);
    let left = pair.rail.side.sign();
    let size = [(domain.lead[1] - domain.lead[0]) / columns as f64, (domain.arc[1] - domain.arc[0]) / rows as f64];
    // Rolling backward everything turns by 180 degrees about the normal: the leading edge comes first.
    let ahead = if motion.is_some_and(|motion| motion.speed < 0.0) { -1.0 } else { 1.0 };
    let edge = if left * ahead > 0.0 { domain.arc[0] } else { -domain.arc[1] };
    let begin = if ahead > 0.0 { domain.lead[0] } else { -domain.lead[1] };
    let middle = |cell: &Cell| [begin + size[0] * (cell.column as f64 + 0.5), edge + size[1] * (cell.row as f64 + 0.5)];
    let cells: Vec<Cell> = (0..rows).flat_map(|row| (0..columns).rev().map(move |column| Cell { column, row })).collect();
    let samples: Vec<_> = cells
        .iter()
        .map(|cell| {
            let [x, y] = middle(cell).map(|place| place * ahead);
            sample(pair, x, domain.eta(y * left))
        })
        .collect();
    let overlaps: Vec<f64> = samples.iter().map(|sample| sample.overlap).collect();
    let convolver = Convolver::new(columns, rows);
    let pressures = normal::pressures(&cells, &overlaps, &normal::kernel(size, nu, &convolver), &convolver)?;

    let pressed: Vec<usize> = (0..cells.len()).filter(|k| pressures[*k] > 0.0).collect();
    let bound = Pressure {
        size,
        cells: pressed.iter().map(|k| cells[*k]).collect(),
        places: pressed.iter().map(|k| middle(&cells[*k])).collect(),
        values: pressed.iter().map(|k| friction * pressures[*k]).collect(),
    };
    let mut tractions: Vec<Components> = vec![[0.0; 2]; pressed.len()];
    let (mut slips, mut residual) = (tractions.clone(), 0.0);
    if let Some(motion) = motion.filter(|motion| motion.speed != 0.0 && friction > 0.0 && !pressed.is_empty()) {
        let rigid: Vec<Components> = pressed
            .iter()
            .map(|k| {
                let at = &samples[*k];
                let slip = rigid_slip(pair, at, motion) / motion.speed.abs();
                [slip.dot(&at.forward) * ahead, slip.dot(&at.normal.cross(&at.forward)) * ahead]
            })
            .collect();
        let kernel = rolling::kernel(size, nu, &convolver);
        let problem = Tangential { pressure: &bound, convolver: &convolver, kernel: &kernel };
        let (mut workspace, limits) = (Workspace::new(&convolver), Limits { tolerance: TOLERANCE, most_steps: MOST_STEPS });
        residual = problem.solve(&rigid, &mut tractions, limits, &mut workspace).residual;
        slips = problem.slip_of(&rigid, &tractions, &mut workspace);
    }
    let found = pressed.iter().enumerate().map(|(n, k)| {
        let at = &samples[*k];
        PatchCell {
            place: [ahead * bound.places[n][0] - domain.deepest.0, ahead * bound.places[n][1]],
            point: at.between(),
            normal: at.normal,
            pressure: shear_modulus * pressures[*k],
            traction: tractions[n].map(|traction| ahead * shear_modulus * traction),
            slip: slips[n].map(|slip| ahead * slip),
            sticks: tractions[n][0].hypot(tractions[n][1]) < bound.values[n] * (1.0 - 1e-9),
        }
    });
    let forward: Vec<Vector3<f64>> = pressed.iter().map(|k| samples[*k].forward).collect();
    Some(
        PatchSolution { cells: found.collect(), cell_size: size, overlap: domain.deepest.2, residual, ..PatchSolution::default() }
            .summed(&forward),
    )
}

/// Velocity of the wheel's material past the rail, in the rail's tangent plane, m/s.
fn rigid_slip(pair: &Pair, at: &Sample, motion: &Motion) -> Vector3<f64> {
    let arm = at.on_wheel() - pair.centre;
    let axle = pair.axes.column(1);
    let spin = axle * motion.rotation.dot(&axle);
    let around = spin.cross(&arm);
    // The smallest rotation that takes the wheel's normal to the rail's.
    let axis = at.wheel_normal.cross(&at.normal);
    let turned = around + axis.cross(&around) + axis.cross(&axis.cross(&around)) / (1.0 + at.wheel_normal.dot(&at.normal));
    turned + motion.velocity + (motion.rotation - spin).cross(&arm)
}

/// Residual of the friction law over the bound (root mean square) at which the tangential iteration stops.
const TOLERANCE: f64 = 1e-6;

impl PatchSolution {
    /// With the sums over its cells, whose e1 are given.
    fn summed(mut self, forward: &[Vector3<f64>]) -> PatchSolution {
        let area = self.cell_size[0] * self.cell_size[1];
        for cell in &self.cells {
            let load = cell.pressure * area;
            self.load += load;
            self.pressing += cell.normal * load;
            self.centre += cell.point * load;
        }
        if self.load > 0.0 {
            self.centre /= self.load;
        }
        for (cell, e1) in self.cells.iter().zip(forward) {
            let [x, y] = cell.traction;
            let force = (e1 * x + cell.normal.cross(e1) * y) * area;
            self.creep_force += force;
            self.creep_moment += (cell.point - self.centre).cross(&force);
        }
        self
    }
}

/// By how much, m, the wheel must be lowered from the pose of `pair` until its normal pressures carry a vertical load [N].
///
/// `None` where no such depth is found within 5 mm.
pub fn depth_under_load(pair: &Pair, load: f64, material: Material, settings: Settings) -> Option<f64> {
    const DEEPEST: f64 = 5e-3;
    const CARRIED: f64 = 1e-7;
    let missing = |depth: f64| {
        let centre = pair.centre - Vector3::z() * depth;
        let patch = solve(&Pair { centre: &centre, ..*pair }, material, 0.0, None, settings)?;
        // Loads grow about as depth^1.5.
        Some((patch.pressing.z.max(0.0) / load).powf(2.0 / 3.0) - 1.0)
    };
    let (mut low, mut high) = ((0.0, -1.0), (5e-5, missing(5e-5)?));
    while high.1 < 0.0 {
        if high.0 > DEEPEST {
            return None;
        }
        low = high;
        high = (2.0 * high.0, missing(2.0 * high.0)?);
    }
    // False position with halved weights (Illinois): the ends enclose the depth.
    for _ in 0..60 {
        let depth = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        let found = missing(depth)?;
        if found.abs() < CARRIED || !(depth > low.0 && depth < high.0) {
            return Some(depth);
        }
        if found < 0.0 {
            (low, high.1) = ((depth, found), 0.5 * high.1);
        } else {
            (high, low.1) = ((depth, found), 0.5 * low.1);
        }
    }
    Some(0.5 * (low.0 + high.0))
}
