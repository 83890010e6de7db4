//! One run of a scene with one integrator: observed, then repeated without outputs for its cost.

use super::clock::{Interrupted, cpu_time, in_seconds};
use super::observation::{Observation, needed};
use super::request::Request;
use crate::formulation::work::Work;
use crate::scene::spec::Scene;
use crate::sim::recording::{Recording, Times, communication_points};
use crate::sim::{Simulation, SimulationState};
use crate::solve::{self, SettingKind, Statistics};
use crate::study::digits::rounded;
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// An integrator with the number that governs it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    pub integrator: &'static str,
    /// Is `value` a step [s]? Otherwise it is a tolerance [m].
    pub fixed: bool,
    pub value: f64,
}

impl Setting {
    /// "dormand_prince, tolerance 1e-7".
    pub fn words(&self) -> String {
        format!("{}, {} {}", self.integrator, if self.fixed { "step" } else { "tolerance" }, self.number())
    }

    /// "1e-7" or "0.5 ms".
    pub fn number(&self) -> String {
        number(self.fixed, self.value)
    }

    pub fn tolerance(&self) -> Option<f64> {
        (!self.fixed).then_some(self.value)
    }

    pub fn step(&self) -> Option<f64> {
        self.fixed.then_some(self.value)
    }
}

/// A step [s] (`fixed`) or a tolerance [m] in words.
fn number(fixed: bool, value: f64) -> String {
    if fixed { format!("{} ms", rounded(1e3 * value)) } else { format!("{:e}", rounded(value)) }
}

/// An integrator of the registry with any setting; the kind of number that governs it and its range.
pub(super) fn method(name: &str) -> Result<Arc<dyn solve::Integrator>, String> {
    use crate::settings::{Section, Source};
    // Each reads what it needs.
    let text = format!("integrator = \"{name}\"\ntolerance = 1e-7\nstep = 1e-3\n");
    let source = Source { file: "[solver]".into(), text: text.clone(), overridden: vec![], folder: None };
    let document = toml_edit::Document::parse(text).map_err(|error| error.to_string())?;
    let parsed = solve::parse(&Section::root(document.as_table(), &source), name).map_err(|error| error.to_string())?;
    Ok(parsed.integrator)
}

/// Settings of all integrators out of the lists that fit each; and notes of what they do not take of the user's lists.
///
/// # Errors
/// In words, where nothing is left for any method.
pub(super) fn settings(request: &Request) -> Result<(Vec<Setting>, Vec<String>), String> {
    let (mut settings, mut notes, mut wanted) = (Vec::new(), Vec::new(), [false; 2]);
    for name in &request.integrators {
        let taken = method(name)?.setting();
        let (fixed, (least, most)) = (taken.kind == SettingKind::Step, taken.range);
        wanted[usize::from(fixed)] = true;
        let values = if fixed { &request.steps } else { &request.tolerances };
        let (fit, outside): (Vec<f64>, Vec<f64>) = values.iter().partition(|value| (least..=most).contains(*value));
        settings.extend(fit.into_iter().map(|value| Setting { integrator: name, fixed, value }));
        if !outside.is_empty() {
            let what = format!("{}{}", if fixed { "step" } else { "tolerance" }, if outside.len() > 1 { "s" } else { "" });
            let outside: Vec<String> = outside.into_iter().map(|value| number(fixed, value)).collect();
            let [least, most] = [least, most].map(|value| number(fixed, value));
            notes.push((fixed, format!("{name}: {what} {} left out, it takes {least} to {most}", outside.join(", "))));
        }
    }
    if settings.is_empty() {
        let words: Vec<String> = notes.into_iter().map(|note| note.1).collect();
        return Err(format!("no tolerance and no step is left for any method: {}", words.join("; ")));
    }
    for (fixed, what) in [(false, "tolerances"), (true, "steps")] {
        if !wanted[usize::from(fixed)] {
            notes.push((fixed, format!("{what} left out: none of the methods takes one")));
        }
    }
    notes.retain(|note| request.own_lists[usize::from(note.0)]);
    Ok((settings, notes.into_iter().map(|note| note.1).collect()))
}

/// The scene with another integrator.
pub(super) fn with_setting(scene: &Scene, setting: &Setting) -> Result<Scene, String> {
    let mut changed = scene.clone();
    changed.solver.name = setting.integrator;
    changed.solver.integrator = method(setting.integrator)?.with_setting(setting.value);
    Ok(changed)
}

/// A run is foreseen to fail when this share of its time is gone and it seems to need so many times its time: a scene may begin
/// with its hardest part.
const FORESEEN: (f64, f64) = (0.25, 1.5);

/// What became of a run.
#[derive(Clone, Debug)]
pub(super) struct Observed {
    pub observation: Observation,
    /// CPU time of the integration without reading outputs, s.
    pub cpu: f64,
    /// Simulated time that was reached, s.
    pub reached: f64,
    pub failure: Option<String>,
    /// Is the reason that there was no time?
    pub late: bool,
}

