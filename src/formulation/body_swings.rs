//! How far bodies that are no wheelsets swing at present: cars, frames, motors on their springs, vehicles on their couplers.
//!
//! A tolerance in metres says little of a swing that is not much larger (see [`super::swing`]): an undamped car on smooth track, 2 mm at 1.4 Hz, faded by 0.027 1/s at 1e-5, wagons of
//! a train by 0.165 for 0.045 1/s. So each coordinate of a body has a swing of its own, against which a step's error is held on plain track:
//!
//! ```text
//! |e| <= r max(A, A_0),   r = 5e-3 (1 - p) between 5e-5 and 5e-3,   A_0 = 0.1 mm, 0.05 mrad
//! ```
//!
//! A: an envelope of what it is off its slow mean; p: what a peak keeps of the one before on its side, the more lasting side counts. A damping of 20 % has p = 0.28 and hardly feels it; where
//! nothing is known yet r = 5e-4. Some seven steps in a period then change the logarithmic decrement by 4 % of itself at most.
//!
//! Coordinates relative to the track beside the body: along it relative to the foremost of all bodies, across, up, and three angles.

use super::envelope::Envelope;
use super::{Model, Workspace};
use crate::mbs::body::COORDINATES;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// r per part that a peak loses, its bounds, and where no peaks are known.
const PER_LOSS: f64 = 5e-3;
const LEAST: f64 = 5e-5;
const UNKNOWN: f64 = 5e-4;
/// Swings below this do not matter, m and rad.
const SMALLEST: [f64; 2] = [1e-4, 5e-5];
/// Places of the angles among the coordinates: yaw, roll, pitch.
const ANGLES: usize = 3;

/// Peaks of a swing about its mean, on either side (above: second).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Peaks {
    above: bool,
    /// Of the present half swing.
    peak: f64,
    /// Of the last whole one on each side, and what it kept of the one before.
    last: [Option<f64>; 2],
    kept: [Option<f64>; 2],
}

impl Peaks {
    fn note(&mut self, from_mean: f64) {
        let above = from_mean > 0.0;
        if above != self.above {
            let side = usize::from(self.above);
            self.kept[side] = self.last[side].map(|last| self.peak / last);
            self.last[side] = Some(self.peak);
            *self = Peaks { above, peak: 0.0, ..*self };
        }
        self.peak = self.peak.max(from_mean.abs());
        // A swing that has begun anew is known at once.
        let side = usize::from(above);
        if let (Some(last), Some(kept)) = (self.last[side], &mut self.kept[side]) {
            *kept = kept.max(self.peak / last);
        }
    }

    /// r.
    fn share(&self) -> f64 {
        let [below, above] = self.kept;
        let (Some(below), Some(above)) = (below, above) else { return UNKNOWN };
        (PER_LOSS * (1.0 - below.max(above))).clamp(LEAST, PER_LOSS)
    }
}

/// One coordinate of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Coordinate {
    envelope: Envelope,
    peaks: Peaks,
}

/// All of a body; part of a simulation's state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BodySwing([Coordinate; COORDINATES]);

impl Model {
    /// Bodies that are no wheelsets and no wheels of their own.
    fn carried(&self) -> impl Iterator<Item = usize> {
        let rolls = |body: &usize| self.wheelsets.iter().any(|wheelset| wheelset.body == *body || wheelset.turning.contains(body));
        (0..self.system.bodies.len()).filter(move |body| !rolls(body))
    }

    /// Before the first step.
    pub(super) fn body_swings(&self) -> Vec<BodySwing> {
        self.carried().map(|_| BodySwing::default()).collect()
    }

    /// Notes the end of a step at which the workspace's evaluation was made.
    pub(super) fn note_body_swings(&self, workspace: &Workspace, (fading, first): (f64, bool), swings: &mut [BodySwing]) {
        let motions = &workspace.system.motions;
        let leading = motions.iter().map(|motion| motion.distance).fold(f64::NEG_INFINITY, f64::max);
        for (body, BodySwing(own)) in self.carried().zip(swings) {
            let motion = &motions[body];
            let place = match workspace.system.stations.get(body) {
                None => motion.position,
                Some(station) => station.frame.components(&(motion.position - station.frame.origin)),
            };
            let [ahead, left] = [0, 1].map(|axis| workspace.in_track(body, motion.frame.axes.column(axis).into_owned()));
            let now = [motion.distance - leading, place.y, place.z, ahead.y, left.z, -ahead.z];
            for (Coordinate { envelope, peaks }, now) in own.iter_mut().zip(now) {
                envelope.note(now, fading, first);
                peaks.note(now - envelope.mean);
            }
        }
    }

    /// An error of the state in parts of what the swings allow; the workspace holds an evaluation nearby.
    pub(super) fn body_swing_error(&self, workspace: &Workspace, swings: &[BodySwing], error: &[f64]) -> f64 {
        let of = |(body, BodySwing(own)): (usize, &BodySwing)| {
            let error = &error[COORDINATES * body..COORDINATES * (body + 1)];
            let place = workspace.in_track(body, Vector3::new(error[0], error[1], error[2]));
            let error = [place.x, place.y, place.z, error[3], error[4], error[5]];
            let part = |(i, Coordinate { envelope, peaks }): (usize, &Coordinate)| {
                error[i].abs() / (peaks.share() * envelope.amplitude.max(SMALLEST[usize::from(i >= ANGLES)]))
            };
            own.iter().enumerate().map(part).fold(0.0, f64::max)
        };
        self.carried().zip(swings).map(of).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn analytic_what_a_swing_loses_says_how_much_a_step_may_take() {
        let share = |rate: f64, mean: f64| {
            let mut peaks = Peaks::default();
            for i in 0..800 {
                let t = 0.005 * f64::from(i);
                peaks.note(mean + (-rate * t).exp() * (TAU * 1.4 * t).sin());
            }
            peaks.share()
        };
        assert_eq!([share(0.0, 0.0), share(-0.3, 0.0), share(0.0, 2.0)], [LEAST, LEAST, UNKNOWN]);
        // By a whole period's decay.
        let kept = (-0.16_f64 / 1.4).exp();
        assert!((share(0.16, 0.0) / (PER_LOSS * (1.0 - kept)) - 1.0).abs() < 0.05, "{}", share(0.16, 0.0));
    }
}
