//! Means over the last stretch of travel, as EN 14363 asks of Y/Q and of the sum of Y: low-pass filter of 20 Hz, then 2 m.
//!
//! ```text
//! mean(S) = (I(S) - I(S - window)) / window,    I' = q |v|,    S' = |v|
//! ```
//!
//! I and S are integrated beside the model's states (without error control: nothing depends on them). What I was a window ago
//! is remembered: at the end of accepted steps, not closer to each other than a sixtieth of the window, S and all I are
//! written into a ring. Steps of a millisecond and of thirty stand side by side, and q jumps where an input does: a polynomial through several uneven entries
//! swings, and one whose slope before a jump comes from what lies behind it turned a force of 30 kN that stood for 0.2 m into a mean of 6.1 kN (2.8). So between two entries
//! I is a cubic whose slopes deviate from the chord, where a short interval stands beside a long one, by no more than the bends of both its ends agree on ([`MeanMemory::deviations`]). Before a whole window has been
//! travelled the mean is that since the start; before anything has been, the present value at the end of the last step.
//!
//! Filtered: [`super::low_pass`] runs in time and is advanced exactly; so it takes no part in error control and is stable for any step. Its input over an accepted
//! step is a line: its mean is that of q there, `change of I / change of S`, its slope is from the mean of the step before to this one's.
//! With y the filter's output, `K' = y |v|` takes the place of I, |v| as its mean over the step; the slope of K over S between entries is y itself.
//! The line's error is of third order in the step h: it shifts a wave of frequency f by (2 pi f h)^3 / 24 of its amplitude, 0.07 % at 20 Hz with 2 ms, 0.8 % at 3 Hz with 30 ms.
//! It begins settled on the first step's mean. Where the wheelset stands still it goes on with the last input.
//! Two ends of steps are kept ([`End`]), because outputs are read within the last step.

use super::low_pass::{self, LowPass};
use serde::{Deserialize, Serialize};

/// Entries of the ring: a window and what the interpolation needs beyond it.
const ENTRIES: usize = 64;
/// Entries in a window when steps are short.
const PER_WINDOW: f64 = 60.0;
/// EN 14363's low-pass filter, Hz.
pub const CUT_OFF: f64 = 20.0;
/// Travel of a step, m, below which the mean of q over it is lost in rounding.
const LEAST_TRAVEL: f64 = 1e-7;

/// What is averaged for each wheelset, in this order.
pub const MEANS: [&str; 3] = ["Y/Q of the left wheel", "Y/Q of the right wheel", "sum of Y"];

/// Number of quantities.
pub const QUANTITIES: usize = MEANS.len();

/// Integrals of some quantities over the distance that a wheelset travels, and their past.
#[derive(Clone, Copy, Debug)]
pub struct SlidingMean {
    /// m.
    pub window: f64,
    filter: LowPass,
}

/// What is averaged: the quantity itself, or what the filter leaves of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Averaged {
    Unfiltered,
    Filtered,
}

/// S and all I.
type States = [f64; 1 + QUANTITIES];

/// An entry of the ring: S, I of all quantities, K of all quantities and their filters' outputs, which are its slopes over S.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Entry {
    distance: f64,
    plain: [f64; QUANTITIES],
    filtered: [f64; QUANTITIES],
    outputs: [f64; QUANTITIES],
}

/// A quantity's filter at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Filter {
    /// Mean over the step.
    input: f64,
    state: [f64; low_pass::STATES],
    /// K.
    integral: f64,
}

/// The filters at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct End {
    /// s.
    time: f64,
    /// Length of the step, s.
    step: f64,
    states: States,
    /// Have the filters an input yet?
    running: bool,
    filters: [Filter; QUANTITIES],
}

/// What the means of one wheelset remember.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct MeanMemory {
    /// As a ring: so many of them, from the oldest on.
    entries: Vec<Entry>,
    count: usize,
    oldest: usize,
    /// The ends of the last two steps.
    before: Option<End>,
    last: Option<End>,
    /// The quantities at the end of the last step, while nothing has been travelled.
    present: [f64; QUANTITIES],
}

