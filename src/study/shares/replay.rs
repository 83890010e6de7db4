//! Evaluations of a run, made again in parts: what a right-hand side and a Jacobian consist of.
//!
//! Of each kept evaluation (state and warm starts as they were in the run): the whole; the same with a law called again (see
//! [`super::again`]); the stations on a curved track, the bodies' motion with the force elements, and the equations of motion by
//! themselves. Contact search is what is left: places, surfaces' geometry, slip, summing up of wrenches. Constraint formulations
//! solve the equations of motion together with the contacts, so both stay together there. Each part of each evaluation counts with its
//! shortest time: others on the machine make some calls longer, none shorter.

use super::again::{EXTRA, creep_again, normal_again};
use super::watch::Sample;
use crate::formulation::memory::ModelMemory;
use crate::formulation::{Evaluation, Model, Workspace};
use crate::scene::assemble;
use crate::scene::spec::Scene;
use std::hint::black_box;
use std::time::Instant;

/// Times of the parts of all samples together, s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Replay {
    /// Of all of a right-hand side.
    pub whole: f64,
    pub normal: f64,
    pub creep: f64,
    pub track: f64,
    pub forces: f64,
    /// 0 where contacts are constraints.
    pub equations: f64,
    /// Of all of a Jacobian.
    pub jacobian: f64,
    /// Of its force elements.
    pub jacobian_forces: f64,
}

/// Calls per reading of the clock.
const CALLS: u32 = 4;
const ROUNDS: usize = 24;
/// No further evaluation after so long, s, when there are [`FEW`]: the creep law `exact` takes milliseconds.
const LONG: f64 = 2.0;
const FEW: usize = 4;

/// A model and what its evaluations work in.
struct Stage {
    model: Model,
    workspace: Workspace,
    memory: ModelMemory,
    dy: Vec<f64>,
    inputs: Vec<f64>,
}

impl Stage {
    fn new(scene: &Scene) -> Result<Stage, String> {
        let model = assemble::model(scene).map_err(|error| error.to_string())?;
        let mut workspace = model.workspace();
        if scene.solver.integrator.linearises() {
            model.prepare_tangent(&mut workspace);
        }
        let (memory, dy, inputs) = (model.blank_memory(), vec![0.0; model.dimension()], model.neutral_inputs());
        Ok(Stage { model, workspace, memory, dy, inputs })
    }

    /// Makes an evaluation; returns whether it came to an end.
    fn derivative(&mut self, sample: &Sample) -> bool {
        let at = Evaluation { t: sample.t, inputs: &self.inputs, y: black_box(&sample.y), memory: &mut self.memory };
        self.model.derivative(&mut self.workspace, at, &mut self.dy).is_ok()
    }

    fn whole(&mut self, sample: &Sample) -> f64 {
        timed(|| {
            black_box(self.derivative(sample));
        })
    }

    /// Stations on the track; motion and force elements; equations of motion. An evaluation comes before.
    fn parts(&mut self, sample: &Sample) -> [f64; 3] {
        let Stage { model, workspace, memory, dy, .. } = self;
        let (system, y) = (&model.system, sample.y.as_slice());
        let curved = model.track.line().is_some();
        let equations = timed(|| {
            let _ = black_box(system.constrained_derivative(sample.t, black_box(y), &mut workspace.system, dy));
        });
        let motion = timed(|| system.move_bodies(black_box(y), &mut workspace.system));
        let stations = if curved { timed(|| model.move_bodies(black_box(y), memory, &mut workspace.system)) } else { motion };
        let forces = match curved {
            true => motion + timed(|| system.apply_forces_on_track(black_box(y), &mut workspace.system)),
            false => timed(|| system.apply_forces(black_box(y), &mut workspace.system)),
        };
        [(stations - motion).max(0.0), forces, equations]
    }

    /// All of a Jacobian and its contacts alone. An evaluation comes before.
    fn jacobian(&mut self, sample: &Sample) -> [f64; 2] {
        let Stage { model, workspace, memory, inputs, .. } = self;
        [true, false].map(|forces| timed(|| model.linearise(workspace, (black_box(&sample.y), memory), inputs, forces)))
    }
}

/// s per call.
fn timed(mut call: impl FnMut()) -> f64 {
    let clock = Instant::now();
    for _ in 0..CALLS {
        call();
    }
    clock.elapsed().as_secs_f64() / f64::from(CALLS)
}

/// Makes the evaluations of a run with `scene` again; `whole`: Jacobians cover the force elements too.
pub(super) fn replay(scene: &Scene, samples: &[Sample], whole: bool) -> Result<Replay, String> {
    let (mut plain, mut normal, mut creep) = (Stage::new(scene)?, Stage::new(&normal_again(scene))?, Stage::new(&creep_again(scene))?);
    let elastic = !plain.model.formulation.constrains();
    // Whole, normal again, creep again, track, forces, equations, Jacobian, its contacts.
    let mut best = vec![[f64::INFINITY; 8]; samples.len()];
    let clock = Instant::now();
    'rounds: for round in 0..ROUNDS {
        for (place, (sample, best)) in samples.iter().zip(&mut best).enumerate() {
            if (round > 0 || place >= FEW) && clock.elapsed().as_secs_f64() > LONG {
                break 'rounds;
            }
            // Not all that is asked for in a run has an answer.
            if !plain.derivative(sample) {
                *best = [0.0; 8];
                continue;
            }
            let (once, again, creeping) = (plain.whole(sample), normal.whole(sample), creep.whole(sample));
            let [all, contacts] = if scene.solver.integrator.linearises() { plain.jacobian(sample) } else { [0.0; 2] };
            let [track, forces, equations] = plain.parts(sample);
            let found = [once, again, creeping, track, forces, equations, all, contacts];
            best.iter_mut().zip(found).for_each(|(best, found)| *best = best.min(found));
        }
    }
    best.retain(|best| best[0].is_finite());
    let sum = |part: usize| best.iter().map(|best| best[part]).sum::<f64>();
    let law = |part: usize| (sum(part) - sum(0)).max(0.0) / EXTRA as f64;
    let jacobian = if whole { sum(6) } else { sum(7) };
    Ok(Replay {
        whole: sum(0),
        normal: law(1),
        creep: law(2),
        track: sum(3),
        forces: sum(4),
        equations: if elastic { sum(5) } else { 0.0 },
        jacobian,
        jacobian_forces: (jacobian - sum(7)).max(0.0),
    })
}
