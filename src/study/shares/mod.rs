//! Where the time of a whole run goes: contact search, laws of contact, multibody system, Jacobians, linear systems, integrator, outputs.
//!
//! The run is the scene's, with its integrator and all its outputs at equal intervals, and written as CSV (into memory). What the
//! integrator asks of the model is timed around each call (see [`watch`]); what is left of the time between two outputs is the
//! integrator's own: sums of stages, carried motion, error norm, step control, continuous output. What a right-hand side and a Jacobian consist of is
//! measured on evaluations out of that run, made again in parts (see [`replay`]).
//!
//! Each call's time is cleared of the clock's own. The run is repeated; each part counts with its shortest time, and all parts
//! together are the whole.

mod again;
mod replay;
mod watch;
mod words;

use crate::scene::spec::Scene;
use crate::sim::recording::{Recording, communication_points};
use crate::sim::vehicle_outputs::scene_outputs;
use crate::sim::{Simulation, SimulationState};
use crate::solve::Statistics;
use replay::{Replay, replay};
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;
use watch::{CALLS, Shared, Tally, Watched, own_time};

/// A part of the work of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    ContactSearch,
    NormalLaw,
    CreepLaw,
    Track,
    Forces,
    EquationsOfMotion,
    /// Search, constraints and equations of motion, which constraint formulations solve together.
    ContactAndEquations,
    JacobianContacts,
    JacobianForces,
    Factorisation,
    LinearSystems,
    Constraints,
    Integrator,
    ReadingOutputs,
    WritingOutputs,
}

/// What parts belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    RightHandSides,
    Jacobians,
    LinearSystems,
    Constraints,
    Integrator,
    Outputs,
}

impl Group {
    pub const ALL: [Group; 6] =
        [Group::RightHandSides, Group::Jacobians, Group::LinearSystems, Group::Constraints, Group::Integrator, Group::Outputs];
}

impl Part {
    pub const ALL: [Part; 15] = [
        Part::ContactSearch,
        Part::NormalLaw,
        Part::CreepLaw,
        Part::Track,
        Part::Forces,
        Part::EquationsOfMotion,
        Part::ContactAndEquations,
        Part::JacobianContacts,
        Part::JacobianForces,
        Part::Factorisation,
        Part::LinearSystems,
        Part::Constraints,
        Part::Integrator,
        Part::ReadingOutputs,
        Part::WritingOutputs,
    ];

    pub fn group(self) -> Group {
        match self {
            Part::ContactSearch
            | Part::NormalLaw
            | Part::CreepLaw
            | Part::Track
            | Part::Forces
            | Part::EquationsOfMotion
            | Part::ContactAndEquations => Group::RightHandSides,
            Part::JacobianContacts | Part::JacobianForces => Group::Jacobians,
            Part::Factorisation | Part::LinearSystems => Group::LinearSystems,
            Part::Constraints => Group::Constraints,
            Part::Integrator => Group::Integrator,
            Part::ReadingOutputs | Part::WritingOutputs => Group::Outputs,
        }
    }
}

/// One part of the time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    pub part: Part,
    /// Of the whole; all shares of a run together are 1.
    pub share: f64,
}

/// Where the time of a run goes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shares {
    pub scene: String,
    pub formulation: &'static str,
    pub integrator: &'static str,
    /// Tolerance [m] or step [s].
    pub setting: f64,
    /// Is `setting` a step?
    pub fixed: bool,
    /// Simulated time, distance of the output times, s.
    pub stop: f64,
    pub step: f64,
    /// Outputs at each of these times.
    pub outputs: usize,
    /// Shortest time of the run with its outputs, s.
    pub seconds: f64,
    /// The same with the clocks, cleared of their time: the sum of all parts, s.
    pub watched: f64,
    pub statistics: Statistics,
    /// In the order of the parts; a part that the run does not have has the share 0.
    pub shares: Vec<Share>,
    /// Why the parts can't be trusted, where they were measured as more than the whole.
    pub doubt: Option<String>,
}

impl Shares {
    /// Of a group.
    pub fn of(&self, group: Group) -> f64 {
        self.shares.iter().filter(|share| share.part.group() == group).map(|share| share.share).sum()
    }
}

