//! Driving constraint: `q1 = f(t)`, or `q1 - q2 = f(t)` against another body, for one of the six coordinates; or the
//! same for the speeds. A law of time states its value with two derivatives, so nothing is differenced.

use super::Joint;
use super::prescribed::Prescribed;
use super::primitive::{Level, Primitive};
use crate::mbs::kkt::RowBodies;

/// Names of the coordinates' rows.
const ROWS: [&str; 6] = ["x", "y", "z", "yaw", "roll", "pitch"];

/// Coordinates 0 to 5: x, y, z, yaw, roll, pitch (larger counts as pitch).
pub fn driven(name: &str, bodies: RowBodies, coordinate: usize, level: Level, law: Prescribed) -> Joint {
    let coordinate = coordinate.min(5);
    Joint::new(name, bodies, vec![(ROWS[coordinate], Primitive::Coordinate { coordinate, law, level })])
}
