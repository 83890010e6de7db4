//! What holds to an axle by its bearings: they hand no moment about the axle over.
//!
//! An attachment to a wheelset sits on a box that is kept level (`mbs::force::attachment`). A joint that holds a body against turning with that box would take a moment about the axle from
//! nowhere: a frame on horn guides (`prismatic`) or fixed (`rigid`) on its axles could not pitch, and axle loads would be shared by no law of statics. So would a spring against
//! turning about the axle; between a box that is free to turn and a body it has no force, and is left out.

use super::expand::Entry;
use super::{Element, VehicleSpec};
use crate::mbs::joint::Joint;
use crate::settings::SettingsError;

/// Joints may hold so far off the axle's line, m, as force elements may.
const OFF_AXLE: f64 = 0.01;

/// Takes from an element what bearings do not hand over.
pub(super) fn rest_on_axles(mut force: Element, wheelsets: usize) -> Element {
    if force.0.bodies().into_iter().flatten().any(|body| body < wheelsets) {
        force.0.free_about_axle();
    }
    force
}

/// Checks the vehicle's joints, which were read from these entries.
///
/// # Errors
/// One holds what it joins against turning about an axle; a body that nothing else holds, as a mass that is added to the axle, may be held so.
pub(super) fn check(vehicle: &VehicleSpec, entries: &[Entry]) -> Result<(), SettingsError> {
    for joint in &vehicle.joints {
        let Some((wheelset, other)) = ends(joint, vehicle.wheelsets.len()) else { continue };
        if !joint.holds_about_y(wheelset, OFF_AXLE) || other.is_some_and(|other| alone(vehicle, joint, other)) {
            continue;
        }
        if let Some(entry) = entries.iter().find(|entry| entry.name == joint.name) {
            return Err(entry.section.error(
                "kind",
                format!(
                    "this joint holds what it joins against turning about the axle of {}, which no bearing does: load transfer would be lost. Expected a revolute joint about y on the axle's line, to an \
                     axle box (a body of its own) that the others hold to",
                    vehicle.wheelsets[wheelset].spec.name
                ),
            ));
        }
    }
    Ok(())
}

/// The wheelset of a joint, and what it joins it with.
fn ends(joint: &Joint, wheelsets: usize) -> Option<(usize, Option<usize>)> {
    let [first, second] = [Some(joint.bodies.first), joint.bodies.second];
    let axle = |body: Option<usize>| body.filter(|body| *body < wheelsets);
    axle(first).map(|wheelset| (wheelset, second)).or_else(|| axle(second).map(|wheelset| (wheelset, first)))
}

/// Is this joint all that acts on a body?
fn alone(vehicle: &VehicleSpec, joint: &Joint, body: usize) -> bool {
    let joined = |other: &&Joint| other.bodies.first == body || other.bodies.second == Some(body);
    let acts = |element: &Element| element.0.reach().into_iter().flatten().any(|reached| reached == body);
    body >= vehicle.wheelsets.len()
        && vehicle.joints.iter().filter(joined).all(|own| own.name == joint.name)
        && !vehicle.forces.iter().any(acts)
}
