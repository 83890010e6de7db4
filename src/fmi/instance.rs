//! One FMU instance, in safe Rust: phases, variables, steps and saved states.
//!
//! Every method checks everything before it changes anything: a call that is refused leaves the instance as it was.

use super::description::{self, INPUT_DERIVATIVE_ORDER, OUTPUT_DERIVATIVE_ORDER};
use super::serialized::{self, BlobError};
use super::variables::{Kind, Role, Variable, VariableTable};
use crate::scene::load::{self, SceneError};
use crate::scene::spec::Scene;
use crate::sim::outputs::outputs;
use crate::sim::{Simulation, SimulationError, SimulationState};
use crate::solve::Integrator;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Where an instance stands in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    Instantiated,
    Initialization,
    Stepping,
    Terminated,
}

impl Phase {
    fn words(self) -> &'static str {
        match self {
            Phase::Instantiated => "before fmi2EnterInitializationMode",
            Phase::Initialization => "in initialization mode",
            Phase::Stepping => "after initialization",
            Phase::Terminated => "after fmi2Terminate",
        }
    }
}

/// Why a call was refused.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    #[error("{function} is not allowed {}", phase.words())]
    Phase { function: &'static str, phase: Phase },
    #[error("there is no {kind:?} variable with value reference {reference}")]
    UnknownReference { reference: u32, kind: Kind },
    #[error("\"{name}\" is {causality}, {variability}; it can't be set {}", phase.words())]
    NotSettable { name: String, causality: &'static str, variability: &'static str, phase: Phase },
    #[error("\"{name}\" can't be set to {value}: {problem}")]
    Value { name: String, value: f64, problem: String },
    #[error("\"{name}\" is not a real input, so it has no input derivative")]
    NotAnInput { name: String },
    #[error("\"{name}\" is not a real output, so it has no output derivative")]
    NotAnOutput { name: String },
    #[error("derivative order {order} of \"{name}\" is not supported; expected 1 to {largest}")]
    Order { name: String, order: i32, largest: i32 },
    #[error("{what} is {value}; expected {expected}")]
    Time { what: &'static str, value: f64, expected: String },
    #[error("the saved state does not fit this instance")]
    ForeignState,
    #[error("{0}")]
    Blob(#[from] BlobError),
    #[error("the model can't be started with these parameters: {0}")]
    Start(SimulationError),
    #[error("\"{name}\" is not a finite number at t = {time} s; the inputs or parameters are beyond what the model can follow")]
    NotFinite { name: String, time: f64 },
    #[error("the outputs can't be evaluated: {0}")]
    Evaluation(SimulationError),
}

/// How a step ended.
#[derive(Debug)]
pub enum StepOutcome {
    Done,
    /// The model could not be advanced to the end; time stands at the last successful step.
    Discarded(SimulationError),
}

/// All memory of an instance; what fmi2GetFMUstate keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    phase: Phase,
    experiment: Experiment,
    /// Values of all real parameters and of `fromEquilibrium`, in table order.
    parameters: Vec<f64>,
    /// Inputs as they were set before a simulation existed: value, first and second derivative.
    inputs: Vec<[f64; 3]>,
    simulation: Option<SimulationState>,
}

/// What fmi2SetupExperiment says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Experiment {
    start: f64,
    stop: Option<f64>,
    tolerance: Option<f64>,
}

/// An FMU instance.
pub struct Instance {
    /// As exported.
    exported: Scene,
    /// With the parameters that were set.
    scene: Scene,
    table: VariableTable,
    guid: String,
    phase: Phase,
    experiment: Experiment,
    inputs: Vec<[f64; 3]>,
    simulation: Option<Simulation>,
}

/// Why an instance cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum InstantiateError {
    #[error("resources/scene.toml: {0}")]
    Scene(#[from] SceneError),
    #[error("the resources belong to GUID {found}, but {wanted} was asked for: modelDescription.xml and resources don't fit, or were changed")]
    Guid { found: String, wanted: String },
}

/// Times agree when they differ by no more than this, relative to their size (at least 1 s).
const TIME_SLACK: f64 = 1e-9;

