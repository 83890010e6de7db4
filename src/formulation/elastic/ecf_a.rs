//! ECF-A: elastic contact located by algebraic equations (Eqs. 24-28 of the paper).
//!
//! The wheel has six degrees of freedom relative to the rail. Per contact, four equations give the surface
//! parameters; they are solved to rounding at each evaluation and are not integrated. There is no multiplier. The
//! penetration `delta` (positive in contact) gives the normal force `N = K_h delta^1.5 + C delta delta'`, never
//! tensile; `delta' = -v . n` with the velocity v of the wheel's material point, which is exact because the located
//! points make delta stationary. At lift-off (delta <= 0) all forces vanish and the search goes on, so landing needs
//! nothing special. Forces act at the wheel's undeformed material point; creepage is taken there too.

use super::{finish, points};
use crate::formulation::loading::{WheelAt, external_wrench};
use crate::formulation::rail_motion::Climb;
use crate::formulation::{
    Build, Evaluation, EvaluationError, Formulation, LEFT_FRICTION, Model, Parse, RIGHT_FRICTION, WHEELSET_INPUTS, Workspace, contact_index,
};
use crate::geometry::Side;
use crate::mbs::body::Wrench;
use crate::settings::{Entry, Section, SettingsError};
use std::sync::Arc;

pub(in crate::formulation) const ENTRY: Entry<Parse> = Entry {
    name: "ECF-A",
    summary: "elastic contact, points located by four algebraic equations per wheel",
    reference: "paper, section 4.1, Eqs. 24-28",
    parse,
};

fn parse(_: &Section) -> Result<Build, SettingsError> {
    Ok(build())
}

pub(in crate::formulation) fn build() -> Build {
    Arc::new(|_| Ok(Box::new(EcfA)))
}

/// The formulation has no settings of its own.
#[derive(Debug)]
struct EcfA;

impl Formulation for EcfA {
    fn describe(&self) -> String {
        "elastic, each point from four equations".into()
    }

    #[inline]
    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        let Evaluation { t, inputs, y, memory } = at;
        model.apply_forces(y, memory, &mut workspace.system);
        model.feel_rails(workspace, y);
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            let own = &inputs[index * WHEELSET_INPUTS..(index + 1) * WHEELSET_INPUTS];
            let applied = external_wrench(model, &workspace.system, wheelset.body, own);
            workspace.system.wrenches[wheelset.body] += applied;
            let mut left = Wrench::default();
            for (side, friction) in [(Side::Left, own[LEFT_FRICTION]), (Side::Right, own[RIGHT_FRICTION])] {
                let (contact, turning) = (contact_index(index, side), wheelset.turning[side.index()]);
                if model.half.is_some() && side == Side::Right {
                    model.mirror_wheel(workspace, [contact - 1, contact], turning, &left);
                    continue;
                }
                let moved = model.against_rail((&workspace.system, &workspace.rails), (inputs, y), (wheelset.body, turning), contact);
                let as_it_is = &workspace.system.motions[turning];
                let (motion, climb) = moved.as_ref().map_or((as_it_is, Climb::default()), |moved| (&moved.motion, moved.climb));
                let wheel = WheelAt { model, wheelset, side, contact, motion, climb, friction, y };
                let wrench = &mut workspace.system.wrenches[turning];
                let before = *wrench;
                let reports = model.reports(contact, &mut workspace.contacts, &mut workspace.further_contacts);
                points::elastic_wheel(
                    &wheel,
                    &mut memory.wheels[contact],
                    (&mut workspace.strips[contact], &mut workspace.loaded),
                    wrench,
                    reports,
                )
                .and_then(|()| if model.half.is_some() { model.check_half(&wheel, own) } else { Ok(()) })
                .map_err(|cause| EvaluationError::new(t, wheelset, side, cause))?;
                left = Wrench { force: wrench.force - before.force, moment: wrench.moment - before.moment };
                workspace.work.search_iterations += workspace.contacts[contact].iterations as u64;
                model.finish_wheel(workspace, moved.as_ref(), (contact, wheelset.body, turning));
            }
        }
        finish(model, workspace, t, y, dy)
    }
}
