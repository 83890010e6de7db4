//! Running resistance after Davis: what bearings, track and air take from a vehicle.
//!
//! At the place `on`, with its speed v along the track and the head wind w (input, m/s, positive against forward running):
//!
//! ```text
//! F = -(A v / sqrt(v^2 + v0^2) + B v) - C |v + w| (v + w)
//! ```
//!
//! A [N] is the resistance of bearings, smoothed below v0 = 0.1 m/s so that it holds nothing at rest (a brake does); B [N s/m] grows with the speed; C [kg/m] is that of
//! the air. The resistance of creepage and of grades is not in it: the model has these. Heat: the first two terms' power, and that of the third on
//! v + w; the wind brings in the third term's power on w.

use super::along_track::{AlongTrack, read_place};
use super::{ElementInput, ForceElement, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};

/// v0, m/s.
const SLOW: f64 = 0.1;

/// Resistance of a vehicle on one of its bodies.
#[derive(Clone, Debug)]
pub struct RunningResistance {
    pub name: String,
    pub place: AlongTrack,
    /// A, N.
    pub rolling: f64,
    /// B, N s/m.
    pub per_speed: f64,
    /// C, kg/m.
    pub air: f64,
}

impl RunningResistance {
    /// The first two terms and the third, N, both against the motion, and their slopes by v, N s/m.
    #[inline]
    fn parts(&self, speed: f64, wind: f64) -> [[f64; 2]; 2] {
        let root = speed.hypot(SLOW);
        let own =
            [self.rolling * speed / root + self.per_speed * speed, self.rolling * SLOW * SLOW / (root * root * root) + self.per_speed];
        let through = speed + wind;
        [own, [self.air * through.abs() * through, 2.0 * self.air * through.abs()]]
    }

    #[inline]
    fn now(&self, bodies: &Moving) -> (f64, [[f64; 2]; 2]) {
        let speed = self.place.speed(bodies);
        (speed, self.parts(speed, bodies.input(0)))
    }
}

const INPUTS: [ElementInput; 1] = [ElementInput {
    number: 0,
    name: "headWind",
    unit: Unit::MetrePerSecond,
    least: None,
    description: "speed of the air against forward running, added to the speed in C v^2 alone",
}];

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        number: 0,
        name: "force",
        kind: QuantityKind::Force,
        description: "running resistance on the body, forward positive: negative while it runs forward, but for a strong tail wind",
    },
    Quantity {
        number: 1,
        name: "power",
        kind: QuantityKind::Power,
        description: "power of the resistance on the body, negative where it brakes",
    },
];

impl Numbered for RunningResistance {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "rolling", Newton, Some(0.0), "A of the resistance A + B v + C v^2", rolling),
        constant!(tunable 1, "perSpeed", NewtonSecondPerMetre, Some(0.0), "B of the resistance A + B v + C v^2", per_speed),
        constant!(tunable 2, "air", KilogramPerMetre, Some(0.0), "C of the resistance A + B v + C v^2", air),
    ];
}

impl ForceElement for RunningResistance {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> &'static [ElementInput] {
        &INPUTS
    }

    fn is_supplied(&self) -> bool {
        true
    }

    fn supplied_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        self.now(bodies).1[1][0] * bodies.input(0)
    }

    #[inline]
    fn apply(&self, bodies: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let (_, [own, air]) = self.now(bodies);
        self.place.load(bodies, -own[0] - air[0], wrenches);
    }

    fn resists(&self) -> bool {
        true
    }

    fn bodies(&self) -> Ends {
        self.place.ends()
    }

    fn tangent(&self, bodies: &Moving, _: &[f64], _: usize, sum: &mut PairTangent) {
        let (_, [own, air]) = self.now(bodies);
        self.place.tangent(bodies, -own[0] - air[0], -own[1] - air[1], sum);
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, _: &[f64]) -> f64 {
        let (speed, [own, air]) = self.now(bodies);
        let force = -own[0] - air[0];
        match index {
            0 => force,
            1 => force * speed,
            _ => 0.0,
        }
    }

    fn potential_energy(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }

    fn dissipated_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let (speed, [own, air]) = self.now(bodies);
        own[0] * speed + air[0] * (speed + bodies.input(0))
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    Ok(Box::new(RunningResistance {
        name: places.name(section)?,
        place: read_place(section, places)?,
        rolling: section.not_negative_or("rolling", Dimension::Force, 0.0)?,
        per_speed: section.not_negative_or("per_speed", Dimension::Damping, 0.0)?,
        air: section.not_negative_or("air", Dimension::AirResistance, 0.0)?,
    }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "running_resistance",
    summary: "resistance A + B v + C v^2 against running, with head wind, on a place of a body",
    reference: "W. J. Davis, General Electric Review 29 (1926) 685-707",
    parse,
};
