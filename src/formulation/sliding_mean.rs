//! Means over the last stretch of travel, as EN 14363 asks of Y/Q and of the sum of Y: low-pass filter of 20 Hz, then 2 m.
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
//!
//! Filtered: [`super::low_pass`] runs in time, with the mean of q over each accepted step, `change of I / change of S`, as its input there, and
//! is advanced exactly; so it takes no part in error control and is stable for any step. With y its output, `K' = y |v|` takes the place of I, |v| as its mean over the step.
//! That the input is constant over a step of length h lowers a wave of frequency f by `sin(pi f h) / (pi f h)`: 0.2 % at 20 Hz with 2 ms, 1.6 % with 5 ms.
//! It begins settled on the first step's mean. Where the wheelset stands still it goes on with the last input.
//! Memory: the ring, then two ends of steps ([`End`]), because outputs are read within the last step.

use super::low_pass::{self, LowPass};
use super::{Model, Workspace, contact_index};
use crate::geometry::Side;
use nalgebra::Vector3;
use std::ops::Range;

/// Entries of the ring: a window and what the interpolation needs beyond it.
const ENTRIES: usize = 64;
/// Entries in a window when steps are short.
const PER_WINDOW: f64 = 60.0;
/// EN 14363's low-pass filter, Hz.
pub const CUT_OFF: f64 = 20.0;
/// Travel of a step, m, below which the mean of q over it is lost in rounding.
const LEAST_TRAVEL: f64 = 1e-7;

/// Integrals of some quantities over the distance that a wheelset travels, and their past.
#[derive(Clone, Copy, Debug)]
pub struct SlidingMean {
    /// m.
    pub window: f64,
    /// Number of quantities.
    pub quantities: usize,
    filter: LowPass,
}

/// What is averaged: the quantity itself, or what the filter leaves of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Averaged {
    Unfiltered,
    Filtered,
}

/// The filters at the end of a step: how far they are (0 nothing noted, 1 no input yet, 2 running), time, S and all I, then of each
/// quantity its input, the filter's state and K.
struct End;

impl End {
    const TIME: usize = 1;
    const STATES: usize = 2;
    /// Input, state, K.
    const PER_QUANTITY: usize = low_pass::STATES + 2;
    const NOTHING: f64 = 0.0;
    const WAITING: f64 = 1.0;
    const RUNNING: f64 = 2.0;
}

impl SlidingMean {
    pub fn new(window: f64, quantities: usize) -> Self {
        SlidingMean { window, quantities, filter: LowPass::new(CUT_OFF) }
    }

    /// States: S [m] and the integrals.
    pub fn states(&self) -> usize {
        1 + self.quantities
    }

    /// Numbers of an entry of the ring: S, all I, all K.
    fn width(&self) -> usize {
        1 + 2 * self.quantities
    }

    fn end_length(&self) -> usize {
        End::STATES + self.states() + End::PER_QUANTITY * self.quantities
    }

    /// Numbers in the memory: how many entries there are, which is the oldest, the entries; the ends of the last two steps.
    pub fn memory(&self) -> usize {
        self.ends() + 2 * self.end_length()
    }

    fn ends(&self) -> usize {
        2 + ENTRIES * self.width()
    }

    /// Place of a quantity's part in an end.
    fn part(&self, index: usize) -> Range<usize> {
        let first = End::STATES + self.states() + End::PER_QUANTITY * index;
        first..first + End::PER_QUANTITY
    }

    /// K of a quantity at an end.
    fn filtered_integral(&self, index: usize, end: &[f64]) -> f64 {
        end[self.part(index).end - 1]
    }

    /// Notes time and states at the end of an accepted step.
    pub fn note(&self, t: f64, states: &[f64], memory: &mut [f64]) {
        let (ring, ends) = memory.split_at_mut(self.ends());
        let (before, last) = ends.split_at_mut(self.end_length());
        let travelled = states[0] - last[End::STATES] > LEAST_TRAVEL;
        let state = match last[0] {
            End::NOTHING => End::WAITING,
            // The first input is the mean since the start, however slowly that began.
            End::WAITING if !travelled => return,
            _ => End::RUNNING,
        };
        if last[0] != End::NOTHING && !(t > last[End::TIME]) {
            return;
        }
        before.copy_from_slice(last);
        for index in 0..self.quantities {
            let part = self.advanced(index, t, states, before);
            last[self.part(index)].copy_from_slice(&part);
        }
        (last[0], last[End::TIME]) = (state, t);
        last[End::STATES..End::STATES + self.states()].copy_from_slice(states);

        let width = self.width();
        let (count, oldest) = ((ring[0] as usize).min(ENTRIES), ring[1] as usize % ENTRIES);
        let place = |entry: usize| 2 + (entry % ENTRIES) * width;
        if count > 0 && states[0] - ring[place(oldest + count - 1)] < self.window / PER_WINDOW {
            return;
        }
        let at = place(oldest + count);
        ring[at..at + self.states()].copy_from_slice(states);
        for index in 0..self.quantities {
            ring[at + self.states() + index] = self.filtered_integral(index, last);
        }
        if count < ENTRIES {
            ring[0] += 1.0;
        } else {
            ring[1] = ((oldest + 1) % ENTRIES) as f64;
        }
    }

