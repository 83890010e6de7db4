//! Means over the last stretch of travel, as EN 14363 asks of Y/Q and of the sum of Y (2 m).
//!
//! ```text
//! mean(S) = (I(S) - I(S - window)) / window,    I' = q |v|,    S' = |v|
//! ```
//!
//! I and S are integrated beside the model's states (without error control: nothing depends on them). What I was a window ago
//! is kept in the state's memory: at the end of accepted steps, not closer to each other than a sixtieth of the window, S and all I are
//! written into a ring. Between its entries I is interpolated by a cubic through four of them: q is a smooth function of
//! distance but for impacts, and a step is a few centimetres long. Before a whole window has been travelled the mean is that since
//! the start.

use super::{Model, Workspace, contact_index};
use crate::geometry::Side;
use nalgebra::Vector3;
use std::ops::Range;

/// Entries of the ring: a window and what the interpolation needs beyond it.
const ENTRIES: usize = 64;
/// Entries in a window when steps are short.
const PER_WINDOW: f64 = 60.0;

/// Integrals of some quantities over the distance that a wheelset travels, and their past.
#[derive(Clone, Copy, Debug)]
pub struct SlidingMean {
    /// m.
    pub window: f64,
    /// Number of quantities.
    pub quantities: usize,
}

impl SlidingMean {
    /// States: S [m] and the integrals.
    pub fn states(&self) -> usize {
        1 + self.quantities
    }

    /// Numbers in the memory: how many entries there are, which is the oldest, the entries.
    pub fn memory(&self) -> usize {
        2 + ENTRIES * self.states()
    }

    /// Notes the states at the end of an accepted step.
    pub fn note(&self, states: &[f64], memory: &mut [f64]) {
        let width = self.states();
        let (count, oldest) = ((memory[0] as usize).min(ENTRIES), memory[1] as usize % ENTRIES);
        let place = |entry: usize| 2 + (entry % ENTRIES) * width;
        if count > 0 && states[0] - memory[place(oldest + count - 1)] < self.window / PER_WINDOW {
            return;
        }
        let at = place(oldest + count);
        memory[at..at + width].copy_from_slice(states);
        if count < ENTRIES {
            memory[0] += 1.0;
        } else {
            memory[1] = ((oldest + 1) % ENTRIES) as f64;
        }
    }

    /// Mean of quantity `index` over the window that ends at the given states; 0 before anything was travelled.
    pub fn mean(&self, index: usize, states: &[f64], memory: &[f64]) -> f64 {
        let (end, integral) = (states[0], states[1 + index]);
        let count = (memory[0] as usize).min(ENTRIES);
        let begin = (end - self.window).max(if count > 0 { self.entry(0, memory)[0] } else { end });
        if !(end > begin) {
            return 0.0;
        }
        (integral - self.past(begin, index, memory)) / (end - begin)
    }

    fn entry<'a>(&self, number: usize, memory: &'a [f64]) -> &'a [f64] {
        let width = self.states();
        let at = 2 + ((memory[1] as usize % ENTRIES + number) % ENTRIES) * width;
        &memory[at..at + width]
    }

    /// An integral at travelled distance `at`, by the polynomial through the four entries around it.
    fn past(&self, at: f64, index: usize, memory: &[f64]) -> f64 {
        let count = (memory[0] as usize).min(ENTRIES);
        let after = (0..count).find(|number| self.entry(*number, memory)[0] > at).unwrap_or(count);
        let first = after.saturating_sub(2).min(count.saturating_sub(4));
        let nodes = first..(first + 4).min(count);
        let weight = |i: usize| -> f64 {
            let own = self.entry(i, memory)[0];
            nodes.clone().filter(|j| *j != i).map(|j| self.entry(j, memory)[0]).map(|other| (at - other) / (own - other)).product()
        };
        nodes.clone().map(|i| weight(i) * self.entry(i, memory)[1 + index]).sum()
    }
}

/// What is averaged for each wheelset, in this order.
pub const MEANS: [&str; 3] = ["Y/Q of the left wheel", "Y/Q of the right wheel", "sum of Y"];

