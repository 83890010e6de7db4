//! Motor on the car body, cardan shaft along it, and a bevel gear on the axle with a torque arm on the bogie frame.
//!
//! Three bodies: the car `from` has motor and stator; the axle `to` the gear case on its bearings; the torque arm is a link at the place `arm` of the frame, vertical in
//! the frame's axes, which holds the case against turning about the axle ([`AxlePair`], the lever is the arm's distance from the axle along the track). x is the shaft's direction: the car's own
//! x axis, times -1 where the shaft turns anticlockwise seen in the direction of travel. With p the rotor's absolute speed about x (a state, as the twist is), rho the axle's speed against
//! its case, y the axle, W the angular velocity of its body with its spin and w that of the case about x, M the motor's torque and J the rotor's inertia:
//!
//! ```text
//! w = x . W_case,   W_case = W - rho y,   theta' = p - n rho - w,   S = k theta + c theta'
//! J p' = M - S
//! axle: the couple S x and, with the torque arm's force, (n - x . y) S about y,   frame: the arm's force, opposite
//! car: -M x - J p (W_car x x)
//! ```
//!
//! n is the bevel gear's ratio, S the shaft's torque, theta its twist. The shaft ends on the case, so that S rolls the axle (one wheel gets S over the wheels' distance more) and the stator rolls the car back; the part of S x
//! about the axle, which its bearings let through, is the torque arm's. Forces sum up to zero, and moments to what the rotor's angular momentum J p x takes. Power: the bodies and the rotor
//! get `M (p - x . W_car) - d/dt(k theta^2 / 2) - c theta'^2`. With the car and the case held, rotor and axle swing with `sqrt(k (1/J + n^2/I))`.
//!
//! The shaft has two universal joints with forks in phase and equal angles (or joints of constant velocity): twice a turn nothing is left over. What is left out, for an angle b of the shaft:
//!
//! - unequal angles b1, b2 at the joints: the case leads and lags twice a turn by (b1^2 - b2^2) / 4 (4 and 2 degrees: 0.9 mrad, times k);
//! - S acts along the car's axis, not along the bisector of both shafts' axes: off by b / 2 of S (4 degrees: 3.5 %), with the same sum of moments and the same power;
//! - the couple S tan(b / 2) across the line of joints at different heights, opposite on car and case;
//! - friction in the sliding piece: up to friction times S over its radius (0.1, 2 kN m and 50 mm: 4 kN along the shaft) between car and axle;
//! - inertia of shaft and pinion: n^2 times that of the pinion belongs in the axle's own.

