//! Friction brake of an axle: disc or tread, with true sticking.
//!
//! - `type = "disc"`: a couple between axle and carrier ([`AxlePair`]). The input is the largest friction torque, or with `friction` and `radius` the clamping
//!   force N (both pads' friction together): `M = friction N radius`.
//! - `type = "tread"`: a block at the place `from` of the carrier presses with the input N [N] toward the axle, wherever that stands (in a direction fixed in the carrier, N turned the wheel where the carrier had moved); its friction acts across the radius r to
//!   that place, `M = friction N r`, r that of the design configuration: the block follows its tread. The wheel gets both forces, the carrier the opposite ones. One element is one block.
//!
//! M [N m] is the largest friction torque. The state is the brake's elastic deflection theta [rad at the axle], k its stiffness (caliper, hangers), and rho the
//! speed of the axle against its carrier; [`super::sticking`] has the law of theta and of the torque T.

use super::attachment::Attachment;
use super::axle_pair::{AxlePair, read_ends};
use super::sticking::{Grip, STICKING, Sticking};
use super::{ElementInput, ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::mbs::twist::Axles;
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};
use nalgebra::Vector3;

/// The default tau and damping time, s.
const RELAXATION: f64 = 2e-3;
const DAMPING_TIME: f64 = 5e-3;

/// A brake on an axle.
#[derive(Clone, Debug)]
pub struct Brake {
    pub name: String,
    pub pair: AxlePair,
    /// Of a tread brake: the place on the axle, beside the block, toward which it presses.
    pub press: Option<Attachment>,
    /// Friction coefficient and radius [m]; `None`: the input is the torque.
    pub friction: Option<(f64, f64)>,
    /// k, N m/rad.
    pub stiffness: f64,
    /// tau, s.
    pub relaxation: f64,
    /// c / k, s.
    pub damping_time: f64,
    /// The input until a master sets it.
    pub application: f64,
}

impl Brake {
    /// The input, not negative: a polynomial may pass below zero between communication points.
    #[inline]
    fn applied(&self, bodies: &Moving) -> f64 {
        bodies.input(0).max(0.0)
    }

    /// M, N m.
    #[inline]
    fn most(&self, bodies: &Moving) -> f64 {
        self.friction.map_or(1.0, |(friction, radius)| friction * radius) * self.applied(bodies)
    }

    #[inline]
    fn grip(&self, most: f64, angle: f64, speed: f64) -> Grip {
        self.sticking().grip(most, angle, speed)
    }

    #[inline]
    fn sticking(&self) -> Sticking {
        let Brake { stiffness, relaxation, damping_time, .. } = *self;
        Sticking { stiffness, relaxation, damping_time }
    }

    /// The brake as it stands, with the wrenches of a unit torque and rho.
    #[inline]
    fn now(&self, bodies: &Moving, state: &[f64]) -> (Grip, [Wrench; 2], f64) {
        let unit = self.pair.wrenches(bodies);
        let speed = self.pair.power(bodies, &unit);
        (self.grip(self.most(bodies), state[0], speed), unit, speed)
    }

    /// How the block presses: with N along the line from the axle's middle beside it to its place; `None` where nothing presses.
    #[inline]
    fn pressing(&self, bodies: &Moving) -> Option<Pressing> {
        let across = self.pair.point(bodies) - self.press?.point(bodies);
        let length = across.norm();
        (length > 0.0).then(|| Pressing { unit: across / length, length, force: self.applied(bodies) })
    }
}

/// A block's force on the axle: N, opposite to the unit vector from the axle to the block.
struct Pressing {
    unit: Vector3<f64>,
    /// m.
    length: f64,
    force: f64,
}

impl Pressing {
    fn on_axle(&self) -> Vector3<f64> {
        self.unit * -self.force
    }
}

macro_rules! input {
    ($number:literal, $name:literal, $unit:ident, $text:literal) => {
        [ElementInput { number: $number, name: $name, unit: Unit::$unit, least: Some(0.0), description: $text }]
    };
}