/// Wheel unloading below this force [N] makes quotients meaningless; they are zero then.
const UNLOADED: f64 = 1.0;

/// Guiding force over Q, outward positive, from the force on a wheel in the track frame.
pub fn derailment_quotient(side: Side, force: &Vector3<f64>) -> f64 {
    if force.z > UNLOADED { -side.sign() * force.y / force.z } else { 0.0 }
}

impl Model {
    /// Has the model sliding means from now on, over `window` [m]?
    pub fn with_sliding_means(mut self, window: Option<f64>) -> Self {
        self.means = window.map(|window| SlidingMean { window, quantities: MEANS.len() });
        self
    }

    /// States of a wheelset's means; they stand at the end of the state vector.
    pub fn mean_states(&self, wheelset: usize) -> Range<usize> {
        let count = self.means.map_or(0, |mean| mean.states());
        let first = self.means_begin() + wheelset * count;
        first..first + count
    }

    /// A wheelset's ring in the memory.
    pub fn mean_memory(&self, wheelset: usize) -> Range<usize> {
        let count = self.means.map_or(0, |mean| mean.memory());
        let first = self.contact_memory(self.contacts()).start + wheelset * count;
        first..first + count
    }

    /// Rates of the means' states from the forces that were found last.
    pub(super) fn mean_rates(&self, workspace: &Workspace, dy: &mut [f64]) {
        if self.means.is_none() {
            return;
        }
        for (index, wheelset) in self.wheelsets.iter().enumerate() {
            let speed = wheelset.speed(&workspace.system.motions[wheelset.body]).abs();
            let forces = Side::BOTH.map(|side| workspace.wheel_force(contact_index(index, side), wheelset.body));
            let quotient = |side: Side| derailment_quotient(side, &forces[side.index()]);
            let values = [1.0, quotient(Side::Left), quotient(Side::Right), -(forces[0].y + forces[1].y)];
            for (rate, value) in dy[self.mean_states(index)].iter_mut().zip(values) {
                *rate = value * speed;
            }
        }
    }

    /// Notes the means' states at the end of an accepted step.
    pub fn note_means(&self, y: &[f64], memory: &mut [f64]) {
        let Some(mean) = &self.means else { return };
        for wheelset in 0..self.wheelsets.len() {
            mean.note(&y[self.mean_states(wheelset)], &mut memory[self.mean_memory(wheelset)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs over a track with steps of uneven length; returns the largest difference from the exact mean of cos(k s).
    fn largest_error(step: f64, wave_number: f64) -> f64 {
        let filter = SlidingMean { window: 2.0, quantities: 2 };
        let mut memory = vec![0.0; filter.memory()];
        let integral = |s: f64| [s, (wave_number * s).sin() / wave_number, 3.0 * s];
        let (mut s, mut worst) = (0.0, 0.0f64);
        for k in 0..2000 {
            filter.note(&integral(s), &mut memory);
            // Outputs are read anywhere within the last step.
            for part in [0.0, 0.4, 0.9] {
                let at = s + part * step;
                let begin = (at - 2.0).max(0.0);
                let exact = if at > 0.0 { (integral(at)[1] - integral(begin)[1]) / (at - begin) } else { 0.0 };
                worst = worst.max((filter.mean(0, &integral(at), &memory) - exact).abs());
                let constant = if at > 0.0 { 3.0 } else { 0.0 };
                assert!((filter.mean(1, &integral(at), &memory) - constant).abs() < 1e-9, "{at}");
            }
            s += step * [1.0, 0.3, 1.7, 0.02][k % 4];
        }
        worst
    }

    #[test]
    fn analytic_mean_of_a_wave_over_two_metres() {
        // A wave of 1.5 m: the mean is not zero, its error that of the cubic.
        let k = std::f64::consts::TAU / 1.5;
        let (fine, coarse) = (largest_error(0.05, k), largest_error(0.1, k));
        println!("steps of up to 0.09 m: {fine:.1e}, 0.17 m: {coarse:.1e}");
        assert!(fine < 2e-4 && coarse < 3e-3, "{fine} {coarse}");
        // Steps much shorter than the entries' spacing.
        assert!(largest_error(1e-3, k) < 1e-4);
    }
}