fn slack(time: f64) -> f64 {
    TIME_SLACK * time.abs().max(1.0)
}

impl Instance {
    /// Reads the scene in a resource folder and checks that it belongs to `guid`.
    ///
    /// # Errors
    /// [`InstantiateError`].
    pub fn new(resources: &Path, guid: &str) -> Result<Self, InstantiateError> {
        let scene = load::open_file(&resources.join("scene.toml"), "scene", &[])?;
        let table = VariableTable::new(&scene);
        let found = description::describe(&scene, &table).guid;
        if found != guid {
            return Err(InstantiateError::Guid { found, wanted: guid.chars().filter(|c| !c.is_control()).collect() });
        }
        let inputs = neutral_inputs(&table);
        Ok(Instance {
            exported: scene.clone(),
            scene,
            table,
            guid: found,
            phase: Phase::Instantiated,
            experiment: Experiment { start: 0.0, stop: None, tolerance: None },
            inputs,
            simulation: None,
        })
    }

    pub fn phase(&self) -> Phase {
        self.phase
    }

    pub fn guid(&self) -> &str {
        &self.guid
    }

    /// The present time, s.
    pub fn time(&self) -> f64 {
        self.simulation.as_ref().map_or(self.experiment.start, Simulation::time)
    }

    /// A sentence about the simulation for the log.
    pub fn summary(&self) -> String {
        match &self.simulation {
            None => format!("{}: not started", self.scene.title),
            Some(simulation) => {
                let s = simulation.statistics();
                format!(
                    "{}: t = {} s, {} steps, {} rejected, {} evaluations, {} restarts",
                    self.scene.title,
                    simulation.time(),
                    s.steps,
                    s.rejected,
                    s.evaluations,
                    s.restarts
                )
            }
        }
    }

    fn require(&self, function: &'static str, allowed: &[Phase]) -> Result<(), CallError> {
        if allowed.contains(&self.phase) { Ok(()) } else { Err(CallError::Phase { function, phase: self.phase }) }
    }

    /// fmi2SetupExperiment.
    ///
    /// # Errors
    /// [`CallError`] for times that make no sense or a call that comes too late.
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<(), CallError> {
        self.require("fmi2SetupExperiment", &[Phase::Instantiated])?;
        if !start.is_finite() {
            return Err(CallError::Time { what: "startTime", value: start, expected: "a finite number".into() });
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return Err(CallError::Time { what: "stopTime", value: stop, expected: format!("a finite number not before startTime = {start}") });
        }
        if let Some(tolerance) = tolerance.filter(|tolerance| !(1e-14..=1e-3).contains(tolerance)) {
            return Err(CallError::Time { what: "tolerance", value: tolerance, expected: "1e-14 to 1e-3 (m and rad per step)".into() });
        }
        self.experiment = Experiment { start, stop, tolerance };
        self.simulation = None;
        Ok(())
    }

    /// fmi2EnterInitializationMode.
    ///
    /// # Errors
    /// [`CallError`] when it comes at the wrong time.
    pub fn enter_initialization(&mut self) -> Result<(), CallError> {
        self.require("fmi2EnterInitializationMode", &[Phase::Instantiated])?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// fmi2ExitInitializationMode: the model is assembled with the parameters then set.
    ///
    /// # Errors
    /// [`CallError::Start`] when there is no valid initial state; the instance stays in initialization mode.
    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        self.require("fmi2ExitInitializationMode", &[Phase::Initialization])?;
        self.started()?;
        self.phase = Phase::Stepping;
        Ok(())
    }

