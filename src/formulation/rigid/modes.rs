//! Lift-off and landing of contacts that are constraints (`contact.on_lift`).

use super::lasting;
use super::load_transfer::{carried, depth_under_load, held_beside, press};
use super::projection::project_pressed;
use super::row::{coefficients, locate, rates};
use crate::formulation::elastic::points;
use crate::formulation::events::ContactChange;
use crate::formulation::memory::{Mode, ModelMemory, WheelMemory};
use crate::formulation::step::{Step, WheelRef};
use crate::formulation::{ContactFailure, ContactReport, EvaluationError, Model, OnLift, Workspace};
use crate::mbs::body::COORDINATES;
use crate::mbs::kkt::Coefficients;
use crate::settings::{Section, SettingsError};

/// Reads `contact.on_lift`.
pub(in crate::formulation) fn parse(section: &Section) -> Result<OnLift, SettingsError> {
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

/// An elastic contact that has tried so often.
fn elastic(vanished: u32, tries: u32, t: f64) -> Mode {
    let patience = PATIENCE.powi(i32::try_from(vanished).unwrap_or(i32::MAX).saturating_sub(1).clamp(0, 6));
    let doublings = i32::try_from(tries).unwrap_or(i32::MAX).min(DOUBLINGS);
    Mode::Elastic { next_try: t + FIRST_TRY * patience * 2f64.powi(doublings), tries }
}

/// All contacts begin as constraints that carry the static load, each at its wheel's deepest place.
pub(super) fn start(step: &mut Step) {
    step.move_bodies();
    for wheel in step.model.wheels() {
        let memory = &mut step.memory.wheels[wheel.contact];
        let pair = wheel.pair(step.model, &step.workspace.system.motions[wheel.wheelset.body]);
        if let Some(place) = points::deepest(step.model, wheel.contact, &pair) {
            memory.set_start(place);
        }
        memory.mode = Mode::rigid(wheel.wheelset.static_wheel_load, 0.0);
    }
}

/// All contacts begin as elastic ones, each at its wheel's deepest place.
pub(in crate::formulation) fn start_elastic(step: &mut Step) {
    start(step);
    for memory in &mut step.memory.wheels {
        memory.mode = elastic(memory.vanished, 0, step.t);
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
fn settled(model: &Model, workspace: &Workspace, wheel: WheelRef) -> bool {
    let WheelRef { contact, wheelset, .. } = wheel;
    let report = most_pressed(workspace, contact);
    if !(report.stiffness > 0.0) {
        return false;
    }
    let motion = &workspace.system.motions[wheelset.body];
    let Ok(found) = wheel.pair(model, motion).locate_moving(&report.parameters, &motion.carrier()) else {
        return false;
    };
    let accelerations = &workspace.system.constraints.accelerations[model.system.coordinates(wheelset.body)];
    let acceleration = found.gap_bias + coefficients(motion, &found).dot(&Coefficients::from_column_slice(accelerations));
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

/// Height and roll of a wheelset weigh no more than other coordinates while both wheels are constraints: no penetration
/// depends on them.
pub(super) fn error_weight(model: &Model, workspace: &Workspace, i: usize, plain: f64) -> f64 {
    if plain <= 1.0 {
        return plain;
    }
    let body = i / COORDINATES;
    let own = model.wheels().filter(|wheel| wheel.wheelset.body == body);
    if own.into_iter().all(|wheel| workspace.contacts[wheel.contact].constrained) { 1.0 } else { plain }
}

/// Why a constraint becomes elastic or a run ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::formulation) enum Leaving {
    /// Its normal force is zero.
    Lifts,
    /// Its place ceases.
    Vanishes,
}

/// How far a constraint is from that, N or 1/m; infinity for an elastic contact.
#[inline]
pub(in crate::formulation) fn event_value(on_lift: OnLift, memory: &WheelMemory, leaving: Leaving) -> f64 {
    match (memory.mode, leaving) {
        (Mode::Rigid { normal_force, .. }, Leaving::Lifts) => normal_force,
        (Mode::Rigid { lasting, .. }, Leaving::Vanishes) if on_lift == OnLift::Elastic => lasting,
        _ => f64::INFINITY,
    }
}

/// The constraint that is furthest beyond an event value of zero: it alone is freed, because the others may press again then.
pub(in crate::formulation) fn first_leaving(on_lift: OnLift, wheels: &[WheelMemory], leaving: Leaving) -> Option<usize> {
    let values = wheels.iter().map(|memory| event_value(on_lift, memory, leaving)).enumerate();
    let least = values.reduce(|least, other| if other.1 < least.1 { other } else { least })?;
    (least.1 < 0.0).then_some(least.0)
}

/// A constraint leaves its rail: it becomes elastic, or the run ends.
pub(in crate::formulation) fn leave(step: &mut Step, wheel: WheelRef, leaving: Leaving) -> Result<(), EvaluationError> {
    let change = match (leaving, step.memory.wheels[wheel.contact].mode) {
        (Leaving::Lifts, Mode::Rigid { normal_force, .. }) if step.model.formulation.on_lift() == Some(OnLift::Stop) => {
            return Err(wheel.error(step.t, ContactFailure::Tensile { normal_force }));
        }
        (Leaving::Lifts, _) => ContactChange::Lifted,
        (Leaving::Vanishes, _) => ContactChange::Vanished,
    };
    free(step, wheel, change)
}

/// An elastic contact tries to become a constraint again; returns whether it has.
pub(in crate::formulation) fn try_to_land(step: &mut Step, wheel: WheelRef) -> Result<bool, EvaluationError> {
    let change = if settled(step.model, step.workspace, wheel) { land(step, wheel)? } else { None };
    if let Some(change) = change {
        step.note(wheel, change);
        return Ok(true);
    }
    wait(&mut step.memory.wheels[wheel.contact], step.t);
    Ok(false)
}

/// An elastic contact that could not become a constraint tries again later.
fn wait(memory: &mut WheelMemory, t: f64) {
    if let Mode::Elastic { tries, .. } = memory.mode {
        memory.mode = elastic(memory.vanished, tries.saturating_add(1), t);
    }
}

impl ModelMemory {
    /// The landings that are due at `t` [s] lead to where there is no solution: they are tried again later. Returns whether there was one.
    pub fn refuse_landings(&mut self, t: f64) -> bool {
        let due = |memory: &&mut WheelMemory| matches!(memory.mode, Mode::Elastic { next_try, .. } if !(t < next_try));
        self.wheels.iter_mut().filter(due).map(|memory| wait(memory, t)).count() > 0
    }
}

/// Frees the wheel whose contact was not found; returns whether there is one.
pub(in crate::formulation) fn release(step: &mut Step, failure: &EvaluationError) -> Result<bool, EvaluationError> {
    let model = step.model;
    let lost = model.wheels().find(|wheel| wheel.wheelset.name == failure.wheelset && wheel.side == failure.side);
    let Some(lost) = lost else { return Ok(false) };
    // Positions of a wheelset are closed together: the wheel whose place ends first is the one that they can't be closed with.
    let lasting = |contact: usize| match step.memory.wheels[contact].mode {
        Mode::Rigid { lasting, .. } => lasting,
        Mode::Elastic { .. } => f64::INFINITY,
    };
    let mut rigid = model.wheels().filter(|wheel| !step.memory.wheels[wheel.contact].mode.is_elastic());
    let first = rigid
        .next()
        .map(|first| rigid.fold(first, |least, other| if lasting(other.contact) < lasting(least.contact) { other } else { least }));
    let ending = first.filter(|wheel| matches!(failure.cause, ContactFailure::NotClosed { .. }) && wheel.wheelset.name == failure.wheelset);
    let wheel = ending.unwrap_or(lost);
    let searched = points::searched(model, wheel.contact);
    let lost = matches!(failure.cause, ContactFailure::NotFound { .. } | ContactFailure::NotClosed { .. } | ContactFailure::Dependent);
    // Where no normal force is in balance rigid bodies have no motion; elastic ones have.
    let undecided = matches!(failure.cause, ContactFailure::NotSettled { .. });
    if !(searched && lost || undecided) || step.memory.wheels[wheel.contact].mode.is_elastic() {
        return Ok(false);
    }
    free(step, wheel, if undecided { ContactChange::Undecided } else { ContactChange::Vanished })?;
    Ok(true)
}

/// Makes a constraint an elastic contact and moves the state onto the constraints that are left. A wheel that loses its place under
/// load is moved to where its elastic places carry that load, as landing moves it out of there: else it would fall by its static
/// penetration, and bounce.
fn free(step: &mut Step, wheel: WheelRef, change: ContactChange) -> Result<(), EvaluationError> {
    let lost = matches!(change, ContactChange::Vanished | ContactChange::Undecided);
    let load = carried(wheel, step.workspace);
    let depth = if lost { depth_under_load(step, wheel, load) } else { None };
    let memory = &mut step.memory.wheels[wheel.contact];
    memory.vanished += u32::from(lost);
    memory.mode = elastic(memory.vanished, 0, step.t);
    memory.forget();
    step.note(wheel, change);
    if let Some(depth) = depth {
        press(step, wheel, load, depth);
        step.memory.wheels[wheel.contact].forget();
    }
    step.model.formulation.resettle(step)
}

/// Makes an elastic contact a constraint again: positions, then velocities are projected. `None` where its place would not last: it
/// stays elastic.
fn land(step: &mut Step, wheel: WheelRef) -> Result<Option<ContactChange>, EvaluationError> {
    step.move_bodies();
    let (model, t, contact) = (step.model, step.t, wheel.contact);
    let motion = step.workspace.system.motions[wheel.wheelset.body];
    points::promote(model, step.workspace, contact, step.y, &mut step.memory.wheels[contact]);
    let found = locate(model, wheel, &motion, &mut step.memory.wheels[contact]).map_err(|cause| wheel.error(t, cause))?;
    if !lasting::bears(model, wheel, &motion, &found.location, rates(&found)) {
        return Ok(None);
    }
    let mechanical = |step: &Step| model.system.mechanical_energy(step.y, &step.workspace.system);
    let penetration = found.location.penetration;
    // K delta^1.5 integrated; a curvature taken over the patch changes K a little on the way, which is left out.
    let shape = found.location.shape(wheel.wheelset.wheel(wheel.side), model.track.rail(wheel.side));
    let law = model.laws.normal.contact(&shape, penetration.max(0.0));
    let stiffness = law.map_err(|cause| wheel.error(t, cause.into()))?.stiffness;
    let elastic = 0.4 * stiffness * penetration.max(0.0).powf(2.5);
    let before = mechanical(step) + elastic;
    let beside = held_beside(step, wheel);
    let memory = &mut step.memory.wheels[contact];
    memory.mode = Mode::rigid(wheel.wheelset.static_wheel_load, penetration.max(0.0));
    memory.forget();
    if beside.is_some() {
        project_pressed(step, [beside, None])?;
    }
    model.formulation.resettle(step)?;
    step.move_bodies();
    Ok(Some(ContactChange::Landed { penetration, rate: -found.gap_rate, energy: mechanical(step) - before }))
}
