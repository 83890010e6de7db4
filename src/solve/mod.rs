//! Floor 5: integration of ordinary differential equations. Knows nothing of railways.
//!
//! A system implements [`Dynamics`] and, with a Jacobian or without, [`Implicit`]; an [`Integrator`] advances an [`IntegrationState`]. Steps are the integrator's own: they pass communication points, where the solution is read from the dense
//! output of the last step, so results do not depend on where a master looks. Steps end where the system is not
//! smooth ([`Dynamics::next_break`]). After each step the solution is brought back onto what the system must keep exactly
//! ([`Dynamics::project`]), and the step is cut where the system changes its form ([`Dynamics::event_values`]). What a system remembers beside the
//! solution (warm starts, its form) is its own: it keeps what was accepted and what an attempt has made of it.

mod adaptive;
mod dense;
mod dormand_prince;
mod doubts;
mod events;
mod fixed;
mod generalised_alpha;
mod imex;
mod integrals;
mod local_error;
mod looks;
mod moving_frame;
mod real_time;
mod response;
mod rk4;
mod rk43;
mod rosenbrock;
mod stability;
mod state;
mod zhai;

pub use dormand_prince::DormandPrince;
pub use doubts::Doubts;
pub use generalised_alpha::GeneralisedAlpha;
pub use real_time::RealTime;
pub use rk4::RungeKutta4;
pub use rk43::RungeKutta43;
pub use rosenbrock::Rosenbrock;
pub use state::{IntegrationState, Statistics};
pub use zhai::Zhai;

use crate::settings::{Entry, Section, SettingsError, choose};
use crate::units::Dimension;
use looks::Looks;
use moving_frame::MovingFrame;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// A system `y' = f(t, y)`.
pub trait Dynamics {
    /// Writes f(t, y) to `dy`.
    ///
    /// # Errors
    /// [`Undefined`] when f is not defined at (t, y); the integrator then tries a shorter step. The system keeps the reason.
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined>;

    /// The same where the next step may begin: what it starts from and finds is wanted again ([`Dynamics::accept`], [`Dynamics::repeat`]).
    ///
    /// # Errors
    /// As [`Dynamics::derivative`].
    fn derivative_at_end(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.derivative(t, y, dy)
    }

    /// What the system remembers beside `y` becomes again what it was when it was accepted last.
    fn rollback(&mut self) {}

    /// What the system remembers beside `y` belongs to the state from now on; with `evaluated` so does the last
    /// [`Dynamics::derivative_at_end`].
    fn accept(&mut self, _evaluated: bool) {}

    /// A step from where the system was accepted with an evaluation last is about to be accepted: what that evaluation started from may be wanted again
    /// ([`Implicit::linearise_again`]).
    fn keep_begin(&mut self) {}

    /// The step that was accepted last has been cut: it ends at `t` in the state `y`, and what it left beyond is to be forgotten.
    fn note_cut(&mut self, _t: f64, _y: &[f64]) {}

    /// Does the system still hold what that evaluation found? Not after another one, a change of the system, or in another system that took
    /// over the state.
    fn is_cached(&self) -> bool {
        false
    }

    /// Makes that evaluation again, to the bit, for the sake of what it finds: it does not count as work.
    ///
    /// # Errors
    /// As [`Dynamics::derivative`].
    fn repeat(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.derivative(t, y, dy)
    }

    /// Weight of the local error of component `i` against the tolerance: 1 for positions and angles in metres and radians,
    /// more where a small error has large consequences, 0 where the error is not controlled.
    fn error_weight(&self, i: usize) -> f64;

    /// The states on which no derivative depends: what is integrated along with the solution.
    fn integrals(&self) -> Range<usize> {
        0..0
    }

    /// The next time after `t` where f is not smooth; infinity when there is none. A prediction is enough: it is
    /// asked for before each step.
    fn next_break(&self, t: f64, y: &[f64]) -> f64;

