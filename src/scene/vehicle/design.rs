//! The design configuration of a vehicle.

use super::VehicleSpec;
use crate::mbs::system::System;

/// State of the system in the design configuration, travelling with `speed` [m/s].
pub(super) fn design_state(vehicle: &VehicleSpec, system: &System, speed: f64) -> Vec<f64> {
    let mut y = vec![0.0; system.dimension()];
    for body in 0..vehicle.body_count() {
        y[system.coordinates(body)][..3].copy_from_slice(vehicle.design_position(body).as_slice());
        y[system.velocities(body).start] = speed;
    }
    y
}