    /// fmi2Terminate.
    ///
    /// # Errors
    /// [`CallError`] before initialization or when terminated already.
    pub fn terminate(&mut self) -> Result<(), CallError> {
        self.require("fmi2Terminate", &[Phase::Stepping])?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// fmi2Reset: as after fmi2Instantiate.
    pub fn reset(&mut self) {
        self.scene = self.exported.clone();
        self.phase = Phase::Instantiated;
        self.experiment = Experiment { start: 0.0, stop: None, tolerance: None };
        self.inputs = neutral_inputs(&self.table);
        self.simulation = None;
    }

    /// The scene with the parameters and the tolerance that hold now.
    fn effective_scene(&self) -> Scene {
        let mut scene = self.scene.clone();
        if let (Some(wanted), Integrator::DormandPrince { tolerance }) = (self.experiment.tolerance, &mut scene.solver.integrator) {
            *tolerance = wanted;
        }
        scene
    }

    /// A simulation of the present parameters; made when it is first needed.
    fn started(&mut self) -> Result<&mut Simulation, CallError> {
        if self.simulation.is_none() {
            let scene = self.effective_scene();
            let mut simulation = Simulation::new(&scene, self.experiment.start).map_err(CallError::Start)?;
            for (index, [value, first, second]) in self.inputs.iter().enumerate() {
                simulation.set_input(index, *value, *first, *second);
            }
            // Outputs read element constants, which parameters may have changed.
            self.table.outputs = outputs(simulation.model(), &scene.interface.outputs);
            self.simulation = Some(simulation);
        }
        match &mut self.simulation {
            Some(simulation) => Ok(simulation),
            None => unreachable!("just made"),
        }
    }

    fn lookup(&self, reference: u32, kind: Kind) -> Result<&Variable, CallError> {
        match self.table.find(reference) {
            Some((_, variable)) if variable.kind == kind => Ok(variable),
            _ => Err(CallError::UnknownReference { reference, kind }),
        }
    }

    /// fmi2GetReal.
    ///
    /// # Errors
    /// [`CallError`]; `values` is then unchanged.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), CallError> {
        let mut needs_simulation = false;
        for reference in references {
            needs_simulation |= matches!(self.lookup(*reference, Kind::Real)?.role, Role::Output(_));
        }
        if needs_simulation {
            self.started()?.snapshot().map_err(CallError::Evaluation)?;
        }
        let mut found = Vec::with_capacity(references.len());
        for reference in references {
            let variable = self.lookup(*reference, Kind::Real)?;
            let value = match &variable.role {
                Role::Output(output) => match &self.simulation {
                    Some(simulation) => self.table.outputs[*output].value(simulation.last_snapshot()),
                    None => unreachable!("started above"),
                },
                Role::Input(input) => self.simulation.as_ref().map_or(self.inputs[*input][0], |simulation| simulation.input(*input)[0]),
                Role::RealParameter(parameter) => parameter.value(&self.scene),
                _ => return Err(CallError::UnknownReference { reference: *reference, kind: Kind::Real }),
            };
            if !value.is_finite() {
                return Err(CallError::NotFinite { name: variable.name.clone(), time: self.time() });
            }
            found.push(value);
        }
        values.copy_from_slice(&found);
        Ok(())
    }

    /// fmi2GetInteger.
    ///
    /// # Errors
    /// [`CallError`] for an unknown reference.
    pub fn get_integer(&mut self, reference: u32) -> Result<i32, CallError> {
        match self.lookup(reference, Kind::Integer)?.role {
            Role::Counter(read) => {
                let count = self.simulation.as_ref().map_or(0, |simulation| read(&simulation.statistics()));
                Ok(i32::try_from(count).unwrap_or(i32::MAX))
            }
            _ => Err(CallError::UnknownReference { reference, kind: Kind::Integer }),
        }
    }

    /// fmi2GetBoolean.
    ///
    /// # Errors
    /// [`CallError`] for an unknown reference.
    pub fn get_boolean(&self, reference: u32) -> Result<bool, CallError> {
        self.lookup(reference, Kind::Boolean)?;
        Ok(self.scene.vehicle.initial.from_equilibrium)
    }

    /// fmi2GetString.
    ///
    /// # Errors
    /// [`CallError`] for an unknown reference.
    pub fn get_string(&self, reference: u32) -> Result<&str, CallError> {
        self.lookup(reference, Kind::String)?;
        Ok(&self.scene.title)
    }

    fn not_settable(&self, variable: &Variable) -> CallError {
        CallError::NotSettable {
            name: variable.name.clone(),
            causality: variable.causality,
            variability: variable.variability,
            phase: self.phase,
        }
    }

