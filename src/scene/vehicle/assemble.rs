//! Bodies, forces and joints of a vehicle.

use super::design::design_state;
use super::wheelset::WheelsetSpec;
use super::{PlacedWheelset, VehicleSpec, static_preload};
use crate::formulation::{AssemblyError, Wheelset};
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::mbs::body::Body;
use crate::mbs::driving::DrivingConstraint;
use crate::mbs::force::{ForceElement, Gravity, VerticalLoad};
use crate::mbs::inertia::Inertia;
use crate::mbs::supported::SupportedMass;
use crate::mbs::system::System;
use crate::mbs::twist::{Axles, Twist};

fn body(spec: &WheelsetSpec) -> Body {
    let (transverse, axial) = (spec.transverse_inertia, spec.axial_inertia);
    let inertia = match spec.gyroscopic {
        true => Inertia::Revolution { transverse, axial },
        false => Inertia::NotGyroscopic { transverse, axial },
    };
    Body { name: spec.name.clone(), mass: spec.mass, inertia }
}

fn wheels(spec: &WheelsetSpec) -> [Wheel; 2] {
    let wheel =
        |side: Side| Wheel { side, profile: spec.profiles[side.index()].profile.clone(), half_spacing: spec.half_tread_circle_distance };
    Side::BOTH.map(wheel)
}

fn wheelset(spec: &WheelsetSpec, (body, turning): (usize, [usize; 2]), imposed_speed: Option<f64>, static_wheel_load: f64) -> Wheelset {
    let [left, right] = wheels(spec);
    Wheelset { name: spec.name.clone(), body, turning, left, right, imposed_speed, static_wheel_load }
}

/// Left and right wheels of every wheelset.
pub fn all_wheels(vehicle: &VehicleSpec) -> Vec<[Wheel; 2]> {
    vehicle.wheelsets.iter().map(|placed| wheels(&placed.spec)).collect()
}

/// The inertia along the track of what a load stands for; where the speed is constant it makes no force.
fn supported(load: &VerticalLoad, constant: bool) -> Option<SupportedMass> {
    (load.mass != 0.0 && !constant).then_some(SupportedMass { body: load.body, mass: load.mass })
}

/// The wheelsets that twist, in the order of the elements that let them.
fn twisted(bodies: &[Body], forces: &[Box<dyn ForceElement>]) -> Result<Vec<usize>, AssemblyError> {
    let mut found: Vec<(usize, &str)> = Vec::new();
    for force in forces {
        let Some(Twist { body, .. }) = force.twist() else { continue };
        if let Some((_, first)) = found.iter().find(|(other, _)| *other == body) {
            return Err(AssemblyError::TwoTwists { axle: bodies[body].name.clone(), elements: [(*first).into(), force.name().into()] });
        }
        found.push((body, force.name()));
    }
    Ok(found.into_iter().map(|(body, _)| body).collect())
}

/// State of its system in the design configuration, at rest.
pub fn design(vehicle: &VehicleSpec, system: &System) -> Vec<f64> {
    design_state(vehicle, system, 0.0)
}

/// Multibody system and wheelsets of a vehicle on a track that climbs with `grade` [rad]. Every wheel begins with an equal share of the
/// weight; where there are several wheelsets the steady state puts its own load in place of it.
///
/// # Errors
/// [`AssemblyError`] when joints contradict each other, preloads do not balance, or an axle has two elements that let it twist.
pub fn parts(vehicle: &VehicleSpec, grade: f64) -> Result<(System, Vec<Wheelset>), AssemblyError> {
    let (mut system, turning) = unbalanced(vehicle, grade)?;
    if vehicle.away().is_none() {
        // Drawn, and balanced, on level track.
        for (element, index, force) in static_preloads(vehicle)? {
            let first = system.forces.len() - vehicle.forces.len();
            system.forces[first + element].set_preload(index, force);
        }
    }
    let load = vehicle.weight() * grade.cos() / (2.0 * vehicle.wheelsets.len() as f64);
    let wheelsets = vehicle
        .wheelsets
        .iter()
        .enumerate()
        .map(|(body, placed)| wheelset(&placed.spec, (body, turning[body]), constant(vehicle, placed), load))
        .collect();
    Ok((system, wheelsets))
}

