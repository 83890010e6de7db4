//! Where the time of a whole run goes: contact search, laws of contact, multibody system, Jacobians, linear systems, integrator, outputs.
//!
//! The run is the scene's, with its integrator and all its outputs at equal intervals, and written as CSV (into memory). What the
//! integrator asks of the model is timed by the workspace's [`Timers`], cleared of the clocks' own time; what is left of the time between
//! two outputs is the integrator's own. What a right-hand side and a Jacobian consist of is measured on evaluations out of that run, made again
//! in parts (see [`anatomy`]); what `wheelrail plan` shows of the initial state is counted ([`counted`]). The shortest of several runs counts.

pub mod anatomy;
pub mod counted;

use crate::formulation::timers::{CALLS, Call, Timers};
use crate::scene::spec::Scene;
use crate::sim::recording::{Recording, Times, communication_points};
use crate::sim::vehicle_outputs::scene_outputs;
use crate::sim::{Simulation, SimulationState};
use crate::solve::{SettingKind, Statistics};
use crate::study::digits::rounded;
use anatomy::{Anatomy, Sample};
use serde::Serialize;
use std::fmt::{Display, Formatter};
use std::time::Instant;

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

/// Groups of parts in their order, in words; of a group that is one part its words say it all.
const GROUPS: [(&str, &[(Part, &str)]); 6] = [
    (
        "right-hand sides",
        &[
            (Part::ContactSearch, "contact search: places, surfaces there, slip"),
            (Part::NormalLaw, "normal law with patch and damping"),
            (Part::CreepLaw, "creep law"),
            (Part::Track, "track: where bodies are along the curve"),
            (Part::Forces, "multibody: motion of bodies, force elements"),
            (Part::EquationsOfMotion, "multibody: equations of motion with joints"),
            (Part::ContactAndEquations, "contact search, constraints, equations of motion"),
        ],
    ),
    ("Jacobians", &[(Part::JacobianContacts, "contacts, and putting it together"), (Part::JacobianForces, "force elements")]),
    ("linear systems", &[(Part::Factorisation, "factorisations"), (Part::LinearSystems, "solving with them")]),
    ("projection onto constraints, events", &[(Part::Constraints, "")]),
    ("integrator: stages, moving frame, error norm, step control, continuous output", &[(Part::Integrator, "")]),
    (
        OUTPUTS,
        &[(Part::ReadingOutputs, "an evaluation at each output time, and reading them"), (Part::WritingOutputs, "writing them as CSV")],
    ),
];
const OUTPUTS: &str = "outputs";

impl Part {
    /// What it is.
    pub fn words(self) -> &'static str {
        GROUPS.iter().flat_map(|group| group.1).find(|one| one.0 == self).map_or("", |one| one.1)
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

/// No further repetition when all have taken longer, s.
const LONG: f64 = 20.0;
/// At most so many evaluations are made again.
const SAMPLES: usize = 60;

/// Seconds of the parts of one run.
#[derive(Clone, Copy, Debug, Default)]
struct Seconds {
    calls: [f64; CALLS],
    own: f64,
    reading: f64,
    writing: f64,
}

impl Seconds {
    fn sum(&self) -> f64 {
        self.calls.iter().sum::<f64>() + self.own + self.reading + self.writing
    }

    /// Takes the clocks' own time, of which `inside` falls into each call's, off the calls and off what is left for the integrator of the time
    /// of `advancing`.
    fn cleared(mut self, timers: &Timers, advancing: f64, [inside, all]: [f64; 2]) -> Seconds {
        self.own = advancing;
        for (seconds, tally) in self.calls.iter_mut().zip(timers.tallies()) {
            let (count, time) = (tally.count as f64, tally.time.as_secs_f64());
            *seconds = (time - inside * count).max(0.0);
            self.own -= time + (all - inside) * count;
        }
        Seconds { own: self.own.max(0.0), ..self }
    }
}

/// A simulation that is run again and again from its start.
struct Runner {
    simulation: Simulation,
    start: SimulationState,
    outputs: Vec<crate::sim::outputs::Output>,
    span: Times,
}

impl Runner {
    fn new(scene: &Scene, span: Times) -> Result<Runner, String> {
        let simulation = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
        let (start, outputs) = (simulation.state().clone(), scene_outputs(scene, simulation.model()));
        Ok(Runner { simulation, start, outputs, span })
    }

