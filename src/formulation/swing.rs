//! How far wheelsets swing at present, so that growth and decay of small swings are right at loose tolerances too.
//!
//! A tolerance in metres says nothing of a swing that is not much larger: a hunting motion of 1 mm at 4 Hz gets seven steps in a period at 1e-5 m,
//! and loses in each of them more than it gains by its instability (growth of -0.02 1/s for 0.062, at 1e-4 -1.2). So on plain track, where
//! nothing but its own stability decides what becomes of a swing, a step's error is also held against the swing's amplitude:
//!
//! ```text
//! |e_y| <= r A_y,   |e_yaw| <= r A_yaw,   r = 1.5e-4,   A_y >= 1 um
//! ```
//!
//! A is an envelope: the largest distance from a slow mean, which fades with the mean's own time. Where a rail or the centre line changes
//! with distance, wheels follow that, and the tolerance alone counts.

use super::step::WheelRef;
use super::{Model, Workspace};
use crate::mbs::body::{COORDINATES, YAW};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// r, -.
const SHARE: f64 = 1.5e-4;
/// Swings below this do not matter, m; the same in yaw, rad: that of a wave of 60 m.
const SMALLEST: [f64; 2] = [1e-6, 1e-7];
/// Time of mean and envelope, s: a few periods of slow hunting.
const TIME: f64 = 2.0;

/// Mean and envelope of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Envelope {
    mean: f64,
    amplitude: f64,
}

/// Those of lateral displacement [m] and yaw [rad] of each wheelset relative to the track; part of a simulation's state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Swings {
    /// End of the last step, s; not a number before the first one.
    time: Option<f64>,
    wheelsets: Vec<[Envelope; 2]>,
    /// Does nothing but its own stability decide what becomes of it?
    plain: bool,
}

impl Swings {
    /// Could these have come from the same model as `other`?
    pub fn fits(&self, other: &Swings) -> bool {
        self.wheelsets.len() == other.wheelsets.len()
    }

    /// Does nothing but its own stability decide what becomes of a swing?
    pub fn is_plain(&self) -> bool {
        self.plain
    }
}

impl Model {
    /// Before the first step.
    pub fn swings(&self) -> Swings {
        Swings { time: None, wheelsets: vec![Default::default(); self.wheelsets.len()], plain: false }
    }

    /// Notes the end of a step at time `t` [s], at which the workspace's evaluation was made.
    pub fn note_swings(&self, workspace: &Workspace, t: f64, swings: &mut Swings) {
        let fading = swings.time.map_or(1.0, |before| 1.0 - (-(t - before).max(0.0) / TIME).exp());
        for (envelopes, wheelset) in swings.wheelsets.iter_mut().zip(&self.wheelsets) {
            let now = workspace.beside_track(wheelset.body);
            for (envelope, now) in envelopes.iter_mut().zip(now) {
                if swings.time.is_none() {
                    envelope.mean = now;
                }
                envelope.mean += fading * (now - envelope.mean);
                let faded = if swings.time.is_none() { 0.0 } else { (1.0 - fading) * envelope.amplitude };
                envelope.amplitude = faded.max((now - envelope.mean).abs());
            }
        }
        swings.time = Some(t);
        swings.plain = self.out_of_round.is_empty()
            && self.wheels().all(|WheelRef { wheelset, side, .. }| {
                self.track.rail(side).waves().shortest_at(workspace.system.motions[wheelset.body].distance).is_none()
            });
    }

    /// An error of the state in parts of what the swings allow; the workspace holds an evaluation nearby.
    pub fn swing_error(&self, workspace: &Workspace, swings: &Swings, error: &[f64]) -> f64 {
        if !swings.plain {
            return 0.0;
        }
        // The same for all wheelsets: those of a vehicle swing together, one more, one less.
        let amplitude = |i: usize| swings.wheelsets.iter().map(|envelopes| envelopes[i].amplitude).fold(SMALLEST[i], f64::max);
        let allowed = [SHARE * amplitude(0), SHARE * amplitude(1)];
        let of = |body: usize| {
            let own = &error[COORDINATES * body..COORDINATES * (body + 1)];
            let across = workspace.in_track(body, Vector3::new(own[0], own[1], own[2])).y;
            (across.abs() / allowed[0]).max(own[YAW].abs() / allowed[1])
        };
        self.wheelsets.iter().map(|wheelset| of(wheelset.body)).fold(0.0, f64::max)
    }
}
