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
//! Creep forces err in proportion to the cells, by 3 % of mu N with 32: they are extrapolated from two grids. Places that are small beside the way between
//! them get 20 cells each way of their own ([`depth_under_load`]), up to 128 along and 256 across the box of all.

mod choice;
mod lowering;
mod places;
mod pressed;
mod surfaces;
#[cfg(test)]
mod tests;

pub use choice::{AUTO, PatchLaw, REGISTRY, parse};
pub use lowering::depth_under_load;
pub use places::{FrictionOf, Place, PlaceCreep};
pub use pressed::Pressed;

use nalgebra::Vector3;

/// Settings of the numerical solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Cells along e1 over the box within which the undeformed surfaces overlap.
    pub columns: usize,
    /// ... and across.
    pub rows: usize,
    /// Are creep forces extrapolated from this grid (of even numbers) and one with half as many cells each way?
    pub extrapolate: bool,
    /// Residual of the friction law over the bound (root mean square) at which the tangential iteration stops.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { columns: 32, rows: 32, extrapolate: true, tolerance: 1e-6 }
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
        places::rows(self.cells.iter().map(|cell| cell.place[1]), self.cell_size[1]).len()
    }
}

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
