//! Traction motor with gear on an axle: torque with its reaction, and the rotor's inertia behind an elastic drive.
//!
//! The motor's torque M [N m, positive drives forward] acts between rotor and stator; the gear turns the rotor by n = sense x ratio for each turn of
//! its large wheel (sense -1: one pair of wheels, the rotor turns against the axle; +1: an idler or two stages). Motor and gear case are
//!
//! - `mount = "shaft"`: on the carrier `from` (bogie frame, car body); a jointed or hollow shaft hands the torque to the axle, the case hands its
//!   reaction to the carrier as a couple;
//! - `mount = "nose"`: on the axle's bearings and on a nose link, vertical in the carrier's axes at the place `from`: the reaction is a force F = torque / L there,
//!   L the link's distance from the axle along the track, and the opposite force on the axle.
//!
//! Masses of motor and gear belong to the bodies that carry them. *Without* `rotor_inertia` the axle gets `ratio M`, the carrier the opposite ([`AxlePair`]).
//! *With* it the rotor's absolute speed p about its axis is a state, and the drive gives by the twist psi [rad at the axle]. With the speed rho of the axle
//! and the spin w of the case (that of the carrier about its y axis; with a nose that of the axle about itself, less rho), sigma the large wheel's speed:
//!
//! ```text
//! sigma = (p - w) / n,   psi' = rho - sigma,   T = k psi + c psi'
//! J p' = sense M + T / n
//! axle: -T,  carrier: T - J p'   (the sum is what the rotor's angular momentum takes),  and -J p (W x a) on what holds the rotor
//! ```
//!
//! a is the rotor's axis, the y axis of the body that holds the case (carrier, or axle with a nose), W that body's angular velocity. Slower than
//! the drive's own frequency sqrt(k / (n^2 J)) the axle has the inertia n^2 J more. The body that holds the case has the rotor's mass, but not its
//! inertia about a, in its own numbers. Power: `T psi'` = rate of k psi^2/2 + c psi'^2; the motor brings in `sense M (p - w)`. The second state is
//! p / n over a fixed rate of that size [rad].

use super::attachment::Attachment;
use super::axle_pair::{AxlePair, read_ends};
use super::{ElementInput, ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, Gradient, PairTangent};
use crate::mbs::twist::Axles;
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};
use nalgebra::Vector3;

/// A motor on an axle.
#[derive(Clone, Debug)]
pub struct MotorGear {
    pub name: String,
    pub pair: AxlePair,
    /// Is the case on the axle's bearings, with a nose link?
    pub nose: bool,
    /// Positive.
    pub ratio: f64,
    /// 1 or -1.
    pub sense: f64,
    /// `None`: its inertia is left out.
    pub rotor: Option<Rotor>,
    /// M until a master sets it, N m.
    pub torque: f64,
}

/// A rotor behind its drive.
#[derive(Clone, Copy, Debug)]
pub struct Rotor {
    /// J about its own axis, kg m2.
    pub inertia: f64,
    /// k, N m/rad, and c, N m s/rad, of the drive as seen at the axle.
    pub stiffness: f64,
    pub damping: f64,
}

/// Unit of the rotor's speed over n, 1/s: sqrt(k / J) of usual drives, so that both states are angles of one size. It is no drive's own, whose
/// stiffness may be tuned during a run: a rotor keeps its speed then.
pub(super) const UNIT_RATE: f64 = 600.0;

/// Drive and rotor at one instant.
struct Drive {
    unit: [Wrench; 2],
    /// rho, w, p, all rad/s.
    axle: f64,
    case: f64,
    rotor: f64,
    /// psi', rad/s, and T, N m: what the axle gives to the drive.
    twist_rate: f64,
    torque: f64,
    /// J p', N m.
    spin_up: f64,
}

impl MotorGear {
    /// n.
    #[inline]
    fn gear(&self) -> f64 {
        self.sense * self.ratio
    }

