//! One run that is looked at, with what it cost.

use super::observed::{Observed, outputs, watched};
use crate::formulation::work::Work;
use crate::scene::spec::Scene;
use crate::sim::recording::{Recording, Times, communication_points};
use crate::sim::{Simulation, SimulationError};
use crate::solve::Statistics;
use crate::study::accuracy::cpu_time;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// What a run took. Counters are the same in every run of a scene, CPU time is not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    #[serde(flatten)]
    pub statistics: Statistics,
    #[serde(flatten)]
    pub work: Work,
    /// CPU time of the integration without outputs, s: the shorter of two runs where they are short.
    pub cpu: f64,
}

/// Why a run did not come to its end.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Ended {
    /// It can't start.
    Refused(String),
    Failed {
        time: f64,
        derailed: bool,
        reason: String,
    },
    /// The caller wants no more after so many seconds of CPU time; where it was then, in words.
    GivenUp {
        at: String,
        cpu: f64,
    },
}

/// A run that came to its end.
pub(super) struct Ran {
    pub observed: Observed,
    pub cost: Cost,
    /// What its user should know.
    pub notes: Vec<String>,
}

/// A run this short is timed twice, s.
const SHORT: f64 = 0.5;

/// How often a run that is under way is looked at.
const LOOK: Duration = Duration::from_millis(50);
/// A run whose CPU time is not known yet crawls when this many times that has passed: it may have had half a core.
const WAITED: f64 = 2.0;

/// The same in a thread of its own, which is left to itself when it is given up: one step, or the search for the start, may take minutes where a law solves
/// half-spaces. What was left ends at its next output time, or with the process. `crawls` is told CPU time so far [s]; `give_up` is whether others want it to end.
pub(super) fn run_unless(
    scene: Scene,
    span: Times,
    crawls: impl Fn(f64) -> bool + Send + Copy + 'static,
    give_up: &dyn Fn() -> bool,
) -> Result<Ran, Ended> {
    let left = Arc::new(AtomicBool::new(false));
    let (given_up, (tell, told)) = (left.clone(), mpsc::channel());
    let begin = Instant::now();
    let spawned = std::thread::Builder::new().spawn(move || {
        let ended = run(&scene, span, &|cpu| given_up.load(Ordering::Relaxed) || crawls(cpu));
        // Nobody listens to a run that was left.
        let _ = tell.send(ended);
    });
    if let Err(error) = spawned {
        return Err(Ended::Refused(error.to_string()));
    }
    loop {
        match told.recv_timeout(LOOK) {
            Ok(ended) => return ended,
            Err(RecvTimeoutError::Disconnected) => return Err(Ended::Refused("it broke off".into())),
            Err(RecvTimeoutError::Timeout) => {}
        }
        let waited = begin.elapsed().as_secs_f64();
        if give_up() || crawls(waited / WAITED) {
            left.store(true, Ordering::Relaxed);
            return Err(Ended::GivenUp { at: "within a step".into(), cpu: waited / WAITED });
        }
    }
}

/// Runs a scene to the end; `give_up` is asked at each output time, and told the CPU time so far [s].
pub(super) fn run(scene: &Scene, span: Times, give_up: &dyn Fn(f64) -> bool) -> Result<Ran, Ended> {
    let scene = watched(scene);
    let mut simulation = Simulation::new(&scene, 0.0).map_err(|error| Ended::Refused(error.to_string()))?;
    let outputs = outputs(&scene, simulation.model());
    let (start, mut recording, mut cpu) = (simulation.state().clone(), Recording::new(&outputs), 0.0);
    let failed = |simulation: &Simulation, error: SimulationError| Ended::Failed {
        time: simulation.time(),
        derailed: error.is_derailed(),
        reason: error.to_string(),
    };
    recording.sample(&mut simulation, &outputs).map_err(|error| failed(&simulation, error))?;
    for time in communication_points(0.0, span.stop, span.step) {
        let (advanced, seconds) = cpu_time(|| simulation.advance(time));
        cpu += seconds;
        advanced.map_err(|error| failed(&simulation, error))?;
        recording.sample(&mut simulation, &outputs).map_err(|error| failed(&simulation, error))?;
        if give_up(cpu) {
            return Err(Ended::GivenUp { at: format!("at t = {time:.3} s"), cpu });
        }
    }
    let (observed, notes) = (Observed::new(&recording, simulation.model()), simulation.notes());
    let (statistics, work) = (simulation.statistics(), simulation.state().work);
    if cpu < SHORT && simulation.restore(&start) {
        let (done, again) = cpu_time(|| simulation.advance(span.stop));
        cpu = if done.is_ok() { cpu.min(again) } else { cpu };
    }
    Ok(Ran { observed, cost: Cost { statistics, work, cpu }, notes })
}