const TORQUE: [ElementInput; 1] =
    input!(0, "largestTorque", NewtonMetre, "largest friction torque of the brake: what it brakes with while the axle turns");
const CLAMP: [ElementInput; 1] = input!(1, "clampingForce", Newton, "force that clamps the disc, counted with the friction of both pads");
const BLOCK: [ElementInput; 1] = input!(2, "blockForce", Newton, "force that presses the block onto the tread");

const QUANTITIES: [Quantity; 4] = [
    Quantity {
        number: 0,
        name: "torque",
        kind: QuantityKind::Moment,
        description: "torque of the brake on the axle, forward positive: negative brakes forward running",
    },
    Quantity {
        number: 1,
        name: "slidingSpeed",
        kind: QuantityKind::AngularSpeed,
        description: "speed of the axle against what carries the brake, forward positive",
    },
    Quantity { number: 2, name: "heatFlow", kind: QuantityKind::Power, description: "power that the brake turns into heat" },
    Quantity {
        number: 3,
        name: "deflection",
        kind: QuantityKind::Angle,
        description: "elastic deflection of the brake at the axle, forward positive",
    },
];

impl Numbered for Brake {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "friction", One, POSITIVE, "friction coefficient of pads or block", get: |brake| brake.friction.map(|pair| pair.0), set: |brake, value| if let Some(pair) = &mut brake.friction { pair.0 = value }),
        constant!(1, "radius", Metre, POSITIVE, "friction radius of the disc", get: |brake| brake.friction.filter(|_| brake.press.is_none()).map(|pair| pair.1), set: |brake, value| if let Some(pair) = &mut brake.friction { pair.1 = value }),
        constant!(tunable 2, "stiffness", NewtonMetrePerRadian, POSITIVE, "stiffness of the brake before it slips, at the axle", stiffness),
        constant!(tunable 3, "relaxation", Second, POSITIVE, "time within which the brake takes hold and lets go", relaxation),
        constant!(tunable 4, "dampingTime", Second, Some(0.0), "damping of the brake's deflection over its stiffness", damping_time),
    ];
}