    fn check_settable(&self, variable: &Variable) -> Result<(), CallError> {
        let allowed = match variable.role {
            Role::Input(_) => self.phase != Phase::Terminated,
            Role::RealParameter(_) | Role::FromEquilibrium => matches!(self.phase, Phase::Instantiated | Phase::Initialization),
            _ => false,
        };
        if allowed { Ok(()) } else { Err(self.not_settable(variable)) }
    }

    fn check_value(&self, variable: &Variable, value: f64) -> Result<(), CallError> {
        let problem = if !value.is_finite() {
            "it must be a finite number".to_string()
        } else if variable.min.is_some_and(|min| value < min) {
            format!("the smallest value is {}", variable.min.unwrap_or_default())
        } else if variable.max.is_some_and(|max| value > max) {
            format!("the largest value is {}", variable.max.unwrap_or_default())
        } else if value == 0.0 && variable.name == "speed" {
            "creepages are relative to the travelling speed".to_string()
        } else {
            return Ok(());
        };
        Err(CallError::Value { name: variable.name.clone(), value, problem })
    }

    /// fmi2SetReal. Setting an input ends its derivatives.
    ///
    /// # Errors
    /// [`CallError`]; nothing is set then.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        for (reference, value) in references.iter().zip(values) {
            let variable = self.lookup(*reference, Kind::Real)?;
            self.check_settable(variable)?;
            self.check_value(variable, *value)?;
        }
        for (reference, value) in references.iter().zip(values) {
            match self.lookup(*reference, Kind::Real)?.role {
                Role::Input(input) => self.set_input(input, [*value, 0.0, 0.0]),
                Role::RealParameter(parameter) => {
                    parameter.assign(&mut self.scene, *value);
                    self.simulation = None;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn set_input(&mut self, input: usize, signal: [f64; 3]) {
        match &mut self.simulation {
            Some(simulation) => simulation.set_input(input, signal[0], signal[1], signal[2]),
            None => {}
        }
        // Kept for a simulation that is made anew when a parameter changes before initialization ends.
        self.inputs[input] = signal;
    }

    /// fmi2SetBoolean.
    ///
    /// # Errors
    /// [`CallError`].
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), CallError> {
        for reference in references {
            self.check_settable(self.lookup(*reference, Kind::Boolean)?)?;
        }
        if let Some(value) = values.last() {
            self.scene.vehicle.initial.from_equilibrium = *value;
            self.simulation = None;
        }
        Ok(())
    }

    /// fmi2SetInteger and fmi2SetString: no variable of these types can be set.
    ///
    /// # Errors
    /// [`CallError`], always unless `references` is empty.
    pub fn refuse_to_set(&self, references: &[u32], kind: Kind) -> Result<(), CallError> {
        match references.first() {
            Some(reference) => Err(self.not_settable(self.lookup(*reference, kind)?)),
            None => Ok(()),
        }
    }

    /// fmi2SetRealInputDerivatives: order 1 and 2, with respect to the present time. An input follows its polynomial
    /// until its value or a derivative is set again.
    ///
    /// # Errors
    /// [`CallError`]; nothing is set then.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), CallError> {
        let mut changes: Vec<(usize, [f64; 3])> = Vec::new();
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let variable = self.lookup(*reference, Kind::Real)?;
            let name = variable.name.clone();
            let Role::Input(input) = variable.role else { return Err(CallError::NotAnInput { name }) };
            self.check_settable(variable)?;
            if !(1..=INPUT_DERIVATIVE_ORDER).contains(order) {
                return Err(CallError::Order { name, order: *order, largest: INPUT_DERIVATIVE_ORDER });
            }
            if !value.is_finite() {
                return Err(CallError::Value { name, value: *value, problem: "a derivative must be a finite number".into() });
            }
            let place = match changes.iter().position(|change| change.0 == input) {
                Some(place) => place,
                None => {
                    let present = self.simulation.as_ref().map_or(self.inputs[input], |simulation| simulation.input(input));
                    changes.push((input, present));
                    changes.len() - 1
                }
            };
            changes[place].1[*order as usize] = *value;
        }
        for (input, signal) in changes {
            self.set_input(input, signal);
        }
        Ok(())
    }

    /// fmi2GetRealOutputDerivatives, order 1: the outputs' change along the solution's tangent by a central difference
    /// over two microseconds (relative error about 1e-7 for the stiffest motion, the contact's 200 Hz).
    ///
    /// # Errors
    /// [`CallError`]; `values` is then unchanged.
    pub fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Result<(), CallError> {
        const REACH: f64 = 1e-6;
        let mut outputs = Vec::with_capacity(references.len());
        for (reference, order) in references.iter().zip(orders) {
            let variable = self.lookup(*reference, Kind::Real)?;
            let Role::Output(output) = variable.role else { return Err(CallError::NotAnOutput { name: variable.name.clone() }) };
            if !(1..=OUTPUT_DERIVATIVE_ORDER).contains(order) {
                return Err(CallError::Order { name: variable.name.clone(), order: *order, largest: OUTPUT_DERIVATIVE_ORDER });
            }
            outputs.push(output);
        }
        if outputs.is_empty() {
            return Ok(());
        }
        self.started()?;
        let (Some(simulation), table) = (&mut self.simulation, &self.table) else { return Ok(()) };
        let mut read = |offset: f64| -> Result<Vec<f64>, CallError> {
            let snapshot = simulation.displaced_snapshot(offset).map_err(CallError::Evaluation)?;
            Ok(outputs.iter().map(|output| table.outputs[*output].value(snapshot)).collect())
        };
        let (ahead, behind) = (read(REACH)?, read(-REACH)?);
        for ((value, ahead), behind) in values.iter_mut().zip(ahead).zip(behind) {
            *value = (ahead - behind) / (2.0 * REACH);
        }
        Ok(())
    }

    /// fmi2DoStep.
    ///
    /// # Errors
    /// [`CallError`] for a call that makes no sense; a model that cannot go on is [`StepOutcome::Discarded`].
    pub fn do_step(&mut self, current: f64, step: f64) -> Result<StepOutcome, CallError> {
        self.require("fmi2DoStep", &[Phase::Stepping])?;
        let time = self.time();
        if !((current - time).abs() <= slack(time)) {
            return Err(CallError::Time { what: "currentCommunicationPoint", value: current, expected: format!("the instance's time {time}") });
        }
        if !(step > 0.0 && step.is_finite()) {
            return Err(CallError::Time { what: "communicationStepSize", value: step, expected: "a finite number greater than 0".into() });
        }
        let target = current + step;
        if let Some(stop) = self.experiment.stop.filter(|stop| target > stop + slack(*stop)) {
            return Err(CallError::Time { what: "communicationStepSize", value: step, expected: format!("a step that ends by the stop time {stop}") });
        }
        if !(target > time) {
            return Err(CallError::Time { what: "communicationStepSize", value: step, expected: format!("a step that moves time beyond {time}") });
        }
        match self.started()?.advance(target) {
            Ok(()) => Ok(StepOutcome::Done),
            Err(error) => Ok(StepOutcome::Discarded(error)),
        }
    }

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
                    table: VariableTable::new(&self.exported),
                    guid: self.guid.clone(),
                    phase: saved.phase,
                    experiment: saved.experiment,
                    inputs: saved.inputs.clone(),
                    simulation: None,
                };
                if let Some(state) = state {
                    if !other.started()?.restore(state) {
                        return Err(CallError::ForeignState);
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

/// Start values of all inputs of the model.
fn neutral_inputs(table: &VariableTable) -> Vec<[f64; 3]> {
    // Inputs that the interface does not show keep their neutral value too.
    let count = table.variables.iter().filter_map(|v| if let Role::Input(input) = v.role { Some(input + 1) } else { None }).max().unwrap_or(0);
    let model_inputs = count.div_ceil(crate::formulation::WHEELSET_INPUTS).max(1) * crate::formulation::WHEELSET_INPUTS;
    crate::formulation::NEUTRAL_INPUTS.iter().cycle().take(model_inputs).map(|value| [*value, 0.0, 0.0]).collect()
}
