//! Magnetic track brake: magnets that hold on to the rail, whose pole shoes slide on it.
//!
//! Magnets pull themselves onto the rail with the attraction A [N] (all of them together), which follows the input A_0 with the rise time T:
//! `A' = (A_0 - A) / T`. The largest friction force on the frame, at the place `on` (at the height where links or stops hand it on), falls with the speed v of that place along the
//! track:
//!
//! ```text
//! M = mu(v) A,   mu(v) = mu_s + (mu_0 - mu_s) / (1 + |v| / v_h)
//! ```
//!
//! from mu_0 (`friction`) at rest by half of the way to mu_s (`sliding_friction`) at v_h (`half_speed`). That is the form which Curtius and Kniffler gave the falling adhesion of locomotives
//! (`7.5 / (44 + v) + 0.161`, v in km/h: mu_0 = 0.331, mu_s = 0.161, v_h = 44 km/h); the numbers of a pole shoe are the user's. Without the other two keys mu is constant. Within M
//! the brake sticks and slides as friction brakes do ([`super::sticking`]), k the stiffness of its links along the track, so that it holds a vehicle at rest. States: its deflection [m], and A in
//! [`UNIT`].
//!
//! Left out: the attraction's own path, which closes between magnets and rail and does not load the vehicle, the eddy currents of the moving magnets, the weight of magnets that lie on the
//! rail instead of the frame, and forces across the track. The rail takes the reaction.

use super::along_track::{AlongTrack, read_place};
use super::sticking::{Grip, STICKING, Sticking};
use super::{ElementInput, ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};

/// The state of the attraction counts in this, N: error control weighs it like a length.
pub const UNIT: f64 = 1e6;
/// The default tau and damping time, s.
const RELAXATION: f64 = 2e-3;
const DAMPING_TIME: f64 = 5e-3;

/// A magnetic track brake on one body.
#[derive(Clone, Debug)]
pub struct MagneticTrackBrake {
    pub name: String,
    pub place: AlongTrack,
    /// mu_0 and mu_s.
    pub friction: f64,
    pub sliding_friction: f64,
    /// v_h, m/s; infinity: mu_0 at every speed.
    pub half_speed: f64,
    /// T, s.
    pub rise_time: f64,
    /// k in N/m.
    pub sticking: Sticking,
    /// A_0 until a master sets it, N.
    pub attraction: f64,
}

/// The brake at one instant.
struct Held {
    speed: f64,
    /// M, N, and its change with speed and attraction.
    most: f64,
    by_speed: f64,
    by_attraction: f64,
    grip: Grip,
}

impl MagneticTrackBrake {
    /// mu and its change with the speed.
    fn friction_at(&self, speed: f64) -> [f64; 2] {
        let (fall, beyond) = (self.friction - self.sliding_friction, 1.0 + speed.abs() / self.half_speed);
        [self.sliding_friction + fall / beyond, -fall / (beyond * beyond * self.half_speed) * speed.signum()]
    }

    #[inline]
    fn now(&self, bodies: &Moving, state: &[f64]) -> Held {
        let speed = self.place.speed(bodies);
        let attraction = UNIT * state[1].max(0.0);
        let [friction, slope] = self.friction_at(speed);
        let most = friction * attraction;
        let grip = self.sticking.grip(most, state[0], speed);
        Held { speed, most, by_speed: slope * attraction, by_attraction: if state[1] > 0.0 { friction } else { 0.0 }, grip }
    }

    /// How force and rate change with M.
    fn by_most(&self, held: &Held, deflection: f64) -> [f64; 2] {
        /// Of M, for a difference.
        const CHANGE: f64 = 1e-5;
        if self.sticking.is_off(held.most) {
            return [0.0; 2];
        }
        let at = |sign: f64| self.sticking.grip(held.most * (1.0 + sign * CHANGE), deflection, held.speed);
        let (more, less, width) = (at(1.0), at(-1.0), 2.0 * CHANGE * held.most);
        [(more.torque - less.torque) / width, (more.rate - less.rate) / width]
    }
}

const INPUTS: [ElementInput; 1] = [ElementInput {
    number: 0,
    name: "attractionForce",
    unit: Unit::Newton,
    least: Some(0.0),
    description: "attraction of all magnets to the rail that their excitation leads to; 0: off",
}];

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        number: 0,
        name: "force",
        kind: QuantityKind::Force,
        description: "force of the brake on the body, forward positive: negative while it runs forward",
    },
    Quantity { number: 1, name: "attraction", kind: QuantityKind::Force, description: "attraction of the magnets to the rail now" },
    Quantity { number: 2, name: "heatFlow", kind: QuantityKind::Power, description: "power that becomes heat in pole shoes and rail" },
];

