//! Positions and velocities on the constraints, contacts located one by one.
//!
//! Two coupled Newton iterations (section 3.3 of the paper): for given coordinates Eq. 16 is solved for the surface parameters; with these the
//! coordinates are corrected by `-M^-1 H^T (H M^-1 H^T)^-1 g`, the smallest change weighted with the masses; and again, until all gaps vanish.
//! Velocities are then corrected likewise.

use super::row::{coefficients, locate};
use crate::formulation::elastic::points;
use crate::formulation::step::Step;
use crate::formulation::{EvaluationError, projection};
use crate::mbs::kkt::Coefficients;

/// Moves coordinates, then velocities onto the constraints; returns whether anything was moved.
pub(super) fn project(step: &mut Step) -> Result<bool, EvaluationError> {
    project_pressed(step, [None; 2])
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
pub(super) fn project_pressed(step: &mut Step, pressed: [Option<Pressed>; 2]) -> Result<bool, EvaluationError> {
    let (model, t) = (step.model, step.t);
    let mut searches = 0;
    let changed = projection::project(step, |system, memory| {
        model.update_stations(memory, system);
        for wheel in model.wheels() {
            let memory = &mut memory.wheels[wheel.contact];
            let pressed = pressed.into_iter().flatten().find(|pressed| pressed.contact == wheel.contact);
            let elastic = memory.mode.is_elastic() && pressed.is_none();
            let index = system.constraints.joint_rows + wheel.contact;
            system.constraints.kkt.set_active(index, !elastic);
            (system.constraints.residual[index], system.constraints.rate[index]) = (0.0, 0.0);
            if elastic {
                continue;
            }
            let motion = &system.motions[wheel.wheelset.body];
            if pressed.is_some()
                && let Some(place) = points::deepest(model, wheel.contact, &wheel.pair(model, motion))
            {
                memory.set_start(place);
            }
            let found = locate(model, wheel, motion, memory).map_err(|cause| wheel.error(t, cause))?;
            searches += found.location.iterations as u64;
            system.constraints.kkt.set_row(index, &coefficients(motion, &found), &Coefficients::zeros());
            system.constraints.residual[index] = pressed.map_or(0.0, |pressed| pressed.depth) - found.location.penetration;
            system.constraints.rate[index] = found.gap_rate - pressed.map_or(0.0, |pressed| pressed.gap_rate);
        }
        Ok(())
    });
    step.workspace.work.search_iterations += searches;
    changed
}