    /// A quantity's filter at time `t` with the means' states there: its part of an end, from an earlier end.
    fn advanced(&self, index: usize, t: f64, states: &[f64], end: &[f64]) -> [f64; End::PER_QUANTITY] {
        let mut part = [0.0; End::PER_QUANTITY];
        part.copy_from_slice(&end[self.part(index)]);
        let (step, travel) = (t - end[End::TIME], states[0] - end[End::STATES]);
        let moves = travel > LEAST_TRAVEL;
        if end[0] == End::NOTHING || !(step > 0.0) || end[0] == End::WAITING && !moves {
            return part;
        }
        let [input, state @ .., integral] = &mut part;
        if moves {
            *input = (states[1 + index] - end[End::STATES + 1 + index]) / travel;
        }
        if end[0] == End::WAITING {
            self.filter.settle(*input, state);
        }
        *integral += self.filter.advance(*input, step, state) * travel / step;
        part
    }

    /// Mean of quantity `index` over the window that ends at time `t` at the given states; 0 before anything was travelled.
    pub fn mean(&self, index: usize, averaged: Averaged, t: f64, states: &[f64], memory: &[f64]) -> f64 {
        let end = states[0];
        let (integral, column) = match averaged {
            Averaged::Unfiltered => (states[1 + index], 1 + index),
            Averaged::Filtered => (self.now(index, t, states, memory), self.states() + index),
        };
        let count = (memory[0] as usize).min(ENTRIES);
        let begin = (end - self.window).max(if count > 0 { self.entry(0, memory)[0] } else { end });
        if !(end > begin) {
            return 0.0;
        }
        (integral - self.past(begin, column, memory)) / (end - begin)
    }

    /// K at time `t`, within the last step or after it.
    fn now(&self, index: usize, t: f64, states: &[f64], memory: &[f64]) -> f64 {
        let (before, last) = memory[self.ends()..].split_at(self.end_length());
        let from = if t < last[End::TIME] && before[0] != End::NOTHING { before } else { last };
        let [.., integral] = self.advanced(index, t, states, from);
        integral
    }

