//! How far bodies that are no wheelsets swing at present: cars, frames, motors on their springs, vehicles on their couplers.
//!
//! A tolerance in metres says little of a swing that is not much larger (see [`super::swing`]): an undamped car on smooth track, 2 mm at 1.4 Hz, faded by 0.027 1/s at 1e-5, wagons of
//! a train by 0.165 for 0.045 1/s. So each coordinate of a body has a swing of its own, against which a step's error is held:
//!
//! ```text
//! |e| <= max(r A, e_0),   r = 1e-3 (1 - p) between 5e-5 and 1e-3,   e_0 = 0.02 um, 0.01 urad
//! ```
//!
//! A: an envelope of what it is off its slow mean; p: what a peak keeps of the one before on its side, the less of two in a row, the more of both sides. A damping of 20 % has p = 0.28 and hardly feels it.
//! Some seven steps in a period then change the logarithmic decrement by 0.8 % of itself at most. Before two peaks on a side have followed each other, and on waves of the track that pass within 2 s, r is 1e-3 and e_0 = 2 um, 2 urad.
//!
//! Coordinates relative to the track beside the body: along it relative to the foremost of all bodies, across, up, and three angles. What bodies do beside each other is seen by
//! their modes ([`super::body_modes`]).

use super::envelope::Envelope;
use super::half_swings::HalfSwings;
use super::{Model, Workspace};
use crate::mbs::body::COORDINATES;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// r per part that a peak loses, and its bounds.
const PER_LOSS: f64 = 1e-3;
const LEAST: f64 = 5e-5;
/// Errors below this do not matter, m and rad.
const SMALLEST: [f64; 2] = [2e-8, 1e-8];
/// r where no swing is known yet, or a track's waves move bodies anyhow, and errors that do not matter then.
const UNKNOWN: f64 = 1e-3;
const SMALLEST_UNKNOWN: [f64; 2] = [2e-6, 2e-6];
/// Places of the angles among the coordinates: yaw, roll, pitch.
const ANGLES: usize = 3;

/// r; `None` where no swing is known.
fn share(swings: &HalfSwings) -> Option<f64> {
    swings.kept().map(|kept| (PER_LOSS * (1.0 - kept)).clamp(LEAST, PER_LOSS))
}

/// One coordinate of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Coordinate {
    envelope: Envelope,
    halves: HalfSwings,
}

/// All of a body, by its number; part of a simulation's state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BodySwing {
    body: usize,
    coordinates: [Coordinate; COORDINATES],
}

impl Model {
    /// Bodies that are no wheelsets and no wheels of their own.
    fn carried(&self) -> impl Iterator<Item = usize> {
        let rolls = |body: &usize| self.wheelsets.iter().any(|wheelset| wheelset.body == *body || wheelset.turning.contains(body));
        (0..self.system.bodies.len()).filter(move |body| !rolls(body))
    }

    /// Before the first step.
    pub(super) fn body_swings(&self) -> Vec<BodySwing> {
        self.carried().map(|body| BodySwing { body, ..BodySwing::default() }).collect()
    }

    /// Notes the end of a step at which the workspace's evaluation was made.
    pub(super) fn note_body_swings(&self, workspace: &Workspace, (fading, first): (f64, bool), swings: &mut [BodySwing]) {
        let motions = &workspace.system.motions;
        let leading = motions.iter().map(|motion| motion.distance).fold(f64::NEG_INFINITY, f64::max);
        for BodySwing { body, coordinates } in swings {
            let now = beside_track(workspace, *body, leading);
            for (Coordinate { envelope, halves }, now) in coordinates.iter_mut().zip(now) {
                envelope.note(now, fading, first);
                halves.note(now - envelope.mean);
            }
        }
    }

    /// An error of the state in parts of what the swings allow; the workspace holds an evaluation nearby.
    pub(super) fn body_swing_error(&self, workspace: &Workspace, (swings, calm): (&[BodySwing], bool), error: &[f64]) -> f64 {
        let of = |BodySwing { body, coordinates }: &BodySwing| {
            let own = &error[COORDINATES * body..COORDINATES * (body + 1)];
            let place = workspace.in_track(*body, Vector3::new(own[0], own[1], own[2]));
            let error = [place.x, place.y, place.z, own[3], own[4], own[5]];
            let part = |(i, Coordinate { envelope, halves }): (usize, &Coordinate)| {
                let kind = usize::from(i >= ANGLES);
                let allowed = match share(halves) {
                    Some(share) if calm => (share * envelope.amplitude).max(SMALLEST[kind]),
                    share => (share.unwrap_or(UNKNOWN).max(UNKNOWN) * envelope.amplitude).max(SMALLEST_UNKNOWN[kind]),
                };
                error[i].abs() / allowed
            };
            coordinates.iter().enumerate().map(part).fold(0.0, f64::max)
        };
        swings.iter().map(of).fold(0.0, f64::max)
    }
}

/// Of a body relative to the track beside it.
fn beside_track(workspace: &Workspace, body: usize, leading: f64) -> [f64; COORDINATES] {
    let motion = &workspace.system.motions[body];
    let place = match workspace.system.stations.get(body) {
        None => motion.position,
        Some(station) => station.frame.components(&(motion.position - station.frame.origin)),
    };
    let [ahead, left] = [0, 1].map(|axis| workspace.in_track(body, motion.frame.axes.column(axis).into_owned()));
    [motion.distance - leading, place.y, place.z, ahead.y, left.z, -ahead.z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn analytic_what_a_swing_loses_says_how_much_a_step_may_take() {
        let share = |of: &dyn Fn(f64) -> f64| {
            let mut halves = HalfSwings::default();
            (0..800).for_each(|i| halves.note(of(0.005 * f64::from(i))));
            share(&halves)
        };
        let swing = |rate: f64| move |t: f64| (-rate * t).exp() * (TAU * 1.4 * t).sin();
        assert_eq!([share(&swing(0.0)), share(&swing(-0.2)), share(&|t| 2.0 + swing(0.0)(t))], [Some(LEAST), Some(LEAST), None]);
        // By a whole period's decay.
        let kept = (-0.16_f64 / 1.4).exp();
        let found = share(&swing(0.16)).unwrap();
        assert!((found / (PER_LOSS * (1.0 - kept)) - 1.0).abs() < 0.05, "{found}");
        // Aside and back, once; and a blow after a swing that had faded.
        assert_eq!(share(&|t| (-(t - 1.0).powi(2)).exp() - (-(t - 2.5).powi(2)).exp()), None);
        assert_eq!(share(&|t| if t < 3.3 { swing(2.0)(t) } else { 5.0 * swing(0.0)(t) }), None);
    }
}
