//! How far wheelsets swing at present, so that growth and decay of small swings are right at loose tolerances too.
//!
//! A tolerance in metres says nothing of a swing that is not much larger: a hunting motion of 1 mm at 4 Hz gets seven steps in a period at 1e-5 m,
//! and loses in each of them more than it gains by its instability (growth of -0.02 1/s for 0.062, at 1e-4 -1.2). So a step's error is also held
//! against the swing's amplitude:
//!
//! ```text
//! |e_y| <= r A_y,   |e_yaw| <= r A_yaw,   A_y >= 1 um, 0.2 mm on a track's waves
//! r = 5e-5 where it does not fade on plain track, where nothing but its own stability decides what becomes of it; 1.5e-4 elsewhere
//! ```
//!
//! What a step loses of a swing that fades, fades with it. In one that grows, an error grows as well, from a micrometre on the wave that set it going to a tenth
//! of a millimetre when its flanges strike. A is an envelope: the largest distance from a slow mean, which fades with the mean's own time. A swing fades when
//! its peaks on either side do. On a track's waves nobody knows yet what the swing will do; r = 5e-5 there too took a third more steps of a coach at 70 m/s.

use super::body_swings::BodySwing;
use super::envelope::Envelope;
use super::half_swings::HalfSwings;
use super::step::WheelRef;
use super::torsion::Torsion;
use super::{Model, Workspace};
use crate::mbs::body::{COORDINATES, YAW};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// r, -.
const SHARE: f64 = 1.5e-4;
/// r of a swing that does not fade where nothing moves the wheelset but itself, -.
const GROWING_SHARE: f64 = 5e-5;
/// A peak that is not below this part of the one before on its side has not faded, -.
const FADED: f64 = 0.98;
/// Swings below this do not matter, m; the same in yaw, rad: that of a wave of 60 m.
const SMALLEST: [f64; 2] = [1e-6, 1e-7];
/// The same where a track's waves move wheelsets anyhow.
const SMALLEST_ON_WAVES: [f64; 2] = [2e-4, 2e-5];
/// Waves that take longer lead cars along, s: hardly any swings so slowly.
const SLOW: f64 = 2.0;
/// Time of mean and envelope, s: a few periods of slow hunting.
const TIME: f64 = 2.0;

/// Those of lateral displacement [m] and yaw [rad] of each wheelset relative to the track; part of a simulation's state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Swings {
    /// End of the last step, s; not a number before the first one.
    time: Option<f64>,
    wheelsets: Vec<[Envelope; 2]>,
    /// Of lateral displacement.
    halves: Vec<HalfSwings>,
    torsions: Vec<Torsion>,
    /// Of the other bodies.
    bodies: Vec<BodySwing>,
    /// Modal accelerations of their modes, m/s2.
    modes: Vec<Envelope>,
    /// Does nothing but its own stability decide what becomes of it?
    plain: bool,
    /// The same of the other bodies, which slow waves only lead along.
    calm: bool,
}

impl Swings {
    /// Could these have come from the same model as `other`?
    pub fn fits(&self, other: &Swings) -> bool {
        self.wheelsets.len() == other.wheelsets.len()
            && self.halves.len() == other.halves.len()
            && self.torsions.len() == other.torsions.len()
            && self.bodies.len() == other.bodies.len()
            && self.modes.len() == other.modes.len()
    }

    /// Does nothing but its own stability decide what becomes of a swing?
    pub fn is_plain(&self) -> bool {
        self.plain
    }
}

impl Model {
    /// Before the first step.
    pub fn swings(&self) -> Swings {
        Swings {
            time: None,
            wheelsets: vec![Default::default(); self.wheelsets.len()],
            halves: vec![Default::default(); self.wheelsets.len()],
            torsions: self.torsions(),
            bodies: self.body_swings(),
            modes: vec![Envelope::default(); self.body_modes.len()],
            plain: false,
            calm: false,
        }
    }

    /// Notes the end of a step at time `t` [s], at which the workspace's evaluation was made.
    pub fn note_swings(&self, workspace: &Workspace, (t, y): (f64, &[f64]), swings: &mut Swings) {
        let fading = swings.time.map_or(1.0, |before| 1.0 - (-(t - before).max(0.0) / TIME).exp());
        for ((envelopes, halves), wheelset) in swings.wheelsets.iter_mut().zip(&mut swings.halves).zip(&self.wheelsets) {
            let now = workspace.beside_track(wheelset.body);
            for (envelope, now) in envelopes.iter_mut().zip(now) {
                envelope.note(now, fading, swings.time.is_none());
            }
            halves.note(now[0] - envelopes[0].mean);
        }
        self.note_torsions(workspace, (swings.time, t), y, &mut swings.torsions);
        self.note_mode_swings(workspace, swings.time.map(|before| (t - before).max(0.0)), &mut swings.modes);
        self.note_body_swings(workspace, (fading, swings.time.is_none()), &mut swings.bodies);
        swings.time = Some(t);
        let shortest = |WheelRef { wheelset, side, .. }: &WheelRef| {
            let motion = &workspace.system.motions[wheelset.body];
            // Seconds for a wave.
            self.track.rail(*side).waves().shortest_at(motion.distance).map(|wave| wave / motion.speed.abs())
        };
        let shortest = self.wheels().filter_map(|wheel| shortest(&wheel)).reduce(f64::min);
        swings.plain = self.out_of_round.is_empty() && shortest.is_none();
        swings.calm = self.out_of_round.is_empty() && shortest.is_none_or(|time| time > SLOW);
    }

    /// An error of the state in parts of what the swings allow; the workspace holds an evaluation nearby.
    pub fn swing_error(&self, workspace: &Workspace, swings: &Swings, error: &[f64]) -> f64 {
        let smallest = if swings.plain { SMALLEST } else { SMALLEST_ON_WAVES };
        // The same for all wheelsets: those of a vehicle swing together, one more, one less.
        let amplitude = |i: usize| swings.wheelsets.iter().map(|envelopes| envelopes[i].amplitude).fold(smallest[i], f64::max);
        let share = if swings.plain && !swings.halves.iter().all(|halves| halves.fade(FADED)) { GROWING_SHARE } else { SHARE };
        let allowed = [share * amplitude(0), share * amplitude(1)];
        let of = |body: usize| {
            let own = &error[COORDINATES * body..COORDINATES * (body + 1)];
            let across = workspace.in_track(body, Vector3::new(own[0], own[1], own[2])).y;
            (across.abs() / allowed[0]).max(own[YAW].abs() / allowed[1])
        };
        let torsion = self.torsion_error(swings.time.unwrap_or(0.0), &swings.torsions, error);
        let bodies = self.body_swing_error(workspace, (&swings.bodies, swings.calm), error);
        let modes = self.mode_swing_error(workspace, &swings.modes, error);
        self.wheelsets.iter().map(|wheelset| of(wheelset.body)).fold(torsion.max(bodies).max(modes), f64::max)
    }
}