    /// The longest step that may begin where f was evaluated last, with the result `dy`, s: what lies ahead must be met by evaluations,
    /// because an error estimate knows nothing of what no evaluation has seen.
    fn longest_step(&self, _dy: &[f64]) -> f64 {
        f64::INFINITY
    }

    /// The part of that bound which knows where things are beforehand (a track), without what is foreseen from the motion, s.
    fn longest_known(&self) -> f64 {
        f64::INFINITY
    }

    /// Size [1/s] and damping ratio of the fastest vibration that methods which are explicit in it must follow; zeros where none is known.
    fn fastest_vibration(&self) -> [f64; 2] {
        [0.0; 2]
    }

    /// What an error of the state makes of the forces, near the state that was evaluated last: 1 where it is as large as is allowed.
    fn load_error(&self, _error: &[f64]) -> f64 {
        0.0
    }

    /// The same for what is held against the motion itself or against what is to come of it, whatever the tolerance: it chooses steps, and is no measure of one that is given.
    fn swing_error(&self, _error: &[f64]) -> f64 {
        0.0
    }

    /// Notes that a step has been accepted; f was evaluated last at its end.
    fn note_step(&mut self, _t: f64, _y: &[f64]) {}

    /// How the error of a component counts among positions, in a step that is given: those all alike.
    fn plain_weight(&self, i: usize) -> f64 {
        f64::from(u8::from(self.error_weight(i) > 0.0))
    }

    /// Error of a position from which a fixed step is doubtful, m or rad.
    fn doubtful_error(&self) -> f64 {
        f64::INFINITY
    }

    /// How the state divides: that many coordinates, as many velocities (their time derivatives), then first-order states.
    fn coordinates(&self) -> usize {
        0
    }

    /// Moves `y` onto the constraints that it must satisfy exactly; called at the end of each accepted step. Returns whether
    /// `y` was changed.
    ///
    /// # Errors
    /// [`Undefined`] when there is no such point near `y`.
    fn project(&mut self, _t: f64, _y: &mut [f64]) -> Result<bool, Undefined> {
        Ok(false)
    }

    /// Number of event functions: where one falls below zero the system changes its form.
    fn event_functions(&self) -> usize {
        0
    }

    /// Their values in the last evaluation; infinity where an event can't take place at present.
    fn event_values(&self, _values: &mut [f64]) {}

    /// The event that takes place now, by the last evaluation at `t`: of an event function, or one that was foreseen by
    /// [`Dynamics::next_break`].
    fn due(&self, _t: f64) -> Option<Event> {
        None
    }

    /// Changes the system's form at an event; may change `y`. Returns whether it did.
    ///
    /// # Errors
    /// [`Undefined`] when it can't go on from here.
    fn on_event(&mut self, _event: Event, _t: f64, _y: &mut [f64]) -> Result<bool, Undefined> {
        Ok(false)
    }

    /// Gives up changes of form at `t` that need not be, because the form that they lead to has no solution there; returns whether there was one. Follows
    /// [`Dynamics::rollback`].
    fn refuse(&mut self, _t: f64) -> bool {
        false
    }

    /// Changes the system's form where the present one has no solution beyond `t`; returns whether there is another form.
    ///
    /// # Errors
    /// [`Undefined`] when it can't go on from here.
    fn release(&mut self, _t: f64, _y: &mut [f64]) -> Result<bool, Undefined> {
        Ok(false)
    }
}

/// The number by which a system knows one of its events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event(pub usize);

/// A system with a Jacobian, and perhaps a motion that its solution nearly follows. What says nothing has J = 0 and no such motion.
pub trait Implicit: Dynamics {
    /// Finds J, close to df/dy at (t, y), for [`Implicit::factorise`]. Follows an evaluation of f at the same (t, y) directly, whose
    /// results it may use. J need not be exact: methods that use it keep their order whatever J is, and need it for stability.
    ///
    /// # Errors
    /// [`Undefined`] when it is not defined there.
    fn linearise(&mut self, _t: f64, _y: &[f64], _part: StiffPart) -> Result<(), Undefined> {
        Ok(())
    }

