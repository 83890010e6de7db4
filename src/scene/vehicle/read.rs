//! Reads a vehicle.

use super::expand::{BODY, Entry, FORCE, Flat, JOINT, SENSOR, WHEELSET, expand};
use super::extent::Extent;
use super::kept::{self, Entries};
use super::places::{Bodies, ElementPlaces, Resolver};
use super::travel::Travel;
use super::wheelset::{WheelsetSpec, not_degrees, read_initial};
use super::{Element, PlacedBody, PlacedWheelset, SUSPENSION, Sensor, VehicleSpec, bearings, graph, joints};
use crate::geometry::Side;
use crate::geometry::profile::Part;
use crate::mbs::body::Body;
use crate::mbs::force::{GUIDED_SPRING, Places, REGISTRY};
use crate::mbs::inertia::Inertia;
use crate::scene::limits::SMALLEST;
use crate::scene::profiles::read_profiles;
use crate::settings::{Section, SettingsError, choose};
use crate::units::Dimension;
use nalgebra::Vector3;

/// Reads `[vehicle]`, laid over its template.
pub(super) fn vehicle<'a>(
    section: Section<'a>,
    template: &'static str,
    library: &[(&'static str, Section<'a>)],
) -> Result<VehicleSpec, SettingsError> {
    let travel = section.keep(Travel::read(&section))?;
    let flat = expand(&section, library)?;
    let mut wheelsets = all(&section, &flat.entries[WHEELSET], |entry| wheelset(entry, &flat))?;
    let bodies = all(&section, &flat.entries[BODY], |entry| body(entry, &flat))?;
    let lone = flat.entries[WHEELSET].len() == 1 && flat.entries[BODY].is_empty();
    let initial = section.keep(section.section_or_empty("initial").and_then(|initial| read_initial(initial, lone)))?;
    let drive = section.word_or("drive", &["leading", "all"], "leading")?;
    let lost = wheelsets.len() < flat.entries[WHEELSET].len() || bodies.len() < flat.entries[BODY].len();
    let travel = match travel {
        // Without all bodies, names of bodies say nothing.
        _ if lost => None,
        travel => travel,
    };
    let (Some(Travel { speed, speed_imposed, course, gravity }), Some(initial)) = (travel, initial) else {
        return Err(section.stop());
    };
    // The entries are sorted by name, and this sort keeps their order where places are equal.
    wheelsets.sort_by(|a, b| b.x.total_cmp(&a.x));
    if wheelsets.is_empty() {
        return Err(section.error("wheelset", "is missing; expected at least one [[vehicle.wheelset]], here or in a module that is placed"));
    }
    if speed_imposed && !wheelsets.iter().any(|wheelset| wheelset.driven) {
        let problem = "the imposed speed acts on no wheelset; expected driven = true on at least one, or travel = \"free\"";
        return Err(section.error("travel", problem));
    }
    if drive == "leading" {
        drive_leading(&mut wheelsets);
    }
    let (joints, forces, sensors, extent) = (Vec::new(), Vec::new(), Vec::new(), Extent::Whole);
    let mut vehicle = VehicleSpec {
        template,
        speed,
        speed_imposed,
        course,
        gravity,
        initial,
        wheelsets,
        bodies,
        joints,
        forces,
        sensors,
        extent,
        coarser: None,
        followers: Vec::new(),
        couplings: Vec::new(),
    };
    let known = known(&vehicle);
    let resolver = |entry: &Entry| Resolver::new(&flat.scopes, &known, entry);
    vehicle.joints = all(&section, &flat.entries[JOINT], |entry| {
        let joint = joints::read(&entry.name, &entry.section, &resolver(entry))?;
        entry.section.clone().finish()?;
        Ok(joint)
    })?;
    vehicle.forces = all(&section, &flat.entries[FORCE], |entry| {
        let force = force(entry, &ElementPlaces { resolver: &resolver(entry), name: &entry.name })?;
        let force = on_axles(force, &entry.section, vehicle.wheelsets.len())?;
        entry.section.clone().finish()?;
        Ok(force)
    })?;
    section.keep(bearings::check(&vehicle, &flat.entries[JOINT]))?;
    vehicle.sensors = all(&section, &flat.entries[SENSOR], |entry| {
        let resolver = resolver(entry);
        let body = resolver.body(&entry.section, "body")?;
        let point = resolver.near(&entry.section, "at", (body, resolver.point(&entry.section, "at")?))?;
        let measured = entry.section.flag_or("measured", false)?;
        entry.section.clone().finish()?;
        Ok(Sensor { name: entry.name.clone(), body, point, measured })
    })?;
    vehicle.couplings = graph::couplings(&vehicle, &flat.entries[FORCE]);
    let parse: &dyn Fn(&Entry, &dyn Places) -> Result<Element, SettingsError> = &force;
    let from = Entries { flat: &flat, bodies: &known, parse };
    if let Some(read) = section.keep(kept::read(&section, &vehicle, &from))? {
        (vehicle.extent, vehicle.coarser, vehicle.followers) = (read.extent, read.coarser, read.followers);
    }
    section.finish()?;
    Ok(vehicle)
}