impl Default for MeanMemory {
    fn default() -> Self {
        MeanMemory { entries: vec![Entry::default(); ENTRIES], count: 0, oldest: 0, before: None, last: None, present: [0.0; QUANTITIES] }
    }
}

impl Clone for MeanMemory {
    fn clone(&self) -> Self {
        MeanMemory { entries: self.entries.clone(), ..*self }
    }

    fn clone_from(&mut self, other: &Self) {
        self.entries.clone_from(&other.entries);
        (self.count, self.oldest, self.before, self.last, self.present) =
            (other.count, other.oldest, other.before, other.last, other.present);
    }
}

impl MeanMemory {
    /// Could it be of the same model as `other`?
    pub fn fits(&self, other: &MeanMemory) -> bool {
        self.entries.len() == other.entries.len() && self.count.max(other.count) <= self.entries.len()
    }

    /// Notes what the quantities are at the end of a step; it is what is shown until something has been travelled.
    pub fn note_present(&mut self, values: impl FnOnce() -> [f64; QUANTITIES]) {
        if self.count < 2 {
            self.present = values();
        }
    }

    /// An entry by its age, the oldest first.
    fn entry(&self, number: usize) -> &Entry {
        &self.entries[(self.oldest % ENTRIES + number) % ENTRIES]
    }

    fn newest(&self) -> Option<&Entry> {
        self.count.checked_sub(1).map(|newest| self.entry(newest))
    }

    fn push(&mut self, entry: Entry) {
        let at = (self.oldest % ENTRIES + self.count) % ENTRIES;
        self.entries[at] = entry;
        if self.count < ENTRIES {
            self.count += 1;
        } else {
            self.oldest = (self.oldest % ENTRIES + 1) % ENTRIES;
        }
    }

    /// Forgets what was noted beyond time `t`: the end of a step that was cut afterwards, or over which the integration restarts.
    fn take_back(&mut self, t: f64) {
        if self.last.as_ref().is_some_and(|last| last.time > t) && self.before.is_some() {
            self.last = self.before.take();
            let end = self.last.as_ref().map_or(f64::NEG_INFINITY, |last| last.states[0]);
            while self.newest().is_some_and(|newest| newest.distance > end) {
                self.count -= 1;
            }
        }
    }

    /// The filters begin where the newest entry is: settled on their first inputs.
    fn settle(&mut self, inputs: [f64; QUANTITIES]) {
        if let Some(newest) = self.count.checked_sub(1) {
            self.entries[(self.oldest % ENTRIES + newest) % ENTRIES].outputs = inputs;
        }
    }

    /// Number of the first entry beyond a travelled distance.
    fn after(&self, distance: f64) -> usize {
        (0..self.count).find(|number| self.entry(*number).distance > distance).unwrap_or(self.count)
    }

    /// An integral at travelled distance `at` from its values at the entries and, by the number of an interval's first entry, what its slopes at both ends would add
    /// to or take from the chord over the whole interval.
    fn past(&self, at: f64, value: impl Fn(&Entry) -> f64, deviations: impl Fn(usize) -> [f64; 2]) -> f64 {
        let right = self.after(at);
        let Some(left) = right.checked_sub(1) else { return if self.count > 0 { value(self.entry(0)) } else { 0.0 } };
        let from = self.entry(left);
        if right == self.count {
            return value(from);
        }
        let to = self.entry(right);
        let part = (at - from.distance) / (to.distance - from.distance);
        // Deviation from the chord: part (1 - part) times a line between what the slopes deviate by.
        let [first, last] = deviations(left);
        value(from) + (value(to) - value(from)) * part + part * (1.0 - part) * (first * (1.0 - part) - last * part)
    }

