//! The state that a scene begins with.

use crate::formulation::Model;
use crate::geometry::track::centre_line::CentreLine;
use crate::mbs::body::COORDINATES;
use crate::mbs::on_track::{self, OnTrack};
use crate::scene::spec::Scene;
use crate::scene::steady_state::{Contacts, SteadyState};

/// The `steady` state with the scene's initial values, or these alone, in the track frame; with it, how contacts begin.
pub(super) fn initial_state(scene: &Scene, model: &Model, steady: Option<SteadyState>) -> (Vec<f64>, Contacts) {
    let [distance, given @ ..] = scene.vehicle.initial.values;
    let (mut state, contacts) = steady.map_or((Vec::new(), Contacts::Any), |steady| (steady.y, steady.contacts));
    state.resize(model.dimension(), 0.0);
    for body in 0..scene.vehicle.body_count() {
        state[model.system.coordinates(body).start] += distance;
    }
    for (wheelset, placed) in model.wheelsets.iter().zip(&scene.vehicle.wheelsets) {
        let q = model.system.coordinates(wheelset.body).start;
        state[q + 1] += placed.offset[0];
        state[q + 3] += placed.offset[1];
    }
    if scene.vehicle.is_lone() {
        let [y, z, roll, yaw, vy, vz, roll_rate, yaw_rate, pitch_rate] = given;
        let added = [0.0, y, z, yaw, roll, 0.0, 0.0, vy, vz, yaw_rate, roll_rate, pitch_rate];
        state.iter_mut().zip(added).for_each(|(value, added)| *value += added);
        state[COORDINATES] = scene.vehicle.speed;
    }
    let displaced = scene.vehicle.wheelsets.iter().any(|placed| placed.offset != [0.0; 2]) || given != [0.0; 9];
    (state, if displaced { Contacts::Any } else { contacts })
}

/// From values in the track frame to the world.
pub(super) fn on_the_line(model: &Model, line: &CentreLine, y: &mut [f64]) {
    for body in 0..model.system.bodies.len() {
        let (q, v) = (model.system.coordinates(body), model.system.velocities(body));
        let mut at = OnTrack::default();
        at.coordinates.copy_from_slice(&y[q.clone()]);
        at.velocities.copy_from_slice(&y[v.clone()]);
        let (coordinates, velocities) = on_track::place(&line.frame(at.coordinates[0]), &at);
        y[q].copy_from_slice(&coordinates);
        y[v].copy_from_slice(&velocities);
    }
}