    /// Has J of the begin (t, y) of the last step there again, to the bit, where something else has taken its place. Does not count as work.
    ///
    /// # Errors
    /// [`Undefined`] when it can't be had.
    fn linearise_again(&mut self, _t: f64, _y: &[f64], _part: StiffPart) -> Result<(), Undefined> {
        Err(Undefined)
    }

    /// Factorises I - a J, a in s.
    ///
    /// # Errors
    /// [`Undefined`] when it is singular.
    fn factorise(&mut self, _a: f64) -> Result<(), Undefined> {
        Ok(())
    }

    /// Solves (I - a J) x = x in place. Systems that say nothing have J = 0.
    fn solve_linear(&mut self, _x: &mut [f64]) {}

    /// Solves (I - a J) x = x + weight push in place. Constraints that x fulfils hold for the result whatever `push` is.
    fn solve_linear_pushed(&mut self, x: &mut [f64], weight: f64, push: &[f64]) {
        x.iter_mut().zip(push).for_each(|(x, push)| *x += weight * push);
        self.solve_linear(x);
    }

    /// At the begin (t, y) of a step of a method that does not linearise, directly after an evaluation of f there: looks at what such steps would hide.
    fn note_begin(&mut self, _t: f64, _y: &[f64]) {}

    /// Notes there the motion of [`Implicit::frame_at`]. False where there is none, or one that is linear in time.
    fn note_frame(&mut self) -> bool {
        false
    }

    /// A known motion that the solution nearly follows from the state that was linearised (or noted) last: writes what it has added to the state
    /// `ahead` [s] later (`shift`, zero for 0) and its rate there. False where there is no such motion.
    fn frame_at(&mut self, _ahead: f64, _shift: &mut [f64], _rate: &mut [f64]) -> bool {
        false
    }

    /// Notes that the step for which that motion was asked has been accepted: [`Implicit::add_frame_motion`] speaks of it from now on.
    fn keep_frame(&mut self) {}

    /// Adds that motion, as it was kept, to the state: `ahead` [s] after the begin of the last step.
    fn add_frame_motion(&self, _ahead: f64, _y: &mut [f64]) {}

    /// df/dt + J c' - c'' of that motion c at its begin; df/dt as far as it is known.
    fn frame_change(&mut self, change: &mut [f64]) {
        change.fill(0.0);
    }
}

/// The part of f that J covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StiffPart {
    /// Everything that is fast or may be.
    All,
    /// Normal contact and creep forces alone.
    Contact,
}

/// f is not defined where it was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undefined;

/// An integration stopped.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    #[error("t = {time:.9} s: the system can't be evaluated")]
    Undefined { time: f64 },
    #[error(
        "t = {time:.9} s: a step of {step:.1e} s still misses the tolerance {tolerance:.1e}; loosen solver.tolerance or solver.load_tolerance, or look for a jump in the scene"
    )]
    StepTooSmall { time: f64, step: f64, tolerance: f64 },
    #[error(
        "t = {time:.9} s: the integration has all but stopped: {steps} steps and {rejected} rejected ones for {span:.1e} s. Forces jump to and fro here \
         (a contact that begins and ends, friction that turns round): loosen solver.load_tolerance or solver.tolerance, give the contacts damping, or take an explicit method (rk43) or a fixed step (real_time); where a wheelset goes over or climbs, the run has shown what it can"
    )]
    Crawls { time: f64, steps: u64, rejected: u64, span: f64 },
    #[error("t = {time:.9e} s: a step of {step:.1e} s no longer moves time; start closer to 0 or use a longer step")]
    NoProgress { time: f64, step: f64 },
    #[error("t = {time:.9} s: the system changes its form again and again without moving on")]
    EndlessEvents { time: f64 },
    #[error(
        "t = {time:.9} s: the equations of a step of {step:.1e} s are not solved after {iterations} iterations; reduce solver.step or choose another integrator"
    )]
    NotConverged { time: f64, step: f64, iterations: usize },
    #[error(
        "t = {time:.9} s: the step of {step:.2e} s that ended here is off by {position:.1e} m or rad in position and by {load:.0} times what a step with error control may be off in contact forces; reduce solver.step or choose an integrator with a tolerance"
    )]
    StepTooLong { time: f64, step: f64, position: f64, load: f64 },
    #[error(
        "t = {time:.9} s: a step of {step:.2e} s would pass what the track has ahead without seeing it; reduce solver.step to {longest:.1e} s or less, or choose an integrator with a tolerance"
    )]
    StepPassesTrack { time: f64, step: f64, longest: f64 },
    #[error("t = {time:.9} s: the solution is no longer finite; reduce solver.step (it is {step:.1e} s)")]
    NotFinite { time: f64, step: f64 },
}