    /// What the slopes of an integral at the ends of the interval behind an entry deviate by from its chord, times the interval's length.
    ///
    /// The chords of two intervals side by side, over h and k, make a bend b = 2 (their difference) / (h + k), which is dq/dS if q is a line; its slope at either end of h is then
    /// b h / 2 off the chord's. Where a short interval follows a long one (k < h / 2) the difference may be a jump: there b counts only as far as the bend at the interval's other end says
    /// the same, and up to twice that.
    fn deviations(&self, interval: usize, value: impl Fn(&Entry) -> f64) -> [f64; 2] {
        let chord = |from: usize| {
            let [from, to] = [from, from + 1].map(|number| self.entry(number));
            let length = to.distance - from.distance;
            (length, (value(to) - value(from)) / length)
        };
        let (length, rise) = chord(interval);
        // Half a bend, and the length of the interval beside.
        let bend = |beside: usize| {
            let (other, beyond) = chord(beside);
            ((beyond - rise) / (length + other), other)
        };
        let before = interval.checked_sub(1).map(bend);
        let after = (interval + 2 < self.count).then(|| bend(interval + 1));
        let limited = |(bend, other): (f64, f64), opposite: f64| match (2.0 * other < length, bend * opposite > 0.0) {
            (false, _) => bend,
            (true, true) => bend.signum() * bend.abs().min(2.0 * opposite.abs()),
            (true, false) => 0.0,
        };
        // The chord before lies below where q rises.
        let [first, last] = match [before.map(|(bend, other)| (-bend, other)), after] {
            [Some(first), Some(last)] => [limited(first, last.0), limited(last, first.0)],
            [one, other] => [one.or(other).map_or(0.0, |one| one.0); 2],
        };
        [-first * length * length, last * length * length]
    }
}

impl SlidingMean {
    pub fn new(window: f64) -> Self {
        SlidingMean { window, filter: LowPass::new(CUT_OFF) }
    }

    /// States: S [m] and the integrals.
    pub const STATES: usize = 1 + QUANTITIES;

    /// Notes time and states at the end of an accepted step, which may lie before the end that was noted last: that step was cut.
    pub fn note(&self, t: f64, states: &[f64], memory: &mut MeanMemory) {
        memory.take_back(t);
        let mut now = End { time: t, ..End::default() };
        now.states.copy_from_slice(states);
        if let Some(last) = &memory.last {
            // The first input is the mean since the start, however slowly that began.
            if !(t > last.time) || !last.running && !(states[0] - last.states[0] > LEAST_TRAVEL) {
                return;
            }
            now.running = true;
            now.step = t - last.time;
            for (index, filter) in now.filters.iter_mut().enumerate() {
                *filter = self.advanced(index, t, states, last);
            }
            let inputs = now.filters.map(|filter| filter.input);
            if !last.running {
                memory.settle(inputs);
            }
        }
        memory.before = memory.last.replace(now);
        if memory.newest().is_some_and(|newest| states[0] - newest.distance < self.window / PER_WINDOW) {
            return;
        }
        let mut entry = Entry { distance: states[0], ..Entry::default() };
        entry.filtered = now.filters.map(|filter| filter.integral);
        entry.outputs = now.filters.map(|filter| self.filter.output(&filter.state));
        entry.plain.copy_from_slice(&states[1..]);
        memory.push(entry);
    }

    /// A quantity's filter at time `t` with the means' states there, from an earlier end.
    fn advanced(&self, index: usize, t: f64, states: &[f64], end: &End) -> Filter {
        let mut filter = end.filters[index];
        let (step, travel) = (t - end.time, states[0] - end.states[0]);
        let moves = travel > LEAST_TRAVEL;
        if !(step > 0.0) || !end.running && !moves {
            return filter;
        }
        if moves {
            filter.input = (states[1 + index] - end.states[1 + index]) / travel;
        }
        let mut slope = 0.0;
        if end.running {
            slope = (filter.input - end.filters[index].input) / (0.5 * (step + end.step));
        } else {
            self.filter.settle(filter.input, &mut filter.state);
        }
        filter.integral += self.filter.advance(filter.input, slope, step, &mut filter.state) * travel / step;
        filter
    }

