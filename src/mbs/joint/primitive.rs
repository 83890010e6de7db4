//! The scalar constraints of which all joints consist.
//!
//! ```text
//! displacement   d . (P2 - P1) = c     d fixed in frame 1 or in the track frame
//! angle          a . b = c             a fixed in frame 1, b in frame 2
//! coordinate     q1 - q2 = f(t)        one of the six coordinates; as a speed: q1' - q2' = f'(t)
//! ```
//!
//! Points, vectors and frames are those of the bodies' attachments ([`super::attachment`]); frame 2 may be the
//! ground. With `r` the arm from a body's centre to its point, `o` the frames' angular velocities, R = P2 - P1 and
//! `(..)0` what remains of a second derivative without q'':
//!
//! ```text
//! displacement'  = d . (V2 - V1) + (o1 x d) . R
//!   on v2, o2: d, r2 x d;   on v1, o1: -d, d x (r1 + R)    (d in the track frame: d x r1)
//!   gamma = -(d . (r2''0 - r1''0) + 2 (o1 x d) . (V2 - V1) + d''0 . R)
//! angle'         = (o1 - o2) . (a x b)
//!   gamma = -(a''0 . b + 2 (o1 x a) . (o2 x b) + a . b''0)
//! coordinate     gamma = f''
//! ```

use super::attachment::Attachment;
use super::{Prescribed, RowValues};
use crate::mbs::body::BodyMotion;
use crate::mbs::kkt::Coefficients;
use nalgebra::Vector3;

/// A direction that a displacement is measured along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Direction {
    Track(Vector3<f64>),
    /// In the axes of the first body's attachments.
    First(Vector3<f64>),
}

/// What a driving constraint prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The coordinate itself.
    Position,
    /// Only its rate; the coordinate starts where the state puts it.
    Speed,
}

/// One scalar constraint; points and vectors in the axes of the attachments (track frame on the ground).
#[derive(Clone, Debug)]
pub(super) enum Primitive {
    Displacement { first: Vector3<f64>, second: Vector3<f64>, direction: Direction },
    Angle { first: Vector3<f64>, second: Vector3<f64> },
    Coordinate { coordinate: usize, law: Prescribed, level: Level },
}

/// Both sides of a joint at one instant.
pub(super) struct Sides<'a> {
    pub motions: (&'a BodyMotion, Option<&'a BodyMotion>),
    pub first: Attachment,
    pub second: Attachment,
}

/// Arms [m], and parts of unit vectors across y, below this count as none.
const ALONG_Y: f64 = 0.01;

/// Is it changed by a rotation about y?
fn turns_about_y(vector: &Vector3<f64>) -> bool {
    vector.x.hypot(vector.z) > ALONG_Y
}

impl Primitive {
    /// Does the constraint change when the frame of the first or second body turns about its own y axis, at the design place where both bodies' axes are parallel?
    pub fn feels_turn_about_y(&self, of_first: bool) -> bool {
        match self {
            Primitive::Displacement { first, second, direction } => {
                let axis = matches!(direction, Direction::First(axis) if of_first && turns_about_y(axis));
                axis || turns_about_y(if of_first { first } else { second })
            }
            // Across both: an axis along y is not turned, and turned axes stay across it.
            Primitive::Angle { first, second } => turns_about_y(first) && turns_about_y(second),
            Primitive::Coordinate { .. } => false,
        }
    }

    /// Does the constraint hold the frame of the first or second body against turning about its own y axis, its place being further than `off` [m] from it?
    pub fn holds_about_y(&self, of_first: bool, off: f64) -> bool {
        match self {
            Primitive::Displacement { first, second, .. } => {
                let place = if of_first { first } else { second };
                place.x.hypot(place.z) > off
            }
            Primitive::Angle { .. } => self.feels_turn_about_y(of_first),
            Primitive::Coordinate { .. } => false,
        }
    }

    /// Its places on both bodies, of one that holds places together.
    pub fn points(&self) -> Option<[Vector3<f64>; 2]> {
        match self {
            Primitive::Displacement { first, second, .. } => Some([*first, *second]),
            Primitive::Angle { .. } | Primitive::Coordinate { .. } => None,
        }
    }

    pub fn values(&self, t: f64, sides: &Sides) -> RowValues {
        match self {
            Primitive::Displacement { first, second, direction } => displacement(sides, first, second, direction),
            Primitive::Angle { first, second } => angle(sides, first, second),
            Primitive::Coordinate { coordinate, law, level } => drive(sides, *coordinate, law.at(t), *level),
        }
    }
}

fn displacement(sides: &Sides, first: &Vector3<f64>, second: &Vector3<f64>, direction: &Direction) -> RowValues {
    let (one, two) = (&sides.first, &sides.second);
    let (r1, r2) = (one.axes * first, two.axes * second);
    let distance = two.centre + r2 - one.centre - r1;
    let velocity = two.velocity + two.rate(&r2) - one.velocity - one.rate(&r1);
    let bias = two.bias(&r2) - one.bias(&r1);
    let (d, turning, arm, turning_bias) = match direction {
        Direction::Track(d) => (*d, Vector3::zeros(), r1, 0.0),
        Direction::First(local) => {
            let d = one.axes * local;
            (d, one.rate(&d), r1 + distance, one.bias(&d).dot(&distance))
        }
    };
    RowValues {
        residual: d.dot(&distance),
        rate: d.dot(&velocity) + turning.dot(&distance),
        first: one.coefficients(&-d, &d.cross(&arm)),
        second: two.coefficients(&d, &r2.cross(&d)),
        gamma: -(d.dot(&bias) + 2.0 * turning.dot(&velocity) + turning_bias),
    }
}

fn angle(sides: &Sides, first: &Vector3<f64>, second: &Vector3<f64>) -> RowValues {
    let (one, two) = (&sides.first, &sides.second);
    let (a, b) = (one.axes * first, two.axes * second);
    let (a_rate, b_rate) = (one.rate(&a), two.rate(&b));
    let normal = a.cross(&b);
    let zero = Vector3::zeros();
    RowValues {
        residual: a.dot(&b),
        rate: a_rate.dot(&b) + a.dot(&b_rate),
        first: one.coefficients(&zero, &normal),
        second: two.coefficients(&zero, &-normal),
        gamma: -(one.bias(&a).dot(&b) + 2.0 * a_rate.dot(&b_rate) + a.dot(&two.bias(&b))),
    }
}

fn drive(sides: &Sides, coordinate: usize, [value, rate, second]: [f64; 3], level: Level) -> RowValues {
    let at = |motion: &BodyMotion| match coordinate {
        0..3 => [motion.position[coordinate], motion.velocity[coordinate]],
        3 => [motion.yaw, motion.yaw_rate],
        4 => [motion.roll, motion.roll_rate],
        _ => [motion.pitch, motion.pitch_rate],
    };
    let [q1, v1] = at(sides.motions.0);
    let [q2, v2] = sides.motions.1.map_or([0.0; 2], at);
    let mut unit = Coefficients::zeros();
    unit[coordinate.min(5)] = 1.0;
    RowValues {
        residual: if level == Level::Position { q1 - q2 - value } else { 0.0 },
        rate: v1 - v2 - rate,
        first: unit,
        second: -unit,
        gamma: second,
    }
}
