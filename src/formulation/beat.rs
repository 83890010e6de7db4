//! Fast swings of a wheel's load, counted from turn to turn: what a flutter (`flutter`) does to a wheel, and with what frequency.

use serde::{Deserialize, Serialize};

/// Longest time between two turns, s: 40 Hz.
const LONGEST: f64 = 0.0125;

/// What counts.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// In parts of the static load: what is no turn yet, and the least swing from turn to turn that counts.
    wiggle: f64,
    least: f64,
    /// So many turns one after the other.
    turns: u32,
}

/// A swing of which nothing else is known: so many turns are no echo of a single blow, since contact damping ends that within some periods.
pub const GREAT: Limits = Limits { wiggle: 0.02, least: 0.1, turns: 30 };
/// A swing of a wheelset that is known to flutter.
pub const SMALL: Limits = Limits { wiggle: 0.004, least: 0.01, turns: 6 };

/// Swings that went on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Swing {
    /// s.
    pub since: f64,
    /// Hz, over the longest run of turns.
    pub frequency: f64,
    /// Largest from turn to turn, in parts of the static load.
    pub size: f64,
    turns: u32,
}

/// One wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beat {
    begun: bool,
    rising: bool,
    /// Share of the static load and time [s] of the last turn and of the farthest since then.
    turn: (f64, f64),
    farthest: (f64, f64),
    /// Turns one after the other, where they began [s], and the largest swing in them.
    turns: u32,
    begin: f64,
    largest: f64,
    /// What was found.
    pub swing: Option<Swing>,
}

impl Beat {
    /// Forgets what came after `time` [s]; turns are then counted anew.
    pub fn take_back(&mut self, time: f64) {
        if self.begun && self.turn.1 > time {
            *self = Beat { swing: self.swing.filter(|swing| swing.since <= time), ..Beat::default() };
        }
    }

    /// Has it turned so that it counts?
    pub fn counts(&self) -> bool {
        self.turns > 0
    }

    /// What comes next is no part of a swing that goes on.
    pub fn interrupt(&mut self) {
        if self.begun {
            *self = Beat { swing: self.swing, ..Beat::default() };
        }
    }

    /// Takes the wheel's force, in parts of its static load, at `t` [s].
    pub fn note(&mut self, share: f64, t: f64, limits: &Limits) {
        if !share.is_finite() {
            return;
        }
        if !self.begun {
            *self = Beat { begun: true, turn: (share, t), farthest: (share, t), ..*self };
            return;
        }
        let back = if self.rising { self.farthest.0 - share } else { share - self.farthest.0 };
        if back <= 0.0 {
            self.farthest = (share, t);
        } else if back > limits.wiggle {
            self.note_turn(limits);
            (self.turn, self.farthest, self.rising) = (self.farthest, (share, t), !self.rising);
        }
    }

    /// The farthest place was a turn.
    fn note_turn(&mut self, limits: &Limits) {
        let size = (self.farthest.0 - self.turn.0).abs();
        if !(size >= limits.least && self.farthest.1 - self.turn.1 <= LONGEST) {
            (self.turns, self.largest) = (0, 0.0);
            return;
        }
        if self.turns == 0 {
            self.begin = self.turn.1;
        }
        (self.turns, self.largest) = (self.turns.saturating_add(1), self.largest.max(size));
        if self.turns >= limits.turns && self.swing.is_none_or(|swing| self.turns >= swing.turns) {
            let since = self.swing.map_or(self.begin, |swing| swing.since);
            let frequency = 0.5 * f64::from(self.turns) / (self.farthest.1 - self.begin);
            self.swing = Some(Swing { since, frequency, size: self.largest, turns: self.turns });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(load: impl Fn(f64) -> f64) -> Option<Swing> {
        counted(load, &GREAT)
    }

    fn counted(load: impl Fn(f64) -> f64, limits: &Limits) -> Option<Swing> {
        let mut beat = Beat::default();
        (0..2000).for_each(|k| beat.note(load(5e-4 * f64::from(k)), 5e-4 * f64::from(k), limits));
        beat.swing
    }

    #[test]
    fn analytic_swings_are_counted_with_their_frequency_size_and_begin() {
        let sine = |f: f64, t: f64| (std::f64::consts::TAU * f * t).sin();
        // From 0.3 s on, with a wiggle that is none.
        let found = swing(|t| 1.0 + if t < 0.3 { 0.0 } else { 0.3 * sine(150.0, t) } + 0.004 * sine(900.0, t)).unwrap();
        assert!((found.frequency - 150.0).abs() < 2.0 && (found.size - 0.6).abs() < 0.05 && (found.since - 0.3).abs() < 0.01, "{found:?}");
        // Too slow, too small, an echo that fades within ten periods.
        assert!(swing(|t| 1.0 + 0.5 * sine(30.0, t)).is_none() && swing(|t| 1.0 + 0.045 * sine(150.0, t)).is_none());
        assert!(swing(|t| 1.0 + 0.9 * (-40.0 * t).exp() * sine(150.0, t)).is_none());
        // A slow swing of curves and rails beside it changes nothing.
        let found = swing(|t| 1.2 + 0.3 * sine(5.0, t) + 0.2 * sine(110.0, t)).unwrap();
        assert!((found.frequency - 110.0).abs() < 2.0, "{found:?}");
        // What grows for five periods and fades again counts where flutter is known, and not otherwise.
        let burst = |t: f64| 1.0 + 0.03 * (-(50.0 * (t - 0.5)).powi(2)).exp() * sine(120.0, t);
        let found = counted(burst, &SMALL).unwrap();
        assert!(swing(burst).is_none() && (found.frequency - 120.0).abs() < 6.0 && (found.size - 0.06).abs() < 0.006, "{found:?}");
    }
}
