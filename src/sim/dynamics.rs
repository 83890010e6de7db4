//! The model with its inputs as a system that an integrator can advance.

use super::input::{self, InputSignal};
use crate::formulation::flutter::Flutter;
use crate::formulation::frame_motion::FrameMotion;
use crate::formulation::memory::ModelMemory;
use crate::formulation::strikes::Strikes;
use crate::formulation::swing::Swings;
use crate::formulation::timers::Call;
use crate::formulation::transitions::Transition;
use crate::formulation::wheel_loads::WheelLoads;
use crate::formulation::{Cached, Evaluation, EvaluationError, Model, Workspace};
use crate::mbs::body::{COORDINATES, HEIGHT, ROLL};
use crate::solve::{Dynamics, Event, Implicit, StiffPart, Undefined};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Weight of a wheelset's height and roll in the error control: a loaded wheel's penetration is 0.07 mm, so that an error of
/// 1e-6 m there would be one of 2 % (1.6 kN) in the wheel load. With the weight, wheel loads are about as exact as lateral motion.
const PRESSING: f64 = 100.0;
/// Error of a position that makes a fixed step doubtful, m and rad.
const DOUBTFUL: f64 = 1e-4;
/// A failure before the present time by more than this lies behind, s.
const PASSED: f64 = 1e-9;

/// What a run remembers of its model beside the solution: as it was accepted last, and as the evaluation at the begin of the next step
/// found it, for repeating that to the bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memories {
    pub accepted: ModelMemory,
    before: ModelMemory,
    /// What the evaluation at the begin of the last step started from; of integrators that take changes of inputs up.
    begin: Option<ModelMemory>,
}

impl Memories {
    pub fn new(memory: ModelMemory) -> Self {
        Memories { before: memory.clone(), accepted: memory, begin: None }
    }

    /// With what [`crate::solve::Integrator::take_up`] needs.
    pub fn with_begin(self) -> Self {
        Memories { begin: Some(self.before.clone()), ..self }
    }

    pub fn fits(&self, other: &Memories) -> bool {
        self.accepted.fits(&other.accepted) && self.before.fits(&other.before) && self.begin.is_some() == other.begin.is_some()
    }

    fn take_over(&mut self, other: &Memories) {
        self.accepted.clone_from(&other.accepted);
        self.before.clone_from(&other.before);
    }
}

/// What a run looks at beside its solution.
#[derive(Debug)]
pub struct Watched<'a> {
    /// Beside which the last accepted step was made.
    pub frame: &'a mut FrameMotion,
    pub swings: &'a mut Swings,
    pub strikes: &'a mut Strikes,
    pub flutter: &'a mut Flutter,
    pub loads: &'a mut WheelLoads,
}

/// A model under given input signals.
pub struct ModelDynamics<'a> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    signals: &'a [InputSignal],
    values: &'a mut [f64],
    memories: &'a mut Memories,
    /// Of the attempt under way.
    trial: &'a mut Memories,
    watched: Watched<'a>,
    constant: bool,
    /// Where a derivative that is known already is written ([`Implicit::linearise_again`]); empty where it is not asked for.
    again: &'a mut [f64],
    /// Why the last failed evaluation failed.
    pub failure: Option<EvaluationError>,
}

impl<'a> ModelDynamics<'a> {
    pub fn new(
        model: &'a Model,
        workspace: &'a mut Workspace,
        (signals, values): (&'a [InputSignal], &'a mut [f64]),
        (memories, trial): (&'a mut Memories, &'a mut Memories),
        watched: Watched<'a>,
    ) -> Self {
        let constant = signals.iter().all(|signal| signal.first == 0.0 && signal.second == 0.0);
        input::evaluate(model, signals, 0.0, values);
        // Inputs are those of the evaluation that found them.
        if !constant {
            workspace.cached = Cached::No;
        }
        trial.take_over(memories);
        ModelDynamics { model, workspace, signals, values, memories, trial, watched, constant, again: &mut [], failure: None }
    }

    /// With room for a derivative.
    pub fn again(self, again: &'a mut [f64]) -> Self {
        ModelDynamics { again, ..self }
    }
}

