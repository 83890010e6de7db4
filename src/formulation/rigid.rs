//! Contacts as constraints: what ACCF and ECCF share once each has found its constraint row.
//!
//! Per contact one row `H q'' = Q_cn` stands in the equations of motion (Eq. 23); its multiplier is minus the normal force N,
//! because n points out of the rail. Patch and friction bound depend on N and creep forces act on the accelerations, so that N
//! is found from `N = -lambda(creep forces(N))` in every evaluation, to 1e-11 relative (`balance`); the last N is only the start.
//!
//! A contact whose N would fall below zero is an event (`on_lift`): it ends the run, or hands the contact to elastic forces
//! (ECF-A) at N = 0 and zero penetration. Such a contact becomes a constraint again where it no longer bounces (`lift`); what penetration
//! is left is removed by projection.
//!
//! Memory per contact: surface parameters, N, mode (0 constraint, 1 elastic), when it tries next to become a constraint (infinity:
//! it is one), how many of the wheel's places have ceased to exist, penetration [m] at which N was found, how far its place is from being
//! left (`lasting`), how often it has tried.

use super::accf::Partition;
use super::balance::{self, Balance, Pressing};
use super::lasting;
use super::loading::{Contact, WheelAt, external_wrench};
use super::points;
use super::{
    ContactFailure, ContactReport, Evaluation, EvaluationError, LEFT_FRICTION, Model, RIGHT_FRICTION, WHEELSET_INPUTS, Wheelset, Workspace,
    contact_index,
};
use crate::contact::search::algebraic::ContactLocation;
use crate::contact::search::point_contact::{PointContact, Residual};
use crate::geometry::Side;
use crate::mbs::body::BodyMotion;
use crate::mbs::kkt::{Coefficients, SingularConstraints};
use crate::mbs::projection::ProjectionError;
use crate::mbs::system::SystemWorkspace;
use nalgebra::Vector3;

/// Numbers per contact in the memory, and their places after the surface parameters.
pub(super) const MEMORY: usize = 11;
pub(super) const NORMAL_FORCE: usize = 4;
pub(super) const MODE: usize = 5;
pub(super) const RETURN: usize = 6;
pub(super) const VANISHED: usize = 7;
pub(super) const APPROACH: usize = 8;
pub(super) const LASTING: usize = 9;
pub(super) const TRIES: usize = 10;

/// Is the contact an elastic one at present?
#[inline]
pub(super) fn is_elastic(memory: &[f64]) -> bool {
    memory[MODE] != 0.0
}

/// A contact's constraint at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConstraintRow {
    pub location: ContactLocation,
    /// H on the wheelset's coordinates.
    pub row: Coefficients,
    /// -Q_cn: second derivative of the gap when no coordinate accelerates, m/s2.
    pub bias: f64,
    /// Rates of u and eta, m/s.
    pub rates: [f64; 2],
}

/// Scratch of the constraint formulations; rows and multipliers are in the system's workspace.
#[derive(Clone, Debug, Default)]
pub struct RigidScratch {
    rows: Vec<Option<ConstraintRow>>,
    balance: Balance,
    /// A state that the constraints have been made to hold in (ACCF).
    pub(super) consistent: Vec<f64>,
    /// Each constrained contact's five constraints there with their second derivatives (ACCF).
    pub(super) points: Vec<Option<(PointContact, Residual)>>,
    /// The partition of each wheelset in the last evaluation (ACCF).
    pub(super) partitions: Vec<Option<Partition>>,
}

impl RigidScratch {
    pub(super) fn new(model: &Model) -> Self {
        let count = model.contacts();
        RigidScratch {
            rows: vec![None; count],
            balance: Balance::new(model),
            consistent: vec![0.0; model.dimension()],
            points: Vec::with_capacity(count),
            partitions: vec![None; model.wheelsets.len()],
        }
    }
}

