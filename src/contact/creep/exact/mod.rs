//! Kalker's exact theory of Hertzian rolling contact: half-spaces, Coulomb friction, tractions on a grid.
//!
//! Variational theory for wheel and rail of the same material with an elliptic Hertzian patch (semi-axes a along
//! e1, b along e2). Both bodies are elastic half-spaces; tractions are constant in each cell of an n x n grid over
//! the ellipse; normal and tangential problem are uncoupled; friction is Coulomb's with one coefficient. Sign
//! conventions as everywhere: creepages of the wheel relative to the rail over V, force on the wheel, so positive
//! creepage gives negative force; rolling along +e1, spin about the rail's outward normal.
//!
//! - `half_space`: displacements of a loaded rectangle, sums by FFT, stick and slip
//! - `normal`: cells in contact and Hertz's pressure, the bound of the tractions
//! - `patch`: steady rolling, dimensionless
//! - `grids`: the grid that a case needs
//! - `transient`: step by step, with rolling or without
//!
//! Size of the error: proportional to the cell size, so the force of steady rolling is extrapolated from a grid and one with half
//! as many cells, `2 F(n) - F(n/2)`, and cut back to mu N where that overshoots. By default n is chosen by the case, 32 to 256
//! (`grids`): see there for the error that is left. A given grid is used as it is. Slopes at zero creepage
//! against a spectral solution (tests/reference/adhesion.py), 48 and 24 cells: 0.12 % (c11, c22), 0.27 % (c23), 0.65 % (c33); c33
//! of long patches needs them: with 32 it is 5 % off at a/b = 5, 23 % at a/b = 10. The theory itself
//! leaves out the bodies' real shape (half-spaces), roughness, a third layer and falling friction.
//!
//! This is the slow reference: a call solves some thousand coupled equations (10 ms to seconds) and allocates its memory.
//!
//! Source: J.J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, Kluwer (1990), chapters 3 and 4; the
//! numbers are checked against the open program CONTACT.

mod grids;

pub(crate) mod normal;
pub(crate) mod patch;

#[cfg(test)]
mod tests;
mod transient;

pub use transient::Increment;

use super::{Build, CreepLaw, RollingContact};
use crate::contact::creepage::CreepForce;
use crate::contact::half_space::cells::Pressure;
use crate::contact::half_space::influence::{Convolver, Pair};
use crate::contact::half_space::tangential::{Limits, MOST_STEPS, Outcome, Workspace};
use crate::contact::{Material, Patch};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use grids::{Case, Ladder, OnGrid};
use patch::{extrapolated, resultant};
use std::f64::consts::PI;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "exact",
    summary: "Kalker's exact theory: half-space, Coulomb friction, tractions on a grid chosen by the case; slow, the reference",
    reference: "Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, Kluwer (1990)",
    parse,
};

/// Settings of the numerical solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Cells across each axis of the ellipse; `None`: chosen by the case where the force is extrapolated, else 32.
    pub grid: Option<usize>,
    /// Is the force extrapolated from this grid and one with half as many cells?
    pub extrapolate: bool,
    /// Residual of the friction law over the bound (root mean square) at which the iteration stops.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { grid: None, extrapolate: true, tolerance: 1e-6 }
    }
}

/// The exact theory for one material.
#[derive(Debug, Clone)]
pub struct Exact {
    shear_modulus: f64,
    nu: f64,
    settings: Settings,
    /// Of a given grid, of transients and of a force that is not extrapolated.
    convolver: Convolver,
    half: Option<Convolver>,
    ladder: Option<Ladder>,
}

/// Cells across each axis where none are given and none are chosen by the case.
const GRID: usize = 32;

/// One cell of the solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellState {
    /// Middle of the cell along e1, e2 from the patch's middle, m.
    pub place: [f64; 2],
    /// Traction on the wheel along e1, e2, Pa.
    pub traction: [f64; 2],
    /// Friction bound mu p, Pa.
    pub bound: f64,
    /// Slip of the wheel relative to the rail along e1, e2: over V [-] when steady, of the step [m] when transient.
    pub slip: [f64; 2],
    /// Does the cell stick?
    pub sticks: bool,
}

/// Tractions and what they sum to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solution {
    /// Best value: extrapolated, if the settings say so (steady rolling only), else that of the grid.
    pub force: CreepForce,
    /// Sum of the tractions below.
    pub force_on_grid: CreepForce,
    /// Cells in contact, strip by strip from right to left, in each strip from the leading edge backward.
    pub cells: Vec<CellState>,
    /// Area of a cell, m^2.
    pub cell_area: f64,
    /// Newton steps.
    pub iterations: usize,
    /// Products with the influence matrix, the measure of the effort.
    pub products: usize,
    /// Residual of the friction law over the bound; above the setting's tolerance the iteration was given up, and the
    /// force is approximate (yet within the bound).
    pub residual: f64,
}

impl Solution {
    /// Share of the cells in contact that stick.
    pub fn sticking_share(&self) -> f64 {
        self.cells.iter().filter(|cell| cell.sticks).count() as f64 / self.cells.len().max(1) as f64
    }
}

/// What turns dimensionless numbers into SI.
struct Scale {
    a_over_b: f64,
    /// sqrt(a b), m.
    length: f64,
    /// mu p0, Pa.
    stress: f64,
    /// G / (mu p0).
    creep: f64,
    /// mu N, N.
    bound: f64,
}

