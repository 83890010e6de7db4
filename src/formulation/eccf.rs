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
use super::points;
use super::rigid::{self, ConstraintRow, is_elastic, wheels};
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

    fn on_lift(&self) -> Option<OnLift> {
        Some(self.on_lift)
    }

    fn start(&self, model: &Model, workspace: &mut Workspace, _: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        lift::start(model, workspace, y, memory);
        Ok(())
    }

    #[inline]
    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        rigid::derivative(model, workspace, at, dy, |contact, wheelset, side, motion, memory| {
            let found = locate(model, (contact, wheelset, side), motion, memory)?;
            let rates = [found.parameter_rates[0], found.parameter_rates[3]];
            Ok(ConstraintRow { location: found.location, row: row(motion, &found), bias: found.gap_bias, rates })
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
        project(model, workspace, t, y, memory)
    }

    fn error_weight(&self, model: &Model, workspace: &Workspace, i: usize, plain: f64) -> f64 {
        lift::error_weight(model, workspace, i, plain)
    }
}

/// The contact with the motion of its gap; `memory` holds the warm start.
#[inline]
pub(super) fn locate(
    model: &Model,
    (contact, wheelset, side): (usize, &Wheelset, Side),
    motion: &BodyMotion,
    memory: &mut [f64],
) -> Result<MovingContact, ContactFailure> {
    let pair = pair(model, wheelset, side, motion);
    let carrier = motion.carrier();
    let start = warm_start(memory);
    let mut found = pair.locate_moving(&start, &carrier);
    // A constraint that is lost where others may take over must not jump to one of them.
    if model.searches[contact].is_none() || is_elastic(memory) {
        found = found.or_else(|_| pair.locate_moving(&SurfaceParameters::default(), &carrier));
    }
    let found = found.map_err(|failure| not_found(model, motion, failure))?;
    keep(&found.location.parameters, memory);
    Ok(found)
}

/// H of Eq. 23 on the wheelset's coordinates.
#[inline]
pub(super) fn row(motion: &BodyMotion, found: &MovingContact) -> Coefficients {
    let normal = found.location.normal;
    motion.coefficients(&normal, &found.arm.cross(&normal))
}

/// Moves coordinates, then velocities onto the constraints; returns whether anything was moved.
pub(super) fn project(
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) -> Result<bool, EvaluationError> {
    project_pressed(model, workspace, t, y, memory, [None; 2])
}

/// An elastic contact that projection treats as if it were a constraint, at its wheel's deepest place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pressed {
    pub contact: usize,
    /// Penetration, m.
    pub depth: f64,
    /// Rate of the gap, m/s.
    pub gap_rate: f64,
}

/// The same; the elastic contacts of one wheelset may be brought to a penetration and its rate, or held there.
pub(super) fn project_pressed(
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
    pressed: [Option<Pressed>; 2],
) -> Result<bool, EvaluationError> {
    let mut searches = 0;
    let changed = rigid::project(model, workspace, t, y, |system| {
        model.update_stations(memory, system);
        for (contact, wheelset, side) in wheels(model) {
            let memory = &mut memory[model.contact_memory(contact)];
            let pressed = pressed.into_iter().flatten().find(|pressed| pressed.contact == contact);
            let elastic = is_elastic(memory) && pressed.is_none();
            let index = system.constraints.joint_rows + contact;
            system.constraints.kkt.set_active(index, !elastic);
            (system.constraints.residual[index], system.constraints.rate[index]) = (0.0, 0.0);
            if elastic {
                continue;
            }
            let motion = &system.motions[wheelset.body];
            if pressed.is_some()
                && let Some(place) = points::deepest(model, contact, &pair(model, wheelset, side, motion))
            {
                keep(&place, memory);
            }
            let found =
                locate(model, (contact, wheelset, side), motion, memory).map_err(|cause| EvaluationError::new(t, wheelset, side, cause))?;
            searches += found.location.iterations as u64;
            system.constraints.kkt.set_row(index, &row(motion, &found), &Coefficients::zeros());
            system.constraints.residual[index] = pressed.map_or(0.0, |pressed| pressed.depth) - found.location.penetration;
            system.constraints.rate[index] = found.gap_rate - pressed.map_or(0.0, |pressed| pressed.gap_rate);
        }
        Ok(())
    });
    workspace.work.search_iterations += searches;
    changed
}