    /// Mean of quantity `index` over the window that ends at time `t` at the given states; the present value before anything was travelled.
    pub fn mean(&self, index: usize, averaged: Averaged, t: f64, states: &[f64], memory: &MeanMemory) -> f64 {
        let end = states[0];
        let begin = (end - self.window).max(if memory.count > 0 { memory.entry(0).distance } else { end });
        if !(end > begin + LEAST_TRAVEL) {
            return memory.present[index];
        }
        let change = match averaged {
            Averaged::Unfiltered => {
                let plain = |entry: &Entry| entry.plain[index];
                states[1 + index] - memory.past(begin, plain, |interval| memory.deviations(interval, plain))
            }
            Averaged::Filtered => {
                // The filter's outputs are the slopes.
                let deviations = |interval: usize| {
                    let [from, to] = [interval, interval + 1].map(|number| memory.entry(number));
                    let (length, rise) = (to.distance - from.distance, to.filtered[index] - from.filtered[index]);
                    [from, to].map(|entry| entry.outputs[index] * length - rise)
                };
                self.filtered(index, t, states, memory) - memory.past(begin, |entry| entry.filtered[index], deviations)
            }
        };
        change / (end - begin)
    }

    /// K at time `t`, within the last step or after it.
    fn filtered(&self, index: usize, t: f64, states: &[f64], memory: &MeanMemory) -> f64 {
        let from = memory.last.as_ref().map(|last| memory.before.as_ref().filter(|_| t < last.time).unwrap_or(last));
        from.map_or(0.0, |from| self.advanced(index, t, states, from).integral)
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
        let filter = SlidingMean::new(2.0);
        let mut memory = MeanMemory::default();
        let integral = |s: f64| [s, (wave_number * s).sin() / wave_number, 3.0 * s, 0.0];
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
        assert!(fine < 2e-4 && coarse < 1.5e-3, "{fine} {coarse}");
        // Steps much shorter than the entries' spacing.
        assert!(largest_error(1e-3, k) < 1e-4);
    }

    /// Largest filtered and unfiltered mean of a wave of `frequency` Hz, after the transient; outputs are read before the end of the last step.
    fn largest_means(frequency: f64, step: f64) -> [f64; 2] {
        let filter = SlidingMean::new(2.0);
        let mut memory = MeanMemory::default();
        let states = |t: f64| [SPEED * t, SPEED * (1.0 - (TAU * frequency * t).cos()) / (TAU * frequency), 0.0, 0.0];
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
        for (frequency, step, tolerance) in [(3.0, 5e-3, 2e-4), (20.0, 1e-3, 2e-3), (20.0, 2e-3, 2e-3), (37.0, 1e-3, 2e-3)] {
            let half = 0.5 * TAU * frequency * 2.0 / SPEED;
            let mean = (half.sin() / half).abs();
            let gain = 1.0 / (1.0 + (frequency / CUT_OFF).powi(8)).sqrt();
            let [filtered, unfiltered] = largest_means(frequency, step);
            println!("{frequency} Hz: {filtered:.5} of {:.5}, unfiltered {unfiltered:.5} of {mean:.5}", mean * gain);
            assert!((unfiltered / mean - 1.0).abs() < 2e-3 && (filtered / (mean * gain) - 1.0).abs() < tolerance, "{frequency}");
        }
    }

    /// A run's steps are some milliseconds long on one stretch and tens on the next: the filtered mean must not swing between them. Against steps of 1 mm.
    #[test]
    fn analytic_mean_where_long_steps_follow_short_ones() {
        let filter = SlidingMean::new(2.0);
        // q rises from 0 to 1 over half a wave, 2 m long, between 8 and 10 m.
        let integral = |s: f64| {
            let rising = (s - 8.0).clamp(0.0, 2.0);
            [s, 0.5 * rising - (0.5 * TAU * 0.5 * rising).sin() / TAU + (s - 10.0).max(0.0), 0.0, 0.0]
        };
        let mean = |at: f64, memory: &MeanMemory| filter.mean(0, Averaged::Filtered, at / SPEED, &integral(at), memory);
        let mut worst = 0.0f64;
        for phase in 0..12 {
            let [mut fine, mut memory] = [(); 2].map(|()| MeanMemory::default());
            let (mut s, mut at) = (0.0, 0.0);
            for k in phase.. {
                let step = if k % 12 < 9 { 0.034 } else { 0.4 };
                filter.note(s / SPEED, &integral(s), &mut memory);
                if s > 16.0 {
                    break;
                }
                for part in [0.3, 0.6, 0.9, 1.0] {
                    let reading = s + part * step;
                    while at < reading {
                        filter.note(at / SPEED, &integral(at), &mut fine);
                        at += 1e-3;
                    }
                    worst = worst.max((mean(reading, &memory) - mean(reading, &fine)).abs());
                }
                s += step;
            }
        }
        println!("off by at most {worst:.1e}");
        // With a constant input over each step and a polynomial through four entries: 4.3e-3.
        assert!(worst < 3.5e-3, "{worst}");
    }

