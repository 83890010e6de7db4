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
//! Coordinates relative to the track beside the body: along it relative to the foremost of all bodies, across, up, and three angles; and those of bodies that force elements hold together relative to
//! each other, because a box on a car swings by much less than the car does (400 kg at 12 Hz, 70 um, on a car that crossed a dip of 20 mm: it lost nine tenths in 2 s without damping, 20 % with 1 %).

use super::envelope::Envelope;
use super::half_swings::HalfSwings;
use super::{Model, Workspace};
use crate::mbs::body::{BodyMotion, COORDINATES};
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
/// r of bodies relative to each other where the track is calm: what their swings do is not known while the car's own, slower one moves them too.
const UNKNOWN_BETWEEN: f64 = 2e-4;
/// Errors that do not matter for bodies relative to each other.
const SMALLEST_BETWEEN: [f64; 2] = [5e-8, 5e-8];
/// Swings below this are rounding, m and rad: what their peaks keep says nothing, and would differ from machine to machine.
const ROUNDING: f64 = 1e-10;
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

/// All of a body, by its number, relative to the track or to another body; part of a simulation's state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BodySwing {
    body: usize,
    against: Option<usize>,
    coordinates: [Coordinate; COORDINATES],
}

impl Model {
    /// Bodies that are no wheelsets and no wheels of their own.
    fn carried(&self) -> impl Iterator<Item = usize> {
        let rolls = |body: &usize| self.wheelsets.iter().any(|wheelset| wheelset.body == *body || wheelset.turning.contains(body));
        (0..self.system.bodies.len()).filter(move |body| !rolls(body))
    }

    /// Pairs of them that force elements hold together.
    fn held_together(&self) -> Vec<[usize; 2]> {
        let carried: Vec<usize> = self.carried().collect();
        let mut pairs: Vec<[usize; 2]> = Vec::new();
        for ends in self.system.forces.iter().map(|force| force.bodies()) {
            let [Some(from), Some(to)] = ends else { continue };
            let pair = [from.min(to), from.max(to)];
            if from != to && pair.iter().all(|body| carried.contains(body)) && !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        pairs
    }

    /// Before the first step.
    pub(super) fn body_swings(&self) -> Vec<BodySwing> {
        let alone = self.carried().map(|body| BodySwing { body, ..BodySwing::default() });
        let pairs = self.held_together().into_iter().map(|[from, to]| BodySwing { body: to, against: Some(from), ..BodySwing::default() });
        alone.chain(pairs).collect()
    }

    /// Notes the end of a step at which the workspace's evaluation was made.
    pub(super) fn note_body_swings(&self, workspace: &Workspace, (fading, first): (f64, bool), swings: &mut [BodySwing]) {
        let motions = &workspace.system.motions;
        let leading = motions.iter().map(|motion| motion.distance).fold(f64::NEG_INFINITY, f64::max);
        for BodySwing { body, against, coordinates } in swings {
            let now = match against {
                None => beside_track(workspace, *body, leading),
                Some(against) => beside_body(&motions[*against], &motions[*body]),
            };
            for (Coordinate { envelope, halves }, now) in coordinates.iter_mut().zip(now) {
                envelope.note(now, fading, first);
                if envelope.amplitude > ROUNDING {
                    halves.note(now - envelope.mean);
                }
            }
        }
    }

    /// An error of the state in parts of what the swings allow; the workspace holds an evaluation nearby.
    pub(super) fn body_swing_error(&self, workspace: &Workspace, (swings, calm): (&[BodySwing], bool), error: &[f64]) -> f64 {
        let motions = &workspace.system.motions;
        let own = |body: usize| {
            let error = &error[COORDINATES * body..COORDINATES * (body + 1)];
            (workspace.in_track(body, Vector3::new(error[0], error[1], error[2])), [error[3], error[4], error[5]])
        };
        let of = |BodySwing { body, against, coordinates }: &BodySwing| {
            let (mut place, mut angles) = own(*body);
            let unknown = if against.is_some() { &SMALLEST_BETWEEN } else { &SMALLEST_UNKNOWN };
            if let Some(against) = *against {
                let (carrier, turned) = own(against);
                let arm = workspace.in_track(against, motions[*body].position - motions[against].position);
                let [yaw, roll, pitch] = turned;
                place -= carrier + Vector3::new(roll, pitch, yaw).cross(&arm);
                angles.iter_mut().zip(turned).for_each(|(angle, turned)| *angle -= turned);
            }
            let error = [place.x, place.y, place.z, angles[0], angles[1], angles[2]];
            let part = |(i, Coordinate { envelope, halves }): (usize, &Coordinate)| {
                let kind = usize::from(i >= ANGLES);
                let allowed = match share(halves) {
                    share if calm && against.is_some() => {
                        share.unwrap_or(UNKNOWN_BETWEEN) * envelope.amplitude.max(SMALLEST[kind] / PER_LOSS)
                    }
                    Some(share) if calm => (share * envelope.amplitude).max(SMALLEST[kind]),
                    share => (share.unwrap_or(UNKNOWN).max(UNKNOWN) * envelope.amplitude).max(unknown[kind]),
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

/// Of a body in another one's axes.
fn beside_body(carrier: &BodyMotion, body: &BodyMotion) -> [f64; COORDINATES] {
    let axes = &carrier.frame.axes;
    let place = axes.tr_mul(&(body.position - carrier.position));
    let [ahead, left] = [0, 1].map(|axis| axes.tr_mul(&body.frame.axes.column(axis)));
    [place.x, place.y, place.z, ahead.y, left.z, -ahead.z]
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