    fn entry<'a>(&self, number: usize, memory: &'a [f64]) -> &'a [f64] {
        let width = self.width();
        let at = 2 + ((memory[1] as usize % ENTRIES + number) % ENTRIES) * width;
        &memory[at..at + width]
    }

    /// An integral at travelled distance `at`, by the polynomial through the four entries around it.
    fn past(&self, at: f64, column: usize, memory: &[f64]) -> f64 {
        let count = (memory[0] as usize).min(ENTRIES);
        let after = (0..count).find(|number| self.entry(*number, memory)[0] > at).unwrap_or(count);
        let first = after.saturating_sub(2).min(count.saturating_sub(4));
        let nodes = first..(first + 4).min(count);
        let weight = |i: usize| -> f64 {
            let own = self.entry(i, memory)[0];
            nodes.clone().filter(|j| *j != i).map(|j| self.entry(j, memory)[0]).map(|other| (at - other) / (own - other)).product()
        };
        nodes.clone().map(|i| weight(i) * self.entry(i, memory)[column]).sum()
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
        self.means = window.map(|window| SlidingMean::new(window, MEANS.len()));
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
    pub fn note_means(&self, t: f64, y: &[f64], memory: &mut [f64]) {
        let Some(mean) = &self.means else { return };
        for wheelset in 0..self.wheelsets.len() {
            mean.note(t, &y[self.mean_states(wheelset)], &mut memory[self.mean_memory(wheelset)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Speed of the runs, m/s.
    const SPEED: f64 = 30.0;

    /// Runs over a track with steps of uneven length; returns the largest difference from the exact mean of cos(k s).
    fn largest_error(step: f64, wave_number: f64) -> f64 {
        let filter = SlidingMean::new(2.0, 2);
        let mut memory = vec![0.0; filter.memory()];
        let integral = |s: f64| [s, (wave_number * s).sin() / wave_number, 3.0 * s];
        let (mut s, mut worst) = (0.0, 0.0f64);
        for k in 0..2000 {
            filter.note(s / SPEED, &integral(s), &mut memory);
            // Outputs are read anywhere within the last step.
            for part in [0.0, 0.4, 0.9] {
                let at = s + part * step;
                let begin = (at - 2.0).max(0.0);
                let exact = if at > 0.0 { (integral(at)[1] - integral(begin)[1]) / (at - begin) } else { 0.0 };
                let found = |index, averaged| filter.mean(index, averaged, at / SPEED, &integral(at), &memory);
                worst = worst.max((found(0, Averaged::Unfiltered) - exact).abs());
                let constant = if at > 0.0 { 3.0 } else { 0.0 };
                for averaged in [Averaged::Unfiltered, Averaged::Filtered] {
                    assert!((found(1, averaged) - constant).abs() < 1e-9, "{averaged:?} {at}");
                }
            }
            s += step * [1.0, 0.3, 1.7, 0.02][k % 4];
        }
        worst
    }

    #[test]
    fn analytic_mean_of_a_wave_over_two_metres() {
        // A wave of 1.5 m: the mean is not zero, its error that of the cubic.
        let k = TAU / 1.5;
        let (fine, coarse) = (largest_error(0.05, k), largest_error(0.1, k));
        println!("steps of up to 0.09 m: {fine:.1e}, 0.17 m: {coarse:.1e}");
        assert!(fine < 2e-4 && coarse < 3e-3, "{fine} {coarse}");
        // Steps much shorter than the entries' spacing.
        assert!(largest_error(1e-3, k) < 1e-4);
    }

    /// Largest filtered and unfiltered mean of a wave of `frequency` Hz, after the transient; outputs are read before the end of the last step.
    fn largest_means(frequency: f64, step: f64) -> [f64; 2] {
        let filter = SlidingMean::new(2.0, 1);
        let mut memory = vec![0.0; filter.memory()];
        let states = |t: f64| [SPEED * t, SPEED * (1.0 - (TAU * frequency * t).cos()) / (TAU * frequency)];
        let (mut t, mut largest) = (0.0, [0.0f64; 2]);
        for k in 0..(2.0 / step) as usize {
            filter.note(t, &states(t), &mut memory);
            let at = t - 0.7 * step;
            if at > 1.0 {
                for (largest, averaged) in largest.iter_mut().zip([Averaged::Filtered, Averaged::Unfiltered]) {
                    *largest = largest.max(filter.mean(0, averaged, at, &states(at), &memory).abs());
                }
            }
            t += step * [1.0, 1.2, 0.8][k % 3];
        }
        largest
    }

    #[test]
    fn analytic_waves_pass_with_butterworths_gain() {
        // |sin(pi f T)| / (pi f T), T = window / speed, is what the mean alone leaves.
        for (frequency, step, tolerance) in [(3.0, 5e-3, 2e-3), (20.0, 1e-3, 5e-3), (20.0, 2e-3, 0.01), (37.0, 1e-3, 0.01)] {
            let half = 0.5 * TAU * frequency * 2.0 / SPEED;
            let mean = (half.sin() / half).abs();
            let gain = 1.0 / (1.0 + (frequency / CUT_OFF).powi(8)).sqrt();
            let [filtered, unfiltered] = largest_means(frequency, step);
            println!("{frequency} Hz: {filtered:.5} of {:.5}, unfiltered {unfiltered:.5} of {mean:.5}", mean * gain);
            assert!((unfiltered / mean - 1.0).abs() < 0.02 && (filtered / (mean * gain) - 1.0).abs() < tolerance + 0.02, "{frequency}");
        }
    }

    #[test]
    fn prop_a_halt_keeps_the_mean() {
        let filter = SlidingMean::new(2.0, 1);
        let mut memory = vec![0.0; filter.memory()];
        // Stands, runs 5 m with q = 4, stands again.
        let travelled = |t: f64| SPEED * (t - 0.1).clamp(0.0, 5.0 / SPEED);
        let mut t = 0.0;
        while t < 0.5 {
            let states = [travelled(t), 4.0 * travelled(t)];
            filter.note(t, &states, &mut memory);
            let mean = filter.mean(0, Averaged::Filtered, t, &states, &memory);
            assert!(if travelled(t) > 1e-6 { (mean - 4.0).abs() < 1e-9 } else { mean == 0.0 }, "{t}: {mean}");
            t += 1e-3;
        }
    }
}