/// Preloads that balance on level track asks for: number among the vehicle's force elements, index and force [N].
///
/// # Errors
/// [`AssemblyError`], as for [`parts`].
pub fn static_preloads(vehicle: &VehicleSpec) -> Result<Vec<(usize, usize, f64)>, AssemblyError> {
    if vehicle.forces.iter().all(|element| element.0.static_stiffness().is_empty()) {
        return Ok(Vec::new());
    }
    let (system, _) = unbalanced(vehicle, 0.0)?;
    // Weights and loads come first.
    let first = system.forces.len() - vehicle.forces.len();
    Ok(static_preload::found(vehicle, &system)?.into_iter().map(|(element, index, force)| (element - first, index, force)).collect())
}

/// The constant speed that is imposed on a wheelset, m/s.
fn constant(vehicle: &VehicleSpec, wheelset: &PlacedWheelset) -> Option<f64> {
    (vehicle.keeps_speed() && wheelset.driven).then_some(vehicle.speed)
}

/// What imposes speeds on wheelsets, the leading one first.
fn drives(vehicle: &VehicleSpec) -> Vec<DrivingConstraint> {
    let leader = vehicle.leader();
    let driven = vehicle.wheelsets.iter().enumerate().filter(|(_, wheelset)| vehicle.speed_imposed && wheelset.driven);
    driven.map(|(body, _)| DrivingConstraint { body, speed: vehicle.speed, course: vehicle.course.clone(), leader }).collect()
}

/// The system with preloads as they are given, and whose motions the wheels of each wheelset have.
fn unbalanced(vehicle: &VehicleSpec, grade: f64) -> Result<(System, Vec<[usize; 2]>), AssemblyError> {
    let bodies: Vec<Body> =
        vehicle.wheelsets.iter().map(|w| body(&w.spec)).chain(vehicle.bodies.iter().map(|placed| placed.body.clone())).collect();
    let mut forces: Vec<Box<dyn ForceElement>> = Vec::new();
    if vehicle.gravity != 0.0 {
        let weight = |(number, body): (usize, &Body)| Gravity { body: number, mass: body.mass, acceleration: vehicle.gravity, grade };
        forces.extend(bodies.iter().enumerate().map(|body| Box::new(weight(body)) as Box<dyn ForceElement>));
    }
    let loaded = vehicle.wheelsets.iter().enumerate().filter(|(_, wheelset)| wheelset.spec.vertical_load != 0.0);
    let loads = loaded.map(|(number, wheelset)| VerticalLoad::new(number, wheelset.spec.vertical_load, vehicle.gravity, grade));
    let loads: Vec<VerticalLoad> = loads.collect();
    let steady = |load: &VerticalLoad| constant(vehicle, &vehicle.wheelsets[load.body]).is_some();
    let mut supported: Vec<SupportedMass> = loads.iter().filter_map(|load| supported(load, steady(load))).collect();
    for carried in vehicle.away().map_or(&[][..], |away| &away.along) {
        match supported.iter_mut().find(|own| own.body == carried.body) {
            Some(own) => own.mass += carried.mass,
            None => supported.push(*carried),
        }
    }
    forces.extend(loads.into_iter().map(|load| Box::new(load) as Box<dyn ForceElement>));
    let pulls = vehicle.away().map_or(&[][..], |away| &away.pulls);
    forces.extend(pulls.iter().map(|pull| Box::new(*pull) as Box<dyn ForceElement>));
    forces.extend(vehicle.forces.iter().map(|element| element.0.clone_box()));
    let twisted = twisted(&bodies, &forces)?;
    let axles = Axles { bodies: &bodies, twisted: &twisted };
    forces.iter_mut().for_each(|force| force.fit(&axles));
    let turning = |body: usize| Side::BOTH.map(|side| axles.turning(body, side));
    let turning: Vec<[usize; 2]> = (0..vehicle.wheelsets.len()).map(turning).collect();
    let mut system = System { bodies, forces, drives: drives(vehicle), supported, joints: vehicle.joints.clone(), redundant: Vec::new() };
    if !system.joints.is_empty() {
        let found = system.find_redundant(0.0, &design_state(vehicle, &system, vehicle.speed)).map_err(AssemblyError::Joints)?;
        system.redundant = found.into_iter().map(|row| row.row).collect();
    }
    Ok((system, turning))
}