impl ForceElement for Brake {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        1
    }

    fn torsion(&self) -> Option<usize> {
        Some(0)
    }

    fn swings_when_locked(&self) -> bool {
        true
    }

    fn state_weight(&self) -> f64 {
        self.sticking().state_weight()
    }

    fn time_constant(&self) -> Option<f64> {
        Some((1.0 - STICKING) * self.relaxation)
    }

    fn inputs(&self) -> &'static [ElementInput] {
        match (self.press, self.friction) {
            (Some(_), _) => &BLOCK,
            (None, Some(_)) => &CLAMP,
            (None, None) => &TORQUE,
        }
    }

    fn start_input(&self, _: usize) -> f64 {
        self.application
    }

    fn turns_axle(&self) -> bool {
        true
    }

    fn wheel(&self) -> Option<usize> {
        self.pair.wheel()
    }

    fn fit(&mut self, axles: &Axles) {
        self.pair.fit(axles);
    }

    fn is_supplied(&self) -> bool {
        self.press.is_some()
    }

    /// Of the cylinder that presses a block; a clamp moves nothing.
    fn supplied_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let pressing = self.pressing(bodies);
        pressing.map_or(0.0, |pressing| self.pair.power(bodies, &self.pair.opposite(bodies, &pressing.on_axle())))
    }

    fn settle(&self, bodies: &Moving, state: &mut [f64]) {
        let speed = self.now(bodies, state).2;
        state[0] = self.sticking().settled(self.most(bodies), speed);
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let (grip, unit, _) = self.now(bodies, state);
        rates[0] = grip.rate;
        self.pair.load(&unit, -grip.torque, wrenches);
        if let Some(pressing) = self.pressing(bodies) {
            self.pair.load(&self.pair.opposite(bodies, &pressing.on_axle()), 1.0, wrenches);
        }
    }

    fn bodies(&self) -> Ends {
        self.pair.ends()
    }

    fn doubt(&self) -> Option<String> {
        self.pair.doubt()
    }

    fn holds(&self) -> [Option<Attachment>; 2] {
        self.pair.holds()
    }

    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let (grip, unit, _) = self.now(bodies, state);
        self.pair.turning(bodies, -grip.torque, sum);
        if let Some(Pressing { unit, length, force }) = self.pressing(bodies) {
            // A push along a line that turns with its ends.
            let (point, tension) = (self.pair.point(bodies), -force);
            let line = sum.line(&point, &unit);
            sum.add_uniform_spring(&point, tension / length);
            sum.add_spring(&line, &line, -tension / length);
            sum.add_force(&point, &(unit * tension));
        }
        let axle = self.pair.gradient(bodies, &unit);
        sum.add_rates(&axle, &axle, -grip.torque_by_speed);
        let Some(own) = sum.add_own_states(first_state, 1) else { return };
        own.rate_by_state[(0, 0)] = grip.rate_by_angle;
        own.rate_by_velocity[0] = axle.map(|axle| axle * grip.rate_by_speed);
        own.load_by_state[0] = axle.map(|axle| axle * -grip.torque_by_angle);
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        match index {
            0 => -self.now(bodies, state).0.torque,
            1 => self.now(bodies, state).2,
            2 => self.dissipated_power(bodies, state),
            3 => state[0],
            _ => 0.0,
        }
    }

    fn potential_energy(&self, _: &Moving, state: &[f64]) -> f64 {
        0.5 * self.stiffness * state[0].powi(2)
    }

    fn block(&self) -> Option<(usize, f64)> {
        let (_, radius) = self.friction.filter(|_| self.press.is_some())?;
        Some((self.pair.axle, radius))
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let (grip, _, speed) = self.now(bodies, state);
        // Rounding of two equal numbers is no heat.
        (grip.torque * speed - self.stiffness * state[0] * grip.rate).max(0.0)
    }
}

/// Least distance of a block from its axle, m.
const NEAREST_BLOCK: f64 = 0.05;

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (pair, arm) = read_ends(section, places)?;
    let tread = section.word("type", &["disc", "tread"])? == "tread";
    let radial = Vector3::new(arm.x, 0.0, arm.z);
    let radius = radial.norm();
    if tread && radius < NEAREST_BLOCK {
        return Err(section.error("from", format!("is {radius:.3} m from the axle; expected the block's place on the tread")));
    }
    // Across the radius, so that forward is that of the axle.
    let pair = if tread { pair.on_tread(Vector3::y().cross(&radial) / (radius * radius)) } else { pair };
    let friction = match tread {
        true => Some((section.positive("friction", Dimension::None)?, radius)),
        false if section.has("friction") || section.has("radius") => {
            Some((section.positive("friction", Dimension::None)?, section.positive("radius", Dimension::Length)?))
        }
        false => None,
    };
    let key = if tread {
        "block_force"
    } else if friction.is_some() {
        "clamping_force"
    } else {
        "torque"
    };
    let dimension = if friction.is_some() { Dimension::Force } else { Dimension::Torque };
    let press = tread.then(|| Attachment::on(pair.axle, Vector3::y() * arm.y));
    Ok(Box::new(Brake {
        name: places.name(section)?,
        pair,
        press,
        friction,
        stiffness: section.positive("stiffness", Dimension::RotationalStiffness)?,
        relaxation: section.positive_or("relaxation", Dimension::Time, RELAXATION)?,
        damping_time: section.not_negative_or("damping_time", Dimension::Time, DAMPING_TIME)?,
        application: section.not_negative_or(key, dimension, 0.0)?,
    }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "brake",
    summary: "friction brake of the axle \"to\", carried by \"from\": disc or tread, with true sticking",
    reference: "P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, IEEE Trans. Automatic Control 47 (2002) 787-792, with bounded rates",
    parse,
};