    /// A quantity that jumps where a step ends, as an input makes it, after long steps and before short ones; and back.
    #[test]
    fn analytic_mean_over_a_jump() {
        let filter = SlidingMean::new(2.0);
        let integral = |s: f64| [s, 30.0 * (s - 6.0).clamp(0.0, 0.2) + 2.0 * s, 0.0, 0.0];
        let mut memory = MeanMemory::default();
        let (mut s, mut worst) = (0.0, 0.0f64);
        while s < 12.0 {
            filter.note(s / SPEED, &integral(s), &mut memory);
            let step = if (6.0..6.4).contains(&s) { 0.01 } else { 0.6 };
            for part in [0.0, 0.2, 0.5, 0.8, 1.0] {
                let at = s + part * step;
                let begin = (at - 2.0).max(0.0);
                if at > 0.0 {
                    let exact = (integral(at)[1] - integral(begin)[1]) / (at - begin);
                    worst = worst.max((filter.mean(0, Averaged::Unfiltered, at / SPEED, &integral(at), &memory) - exact).abs());
                }
            }
            s = if ((s + step) - 6.0).abs() < 1e-6 { 6.0 } else { s + step };
        }
        println!("off by {worst:.3} of 3");
        // Slopes from the chords on both sides: 1.3. Within entries 33 mm apart the jump's place is not known.
        assert!(worst < 0.06, "{worst}");
    }

    /// A step that ended at B is cut at C: readings before C, and all that follow, are those of a run that never saw B.
    #[test]
    fn regress_steps_that_are_cut_leave_nothing_behind() {
        let filter = SlidingMean::new(2.0);
        let integral = |s: f64| [s, (3.0 * s).sin() / 3.0, 0.0, 0.0];
        let [mut plain, mut cut] = [(); 2].map(|()| MeanMemory::default());
        let mut s = 0.0;
        for k in 0..400 {
            let step = [0.02, 0.3, 0.11, 0.05][k % 4];
            s += step;
            if k % 3 == 1 {
                // Beyond C q is another one.
                let beyond = [s + 0.2, integral(s)[1] + 7.0, 0.0, 0.0];
                filter.note((s + 0.2) / SPEED, &beyond, &mut cut);
            }
            for memory in [&mut plain, &mut cut] {
                filter.note(s / SPEED, &integral(s), memory);
            }
            for at in [s - 0.6 * step, s] {
                let [plain, cut] = [&plain, &cut].map(|memory| filter.mean(0, Averaged::Filtered, at / SPEED, &integral(at), memory));
                assert_eq!(plain, cut, "{at}");
            }
        }
    }

    #[test]
    fn prop_a_halt_keeps_the_mean() {
        let filter = SlidingMean::new(2.0);
        let mut memory = MeanMemory::default();
        // Stands, runs 5 m with q = 4, stands again.
        let travelled = |t: f64| SPEED * (t - 0.1).clamp(0.0, 5.0 / SPEED);
        let mut t = 0.0;
        while t < 0.5 {
            let states = [travelled(t), 4.0 * travelled(t), 0.0, 0.0];
            filter.note(t, &states, &mut memory);
            let mean = filter.mean(0, Averaged::Filtered, t, &states, &memory);
            assert!(if travelled(t) > 1e-6 { (mean - 4.0).abs() < 1e-9 } else { mean == 0.0 }, "{t}: {mean}");
            t += 1e-3;
        }
    }
}