/// Visits all contacts in the order of their index.
pub(super) fn wheels(model: &Model) -> impl Iterator<Item = (usize, &Wheelset, Side)> {
    let both = |(index, wheelset)| Side::BOTH.map(|side| (contact_index(index, side), wheelset, side));
    model.wheelsets.iter().enumerate().flat_map(both)
}

/// Evaluates the equations of motion with a constraint row per contact; `find` locates a contact that is a constraint.
pub(super) fn derivative(
    model: &Model,
    workspace: &mut Workspace,
    at: Evaluation,
    dy: &mut [f64],
    mut find: impl FnMut(usize, &Wheelset, Side, &BodyMotion, &mut [f64]) -> Result<ConstraintRow, ContactFailure>,
) -> Result<(), EvaluationError> {
    let Evaluation { t, inputs, y, memory } = at;
    model.apply_forces(y, memory, &mut workspace.system);
    let mut rigid = std::mem::take(&mut workspace.rigid);
    let done = (|| {
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            let applied = external_wrench(model, &workspace.system, wheelset.body, &inputs[index * WHEELSET_INPUTS..]);
            workspace.system.wrenches[wheelset.body] += applied;
        }
        model.system.prepare_constraints(t, &mut workspace.system);
        for (contact, wheelset, side) in wheels(model) {
            let motion = workspace.system.motions[wheelset.body];
            let memory = &mut memory[model.contact_memory(contact)];
            let fail = |cause| EvaluationError::new(t, wheelset, side, cause);
            let elastic = is_elastic(memory);
            let wheel = WheelAt {
                model,
                wheelset,
                side,
                contact,
                motion: &motion,
                climb: Vector3::zeros(),
                friction: friction(inputs, contact, side),
                y,
            };
            let reports = model.reports(contact, &mut workspace.contacts, &mut workspace.further_contacts);
            let wrench = &mut workspace.system.wrenches[wheelset.body];
            let constraints = &mut workspace.system.constraints;
            let row = constraints.joint_rows + contact;
            constraints.kkt.set_active(row, !elastic);
            if elastic {
                (constraints.gamma[row], memory[LASTING]) = (0.0, f64::INFINITY);
                points::elastic_wheel(&wheel, memory, wrench, reports).map_err(fail)?;
                workspace.work.search_iterations += workspace.contacts[contact].iterations as u64;
                (rigid.rows[contact], rigid.balance.contacts[contact]) = (None, Pressing::default());
                continue;
            }
            let found = find(contact, wheelset, side, &motion, memory).map_err(fail)?;
            if points::vanished(model, contact, &wheel.pair(), &found.location) {
                return Err(fail(ContactFailure::Dependent));
            }
            let load = Contact { wheel: &wheel, found: &found.location, slot: 0, share: 1.0 };
            load.check_place().map_err(fail)?;
            let (first, further) = reports;
            *first = ContactReport { constrained: true, ..load.report() };
            points::elastic_beside(&wheel, &found.location, memory, wrench, further).map_err(fail)?;
            workspace.work.search_iterations += found.location.iterations as u64;
            constraints.kkt.set_row(row, &found.row, &Coefficients::zeros());
            constraints.gamma[row] = -found.bias;
            memory[LASTING] = lasting::remaining(model, (contact, wheelset, side), &motion, &found.location, found.rates);
            rigid.balance.contacts[contact] = Pressing::start(memory[NORMAL_FORCE], memory[APPROACH]);
            rigid.rows[contact] = Some(found);
        }
        workspace.system.constraints.kkt.factorise().map_err(|error| singular(model, &workspace.system, t, error))?;
        balance::settle(model, workspace, &rigid.rows, &mut rigid.balance, (t, y, inputs))?;
        for ((contact, ..), found) in wheels(model).zip(&rigid.balance.contacts) {
            let memory = &mut memory[model.contact_memory(contact)];
            (memory[NORMAL_FORCE], memory[APPROACH]) = (found.force, found.approach);
        }
        model.system.constrained_result(y, &mut workspace.system, dy);
        model.deflection_rates(workspace, y, dy);
        Ok(())
    })();
    workspace.rigid = rigid;
    done
}

