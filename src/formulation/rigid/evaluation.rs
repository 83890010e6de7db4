//! The equations of motion with a constraint row per contact.
//!
//! Per contact one row `H q'' = Q_cn` stands in the equations of motion (Eq. 23); its multiplier is minus the normal force N,
//! because n points out of the rail. Patch and friction bound depend on N and creep forces act on the accelerations, so that N
//! is found from `N = -lambda(creep forces(N))` in every evaluation, to 1e-11 relative (`balance`); the last N is only the start.

use super::balance;
use super::lasting;
use crate::formulation::elastic::points;
use crate::formulation::loading::{Contact, WheelAt, external_wrench, friction};
use crate::formulation::memory::{Mode, WheelMemory};
use crate::formulation::rail_motion::Climb;
use crate::formulation::rigid_scratch::{ConstraintRow, Pressing};
use crate::formulation::step::WheelRef;
use crate::formulation::{ContactFailure, ContactReport, Evaluation, EvaluationError, Model, WHEELSET_INPUTS, Workspace};
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::kkt::Coefficients;

/// Evaluates the equations of motion; `find` locates a contact that is a constraint.
pub(super) fn derivative(
    model: &Model,
    workspace: &mut Workspace,
    at: Evaluation,
    dy: &mut [f64],
    mut find: impl FnMut(WheelRef, &BodyMotion, &mut WheelMemory) -> Result<ConstraintRow, ContactFailure>,
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
        for wheel in model.wheels() {
            let WheelRef { contact, wheelset, side } = wheel;
            let turning = wheelset.turning[side.index()];
            let motion = workspace.system.motions[turning];
            let memory = &mut memory.wheels[contact];
            let fail = |cause| wheel.error(t, cause);
            let wheel_at = WheelAt {
                model,
                wheelset,
                side,
                contact,
                motion: &motion,
                climb: Climb::default(),
                friction: friction(inputs, contact, side),
                y,
            };
            let reports = model.reports(contact, &mut workspace.contacts, &mut workspace.further_contacts);
            let wrench = &mut workspace.system.wrenches[turning];
            let constraints = &mut workspace.system.constraints;
            let row = constraints.joint_rows + contact;
            let Mode::Rigid { normal_force, approach, .. } = memory.mode else {
                constraints.kkt.set_active(row, false);
                constraints.gamma[row] = 0.0;
                points::elastic_wheel(&wheel_at, memory, (&mut workspace.strips[contact], &mut workspace.loaded), wrench, reports)
                    .map_err(fail)?;
                workspace.work.search_iterations += workspace.contacts[contact].iterations as u64;
                (rigid.rows[contact], rigid.balance.contacts[contact]) = (None, Pressing::default());
                continue;
            };
            constraints.kkt.set_active(row, true);
            let found = find(wheel, &motion, memory).map_err(fail)?;
            if points::vanished(model, contact, &wheel_at.pair(), &found.location) {
                return Err(fail(ContactFailure::Dependent));
            }
            let load = Contact { wheel: &wheel_at, found: &found.location, slot: 0, share: 1.0 };
            load.check_place().map_err(fail)?;
            let (first, further) = reports;
            *first = ContactReport { constrained: true, ..load.report() };
            points::elastic_beside(&wheel_at, &found.location, memory, wrench, further).map_err(fail)?;
            workspace.work.search_iterations += found.location.iterations as u64;
            constraints.kkt.set_row(row, &found.row, &Coefficients::zeros());
            constraints.gamma[row] = -found.bias;
            let lasting = lasting::remaining(model, wheel, &motion, &found.location, found.rates);
            memory.mode = Mode::Rigid { normal_force, approach, lasting };
            rigid.balance.contacts[contact] = Pressing::start(normal_force, approach);
            rigid.rows[contact] = Some(found);
        }
        let factorised = workspace.system.constraints.kkt.factorise();
        factorised.map_err(|error| model.singular_row(&workspace.system, t, error.row))?;
        model.system.fold_wheels(&mut workspace.system);
        balance::settle(model, workspace, &rigid.rows, &mut rigid.balance, (t, y, inputs))?;
        for (wheel, found) in memory.wheels.iter_mut().zip(&rigid.balance.contacts) {
            if let Mode::Rigid { normal_force, approach, .. } = &mut wheel.mode {
                (*normal_force, *approach) = (found.force, found.approach);
            }
        }
        twist_under_creep(model, workspace);
        model.system.constrained_result(y, &mut workspace.system, dy);
        model.deflection_rates(workspace, y, dy);
        Ok(())
    })();
    workspace.rigid = rigid;
    done
}

/// Hands the moments of contacts that are constraints to the twists of their axles; those of elastic ones are there.
fn twist_under_creep(model: &Model, workspace: &mut Workspace) {
    if workspace.system.twists.is_empty() {
        return;
    }
    for WheelRef { contact, wheelset, side } in model.wheels() {
        let (report, mut wrench) = (&workspace.contacts[contact], Wrench::default());
        if report.constrained {
            report.add_to(&mut wrench, report.force, &workspace.system.motions[wheelset.body].position);
            model.system.twist_by(wheelset.turning[side.index()], &wrench.moment, &mut workspace.system);
        }
    }
}
