//! Bodies, forces and joints of a vehicle, whatever template it comes from.

use super::suspended::{SuspensionSpec, WheelsetSpec};
use super::{FreeVehicle, VehicleSpec, static_preload};
use crate::formulation::{AssemblyError, Wheelset};
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::mbs::body::Body;
use crate::mbs::force::{ForceElement, Gravity, GuidedSpring, TrackAxis, VerticalLoad};
use crate::mbs::inertia::Inertia;
use crate::mbs::supported::SupportedMass;
use crate::mbs::system::{DrivingConstraint, System};

/// Multibody system and wheelsets of a vehicle on a track that climbs with `grade` [rad].
///
/// # Errors
/// [`AssemblyError::Joints`] when joints contradict each other.
pub fn parts(vehicle: &VehicleSpec, grade: f64) -> Result<(System, Vec<Wheelset>), AssemblyError> {
    match &vehicle.free {
        Some(free) => free_parts(vehicle, free, grade),
        None => Ok(suspended_parts(vehicle, grade)),
    }
}

fn body(spec: &WheelsetSpec) -> Body {
    let inertia = Inertia::Revolution { transverse: spec.transverse_inertia, axial: spec.axial_inertia };
    Body { name: spec.name.clone(), mass: spec.mass, inertia }
}

fn wheels(spec: &WheelsetSpec) -> [Wheel; 2] {
    let wheel =
        |side: Side| Wheel { side, profile: spec.profiles[side.index()].profile.clone(), half_spacing: spec.half_tread_circle_distance };
    Side::BOTH.map(wheel)
}

fn wheelset(spec: &WheelsetSpec, body: usize, imposed_speed: Option<f64>, static_wheel_load: f64) -> Wheelset {
    let [left, right] = wheels(spec);
    Wheelset { name: spec.name.clone(), body, left, right, imposed_speed, static_wheel_load }
}

/// Left and right wheels of every wheelset.
pub fn all_wheels(vehicle: &VehicleSpec) -> Vec<[Wheel; 2]> {
    match &vehicle.free {
        Some(free) => free.wheelsets.iter().map(|placed| wheels(&placed.spec)).collect(),
        None => vec![wheels(&vehicle.wheelset)],
    }
}

/// The inertia along the track of what a load stands for; where the speed is imposed it makes no force.
fn supported(load: &VerticalLoad, speed_imposed: bool) -> Option<SupportedMass> {
    (load.mass != 0.0 && !speed_imposed).then_some(SupportedMass { body: load.body, mass: load.mass })
}

fn suspended_parts(vehicle: &VehicleSpec, grade: f64) -> (System, Vec<Wheelset>) {
    let spec = &vehicle.wheelset;
    let mut forces: Vec<Box<dyn ForceElement>> = Vec::new();
    if vehicle.gravity != 0.0 {
        forces.push(Box::new(Gravity { body: 0, mass: spec.mass, acceleration: vehicle.gravity, grade }));
    }
    let load = VerticalLoad::new(0, spec.vertical_load, vehicle.gravity, grade);
    let supported = supported(&load, vehicle.speed_imposed).into_iter().collect();
    if load.force != 0.0 {
        forces.push(Box::new(load));
    }
    if let Some(suspension) = &vehicle.suspension {
        forces.extend(springs(suspension).map(|spring| Box::new(spring) as Box<dyn ForceElement>));
    }
    let imposed_speed = vehicle.speed_imposed.then_some(vehicle.speed);
    let system = System {
        bodies: vec![body(spec)],
        forces,
        drives: imposed_speed.map(|speed| DrivingConstraint { body: 0, speed }).into_iter().collect(),
        supported,
        joints: Vec::new(),
        redundant: Vec::new(),
    };
    let load = 0.5 * (spec.mass * vehicle.gravity + spec.vertical_load) * grade.cos();
    (system, vec![wheelset(spec, 0, imposed_speed, load)])
}