    /// The second state's unit, rad/s.
    #[inline]
    fn unit_rate(&self) -> f64 {
        UNIT_RATE / self.ratio
    }

    /// The body that holds the case, and a.
    #[inline]
    fn holder(&self, bodies: &Moving) -> (usize, Vector3<f64>) {
        let body = if self.nose { self.pair.axle } else { self.pair.carrier };
        (body, bodies[body].frame.axes.column(1).into_owned())
    }

    #[inline]
    fn drive(&self, bodies: &Moving, state: &[f64]) -> Drive {
        let unit = self.pair.wrenches(bodies);
        let axle = self.pair.power(bodies, &unit);
        let (holder, axis) = self.holder(bodies);
        let own = bodies[holder].rotation.dot(&axis);
        let case = if self.nose { own - axle } else { own };
        let (motor, gear) = (self.sense * bodies.input(0), self.gear());
        let Some(rotor) = &self.rotor else {
            let torque = -self.ratio * bodies.input(0);
            return Drive { unit, axle, case, rotor: case + gear * axle, twist_rate: 0.0, torque, spin_up: 0.0 };
        };
        let speed = gear * self.unit_rate() * state[1];
        let twist_rate = axle - (speed - case) / gear;
        let torque = rotor.stiffness * state[0] + rotor.damping * twist_rate;
        Drive { unit, axle, case, rotor: speed, twist_rate, torque, spin_up: motor + torque / gear }
    }

    /// J p, N m s.
    fn momentum(&self, drive: &Drive) -> f64 {
        self.rotor.map_or(0.0, |rotor| rotor.inertia * drive.rotor)
    }

    /// Torque along the pair's wrenches, N m.
    fn paired(&self, drive: &Drive) -> f64 {
        if self.nose { drive.spin_up - drive.torque } else { -drive.torque }
    }
}

pub(super) const INPUTS: [ElementInput; 1] = [ElementInput {
    number: 0,
    name: "torque",
    unit: Unit::NewtonMetre,
    least: None,
    description: "torque of the motor on its rotor, positive drives forward",
}];

const QUANTITIES: [Quantity; 5] = [
    Quantity {
        number: 0,
        name: "axleTorque",
        kind: QuantityKind::Moment,
        description: "torque of the drive on the axle, positive drives forward",
    },
    Quantity {
        number: 1,
        name: "axleSpeed",
        kind: QuantityKind::AngularSpeed,
        description: "speed of the axle against the motor's case, forward positive",
    },
    Quantity {
        number: 2,
        name: "motorSpeed",
        kind: QuantityKind::AngularSpeed,
        description: "speed of the rotor against its case, positive where the vehicle goes forward",
    },
    Quantity { number: 3, name: "power", kind: QuantityKind::Power, description: "mechanical power of the motor, positive drives" },
    Quantity {
        number: 4,
        name: "twist",
        kind: QuantityKind::Angle,
        description: "twist of the drive at the axle, positive where the axle is ahead",
    },
];

/// A line of the table for a number of the rotor.
macro_rules! of_rotor {
    ($($tunable:ident)? $number:literal, $name:literal, $unit:ident, $least:expr, $text:literal, $field:ident) => {
        constant!($($tunable)? $number, $name, $unit, $least, $text, get: |element| element.rotor.map(|rotor| rotor.$field), set: |element, value| {
            if let Some(rotor) = &mut element.rotor {
                rotor.$field = value;
            }
        })
    };
}

impl Numbered for MotorGear {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(0, "ratio", One, POSITIVE, "turns of the rotor for each turn of the axle", ratio),
        of_rotor!(1, "rotorInertia", KilogramMetre2, POSITIVE, "moment of inertia of the rotor about its own axis", inertia),
        of_rotor!(tunable 2, "stiffness", NewtonMetrePerRadian, POSITIVE, "stiffness of the drive in torsion, at the axle", stiffness),
        of_rotor!(tunable 3, "damping", NewtonMetreSecondPerRadian, Some(0.0), "damping of the drive in torsion, at the axle", damping),
    ];
}