use super::axle_pair::{AxlePair, read_pair};
use super::motor_gear::{INPUTS, NEAREST_NOSE, UNIT_RATE};
use super::{ElementInput, ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, Gradient, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Dimension;
use nalgebra::{Vector3, Vector6};

/// A motor on one body that drives an axle which another one guides.
#[derive(Clone, Debug)]
pub struct CardanDrive {
    pub name: String,
    /// The axle, and the frame with the torque arm.
    pub pair: AxlePair,
    pub car: usize,
    /// 1: seen forward the shaft turns clockwise when the vehicle goes forward; -1.
    pub sense: f64,
    /// n, positive.
    pub ratio: f64,
    /// J about the rotor's own axis, kg m2.
    pub inertia: f64,
    /// k, N m/rad, and c, N m s/rad, of the shaft.
    pub stiffness: f64,
    pub damping: f64,
    /// M until a master sets it, N m.
    pub torque: f64,
}

/// Shaft and rotor at one instant.
struct Shaft {
    /// On axle and frame for a torque of 1 on the axle by the arm, and for S = 1.
    arm: [Wrench; 2],
    unit: [Wrench; 2],
    /// x, and n - x . y.
    axis: Vector3<f64>,
    gear: f64,
    /// p, rho, and n rho + w, rad/s.
    rotor: f64,
    axle: f64,
    pinion: f64,
    /// theta', rad/s, and S, N m.
    twist_rate: f64,
    torque: f64,
}

impl CardanDrive {
    /// x.
    #[inline]
    fn axis(&self, bodies: &Moving) -> Vector3<f64> {
        bodies[self.car].frame.axes.column(0) * self.sense
    }

    #[inline]
    fn shaft(&self, bodies: &Moving, state: &[f64]) -> Shaft {
        let (arm, axis) = (self.pair.wrenches(bodies), self.axis(bodies));
        let gear = self.ratio - axis.dot(&bodies[self.pair.axle].frame.axes.column(1));
        let mut unit = arm.map(|on| Wrench { force: on.force * gear, moment: on.moment * gear });
        unit[0].moment += axis;
        let (rotor, pinion) = (UNIT_RATE * state[1], self.pair.power(bodies, &unit));
        let twist_rate = rotor - pinion;
        let torque = self.stiffness * state[0] + self.damping * twist_rate;
        Shaft { axle: self.pair.power(bodies, &arm), arm, unit, axis, gear, rotor, pinion, twist_rate, torque }
    }

    /// The rotor's speed against its stator, rad/s.
    fn motor_speed(&self, bodies: &Moving, shaft: &Shaft) -> f64 {
        shaft.rotor - shaft.axis.dot(&bodies[self.car].rotation)
    }
}

const QUANTITIES: [Quantity; 7] = [
    Quantity {
        number: 0,
        name: "axleTorque",
        kind: QuantityKind::Moment,
        description: "torque of the gear on the axle, positive drives forward",
    },
    Quantity {
        number: 1,
        name: "axleSpeed",
        kind: QuantityKind::AngularSpeed,
        description: "speed of the axle against the gear case, forward positive",
    },
    Quantity {
        number: 2,
        name: "motorSpeed",
        kind: QuantityKind::AngularSpeed,
        description: "speed of the rotor against its stator, positive where the vehicle goes forward",
    },
    Quantity { number: 3, name: "power", kind: QuantityKind::Power, description: "mechanical power of the motor, positive drives" },
    Quantity { number: 4, name: "twist", kind: QuantityKind::Angle, description: "twist of the shaft, positive where the motor is ahead" },
    Quantity { number: 5, name: "shaftTorque", kind: QuantityKind::Moment, description: "torque of the shaft, positive drives forward" },
    Quantity {
        number: 6,
        name: "armForce",
        kind: QuantityKind::Force,
        description: "force of the torque arm on the body that holds it, up positive",
    },
];

impl Numbered for CardanDrive {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(0, "ratio", One, POSITIVE, "turns of the shaft for each turn of the axle", ratio),
        constant!(1, "rotorInertia", KilogramMetre2, POSITIVE, "moment of inertia of the rotor about its own axis", inertia),
        constant!(tunable 2, "stiffness", NewtonMetrePerRadian, POSITIVE, "stiffness of the shaft in torsion", stiffness),
        constant!(tunable 3, "damping", NewtonMetreSecondPerRadian, Some(0.0), "damping of the shaft in torsion", damping),
    ];
}

