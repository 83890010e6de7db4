//! Lift-off and landing of contacts that are constraints (`contact.on_lift`).

use super::eccf;
use super::events::{ContactChange, ContactEvent};
use super::handover::{carried, depth_under_load, held_beside, press};
use super::lasting;
use super::loading::{keep, pair};
use super::points;
use super::rigid::{APPROACH, LASTING, MODE, NORMAL_FORCE, RETURN, TRIES, VANISHED, is_elastic, least_pressed, wheels};
use super::{ContactFailure, ContactReport, EvaluationError, Model, Wheelset, Workspace};
use crate::geometry::Side;
use crate::mbs::kkt::Coefficients;
use crate::settings::{Section, SettingsError};

/// What to do where the constraint would begin to pull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnLift {
    /// End the run with an error that says so.
    Stop,
    /// Hand the contact to elastic forces until it has settled again.
    Elastic,
}

impl OnLift {
    pub fn describe(self) -> &'static str {
        match self {
            OnLift::Stop => "a wheel that lifts ends the run",
            OnLift::Elastic => "a wheel that lifts is elastic until it has settled",
        }
    }
}

/// Reads `contact.on_lift`.
pub(super) fn parse(section: &Section) -> Result<OnLift, SettingsError> {
    Ok(match section.word_or("on_lift", &["stop", "elastic"], "stop")? {
        "elastic" => OnLift::Elastic,
        _ => OnLift::Stop,
    })
}

/// A wheel that bounces by less than this part of its penetration becomes a constraint again, if one place carries the wheel alone and all
/// others are further from their rail than it is pressed in: a rigid contact knows nothing of a load that moves from place to place.
const SETTLED: f64 = 0.05;
/// It tries to so long after it has become elastic, s. It tries at times that are fixed beforehand because the instant at which a decaying
/// vibration passes a bound is ill conditioned: errors of 1 % move it by milliseconds, and all that follows with it.
const FIRST_TRY: f64 = 5e-3;
/// Each try that fails doubles the time to the next one, so often at most: a wheel whose places share its load for long is left alone.
const DOUBLINGS: i32 = 6;
/// By this factor the time grows with each place of the wheel that has ceased to exist after the first, so that a wheel on nearly
/// conformal profiles does not become a constraint again and again.
const PATIENCE: f64 = 8.0;

/// The next try of a contact that is elastic at time `t`.
fn next_try(memory: &[f64], t: f64) -> f64 {
    let patience = PATIENCE.powi((memory[VANISHED] as i32 - 1).clamp(0, 6));
    t + FIRST_TRY * patience * 2f64.powi((memory[TRIES] as i32).min(DOUBLINGS))
}

/// All contacts begin as constraints that carry the static load, each at its wheel's deepest place.
pub(super) fn start(model: &Model, workspace: &mut Workspace, y: &[f64], memory: &mut [f64]) {
    model.move_bodies(y, memory, &mut workspace.system);
    for (contact, wheelset, side) in wheels(model) {
        let memory = &mut memory[model.contact_memory(contact)];
        let pair = pair(model, wheelset, side, &workspace.system.motions[wheelset.body]);
        if let Some(place) = points::deepest(model, contact, &pair) {
            keep(&place, memory);
        }
        (memory[NORMAL_FORCE], memory[APPROACH]) = (wheelset.static_wheel_load, 0.0);
        (memory[MODE], memory[RETURN], memory[TRIES], memory[LASTING]) = (0.0, f64::INFINITY, 0.0, f64::INFINITY);
    }
}

/// All contacts begin as elastic ones, each at its wheel's deepest place.
pub(super) fn start_elastic(model: &Model, workspace: &mut Workspace, t: f64, y: &[f64], memory: &mut [f64]) {
    start(model, workspace, y, memory);
    for (contact, ..) in wheels(model) {
        let memory = &mut memory[model.contact_memory(contact)];
        (memory[MODE], memory[RETURN]) = (1.0, next_try(memory, t));
    }
}

