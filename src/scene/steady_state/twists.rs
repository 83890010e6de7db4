//! Axles that twist, in steady running: what their wheels get about the axle is in balance.
//!
//! A flexible axle does not go on twisting: `tau' = 0`, and tau is what M asks for, M = f_l M_l + f_r M_r ([`crate::mbs::twist`]); no force on a body depends on it. Independent wheels
//! have the rate tau' for which `M = c tau'`, found by Newton's method in each evaluation of the balance: its first step is that which makes both wheels slip alike, the others
//! take the slope from the last two, and the next evaluation starts with what was found.

use crate::formulation::memory::ModelMemory;
use crate::formulation::{Evaluation, EvaluationError, Model, Workspace, contact_index};
use crate::geometry::Side;
use crate::mbs::body::COORDINATES;
use crate::mbs::system::SystemWorkspace;
use crate::mbs::twist::Twist;

/// N m; a wheel that carries a load rolls against more than this.
const BALANCED: f64 = 1e-6;
const ROUNDS: usize = 12;

/// What is known of each axle that twists.
#[derive(Clone, Debug)]
pub(super) struct Twists {
    /// Change of M - c tau' with tau', N m s; `None` before it was seen.
    slopes: Vec<Option<f64>>,
    /// Both states as they were found last.
    found: Vec<[f64; 2]>,
}

impl Twists {
    pub fn new(model: &Model) -> Twists {
        let count = model.system.forces.iter().filter(|force| force.twist().is_some()).count();
        Twists { slopes: vec![None; count], found: vec![[0.0; 2]; count] }
    }

    /// Puts them as they were found last.
    pub fn put(&self, system: &SystemWorkspace, y: &mut [f64]) {
        for (axle, found) in system.twists.iter().zip(&self.found) {
            y[2 * COORDINATES * system.bodies() + axle.state..][..2].copy_from_slice(found);
        }
    }

    /// Balances all of them at the state that was evaluated last, whose rates are in `dy`.
    pub fn settle(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        inputs: &[f64],
        (y, dy): (&mut [f64], &mut [f64]),
        memory: &mut ModelMemory,
    ) -> Result<(), EvaluationError> {
        if self.slopes.is_empty() {
            return Ok(());
        }
        let first = 2 * COORDINATES * model.system.bodies.len();
        let axles = workspace.system.twists.clone();
        let mut before = vec![(0.0, f64::INFINITY); axles.len()];
        for _ in 0..ROUNDS {
            let mut moved = false;
            for (number, axle) in axles.iter().enumerate() {
                let Some(twist) = model.system.forces[axle.element].twist() else { continue };
                let (tau, rate) = (first + axle.state, first + axle.state + 1);
                let rest = dy[rate] * twist.inertia() / Twist::TIME;
                if twist.stiffness > 0.0 {
                    y[tau] += rest / twist.stiffness;
                    (dy[tau], dy[rate]) = (0.0, 0.0);
                    continue;
                }
                let now = y[rate] / Twist::TIME;
                let (last, was) = before[number];
                // NaN and what gains nothing any more stay.
                if !(rest.abs() > BALANCED && rest.abs() < was.abs()) {
                    continue;
                }
                if was.is_finite() && now != last {
                    self.slopes[number] = Some((rest - was) / (now - last)).filter(|slope| *slope < 0.0).or(self.slopes[number]);
                }
                let step = match self.slopes[number] {
                    Some(slope) => -rest / slope,
                    None => alike(model, workspace, axle.body),
                };
                before[number] = (now, rest);
                y[rate] = (now + step) * Twist::TIME;
                moved = true;
            }
            if !moved {
                break;
            }
            model.derivative(workspace, Evaluation { t: 0.0, inputs, y, memory }, dy)?;
        }
        for (axle, found) in axles.iter().zip(&mut self.found) {
            found.copy_from_slice(&y[first + axle.state..][..2]);
        }
        Ok(())
    }

    /// Scales all speeds.
    pub fn slow_down(&self, system: &SystemWorkspace, scale: f64, y: &mut [f64]) {
        for axle in &system.twists {
            y[2 * COORDINATES * system.bodies() + axle.state + 1] *= scale;
        }
    }
}

/// The change of tau' [rad/s] after which both wheels of a wheelset slip alike along their rails.
fn alike(model: &Model, workspace: &Workspace, body: usize) -> f64 {
    let Some(index) = model.wheelsets.iter().position(|wheelset| wheelset.body == body) else { return 0.0 };
    let [left, right] = Side::BOTH.map(|side| workspace.contacts[contact_index(index, side)].slip.longitudinal);
    let wheelset = &model.wheelsets[index];
    2.0 * (left - right) / (wheelset.left.profile.at(0.0).value + wheelset.right.profile.at(0.0).value)
}
