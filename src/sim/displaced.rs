//! The snapshot a little ahead or behind along the solution: derivatives of outputs by time are found by looking there.

use super::{Simulation, SimulationError, Snapshot, input};
use crate::formulation::Evaluation;

impl Simulation {
    /// Moves the snapshot along the solution by `offset` [s] (for derivatives of outputs): y along its tangent, or along the parabola with these second
    /// derivatives; inputs by their polynomials.
    ///
    /// # Errors
    /// [`SimulationError`] when the model cannot be evaluated there.
    pub fn displace(&mut self, offset: f64, bend: Option<&[f64]>) -> Result<(), SimulationError> {
        self.snapshot()?;
        self.known = None;
        let Snapshot { time, y, dy, workspace, memory, inputs } = &mut self.snapshot;
        for (value, slope) in y.iter_mut().zip(dy.iter()) {
            *value += offset * slope;
        }
        for (value, bend) in y.iter_mut().zip(bend.unwrap_or_default()) {
            *value += 0.5 * offset * offset * bend;
        }
        *time += offset;
        input::evaluate(&self.model, &self.state.inputs, *time, inputs);
        Ok(self.model.derivative(workspace, Evaluation { t: *time, inputs, y, memory }, dy)?)
    }

    /// What was looked at last.
    pub fn seen(&self) -> &Snapshot {
        &self.snapshot
    }
}