/// Has an elastic wheel settled, in the state that was evaluated last?
///
/// Where a wheel follows its rail its penetration changes as slowly as the load on it. What a rigid contact knows nothing of is the wheel's
/// bouncing on its contact, with the frequency `omega = sqrt(1.5 N / (m delta))` (the contact's stiffness is 1.5 N / delta, m half
/// the wheelset). Its amplitude in parts of delta is that of the rate and the acceleration of the penetration,
///
/// ```text
/// a = hypot(delta' / (omega delta), delta'' / (omega^2 delta)),
/// ```
///
/// which falls steadily where either alone passes zero again and again, whatever the load itself is: in a curve a wheel settles beside its static
/// load. A load that changes with the frequency f counts as (f / omega) of its change: 10 Hz as a twentieth.
fn settled(model: &Model, workspace: &Workspace, (contact, wheelset, side): (usize, &Wheelset, Side)) -> bool {
    let report = most_pressed(workspace, contact);
    if !(report.stiffness > 0.0) {
        return false;
    }
    let motion = &workspace.system.motions[wheelset.body];
    let Ok(found) = pair(model, wheelset, side, motion).locate_moving(&report.parameters, &motion.carrier()) else {
        return false;
    };
    let accelerations = &workspace.system.constraints.accelerations[model.system.coordinates(wheelset.body)];
    let acceleration = found.gap_bias + eccf::row(motion, &found).dot(&Coefficients::from_column_slice(accelerations));
    // N = K delta^1.5 with the vertical part of N equal to the static load.
    let load = wheelset.static_wheel_load / report.axes.normal.z;
    let penetration = (load / report.stiffness).cbrt().powi(2);
    let mass = 0.5 * model.system.bodies[wheelset.body].mass;
    let frequency = (1.5 * load / (mass * penetration)).sqrt();
    let amplitude = (found.gap_rate / (frequency * penetration)).hypot(acceleration / (frequency * frequency * penetration));
    amplitude <= SETTLED && clearance(workspace, contact, report) >= penetration
}

/// Distance of the nearest place of a wheel beside `most` from the rail, m; negative where it is pressed.
fn clearance(workspace: &Workspace, contact: usize, most: &ContactReport) -> f64 {
    // A report without iterations belongs to no place.
    let others = workspace.reports(contact).filter(|report| report.iterations > 0 && !std::ptr::eq(*report, most));
    others.map(|report| -report.penetration).fold(f64::INFINITY, f64::min)
}

fn most_pressed(workspace: &Workspace, contact: usize) -> &ContactReport {
    let first = &workspace.contacts[contact];
    workspace.reports(contact).fold(first, |most, other| if other.normal_force > most.normal_force { other } else { most })
}

/// When the next elastic contact tries to become a constraint again, s.
pub(super) fn next_return(model: &Model, memory: &[f64]) -> f64 {
    wheels(model).map(|(contact, ..)| memory[model.contact_memory(contact)][RETURN]).fold(f64::INFINITY, f64::min)
}

/// Height and roll of a wheelset weigh no more than other coordinates while both wheels are constraints: no penetration
/// depends on them.
pub(super) fn error_weight(model: &Model, workspace: &Workspace, i: usize, plain: f64) -> f64 {
    if plain <= 1.0 {
        return plain;
    }
    let body = i / crate::mbs::body::COORDINATES;
    let rests = wheels(model).filter(|(_, wheelset, _)| wheelset.body == body).all(|(contact, ..)| workspace.contacts[contact].constrained);
    if rests { 1.0 } else { plain }
}

/// Changes the mode of the contacts that have settled, or else of those that would be pulled on; returns whether one changed.
pub(super) fn switch(
    on_lift: OnLift,
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) -> Result<bool, EvaluationError> {
    for wheel @ (contact, wheelset, side) in wheels(model) {
        let range = model.contact_memory(contact);
        if t < memory[range.start + RETURN] {
            continue;
        }
        let change = if settled(model, workspace, wheel) { land(wheel, model, workspace, t, y, memory)? } else { None };
        if let Some(change) = change {
            workspace.events.push(ContactEvent { time: t, wheelset: wheelset.name.clone(), side, change });
            // Landing moves the state: another wheel tries in what is found there.
            return Ok(true);
        }
        let memory = &mut memory[range];
        memory[TRIES] += 1.0;
        memory[RETURN] = next_try(memory, t);
    }
    let ending = lasting::least_lasting(model, memory).filter(|(_, margin)| on_lift == OnLift::Elastic && *margin < 0.0);
    if let Some(wheel) = ending.and_then(|(contact, _)| wheels(model).find(|wheel| wheel.0 == contact)) {
        return free(wheel, ContactChange::Vanished, model, workspace, t, y, memory).map(|()| true);
    }
    // The least pressed contact alone: once it is free the others may press again.
    let Some((contact, normal_force)) = least_pressed(model, memory).filter(|(_, force)| *force < 0.0) else { return Ok(false) };
    let Some((_, wheelset, side)) = wheels(model).find(|wheel| wheel.0 == contact) else { return Ok(false) };
    if on_lift == OnLift::Stop {
        return Err(EvaluationError::new(t, wheelset, side, ContactFailure::Tensile { normal_force }));
    }
    free((contact, wheelset, side), ContactChange::Lifted, model, workspace, t, y, memory).map(|()| true)
}