impl ModelDynamics<'_> {
    /// What inputs with a slope do to f, beside J.
    fn find_drift(&mut self, t: f64, y: &[f64], part: StiffPart) {
        // Where J leaves force elements out, df/dt alone would lead astray.
        if self.constant || part != StiffPart::All {
            return;
        }
        let (model, signals) = (self.model, self.signals);
        model.find_drift(self.workspace, (t, y), self.values, |time, values| input::evaluate(model, signals, time, values));
        self.workspace.cached = Cached::No;
    }
}

/// The bodies' distances along the track, each bit of them.
fn places(memory: &ModelMemory) -> u64 {
    memory.distances.iter().fold(0, |all: u64, place| all.rotate_left(7) ^ place.to_bits())
}

/// Keeps the reason of a failure for whoever advanced the simulation.
fn keep<T>(failure: &mut Option<EvaluationError>, result: Result<T, EvaluationError>) -> Result<T, Undefined> {
    result.map_err(|error| {
        *failure = Some(error);
        Undefined
    })
}

impl Dynamics for ModelDynamics<'_> {
    #[inline]
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        let clock = self.workspace.timers.start();
        if !self.constant {
            input::evaluate(self.model, self.signals, t, self.values);
        }
        self.workspace.cached = Cached::No;
        let at = Evaluation { t, inputs: self.values, y, memory: &mut self.trial.accepted };
        let done = self.model.derivative(self.workspace, at, dy);
        self.workspace.timers.stop(Call::Derivative, clock);
        keep(&mut self.failure, done)
    }

    fn derivative_at_end(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.trial.before.clone_from(&self.trial.accepted);
        self.derivative(t, y, dy)?;
        self.workspace.cached = Cached::OfTrial;
        Ok(())
    }

    fn rollback(&mut self) {
        self.trial.take_over(self.memories);
        if self.workspace.cached == Cached::OfTrial {
            self.workspace.cached = Cached::No;
        }
    }

    fn accept(&mut self, evaluated: bool) {
        self.memories.accepted.clone_from(&self.trial.accepted);
        if evaluated {
            self.memories.before.clone_from(&self.trial.before);
            if self.workspace.cached == Cached::OfTrial {
                self.workspace.cached = Cached::OfState;
            }
        }
    }

    fn keep_begin(&mut self) {
        if let Some(begin) = &mut self.memories.begin {
            std::mem::swap(begin, &mut self.memories.before);
        }
    }

    fn note_cut(&mut self, t: f64, y: &[f64]) {
        self.model.note_means(t, y, &mut self.memories.accepted);
    }

    fn is_cached(&self) -> bool {
        self.workspace.cached == Cached::OfState
    }

    fn repeat(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        let work = self.workspace.work;
        self.trial.accepted.clone_from(&self.memories.before);
        let done = self.derivative(t, y, dy);
        // What was noted since then stays.
        self.rollback();
        self.workspace.work = work;
        self.workspace.cached = Cached::OfState;
        done
    }

    /// Positions, angles and force elements' states in metres and radians; those that press wheels into rails weigh more.
    fn error_weight(&self, i: usize) -> f64 {
        let system = &self.model.system;
        let velocities = COORDINATES * system.bodies.len();
        let plain = if (velocities..2 * velocities).contains(&i) || i >= self.model.mean_states(0).start {
            0.0
        } else if let Some(weight) = self.model.weight_of_force(i) {
            weight
        } else if let Some(weight) = self.model.weight_of_rail(i) {
            weight * PRESSING
        } else if i < velocities
            && matches!(i % COORDINATES, HEIGHT | ROLL)
            && self.model.wheelsets.iter().any(|wheelset| wheelset.body == i / COORDINATES)
        {
            PRESSING
        } else {
            1.0
        };
        self.model.formulation.error_weight(self.model, self.workspace, i, plain)
    }

    fn plain_weight(&self, i: usize) -> f64 {
        // Of a contact's patch it counts by the force that it makes, and a patch without load makes none.
        f64::from(u8::from(!self.model.is_deflection(i) && self.error_weight(i) > 0.0))
    }

    fn integrals(&self) -> Range<usize> {
        self.model.books_begin()..self.model.dimension()
    }

    fn coordinates(&self) -> usize {
        COORDINATES * self.model.system.bodies.len()
    }

    fn longest_step(&self, dy: &[f64]) -> f64 {
        self.model.longest_step(self.workspace, dy).min(self.watched.flutter.longest_step())
    }

    fn longest_known(&self) -> f64 {
        self.model.longest_known(self.workspace)
    }

    fn fastest_vibration(&self) -> [f64; 2] {
        let vibration = &self.watched.flutter.vibration;
        [vibration.rate, vibration.damping]
    }

    fn load_error(&self, error: &[f64]) -> f64 {
        self.model.load_error(self.workspace, error)
    }

    fn doubtful_error(&self) -> f64 {
        DOUBTFUL
    }

    fn swing_error(&self, error: &[f64]) -> f64 {
        let strikes = self.model.error_at_strikes(self.workspace, self.watched.strikes, error);
        let driving = self.model.driving_error(self.workspace, error);
        self.model.swing_error(self.workspace, self.watched.swings, error).max(strikes).max(driving)
    }

    fn note_step(&mut self, t: f64, y: &[f64]) {
        self.model.note_swings(self.workspace, (t, y), self.watched.swings);
        self.model.note_strikes(self.workspace, t, self.watched.strikes);
        let plain = self.watched.swings.is_plain();
        let flutters = |wheelset| self.watched.flutter.is_growing(wheelset);
        self.model.note_wheel_loads(self.workspace, (t, plain), flutters, self.watched.loads);
        self.model.note_present_means(self.workspace, &mut self.memories.accepted);
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        let cached = std::mem::replace(&mut self.workspace.cached, Cached::No);
        let memory = &mut self.trial.accepted;
        let clock = self.workspace.timers.start();
        let before = places(memory);
        let moved = self.model.at(self.workspace, t, y, memory).project();
        self.workspace.timers.stop(Call::Keep, clock);
        let moved = keep(&mut self.failure, moved)?;
        // Where nothing moves, bodies' motions are found again to the bit, and so are their places along a curved track: the search ends where it begins, but for a rounding at times.
        if !moved && places(memory) == before {
            self.workspace.cached = cached;
        }
        self.model.note_means(t, y, memory);
        Ok(moved)
    }

    fn event_functions(&self) -> usize {
        self.model.event_functions()
    }

    fn event_values(&self, values: &mut [f64]) {
        self.model.event_values(&self.trial.accepted, values);
    }

    fn due(&self, t: f64) -> Option<Event> {
        self.model.due(t, &self.trial.accepted).map(|transition| Event(transition.number()))
    }

    fn on_event(&mut self, Event(number): Event, t: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        let clock = self.workspace.timers.start();
        let changed = self.model.at(self.workspace, t, y, &mut self.trial.accepted).carry_out(Transition::of(number));
        self.workspace.timers.stop(Call::Keep, clock);
        let changed = keep(&mut self.failure, changed)?;
        if changed {
            self.workspace.cached = Cached::No;
        }
        Ok(changed)
    }

    fn refuse(&mut self, t: f64) -> bool {
        self.workspace.cached = Cached::No;
        let refused = self.trial.accepted.refuse_landings(t);
        if refused {
            self.failure = None;
            // What is told twice did not take place twice.
            self.workspace.events.retain(|event| event.time < t || !event.change.changes_mode());
        }
        refused
    }

    fn release(&mut self, t: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        // A failure that lies behind was overcome by a shorter step and says nothing.
        let Some(failure) = self.failure.clone().filter(|failure| failure.time > t - PASSED) else { return Ok(false) };
        self.workspace.cached = Cached::No;
        let released = self.model.at(self.workspace, t, y, &mut self.trial.accepted).release(&failure);
        keep(&mut self.failure, released)
    }

    /// When a wheel's contact reaches a place where its rail is not smooth, or an imposed speed bends.
    fn next_break(&self, t: f64, y: &[f64]) -> f64 {
        let memory = &self.trial.accepted;
        let next = self.model.next_try(memory).min(self.model.formulation.next_break(self.model, t, y));
        next.min(self.model.next_rough_place(t, y, memory))
            .min(self.model.next_edge_of_a_flat(t, y))
            .min(self.model.next_change_of_speed(t, y, memory))
    }
}