/// Span of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// s.
    pub stop: f64,
    /// Distance of the output times, s.
    pub step: f64,
}

/// No further repetition when all have taken longer, s.
const LONG: f64 = 20.0;

/// Seconds of one run.
#[derive(Clone, Copy, Debug)]
struct Times {
    calls: [f64; CALLS],
    own: f64,
    reading: f64,
    writing: f64,
    /// What was measured as less than nothing, which the parts above do not show.
    clipped: f64,
}

impl Times {
    fn sum(&self) -> f64 {
        self.calls.iter().sum::<f64>() + self.own + self.reading + self.writing
    }

    fn least(self, other: Times) -> Times {
        Times {
            calls: std::array::from_fn(|call| self.calls[call].min(other.calls[call])),
            own: self.own.min(other.own),
            reading: self.reading.min(other.reading),
            writing: self.writing.min(other.writing),
            clipped: self.clipped.max(other.clipped),
        }
    }
}

/// A simulation that is run again and again from its start.
struct Runner {
    simulation: Simulation,
    start: SimulationState,
    outputs: Vec<crate::sim::outputs::Output>,
    span: Span,
}

impl Runner {
    fn new(scene: &Scene, span: Span) -> Result<Runner, String> {
        let simulation = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
        let (start, outputs) = (simulation.state().clone(), scene_outputs(scene, simulation.model()));
        Ok(Runner { simulation, start, outputs, span })
    }

    /// Time of advancing, of reading outputs and of writing them, s.
    fn run(&mut self) -> Result<[f64; 3], String> {
        if !self.simulation.restore(&self.start) {
            return Err("the initial state does not fit its own simulation".into());
        }
        let mut recording = Recording::new(&self.outputs);
        let (mut advancing, mut reading) = (0.0, 0.0);
        let mut clock = Instant::now();
        let mut lap = || {
            let now = Instant::now();
            let seconds = (now - clock).as_secs_f64();
            clock = now;
            seconds
        };
        let words = |error: crate::sim::SimulationError| error.to_string();
        recording.sample(&mut self.simulation, &self.outputs).map_err(words)?;
        reading += lap();
        for time in communication_points(0.0, self.span.stop, self.span.step) {
            self.simulation.advance(time).map_err(words)?;
            advancing += lap();
            recording.sample(&mut self.simulation, &self.outputs).map_err(words)?;
            reading += lap();
        }
        let mut text = Vec::new();
        recording.write_csv(&mut text).map_err(|error| error.to_string())?;
        std::hint::black_box(&text);
        let writing = lap();
        self.simulation.take_events();
        Ok([advancing, reading, writing])
    }
}

/// Runs `scene` several times with and without the watch; see the module.
///
/// # Errors
/// In words, when the scene can't be started or the run does not come to its end.
pub fn shares(scene: &Scene, span: Span, repeats: usize) -> Result<Shares, String> {
    let meter = Shared::default();
    let mut guarded = scene.clone();
    guarded.solver.integrator = Arc::new(Watched { inner: scene.solver.integrator.clone(), meter: meter.clone() });
    let (mut plain, mut watched) = (Runner::new(scene, span)?, Runner::new(&guarded, span)?);
    meter.sample();
    watched.run()?;
    let samples = meter.take_samples();
    meter.take();
    let clock_time = own_time();
    let begin = Instant::now();
    let (mut best, mut seconds): (Option<Times>, f64) = (None, f64::INFINITY);
    for round in 0..repeats.max(1) {
        if round > 0 && begin.elapsed().as_secs_f64() > LONG {
            break;
        }
        let run = watched.run()?;
        let times = cleared(&meter.take(), run, clock_time);
        best = Some(best.map_or(times, |best| best.least(times)));
        seconds = seconds.min(plain.run()?.iter().sum());
    }
    let Some(times) = best else { return Err("there was no run".into()) };
    let parts = replay(scene, &samples, meter.covers_forces())?;
    let setting = scene.solver.integrator.setting();
    Ok(Shares {
        scene: scene.name.clone(),
        formulation: scene.contact.formulation_name,
        integrator: scene.solver.name,
        setting: setting.value,
        fixed: setting.kind == crate::solve::SettingKind::Step,
        stop: span.stop,
        step: span.step,
        outputs: plain.outputs.len(),
        seconds,
        watched: times.sum(),
        statistics: plain.simulation.statistics(),
        shares: divide(&times, &parts),
        doubt: doubt(&times, &parts),
    })
}