impl Scale {
    fn force(&self, [x, y, spin]: [f64; 3]) -> CreepForce {
        CreepForce { longitudinal: x * self.bound, lateral: y * self.bound, spin_moment: spin * self.bound * self.length }
    }
}

impl Exact {
    /// # Panics
    /// If `settings.grid` is below 4, or odd where the force is to be extrapolated.
    pub fn new(material: Material, settings: Settings) -> Self {
        let grid = settings.grid.unwrap_or(GRID);
        assert!(grid >= 4 && !(settings.extrapolate && grid % 2 == 1), "no such grid: {settings:?}");
        let half = (settings.extrapolate && settings.grid.is_some()).then(|| Convolver::square(grid / 2));
        let ladder = (settings.extrapolate && settings.grid.is_none()).then(Ladder::new);
        let (shear_modulus, nu) = (material.shear_modulus(), material.poisson_ratio);
        Exact { shear_modulus, nu, settings, convolver: Convolver::square(grid), half, ladder }
    }

    fn limits(&self) -> Limits {
        Limits { tolerance: self.settings.tolerance, most_steps: MOST_STEPS }
    }

    fn scale(&self, contact: &RollingContact) -> Option<Scale> {
        let (Patch { a, b }, bound) = (contact.patch, contact.bound());
        if !(a > 0.0 && b > 0.0 && bound > 0.0) {
            return None;
        }
        let stress = 1.5 * bound / (PI * a * b);
        Some(Scale { a_over_b: a / b, length: (a * b).sqrt(), stress, creep: self.shear_modulus / stress, bound })
    }

    /// Steady rolling. Zero where the friction bound is zero.
    pub fn solve(&self, contact: &RollingContact) -> Solution {
        let Some(scale) = self.scale(contact) else { return Solution::default() };
        let creepage = contact.creepage;
        let normalised = [creepage.longitudinal, creepage.lateral, creepage.spin * scale.length].map(|c| c * scale.creep);
        let case = Case { a_over_b: scale.a_over_b, nu: self.nu, creepage: normalised, limits: self.limits() };
        let (finest, best, residual) = match (&self.ladder, &self.half) {
            (Some(ladder), _) => ladder.climb(&case),
            (None, half) => {
                let coarse = half.as_ref().map(|half| OnGrid::solve(&case, half, None));
                let fine = OnGrid::solve(&case, &self.convolver, coarse.as_ref());
                let best = coarse.as_ref().map_or(fine.force, |coarse| extrapolated(fine.force, coarse.force));
                let residual = coarse.map_or(0.0, |coarse| coarse.outcome.residual);
                (fine, best, residual)
            }
        };
        let OnGrid { patch, p, outcome, .. } = &finest;
        let slip = patch.tangential().slip_of(&patch.rigid(normalised), p, &mut Workspace::new(&patch.convolver));
        let slip: Vec<Pair> = slip.iter().map(|s| s.map(|s| s / scale.creep)).collect();
        let mut solution = self.solution(&scale, &patch.pressure, p, &slip, *outcome);
        solution.force = scale.force(best);
        solution.residual = solution.residual.max(residual);
        solution
    }

    fn solution(&self, scale: &Scale, pressure: &Pressure, p: &[Pair], slip: &[Pair], outcome: Outcome) -> Solution {
        let force = scale.force(resultant(pressure, p));
        let cell = |k: usize| CellState {
            place: pressure.places[k].map(|x| x * scale.length),
            traction: p[k].map(|p| p * scale.stress),
            bound: pressure.values[k] * scale.stress,
            slip: slip[k],
            sticks: p[k][0].hypot(p[k][1]) < pressure.values[k] * (1.0 - 1e-9),
        };
        Solution {
            force,
            force_on_grid: force,
            cells: (0..p.len()).map(cell).collect(),
            cell_area: pressure.size[0] * pressure.size[1] * scale.length * scale.length,
            iterations: outcome.iterations,
            products: outcome.products,
            residual: outcome.residual,
        }
    }
}

impl CreepLaw for Exact {
    /// Allocates, unlike the other laws: see the module.
    fn force(&self, contact: &RollingContact) -> CreepForce {
        self.solve(contact).force
    }

    fn on_any_patch(&self) -> Option<Settings> {
        Some(self.settings)
    }

    fn describe(&self) -> String {
        match self.settings.grid {
            // Measured: the third power of the cells across, between 20 and 90.
            Some(n) => format!(" on {n} x {n} cells (about {:.1e} s a call, a start asks hundreds of times)", 3e-6 * (n as f64).powi(3)),
            None => " on a grid chosen by the case (10 ms to seconds a call)".into(),
        }
    }
}

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let defaults = Settings::default();
    let grid = match section.optional("grid", Dimension::None)? {
        None => None,
        Some(grid) if grid % 2.0 == 0.0 && (4.0..=256.0).contains(&grid) => Some(grid as usize),
        Some(grid) => return Err(section.error("grid", format!("found {grid:?}, expected an even number of cells from 4 to 256"))),
    };
    let extrapolate = section.flag_or("extrapolate", defaults.extrapolate)?;
    let tolerance = section.number_or("tolerance", Dimension::None, defaults.tolerance)?;
    if !(1e-10..=1e-2).contains(&tolerance) {
        return Err(section.error("tolerance", format!("found {tolerance:?}, expected a number from 1e-10 to 1e-2")));
    }
    let settings = Settings { grid, extrapolate, tolerance };
    Ok(Arc::new(move |material| Box::new(Exact::new(material, settings))))
}