impl ForceElement for CardanDrive {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        2
    }

    fn time_constant(&self) -> Option<f64> {
        Some((self.inertia / self.stiffness).sqrt())
    }

    fn inputs(&self) -> &'static [ElementInput] {
        &INPUTS
    }

    fn start_input(&self, _: usize) -> f64 {
        self.torque
    }

    fn turns_axle(&self) -> bool {
        true
    }

    fn torsion(&self) -> Option<usize> {
        Some(0)
    }

    fn own_inertia(&self) -> Option<(usize, &'static str, f64)> {
        Some((1, "rotor", self.inertia * UNIT_RATE * UNIT_RATE))
    }

    fn rotor_on_axle(&self) -> Option<(usize, f64)> {
        Some((self.pair.axle, self.ratio * self.ratio * self.inertia))
    }

    fn rotor_carrier(&self) -> Option<usize> {
        Some(self.car)
    }

    fn angular_momentum(&self, bodies: &Moving, state: &[f64]) -> Vector3<f64> {
        self.axis(bodies) * (self.inertia * UNIT_RATE * state[1])
    }

    fn is_supplied(&self) -> bool {
        true
    }

    fn supplied_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        bodies.input(0) * self.motor_speed(bodies, &self.shaft(bodies, state))
    }

    /// Turning with its axle, the shaft wound up by the motor's torque.
    fn settle(&self, bodies: &Moving, state: &mut [f64]) {
        let pinion = self.shaft(bodies, state).pinion;
        (state[0], state[1]) = (bodies.input(0) / self.stiffness, pinion / UNIT_RATE);
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let (shaft, motor) = (self.shaft(bodies, state), bodies.input(0));
        self.pair.load(&shaft.unit, shaft.torque, wrenches);
        let turned = bodies[self.car].rotation.cross(&shaft.axis) * (self.inertia * shaft.rotor);
        wrenches[self.car].moment -= shaft.axis * motor + turned;
        rates[0] = shaft.twist_rate;
        rates[1] = (motor - shaft.torque) / (self.inertia * UNIT_RATE);
    }

    fn bodies(&self) -> Ends {
        self.pair.ends()
    }

    fn doubt(&self) -> Option<String> {
        self.pair.doubt()
    }

    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let shaft = self.shaft(bodies, state);
        self.pair.turning(bodies, shaft.gear * shaft.torque, sum);
        sum.add_couple_of_carrier(&(shaft.axis * shaft.torque));
        sum.add_carried_couple(&(shaft.axis * (shaft.torque - bodies.input(0))));
        let generalised = |body: usize, moment: Vector3<f64>| -> Vector6<f64> {
            Vector6::from_iterator(bodies[body].generalised_force(&Wrench { force: Vector3::zeros(), moment }).iter().copied())
        };
        // x . y changes by (x x y) . (turn of x - turn of y).
        let across = shaft.axis.cross(&bodies[self.pair.axle].frame.axes.column(1));
        let measured = [generalised(self.pair.axle, -across), generalised(self.car, across)];
        sum.add_across(&self.pair.gradient(bodies, &shaft.arm).map(|load| load * -shaft.torque), &measured);
        let gradient: Gradient = self.pair.gradient(bodies, &shaft.unit);
        sum.add_rates(&gradient, &gradient, -self.damping);
        // -J p (W x x) = J p (W_y z - W_z y) along the car's axes, times the sense.
        let about = |axis: usize| generalised(self.car, bodies[self.car].frame.axes.column(axis).into_owned());
        let ([y, z], momentum) = ([about(1), about(2)], self.sense * self.inertia * shaft.rotor);
        sum.add_carrier_rates(&z, &y, momentum);
        sum.add_carrier_rates(&y, &z, -momentum);
        let rate = bodies[self.car].frame.axes.tr_mul(&bodies[self.car].rotation);
        let per_state = self.inertia * UNIT_RATE;
        let Some(own) = sum.add_own_states(first_state, 2) else { return };
        own.rate_by_velocity = [gradient.map(|part| -part), gradient.map(|part| part * (self.damping / per_state))];
        own.rate_by_state[(0, 1)] = UNIT_RATE;
        own.rate_by_state[(1, 0)] = -self.stiffness / per_state;
        own.rate_by_state[(1, 1)] = -self.damping * UNIT_RATE / per_state;
        own.load_by_state = [gradient.map(|part| part * self.stiffness), gradient.map(|part| part * (self.damping * UNIT_RATE))];
        own.far = Some((self.car, [Vector6::zeros(), (z * rate.y - y * rate.z) * (self.sense * per_state)]));
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        let shaft = self.shaft(bodies, state);
        match index {
            0 => self.ratio * shaft.torque,
            1 => shaft.axle,
            2 => self.motor_speed(bodies, &shaft),
            3 => self.supplied_power(bodies, state),
            4 => state[0],
            5 => shaft.torque,
            6 => shaft.gear * shaft.torque * shaft.arm[1].force.dot(&bodies[self.pair.carrier].frame.axes.column(2)),
            _ => 0.0,
        }
    }

    fn potential_energy(&self, _: &Moving, state: &[f64]) -> f64 {
        0.5 * (self.stiffness * state[0].powi(2) + self.inertia * (UNIT_RATE * state[1]).powi(2))
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        self.damping * self.shaft(bodies, state).twist_rate.powi(2)
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (pair, arm) = read_pair(section, places, "arm")?;
    let car = places.attachment(section, "from")?.body;
    let car = car.ok_or_else(|| section.error("from", "is the world; expected the body that carries the motor"))?;
    if car == pair.axle {
        return Err(section.error("from", "is on the same body as \"to\"; expected the body that carries the motor"));
    }
    if arm.x.abs() < NEAREST_NOSE {
        let problem = format!(
            "is {:.3} m from the axle along the track; expected the torque arm's place, at least {NEAREST_NOSE} m ahead of or behind the axle",
            arm.x
        );
        return Err(section.error("arm", problem));
    }
    let sense = if section.word_or("turns", &["clockwise", "anticlockwise"], "clockwise")? == "clockwise" { 1.0 } else { -1.0 };
    Ok(Box::new(CardanDrive {
        name: places.name(section)?,
        pair: pair.by_link(Vector3::new(0.0, 0.0, -1.0 / arm.x)),
        car,
        sense: sense * places.mirror(),
        ratio: section.positive("ratio", Dimension::None)?,
        inertia: section.positive("rotor_inertia", Dimension::Inertia)?,
        stiffness: section.positive("stiffness", Dimension::RotationalStiffness)?,
        damping: section.not_negative_or("damping", Dimension::RotationalDamping, 0.0)?,
        torque: section.number_or("torque", Dimension::Torque, 0.0)?,
    }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "cardan_drive",
    summary: "motor on the body \"from\", cardan shaft along it, bevel gear on the axle \"to\", its torque arm at \"arm\"",
    reference: "",
    parse,
};
