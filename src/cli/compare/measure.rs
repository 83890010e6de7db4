//! Runs one scene with one formulation after the other: recorded, recorded again with a finer integration, and timed without
//! outputs.

use super::quantity::{GROUPS, Samples};
use crate::cli::progress::Progress;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::outputs::outputs;
use crate::sim::recording::{self, Interrupted, Times};
use crate::solve::SettingKind;
use crate::study::accuracy::{Measured, cpu_time};

/// Timed runs of each formulation; the median counts.
pub(super) const ROUNDS: usize = 3;

/// One formulation and what became of it.
pub(super) struct Run {
    pub name: &'static str,
    pub summary: &'static str,
    /// `None` when the formulation could not be started.
    pub scene: Option<Scene>,
    /// Are contacts constraints (rigid), not springs (elastic)?
    pub rigid: Option<bool>,
    /// Until the failure where there was one.
    pub samples: Samples,
    /// The same with a finer integration.
    pub refined: Option<Samples>,
    pub cost: Option<Measured>,
    pub failure: Option<String>,
}

impl Run {
    /// Records a scene under its formulation and once more with a finer integration; `scene` may be why there is none.
    pub(super) fn new(name: &'static str, summary: &'static str, scene: Result<Scene, String>, times: Times, progress: &Progress) -> Run {
        let samples = Samples::default();
        let mut run = Run { name, summary, scene: None, rigid: None, samples, refined: None, cost: None, failure: None };
        let started = scene.and_then(|scene| Ok((Simulation::new(&scene, 0.0).map_err(|error| error.to_string())?, scene)));
        match started {
            Err(failure) => run.failure = Some(failure),
            Ok((mut simulation, scene)) => {
                run.rigid = Some(simulation.model().formulation.constrains());
                (run.samples, run.failure) = sample(&mut simulation, times, progress);
                if run.finished() {
                    let finer = finer(&scene).and_then(|finer| Simulation::new(&finer.0, 0.0).ok());
                    run.refined =
                        finer.map(|mut finer| sample(&mut finer, times, progress)).filter(|done| done.1.is_none()).map(|done| done.0);
                }
                run.scene = Some(scene);
            }
        }
        run
    }

    pub(super) fn finished(&self) -> bool {
        self.failure.is_none()
    }

    /// That it ended early, and why; `None` where it ran to its end.
    pub(super) fn broken_off(&self) -> Option<String> {
        self.failure.as_ref().map(|failure| format!("{} ended early: {failure}", self.name))
    }

    /// A run without outputs, for its cost.
    fn time(&mut self, stop: f64) -> Result<(), String> {
        let Some(scene) = self.scene.as_ref().filter(|_| self.failure.is_none()) else { return Ok(()) };
        let mut simulation = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
        let (advanced, seconds) = cpu_time(|| simulation.advance(stop));
        advanced.map_err(|error| error.to_string())?;
        let (statistics, work) = (simulation.statistics(), simulation.state().work);
        let cost = self.cost.get_or_insert(Measured { cpu: vec![], statistics, work });
        cost.cpu.push(seconds / stop);
        cost.cpu.sort_by(f64::total_cmp);
        Ok(())
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

/// Times runs. The formulations take turns, so that a machine that slows down slows all of them.
pub(super) fn time(runs: &mut [Run], stop: f64, progress: &Progress) {
    for _ in 0..ROUNDS {
        for run in runs.iter_mut() {
            if let Err(failure) = run.time(stop) {
                run.failure = Some(failure);
            }
            progress.add(stop);
        }
    }
}
