//! What a master may apply to a model: one row per input, which the input vector, the FMU and the plan read.
//!
//! The vector holds the inputs of each wheelset ([`WHEELSET_ROWS`]), then, where rails move, those of the rail under each wheel ([`RAIL_ROWS`]), then those
//! that force elements have (`ForceElement::inputs`), in their order, then those of a speed that is an input ([`TRAVEL_ROWS`]).
//! A new input is a row here and what it does in the equations.

use super::{Model, contact_index};
use crate::geometry::Side;
use crate::mbs::driving::{Course, DrivingConstraint};
use crate::mbs::speed_input::Wanted;
use crate::mbs::system::SystemWorkspace;
use crate::units::Unit;

/// Places among the inputs of one wheelset.
pub const DRIVE_TORQUE: usize = 0;
pub const LATERAL_FORCE: usize = 1;
pub const VERTICAL_FORCE: usize = 2;
pub const LEFT_FRICTION: usize = 3;
pub const RIGHT_FRICTION: usize = 4;
pub const LONGITUDINAL_FORCE: usize = 5;
pub const WHEELSET_INPUTS: usize = 6;

/// Places among the inputs of the rail under one wheel: u [m], w [m/s], u_s [-] (`rail_motion`).
pub const RAIL_LATERAL: usize = 0;
pub const RAIL_VERTICAL: usize = 1;
pub const RAIL_LATERAL_VELOCITY: usize = 2;
pub const RAIL_VERTICAL_VELOCITY: usize = 3;
pub const RAIL_LATERAL_SLOPE: usize = 4;
pub const RAIL_VERTICAL_SLOPE: usize = 5;
pub const RAIL_INPUTS: usize = 6;

/// Places among the inputs of the travelling speed.
pub const WANTED_SPEED: usize = 0;
pub const WANTED_RATE: usize = 1;
pub const TRAVEL_INPUTS: usize = 2;

/// Inputs that a scene shows together: `interface.inputs`.
#[derive(Debug, PartialEq, Eq)]
pub struct InputGroup {
    pub name: &'static str,
    /// What a plan calls them.
    pub effect: &'static str,
    /// Does the model do more where they are shown? Then a scene must name the group.
    pub on_request: bool,
}

pub const DRIVE_TORQUES: InputGroup = InputGroup { name: "drive_torque", effect: "drive torque input", on_request: false };
pub const CENTRE_FORCES: InputGroup = InputGroup { name: "centre_forces", effect: "centre force inputs", on_request: false };
pub const FRICTION_FACTORS: InputGroup = InputGroup { name: "friction", effect: "friction factor inputs", on_request: false };
/// Motion of the rails from outside.
pub const RAIL_MOTION: InputGroup = InputGroup { name: "rail_motion", effect: "rail motion", on_request: true };

/// What force elements bring along: motors, brakes.
pub const ELEMENT_INPUTS: InputGroup = InputGroup { name: "elements", effect: "inputs of force elements", on_request: false };

pub const GROUPS: [&InputGroup; 5] = [&DRIVE_TORQUES, &CENTRE_FORCES, &FRICTION_FACTORS, &RAIL_MOTION, &ELEMENT_INPUTS];

/// Of `vehicle.speed`, which asks for them itself.
pub const TRAVEL: InputGroup = InputGroup { name: "speed", effect: "speed input", on_request: true };

/// One input: of a wheelset, of the rail under a wheel, or of the whole vehicle.
#[derive(Debug)]
pub struct InputRow {
    /// Local number of the variable: that of the left wheel, where each wheel has one.
    pub id: u32,
    pub group: &'static InputGroup,
    /// Behind the wheelset's (rails: the wheel's) name.
    pub name: &'static str,
    pub unit: Unit,
    /// The value that leaves the model alone.
    pub neutral: f64,
    pub least: Option<f64>,
    pub most: Option<f64>,
    /// A force along the track: an imposed speed leaves no room for it.
    pub along: bool,
    pub text: &'static str,
}

/// Of a friction coefficient: beyond it something else was meant, such as per cent.
const GREATEST_FACTOR: f64 = 10.0;

const FORCE: InputRow =
    InputRow { id: 0, group: &CENTRE_FORCES, name: "", unit: Unit::Newton, neutral: 0.0, least: None, most: None, along: false, text: "" };
const FACTOR: InputRow =
    InputRow { group: &FRICTION_FACTORS, unit: Unit::One, neutral: 1.0, least: Some(0.0), most: Some(GREATEST_FACTOR), ..FORCE };
const RAIL: InputRow = InputRow { group: &RAIL_MOTION, unit: Unit::Metre, ..FORCE };

/// By place.
pub const WHEELSET_ROWS: [InputRow; WHEELSET_INPUTS] = [
    InputRow {
        id: 1,
        group: &DRIVE_TORQUES,
        name: "driveTorque",
        unit: Unit::NewtonMetre,
        text: "torque about the axle, positive drives forward, with no reaction on the vehicle (a motor_gear or brake has one)",
        ..FORCE
    },
    InputRow { id: 2, name: "lateralForceInput", text: "external lateral force on the centre, left positive", ..FORCE },
    InputRow { id: 3, name: "verticalForceInput", text: "external vertical force on the centre, up positive", ..FORCE },
    InputRow { id: 4, name: "left.frictionFactor", text: "factor on the friction coefficient at the left wheel", ..FACTOR },
    InputRow { id: 5, name: "right.frictionFactor", text: "factor on the friction coefficient at the right wheel", ..FACTOR },
    InputRow {
        id: 6,
        name: "longitudinalForceInput",
        along: true,
        text: "external longitudinal force on the centre, forward positive",
        ..FORCE
    },
];

