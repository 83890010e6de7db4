//! ECCF: contact as an embedded constraint (Eqs. 15-23 of the paper).
//!
//! The wheel has five degrees of freedom relative to the rail. Four of the five constraints (Eq. 16) give the surface
//! parameters, which are eliminated; the fifth, `n . r = 0` (Eq. 17), stands in the equations of motion with one multiplier per
//! contact (Eq. 23), which is minus the normal force. Rows and Q_cn are derived in `contact::search::kinematics`.
//!
//! Position level (two coupled Newton iterations, section 3.3): for given coordinates Eq. 16 is solved for the surface parameters;
//! with these the coordinates are corrected by `-M^-1 H^T (H M^-1 H^T)^-1 g`, the smallest change weighted with the masses; and
//! again, until all gaps vanish. Velocities are then corrected likewise. Both follow each accepted step.

use super::lift::{self, OnLift};
use super::loading::{keep, not_found, pair, warm_start};
use super::rigid::{self, ConstraintRow, RigidScratch, is_elastic, wheels};
use super::{Build, ContactFailure, Evaluation, EvaluationError, Formulation, Model, Parts, Wheelset, Workspace};
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::kinematics::MovingContact;
use crate::geometry::Side;
use crate::mbs::body::BodyMotion;
use crate::mbs::kkt::Coefficients;
use crate::settings::{Entry, Section, SettingsError};
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "ECCF",
    summary: "contact as a constraint, surface parameters eliminated, one multiplier per contact",
    reference: "paper, section 3.3, Eqs. 15-23",
    parse,
};

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let on_lift = lift::parse(section)?;
    Ok(Arc::new(move |_: &Parts| Ok(Box::new(Eccf { on_lift }))))
}

#[derive(Debug)]
struct Eccf {
    on_lift: OnLift,
}

impl Formulation for Eccf {
    fn describe(&self) -> String {
        format!("constraint, one multiplier per wheel; {} (contact.on_lift)", self.on_lift.describe())
    }

    fn memory_per_contact(&self) -> usize {
        rigid::MEMORY
    }

    fn constrains(&self) -> bool {
        true
    }

    fn rigid_scratch(&self, bodies: usize, wheelsets: &[Wheelset]) -> Option<RigidScratch> {
        Some(RigidScratch::new(bodies, wheelsets, 0))
    }

    fn start(&self, model: &Model, _: &mut Workspace, _: f64, _: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        lift::start(model, memory);
        Ok(())
    }

    #[inline]
    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        rigid::derivative(model, workspace, at, dy, |_, wheelset, side, motion, memory| {
            let found = locate(model, wheelset, side, motion, memory)?;
            let normal = found.location.normal;
            let row = motion.coefficients(&normal, &found.arm.cross(&normal));
            Ok(ConstraintRow { location: found.location, row, bias: found.gap_bias })
        })
    }

    fn project(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        t: f64,
        y: &mut [f64],
        memory: &mut [f64],
    ) -> Result<bool, EvaluationError> {
        let Some(mut scratch) = workspace.rigid.take() else { return Ok(false) };
        let changed = project(model, workspace, &mut scratch, t, y, memory);
        workspace.rigid = Some(scratch);
        lift::watch(model, workspace, t, memory);
        changed
    }

    fn error_weight(&self, model: &Model, workspace: &Workspace, i: usize, plain: f64) -> f64 {
        lift::error_weight(model, workspace, i, plain)
    }

    fn margin(&self, model: &Model, memory: &[f64]) -> Option<f64> {
        rigid::smallest_normal_force(model, memory)
    }

    fn next_event(&self, model: &Model, memory: &[f64]) -> f64 {
        lift::next_return(model, memory)
    }

    fn switch(&self, model: &Model, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        lift::switch(self.on_lift, self, model, workspace, t, y, memory)
    }
}

/// The contact with the motion of its gap; `memory` holds the warm start.
#[inline]
pub(super) fn locate(
    model: &Model,
    wheelset: &Wheelset,
    side: Side,
    motion: &BodyMotion,
    memory: &mut [f64],
) -> Result<MovingContact, ContactFailure> {
    let pair = pair(model, wheelset, side, motion);
    let carrier = motion.carrier();
    let start = warm_start(memory);
    let found = pair.locate_moving(&start, &carrier).or_else(|_| pair.locate_moving(&SurfaceParameters::default(), &carrier));
    let found = found.map_err(|failure| not_found(motion, failure))?;
    keep(&found.location.parameters, memory);
    Ok(found)
}