/// What names and places elements may refer to.
fn known(vehicle: &VehicleSpec) -> Bodies {
    Bodies {
        names: vehicle.wheelsets.iter().map(|w| &w.spec.name).chain(vehicle.bodies.iter().map(|b| &b.body.name)).cloned().collect(),
        positions: (0..vehicle.body_count()).map(|body| vehicle.design_position(body)).collect(),
    }
}

/// Two imposed speeds keep their wheelsets' distance along the track, which is no rigid vehicle's in a curve.
fn drive_leading(wheelsets: &mut [PlacedWheelset]) {
    wheelsets.iter_mut().filter(|wheelset| wheelset.driven).skip(1).for_each(|wheelset| wheelset.driven = false);
}

/// What the entries are read to; those that can't be read are told and left out.
fn all<'a, T>(
    vehicle: &Section,
    entries: &[Entry<'a>],
    read: impl Fn(&Entry<'a>) -> Result<T, SettingsError>,
) -> Result<Vec<T>, SettingsError> {
    let mut all = Vec::with_capacity(entries.len());
    for entry in entries {
        all.extend(vehicle.keep(read(entry))?);
    }
    Ok(all)
}

fn body(entry: &Entry, flat: &Flat) -> Result<PlacedBody, SettingsError> {
    let Entry { name, scope, side, section, .. } = entry;
    let inertia = |key| section.at_least(key, Dimension::Inertia, SMALLEST);
    let principal = Vector3::new(inertia("inertia_xx")?, inertia("inertia_yy")?, inertia("inertia_zz")?);
    let mut position: Vector3<f64> = section.triple("position", Dimension::Length)?.into();
    if *side == Some(Side::Right) {
        position.y = -position.y;
    }
    let mass = section.at_least("mass", Dimension::Mass, SMALLEST)?;
    section.clone().finish()?;
    let body = Body { name: name.clone(), mass, inertia: Inertia::General { principal } };
    Ok(PlacedBody { body, position: flat.scopes[*scope].offset + position })
}

fn wheelset(entry: &Entry, flat: &Flat) -> Result<PlacedWheelset, SettingsError> {
    let Entry { name, scope, section, .. } = entry;
    let profiles = match flat.wheel_profiles(*scope) {
        Some(profiles) if !section.has_table("profile") => Some(profiles.clone()),
        _ => section.keep(read_profiles(section, ["profile", "left_profile", "right_profile"], Part::Wheel))?,
    };
    let load = section.number_or("vertical_load", Dimension::Force, 0.0)?;
    let yaw = section.number_or("initial_yaw", Dimension::Angle, 0.0)?;
    not_degrees(section, "initial_yaw", yaw)?;
    let wheelset = PlacedWheelset {
        spec: WheelsetSpec::read(section, name.clone(), load, profiles)?,
        x: flat.scopes[*scope].offset.x + section.number("x", Dimension::Length)?,
        driven: section.flag_or("driven", false)?,
        offset: [section.number_or("initial_y", Dimension::Length, 0.0)?, yaw],
    };
    section.clone().finish()?;
    Ok(wheelset)
}

/// An element without what bearings do not hand over. What turns an axle acts on a wheelset, which comes before the other bodies, and is carried by one of those.
fn on_axles(force: Element, section: &Section, wheelsets: usize) -> Result<Element, SettingsError> {
    let wheelset = |body: Option<usize>| body.is_some_and(|body| body < wheelsets);
    if force.0.twist().is_some_and(|twist| !wheelset(Some(twist.body))) {
        return Err(section.error("body", "is no wheelset; expected the wheelset whose wheels turn against each other"));
    }
    if !force.0.turns_axle() {
        return Ok(bearings::rest_on_axles(force, wheelsets));
    }
    let [axle, carrier, rotor] = force.0.reach();
    if !wheelset(axle) {
        return Err(section.error("to", "is no wheelset; expected the wheelset that the element turns or brakes"));
    }
    // What holds the rotor is one of both or, where a torque arm is on another body, a third.
    let key = if section.has("arm") { "arm" } else { "from" };
    match [(key, carrier), ("from", rotor.filter(|_| key == "arm"))].into_iter().find(|(_, body)| wheelset(*body)) {
        Some((key, _)) => Err(section.error(key, "is a wheelset; expected the body that carries motor or brake")),
        None => Ok(bearings::rest_on_axles(force, wheelsets)),
    }
}

fn force(entry: &Entry, places: &dyn Places) -> Result<Element, SettingsError> {
    let kind = match entry.name.ends_with(SUSPENSION) {
        true => &GUIDED_SPRING,
        false => choose(REGISTRY, &entry.section, "kind")?,
    };
    Ok(Element((kind.parse)(&entry.section, places)?))
}