impl ForceElement for MotorGear {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        if self.rotor.is_some() { 2 } else { 0 }
    }

    fn time_constant(&self) -> Option<f64> {
        self.rotor.map(|rotor| self.ratio * (rotor.inertia / rotor.stiffness).sqrt())
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

    fn wheel(&self) -> Option<usize> {
        self.pair.wheel()
    }

    fn torsion(&self) -> Option<usize> {
        self.rotor.map(|_| 0)
    }

    fn fit(&mut self, axles: &Axles) {
        self.pair.fit(axles);
    }

    fn own_inertia(&self) -> Option<(usize, &'static str, f64)> {
        self.rotor.map(|rotor| (1, "rotor", rotor.inertia * UNIT_RATE * UNIT_RATE))
    }

    fn rotor_on_axle(&self) -> Option<(usize, f64)> {
        self.rotor.map(|rotor| (self.pair.axle, self.ratio * self.ratio * rotor.inertia))
    }

    fn rotor_carrier(&self) -> Option<usize> {
        let holder = if self.nose { self.pair.axle } else { self.pair.carrier };
        self.rotor.map(|_| holder)
    }

    fn angular_momentum(&self, bodies: &Moving, state: &[f64]) -> Vector3<f64> {
        self.holder(bodies).1 * self.momentum(&self.drive(bodies, state))
    }

    fn is_supplied(&self) -> bool {
        true
    }

    fn is_dissipative(&self) -> bool {
        self.rotor.is_some()
    }

    fn supplied_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let drive = self.drive(bodies, state);
        self.sense * bodies.input(0) * (drive.rotor - drive.case)
    }

    /// Turning with its axle, without torque.
    fn settle(&self, bodies: &Moving, state: &mut [f64]) {
        if self.rotor.is_some() {
            let drive = self.drive(bodies, state);
            let held =
                self.rotor.filter(|rotor| rotor.stiffness > 0.0).map_or(0.0, |rotor| -self.ratio * bodies.input(0) / rotor.stiffness);
            (state[0], state[1]) = (held, (drive.axle + drive.case / self.gear()) / self.unit_rate());
        }
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let drive = self.drive(bodies, state);
        self.pair.load(&drive.unit, self.paired(&drive), wrenches);
        let Some(rotor) = &self.rotor else { return };
        rates[0] = drive.twist_rate;
        rates[1] = drive.spin_up / (rotor.inertia * self.gear() * self.unit_rate());
        let (holder, axis) = self.holder(bodies);
        wrenches[holder].moment -= axis * drive.spin_up + bodies[holder].rotation.cross(&axis) * self.momentum(&drive);
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
        let drive = self.drive(bodies, state);
        self.pair.turning(bodies, self.paired(&drive), sum);
        let Some(rotor) = &self.rotor else { return };
        let (holder, axis) = self.holder(bodies);
        sum.add_carried_couple(&(axis * -drive.spin_up));
        let (unit_rate, gear, momentum) = (self.unit_rate(), self.gear(), self.momentum(&drive));
        // Of unit couples on the holder about its x, y and z axes.
        let about = |axis: usize| -> Gradient {
            let mut unit = [Wrench::default(); 2];
            unit[usize::from(!self.nose)].moment = bodies[holder].frame.axes.column(axis).into_owned();
            self.pair.gradient(bodies, &unit)
        };
        let [x, y, z] = [0, 1, 2].map(about);
        let axle = self.pair.gradient(bodies, &drive.unit);
        // psi' = rho - (p - w) / n, and T acts along the same with the opposite sign.
        let ends = [0, 1];
        let twist = ends.map(|end| {
            let case = if self.nose { y[end] - axle[end] } else { y[end] };
            axle[end] + case / gear
        });
        sum.add_rates(&twist, &twist, -rotor.damping);
        // -J p (W x y) = J p (W_z x - W_x z).
        sum.add_rates(&x, &z, momentum);
        sum.add_rates(&z, &x, -momentum);
        let rate = bodies[holder].frame.axes.tr_mul(&bodies[holder].rotation);
        let per_state = rotor.inertia * gear * unit_rate;
        let Some(own) = sum.add_own_states(first_state, 2) else { return };
        own.rate_by_velocity = [twist, twist.map(|twist| twist * (rotor.damping / (gear * per_state)))];
        own.rate_by_state[(0, 1)] = -unit_rate;
        own.rate_by_state[(1, 0)] = rotor.stiffness / (gear * per_state);
        own.rate_by_state[(1, 1)] = -rotor.damping * unit_rate / (gear * per_state);
        own.load_by_state = [
            twist.map(|twist| twist * -rotor.stiffness),
            ends.map(|end| twist[end] * (rotor.damping * unit_rate) + (x[end] * rate.z - z[end] * rate.x) * per_state),
        ];
    }

    fn quantities(&self) -> &'static [Quantity] {
        if self.rotor.is_some() { &QUANTITIES } else { &QUANTITIES[..4] }
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        let drive = self.drive(bodies, state);
        match index {
            0 => -drive.torque,
            1 => drive.axle,
            2 => self.sense * (drive.rotor - drive.case),
            3 => self.supplied_power(bodies, state),
            4 => state.first().copied().unwrap_or(0.0),
            _ => 0.0,
        }
    }

    fn potential_energy(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let Some(rotor) = &self.rotor else { return 0.0 };
        0.5 * (rotor.stiffness * state[0].powi(2) + rotor.inertia * self.drive(bodies, state).rotor.powi(2))
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        self.rotor.map_or(0.0, |rotor| rotor.damping * self.drive(bodies, state).twist_rate.powi(2))
    }
}