/// What the number that governs an integrator means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingKind {
    /// Bound of the weighted local error, m and rad.
    Tolerance,
    /// Step, s.
    Step,
}

/// The number that governs an integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    pub kind: SettingKind,
    pub value: f64,
    /// Smallest and largest value that make sense.
    pub range: (f64, f64),
}

impl Setting {
    /// Of a method that has one.
    pub fn tolerance(&self) -> Option<f64> {
        (self.kind == SettingKind::Tolerance).then_some(self.value)
    }
}

/// A method with its setting.
pub trait Integrator: Send + Sync + Debug {
    /// The number that governs it.
    fn setting(&self) -> Setting;

    /// The same method with another number.
    fn with_setting(&self, value: f64) -> Arc<dyn Integrator>;

    /// Number of vectors of length n that its continuous output needs.
    fn dense_vectors(&self) -> usize;

    /// Number of vectors of length n that it remembers of earlier steps.
    fn record_vectors(&self) -> usize {
        0
    }

    /// Number of vectors of length n that it needs for [`Integrator::take_up`]; 0 where it never does that.
    fn response_vectors(&self) -> usize {
        0
    }

    /// Takes a change of f from `time` within the last step on up into that step (see `response`): f becomes f + push, `push` as it is at `time` and at the end
    /// of the step, linear between them, as far as the state stays what it is. True where that was done; else the step must be made anew
    /// ([`IntegrationState::restart_at`]) and nothing that can be read has changed.
    fn take_up(
        &self,
        _dynamics: &mut dyn Implicit,
        _state: &mut IntegrationState,
        _scratch: &mut Scratch,
        _time: f64,
        _push: [&[f64]; 2],
    ) -> bool {
        false
    }

    /// Does it use Jacobians?
    fn linearises(&self) -> bool {
        false
    }

    /// Are integrals ([`Dynamics::integrals`]) what its stages say, beside the solution by what is stiff?
    fn lags_in_integrals(&self) -> bool {
        false
    }

    /// States that settle faster than this [s] on their own swing up from step to step: of explicit methods with a fixed step.
    fn least_time_constant(&self) -> f64 {
        0.0
    }

    /// What one step costs at most, in words, where that is bounded.
    fn worst_case(&self) -> Option<String> {
        None
    }

    /// A step that ends short of a target by no more than this has reached it, s.
    fn slack(&self) -> f64 {
        0.0
    }

    /// One accepted step, which ends at the next break at the latest: its end on the constraints, and cut where the system changes its form.
    ///
    /// # Errors
    /// [`SolveError`]; the state then stands at the last successful step.
    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError>;

    /// A state at (t, y); the first step length is found when it is needed.
    fn start(&self, t: f64, y: &[f64]) -> IntegrationState {
        let mut state = IntegrationState::new(t, y, self.dense_vectors(), self.record_vectors());
        state.response = response::Response::new(self.response_vectors() * y.len());
        state
    }

    /// One step, or a change of the system's form where it has no solution further on.
    ///
    /// # Errors
    /// [`SolveError`]; the state then stands at the last successful step.
    fn advance_once(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        // A change of form may lead to where the new one has no solution.
        if let Err(error) = state.begin(dynamics, scratch).and_then(|()| self.step(dynamics, state, scratch))
            && !state.release(dynamics, scratch, error)?
        {
            return Err(error);
        }
        Ok(())
    }