/// By place; variables of the right wheel are numbered ten behind those of the left one.
pub const RAIL_ROWS: [InputRow; RAIL_INPUTS] = [
    InputRow {
        id: 501,
        name: "railLateralDisplacement",
        text: "displacement of the rail under the wheel across the track, left positive",
        ..RAIL
    },
    InputRow { id: 502, name: "railVerticalDisplacement", text: "displacement of the rail under the wheel, up positive", ..RAIL },
    InputRow {
        id: 503,
        name: "railLateralVelocity",
        unit: Unit::MetrePerSecond,
        text: "velocity of the rail's material under the wheel across the track, left positive",
        ..RAIL
    },
    InputRow {
        id: 504,
        name: "railVerticalVelocity",
        unit: Unit::MetrePerSecond,
        text: "velocity of the rail's material under the wheel, up positive",
        ..RAIL
    },
    InputRow {
        id: 505,
        name: "railLateralSlope",
        unit: Unit::One,
        text: "change of railLateralDisplacement per distance along the track; 0 for a track that travels along",
        ..RAIL
    },
    InputRow {
        id: 506,
        name: "railVerticalSlope",
        unit: Unit::One,
        text: "change of railVerticalDisplacement per distance along the track; 0 for a track that travels along",
        ..RAIL
    },
];

/// By place; the first begins with the speed of the scene, its bound is there too.
pub const TRAVEL_ROWS: [InputRow; TRAVEL_INPUTS] = [
    InputRow {
        id: 1,
        group: &TRAVEL,
        name: "speed",
        unit: Unit::TravelSpeed,
        text: "wanted travelling speed of the leading driven wheelset, forward positive; the run begins with it, and later changes are followed with a bounded acceleration",
        ..FORCE
    },
    InputRow {
        id: 30,
        group: &TRAVEL,
        name: "acceleration",
        unit: Unit::MetrePerSecond2,
        text: "acceleration that goes with the wanted speed: its slope, from a master that gives no derivatives of the input speed",
        ..FORCE
    },
];

/// Place of a wheelset's input in the input vector of a model.
pub fn input_index(wheelset: usize, input: usize) -> usize {
    wheelset * WHEELSET_INPUTS + input
}

/// Place of a rail's input in the input vector of a model with `wheelsets` wheelsets.
pub fn rail_input(wheelsets: usize, wheelset: usize, side: Side, input: usize) -> usize {
    first_of_rail(wheelsets, contact_index(wheelset, side)) + input
}

/// Where the inputs of the rail under a wheel begin.
pub(super) fn first_of_rail(wheelsets: usize, contact: usize) -> usize {
    WHEELSET_INPUTS * wheelsets + RAIL_INPUTS * contact
}

/// Where the inputs of force elements begin.
fn first_of_elements(wheelsets: usize, rail_motion: bool) -> usize {
    first_of_rail(wheelsets, if rail_motion { 2 * wheelsets } else { 0 })
}

impl Model {
    /// Values of all inputs that leave the model alone.
    pub fn neutral_inputs(&self) -> Vec<f64> {
        let rails = if self.rail_motion { self.contacts() } else { 0 };
        let mut values = Vec::new();
        for _ in 0..self.wheelsets.len() {
            values.extend(WHEELSET_ROWS.iter().map(|row| row.neutral));
        }
        for _ in 0..rails {
            values.extend(RAIL_ROWS.iter().map(|row| row.neutral));
        }
        values.resize(values.len() + self.system.force_inputs(), 0.0);
        if self.speed_is_input() {
            values.extend([self.system.drives[0].speed, 0.0]);
        }
        values
    }

    /// Values of all inputs until a master sets others: force elements may begin with some.
    pub fn start_inputs(&self) -> Vec<f64> {
        let mut values = self.neutral_inputs();
        let mut place = self.first_element_input();
        for force in &self.system.forces {
            for index in 0..force.inputs().len() {
                values[place] = force.start_input(index);
                place += 1;
            }
        }
        values
    }

    /// Where the inputs of force elements begin in the input vector.
    pub fn first_element_input(&self) -> usize {
        first_of_elements(self.wheelsets.len(), self.rail_motion)
    }

    /// Does the imposed speed follow an input?
    #[inline]
    pub fn speed_is_input(&self) -> bool {
        matches!(self.system.drives.first(), Some(DrivingConstraint { course: Course::Input(_), .. }))
    }

    /// Where the inputs of the travelling speed begin in an input vector of `count`: they stand last.
    #[inline]
    pub fn first_travel_input(&self, count: usize) -> Option<usize> {
        self.speed_is_input().then(|| count - TRAVEL_INPUTS)
    }

    /// Hands imposed speeds the time [s] and what inputs want of them, and force elements their inputs.
    #[inline]
    pub fn take_inputs(&self, system: &mut SystemWorkspace, t: f64, inputs: &[f64]) {
        system.orders.time = t;
        if !system.inputs.is_empty() {
            let first = self.first_element_input();
            let end = first + system.inputs.len();
            system.inputs.copy_from_slice(&inputs[first..end]);
        }
        if let Some(first) = self.first_travel_input(inputs.len()) {
            system.orders.wanted = Wanted { speed: inputs[first + WANTED_SPEED], rate: inputs[first + WANTED_RATE] };
        }
    }
}
