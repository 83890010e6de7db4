//! One FMU instance, in safe Rust: phases, variables, steps and saved states.
//!
//! Every method checks everything before it changes anything: a call that is refused leaves the instance as it was.

mod directional;
mod errors;
mod events;
mod output_derivatives;
mod saved;
mod stepping;
mod tuning;
mod values;

pub use errors::{CallError, InstantiateError};
pub use saved::SavedState;
pub use stepping::{Pace, StepOutcome};

use super::description;
use super::variables::VariableTable;
use super::version::Version;
use crate::contact::normal::hertz_table::{EllipseTable, SharedTable};
use crate::formulation::events::ContactEvent;
use crate::scene::load::{self, SceneError};
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::vehicle_outputs::scene_outputs;
use crate::solve::{Integrator, SettingKind};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

/// Where an instance stands in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    Instantiated,
    Initialization,
    Stepping,
    Terminated,
    /// Between two steps, where discrete outputs may change (FMI 3.0).
    Event,
}

impl Phase {
    /// Has the run begun, and not ended?
    fn is_running(self) -> bool {
        matches!(self, Phase::Stepping | Phase::Event)
    }

    fn words(self) -> &'static str {
        match self {
            Phase::Instantiated => "before initialization mode",
            Phase::Initialization => "in initialization mode",
            Phase::Stepping => "after initialization",
            Phase::Event => "in event mode",
            Phase::Terminated => "after termination",
        }
    }
}

/// What the host says of the run before it begins.
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
    /// With which the run began where that is an input, m/s; `None` before initialization ends.
    begun_speed: Option<f64>,
    simulation: Option<Simulation>,
    last_read: values::LastRead,
    /// Held while the instance lives: models that it makes one after the other share it.
    _ellipses: SharedTable,
    /// Values of all parameters, in table order, with which the run began; empty before initialization ends. Those of `scene` may have been
    /// tuned since.
    begun: Vec<f64>,
    /// Parameters that are not what they were then: place in table order and value.
    tuned: Vec<(u32, f64)>,
    /// Does the host handle events, so that discrete outputs change in event mode alone?
    event_mode: bool,
    /// Contacts that carry load, by wheel, as discrete outputs show them between events; empty before the first event mode.
    shown: Vec<i32>,
    /// Where the step under way began, for taking it back.
    before: Option<Box<stepping::Before>>,
}

impl Instance {
    /// Reads the scene in a resource folder and checks that it belongs to the `guid` of an FMU of FMI 2.0.
    ///
    /// # Errors
    /// [`InstantiateError`].
    pub fn new(resources: &Path, guid: &str) -> Result<Self, InstantiateError> {
        Self::of_version(resources, guid, Version::Two)
    }

    /// The same for an FMU of either version.
    ///
    /// # Errors
    /// [`InstantiateError`].
    pub fn of_version(resources: &Path, guid: &str, version: Version) -> Result<Self, InstantiateError> {
        let ellipses = EllipseTable::shared();
        let scene = load::open_file(&resources.join("scene.toml"), "scene", &[])?;
        let table =
            VariableTable::of_version(&scene, version).map_err(|error| SceneError::Assembly { file: scene.source.file.clone(), error })?;
        let found = description::describe(&scene, &table).guid;
        if found != guid {
            return Err(InstantiateError::Guid { found, wanted: guid.chars().filter(|c| !c.is_control()).collect() });
        }
        let inputs = start_inputs(&table);
        Ok(Instance {
            exported: scene.clone(),
            scene,
            table,
            guid: found,
            phase: Phase::Instantiated,
            experiment: Experiment { start: 0.0, stop: None, tolerance: None },
            inputs,
            begun_speed: None,
            simulation: None,
            last_read: values::LastRead::default(),
            _ellipses: ellipses,
            begun: Vec::new(),
            tuned: Vec::new(),
            event_mode: false,
            shown: Vec::new(),
            before: None,
        })
    }

    /// Is initialization over?
    pub fn has_begun(&self) -> bool {
        self.phase.is_running() || self.phase == Phase::Terminated
    }

