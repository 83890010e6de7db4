//! Saving and restoring all memory of an instance.

use super::{CallError, Experiment, Instance, Phase};
use crate::fmi::serialized;
use crate::fmi::variables::{Role, Variable, VariableTable};
use crate::sim::SimulationState;
use serde::{Deserialize, Serialize};

/// All memory of an instance; what fmi2GetFMUstate keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    phase: Phase,
    experiment: Experiment,
    /// Values of all real parameters and of `fromEquilibrium`, in table order.
    parameters: Vec<f64>,
    /// Inputs as they were set last: value, first and second derivative.
    inputs: Vec<[f64; 3]>,
    simulation: Option<SimulationState>,
}

impl Instance {
    fn parameter_values(&self) -> Vec<f64> {
        self.table
            .variables
            .iter()
            .filter_map(|variable| match &variable.role {
                Role::RealParameter(parameter) => Some(parameter.value(&self.scene)),
                Role::FromEquilibrium => Some(f64::from(u8::from(self.scene.vehicle.initial.from_equilibrium))),
                _ => None,
            })
            .collect()
    }

    /// fmi2GetFMUstate.
    pub fn save(&self) -> SavedState {
        SavedState {
            phase: self.phase,
            experiment: self.experiment,
            parameters: self.parameter_values(),
            inputs: self.inputs.clone(),
            simulation: self.simulation.as_ref().map(|simulation| simulation.state().clone()),
        }
    }

    /// fmi2SetFMUstate: parameters, phase and simulation as they were.
    ///
    /// # Errors
    /// [`CallError`] when the state is not one of this FMU; nothing is changed then.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), CallError> {
        let mut scene = self.exported.clone();
        let parameters = self.table.variables.iter().filter(|v| matches!(v.role, Role::RealParameter(_) | Role::FromEquilibrium));
        let parameters: Vec<&Variable> = parameters.collect();
        if parameters.len() != saved.parameters.len() || self.inputs.len() != saved.inputs.len() {
            return Err(CallError::ForeignState);
        }
        for (variable, value) in parameters.iter().zip(&saved.parameters) {
            // What can't be set can't be restored either.
            self.check_value(variable, *value).map_err(|_| CallError::ForeignState)?;
        }
        let Experiment { start, stop, tolerance } = saved.experiment;
        let numbers = saved.inputs.iter().flatten().chain([&start]).chain(&stop).chain(&tolerance);
        if !numbers.copied().all(f64::is_finite) || !saved.simulation.as_ref().is_none_or(SimulationState::is_sound) {
            return Err(CallError::ForeignState);
        }
        for (variable, value) in parameters.iter().zip(&saved.parameters) {
            match variable.role {
                Role::RealParameter(parameter) => parameter.assign(&mut scene, *value),
                _ => scene.vehicle.initial.from_equilibrium = *value == 1.0,
            }
        }
        let same_model = self.experiment == saved.experiment && self.parameter_values() == saved.parameters;
        match (&saved.simulation, &mut self.simulation) {
            (Some(state), Some(simulation)) if same_model => {
                if !simulation.restore(state) {
                    return Err(CallError::ForeignState);
                }
                (self.phase, self.inputs) = (saved.phase, saved.inputs.clone());
            }
            (state, _) => {
                let mut other = Instance {
                    exported: self.exported.clone(),
                    scene,
                    table: VariableTable::new(&self.exported).map_err(|error| CallError::Start(error.into()))?,
                    guid: self.guid.clone(),
                    phase: saved.phase,
                    experiment: saved.experiment,
                    inputs: saved.inputs.clone(),
                    simulation: None,
                };
                if let Some(state) = state {
                    let simulation = other.started()?;
                    if !simulation.restore(state) {
                        return Err(CallError::ForeignState);
                    }
                    // Lift-offs of its own start say nothing about the state that was put back, unless that is still to start.
                    if saved.phase != Phase::Initialization {
                        simulation.take_events();
                    }
                }
                *self = other;
            }
        }
        Ok(())
    }

    /// Bytes of a saved state.
    ///
    /// # Errors
    /// [`CallError::Blob`].
    pub fn serialize(&self, saved: &SavedState) -> Result<Vec<u8>, CallError> {
        Ok(serialized::write(&self.guid, saved)?)
    }

    /// A saved state from bytes, verified.
    ///
    /// # Errors
    /// [`CallError::Blob`].
    pub fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, CallError> {
        Ok(serialized::read(&self.guid, bytes)?)
    }
}
