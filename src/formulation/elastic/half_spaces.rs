//! A wheel whose patch is that of elastic half-spaces on a grid (`contact.patch = "exact"`, [`crate::contact::patch`]): the reference in the equations of motion, slow.
//!
//! In each evaluation the normal problem is solved for the two real surfaces and Kalker's tangential one on the same cells, with the slip and the friction that each cell has.
//! Each patch is a contact at its load's centre. Damping is stated for patches (their overlap and its rate there) and raises all of a patch's pressures alike.
//!
//! *What it leaves out.* The grid goes with the wheel: N is off by 5e-4 of itself, and jumps by parts of that where its number of cells changes (a second place
//! gets enough cells of its own); creep forces are extrapolated, and scatter by 0.005 mu N on 32 cells. Where two patches become one, damping changes from theirs to that of the whole at once. Slopes for
//! implicit methods are those of strips with Kalker's simplified theory (FASTSIM), a few percent off: a method that needs them exact makes smaller steps.

use super::super::loading::{Contact, WheelAt};
use super::super::patch_loads::Loaded;
use super::super::{ContactFailure, ContactReport};
use crate::contact::normal::damping::damped_force;
use crate::contact::patch::{Motion, Place, PlaceCreep, Pressed, Settings};
use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters};
use crate::contact::strips::{Creep, MOST};

/// The normal problem of a wheel, on a grid that resolves each of its places; `None` where its iteration finds no end.
fn press(wheel: &WheelAt, settings: Settings) -> Option<Pressed> {
    Pressed::resolved(&wheel.pair(), wheel.model.laws.material, settings)
}

/// Rail coordinate of each patch of a wheel, m, and the highest pressure in it, Pa.
pub(in crate::formulation) fn highest_pressures(wheel: &WheelAt, settings: Settings) -> Vec<(f64, f64)> {
    let places = press(wheel, settings).map(|pressed| pressed.places(MOST)).unwrap_or_default();
    places.iter().map(|place| (place.eta, place.highest_pressure)).collect()
}

/// Solves all patches of a wheel.
///
/// # Errors
/// [`ContactFailure`] where the wheel is too deep in the rail, does not roll, or the normal problem finds no end.
pub(super) fn load(wheel: &WheelAt, settings: Settings, loaded: &mut Loaded) -> Result<(), ContactFailure> {
    let WheelAt { model, motion, .. } = *wheel;
    let (pair, laws) = (wheel.pair(), &model.laws);
    let pressed = press(wheel, settings).ok_or_else(|| ContactFailure::Unsettled { y: model.beside(motion).0 })?;
    let places = pressed.places(model.points.min(MOST));
    loaded.weight = None;
    let carried = &mut loaded.shown;
    carried.count = places.len();
    let mut damped = [0.0; MOST];
    for (k, place) in places.iter().enumerate() {
        let found = location(wheel, place);
        let contact = Contact { wheel, found: &found, slot: k, share: 1.0 };
        contact.check_depth()?;
        let report = &mut carried.all[k];
        *report = contact.report();
        let size = place.force.norm();
        report.stiffness = size / (place.overlap * place.overlap.sqrt());
        (report.elastic_slope, report.patch) = (1.5 * size / place.overlap, place.patch);
        report.normal_force = damped_force(laws.damping.as_ref(), place.load, place.overlap, report.penetration_rate);
        damped[k] = report.normal_force / place.load;
        carried.forces[k] = size * damped[k];
    }
    let rolling = Motion { velocity: motion.velocity, rotation: motion.rotation, speed: wheel.speed() };
    let friction = |k: usize, lead: f64, eta: f64| {
        let factor = laws
            .friction_map
            .as_ref()
            .map_or(1.0, |map| map.at(wheel.side, motion.distance + lead, pair.rail.profile.value_and_slope(eta).1).value);
        laws.friction * factor * wheel.friction.max(0.0) * damped[k]
    };
    for (k, creep) in pressed.rolling(&places, &rolling, &friction).iter().enumerate() {
        let ContactReport { axes, .. } = &carried.all[k];
        let PlaceCreep { force, moment, bound } = *creep;
        let about_normal = moment.dot(&axes.normal);
        carried.couples[k] = places[k].moment * damped[k] + moment - axes.normal * about_normal;
        carried.creeps[k] = Creep { force, moment: about_normal, bound };
    }
    Ok(())
}

/// A patch as a place where wheel and rail touch.
fn location(wheel: &WheelAt, place: &Place) -> ContactLocation {
    let (motion, pair) = (wheel.motion, wheel.pair());
    let axes = &motion.frame.axes;
    let size = place.force.norm();
    let normal = place.force / size;
    let forward = place.forward - normal * normal.dot(&place.forward);
    let u = place.arm.dot(&axes.column(1)) * wheel.side.sign() - pair.wheel.half_spacing;
    let angle = place.arm.dot(&axes.column(0)).atan2(-place.arm.dot(&axes.column(2)));
    ContactLocation {
        parameters: SurfaceParameters { wheel: u, angle, lead: place.lead, rail: place.eta },
        wheel_point: motion.position + place.arm,
        normal,
        forward,
        penetration: place.overlap,
        wheel_profile: pair.wheel.profile.at(u),
        rail_profile: pair.rail.profile.at(place.eta),
        iterations: 0,
    }
}
