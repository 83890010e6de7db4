//! Saving and restoring all memory of an instance.

use super::{CallError, Experiment, Instance, Phase};
use crate::contact::normal::hertz_table::EllipseTable;
use crate::fmi::variables::{Role, Variable, VariableTable};
use crate::formulation::wheel_loads::NotedLoads;
use crate::scene::spec::Scene;
use crate::sim::serialized;
use crate::sim::{Simulation, SimulationState};
use serde::{Deserialize, Serialize};

/// All memory of an instance; what fmi2GetFMUstate keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    phase: Phase,
    experiment: Experiment,
    /// Values of all real parameters and of `fromEquilibrium`, in table order, with which the run began or will begin.
    parameters: Vec<f64>,
    /// Those that were tuned since: place in that order, and the value in force.
    tuned: Vec<(u32, f64)>,
    /// Inputs as they were set last: value, first and second derivative.
    inputs: Vec<[f64; 3]>,
    /// With which the run began or will begin, where that is an input.
    speed: Option<f64>,
    simulation: Option<SimulationState>,
    /// What was noted of loads until then: a course that is taken back leaves no warning.
    noted: Option<NotedLoads>,
    /// What discrete outputs show, by wheel; empty without event mode.
    shown: Vec<i32>,
}

impl SavedState {
    /// Is initialization over?
    fn has_begun(&self) -> bool {
        self.phase.is_running() || self.phase == Phase::Terminated
    }

    /// [`Instance::begun`] of an instance in this state.
    fn begun(&self) -> Vec<f64> {
        if self.has_begun() { self.parameters.clone() } else { Vec::new() }
    }

    /// [`Instance::begun_speed`] of an instance in this state.
    fn begun_speed(&self) -> Option<f64> {
        self.speed.filter(|_| self.has_begun())
    }
}

/// Notes go on from those of the state that was put back; those that do not fit are forgotten.
fn note_on(simulation: &mut Simulation, saved: &SavedState) {
    if let Some(noted) = &saved.noted {
        simulation.go_on_noting(noted.clone());
    }
}

impl Instance {
    /// Values of the parameters from which a simulation is started, in table order.
    fn start_values(&self) -> Vec<f64> {
        if self.begun.is_empty() { self.parameter_values() } else { self.begun.clone() }
    }

    /// fmi2GetFMUstate.
    pub fn save(&self) -> SavedState {
        SavedState {
            phase: self.phase,
            experiment: self.experiment,
            parameters: self.start_values(),
            tuned: self.tuned.clone(),
            inputs: self.inputs.clone(),
            speed: self.start_speed(),
            simulation: self.simulation.as_ref().map(|simulation| simulation.state().clone()),
            noted: self.simulation.as_ref().map(|simulation| simulation.loads().noted()),
            shown: self.shown.clone(),
        }
    }

