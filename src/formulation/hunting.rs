//! Wheelsets that swing from flange to flange: what their forces at one instant are worth.
//!
//! A hunting wheelset is held by nothing between its flanges, and small differences grow with the swing: an error of some micrometres when the swing is a millimetre is some tenths of a
//! millimetre of y when it has reached the flanges, and shifts each strike by a millisecond, in which the force of a strike changes by most of itself. Largest values and the frequency hold;
//! the instants do not.

use super::strikes::FLANGE;
use super::{Model, Workspace, contact_index};
use crate::geometry::Side;
use serde::{Deserialize, Serialize};

/// On plain track, where nothing but itself moves the wheelset, the root of a flange counts as one (sine of the normal's angle across the track): 17 degrees.
const ROOT: f64 = 0.3;
/// The other flange has to be met within this time for it to be one swing, s: half a wave at 0.5 Hz.
const WITHIN: f64 = 1.0;
/// Changes from side to side after which a wheelset hunts.
const MANY: u32 = 3;

/// Of one wheelset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Turns {
    /// Which flange carried last (the left one?), and when, s.
    last: Option<(bool, f64)>,
    /// Changes of side without a pause, and when the first was, s.
    count: u32,
    first: f64,
    /// Since when it hunts, and when that was clear, s.
    found: Option<(f64, f64)>,
}

impl Turns {
    fn note(&mut self, left: bool, t: f64) {
        if let Some((before, at)) = self.last
            && before != left
        {
            self.count = if t - at > WITHIN { 0 } else { self.count.saturating_add(1) };
            if self.count == 1 {
                self.first = t;
            }
            if self.count >= MANY && self.found.is_none() {
                self.found = Some((self.first, t));
            }
        }
        self.last = Some((left, t));
    }

    fn take_back(&mut self, time: f64) {
        if self.last.is_some_and(|last| last.1 > time) {
            *self = Turns { found: self.found.filter(|found| found.1 <= time), ..Turns::default() };
        }
    }
}

/// Forgets what was noted after `time` [s].
pub(super) fn take_back(turns: &mut [Turns], time: f64) {
    turns.iter_mut().for_each(|own| own.take_back(time));
}

/// Notes which flanges carry in the evaluation that the workspace holds, at `t` [s], on plain track or not.
pub(super) fn look(model: &Model, workspace: &Workspace, (t, plain): (f64, bool), turns: &mut [Turns]) {
    let least = if plain { ROOT } else { FLANGE };
    for (index, (wheelset, own)) in model.wheelsets.iter().zip(turns).enumerate() {
        let [left, right] = Side::BOTH.map(|side| workspace.lean(contact_index(index, side), wheelset.body).unwrap_or(0.0));
        if left.max(right) > least && left.min(right) < ROOT {
            own.note(left > right, t);
        }
    }
}

/// What a user should know of the wheelset that has swung longest.
pub(super) fn note(model: &Model, turns: &[Turns]) -> Option<String> {
    let hunting = || model.wheelsets.iter().zip(turns).filter_map(|(wheelset, own)| Some((wheelset, own.found?.0)));
    let (wheelset, since) = hunting().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let others = match hunting().count() {
        1 => String::new(),
        more => format!(" (so do {} more)", more - 1),
    };
    Some(format!(
        "{} swings from flange to flange from {since:.3} s on{others}: small errors grow with such a swing and shift its strikes, so that forces and y at one instant hold less than the \
         tolerances say, largest values and frequencies do; a run with a tenth of solver.tolerance and of solver.load_tolerance shows how far both hold",
        wheelset.name
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swung(strikes: &[(bool, f64)]) -> Turns {
        let mut turns = Turns::default();
        strikes.iter().for_each(|(left, t)| turns.note(*left, *t));
        turns
    }

    #[test]
    fn prop_flanges_in_turn_are_hunting_and_one_flange_is_not() {
        assert!(swung(&[(true, 0.1), (true, 0.11), (false, 0.2), (true, 0.3), (false, 0.4)]).found.is_some());
        assert!(swung(&[(true, 0.1), (true, 0.2), (true, 0.3), (true, 0.4)]).found.is_none(), "a curve");
        assert!(swung(&[(true, 1.0), (false, 10.0), (true, 20.0), (false, 30.0)]).found.is_none(), "curves in turn");
        assert!(swung(&[(true, 0.1), (false, 0.2), (true, 0.3), (false, 0.4), (true, 9.0)]).found.is_some(), "forgotten");
        let mut back = [swung(&[(true, 0.1), (false, 0.2), (true, 0.3), (false, 0.4)])];
        assert_eq!(back[0].found, Some((0.2, 0.4)));
        take_back(&mut back, 0.4);
        assert!(back[0].found.is_some());
        take_back(&mut back, 0.35);
        assert_eq!(back[0], Turns::default());
    }
}
