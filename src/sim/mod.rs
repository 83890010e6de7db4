//! Floor 7: a simulation is a model, scratch, an integrator and a state.
//!
//! [`SimulationState`] is all that a run remembers: cloning it saves the run, and two runs from equal states are
//! equal bit for bit when they are advanced to the same times.

pub mod adhesion;
pub mod balance;
pub mod checkpoint;
mod directional;
mod displaced;
mod dynamics;
pub mod energy;
pub mod feedthrough;
mod initial;
pub mod input;
pub mod input_table;
mod look;
mod notes;
pub mod outputs;
pub mod pattern;
pub mod recording;
pub mod serialized;
pub mod statics;
pub mod tables;
mod taking_up;
pub mod tuning;
mod uneven_loads;
pub mod vehicle_outputs;

use crate::formulation::events::ContactEvent;
use crate::formulation::flutter::Flutter;
use crate::formulation::frame_motion::FrameMotion;
use crate::formulation::strikes::Strikes;
use crate::formulation::swing::Swings;
use crate::formulation::timers::Timers;
use crate::formulation::transitions::Transition;
use crate::formulation::wheel_loads::WheelLoads;
use crate::formulation::work::Work;
use crate::formulation::{AssemblyError, ContactFailure, Evaluation, EvaluationError, Model, Workspace};
use crate::scene::assemble;
use crate::scene::equilibrium::EquilibriumError;
use crate::scene::spec::Scene;
use crate::scene::steady_state::{self, Contacts};
use crate::solve::{Doubts, IntegrationState, Integrator, Scratch, SolveError, Statistics};
use dynamics::{Memories, ModelDynamics, Watched};
use initial::{initial_state, on_the_line};
use input::InputSignal;
use look::Needs;
pub use look::Snapshot;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use taking_up::Push;

/// Everything that a simulation remembers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulationState {
    /// The simulation's own time (the integrator may be ahead), s.
    pub time: f64,
    pub integration: IntegrationState,
    /// Of the model, beside the solution.
    pub memories: Memories,
    /// One signal per input of the model, as it was set.
    pub inputs: Vec<InputSignal>,
    /// Those that the integration follows; others take their place when it goes on.
    followed: Vec<InputSignal>,
    /// Those under which the step in hand was made, where it has taken changes up.
    began: Vec<InputSignal>,
    /// The motion beside which the last step was made; its continuous output is counted from it.
    pub frame: FrameMotion,
    /// How far wheelsets swing.
    pub swings: Swings,
    /// Wheelsets whose flanges strike.
    pub strikes: Strikes,
    /// Wheelsets that flutter on their contacts.
    pub flutter: Flutter,
    /// Work of the formulation on the stepping path.
    pub work: Work,
}

impl SimulationState {
    /// Are time, solution and inputs numbers, and has the integrator come to the simulation's time? (Memory may hold times that never come.)
    pub fn is_sound(&self) -> bool {
        let signals = self.inputs.iter().chain(&self.followed).flat_map(|signal| signal.at(self.time));
        let own = [self.time, self.integration.t];
        let finite = own.into_iter().chain(signals).chain(self.integration.y.iter().copied()).all(f64::is_finite);
        finite && self.time - self.integration.t <= LAG
    }

    /// Could this state have come from the same model and integrator as `other`?
    pub fn fits(&self, other: &SimulationState) -> bool {
        self.integration.fits(&other.integration)
            && self.memories.fits(&other.memories)
            && self.frame.fits(&other.frame)
            && self.swings.fits(&other.swings)
            && self.strikes.fits(&other.strikes)
            && self.flutter.fits(&other.flutter)
            && self.inputs.len() == other.inputs.len()
            && self.followed.len() == other.followed.len()
            && self.began.len() == other.began.len()
    }
}

