//! Does a vehicle stand by itself?
//!
//! Its bodies hang on force elements in the design configuration, wheelsets held, friction and dampers without a part in it. With K the change of the generalised
//! forces with the bodies' coordinates (by differences, so that preloads that turn with their bodies are in it), M their masses and Z a basis of what joints leave free,
//!
//! ```text
//! Z^T K Z v = lambda Z^T M Z v
//! ```
//!
//! where lambda < 0 a body falls over with the rate `sqrt(-lambda)`: a car whose springs stand too near to each other for the height of its centre of mass. Exactly upright it would
//! stand for ever, and a run on straight track shows nothing of it.

use super::VehicleSpec;
use super::assemble::parts;
use super::design::design_state;
use super::static_preload::{generalised, joint_rows};
use crate::mbs::body::COORDINATES;
use nalgebra::{DMatrix, DVector};

/// Differences of coordinates, m and rad.
const STEP: f64 = 1e-5;
/// Slower than this nothing is worth a word, 1/s.
const SLOWEST: f64 = 0.3;
/// Joints' rows whose share of the largest is below this leave a motion free.
const FREE: f64 = 1e-9;
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
    let count = COORDINATES * vehicle.bodies.len();
    if vehicle.bodies.is_empty() || vehicle.bodies.len() > MOST || vehicle.away().is_some() {
        return None;
    }
    let (system, _) = parts(vehicle, 0.0).ok()?;
    let design = design_state(vehicle, &system, 0.0);
    let mut workspace = system.workspace(&[]);
    let first = system.coordinates(vehicle.wheelsets.len()).start;
    let mut forces = |coordinate: usize, step: f64| -> DVector<f64> {
        let mut y = design.clone();
        y[first + coordinate] += step;
        system.settle_forces(&mut y, &mut workspace);
        system.apply_forces(&y, &mut workspace);
        system.fold_wheels(&mut workspace);
        generalised(vehicle, &workspace, &workspace.wrenches)
    };
    let mut stiffness = DMatrix::zeros(count, count);
    for coordinate in 0..count {
        stiffness.set_column(coordinate, &((forces(coordinate, -STEP) - forces(coordinate, STEP)) / (2.0 * STEP)));
    }
    forces(0, 0.0);
    let masses = DVector::from_iterator(
        count,
        vehicle.bodies.iter().flat_map(|placed| {
            let [xx, yy, zz] = placed.body.inertia.moments();
            let mass = placed.body.mass;
            // Yaw, roll and pitch.
            [mass, mass, mass, zz, xx, yy]
        }),
    );
    let rows = joint_rows(vehicle, &system, &workspace, 0);
    let held = (&rows * rows.transpose()).symmetric_eigen();
    let least = FREE * held.eigenvalues.amax().max(f64::MIN_POSITIVE);
    let free: Vec<DVector<f64>> = held
        .eigenvalues
        .iter()
        .zip(held.eigenvectors.column_iter())
        .filter(|(value, _)| **value <= least)
        .map(|(_, way)| way.into())
        .collect();
    if free.is_empty() {
        return None;
    }
    let basis = DMatrix::from_columns(&free);
    let root = (basis.transpose() * DMatrix::from_diagonal(&masses) * &basis).cholesky()?.l();
    let reduced = basis.transpose() * (0.5 * (&stiffness + stiffness.transpose())) * &basis;
    let inverse = root.clone().try_inverse()?;
    let modes = (&inverse * reduced * inverse.transpose()).symmetric_eigen();
    let (index, lowest) = modes.eigenvalues.argmin();
    let rate = (-lowest).max(0.0).sqrt();
    if !(rate > SLOWEST) {
        return None;
    }
    let motion = basis * (inverse.transpose() * modes.eigenvectors.column(index));
    let (worst, _) = motion.component_mul(&motion).component_mul(&masses).argmax();
    let direction = ["along the track", "to the side", "vertically", "in yaw", "in roll", "in pitch"][worst % COORDINATES];
    Some(Fall { body: vehicle.bodies[worst / COORDINATES].body.name.clone(), direction, rate })
}
