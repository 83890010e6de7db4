//! Parameters of a free vehicle's parts.

use super::parameters::Row;
use super::variables::{BODY, WHEELSET};
use crate::mbs::inertia::Inertia;
use crate::scene::spec::{SMALLEST, Scene};
use crate::scene::vehicle::{FreeVehicle, PlacedBody, PlacedWheelset};
use crate::sim::unit::Unit;

type Get = fn(&Scene, usize) -> f64;
type Set = fn(&mut Scene, usize, f64);

fn wheelset(scene: &Scene, index: usize) -> Option<&PlacedWheelset> {
    scene.vehicle.free.as_ref().and_then(|free| free.wheelsets.get(index))
}

fn body(scene: &Scene, index: usize) -> Option<&PlacedBody> {
    scene.vehicle.free.as_ref().and_then(|free| free.bodies.get(index))
}

/// A number of a wheelset.
macro_rules! of_wheelset {
    ($($field:tt)+) => {
        (
            (|scene, index| wheelset(scene, index).map_or(0.0, |w| w.$($field)+)) as Get,
            (|scene, index, value| {
                if let Some(w) = scene.vehicle.free.as_mut().and_then(|free| free.wheelsets.get_mut(index)) {
                    w.$($field)+ = value;
                }
            }) as Set,
        )
    };
}

/// A principal inertia of a body.
macro_rules! of_body {
    ($axis:ident) => {
        (
            (|scene, index| match body(scene, index).map(|b| &b.body.inertia) {
                Some(Inertia::General { principal }) => principal.$axis,
                _ => 0.0,
            }) as Get,
            (|scene, index, value| {
                let body = scene.vehicle.free.as_mut().and_then(|free| free.bodies.get_mut(index));
                if let Some(Inertia::General { principal }) = body.map(|b| &mut b.body.inertia) {
                    principal.$axis = value;
                }
            }) as Set,
        )
    };
}

/// Reference, last part of the name, unit, smallest value, description, access.
type Line = (u32, &'static str, Unit, Option<f64>, &'static str, (Get, Set));

/// All parameters of the vehicle's parts and of its start.
pub(super) fn rows(scene: &Scene, free: &FreeVehicle) -> Vec<Row> {
    let wheelset_lines: [Line; 6] = [
        (400, "mass", Unit::Kilogram, Some(SMALLEST), "mass of the wheelset", of_wheelset!(spec.mass)),
        (
            401,
            "transverseInertia",
            Unit::KilogramMetre2,
            Some(SMALLEST),
            "moment of inertia about any axis across the axle (Ixx = Izz)",
            of_wheelset!(spec.transverse_inertia),
        ),
        (
            402,
            "axialInertia",
            Unit::KilogramMetre2,
            Some(SMALLEST),
            "moment of inertia about the axle (Iyy)",
            of_wheelset!(spec.axial_inertia),
        ),
        (
            403,
            "verticalLoad",
            Unit::Newton,
            None,
            "weight of what rests on the wheelset, down positive: plumb, with its centrifugal force and its inertia along the track",
            of_wheelset!(spec.vertical_load),
        ),
        (451, "initial.y", Unit::Metre, None, "added to y of the steady state at the start", of_wheelset!(offset[0])),
        (454, "initial.yaw", Unit::Radian, None, "added to the yaw of the steady state at the start", of_wheelset!(offset[1])),
    ];
    let mass: (Get, Set) = (
        |scene, index| body(scene, index).map_or(0.0, |b| b.body.mass),
        |scene, index, value| {
            if let Some(b) = scene.vehicle.free.as_mut().and_then(|free| free.bodies.get_mut(index)) {
                b.body.mass = value;
            }
        },
    );
    let body_lines: [Line; 4] = [
        (50, "mass", Unit::Kilogram, Some(SMALLEST), "mass of the body", mass),
        (51, "inertiaXx", Unit::KilogramMetre2, Some(SMALLEST), "moment of inertia about the body's x axis", of_body!(x)),
        (52, "inertiaYy", Unit::KilogramMetre2, Some(SMALLEST), "moment of inertia about the body's y axis", of_body!(y)),
        (53, "inertiaZz", Unit::KilogramMetre2, Some(SMALLEST), "moment of inertia about the body's z axis", of_body!(z)),
    ];
    let mut rows = Vec::new();
    let mut add = |base: u32, part: &str, index: usize, (id, name, unit, min, text, (get, set)): Line| {
        let group = if name.starts_with("initial") { "initial" } else { "vehicle" };
        let name = if part.is_empty() { name.to_string() } else { format!("{part}.{name}") };
        rows.push(Row { id: base + id, group, name, unit, min, max: None, text, index, get, set });
    };
    for (index, w) in free.wheelsets.iter().enumerate().filter(|(_, w)| scene.interface.shows(&w.spec.name)) {
        for line in wheelset_lines {
            add(WHEELSET * (index as u32 + 1), &w.spec.name, index, line);
        }
    }
    for (index, b) in free.bodies.iter().enumerate().filter(|(_, b)| scene.interface.shows(&b.body.name)) {
        for line in body_lines {
            add(BODY + 100 * index as u32, &b.body.name, index, line);
        }
    }
    let distance: (Get, Set) = (
        |scene, _| scene.vehicle.free.as_ref().map_or(0.0, |free| free.distance),
        |scene, _, value| {
            if let Some(free) = scene.vehicle.free.as_mut() {
                free.distance = value;
            }
        },
    );
    let text = "distance along the track of the vehicle's design origin at the start";
    add(0, "", 0, (10, "initial.distance", Unit::Distance, None, text, distance));
    rows
}
