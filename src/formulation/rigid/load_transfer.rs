//! The load of a wheel as its contact passes from a constraint to elastic forces.
//!
//! A constraint holds its wheel at zero penetration, elastic places carry its load only when they are pressed in by 50 to 70 um. A wheel whose
//! place has ended is therefore moved down to where all its places together carry the vertical force that they carried before,
//! so that accelerations pass over the change as if there were none; rates are left as the other constraints want them.

use super::projection::{Pressed, project_pressed};
use crate::formulation::elastic::points;
use crate::formulation::loading::WheelAt;
use crate::formulation::rail_motion::Climb;
use crate::formulation::step::{Step, WheelRef};
use crate::formulation::{ContactReport, Workspace};
use crate::mbs::body::Wrench;

/// A place this steep (vertical part of its normal) or this far away [m] can't take over the load of one that ceases to exist.
const LEAST_VERTICAL: f64 = 0.8;
const FURTHEST: f64 = 5e-5;
/// Most that it takes over, in static wheel loads: the force of a constraint grows without bound where its place ceases to exist
/// (the place runs ever faster along the curved surfaces), and says nothing of the load there.
const MOST_CARRIED: f64 = 1.25;

/// The places of a wheel that is handed over carry its load to this part of it after this many corrections.
const PRESSED: f64 = 1e-6;
const PRESSINGS: usize = 12;

/// Vertical force on a wheel from its contacts as they were found last, N; of its constraint at most what such a one says something
/// about.
pub(super) fn carried(wheel: WheelRef, workspace: &Workspace) -> f64 {
    let most = MOST_CARRIED * wheel.wheelset.static_wheel_load;
    let vertical =
        |report: &ContactReport| report.axes.normal.z * report.normal_force.min(if report.constrained { most } else { f64::MAX });
    workspace.reports(wheel.contact).map(vertical).sum()
}

/// Penetration of a wheel's deepest place [m] under which that would carry `load` [N, vertical] alone; `None` where it could not: a flange,
/// or nothing near.
pub(super) fn depth_under_load(step: &mut Step, wheel: WheelRef, load: f64) -> Option<f64> {
    if !(load > 0.0) {
        return None;
    }
    step.move_bodies();
    let model = step.model;
    let pair = wheel.pair(model, &step.workspace.system.motions[wheel.wheelset.body]);
    let place = points::deepest(model, wheel.contact, &pair).unwrap_or(*step.memory.wheels[wheel.contact].start());
    let found = pair.locate(&place).ok()?;
    if found.normal.z < LEAST_VERTICAL || found.penetration < -FURTHEST {
        return None;
    }
    let shape = found.shape(pair.wheel, pair.rail);
    model.laws.normal.contact_under(&shape, load / found.normal.z).ok().map(|(depth, _)| depth)
}

/// Moves a wheel that has become elastic to where its places together carry `load` [N, vertical], from the penetration of the deepest one
/// that alone would: another one may be pressed beside it and share its patch. Where
/// the search for the depth ends before (no load there, or [`PRESSINGS`] tries) the wheel starts from the depth tried last, and bounces.
pub(super) fn press(step: &mut Step, wheel: WheelRef, load: f64, mut depth: f64) {
    let beside = held_beside(step, wheel);
    step.workspace.rigid.consistent.copy_from_slice(step.y);
    for _ in 0..PRESSINGS {
        step.y.copy_from_slice(&step.workspace.rigid.consistent);
        let pressed = [Some(Pressed { contact: wheel.contact, depth, gap_rate: 0.0 }), beside];
        if project_pressed(step, pressed).is_err() {
            step.y.copy_from_slice(&step.workspace.rigid.consistent);
            return;
        }
        let Some(found) = elastic_load(step, wheel).filter(|found| *found > 0.0) else { return };
        if (found / load - 1.0).abs() <= PRESSED {
            return;
        }
        depth *= (load / found).cbrt().powi(2).clamp(0.5, 2.0);
    }
}

/// The other wheel of a wheelset where it is elastic and pressed, as it is in the state: what is done to one wheel must not move the other, whose
/// load changes by 1 % with each half micrometre.
pub(super) fn held_beside(step: &mut Step, wheel: WheelRef) -> Option<Pressed> {
    step.move_bodies();
    let (other, model) = (wheel.other(), step.model);
    let own = &step.memory.wheels[other.contact];
    if !own.mode.is_elastic() {
        return None;
    }
    let motion = &step.workspace.system.motions[wheel.wheelset.body];
    let pair = other.pair(model, motion);
    let place = points::deepest(model, other.contact, &pair).unwrap_or(*own.start());
    let found = pair.locate_moving(&place, &motion.carrier()).ok()?;
    let depth = found.location.penetration;
    (depth > 0.0).then_some(Pressed { contact: other.contact, depth, gap_rate: found.gap_rate })
}

/// Vertical force of all places of an elastic wheel in a state, N.
fn elastic_load(step: &mut Step, wheel: WheelRef) -> Option<f64> {
    step.move_bodies();
    let WheelRef { contact, wheelset, side } = wheel;
    let Step { model, workspace, y, memory, .. } = step;
    let motion = workspace.system.motions[wheelset.body];
    // Friction says nothing of normal forces.
    let at = WheelAt { model, wheelset, side, contact, motion: &motion, climb: Climb::default(), friction: 0.0, y };
    let memory = &mut memory.wheels[contact];
    memory.forget();
    let reports = model.reports(contact, &mut workspace.contacts, &mut workspace.further_contacts);
    points::elastic_wheel(&at, memory, (&mut workspace.strips[contact], &mut workspace.loaded), &mut Wrench::default(), reports).ok()?;
    Some(carried(wheel, workspace))
}