    /// fmi2SetFMUstate: parameters, phase and simulation as they were.
    ///
    /// # Errors
    /// [`CallError`] when the state is not one of this FMU; nothing is changed then.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), CallError> {
        self.check_whole(saved)?;
        let same_start =
            self.experiment == saved.experiment && self.start_values() == saved.parameters && self.start_speed() == saved.speed;
        let (Some(state), Some(simulation), true) = (&saved.simulation, &self.simulation, same_start) else {
            return self.become_instance_of(saved);
        };
        if !simulation.state().fits(state) {
            return Err(CallError::ForeignState);
        }
        let other = if self.tuned == saved.tuned { None } else { Some(self.scenes(saved)?.1) };
        (self.phase, self.inputs, self.begun, self.shown) =
            (self.phase_of(saved), saved.inputs.clone(), saved.begun(), saved.shown.clone());
        if let Some(scene) = other {
            self.scene = scene;
            self.adopt_tuning();
        }
        self.begun_speed = saved.begun_speed();
        if let Some(simulation) = &mut self.simulation {
            simulation.restore(state);
            note_on(simulation, saved);
        }
        Ok(())
    }

    /// The same from the scene on: the run began otherwise than this one.
    fn become_instance_of(&mut self, saved: &SavedState) -> Result<(), CallError> {
        let (start, tuned) = self.scenes(saved)?;
        let mut other = Instance {
            exported: self.exported.clone(),
            scene: start,
            table: VariableTable::of_version(&self.exported, self.table.version).map_err(|error| CallError::Start(error.into()))?,
            guid: self.guid.clone(),
            phase: self.phase_of(saved),
            experiment: saved.experiment,
            inputs: saved.inputs.clone(),
            begun_speed: saved.begun_speed(),
            simulation: None,
            last_read: Default::default(),
            _ellipses: EllipseTable::shared(),
            begun: saved.begun(),
            tuned: Vec::new(),
            event_mode: self.event_mode,
            shown: saved.shown.clone(),
            before: None,
        };
        if let Some(state) = &saved.simulation {
            other.started()?;
            other.scene = tuned;
            if !saved.tuned.is_empty() {
                other.adopt_tuning();
            }
            let simulation = other.started()?;
            if !simulation.restore(state) {
                return Err(CallError::ForeignState);
            }
            note_on(simulation, saved);
            // Lift-offs of its own start say nothing about the state that was put back, unless that is still to start.
            if saved.phase != Phase::Initialization {
                simulation.take_events();
            }
        }
        *self = other;
        Ok(())
    }

    /// The phase to go on in: a host without event mode steps on from a state that was saved there.
    fn phase_of(&self, saved: &SavedState) -> Phase {
        if saved.phase == Phase::Event && !self.event_mode { Phase::Stepping } else { saved.phase }
    }

    /// Is a saved state of this FMU's form, and made of numbers?
    fn check_whole(&self, saved: &SavedState) -> Result<(), CallError> {
        let Experiment { start, stop, tolerance } = saved.experiment;
        let numbers = saved.inputs.iter().flatten().chain([&start]).chain(&stop).chain(&tolerance).chain(&saved.speed);
        let sound = numbers.copied().all(f64::is_finite) && saved.simulation.as_ref().is_none_or(SimulationState::is_sound);
        // A run has a simulation; before it nothing has been tuned.
        let whole = if saved.has_begun() { saved.simulation.is_some() } else { saved.tuned.is_empty() };
        let fits = self.parameters().count() == saved.parameters.len() && self.inputs.len() == saved.inputs.len();
        let fits = fits && self.table.speed_input.is_some() == saved.speed.is_some();
        let wheels = self.simulation.as_ref().map_or(saved.shown.len(), |simulation| simulation.model().contacts());
        let fits = fits && (saved.shown.is_empty() || saved.shown.len() == wheels);
        if sound && whole && fits { Ok(()) } else { Err(CallError::ForeignState) }
    }

    /// The scene with which a saved state's run began, and with the parameters in force then.
    fn scenes(&self, saved: &SavedState) -> Result<(Scene, Scene), CallError> {
        let parameters: Vec<&Variable> = self.parameters().collect();
        let mut start = self.exported.clone();
        for (variable, value) in parameters.iter().zip(&saved.parameters) {
            self.assign(variable, *value, &mut start)?;
        }
        let mut tuned = start.clone();
        for (place, value) in &saved.tuned {
            let variable = parameters.get(*place as usize).filter(|variable| variable.is_tunable()).ok_or(CallError::ForeignState)?;
            self.assign(variable, *value, &mut tuned)?;
        }
        Ok((start, tuned))
    }

    /// What can't be set can't be restored either.
    fn assign(&self, variable: &Variable, value: f64, scene: &mut Scene) -> Result<(), CallError> {
        self.check_value(variable, value).map_err(|_| CallError::ForeignState)?;
        match variable.role {
            // A number of an element may be one of several that hang together: what is as exported stays as it is.
            Role::RealParameter(parameter) if parameter.value(scene).to_bits() != value.to_bits() => parameter.assign(scene, value),
            Role::FromEquilibrium => scene.vehicle.initial.from_equilibrium = value == 1.0,
            _ => {}
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

    /// How many bytes they are.
    ///
    /// # Errors
    /// [`CallError::Blob`].
    pub fn serialized_size(&self, saved: &SavedState) -> Result<usize, CallError> {
        Ok(serialized::size(saved)?)
    }

    /// A saved state from bytes, verified.
    ///
    /// # Errors
    /// [`CallError::Blob`].
    pub fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, CallError> {
        Ok(serialized::read(&self.guid, bytes)?)
    }
}