/// A gap below this [m] is closed, and a gap rate below this [m/s] is none.
const CLOSED: f64 = 1e-13;
const AT_REST: f64 = 1e-12;
const ITERATIONS: usize = 12;

/// Moves coordinates, then velocities onto the constraints; `t` is for messages.
pub(super) fn project(
    model: &Model,
    workspace: &mut Workspace,
    scratch: &mut RigidScratch,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) -> Result<bool, EvaluationError> {
    let coordinates = scratch.change.len();
    let mut last = f64::INFINITY;
    for iteration in 0..=ITERATIONS {
        let gaps = gaps(model, workspace, scratch, t, y, memory)?;
        let fail = |cause| EvaluationError::new(t, gaps.wheelset, gaps.side, cause);
        let place = workspace.system.motions[gaps.wheelset.body].position.y;
        // Rounding may hold the last digit.
        let closed = gaps.gap <= CLOSED || (gaps.gap >= last && gaps.gap <= 100.0 * CLOSED);
        if closed && gaps.rate <= AT_REST {
            return Ok(iteration > 0);
        }
        scratch.kkt.factorise().map_err(|_| fail(ContactFailure::Singular { y: place }))?;
        let (residual, values) = if closed { (&scratch.gap_rates, coordinates..2 * coordinates) } else { (&scratch.gaps, 0..coordinates) };
        scratch.kkt.correction(residual, &mut scratch.change);
        y[values].iter_mut().zip(&scratch.change).for_each(|(value, change)| *value += change);
        if closed {
            return Ok(true);
        }
        workspace.work.constraint_iterations += 1;
        last = gaps.gap;
    }
    let gaps = gaps(model, workspace, scratch, t, y, memory)?;
    let place = workspace.system.motions[gaps.wheelset.body].position.y;
    let cause = ContactFailure::NotClosed { iterations: ITERATIONS, gap: gaps.gap, y: place };
    Err(EvaluationError::new(t, gaps.wheelset, gaps.side, cause))
}

/// The largest gap and gap rate, and where the gap is.
struct Gaps<'a> {
    gap: f64,
    rate: f64,
    wheelset: &'a Wheelset,
    side: Side,
}

/// Locates all constrained contacts; leaves their rows, gaps and gap rates in the scratch.
fn gaps<'a>(
    model: &'a Model,
    workspace: &mut Workspace,
    scratch: &mut RigidScratch,
    t: f64,
    y: &[f64],
    memory: &mut [f64],
) -> Result<Gaps<'a>, EvaluationError> {
    model.system.set_motions(y, &mut workspace.system);
    let mut worst = Gaps { gap: 0.0, rate: 0.0, wheelset: &model.wheelsets[0], side: Side::Left };
    for (contact, wheelset, side) in wheels(model) {
        let memory = &mut memory[model.contact_memory(contact)];
        scratch.kkt.set_active(contact, !is_elastic(memory));
        (scratch.gaps[contact], scratch.gap_rates[contact]) = (0.0, 0.0);
        if is_elastic(memory) {
            continue;
        }
        let motion = &workspace.system.motions[wheelset.body];
        let found = locate(model, wheelset, side, motion, memory).map_err(|cause| EvaluationError::new(t, wheelset, side, cause))?;
        workspace.work.search_iterations += found.location.iterations as u64;
        let normal = found.location.normal;
        scratch.kkt.set_mobility(wheelset.body, &model.system.mobility(wheelset.body, motion));
        scratch.kkt.set_row(contact, &motion.coefficients(&normal, &found.arm.cross(&normal)), &Coefficients::zeros());
        let gap = -found.location.penetration;
        (scratch.gaps[contact], scratch.gap_rates[contact]) = (gap, found.gap_rate);
        worst.rate = worst.rate.max(found.gap_rate.abs());
        if gap.abs() > worst.gap {
            worst = Gaps { gap: gap.abs(), wheelset, side, ..worst };
        }
    }
    Ok(worst)
}
