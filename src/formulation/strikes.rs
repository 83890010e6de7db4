//! Wheels whose flanges have struck, or that have left their rails: their next strike has to come at the right time.
//!
//! Between strikes of its flanges nothing stiff holds a wheelset across the track, nor a wheel above its rail while it is in the air. What a step loses there,
//! a nanometre or a micrometre at usual tolerances, lasts until the next strike and shifts it. With k the stiffness of a contact and e the error of the place
//! across it, the force at one instant is then off by `k e`, whatever the speed v of the strike: the slope of the force is k v, the shift e / v. So for such a
//! wheelset a step's error counts by the force that it will make,
//!
//! ```text
//! k hypot(e_y, L e_yaw)   across, with 1/L = sqrt(gamma / (r s)) of Klingel's wave: a yaw becomes a displacement in a quarter of a wave
//! k |e_n|, sqrt(k m) |e_n'|   of a wheel in the air, towards its rail
//! k = (6 E*^2 r Q)^(1/3)   of a sphere of the wheel's radius r under its static load Q (Hertz), E* of two equal bodies: 1.2e9 N/m for 0.46 m and 60 kN
//! ```
//!
//! in parts of a fifth of what the scene allows of the static load, from 3 mm before its flange until a second after it touched with it or flew; twice as far away in parts of eight times that,
//! and between by the cube of the way. For a second after a flight all errors of that wheelset's contact forces count more, too ([`FLOWN`]): a blow's error is one of the next
//! flight's length. A wheelset that runs on its treads is not held so: its steps may be longer by half and its loads are as right.

use super::foresight::without_pitch;
use super::step::WheelRef;
use super::{Model, Wheelset, Workspace, contact_index};
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::mbs::body::{COORDINATES, YAW};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Of the load tolerance.
const PART: f64 = 0.2;
/// Of what the forces of other wheels may be off by, for one that has flown of late: what is left of the speed of a blow is the time of the next flight (10 ms of it are
/// a bounce of 0.05 m/s; a hundredth of that is 0.1 ms, in which the next blow rises by half of the static load). Implicit steps, forces at one instant in parts of the static
/// load: wheelsets with flats whose bounces hardly fade 26 and 110 % without this, 3 % with 0.1, 2 and 9 % with 0.05, for 2.3 times the steps; with the damping of
/// embedded scenes 0.7 to 2.9 % without this, 0.1 to 1.5 % with 0.05.
const FLOWN: f64 = 0.05;
/// So long after a strike the next one may come, s: half a wave of hunting at 0.5 Hz.
const LASTING: f64 = 1.0;
/// Nearer than this to its flange a wheel may strike, m.
const NEAR: f64 = 3e-3;
/// Farther than this many times that it will not soon.
const FAR: f64 = 2.0;
/// A contact is on a flange where its normal leans as much across the track (sine): 30 degrees.
pub(super) const FLANGE: f64 = 0.5;
/// gamma in L, -.
const CONICITY: f64 = 0.15;

/// What is known of one wheelset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Striking {
    /// Until when it counts as one that strikes, s.
    until: Option<f64>,
    /// Until when an error of its forces counts as what decides on its next flight, s.
    flying: Option<f64>,
    /// Its nearest flange's way in parts of [`NEAR`], where it is nearer than [`FAR`].
    apart: Option<f64>,
}

/// Which wheelsets strike, or may soon; part of a simulation's state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strikes {
    wheelsets: Vec<Striking>,
    /// End of the last step, s.
    now: f64,
}

impl Strikes {
    /// Could these have come from the same model as `other`?
    pub fn fits(&self, other: &Strikes) -> bool {
        self.wheelsets.len() == other.wheelsets.len()
    }

    /// By how much more the error of a wheelset may be than that of one that strikes; `None`: it does not count.
    fn eased(&self, wheelset: usize) -> Option<f64> {
        let Striking { until, apart, .. } = self.wheelsets.get(wheelset)?;
        if until.is_some_and(|until| until > self.now) {
            return Some(1.0);
        }
        apart.map(|apart| (apart * apart * apart).max(1.0))
    }

    /// Has one of a wheelset's wheels left its rail of late?
    fn flies(&self, wheelset: usize) -> bool {
        self.wheelsets.get(wheelset).and_then(|own| own.flying).is_some_and(|until| until > self.now)
    }
}

impl Model {
    /// Before the first step.
    pub fn strikes(&self) -> Strikes {
        Strikes { wheelsets: vec![Striking::default(); self.wheelsets.len()], now: 0.0 }
    }