    /// The variables.
    pub fn table(&self) -> &VariableTable {
        &self.table
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
                    "{}: t = {} s, {} steps, {} rejected, {} evaluations, {} restarts, {} changes taken up",
                    self.scene.title,
                    simulation.time(),
                    s.steps,
                    s.rejected,
                    s.evaluations,
                    s.restarts,
                    s.taken_up
                )
            }
        }
    }

    fn require(&self, function: &'static str, allowed: &[Phase]) -> Result<(), CallError> {
        if allowed.contains(&self.phase) { Ok(()) } else { Err(CallError::Phase { function, phase: self.phase }) }
    }

    /// fmi2SetupExperiment. Returns a remark for the log when the tolerance could not be taken as it is.
    ///
    /// # Errors
    /// [`CallError`] for times that make no sense or a call that comes too late.
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<Option<String>, CallError> {
        self.require("setting up the experiment", &[Phase::Instantiated])?;
        if !start.is_finite() {
            return Err(CallError::Time { what: "startTime", value: start, expected: "a finite number".into() });
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return Err(CallError::Time {
                what: "stopTime",
                value: stop,
                expected: format!("a finite number not before startTime = {start}"),
            });
        }
        if let Some(tolerance) = tolerance.filter(|tolerance| !(*tolerance > 0.0 && tolerance.is_finite())) {
            return Err(CallError::Time { what: "tolerance", value: tolerance, expected: "a finite number greater than 0".into() });
        }
        self.experiment = Experiment { start, stop, tolerance };
        self.simulation = None;
        let setting = self.scene.solver.integrator.setting();
        Ok(match (setting.kind, tolerance) {
            (SettingKind::Step, Some(_)) => Some("the integrator has a fixed step; the tolerance has no effect".into()),
            (SettingKind::Tolerance, Some(wanted)) if wanted.clamp(setting.range.0, setting.range.1) != wanted => {
                let used = wanted.clamp(setting.range.0, setting.range.1);
                Some(format!("tolerance {wanted:?} is outside the range of the integrator; {used:?} (m and rad per step) is used"))
            }
            _ => None,
        })
    }

    /// fmi2EnterInitializationMode.
    ///
    /// # Errors
    /// [`CallError`] when it comes at the wrong time.
    pub fn enter_initialization(&mut self) -> Result<(), CallError> {
        self.require("entering initialization mode", &[Phase::Instantiated])?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// fmi2ExitInitializationMode: the model is assembled with the parameters then set. Returns the contacts that lift off in
    /// the initial state.
    ///
    /// # Errors
    /// [`CallError::Start`] when there is no valid initial state; the instance stays in initialization mode.
    pub fn exit_initialization(&mut self) -> Result<Vec<ContactEvent>, CallError> {
        self.require("leaving initialization mode", &[Phase::Initialization])?;
        let events = self.started()?.take_events();
        self.begun = self.parameter_values();
        self.begun_speed = self.start_speed();
        self.phase = if self.event_mode { Phase::Event } else { Phase::Stepping };
        Ok(events)
    }

    /// fmi2Terminate.
    ///
    /// # Errors
    /// [`CallError`] before initialization or when terminated already.
    pub fn terminate(&mut self) -> Result<(), CallError> {
        self.require("termination", &[Phase::Stepping, Phase::Event])?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// What a user should know about the run so far.
    pub fn notes(&self) -> Vec<String> {
        self.simulation.as_ref().map(Simulation::notes).unwrap_or_default()
    }

    /// fmi2Reset: as after fmi2Instantiate.
    pub fn reset(&mut self) {
        self.scene = self.exported.clone();
        self.phase = Phase::Instantiated;
        self.experiment = Experiment { start: 0.0, stop: None, tolerance: None };
        self.inputs = start_inputs(&self.table);
        self.begun_speed = None;
        self.simulation = None;
        self.begun.clear();
        self.tuned.clear();
        self.shown.clear();
        self.before = None;
    }

    /// The integrator with the setting that holds now.
    fn effective_integrator(&self) -> Arc<dyn Integrator> {
        let integrator = &self.scene.solver.integrator;
        let setting = integrator.setting();
        match self.experiment.tolerance {
            Some(tolerance) if setting.kind == SettingKind::Tolerance => {
                integrator.with_setting(tolerance.clamp(setting.range.0, setting.range.1))
            }
            _ => integrator.clone(),
        }
    }

    /// With which the run began, or would begin now, where the speed is an input, m/s.
    fn start_speed(&self) -> Option<f64> {
        self.begun_speed.or_else(|| Some(self.inputs[self.table.speed_input?][0]))
    }

    /// A simulation of the present parameters; made when it is first needed.
    fn started(&mut self) -> Result<&mut Simulation, CallError> {
        if self.simulation.is_none() {
            let mut scene = self.scene.clone();
            scene.solver.integrator = self.effective_integrator();
            scene.vehicle.speed = self.start_speed().unwrap_or(scene.vehicle.speed);
            let mut simulation = Simulation::new(&scene, self.experiment.start).map_err(CallError::Start)?;
            for (index, [value, first, second]) in self.inputs.iter().enumerate() {
                simulation.set_input(index, *value, *first, *second);
            }
            // Outputs read element constants, which parameters may have changed.
            self.table.outputs = scene_outputs(&scene, simulation.model());
            self.simulation = Some(simulation);
        }
        match &mut self.simulation {
            Some(simulation) => Ok(simulation),
            None => unreachable!("just made"),
        }
    }
}

/// Start values of all inputs of the model.
fn start_inputs(table: &VariableTable) -> Vec<[f64; 3]> {
    table.start_inputs.iter().map(|value| [*value, 0.0, 0.0]).collect()
}
