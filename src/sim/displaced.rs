//! The snapshot a little ahead or behind along the solution: derivatives of outputs by time are found by looking there.

use super::{Simulation, SimulationError, SimulationState, Snapshot, input};
use crate::formulation::Evaluation;

impl Simulation {
    /// Moves the snapshot along the solution by `offset` [s] (for derivatives of outputs): y along the continuous output of the step in hand, mirrored beyond its
    /// ends, along its tangent f where there is no step, or along the parabola with these second derivatives; inputs by their polynomials.
    ///
    /// The tangent is another direction than the solution goes: implicit steps leave the stiffest motions off balance by what the tolerance allows, and f says how
    /// they would swing back.
    ///
    /// # Errors
    /// [`SimulationError`] when the model cannot be evaluated there.
    pub fn displace(&mut self, offset: f64, bend: Option<&[f64]>) -> Result<(), SimulationError> {
        self.snapshot()?;
        self.known = None;
        let Snapshot { time, y, dy, workspace, memory, inputs } = &mut self.snapshot;
        let SimulationState { integration, frame, .. } = &self.state;
        let step = integration.step_begin()..=integration.t;
        let read = |time: f64, y: &mut [f64]| {
            integration.interpolate_beside(time, y, |ahead, y| self.model.add_frame_motion(frame, ahead, y));
        };
        if bend.is_none() && step.start() < step.end() && step.contains(&(*time + offset)) {
            read(*time + offset, y);
        } else if bend.is_none() && step.start() < step.end() && step.contains(&(*time - offset)) {
            read(*time - offset, dy);
            y.iter_mut().zip(dy.iter()).for_each(|(value, behind)| *value += *value - behind);
        } else {
            y.iter_mut().zip(dy.iter()).for_each(|(value, slope)| *value += offset * slope);
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
