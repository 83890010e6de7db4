//! How wheelsets are set onto the rails before the first balance is looked for.

use super::search::{PITCH, Search};
use crate::formulation::contact_index;
use crate::geometry::Side;
use crate::scene::equilibrium::EquilibriumError;

/// Rounds in which a wheelset on unlike sides is brought back to the centre; each leaves a few per cent of the shift.
const CENTRED: usize = 12;

impl Search<'_> {
    /// Lowers each wheelset until its wheels carry their shares of the load [N] with the stiffness of the first touch.
    pub fn stand(&mut self, load: f64) -> Result<(), EquilibriumError> {
        const TOUCH: f64 = 1e-5;
        if self.model.formulation.constrains() {
            return self.close_unlike_gaps();
        }
        let wheel_load = load / self.model.contacts() as f64;
        let both = |search: &Self, wheelset, of: fn(&crate::formulation::ContactReport) -> f64| {
            Side::BOTH.map(|side| of(&search.workspace.contacts[contact_index(wheelset, side)]))
        };
        let (count, upright) = (self.model.wheelsets.len(), self.held(0, 4));
        self.rails_yield = false;
        for _ in 0..3 {
            for level in [true, false] {
                // Without memory the first contact is the deepest.
                self.now.memory = self.model.blank_memory();
                self.follow_pattern(true);
                self.evaluate().map_err(EquilibriumError::Evaluation)?;
                for wheelset in 0..count {
                    let [left, right] = both(self, wheelset, |report| report.penetration);
                    let place = &mut self.now.at[wheelset].coordinates;
                    if level && !upright {
                        place[4] += (left - right) / (2.0 * self.model.wheelsets[wheelset].left.half_spacing);
                    } else if !level {
                        place[2] += left.max(right) - TOUCH;
                    }
                }
            }
        }
        self.follow_pattern(true);
        self.evaluate().map_err(EquilibriumError::Evaluation)?;
        for wheelset in 0..count {
            // Worn wheels roll on radii that are millimetres off the nominal one: with that they would slide.
            let motion = &self.workspace.system.motions[wheelset];
            let [left, right] = Side::BOTH.map(|side| {
                let arm = self.workspace.contacts[contact_index(wheelset, side)].wheel_point - motion.position;
                motion.axle().cross(&arm).norm()
            });
            self.now.at[wheelset].velocities[PITCH] *= 2.0 * self.model.wheelsets[wheelset].left.profile.at(0.0).value / (left + right);
            let stiffness = both(self, wheelset, |report| report.stiffness);
            let sunk = self.model.travelling_track.map_or(0.0, |track| wheel_load / track.vertical.stiffness);
            self.now.at[wheelset].coordinates[2] += TOUCH - (wheel_load / stiffness[0].max(stiffness[1])).powf(2.0 / 3.0) - sunk;
        }
        self.rails_yield = true;
        Ok(())
    }

    /// Closing the gaps of unlike sides also moves a wheelset that is held sideways a little: back to the centre, and again, until rigid contacts
    /// are where they stay.
    fn close_unlike_gaps(&mut self) -> Result<(), EquilibriumError> {
        if self.standing.held.is_empty() || self.held(0, 4) {
            return Ok(());
        }
        for _ in 0..CENTRED {
            self.rest(true, true).map_err(EquilibriumError::Evaluation)?;
        }
        self.following = true;
        Ok(())
    }
}
