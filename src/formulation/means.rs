//! The sliding means of a model's wheelsets.

use super::memory::ModelMemory;
use super::sliding_mean::{QUANTITIES, SlidingMean};
use super::{Model, Wheelset, Workspace, contact_index};
use crate::geometry::Side;
use nalgebra::Vector3;

/// Wheel unloading below this force [N] makes quotients meaningless; they are zero then.
const UNLOADED: f64 = 1.0;

/// Guiding force over Q, outward positive, from the force on a wheel in the track frame.
pub fn derailment_quotient(side: Side, force: &Vector3<f64>) -> f64 {
    if force.z > UNLOADED { -side.sign() * force.y / force.z } else { 0.0 }
}

/// What is averaged for a wheelset ([`super::sliding_mean::MEANS`]), from the forces that were found last.
fn averaged_now(workspace: &Workspace, (index, wheelset): (usize, &Wheelset)) -> [f64; QUANTITIES] {
    let forces = Side::BOTH.map(|side| workspace.wheel_force(contact_index(index, side), wheelset.body));
    let quotient = |side: Side| derailment_quotient(side, &forces[side.index()]);
    [quotient(Side::Left), quotient(Side::Right), -(forces[0].y + forces[1].y)]
}

impl Model {
    /// Has the model sliding means from now on, over `window` [m]?
    pub fn with_sliding_means(mut self, window: Option<f64>) -> Self {
        self.means = window.map(SlidingMean::new);
        self
    }

    /// Rates of the means' states from the forces that were found last.
    pub(super) fn mean_rates(&self, workspace: &Workspace, dy: &mut [f64]) {
        if self.means.is_none() {
            return;
        }
        for (index, wheelset) in self.wheelsets.iter().enumerate() {
            let speed = wheelset.speed(&workspace.system.motions[wheelset.body]).abs();
            let values = averaged_now(workspace, (index, wheelset));
            for (rate, value) in dy[self.mean_states(index)].iter_mut().zip([1.0].into_iter().chain(values)) {
                *rate = value * speed;
            }
        }
    }

    /// Notes the present values at the end of an accepted step, from the forces that were found last.
    pub fn note_present_means(&self, workspace: &Workspace, memory: &mut ModelMemory) {
        for ((index, wheelset), memory) in self.wheelsets.iter().enumerate().zip(&mut memory.means) {
            memory.note_present(|| averaged_now(workspace, (index, wheelset)));
        }
    }

    /// Notes the means' states at the end of an accepted step.
    pub fn note_means(&self, t: f64, y: &[f64], memory: &mut ModelMemory) {
        let Some(mean) = &self.means else { return };
        for (wheelset, memory) in memory.means.iter_mut().enumerate() {
            mean.note(t, &y[self.mean_states(wheelset)], memory);
        }
    }
}