/// The last step of an elastic evaluation: accelerations under the wrenches and the joints.
#[inline]
pub(super) fn finish_elastic(model: &Model, workspace: &mut Workspace, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), EvaluationError> {
    model.deflection_rates(workspace, y, dy);
    let done = model.system.constrained_derivative(t, y, &mut workspace.system, dy);
    done.map_err(|error| singular(model, &workspace.system, t, error))
}

/// The wheel that belongs to a row of the constraints; the first one for rows of joints.
pub(super) fn wheel_of<'a>(model: &'a Model, system: &SystemWorkspace, row: usize) -> (&'a Wheelset, Side) {
    let contact = row.checked_sub(system.constraints.joint_rows);
    contact.and_then(|contact| wheels(model).find(|wheel| wheel.0 == contact)).map_or((&model.wheelsets[0], Side::Left), |w| (w.1, w.2))
}

fn singular(model: &Model, system: &SystemWorkspace, t: f64, error: SingularConstraints) -> EvaluationError {
    let (wheelset, side) = wheel_of(model, system, error.row);
    let y = model.beside(&system.motions[wheelset.body]).0;
    EvaluationError::new(t, wheelset, side, ContactFailure::Singular { row: error.row, y })
}

/// Positions are on a constraint when it is violated by less than this, m.
const CLOSED: f64 = 1e-13;
/// A change of velocity below this [m/s] counts as none.
const AT_REST: f64 = 1e-12;

/// A failure on the way, with the place still to be found.
enum ProjectionFailure {
    System(ProjectionError),
    At(EvaluationError),
}

impl From<ProjectionError> for ProjectionFailure {
    fn from(error: ProjectionError) -> Self {
        ProjectionFailure::System(error)
    }
}

/// Moves coordinates, then velocities onto all constraints; `contacts` fills the contacts' rows. Returns whether anything was
/// moved.
pub(super) fn project(
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    mut contacts: impl FnMut(&mut SystemWorkspace) -> Result<(), EvaluationError>,
) -> Result<bool, EvaluationError> {
    let system = &mut workspace.system;
    let rounding = |wheelset: &Wheelset| model.rounding(&y[model.system.coordinates(wheelset.body)]);
    let closed = model.wheelsets.iter().map(rounding).fold(CLOSED, f64::max);
    let projected = model.system.project(t, y, system, closed, |system| contacts(system).map_err(ProjectionFailure::At));
    let failure = match projected {
        Ok(done) => {
            workspace.work.constraint_iterations += done.iterations as u64;
            return Ok(done.iterations > 0 || done.velocity_change > AT_REST);
        }
        Err(ProjectionFailure::At(error)) => return Err(error),
        Err(ProjectionFailure::System(error)) => error,
    };
    let (gap, row) = system.constraints.largest(&system.constraints.residual);
    let (wheelset, side) = wheel_of(model, system, row);
    let place = model.beside(&system.motions[wheelset.body]).0;
    let cause = match failure {
        ProjectionError::NotConverged { iterations, .. } => ContactFailure::NotClosed { iterations, gap, y: place },
        ProjectionError::Singular { .. } => ContactFailure::Singular { row, y: place },
    };
    Err(EvaluationError::new(t, wheelset, side, cause))
}

pub(super) fn friction(inputs: &[f64], contact: usize, side: Side) -> f64 {
    let inputs = &inputs[contact / 2 * WHEELSET_INPUTS..];
    if side == Side::Left { inputs[LEFT_FRICTION] } else { inputs[RIGHT_FRICTION] }
}

/// The constrained contact with the smallest normal force [N].
pub(super) fn least_pressed(model: &Model, memory: &[f64]) -> Option<(usize, f64)> {
    let pressing = wheels(model).filter_map(|(contact, ..)| {
        let memory = &memory[model.contact_memory(contact)];
        (!is_elastic(memory)).then_some((contact, memory[NORMAL_FORCE]))
    });
    pressing.reduce(|least, other| if other.1 < least.1 { other } else { least })
}
