//! Positions and velocities are moved onto the constraints: of joints, and of contacts where they are constraints.

use super::step::Step;
use super::{ContactFailure, EvaluationError, Wheelset};
use crate::mbs::projection::ProjectionError;
use crate::mbs::system::SystemWorkspace;

/// Positions are on a constraint when it is violated by less than this, m.
const CLOSED: f64 = 1e-13;
/// A change of velocity below this [m/s] counts as none.
const AT_REST: f64 = 1e-12;

/// A failure on the way, with the place still to be found.
enum ProjectionFailure {
    System(ProjectionError),
    At(EvaluationError),
}

impl From<ProjectionError> for ProjectionFailure {
    fn from(error: ProjectionError) -> Self {
        ProjectionFailure::System(error)
    }
}

/// Moves coordinates, then velocities onto all constraints; `contacts` fills the contacts' rows. Returns whether anything was
/// moved.
///
/// # Errors
/// [`EvaluationError`] when there is no such state nearby.
pub(super) fn project(
    step: &mut Step,
    mut contacts: impl FnMut(&mut SystemWorkspace, &mut super::memory::ModelMemory) -> Result<(), EvaluationError>,
) -> Result<bool, EvaluationError> {
    let Step { model, workspace, t, y, memory } = step;
    let system = &mut workspace.system;
    let rounding = |wheelset: &Wheelset| model.rounding(&y[model.system.coordinates(wheelset.body)]);
    let closed = model.wheelsets.iter().map(rounding).fold(CLOSED, f64::max);
    let projected = model.system.project(*t, y, system, closed, |system| contacts(system, memory).map_err(ProjectionFailure::At));
    let failure = match projected {
        Ok(done) => {
            workspace.work.constraint_iterations += done.iterations as u64;
            return Ok(done.iterations > 0 || done.velocity_change > AT_REST);
        }
        Err(ProjectionFailure::At(error)) => return Err(error),
        Err(ProjectionFailure::System(error)) => error,
    };
    let (gap, row) = system.constraints.largest(&system.constraints.residual);
    let wheel = model.wheel_of_row(system, row);
    let place = model.beside(&system.motions[wheel.wheelset.body]).0;
    Err(match failure {
        ProjectionError::NotConverged { iterations, .. } => wheel.error(*t, ContactFailure::NotClosed { iterations, gap, y: place }),
        ProjectionError::Singular { .. } => model.singular_row(system, *t, row),
    })
}