    /// Runs with these clocks, which are left in the simulation; returns the time of advancing, and those of outputs. `look` is shown the
    /// simulation at each output time.
    fn run(&mut self, timers: Timers, mut look: impl FnMut(&mut Simulation)) -> Result<(f64, Seconds), String> {
        if !self.simulation.restore(&self.start) {
            return Err("the initial state does not fit its own simulation".into());
        }
        *self.simulation.timers() = timers;
        let mut recording = Recording::new(&self.outputs);
        let (mut advancing, mut times) = (0.0, Seconds::default());
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let words = |error: crate::sim::SimulationError| error.to_string();
        recording.sample(&mut self.simulation, &self.outputs).map_err(words)?;
        times.reading += lap();
        for time in communication_points(0.0, self.span.stop, self.span.step) {
            self.simulation.advance(time).map_err(words)?;
            advancing += lap();
            recording.sample(&mut self.simulation, &self.outputs).map_err(words)?;
            times.reading += lap();
            look(&mut self.simulation);
            lap();
        }
        let mut text = Vec::new();
        recording.write_csv(&mut text).map_err(|error| error.to_string())?;
        std::hint::black_box(&text);
        times.writing = lap();
        self.simulation.take_events();
        Ok((advancing, times))
    }
}

/// Runs `scene` several times with and without clocks; see the module.
///
/// # Errors
/// In words, when the scene can't be started or the run does not come to its end.
pub fn shares(scene: &Scene, span: Times, repeats: usize) -> Result<Shares, String> {
    let mut runner = Runner::new(scene, span)?;
    runner.run(Timers::default(), |_| ())?;
    let statistics = runner.simulation.statistics();
    let step = span.stop / statistics.steps.max(1) as f64;
    let every = ((span.stop / span.step) as usize).div_ceil(SAMPLES).max(1);
    let (mut samples, mut seen) = (Vec::new(), 0);
    runner.run(Timers::default(), |simulation| {
        seen += 1;
        let coordinates = crate::mbs::body::COORDINATES * simulation.model().system.bodies.len();
        if let (true, Ok(snapshot)) = (seen % every == 0, simulation.snapshot()) {
            samples.push(Sample::behind(snapshot, coordinates, step));
        }
    })?;
    let (begin, clocks) = (Instant::now(), Timers::own_time());
    let (mut best, mut seconds): (Option<Seconds>, f64) = (None, f64::INFINITY);
    for round in 0..repeats.max(1) {
        if round > 0 && begin.elapsed().as_secs_f64() > LONG {
            break;
        }
        let (advancing, plain) = runner.run(Timers::default(), |_| ())?;
        seconds = seconds.min(advancing + plain.sum());
        let (advancing, times) = runner.run(Timers::running(), |_| ())?;
        let times = times.cleared(runner.simulation.timers(), advancing, clocks);
        best = Some(best.filter(|best| best.sum() < times.sum()).unwrap_or(times));
    }
    let times = best.unwrap_or_default();
    let mut anatomy = Anatomy::of(runner.simulation.model(), &samples, scene.solver.integrator.linearises());
    if !runner.simulation.timers().forces {
        anatomy.jacobian = anatomy.jacobian_contacts;
    }
    let setting = scene.solver.integrator.setting();
    let doubt = anatomy.doubt().map(|reason| format!("not to be trusted: {reason}; repeat it on a quiet machine"));
    Ok(Shares {
        scene: scene.name.clone(),
        formulation: scene.contact.formulation_name,
        integrator: scene.solver.name,
        setting: setting.value,
        fixed: setting.kind == SettingKind::Step,
        stop: span.stop,
        step: span.step,
        outputs: runner.outputs.len(),
        seconds,
        watched: times.sum(),
        statistics,
        shares: divide(&times, &anatomy),
        doubt,
    })
}

/// All parts, with the times of right-hand sides and Jacobians divided as their anatomy says.
fn divide(times: &Seconds, anatomy: &Anatomy) -> Vec<Share> {
    let call = |call: Call| times.calls[call as usize];
    let parts = anatomy.right_hand_side();
    let all: f64 = parts.iter().map(|part| part.1).sum();
    let scale = if all > 0.0 { call(Call::Derivative) / all } else { 0.0 };
    let [jacobians, forces] = [call(Call::Linearise), anatomy.of_forces()];
    let others = [
        (Part::JacobianContacts, jacobians * (1.0 - forces)),
        (Part::JacobianForces, jacobians * forces),
        (Part::Factorisation, call(Call::Factorise)),
        (Part::LinearSystems, call(Call::Solve)),
        (Part::Constraints, call(Call::Keep)),
        (Part::Integrator, times.own),
        (Part::ReadingOutputs, times.reading),
        (Part::WritingOutputs, times.writing),
    ];
    let seconds = parts.into_iter().map(|(part, seconds)| (part, scale * seconds)).chain(others);
    seconds.map(|(part, seconds)| Share { part, share: seconds / times.sum() }).collect()
}

impl Shares {
    /// Of several parts.
    fn of(&self, parts: &[(Part, &str)]) -> f64 {
        let own = |share: &&Share| parts.iter().any(|part| part.0 == share.part);
        self.shares.iter().filter(own).map(|share| share.share).sum()
    }
}

impl Display for Shares {
    fn fmt(&self, out: &mut Formatter) -> std::fmt::Result {
        let setting =
            if self.fixed { format!("step {} ms", rounded(1e3 * self.setting)) } else { format!("tolerance {:.0e}", self.setting) };
        let factor = self.stop / self.seconds;
        let factor = if factor < 9.95 { format!("{factor:.2}") } else { format!("{factor:.0}") };
        let [plain, watched] = [self.seconds, self.watched].map(|seconds| 1e3 * seconds / self.stop);
        let (outputs, step, work) = (self.outputs, rounded(1e3 * self.step), self.statistics);
        writeln!(
            out,
            "Where the time of a run goes: {}, {}, {}, {setting}\n\
             {} s with {outputs} outputs every {step} ms: {plain:.2} ms per simulated second, {factor} times real time ({watched:.2} ms under clocks)\n\
             {} steps, {} rejected, {} evaluations of the right-hand side, {} Jacobians, {} factorisations\n  of all  without outputs",
            self.scene,
            self.formulation,
            self.integrator,
            self.stop,
            work.steps,
            work.rejected,
            work.evaluations,
            work.linearisations,
            work.factorisations
        )?;
        let integration = 1.0 - self.of(GROUPS[GROUPS.len() - 1].1);
        for (group, parts) in GROUPS {
            let mut line = |share: f64, words: &str| match group {
                OUTPUTS => writeln!(out, "  {:5.1} %                 {words}", 100.0 * share),
                _ => writeln!(out, "  {:5.1} %       {:5.1} %    {words}", 100.0 * share, 100.0 * share / integration),
            };
            if self.of(parts) > 0.0 {
                line(self.of(parts), group)?;
            }
            for (part, words) in parts.iter().filter(|part| !part.1.is_empty()) {
                let share = self.of(&[(*part, words)]);
                // Too small to be measured is not the same as absent.
                if share > 0.0 || matches!(part, Part::NormalLaw | Part::CreepLaw | Part::Forces) {
                    line(share, &format!("    {words}"))?;
                }
            }
        }
        self.doubt.as_ref().map_or(Ok(()), |doubt| writeln!(out, "  {doubt}"))
    }
}

#[cfg(test)]
mod tests;
