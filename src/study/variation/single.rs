//! One run of a sweep: how it ended, and its scalars. Whatever goes wrong is its result.

use super::scalar::Scalar;
use crate::scene::improbable::improbable;
use crate::scene::load;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::pattern::matches;
use crate::sim::recording::{self, Recording, Times};
use crate::sim::vehicle_outputs::scene_outputs;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    Ok,
    Derailed,
    /// It could not go on.
    Failed,
    /// The scene was refused, or has no start.
    Refused,
}

impl State {
    pub const ALL: [State; 4] = [State::Ok, State::Derailed, State::Failed, State::Refused];

    pub fn word(self) -> &'static str {
        match self {
            State::Ok => "ok",
            State::Derailed => "derailed",
            State::Failed => "failed",
            State::Refused => "refused",
        }
    }
}

/// What is kept of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub state: State,
    /// Time that was reached, s.
    pub time: Option<f64>,
    /// Why it did not come to its end; of a run that did, what is noted of it.
    pub reason: String,
    /// Of the rows until then.
    pub scalars: Vec<Option<f64>>,
}

impl Outcome {
    fn refused(reason: String, scalars: &[Scalar]) -> Outcome {
        Outcome { state: State::Refused, time: None, reason, scalars: vec![None; scalars.len()] }
    }
}

/// Stop time and output step that are asked for, s; else the scene's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asked {
    pub stop: Option<f64>,
    pub step: Option<f64>,
}

/// Runs a scene with changes; `None` where `go_on` ended it.
pub fn run(scene: &str, changes: &[String], asked: Asked, scalars: &[Scalar], go_on: impl Fn() -> bool) -> Option<Outcome> {
    // A fault of the program in one run must not cost the others.
    let made = catch_unwind(AssertUnwindSafe(|| attempt(scene, changes, asked, scalars, go_on)));
    made.unwrap_or_else(|_| {
        let reason = "an internal error of the program (its message is on stderr)".into();
        Some(Outcome { state: State::Failed, time: None, reason, scalars: vec![None; scalars.len()] })
    })
}

fn attempt(scene: &str, changes: &[String], asked: Asked, scalars: &[Scalar], go_on: impl Fn() -> bool) -> Option<Outcome> {
    let refused = |error: &dyn std::fmt::Display| Some(Outcome::refused(error.to_string(), scalars));
    let scene = match load::open(scene, changes) {
        Ok(scene) => scene,
        Err(error) => return refused(&error),
    };
    let times = Times { stop: asked.stop.unwrap_or(scene.run.stop), step: asked.step.unwrap_or(scene.run.step) };
    let mut simulation = match Simulation::new(&scene, 0.0) {
        Ok(simulation) => simulation,
        Err(error) => return refused(&error),
    };
    let mut outputs = scene_outputs(&scene, simulation.model());
    outputs.retain(|output| scalars.iter().any(|scalar| matches(&scalar.pattern, &output.name)));
    let done =
        recording::record_while(
            &mut simulation,
            &outputs,
            times,
            |_| {
                if go_on() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            },
        );
    if !go_on() {
        return None;
    }
    let values = |recording: &Recording| scalars.iter().map(|scalar| scalar.of(recording)).collect();
    let time = Some(simulation.time());
    Some(match done {
        Ok(recording) => Outcome { state: State::Ok, time, reason: remarks(&scene, &simulation, &recording), scalars: values(&recording) },
        Err(early) => {
            let state = if early.error.is_derailed() { State::Derailed } else { State::Failed };
            Outcome { state, time, reason: early.error.to_string(), scalars: values(&early.recording) }
        }
    })
}

/// What a run that came to its end notes: sizes that look like slips of units, wheels that unload or strike their rail, steps that are
/// doubtful.
fn remarks(scene: &Scene, simulation: &Simulation, recording: &Recording) -> String {
    let mut all = improbable(scene, simulation.model());
    all.extend(recording.all_notes(simulation));
    all.extend(Some(simulation.doubts()).filter(|doubts| doubts.steps > 0).map(|doubts| doubts.to_string()));
    all.join("; ")
}
