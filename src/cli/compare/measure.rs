//! Runs one scene with one formulation after the other: recorded, recorded again with a finer integration, and timed without
//! outputs.

use super::quantity::{GROUPS, Samples};
use crate::cli::progress::Progress;
use crate::formulation::work::Work;
use crate::scene::spec::Scene;
use crate::sim::outputs::outputs;
use crate::sim::recording::{self, Interrupted};
use crate::sim::{Simulation, SimulationError};
use crate::solve::{SettingKind, Statistics};
use crate::study::accuracy::cpu_time;

/// Timed runs of each formulation; the median counts.
pub(super) const ROUNDS: usize = 3;

/// Stop time and interval of the samples, s.
#[derive(Clone, Copy)]
pub(super) struct Times {
    pub stop: f64,
    pub step: f64,
}

/// What a formulation cost.
pub(super) struct Cost {
    /// CPU time of each timed run, s, ascending.
    pub seconds: Vec<f64>,
    pub statistics: Statistics,
    pub work: Work,
}

impl Cost {
    /// CPU time of the run, s.
    pub(super) fn median(&self) -> f64 {
        self.seconds.get(self.seconds.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// One formulation and what became of it.
pub(super) struct Run {
    pub name: &'static str,
    pub summary: &'static str,
    /// Are contacts constraints (rigid), not springs (elastic)? `None` when the formulation could not be started.
    pub rigid: Option<bool>,
    /// Until the failure where there was one.
    pub samples: Samples,
    /// The same with a finer integration.
    pub refined: Option<Samples>,
    pub cost: Option<Cost>,
    pub failure: Option<String>,
}

impl Run {
    /// A formulation that could not be started.
    pub(super) fn failed(name: &'static str, summary: &'static str, failure: String) -> Run {
        Run { name, summary, rigid: None, samples: Samples::default(), refined: None, cost: None, failure: Some(failure) }
    }

    pub(super) fn finished(&self) -> bool {
        self.failure.is_none()
    }
}

/// What was sampled until the end or until it failed, and why it failed.
fn sample(simulation: &mut Simulation, times: Times, progress: &Progress) -> (Samples, Option<String>) {
    let outputs = outputs(simulation.model(), &GROUPS);
    let done = recording::record(simulation, &outputs, times.stop, times.step, |time| progress.at(time));
    progress.add(times.stop);
    let (recording, failure) = match done {
        Ok(recording) => (recording, None),
        Err(Interrupted { recording, error }) => (recording, Some(error.to_string())),
    };
    (Samples::new(recording, simulation.model()), failure)
}

/// Records the scene under its formulation and once more with a finer integration.
pub(super) fn record(name: &'static str, summary: &'static str, scene: &Scene, times: Times, progress: &Progress) -> Run {
    let mut simulation = match Simulation::new(scene, 0.0) {
        Ok(simulation) => simulation,
        Err(error) => return Run::failed(name, summary, error.to_string()),
    };
    let rigid = Some(simulation.model().formulation.constrains());
    let (samples, failure) = sample(&mut simulation, times, progress);
    let refined = || -> Option<Samples> {
        let (samples, failure) = sample(&mut Simulation::new(&finer(scene)?.0, 0.0).ok()?, times, progress);
        failure.is_none().then_some(samples)
    };
    let refined = if failure.is_none() { refined() } else { None };
    Run { name, summary, rigid, samples, refined, cost: None, failure }
}

/// The scene with a finer integration, and how that is written in a scene; `None` when it can't be finer.
pub(super) fn finer(scene: &Scene) -> Option<(Scene, String)> {
    let setting = scene.solver.integrator.setting();
    let (key, factor) = match setting.kind {
        SettingKind::Tolerance => ("tolerance", 1e-2),
        SettingKind::Step => ("step", 0.25),
    };
    let value = (factor * setting.value).max(setting.range.0);
    (value < setting.value).then(|| {
        let mut finer = scene.clone();
        finer.solver.integrator = scene.solver.integrator.with_setting(value);
        (finer, format!("solver.{key} = {value:.0e}"))
    })
}

/// Times runs without outputs. The formulations take turns, so that a machine that slows down slows all of them.
pub(super) fn time(runs: &mut [(Run, Option<Scene>)], stop: f64, progress: &Progress) {
    for _ in 0..ROUNDS {
        for (run, scene) in runs.iter_mut() {
            if let (true, Some(scene)) = (run.finished(), scene) {
                match timed(scene, stop) {
                    Ok(cost) => match &mut run.cost {
                        Some(known) => known.seconds.extend(cost.seconds),
                        None => run.cost = Some(cost),
                    },
                    Err(error) => run.failure = Some(error.to_string()),
                }
            }
            progress.add(stop);
        }
    }
    for cost in runs.iter_mut().filter_map(|(run, _)| run.cost.as_mut()) {
        cost.seconds.sort_by(f64::total_cmp);
    }
}

fn timed(scene: &Scene, stop: f64) -> Result<Cost, SimulationError> {
    let mut simulation = Simulation::new(scene, 0.0)?;
    let (advanced, seconds) = cpu_time(|| simulation.advance(stop));
    advanced?;
    Ok(Cost { seconds: vec![seconds], statistics: simulation.statistics(), work: simulation.state().work })
}
