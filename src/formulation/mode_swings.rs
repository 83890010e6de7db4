//! By how much the modes of the bodies swing at present, and what a step's error is to them ([`super::body_modes`]).

use super::body_modes::{BodyMode, Part};
use super::envelope::Envelope;
use super::{Model, Workspace};
use crate::mbs::body::{COORDINATES, Wrench, YAW};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Periods over which mean and envelope go.
const PERIODS: f64 = 3.0;
/// Swings below this may fade faster, m/s2.
const SMALLEST: f64 = 0.2;

/// Part of its amplitude that the third-order method's error estimate is in a step of the angle y [rad] of a swing, over y cubed.
const ESTIMATE: f64 = 0.039;

/// A swing of bodies that asks for short steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Vibration {
    /// That moves most.
    pub body: String,
    /// Hz.
    pub frequency: f64,
    /// The longest step of the third-order method while it swings, s.
    pub step: f64,
}

impl Model {
    /// The one that asks for the shortest steps.
    pub fn quickest_vibration(&self) -> Option<Vibration> {
        let of = |BodyMode { rate, share, parts, .. }: &BodyMode| {
            let size = |part: &Part| part.by_force.iter().map(|own| own.abs()).fold(0.0, f64::max);
            let most = parts.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
            let body = self.system.bodies[most.body].name.clone();
            Some(Vibration { body, frequency: rate / TAU, step: (share / ESTIMATE).cbrt() / rate })
        };
        self.body_modes.iter().filter(|mode| mode.share.is_finite()).filter_map(of).min_by(|a, b| a.step.total_cmp(&b.step))
    }

    /// Notes the end of a step, `since` [s] after the one before (`None`: the first), at which the workspace's evaluation was made.
    pub(super) fn note_mode_swings(&self, workspace: &Workspace, since: Option<f64>, envelopes: &mut [Envelope]) {
        for (BodyMode { rate, parts, .. }, envelope) in self.body_modes.iter().zip(envelopes).filter(|(mode, _)| mode.share.is_finite()) {
            let fading = since.map_or(1.0, |since| 1.0 - (-since * rate / (TAU * PERIODS)).exp());
            let of = |Part { body, by_force, .. }: &Part| {
                let Wrench { force, moment } = workspace.system.wrenches[*body];
                dot(by_force, &along_and_about(workspace, *body, [force, moment]))
            };
            envelope.note(parts.iter().map(of).sum(), fading, since.is_none());
        }
    }

    /// The largest error of a mode in parts of what its swing allows; the workspace holds an evaluation nearby.
    pub(super) fn mode_swing_error(&self, workspace: &Workspace, envelopes: &[Envelope], error: &[f64]) -> f64 {
        let (places, speeds) = error.split_at(COORDINATES * self.system.bodies.len());
        let of = |(BodyMode { rate, share, parts, led }, envelope): (&BodyMode, &Envelope)| {
            let [place, speed] = [places, speeds].map(|error| {
                let part = |Part { body, by_place, .. }: &Part| {
                    let own = &error[COORDINATES * body..COORDINATES * (body + 1)];
                    let linear = workspace.in_track(*body, Vector3::new(own[0], own[1], own[2]));
                    dot(by_place, &[linear.x, linear.y, linear.z, own[3], own[4], own[5]])
                };
                let follows = |(wheelset, [along, across, yaw]): &(usize, [f64; 3])| {
                    let own = &error[COORDINATES * wheelset..];
                    let linear = workspace.in_track(*wheelset, Vector3::new(own[0], own[1], own[2]));
                    along * linear.x + across * linear.y + yaw * own[YAW]
                };
                parts.iter().map(part).sum::<f64>() + led.iter().map(follows).sum::<f64>()
            });
            rate * (rate * place).hypot(speed) / (share * envelope.amplitude.max(SMALLEST))
        };
        self.body_modes.iter().zip(envelopes).filter(|(mode, _)| mode.share.is_finite()).map(of).fold(0.0, f64::max)
    }
}

/// Force and moment on a body as the generalised forces of small displacements along, across, up, and turns in yaw, roll, pitch.
fn along_and_about(workspace: &Workspace, body: usize, wrench: [Vector3<f64>; 2]) -> [f64; COORDINATES] {
    let [force, moment] = wrench.map(|vector| workspace.in_track(body, vector));
    [force.x, force.y, force.z, moment.z, moment.x, moment.y]
}

fn dot(one: &[f64; COORDINATES], other: &[f64; COORDINATES]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}