/// Why a simulation could not start or go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    #[error("{0}")]
    Assembly(#[from] AssemblyError),
    #[error("{0}")]
    Equilibrium(#[from] EquilibriumError),
    #[error("{0}")]
    Evaluation(#[from] EvaluationError),
    #[error("{0}")]
    Solve(#[from] SolveError),
    #[error("\"{name}\" is not a finite number at t = {time} s; the inputs or the scene are beyond what the model can follow")]
    NotFinite { name: String, time: f64 },
}

impl SimulationError {
    /// Has a wheel left its rail? (Not a failure of the program: the run ends there.)
    pub fn is_derailed(&self) -> bool {
        matches!(
            self,
            SimulationError::Evaluation(EvaluationError { cause: ContactFailure::Derailed { .. } | ContactFailure::OffRail { .. }, .. })
        )
    }
}

/// The integrator is ahead of the simulation, or behind by what an integrator may leave of a step, s.
const LAG: f64 = 1e-6;

/// A running simulation of one scene.
#[derive(Debug)]
pub struct Simulation {
    model: Model,
    integrator: Arc<dyn Integrator>,
    state: SimulationState,
    workspace: Workspace,
    scratch: Scratch,
    /// Of the attempt under way.
    trial: Memories,
    snapshot: Snapshot,
    /// What of the snapshot belongs to the present state.
    known: Option<Needs>,
    push: Push,
    /// Over the run so far, for its notes alone.
    loads: WheelLoads,
    /// Share of its dry friction that the vehicle starts with in a curve.
    rubbed_in: f64,
    untuned: tuning::Untuned,
    /// Constants and tolerance for which the modes of the bodies were found last.
    tuned: tuning::Tuned,
    extrapolation: directional::Extrapolation,
    /// s.
    start: f64,
}

/// Puts elements that turn with axles where they come to rest; `driven`: under what they begin with.
fn spin_up(model: &Model, workspace: &mut Workspace, (start, y): (f64, &mut [f64]), driven: bool) {
    if driven {
        model.take_inputs(&mut workspace.system, start, &model.start_inputs());
    }
    model.system.spin_up_forces(y, &mut workspace.system);
}

impl Simulation {
    /// Assembles the scene and puts it into its initial state at `start` [s].
    ///
    /// # Errors
    /// [`SimulationError`] when there is no equilibrium or the initial state cannot be evaluated.
    pub fn new(scene: &Scene, start: f64) -> Result<Self, SimulationError> {
        if let Some(speed) = scene.vehicle.starts_with(start)?.filter(|speed| *speed != scene.vehicle.speed) {
            let mut scene = scene.clone();
            scene.vehicle.speed = speed;
            return Self::new(&scene, start);
        }
        let model = assemble::model(scene)?;
        let steady = scene.vehicle.initial.from_equilibrium.then(|| steady_state::steady_state(scene)).transpose()?;
        let model = model.with_static_wheel_loads(steady.as_ref().map_or(&[], |steady| &steady.wheel_loads));
        let rubbed_in = steady.as_ref().map_or(1.0, |steady| steady.rubbed_in);
        let state = initial_state(scene, &model, steady);
        let mut simulation = Self::begin(model, &scene.solver.integrator, state, start, scene.vehicle.initial.driven)?;
        simulation.rubbed_in = rubbed_in;
        if scene.effects.half {
            simulation.halve()?;
        }
        Ok(simulation)
    }

    /// Computes one half of a symmetric run from now on.
    fn halve(&mut self) -> Result<(), SimulationError> {
        let Simulation { model, state, snapshot, workspace, .. } = self;
        let at = Evaluation { t: state.time, inputs: &snapshot.inputs, y: &snapshot.y, memory: &mut state.memories.accepted.clone() };
        model.halve(&mut workspace.clone(), at, &mut state.integration.y).map_err(AssemblyError::from)?;
        self.known = None;
        self.look()?;
        Ok(())
    }

    /// A simulation of a model that was put together in code, from its solution `y` at `start` [s]: six coordinates per body (x, y, z, yaw, roll,
    /// pitch) in the track frame, then their rates, then the other states (`Model::dimension` in all; zeros will do). Contacts are found.
    ///
    /// # Errors
    /// [`SimulationError`] when the initial state cannot be evaluated.
    pub fn from_model(model: Model, integrator: &Arc<dyn Integrator>, mut y: Vec<f64>, start: f64) -> Result<Self, SimulationError> {
        y.resize(model.dimension(), 0.0);
        Self::begin(model, integrator, (y, Contacts::Any), start, false)
    }

    /// From a solution in the track frame, and how contacts begin; `driven`: elements have taken up what they begin with.
    fn begin(
        mut model: Model,
        integrator: &Arc<dyn Integrator>,
        (mut y, contacts): (Vec<f64>, Contacts),
        start: f64,
        driven: bool,
    ) -> Result<Self, SimulationError> {
        let mut memory = model.blank_memory();
        if let Contacts::Kept(kept) = &contacts {
            (memory.wheels, memory.partitions) = (kept.wheels.clone(), kept.partitions.clone());
        }
        model.set_distances(|body| y[model.system.coordinates(body).start], &mut memory);
        if let Some(line) = model.track.line() {
            on_the_line(&model, line, &mut y);
        }
        let mut workspace = model.workspace();
        spin_up(&model, &mut workspace, (start, &mut y), driven);
        let mut step = model.at(&mut workspace, start, &mut y, &mut memory);
        match contacts {
            Contacts::Any => model.formulation.start(&mut step)?,
            Contacts::Kept(_) => model.formulation.resettle(&mut step)?,
            Contacts::Elastic => step.start_elastic()?,
        }
        step.project()?;
        step.settle_rails(&model.start_inputs())?;
        model.note_means(start, &y, &mut memory);
        let inputs: Vec<InputSignal> = model.start_inputs().iter().map(|value| InputSignal::constant(start, *value)).collect();
        let snapshot = Snapshot {
            time: start,
            dy: vec![0.0; y.len()],
            workspace: workspace.clone(),
            memory: memory.clone(),
            inputs: vec![0.0; inputs.len()],
            y: y.clone(),
        };
        let tuned = tuning::as_begun(&mut model, integrator);
        let mut simulation = Simulation {
            integrator: integrator.clone(),
            scratch: Scratch::new(y.len(), model.event_functions()),
            trial: Memories::new(memory.clone()),
            push: Push::new(y.len(), inputs.len()),
            state: SimulationState {
                time: start,
                integration: integrator.start(start, &y),
                memories: if integrator.response_vectors() > 0 { Memories::new(memory).with_begin() } else { Memories::new(memory) },
                began: inputs.clone(),
                followed: inputs.clone(),
                inputs,
                frame: FrameMotion::default(),
                swings: model.swings(),
                strikes: model.strikes(),
                flutter: model.flutter(),
                work: Work::default(),
            },
            workspace,
            snapshot,
            known: None,
            loads: model.wheel_loads(),
            rubbed_in: 1.0,
            untuned: Vec::new(),
            tuned,
            extrapolation: Default::default(),
            start,
            model,
        };
        simulation.model.prepare_tangent(&mut simulation.workspace);
        if !simulation.integrator.linearises() {
            simulation.workspace.leave_out_rides();
        }
        simulation.state.frame = simulation.model.frame_motion(&simulation.workspace).clone();
        // A first evaluation finds the contacts from a cold start and shows whether the state makes sense.
        simulation.look()?;
        simulation.state.memories.accepted.clone_from(&simulation.snapshot.memory);
        simulation.model.settle_deflections(&simulation.snapshot.workspace, &mut simulation.state.integration.y);
        simulation.settle_rails()?;
        simulation.look_again()?;
        if let Some(transition) = simulation.model.due(start, &simulation.snapshot.memory) {
            simulation.switch_at_start(transition)?;
        }
        Ok(simulation)
    }

    /// What is shown belongs to the state, means before the first step too: a cold start differs in the last digits.
    fn look_again(&mut self) -> Result<(), SimulationError> {
        self.model.note_present_means(&self.snapshot.workspace, &mut self.state.memories.accepted);
        self.known = None;
        self.look().map(|_| ())
    }

    /// A contact that would be pulled on in the initial state changes its mode before the first step.
    fn switch_at_start(&mut self, transition: Transition) -> Result<(), SimulationError> {
        let SimulationState { time, integration, memories, .. } = &mut self.state;
        self.model.at(&mut self.workspace, *time, &mut integration.y, &mut memories.accepted).carry_out(transition)?;
        self.known = None;
        self.snapshot()?;
        Ok(())
    }

    /// What contacts did since this was last asked, in the order in which it was met. The integrator runs ahead of the simulation's time by up to a
    /// step. Places that are pressed from the start on did not begin.
    pub fn take_events(&mut self) -> Vec<ContactEvent> {
        let mut events = std::mem::take(&mut self.workspace.events);
        events.retain(|event| event.time > self.start || event.change.changes_mode());
        events
    }

    pub fn model(&self) -> &Model {
        &self.model
    }

    pub fn time(&self) -> f64 {
        self.state.time
    }

    pub fn state(&self) -> &SimulationState {
        &self.state
    }

    /// Puts a saved state back. Returns false and changes nothing when it is not a state of this model.
    pub fn restore(&mut self, state: &SimulationState) -> bool {
        let fits = self.state.fits(state);
        if fits {
            self.state.clone_from(state);
            self.loads.take_back(self.state.integration.t);
            self.workspace.events.clear();
            self.workspace.forget();
            self.known = None;
        }
        fits
    }

    /// Clocks of what the integrator asks of the model; off until [`Timers::running`] takes their place.
    pub fn timers(&mut self) -> &mut Timers {
        &mut self.workspace.timers
    }

    pub fn statistics(&self) -> Statistics {
        self.state.integration.statistics
    }

    /// Steps of a fixed length whose estimated error was no longer small.
    pub fn doubts(&self) -> Doubts {
        self.state.integration.doubts
    }

    /// When a wheel that had left its rail first struck it, s.
    pub fn first_strike(&self) -> Option<f64> {
        self.loads.first_strike()
    }

    /// Advances to `target` [s]; time does not go back: it stays where it is for one that has passed.
    ///
    /// # Errors
    /// [`SimulationError`]; time then stands where the last successful step ended.
    pub fn advance(&mut self, target: f64) -> Result<(), SimulationError> {
        let target = target.max(self.state.time);
        let advanced = self.integrate(|integrator, dynamics, state, scratch| integrator.advance(dynamics, state, scratch, target));
        self.state.time = if advanced.is_ok() { target } else { self.state.integration.t.max(self.state.time).min(target) };
        advanced
    }

    /// Advances to where the integrator's step in hand ends, `target` [s] at most; where time stands there already, a new step is made first. A step that
    /// finds its end at once (the system changes its form) may leave time where it is. Stops change nothing: a run over them is that of
    /// [`Simulation::advance`] bit for bit.
    ///
    /// # Errors
    /// [`SimulationError`]; time then stands where the last successful step ended.
    pub fn advance_to_stop(&mut self, target: f64) -> Result<(), SimulationError> {
        if self.state.integration.t <= self.state.time {
            self.integrate(|integrator, dynamics, state, scratch| integrator.advance_once(dynamics, state, scratch))?;
        }
        let end = self.state.integration.t;
        self.advance(if end < target - self.integrator.slack() { end } else { target })
    }

    /// Does time stand at the end of the integrator's last step?
    pub fn is_at_stop(&self) -> bool {
        (self.state.integration.t - self.state.time).abs() <= self.integrator.slack()
    }

    /// Lets the integrator run on the model under the present inputs.
    fn integrate(
        &mut self,
        run: impl FnOnce(&dyn Integrator, &mut ModelDynamics, &mut IntegrationState, &mut Scratch) -> Result<(), SolveError>,
    ) -> Result<(), SimulationError> {
        self.known = None;
        self.follow_inputs();
        self.workspace.work = Work::default();
        let SimulationState { inputs, frame, swings, strikes, flutter, integration, memories, .. } = &mut self.state;
        let watched = Watched { frame, swings, strikes, flutter, loads: &mut self.loads };
        let inputs = (&inputs[..], &mut self.snapshot.inputs[..]);
        let mut dynamics = ModelDynamics::new(&self.model, &mut self.workspace, inputs, (memories, &mut self.trial), watched);
        let advanced = run(&*self.integrator, &mut dynamics, integration, &mut self.scratch);
        let failure = dynamics.failure.take();
        self.state.work += self.workspace.work;
        advanced.map_err(|error| match (error, failure) {
            (SolveError::Undefined { time }, Some(reason)) => {
                // What fails in linear algebra does not know when.
                SimulationError::Evaluation(EvaluationError { time: if reason.time.is_nan() { time } else { reason.time }, ..reason })
            }
            _ => SimulationError::Solve(error),
        })
    }

    /// The state vector at the present time.
    pub fn solution(&self) -> Vec<f64> {
        let mut y = self.state.integration.y.clone();
        self.solution_at(self.state.time, &mut y);
        y
    }

    /// The same at a time [s] within the integrator's last step.
    pub fn solution_at(&self, time: f64, y: &mut [f64]) {
        let SimulationState { integration, frame, .. } = &self.state;
        integration.interpolate_beside(time, y, |ahead, y| self.model.add_frame_motion(frame, ahead, y));
    }
}
