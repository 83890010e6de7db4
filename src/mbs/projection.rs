//! Back onto the constraints: integration of accelerations lets positions and velocities drift off them.
//!
//! Positions: Newton's method with the mass-weighted smallest change, `q += -M^-1 J^T S^-1 phi`, until all |phi| are
//! below the tolerance. Velocities: `v += -M^-1 J^T S^-1 phi'`, which is exact in one go because phi' is linear in
//! v. Imposed coordinates do not move. Rows of contacts take part: a callback fills them after those of the joints.

use super::body::COORDINATES;
use super::kkt::SingularConstraints;
use super::system::{System, SystemWorkspace};

/// Newton converges quadratically from an integrator's drift; more means that it started elsewhere.
pub const MOST_ITERATIONS: usize = 30;
/// A residual of so many tolerances is accepted once iterations can't reduce it.
const ROUNDED: f64 = 10.0;

/// What a projection did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projection {
    /// Factorisations of the positions' iteration.
    pub iterations: usize,
    /// Largest |phi| before and after.
    pub drift: f64,
    pub residual: f64,
    /// Largest change of a coordinate, m or rad, and of a velocity, m/s or rad/s.
    pub position_change: f64,
    pub velocity_change: f64,
}

/// The state could not be brought onto the constraints.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProjectionError {
    #[error("constraint {name} is still violated by {residual:.1e} after {iterations} iterations: check the initial positions")]
    NotConverged { name: String, residual: f64, iterations: usize },
    #[error("constraint {name} repeats what others demand at this position, or nothing can move to satisfy it")]
    Singular { name: String },
}

impl System {
    /// Projects the state `y` at time t [s]: positions until all |phi| <= tolerance (m, rad or a cosine), then
    /// velocities. `contacts` fills the contacts' rows, residuals and rates for the motions in the workspace.
    ///
    /// # Errors
    /// [`ProjectionError`], or what `contacts` returns; `y` is then somewhere between.
    pub fn project<E: From<ProjectionError>>(
        &self,
        t: f64,
        y: &mut [f64],
        workspace: &mut SystemWorkspace,
        tolerance: f64,
        mut contacts: impl FnMut(&mut SystemWorkspace) -> Result<(), E>,
    ) -> Result<Projection, E> {
        let mut done = self.project_positions(t, y, workspace, tolerance, &mut contacts)?;
        // Rows of joints stand as the last look at the positions has filled them; those of contacts are located anew.
        let rows = &workspace.constraints;
        done.velocity_change = if rows.kkt.rows() > rows.joint_rows {
            self.project_velocities(t, y, workspace, &mut contacts)?
        } else {
            self.take_rates_back(y, workspace)?
        };
        Ok(done)
    }

    /// The positions' part of [`System::project`].
    pub fn project_positions<E: From<ProjectionError>>(
        &self,
        t: f64,
        y: &mut [f64],
        workspace: &mut SystemWorkspace,
        tolerance: f64,
        contacts: &mut impl FnMut(&mut SystemWorkspace) -> Result<(), E>,
    ) -> Result<Projection, E> {
        let mut done = Projection::default();
        if workspace.constraints.kkt.rows() == 0 {
            return Ok(done);
        }
        loop {
            self.fill_rows(t, y, workspace, contacts)?;
            let constraints = &mut workspace.constraints;
            let (residual, row) = constraints.largest(&constraints.residual);
            done.residual = residual;
            if done.iterations == 0 {
                done.drift = residual;
            }
            if residual <= tolerance {
                return Ok(done);
            }
            // Where a place of contact is about to cease, rounding is amplified: what can't be reduced is as good as closed.
            if done.iterations == MOST_ITERATIONS && residual <= ROUNDED * tolerance {
                return Ok(done);
            }
            if done.iterations == MOST_ITERATIONS || !residual.is_finite() {
                return Err(ProjectionError::NotConverged { name: self.row_name(row), residual, iterations: done.iterations }.into());
            }
            constraints.kkt.factorise().map_err(|error| self.singular(error))?;
            constraints.kkt.correction(&constraints.residual, &mut constraints.accelerations);
            let change = add(&mut y[..COORDINATES * self.bodies.len()], &constraints.accelerations);
            done.position_change = done.position_change.max(change);
            done.iterations += 1;
        }
    }

    /// The velocities' part of [`System::project`]; returns the largest change.
    pub fn project_velocities<E: From<ProjectionError>>(
        &self,
        t: f64,
        y: &mut [f64],
        workspace: &mut SystemWorkspace,
        contacts: &mut impl FnMut(&mut SystemWorkspace) -> Result<(), E>,
    ) -> Result<f64, E> {
        if workspace.constraints.kkt.rows() > 0 {
            self.fill_rows(t, y, workspace, contacts)?;
        }
        Ok(self.take_rates_back(y, workspace)?)
    }

    /// Takes what the rows in the workspace say of velocities out of `y`; returns the largest change.
    fn take_rates_back(&self, y: &mut [f64], workspace: &mut SystemWorkspace) -> Result<f64, ProjectionError> {
        let constraints = &mut workspace.constraints;
        if constraints.kkt.rows() == 0 {
            return Ok(0.0);
        }
        constraints.kkt.factorise().map_err(|error| self.singular(error))?;
        constraints.kkt.correction(&constraints.rate, &mut constraints.accelerations);
        Ok(add(&mut y[COORDINATES * self.bodies.len()..], &constraints.accelerations))
    }

    /// Motions, mobilities and all rows at `y`.
    fn fill_rows<E>(
        &self,
        t: f64,
        y: &[f64],
        workspace: &mut SystemWorkspace,
        contacts: &mut impl FnMut(&mut SystemWorkspace) -> Result<(), E>,
    ) -> Result<(), E> {
        self.move_bodies(y, workspace);
        self.prepare_constraints(t, workspace);
        contacts(workspace)
    }

    fn singular(&self, error: SingularConstraints) -> ProjectionError {
        ProjectionError::Singular { name: self.row_name(error.row) }
    }
}

/// Adds and returns the largest change.
fn add(values: &mut [f64], change: &[f64]) -> f64 {
    let mut largest: f64 = 0.0;
    for (value, change) in values.iter_mut().zip(change) {
        *value += change;
        largest = largest.max(change.abs());
    }
    largest
}
