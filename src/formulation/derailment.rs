//! Wheels that have left their rails, whatever finds their contacts.
//!
//! A wheel that carries nothing and whose nearest place is further than [`FAR`] from its rail has left it, and one that is pressed on the tip of its flange has derailed: the run ends there. The
//! search for all places says so itself; pairs that touch at one place only, nodes (ECF-N) and linear contact followed a wheel to any height (60 m, and back onto its rail). Linear contact knows no tips.

use super::step::WheelRef;
use super::wheel_search::FAR;
use super::{ContactFailure, EvaluationError, Model, Workspace};

impl Model {
    /// Asks the contacts that were evaluated last, at `t` [s].
    ///
    /// # Errors
    /// [`ContactFailure::Derailed`].
    #[inline]
    pub(super) fn on_the_rails(&self, workspace: &Workspace, t: f64) -> Result<(), EvaluationError> {
        // The place of linear contact is a straight line of y, and passes the tip long before the wheel does.
        let has_tips = self.linear.is_empty();
        for (contact, flank) in self.flanks.iter().enumerate() {
            let (mut nearest, mut carries, mut on_tip) = (f64::NEG_INFINITY, false, false);
            for report in workspace.reports(contact) {
                carries |= report.carries();
                on_tip |= has_tips && report.normal_force > 0.0 && !report.constrained && report.parameters.wheel < flank.tip;
                // Where there is no place there is no overlap either, to the bit.
                nearest = if report.penetration == 0.0 { nearest } else { nearest.max(report.penetration) };
            }
            let far = nearest > f64::NEG_INFINITY && nearest < -FAR;
            let gone = !carries && nearest < 0.0 && (far || self.height(workspace, contact) > FAR);
            if gone || on_tip {
                return Err(self.derailed(
                    workspace,
                    t,
                    contact,
                    if gone { "the wheel has left the rail" } else { "the tip of the flange stands on the rail" },
                ));
            }
        }
        Ok(())
    }

    /// Where a wheel's radius is greatest on its flange, m (wheel coordinate); `None` without a flange.
    pub fn flange_tip(&self, contact: usize) -> Option<f64> {
        self.flanks.get(contact).map(|flank| flank.tip).filter(|tip| tip.is_finite())
    }

    /// How high a wheel's tread is above where it stands on ideal rails, m. (Nodes measure along the normal of the rail's end where nothing is below them.)
    fn height(&self, workspace: &Workspace, contact: usize) -> f64 {
        let WheelRef { wheelset, side, .. } = self.wheel(contact);
        let (wheel, motion) = (wheelset.wheel(side), &workspace.system.motions[wheelset.body]);
        let (_, z) = self.beside(motion);
        let axle = workspace.in_track(wheelset.body, motion.axle());
        z + side.sign() * wheel.half_spacing * axle.z - wheel.profile.at(0.0).value
    }

    #[cold]
    fn derailed(&self, workspace: &Workspace, t: f64, contact: usize, how: &'static str) -> EvaluationError {
        let wheel = self.wheel(contact);
        let (y, z) = self.beside(&workspace.system.motions[wheel.wheelset.body]);
        EvaluationError::new(t, wheel.wheelset, wheel.side, ContactFailure::off_the_rail(how, y, z))
    }
}