    /// Advances until the state reaches `target` or passes it; [`IntegrationState::interpolate`] then gives the
    /// solution at `target`.
    ///
    /// # Errors
    /// [`SolveError`]; the state then stands at the last successful step.
    fn advance(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        target: f64,
    ) -> Result<(), SolveError> {
        while state.t < target - self.slack() {
            self.advance_once(dynamics, state, scratch)?;
        }
        // An event at the target itself is over when the solution is read there.
        if state.t <= target { state.begin(dynamics, scratch) } else { Ok(()) }
    }
}

/// Vectors that a step works in; nothing in here outlives it.
#[derive(Clone, Debug)]
pub struct Scratch {
    stages: [Vec<f64>; 9],
    frame: MovingFrame,
    trial: Vec<f64>,
    looks: Looks,
    /// Those at an event that is being located.
    at_event: Vec<f64>,
}

impl Scratch {
    /// For so many states and event functions.
    pub fn new(dimension: usize, events: usize) -> Self {
        let zero = || vec![0.0; dimension];
        Scratch {
            stages: std::array::from_fn(|_| zero()),
            frame: MovingFrame::new(dimension),
            trial: zero(),
            looks: Looks::new(events),
            at_event: vec![f64::INFINITY; events],
        }
    }
}

type Parse = fn(&Section) -> Result<Arc<dyn Integrator>, SettingsError>;

/// Every integrator that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[
    dormand_prince::ENTRY,
    rk43::ENTRY,
    rk4::ENTRY,
    rosenbrock::ENTRY,
    imex::ENTRY,
    generalised_alpha::ENTRY,
    zhai::ENTRY,
    real_time::ENTRY,
    AUTO,
];

/// Leaves the choice to the scene.
pub const AUTO: Entry<Parse> = Entry {
    name: "auto",
    summary: "chosen from the scene by `tolerance` (or `step`); `wheelrail plan` says which one and why",
    reference: "docs/scene.md",
    parse: |section| Err(section.error("integrator", "\"auto\" stands in a scene only; expected a method's name")),
};

/// Reads `[solver]`. `automatic`: the method that "auto" stands for, as does a scene that names none.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section, automatic: &str) -> Result<Chosen, SettingsError> {
    let named = if section.has("integrator") { choose(REGISTRY, section, "integrator")? } else { &AUTO };
    let chosen = REGISTRY.iter().find(|entry| entry.name == automatic).filter(|_| named.name == AUTO.name);
    let entry = chosen.unwrap_or(named);
    // Each method takes those that it needs; the others may stay for the next choice.
    section.optional("tolerance", Dimension::Length)?;
    section.optional("step", Dimension::Time)?;
    section.optional("rho_infinity", Dimension::None)?;
    Ok(Chosen { name: entry.name, integrator: (entry.parse)(section)?, automatic: named.name == AUTO.name })
}

/// The method of a scene.
pub struct Chosen {
    pub name: &'static str,
    pub integrator: Arc<dyn Integrator>,
    /// Did the scene leave the choice to the program?
    pub automatic: bool,
}

/// Tolerance [m] of a scene that gives neither a tolerance nor a step: that of this program's vehicles.
pub const DEFAULT_TOLERANCE: f64 = 1e-5;

/// Reads the number that governs a method and checks its range.
fn parse_setting(
    section: &Section,
    key: &'static str,
    dimension: Dimension,
    (smallest, largest): (f64, f64),
) -> Result<f64, SettingsError> {
    let value = match key == "tolerance" && !section.has(key) && !section.has("step") {
        true => DEFAULT_TOLERANCE,
        false => section.number(key, dimension)?,
    };
    if (smallest..=largest).contains(&value) {
        return Ok(value);
    }
    Err(section.error(key, format!("found {value:?}, expected {smallest:?} to {largest:?}")))
}

#[cfg(test)]
mod test_systems;
#[cfg(test)]
mod tests;
