//! Driving constraint: `q1 = f(t)`, or `q1 - q2 = f(t)` against another body, for one of the six coordinates; or the
//! same for the speeds. A law of time states its value with two derivatives, so nothing is differenced.

use super::Joint;
use super::primitive::{Level, Primitive};
use crate::mbs::kkt::RowBodies;
use std::sync::Arc;

/// A law of time: value, first and second derivative.
#[derive(Clone)]
pub struct Prescribed(Arc<dyn Fn(f64) -> [f64; 3] + Send + Sync>);

impl Prescribed {
    /// From a function of time [s].
    pub fn new(law: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static) -> Self {
        Prescribed(Arc::new(law))
    }

    /// `start + speed t`.
    pub fn uniform(start: f64, speed: f64) -> Self {
        Self::new(move |t| [start + speed * t, speed, 0.0])
    }

    pub fn at(&self, t: f64) -> [f64; 3] {
        (self.0)(t)
    }
}

impl std::fmt::Debug for Prescribed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Prescribed(t = 0: {:?})", self.at(0.0))
    }
}

/// Names of the coordinates' rows.
const ROWS: [&str; 6] = ["x", "y", "z", "yaw", "roll", "pitch"];

/// Coordinates 0 to 5: x, y, z, yaw, roll, pitch (larger counts as pitch).
pub fn driven(name: &str, bodies: RowBodies, coordinate: usize, level: Level, law: Prescribed) -> Joint {
    let coordinate = coordinate.min(5);
    Joint::new(name, bodies, vec![(ROWS[coordinate], Primitive::Coordinate { coordinate, law, level })])
}
