//! The load of a wheel as its contact passes from a constraint to elastic forces.
//!
//! A constraint holds its wheel at zero penetration, elastic places carry its load only when they are pressed in by 50 to 70 um. A wheel whose
//! place has ended is therefore moved down to where all its places together carry the vertical force that they carried before,
//! so that accelerations pass over the change as if there were none; rates are left as the other constraints want them.

use super::eccf::{self, Pressed};
use super::loading::{WheelAt, pair, warm_start};
use super::points;
use super::rigid::is_elastic;
use super::{ContactReport, Model, Wheelset, Workspace, contact_index};
use crate::geometry::Side;
use crate::mbs::body::Wrench;
use nalgebra::Vector3;

/// A place this steep (vertical part of its normal) or this far away [m] can't take over the load of one that ceases to exist.
const STEEPEST: f64 = 0.8;
const FURTHEST: f64 = 5e-5;
/// Most that it takes over, in static wheel loads: the force of a constraint grows without bound where its place ceases to exist
/// (the place runs ever faster along the curved surfaces), and says nothing of the load there.
const MOST_CARRIED: f64 = 1.25;

/// The places of a wheel that is handed over carry its load to this part of it after this many corrections.
const PRESSED: f64 = 1e-6;
const PRESSINGS: usize = 12;

/// Vertical force on a wheel from its contacts as they were found last, N; of its constraint at most what such a one says something
/// about.
pub(super) fn carried(wheelset: &Wheelset, contact: usize, workspace: &Workspace) -> f64 {
    let most = MOST_CARRIED * wheelset.static_wheel_load;
    let vertical =
        |report: &ContactReport| report.axes.normal.z * report.normal_force.min(if report.constrained { most } else { f64::MAX });
    workspace.reports(contact).map(vertical).sum()
}

/// Penetration of a wheel's deepest place [m] under which that would carry `load` [N, vertical] alone; `None` where it could not: a flange,
/// or nothing near.
pub(super) fn depth_under_load(
    (contact, wheelset, side): (usize, &Wheelset, Side),
    load: f64,
    model: &Model,
    workspace: &mut Workspace,
    y: &[f64],
    memory: &mut [f64],
) -> Option<f64> {
    if !(load > 0.0) {
        return None;
    }
    model.move_bodies(y, memory, &mut workspace.system);
    let pair = pair(model, wheelset, side, &workspace.system.motions[wheelset.body]);
    let place = points::deepest(model, contact, &pair).unwrap_or_else(|| warm_start(&memory[model.contact_memory(contact)]));
    let found = pair.locate(&place).ok()?;
    if found.normal.z < STEEPEST || found.penetration < -FURTHEST {
        return None;
    }
    let shape = found.shape(wheelset.wheel(side), model.track.rail(side));
    model.laws.normal.contact_under(&shape, load / found.normal.z).ok().map(|(depth, _)| depth)
}

/// Moves a wheel that has become elastic to where its places together carry `load` [N, vertical], from the penetration of the deepest one
/// that alone would: another one may be pressed beside it and share its patch. Where
/// the search for the depth ends before (no load there, or [`PRESSINGS`] tries) the wheel starts from the depth tried last, and bounces.
pub(super) fn press(
    (contact, wheelset, side): (usize, &Wheelset, Side),
    (load, depth): (f64, f64),
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) {
    let mut depth = depth;
    let beside = held_beside((contact, wheelset, side), model, workspace, y, memory);
    workspace.rigid.consistent.copy_from_slice(y);
    for _ in 0..PRESSINGS {
        y.copy_from_slice(&workspace.rigid.consistent);
        let pressed = [Some(Pressed { contact, depth, gap_rate: 0.0 }), beside];
        if eccf::project_pressed(model, workspace, t, y, memory, pressed).is_err() {
            y.copy_from_slice(&workspace.rigid.consistent);
            return;
        }
        let Some(found) = elastic_load((contact, wheelset, side), model, workspace, y, memory).filter(|found| *found > 0.0) else { return };
        if (found / load - 1.0).abs() <= PRESSED {
            return;
        }
        depth *= (load / found).cbrt().powi(2).clamp(0.5, 2.0);
    }
}

/// The other wheel of a wheelset where it is elastic and pressed, as it is in `y`: what is done to one wheel must not move the other, whose load
/// changes by 1 % with each half micrometre.
pub(super) fn held_beside(
    (contact, wheelset, side): (usize, &Wheelset, Side),
    model: &Model,
    workspace: &mut Workspace,
    y: &[f64],
    memory: &mut [f64],
) -> Option<Pressed> {
    let side = side.other();
    let other = contact_index(contact / 2, side);
    model.move_bodies(y, memory, &mut workspace.system);
    let own = &memory[model.contact_memory(other)];
    if !is_elastic(own) {
        return None;
    }
    let motion = &workspace.system.motions[wheelset.body];
    let pair = pair(model, wheelset, side, motion);
    let place = points::deepest(model, other, &pair).unwrap_or_else(|| warm_start(own));
    let found = pair.locate_moving(&place, &motion.carrier()).ok()?;
    let depth = found.location.penetration;
    (depth > 0.0).then_some(Pressed { contact: other, depth, gap_rate: found.gap_rate })
}

/// Vertical force of all places of an elastic wheel in a state, N.
fn elastic_load(
    (contact, wheelset, side): (usize, &Wheelset, Side),
    model: &Model,
    workspace: &mut Workspace,
    y: &[f64],
    memory: &mut [f64],
) -> Option<f64> {
    model.move_bodies(y, memory, &mut workspace.system);
    let motion = workspace.system.motions[wheelset.body];
    // Friction says nothing of normal forces.
    let wheel = WheelAt { model, wheelset, side, contact, motion: &motion, climb: Vector3::zeros(), friction: 0.0, y };
    let memory = &mut memory[model.contact_memory(contact)];
    points::forget(model, contact, memory);
    let reports = model.reports(contact, &mut workspace.contacts, &mut workspace.further_contacts);
    points::elastic_wheel(&wheel, memory, &mut Wrench::default(), reports).ok()?;
    Some(carried(wheelset, contact, workspace))
}
