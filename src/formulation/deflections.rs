//! Tangential states of contacts at low speed (`contact.transient`): their rates, and their start.

use super::step::WheelRef;
use super::{Model, Workspace};
use crate::contact::transient::{self, LoadedPatch};

impl Model {
    /// Writes the rates of all tangential states, which the contacts' reports hold.
    #[inline]
    pub(super) fn deflection_rates(&self, workspace: &Workspace, y: &[f64], dy: &mut [f64]) {
        let Some(transient) = &self.laws.transient else { return };
        for WheelRef { contact, wheelset, .. } in self.wheels() {
            let speed = wheelset.speed(&workspace.system.motions[wheelset.body]);
            for slot in 0..self.points {
                let report = workspace.report(contact, slot);
                let range = self.deflection(contact, slot);
                let unloaded = || {
                    let mut state = [0.0; transient::STATES];
                    state.copy_from_slice(&y[range.clone()]);
                    transient.unloaded_rates(speed, &state)
                };
                let rates = if report.normal_force > 0.0 { report.deflection_rates } else { unloaded() };
                dy[range].copy_from_slice(&rates);
            }
        }
    }

    /// Puts the tangential states where they are in steady rolling with the contacts as they were found last.
    pub fn settle_deflections(&self, workspace: &Workspace, y: &mut [f64]) {
        let Some(transient) = &self.laws.transient else { return };
        for WheelRef { contact, wheelset, side } in self.wheels() {
            for slot in 0..self.points {
                let report = workspace.report(contact, slot);
                let motion = &workspace.system.motions[wheelset.body];
                let speed = wheelset.speed(motion);
                let patch = LoadedPatch {
                    patch: report.patch,
                    normal_force: report.normal_force,
                    friction: self.friction_at(side, motion, report),
                };
                let state = transient.steady_state(&patch, &report.slip.rolling(speed));
                y[self.deflection(contact, slot)].copy_from_slice(&state);
            }
        }
    }
}