impl Numbered for MagneticTrackBrake {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "friction", One, POSITIVE, "friction coefficient of the pole shoes at rest", friction),
        constant!(tunable 1, "slidingFriction", One, Some(0.0), "friction coefficient that is left at high speed", get: |brake| brake.half_speed.is_finite().then_some(brake.sliding_friction), set: |brake, value| brake.sliding_friction = value),
        constant!(tunable 2, "halfSpeed", MetrePerSecond, POSITIVE, "speed at which friction has fallen by half of all", get: |brake| brake.half_speed.is_finite().then_some(brake.half_speed), set: |brake, value| brake.half_speed = value),
        constant!(tunable 3, "riseTime", Second, POSITIVE, "time constant with which the attraction follows the excitation", rise_time),
        constant!(tunable 4, "stiffness", NewtonPerMetre, POSITIVE, "stiffness of the magnets' links along the track", sticking.stiffness),
        constant!(tunable 5, "relaxation", Second, POSITIVE, "time within which the brake takes hold and lets go", sticking.relaxation),
        constant!(tunable 6, "dampingTime", Second, Some(0.0), "damping of the brake's deflection over its stiffness", sticking.damping_time),
    ];
}

impl ForceElement for MagneticTrackBrake {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        2
    }

    fn state_weight(&self) -> f64 {
        self.sticking.state_weight()
    }

    fn time_constant(&self) -> Option<f64> {
        Some(((1.0 - STICKING) * self.sticking.relaxation).min(self.rise_time))
    }

    fn inputs(&self) -> &'static [ElementInput] {
        &INPUTS
    }

    fn start_input(&self, _: usize) -> f64 {
        self.attraction
    }

    /// With the attraction that is asked for.
    fn settle(&self, bodies: &Moving, state: &mut [f64]) {
        state[1] = bodies.input(0).max(0.0) / UNIT;
        let held = self.now(bodies, state);
        state[0] = self.sticking.settled(held.most, held.speed);
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let held = self.now(bodies, state);
        rates[0] = held.grip.rate;
        // A polynomial input may pass below zero between communication points.
        rates[1] = (bodies.input(0).max(0.0) / UNIT - state[1]) / self.rise_time;
        self.place.load(bodies, -held.grip.torque, wrenches);
    }

    fn bodies(&self) -> Ends {
        self.place.ends()
    }

    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let held = self.now(bodies, state);
        let [force_by_most, rate_by_most] = self.by_most(&held, state[0]);
        let Grip { torque, torque_by_angle, torque_by_speed, rate_by_angle, rate_by_speed, .. } = held.grip;
        self.place.tangent(bodies, -torque, -(torque_by_speed + force_by_most * held.by_speed), sum);
        let line = self.place.line(bodies, sum);
        let by_attraction = UNIT * held.by_attraction;
        let Some(own) = sum.add_states(first_state, 2) else { return };
        own.rate_by_state[(0, 0)] = rate_by_angle;
        own.rate_by_state[(0, 1)] = rate_by_most * by_attraction;
        own.rate_by_state[(1, 1)] = -1.0 / self.rise_time;
        // The relative twist is minus the body's.
        own.rate_by_velocity[0][0] = line * -(rate_by_speed + rate_by_most * held.by_speed);
        own.load_by_state[0][0] = line * -torque_by_angle;
        own.load_by_state[1][0] = line * -(force_by_most * by_attraction);
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        match index {
            0 => -self.now(bodies, state).grip.torque,
            1 => UNIT * state[1],
            2 => self.dissipated_power(bodies, state),
            _ => 0.0,
        }
    }

    fn potential_energy(&self, _: &Moving, state: &[f64]) -> f64 {
        0.5 * self.sticking.stiffness * state[0].powi(2)
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let Held { speed, grip, .. } = self.now(bodies, state);
        // Rounding of two equal numbers is no heat.
        (grip.torque * speed - self.sticking.stiffness * state[0] * grip.rate).max(0.0)
    }
}

/// Greatest friction coefficient: pole shoes do not interlock with the rail.
const MOST_FRICTION: f64 = 2.0;

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let friction = section.within("friction", Dimension::None, (1e-3, MOST_FRICTION))?;
    let falls = section.has("sliding_friction") || section.has("half_speed");
    let (sliding_friction, half_speed) = match falls {
        true => {
            // More than at rest are two numbers exchanged.
            (section.within("sliding_friction", Dimension::None, (0.0, friction))?, section.positive("half_speed", Dimension::Speed)?)
        }
        false => (friction, f64::INFINITY),
    };
    Ok(Box::new(MagneticTrackBrake {
        name: places.name(section)?,
        place: read_place(section, places)?,
        friction,
        sliding_friction,
        half_speed,
        rise_time: section.positive("rise_time", Dimension::Time)?,
        sticking: Sticking {
            stiffness: section.positive("stiffness", Dimension::Stiffness)?,
            relaxation: section.positive_or("relaxation", Dimension::Time, RELAXATION)?,
            damping_time: section.not_negative_or("damping_time", Dimension::Time, DAMPING_TIME)?,
        },
        attraction: section.not_negative_or("attraction", Dimension::Force, 0.0)?,
    }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "magnetic_track_brake",
    summary: "magnets on the rail under a place of a body: friction that falls with speed, with true sticking",
    reference: "form of the friction: E. W. Curtius, A. Kniffler, Elektrische Bahnen 20 (1944) 25-39",
    parse,
};