/// The suspension's elements; a direction that the scene does not call for has none.
fn springs(spec: &SuspensionSpec) -> impl Iterator<Item = GuidedSpring> + '_ {
    let directions = [
        (spec.longitudinal, "longitudinal", TrackAxis::Longitudinal, spec.longitudinal_stiffness, spec.longitudinal_damping),
        (spec.lateral, "lateral", TrackAxis::Lateral, spec.lateral_stiffness, spec.lateral_damping),
    ];
    let numbered = (0..).zip(directions).filter(|(_, direction)| direction.0);
    numbered.flat_map(|(row, (_, direction, axis, stiffness, damping))| {
        (0..).zip(Side::BOTH).zip(spec.attachments()).map(move |((column, side), attachment)| GuidedSpring {
            name: format!("suspension.{}.{direction}", side.name()),
            output_number: 2 * row + column,
            body: 0,
            axis,
            attachment,
            stiffness,
            damping,
        })
    })
}

/// Every wheel begins with an equal share of the weight; the steady state puts its own load in place of it.
fn free_parts(vehicle: &VehicleSpec, free: &FreeVehicle, grade: f64) -> Result<(System, Vec<Wheelset>), AssemblyError> {
    let bodies: Vec<Body> =
        free.wheelsets.iter().map(|w| body(&w.spec)).chain(free.bodies.iter().map(|placed| placed.body.clone())).collect();
    let mut forces: Vec<Box<dyn ForceElement>> = Vec::new();
    if vehicle.gravity != 0.0 {
        let weight = |(number, body): (usize, &Body)| Gravity { body: number, mass: body.mass, acceleration: vehicle.gravity, grade };
        forces.extend(bodies.iter().enumerate().map(|body| Box::new(weight(body)) as Box<dyn ForceElement>));
    }
    let loaded = free.wheelsets.iter().enumerate().filter(|(_, wheelset)| wheelset.spec.vertical_load != 0.0);
    let loads = loaded.map(|(number, wheelset)| VerticalLoad::new(number, wheelset.spec.vertical_load, vehicle.gravity, grade));
    let loads: Vec<VerticalLoad> = loads.collect();
    let imposed = |load: &VerticalLoad| vehicle.speed_imposed && free.wheelsets[load.body].driven;
    let supported = loads.iter().filter_map(|load| supported(load, imposed(load))).collect();
    forces.extend(loads.into_iter().map(|load| Box::new(load) as Box<dyn ForceElement>));
    forces.extend(free.forces.iter().map(|element| element.0.clone_box()));
    let driven = |wheelset: &super::PlacedWheelset| (vehicle.speed_imposed && wheelset.driven).then_some(vehicle.speed);
    let drives = free.wheelsets.iter().enumerate().filter_map(|(body, wheelset)| driven(wheelset).map(|speed| (body, speed)));
    let mut system = System {
        bodies,
        forces,
        drives: drives.map(|(body, speed)| DrivingConstraint { body, speed }).collect(),
        supported,
        joints: free.joints.clone(),
        redundant: Vec::new(),
    };
    if !system.joints.is_empty() {
        let found = system.find_redundant(0.0, &design_state(free, &system, vehicle.speed)).map_err(AssemblyError::Joints)?;
        system.redundant = found.into_iter().map(|row| row.row).collect();
    }
    static_preload::balance(free, &mut system, vehicle.gravity)?;
    let load = free.weight(vehicle.gravity) * grade.cos() / (2.0 * free.wheelsets.len() as f64);
    let wheelsets = free.wheelsets.iter().enumerate().map(|(body, placed)| wheelset(&placed.spec, body, driven(placed), load)).collect();
    Ok((system, wheelsets))
}

/// State of the system in the design configuration, travelling with `speed` [m/s].
pub(super) fn design_state(free: &FreeVehicle, system: &System, speed: f64) -> Vec<f64> {
    let mut y = vec![0.0; system.dimension()];
    for body in 0..free.body_count() {
        y[system.coordinates(body)][..3].copy_from_slice(free.design_position(body).as_slice());
        y[system.velocities(body).start] = speed;
    }
    y
}
