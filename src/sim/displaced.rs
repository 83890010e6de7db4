//! The snapshot a little ahead or behind along the solution: derivatives of outputs by time are found by looking there.

use super::{Simulation, SimulationError, SimulationState, Snapshot, input};
use crate::formulation::Evaluation;

/// Distance of the points between which the slope of the solution is taken, s.
const APART: f64 = 1e-6;

impl Simulation {
    /// Moves the snapshot along the solution by `offset` [s] (for derivatives of outputs): y along the [`Simulation::slope`], or along the parabola with these
    /// second derivatives; inputs by their polynomials.
    ///
    /// # Errors
    /// [`SimulationError`] when the model cannot be evaluated there.
    pub fn displace(&mut self, offset: f64, slope: &[f64], bend: Option<&[f64]>) -> Result<(), SimulationError> {
        self.snapshot()?;
        self.known = None;
        let Snapshot { time, y, dy, workspace, memory, inputs } = &mut self.snapshot;
        for (value, slope) in y.iter_mut().zip(slope) {
            *value += offset * slope;
        }
        for (value, bend) in y.iter_mut().zip(bend.unwrap_or_default()) {
            *value += 0.5 * offset * offset * bend;
        }
        *time += offset;
        input::evaluate(&self.model, &self.state.inputs, *time, inputs);
        Ok(self.model.derivative(workspace, Evaluation { t: *time, inputs, y, memory }, dy)?)
    }

    /// Slope of the solution in the snapshot: that of the step's continuous output, which is what is handed out. Where no step is in hand it is f.
    ///
    /// f is another direction: implicit steps leave the stiffest motions off balance by what the tolerance allows, and f says how those would swing back. Inputs
    /// that were set since are taken up for a look, as the next step will take them up: into the step in hand, or by a restart, which begins along f.
    ///
    /// # Errors
    /// [`SimulationError`] when the model cannot be evaluated here.
    pub fn slope(&mut self) -> Result<Vec<f64>, SimulationError> {
        if !self.turns() {
            return self.slope_in_hand();
        }
        let (state, loads) = (self.state.clone(), self.loads.clone());
        self.follow_inputs();
        let slope = self.slope_in_hand();
        (self.state, self.loads) = (state, loads);
        self.workspace.forget();
        self.known = None;
        self.snapshot()?;
        slope
    }

    fn slope_in_hand(&mut self) -> Result<Vec<f64>, SimulationError> {
        self.snapshot()?;
        let Simulation { model, state, snapshot, .. } = self;
        let SimulationState { integration, frame, .. } = state;
        let Snapshot { time, y, dy, .. } = snapshot;
        let within = |offset: f64| (integration.step_begin()..=integration.t).contains(&(*time + offset));
        // Differences of second order, to one side at the ends of the step.
        let points = if within(-APART) && within(APART) {
            [(-1.0, -0.5), (1.0, 0.5), (0.0, 0.0)]
        } else if within(-2.0 * APART) {
            [(-2.0, 0.5), (-1.0, -2.0), (0.0, 1.5)]
        } else if within(2.0 * APART) {
            [(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)]
        } else {
            return Ok(dy.clone());
        };
        let (mut slope, mut there) = (vec![0.0; y.len()], vec![0.0; y.len()]);
        for (place, weight) in points {
            integration.interpolate_beside(*time + place * APART, &mut there, |ahead, y| model.add_frame_motion(frame, ahead, y));
            slope.iter_mut().zip(&there).for_each(|(slope, there)| *slope += weight / APART * there);
        }
        Ok(slope)
    }

    /// What was looked at last.
    pub fn seen(&self) -> &Snapshot {
        &self.snapshot
    }
}