/// Frees the wheel whose contact was not found.
pub(super) fn release(
    failure: &EvaluationError,
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) -> Result<bool, EvaluationError> {
    let lost = wheels(model).find(|(_, wheelset, side)| wheelset.name == failure.wheelset && *side == failure.side);
    let Some(lost) = lost else { return Ok(false) };
    // Positions of a wheelset are closed together: the wheel whose place ends first is the one that they can't be closed with.
    let ending = lasting::least_lasting(model, memory).filter(|_| matches!(failure.cause, ContactFailure::NotClosed { .. }));
    let ending = ending.and_then(|(contact, _)| wheels(model).find(|wheel| wheel.0 == contact));
    let (contact, wheelset, side) = ending.filter(|wheel| wheel.1.name == failure.wheelset).unwrap_or(lost);
    let own = &memory[model.contact_memory(contact)];
    let searched = model.searches[contact].is_some();
    let lost = matches!(failure.cause, ContactFailure::NotFound { .. } | ContactFailure::NotClosed { .. } | ContactFailure::Dependent);
    // Where no normal force is in balance rigid bodies have no motion; elastic ones have.
    let undecided = matches!(failure.cause, ContactFailure::NotSettled { .. });
    if !(searched && lost || undecided) || is_elastic(own) {
        return Ok(false);
    }
    let change = if undecided { ContactChange::Undecided } else { ContactChange::Vanished };
    free((contact, wheelset, side), change, model, workspace, t, y, memory)?;
    Ok(true)
}

/// Makes a constraint an elastic contact and moves the state onto the constraints that are left. A wheel that loses its place under
/// load is moved to where its elastic places carry that load, as landing moves it out of there: else it would fall by its static
/// penetration, and bounce.
fn free(
    (contact, wheelset, side): (usize, &Wheelset, Side),
    change: ContactChange,
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) -> Result<(), EvaluationError> {
    let wheel = (contact, wheelset, side);
    let lost = matches!(change, ContactChange::Vanished | ContactChange::Undecided);
    let load = carried(wheelset, contact, workspace);
    let depth = if lost { depth_under_load(wheel, load, model, workspace, y, memory) } else { None };
    let own = &mut memory[model.contact_memory(contact)];
    (own[MODE], own[NORMAL_FORCE], own[LASTING]) = (1.0, 0.0, f64::INFINITY);
    if lost {
        own[VANISHED] += 1.0;
    }
    (own[TRIES], own[RETURN]) = (0.0, next_try(own, t));
    points::forget(model, contact, own);
    workspace.events.push(ContactEvent { time: t, wheelset: wheelset.name.clone(), side, change });
    if let Some(depth) = depth {
        press(wheel, (load, depth), model, workspace, t, y, memory);
        points::forget(model, contact, &mut memory[model.contact_memory(contact)]);
    }
    model.formulation.resettle(model, workspace, t, y, memory)
}

/// Makes an elastic contact a constraint again: positions, then velocities are projected. `None` where its place would not last: it
/// stays elastic.
fn land(
    (contact, wheelset, side): (usize, &Wheelset, Side),
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) -> Result<Option<ContactChange>, EvaluationError> {
    model.move_bodies(y, memory, &mut workspace.system);
    let motion = workspace.system.motions[wheelset.body];
    let range = model.contact_memory(contact);
    points::promote(model, workspace, contact, y, &mut memory[range.clone()]);
    let found = eccf::locate(model, (contact, wheelset, side), &motion, &mut memory[range.clone()])
        .map_err(|cause| EvaluationError::new(t, wheelset, side, cause))?;
    let rates = [found.parameter_rates[0], found.parameter_rates[3]];
    if !lasting::bears(model, (contact, wheelset, side), &motion, &found.location, rates) {
        return Ok(None);
    }
    let mechanical = |workspace: &Workspace, y: &[f64]| model.system.mechanical_energy(y, &workspace.system);
    let penetration = found.location.penetration;
    // K delta^1.5 integrated; a curvature taken over the patch changes K a little on the way, which is left out.
    let shape = found.location.shape(wheelset.wheel(side), model.track.rail(side));
    let law = model.laws.normal.contact(&shape, penetration.max(0.0));
    let stiffness = law.map_err(|cause| EvaluationError::new(t, wheelset, side, cause.into()))?.stiffness;
    let elastic = 0.4 * stiffness * penetration.max(0.0).powf(2.5);
    let before = mechanical(workspace, y) + elastic;
    let beside = held_beside((contact, wheelset, side), model, workspace, y, memory);
    let memory_of = &mut memory[range];
    (memory_of[MODE], memory_of[RETURN], memory_of[TRIES]) = (0.0, f64::INFINITY, 0.0);
    (memory_of[NORMAL_FORCE], memory_of[APPROACH]) = (wheelset.static_wheel_load, penetration.max(0.0));
    points::forget(model, contact, memory_of);
    if beside.is_some() {
        eccf::project_pressed(model, workspace, t, y, memory, [beside, None])?;
    }
    model.formulation.resettle(model, workspace, t, y, memory)?;
    model.move_bodies(y, memory, &mut workspace.system);
    Ok(Some(ContactChange::Landed { penetration, rate: -found.gap_rate, energy: mechanical(workspace, y) - before }))
}