/// Shortest distance of a nose link from its axle along the track, m.
pub(super) const NEAREST_NOSE: f64 = 0.05;

fn read_rotor(section: &Section) -> Result<Option<Rotor>, SettingsError> {
    if !section.has("rotor_inertia") {
        return match ["stiffness", "damping"].into_iter().find(|key| section.has(key)) {
            Some(key) => Err(section.error(key, "is that of the drive between rotor and axle, which serves nothing without rotor_inertia")),
            None => Ok(None),
        };
    }
    let damping = section.not_negative_or("damping", Dimension::RotationalDamping, 0.0)?;
    let inertia = section.positive("rotor_inertia", Dimension::Inertia)?;
    let stiffness = section.positive("stiffness", Dimension::RotationalStiffness)?;
    Ok(Some(Rotor { inertia, stiffness, damping }))
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (pair, arm) = read_ends(section, places)?;
    let nose = section.word("mount", &["shaft", "nose"])? == "nose";
    if nose && arm.x.abs() < NEAREST_NOSE {
        let problem = format!(
            "is {:.3} m from the axle along the track; expected the nose link's place, at least {NEAREST_NOSE} m ahead of or behind the axle",
            arm.x
        );
        return Err(section.error("from", problem));
    }
    if nose && pair.side.is_some() {
        return Err(
            section.error("wheel", "names one wheel, which a motor that hangs on the axle can't turn alone; expected mount = \"shaft\"")
        );
    }
    // e_y . (arm x F) = arm_z F_x - arm_x F_z.
    let pair = if nose { pair.by_link(Vector3::new(0.0, 0.0, -1.0 / arm.x)) } else { pair };
    let sense = if section.word_or("gear", &["opposite", "same"], "opposite")? == "same" { 1.0 } else { -1.0 };
    Ok(Box::new(MotorGear {
        name: places.name(section)?,
        pair,
        nose,
        ratio: section.positive("ratio", Dimension::None)?,
        sense,
        rotor: read_rotor(section)?,
        torque: section.number_or("torque", Dimension::Torque, 0.0)?,
    }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "motor_gear",
    summary: "traction motor and gear on the axle \"to\", carried by \"from\": torque with its reaction, rotor inertia",
    reference: "",
    parse,
};
