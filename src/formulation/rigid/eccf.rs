//! ECCF: contact as an embedded constraint (Eqs. 15-23 of the paper).
//!
//! The wheel has five degrees of freedom relative to the rail. Four of the five constraints (Eq. 16) give the surface
//! parameters, which are eliminated; the fifth, `n . r = 0` (Eq. 17), stands in the equations of motion with one multiplier per
//! contact (Eq. 23), which is minus the normal force. Rows and Q_cn are derived in `contact::search::kinematics`.
//!
//! Position and velocity level: [`projection`], after each accepted step.

use super::evaluation;
use super::modes;
use super::projection;
use super::row::locate;
use crate::formulation::rigid_scratch::ConstraintRow;
use crate::formulation::step::Step;
use crate::formulation::{Build, Evaluation, EvaluationError, Formulation, Model, OnLift, Parse, Parts, Workspace};
use crate::settings::{Entry, Section, SettingsError};
use std::sync::Arc;

pub(in crate::formulation) const ENTRY: Entry<Parse> = Entry {
    name: "ECCF",
    summary: "contact as a constraint, surface parameters eliminated, one multiplier per contact",
    reference: "paper, section 3.3, Eqs. 15-23",
    parse,
};

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let on_lift = modes::parse(section)?;
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

    fn on_lift(&self) -> Option<OnLift> {
        Some(self.on_lift)
    }

    fn start(&self, step: &mut Step) -> Result<(), EvaluationError> {
        modes::start(step);
        Ok(())
    }

    #[inline]
    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        evaluation::derivative(model, workspace, at, dy, |wheel, motion, memory| {
            Ok(ConstraintRow::of(motion, &locate(model, wheel, motion, memory)?))
        })
    }

    fn project(&self, step: &mut Step) -> Result<bool, EvaluationError> {
        projection::project(step)
    }

    fn error_weight(&self, model: &Model, workspace: &Workspace, i: usize, plain: f64) -> f64 {
        modes::error_weight(model, workspace, i, plain)
    }
}