    /// Notes the end of a step at time `t` [s], at which the workspace's evaluation was made.
    pub fn note_strikes(&self, workspace: &Workspace, t: f64, strikes: &mut Strikes) {
        strikes.now = t;
        strikes.wheelsets.iter_mut().for_each(|own| own.apart = None);
        for WheelRef { contact, wheelset, side } in self.wheels() {
            let lean = workspace.lean(contact, wheelset.body);
            let apart = self.way_to_flange(workspace, (wheelset, side, contact)) / NEAR;
            let own = &mut strikes.wheelsets[contact / Side::BOTH.len()];
            if apart < 1.0 || lean.is_none_or(|lean| lean > FLANGE) {
                own.until = Some(t + LASTING);
            }
            if lean.is_none() {
                own.flying = Some(t + LASTING);
            }
            if apart < FAR {
                own.apart = Some(own.apart.map_or(apart, |other| other.min(apart)));
            }
        }
    }

    /// An error of the state in parts of what strikes to come allow; the workspace holds an evaluation nearby.
    pub fn error_at_strikes(&self, workspace: &Workspace, strikes: &Strikes, error: &[f64]) -> f64 {
        let mut largest: f64 = 0.0;
        for (index, wheelset) in self.wheelsets.iter().enumerate() {
            if strikes.flies(index) {
                for side in Side::BOTH {
                    largest = largest.max(self.contact_error(workspace, &self.wheel(contact_index(index, side)), error) / FLOWN);
                }
            }
            let Some(eased) = strikes.eased(index) else { continue };
            let flying = self.force_of_landing(workspace, (index, wheelset), error);
            largest = largest.max(self.force_on_flange(workspace, wheelset, error).max(flying) / (eased * PART * self.load_tolerance));
        }
        if largest.is_nan() { f64::INFINITY } else { largest }
    }

    /// How far a wheel may go outward until its flange meets its rail, m.
    fn way_to_flange(&self, workspace: &Workspace, (wheelset, side, contact): (&Wheelset, Side, usize)) -> f64 {
        let Some(way) = self.flanks.get(contact).map(|flank| flank.way).filter(|way| way.is_finite()) else { return f64::INFINITY };
        let motion = &workspace.system.motions[wheelset.body];
        let [y, _] = workspace.beside_track(wheelset.body);
        let [[rail, ..], _] = self.track.rail(side).deviation(motion.distance);
        way - side.sign() * (y - rail)
    }

    /// Force that an error makes when a flange strikes, by the static wheel load.
    fn force_on_flange(&self, workspace: &Workspace, wheelset: &Wheelset, error: &[f64]) -> f64 {
        let own = &error[COORDINATES * wheelset.body..COORDINATES * (wheelset.body + 1)];
        let across = workspace.in_track(wheelset.body, Vector3::new(own[0], own[1], own[2])).y;
        let length = (radius(&wheelset.left) * wheelset.left.half_spacing / CONICITY).sqrt();
        self.stiffness_of_strikes(wheelset) * across.hypot(length * own[YAW]) / wheelset.static_wheel_load
    }

    /// The same where wheels that carry nothing land.
    fn force_of_landing(&self, workspace: &Workspace, (index, wheelset): (usize, &Wheelset), error: &[f64]) -> f64 {
        let velocities = COORDINATES * self.system.bodies.len();
        let motion = &workspace.system.motions[wheelset.body];
        let stiffness = self.stiffness_of_strikes(wheelset);
        let impedance = (stiffness * self.bouncing_mass(wheelset)).sqrt();
        let mut largest: f64 = 0.0;
        for contact in Side::BOTH.map(|side| contact_index(index, side)) {
            if workspace.reports(contact).any(|report| report.carries()) {
                continue;
            }
            for report in workspace.reports(contact).filter(|report| report.penetration < 0.0) {
                let towards = |first: usize| {
                    let own = &error[first + COORDINATES * wheelset.body..first + COORDINATES * (wheelset.body + 1)];
                    let (moved, turned) = without_pitch(motion, own);
                    (moved + turned.cross(&(report.wheel_point - motion.position))).dot(&report.axes.normal).abs()
                };
                largest = largest.max((stiffness * towards(0)).max(impedance * towards(velocities)));
            }
        }
        largest / wheelset.static_wheel_load
    }

    /// k, N/m.
    fn stiffness_of_strikes(&self, wheelset: &Wheelset) -> f64 {
        let modulus = self.laws.material.contact_modulus();
        (6.0 * modulus * modulus * radius(&wheelset.left) * wheelset.static_wheel_load).cbrt()
    }
}

/// r, m.
fn radius(wheel: &Wheel) -> f64 {
    wheel.profile.at(0.0).value
}
