//! Contact as an elastic force: ECF-A and ECF-N, and the places of contact that one wheel may have.

pub(super) mod ecf_a;
pub(super) mod ecf_n;
pub(super) mod half_spaces;
pub mod linear;
pub(super) mod patch;
pub mod points;
pub(super) mod tabled;

use super::{EvaluationError, Model, Workspace};

/// The last step of an elastic evaluation: accelerations under the wrenches and the joints.
#[inline]
fn finish(model: &Model, workspace: &mut Workspace, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), EvaluationError> {
    model.deflection_rates(workspace, y, dy);
    model.rail_rates(workspace, y, dy);
    model.accelerate(workspace, t, y, dy)
}

impl Model {
    /// Derivative of the bodies' part of the state under the wrenches in the workspace and all joints, where contact is no constraint.
    ///
    /// # Errors
    /// [`EvaluationError`] when joints do not determine their forces.
    #[inline]
    pub fn accelerate(&self, workspace: &mut Workspace, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), EvaluationError> {
        let done = self.system.constrained_derivative(t, y, &mut workspace.system, dy);
        done.map_err(|error| self.singular_row(&workspace.system, t, error.row))
    }
}