impl Implicit for ModelDynamics<'_> {
    fn linearise(&mut self, t: f64, y: &[f64], part: StiffPart) -> Result<(), Undefined> {
        let clock = self.workspace.timers.start();
        if part == StiffPart::Contact {
            self.model.note_vibration(self.workspace, t, y, &mut self.watched.flutter.vibration);
        }
        self.workspace.timers.forces |= part == StiffPart::All;
        self.model.linearise(self.workspace, (y, &self.trial.accepted), self.values, part == StiffPart::All);
        self.model.note_flutter(self.workspace, t, self.watched.flutter);
        self.find_drift(t, y, part);
        self.workspace.linearised = Some(t);
        self.workspace.timers.stop(Call::Linearise, clock);
        Ok(())
    }

    fn linearise_again(&mut self, t: f64, y: &[f64], part: StiffPart) -> Result<(), Undefined> {
        if self.workspace.linearised == Some(t) {
            return Ok(());
        }
        let Some(begin) = &self.memories.begin else { return Err(Undefined) };
        self.workspace.linearised = None;
        self.workspace.cached = Cached::No;
        self.trial.accepted.clone_from(begin);
        input::evaluate(self.model, self.signals, t, self.values);
        let work = self.workspace.work;
        let at = Evaluation { t, inputs: self.values, y, memory: &mut self.trial.accepted };
        let done = self.model.derivative(self.workspace, at, self.again);
        keep(&mut self.failure, done)?;
        self.model.linearise(self.workspace, (y, &self.trial.accepted), self.values, part == StiffPart::All);
        self.find_drift(t, y, part);
        self.workspace.work = work;
        self.workspace.linearised = Some(t);
        self.rollback();
        Ok(())
    }

    fn factorise(&mut self, a: f64) -> Result<(), Undefined> {
        let clock = self.workspace.timers.start();
        let done = self.model.factorise(self.workspace, a).map_err(|error| self.model.singular_tangent(self.workspace, error));
        self.workspace.timers.stop(Call::Factorise, clock);
        keep(&mut self.failure, done)
    }

    fn solve_linear(&mut self, x: &mut [f64]) {
        let clock = self.workspace.timers.start();
        self.model.solve_linear(self.workspace, x);
        self.workspace.timers.stop(Call::Solve, clock);
    }

    fn solve_linear_pushed(&mut self, x: &mut [f64], weight: f64, push: &[f64]) {
        let clock = self.workspace.timers.start();
        self.model.solve_linear_pushed(self.workspace, x, weight, push);
        self.workspace.timers.stop(Call::Solve, clock);
    }

    fn note_begin(&mut self, t: f64, y: &[f64]) {
        let (slides, flutter) = (self.model.any_slides(self.workspace), &mut *self.watched.flutter);
        self.model.note_vibration(self.workspace, t, y, &mut flutter.vibration);
        if slides && flutter.is_due(t) {
            self.model.linearise(self.workspace, (y, &self.trial.accepted), self.values, false);
            self.model.note_flutter(self.workspace, t, flutter);
        } else if !slides && flutter.is_over(t) {
            self.model.note_flutter(self.workspace, t, flutter);
        }
    }

    fn note_frame(&mut self) -> bool {
        self.model.note_motion(self.workspace)
    }

    fn frame_at(&mut self, ahead: f64, shift: &mut [f64], rate: &mut [f64]) -> bool {
        self.model.frame_at(self.workspace, ahead, shift, rate);
        true
    }

    fn keep_frame(&mut self) {
        self.watched.frame.take_over(self.model.frame_motion(self.workspace));
    }

    fn add_frame_motion(&self, ahead: f64, y: &mut [f64]) {
        self.model.add_frame_motion(self.watched.frame, ahead, y);
    }

    fn frame_change(&mut self, change: &mut [f64]) {
        self.model.frame_change(self.workspace, change);
    }
}
