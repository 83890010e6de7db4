//! Does a vehicle stand by itself?
//!
//! Its bodies hang on force elements in the design configuration, wheelsets held, friction and dampers without a part in it ([`crate::mbs::carried`]). Where a mode's value is
//! negative a body falls over with the rate `sqrt(-lambda)`: a car whose springs stand too near to each other for the height of its centre of mass. Exactly upright it would
//! stand for ever, and a run on straight track shows nothing of it.

use super::VehicleSpec;
use super::assemble::{design, parts};
use crate::mbs::body::COORDINATES;
use crate::mbs::carried::Carried;

/// Slower than this nothing is worth a word, 1/s.
const SLOWEST: f64 = 0.3;
/// Vehicles of more bodies are not looked at: the time grows with the cube of their number.
const MOST: usize = 40;

/// A body that falls, in which direction, and the rate at which it begins to, 1/s.
#[derive(Clone, Debug, PartialEq)]
pub struct Fall {
    pub body: String,
    pub direction: &'static str,
    pub rate: f64,
}

/// The fastest fall of the vehicle on level track, if there is one.
pub fn fall(vehicle: &VehicleSpec) -> Option<Fall> {
    if vehicle.bodies.is_empty() || vehicle.bodies.len() > MOST || vehicle.away().is_some() {
        return None;
    }
    let (system, wheelsets) = parts(vehicle, 0.0).ok()?;
    let carried = Carried::new(&system, wheelsets.len(), &design(vehicle, &system));
    let all: Vec<usize> = (0..vehicle.bodies.len()).collect();
    let lowest = carried.modes(&all).into_iter().min_by(|a, b| a.value.total_cmp(&b.value))?;
    let rate = (-lowest.value).max(0.0).sqrt();
    if !(rate > SLOWEST) {
        return None;
    }
    let motion = lowest.shape;
    let (worst, _) = motion.component_mul(&motion).component_mul(carried.masses()).argmax();
    let direction = ["along the track", "to the side", "vertically", "in yaw", "in roll", "in pitch"][worst % COORDINATES];
    Some(Fall { body: vehicle.bodies[worst / COORDINATES].body.name.clone(), direction, rate })
}