/// What is said of a run that the user ended.
pub(super) const INTERRUPTED: &str = "interrupted";

/// Runs and observes; gives up after `limit` seconds, `early` where it can be foreseen. `wheelset`: see [`needed`].
pub(super) fn observe(
    simulation: &mut Simulation,
    wheelset: Option<&str>,
    span: Times,
    (limit, early, interrupted): (f64, bool, Interrupted),
) -> Observed {
    let start = Instant::now();
    let outputs = needed(simulation.model(), wheelset);
    let deadline = in_seconds(limit);
    let mut recording = Recording::new(&outputs);
    let (mut cpu, mut reached, mut late) = (0.0, 0.0, false);
    let mut run = || -> Result<(), String> {
        recording.sample(simulation, &outputs).map_err(|error| error.to_string())?;
        for time in communication_points(0.0, span.stop, span.step) {
            let (advanced, seconds) = cpu_time(|| simulation.advance(time));
            cpu += seconds;
            advanced.map_err(|error| error.to_string())?;
            recording.sample(simulation, &outputs).map_err(|error| error.to_string())?;
            reached = time;
            if interrupted() {
                return Err(INTERRUPTED.into());
            }
            let (spent, expected) = (start.elapsed().as_secs_f64(), start.elapsed().as_secs_f64() * span.stop / time);
            late = early && spent > FORESEEN.0 * limit && expected > FORESEEN.1 * limit;
            if late {
                return Err(format!("given up at t = {time:.3} s: it needs about {expected:.1} s, the budget has {limit:.1} s"));
            }
            late = time < span.stop && deadline.is_some_and(|deadline| Instant::now() > deadline);
            if late {
                return Err(format!("stopped after {limit:.1} s at t = {time:.3} s: the budget has no room for more"));
            }
        }
        Ok(())
    };
    let failure = run().err();
    Observed { observation: Observation::new(&recording, simulation.model()), cpu, reached, failure, late }
}

/// What a finished run cost.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// CPU time of each run per simulated second, ascending.
    pub cpu: Vec<f64>,
    pub statistics: Statistics,
    pub work: Work,
}

impl Measured {
    /// CPU time per simulated second: the median, of an even number of runs the mean of the middle two.
    pub fn median(&self) -> f64 {
        let middle = |place: usize| self.cpu.get(place).copied().unwrap_or(f64::NAN);
        0.5 * (middle(self.cpu.len().saturating_sub(1) / 2) + middle(self.cpu.len() / 2))
    }

    /// Smallest and largest.
    pub fn spread(&self) -> (f64, f64) {
        (self.cpu.first().copied().unwrap_or(f64::NAN), self.cpu.last().copied().unwrap_or(f64::NAN))
    }
}

/// A run longer than this is timed while it is observed, s: reading the clock at each output does not count there.
const LONG: f64 = 0.5;

/// Runs the scene: observes it, and times it `repeats` times, fewer where that takes longer than `patience` seconds.
pub(super) fn measure(
    scene: &Scene,
    wheelset: Option<&str>,
    span: Times,
    repeats: usize,
    [limit, patience]: [f64; 2],
    interrupted: Interrupted,
) -> Result<(Observation, Measured), String> {
    let mut simulation = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
    let start = simulation.state().clone();
    let observed = observe(&mut simulation, wheelset, span, (limit, true, interrupted));
    if let Some(failure) = observed.failure {
        return Err(failure);
    }
    let (statistics, work) = (simulation.statistics(), simulation.state().work);
    let mut cpu: Vec<f64> = if observed.cpu > LONG { vec![observed.cpu / span.stop] } else { Vec::new() };
    // One at least; more as long as they end before the patience does.
    let total = ((patience / observed.cpu).ceil() as usize).saturating_sub(1).clamp(1, repeats.max(1));
    // What was observed counts, and is timed as it was, where the user ends the repetitions.
    let again = |simulation: &mut Simulation| simulation.advance(span.stop).map_err(|error| error.to_string());
    let total = if interrupted() { 1 } else { total };
    cpu.extend(repeated(&mut simulation, &start, span, total.saturating_sub(cpu.len()), again)?);
    cpu.sort_by(f64::total_cmp);
    Ok((observed.observation, Measured { cpu, statistics, work }))
}

/// CPU time per simulated second of so many runs from a start, ascending.
pub(super) fn repeated(
    simulation: &mut Simulation,
    start: &SimulationState,
    span: Times,
    count: usize,
    mut run: impl FnMut(&mut Simulation) -> Result<(), String>,
) -> Result<Vec<f64>, String> {
    let mut seconds = Vec::new();
    while seconds.len() < count {
        if !simulation.restore(start) {
            return Err("the initial state does not fit its own simulation".into());
        }
        let (done, cpu) = cpu_time(|| run(simulation));
        done?;
        seconds.push(cpu / span.stop);
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds)
}
