//! Axles that twist, in steady running: what their wheels get about the axle is in balance.
//!
//! A flexible axle does not go on twisting: `tau' = 0`, and tau is what M asks for, M = f_l M_l + f_r M_r ([`crate::mbs::twist`]); no force on a body depends on it. Independent wheels
//! have the rate tau' for which `M = c tau'`, found in each evaluation of the balance from what was found last. M falls with tau', steeply where wheels roll and hardly where they
//! slide: steps are those of Newton's method, no longer than so much creep, until the root lies between two rates; from there on false position.

use crate::formulation::memory::ModelMemory;
use crate::formulation::{Evaluation, EvaluationError, Model, Workspace, contact_index};
use crate::geometry::Side;
use crate::math::bracket::Bracket;
use crate::mbs::body::COORDINATES;
use crate::mbs::system::SystemWorkspace;
use crate::mbs::twist::Twist;

/// N m; a wheel that carries a load rolls against more than this.
const BALANCED: f64 = 1e-6;
/// What is kept for the next evaluation leaves less than this.
const NEAR: f64 = 1.0;
const ROUNDS: usize = 30;
/// Longest step, and the largest rate, in parts of the axle's speed of rotation: there is none in a trial state that is no rolling.
const LONGEST: f64 = 0.05;
const LARGEST: f64 = 0.5;

/// What is known of each axle that twists.
#[derive(Clone, Debug)]
pub(super) struct Twists {
    /// Change of M - c tau' with tau', N m s; `None` before it was seen.
    slopes: Vec<Option<f64>>,
    /// Both states as they were found last.
    found: Vec<[f64; 2]>,
    /// What resists the turning of independent wheels on each other beside their bearings, N m s; infinite: they turn together.
    pub held_by: f64,
}

impl Twists {
    pub fn new(model: &Model) -> Twists {
        let count = model.system.forces.iter().filter(|force| force.twist().is_some()).count();
        Twists { slopes: vec![None; count], found: vec![[0.0; 2]; count], held_by: 0.0 }
    }

    /// Are there wheels that turn on their own?
    pub fn independent(model: &Model) -> bool {
        model.system.forces.iter().filter_map(|force| force.twist()).any(|twist| twist.stiffness == 0.0)
    }

    /// Puts them as they were found last.
    pub fn put(&self, system: &SystemWorkspace, y: &mut [f64]) {
        for (axle, found) in system.twists.iter().zip(&self.found) {
            y[2 * COORDINATES * system.bodies() + axle.state..][..2].copy_from_slice(found);
        }
    }

    /// Balances all of them at the state that was evaluated last, whose rates are in `dy`; returns how many evaluations that took.
    pub fn settle(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        inputs: &[f64],
        (y, dy): (&mut [f64], &mut [f64]),
        memory: &mut ModelMemory,
    ) -> Result<usize, EvaluationError> {
        if self.slopes.is_empty() {
            return Ok(0);
        }
        let first = 2 * COORDINATES * model.system.bodies.len();
        let axles = workspace.system.twists.clone();
        let mut roots = vec![Root::default(); axles.len()];
        let mut rounds = 0;
        for _ in 0..ROUNDS {
            let mut moved = false;
            for (number, axle) in axles.iter().enumerate() {
                let Some(twist) = model.system.forces[axle.element].twist() else { continue };
                let (tau, rate) = (first + axle.state, first + axle.state + 1);
                let mut rest = dy[rate] * twist.inertia() / Twist::TIME;
                if twist.stiffness == 0.0 && self.held_by == f64::INFINITY {
                    (dy[tau], dy[rate]) = (0.0, 0.0);
                    continue;
                }
                if twist.stiffness > 0.0 {
                    y[tau] += rest / twist.stiffness;
                    (dy[tau], dy[rate]) = (0.0, 0.0);
                    continue;
                }
                let slope = &mut self.slopes[number];
                let now = y[rate] / Twist::TIME;
                rest -= self.held_by * now;
                if let Some((last, was)) = roots[number].last.filter(|(last, _)| *last != now) {
                    *slope = Some((rest - was) / (now - last)).filter(|slope| *slope < 0.0).or(*slope);
                }
                if !(rest.abs() > BALANCED) {
                    roots[number].last = Some((now, rest));
                    continue;
                }
                let motion = &workspace.system.motions[axle.body];
                let speed = motion.rotation.dot(&motion.axle()).abs();
                let step = || {
                    slope.map_or_else(|| alike(model, workspace, axle.body), |slope| -rest / slope).clamp(-LONGEST * speed, LONGEST * speed)
                };
                if let Some(next) = roots[number].next(now, rest, step).filter(|next| next.abs() < LARGEST * speed) {
                    y[rate] = next * Twist::TIME;
                    moved = true;
                }
            }
            if !moved {
                break;
            }
            model.derivative(workspace, Evaluation { t: 0.0, inputs, y, memory }, dy)?;
            rounds += 1;
        }
        for (number, (axle, found)) in axles.iter().zip(&mut self.found).enumerate() {
            // What was found in a trial state that has no balance is no start for the next one.
            let own = &y[first + axle.state..][..2];
            if roots[number].last.is_none_or(|(_, rest)| rest.abs() < NEAR) && own.iter().all(|state| state.is_finite()) {
                found.copy_from_slice(own);
            }
        }
        Ok(rounds)
    }

    /// Scales all speeds.
    pub fn slow_down(&self, system: &SystemWorkspace, scale: f64, y: &mut [f64]) {
        for axle in &system.twists {
            y[2 * COORDINATES * system.bodies() + axle.state + 1] *= scale;
        }
    }
}

/// Where M - c tau' vanishes.
#[derive(Clone, Debug, Default)]
struct Root {
    /// tau', rad/s, and what was left there, N m: the last one, and, once its sign has changed, the two between which the root lies.
    last: Option<(f64, f64)>,
    between: Option<Bracket>,
}

impl Root {
    /// Where to look next; `None` where nothing lies between.
    fn next(&mut self, now: f64, rest: f64, step: impl FnOnce() -> f64) -> Option<f64> {
        let here = (now, rest);
        match (&mut self.between, self.last.replace(here)) {
            (Some(between), _) => between.take(here),
            (None, Some(last)) if last.1 * rest < 0.0 => self.between = Some(Bracket { a: last, b: here }),
            _ => {}
        }
        let next = self.between.map_or_else(|| now + step(), |between| between.place());
        (next.is_finite() && next != now).then_some(next)
    }
}

/// The change of tau' [rad/s] after which both wheels of a wheelset slip alike along their rails.
fn alike(model: &Model, workspace: &Workspace, body: usize) -> f64 {
    let Some(index) = model.wheelsets.iter().position(|wheelset| wheelset.body == body) else { return 0.0 };
    let [left, right] = Side::BOTH.map(|side| workspace.contacts[contact_index(index, side)].slip.longitudinal);
    let wheelset = &model.wheelsets[index];
    2.0 * (left - right) / (wheelset.left.profile.at(0.0).value + wheelset.right.profile.at(0.0).value)
}