/// Takes the clock's own time, of which `inside` falls into each call's, off a run's times.
fn cleared(tallies: &[Tally; CALLS], [advancing, reading, writing]: [f64; 3], [inside, all]: [f64; 2]) -> Times {
    let raw = tallies.map(|tally| tally.time.as_secs_f64());
    let counts = tallies.map(|tally| tally.count as f64);
    let own = advancing - raw.iter().sum::<f64>() - (all - inside) * counts.iter().sum::<f64>();
    let calls: [f64; CALLS] = std::array::from_fn(|call| raw[call] - inside * counts[call]);
    let clipped = calls.iter().chain([&own]).map(|seconds| (-seconds).max(0.0)).sum();
    Times { calls: calls.map(|seconds| seconds.max(0.0)), own: own.max(0.0), reading, writing, clipped }
}

/// Parts of a right-hand side that were measured by themselves, s.
fn apart(replay: &Replay) -> f64 {
    replay.normal + replay.creep + replay.track + replay.forces + replay.equations
}

/// What speaks against the parts: each was measured by itself, so that on a busy machine they may be more than the whole.
fn doubt(times: &Times, replay: &Replay) -> Option<String> {
    /// Of the whole: less than nothing by so little is the clock's noise.
    const NOISE: f64 = 0.01;
    let percent = |part: f64, whole: f64| format!("{:.0} %", 100.0 * part / whole);
    let mut reasons = Vec::new();
    if apart(replay) > replay.whole {
        let sum = percent(apart(replay), replay.whole);
        reasons.push(format!("the parts of a right-hand side were measured as {sum} of it, and nothing is left for the search"));
    }
    if replay.jacobian_forces > replay.jacobian {
        let sum = percent(replay.jacobian_forces, replay.jacobian);
        reasons.push(format!("the force elements of a Jacobian were measured as {sum} of it"));
    }
    if times.clipped > NOISE * times.sum() {
        reasons.push(format!("{} of the run were measured as less than nothing", percent(times.clipped, times.sum())));
    }
    (!reasons.is_empty()).then(|| format!("not to be trusted: {}; repeat it on a quiet machine", reasons.join(", ")))
}

/// All parts, with the times of the calls divided as the replay says.
fn divide(times: &Times, replay: &Replay) -> Vec<Share> {
    let whole = times.sum();
    let [derivatives, jacobians, factorisations, solutions, keeping] = times.calls;
    let Replay { normal, creep, track, forces, equations, .. } = *replay;
    let rest = (replay.whole - apart(replay)).max(0.0);
    // With the measuring errors of the parts the sum may be more than the whole, which `doubt` says.
    let all = apart(replay) + rest;
    let of_derivatives = |part: f64| if all > 0.0 { derivatives * part / all } else { 0.0 };
    let of_forces = if replay.jacobian > 0.0 { (replay.jacobian_forces / replay.jacobian).min(1.0) } else { 0.0 };
    let (search, together) = if replay.equations > 0.0 { (rest, 0.0) } else { (0.0, rest) };
    let seconds = |part: Part| match part {
        Part::ContactSearch => of_derivatives(search),
        Part::NormalLaw => of_derivatives(normal),
        Part::CreepLaw => of_derivatives(creep),
        Part::Track => of_derivatives(track),
        Part::Forces => of_derivatives(forces),
        Part::EquationsOfMotion => of_derivatives(equations),
        Part::ContactAndEquations => of_derivatives(together),
        Part::JacobianContacts => jacobians * (1.0 - of_forces),
        Part::JacobianForces => jacobians * of_forces,
        Part::Factorisation => factorisations,
        Part::LinearSystems => solutions,
        Part::Constraints => keeping,
        Part::Integrator => times.own,
        Part::ReadingOutputs => times.reading,
        Part::WritingOutputs => times.writing,
    };
    Part::ALL.map(|part| Share { part, share: seconds(part) / whole }).to_vec()
}

#[cfg(test)]
mod tests;
