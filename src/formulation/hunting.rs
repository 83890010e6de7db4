//! Wheelsets that swing from flange to flange: what their forces at one instant are worth.
//!
//! A hunting wheelset is held by nothing between its flanges, and small differences grow with the swing: an error of some micrometres when the swing is a millimetre is some tenths of a
//! millimetre of y when it has reached the flanges, and shifts each strike by a millisecond, in which the force of a strike changes by most of itself. Largest values and the frequency hold;
//! the instants do not.

use super::step::WheelRef;
use super::{Model, Workspace, contact_index};
use crate::geometry::Side;
use serde::{Deserialize, Serialize};

/// A contact is on a flange where its normal leans as much across the track (sine): 30 degrees; on plain track, where nothing but itself moves the wheelset, its root (17 degrees) counts too.
const FLANGE: f64 = 0.5;
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
    /// Changes of side, and when the first was, s.
    count: u32,
    first: f64,
}

impl Turns {
    fn note(&mut self, left: bool, t: f64) {
        if let Some((before, at)) = self.last
            && before != left
        {
            if t - at > WITHIN {
                // What has been seen stays.
                self.count = if self.hunts() { self.count } else { 0 };
            } else {
                self.first = if self.count == 0 { t } else { self.first };
                self.count = self.count.saturating_add(1);
            }
        }
        self.last = Some((left, t));
    }

    fn hunts(&self) -> bool {
        self.count >= MANY
    }
}

/// Forgets what was noted after `time` [s].
pub(super) fn take_back(turns: &mut [Turns], time: f64) {
    for own in turns {
        if own.last.is_some_and(|last| last.1 > time) {
            *own = if own.count > 0 && own.first <= time { Turns { last: None, ..*own } } else { Turns::default() };
        }
    }
}

/// Notes which flanges carry in the evaluation that the workspace holds, at `t` [s].
pub(super) fn look(model: &Model, workspace: &Workspace, t: f64, turns: &mut [Turns]) {
    for (index, (wheelset, own)) in model.wheelsets.iter().zip(turns).enumerate() {
        let [left, right] = Side::BOTH.map(|side| {
            let carrying = workspace.reports(contact_index(index, side)).filter(|report| report.carries());
            carrying.map(|report| workspace.in_track(wheelset.body, report.axes.normal).y.abs()).fold(0.0, f64::max)
        });
        let (more, less) = if left > right { (left, right) } else { (right, left) };
        if less < ROOT && more > ROOT && (more > FLANGE || model.is_plain(workspace)) {
            own.note(left > right, t);
        }
    }
}

/// What a user should know of the wheelset that has swung longest.
pub(super) fn note(model: &Model, turns: &[Turns]) -> Option<String> {
    let hunting = || turns.iter().enumerate().filter(|(_, own)| own.hunts());
    let (index, own) = hunting().min_by(|a, b| a.1.first.total_cmp(&b.1.first))?;
    let WheelRef { wheelset, .. } = model.wheel(contact_index(index, Side::Left));
    let others = match hunting().count() {
        1 => String::new(),
        more => format!(" (so do {} more)", more - 1),
    };
    Some(format!(
        "{} swings from flange to flange from {:.3} s on{others}: small errors grow with such a swing and shift its strikes, so that forces and y at one instant hold less than the \
         tolerances say, largest values and frequencies do; a run with a tenth of solver.tolerance and of solver.load_tolerance shows how far both hold",
        wheelset.name, own.first
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
        assert!(swung(&[(true, 0.1), (true, 0.11), (false, 0.2), (true, 0.3), (false, 0.4)]).hunts());
        assert!(!swung(&[(true, 0.1), (true, 0.2), (true, 0.3), (true, 0.4)]).hunts(), "a curve");
        assert!(!swung(&[(true, 1.0), (false, 10.0), (true, 20.0), (false, 30.0)]).hunts(), "curves in turn");
        assert!(swung(&[(true, 0.1), (false, 0.2), (true, 0.3), (false, 0.4), (true, 9.0)]).hunts(), "forgotten");
        let mut back = [swung(&[(true, 0.1), (false, 0.2), (true, 0.3), (false, 0.4)])];
        assert_eq!(back[0].first, 0.2);
        take_back(&mut back, 0.15);
        assert_eq!(back[0], Turns::default());
    }
}
