//! A wheel whose radius differs around it (`geometry::out_of_round`) on its rail.
//!
//! At the angle a that the wheel has turned (in space: on a grade g its outline is g farther than on level track) its centre rides at R + d(a) over a straight rail (D there, with the lead of the contact). With e the direction up in the plane of the wheel
//! and w its angular velocity, wheel and rail stand to each other as if the round wheel's centre p were lower by d, while its material moves as on the larger radius:
//!
//! ```text
//! p* = p - d e        v* = v - w x (d e)        rate of penetration: -(v* - c) . n,   slip: that of v* - c,   c = d' a' e
//! moment about p: that about p* and -d e x F;  about the axle in addition -d' e . F
//! ```
//!
//! The last term, and c in the slip, are the lead of the contact on the bumpy wheel (`rail_motion`): with them the power of its forces is what the contact stores and what slips, so that
//! energy is kept.
//! So a polygon acts on the height of a wheel as corrugation of the rail of the wave 2 pi R / n does, and besides changes the rolling radius (creepage d / R).
//!
//! *Left out:* that the place of the contact leads along the rail too (by d', 1 mm for d' = 1 mm / rad; `wheelAngle` does not show it), so that a wheel's trough over a dip of its rail is the sum of
//! both, the change of the wheel's curvature in Hertz's theory (`d'' / R^2` beside 1 / R: for the deepest flat that is let in 90 %, for a polygon of order 20 and 0.1 mm 4 %), differences between
//! flange and tread.
//!
//! A wheelset rides its wheels' waves as it rides its rails' (`moving_frame`): the known motion lifts it by d(a + a' tau). The Jacobian knows what a changes, so that
//! both cancel where the wheel follows: with P and V the changes of a wheel's wrench with displacement and velocity,
//!
//! ```text
//! dW/da = -P d' e - V (d'' a' e + w x d' e),   dW/da' = -V d' e
//! ```
//!
//! Where an axle twists, a is the wheel's own angle, of which J knows the axle's part, and in a' the twist's too.

use super::rail_motion::{AgainstRail, Swollen};
use super::{AssemblyError, ContactReport, Model, Workspace};
use crate::geometry::out_of_round::OutOfRound;
use crate::mbs::tangent::WrenchTangent;
use nalgebra::Vector3;

impl AgainstRail {
    /// Makes the wheel what it is at its angle.
    pub fn swell(&mut self, wheel: &OutOfRound) {
        let [more, slope, bend, _] = wheel.at(self.motion.pitch);
        let up = self.climb.up;
        let swollen = Swollen { larger: up * more, growing: up * slope, bending: up * bend, axle: self.motion.axle() };
        self.motion.position -= swollen.larger;
        self.motion.velocity -= self.motion.rotation.cross(&swollen.larger);
        self.climb.velocity += swollen.growing * self.motion.pitch_rate;
        self.round = Some(swollen);
    }
}

impl Model {
    /// What a wheel's angle does to its contacts, beside `own`: how its wrench changes with its motion.
    pub(super) fn add_turning_bumps(moved: &AgainstRail, own: &mut WrenchTangent) {
        let Some(Swollen { growing, bending, axle, .. }) = moved.round else { return };
        let motion = &moved.motion;
        let [position, velocity] = [&own.by_position, &own.by_velocity].map(|all| all.fixed_columns::<3>(0).into_owned());
        let moving = bending * motion.pitch_rate + motion.rotation.cross(&growing);
        let by_angle = -(position * growing + velocity * moving);
        let by_rate = -(velocity * growing);
        for (all, change) in [(&mut own.by_position, by_angle), (&mut own.by_velocity, by_rate)] {
            let mut turning = all.fixed_columns_mut::<3>(3);
            turning += change * axle.transpose();
        }
    }

    /// Adds to the wrench of a wheel's contacts, taken about p*, what it is about p, and what the turn of a bent rail makes of it.
    #[inline]
    pub(super) fn finish_wheel(
        &self,
        workspace: &mut Workspace,
        moved: Option<&AgainstRail>,
        (contact, body, turning): (usize, usize, usize),
    ) {
        let Some(moved) = moved.filter(|moved| moved.round.is_some() || moved.slope.is_some()) else { return };
        let bent = self.lay_on_bent_rail(workspace, moved, (contact, body));
        let moment = self.turned_by_bumps(workspace, moved, contact);
        workspace.system.wrenches[turning] += bent;
        workspace.system.wrenches[turning].moment -= moment;
    }

    /// The moment by which those about p* are larger than those about p, N m; 0 of a round wheel.
    pub(super) fn turned_by_bumps(&self, workspace: &Workspace, moved: &AgainstRail, contact: usize) -> Vector3<f64> {
        let Some(Swollen { larger, growing, axle, .. }) = moved.round else { return Vector3::zeros() };
        let turned = |report: &ContactReport| larger.cross(&report.force) + axle * growing.dot(&report.force);
        workspace.reports(contact).map(turned).sum()
    }

    /// Wheels that are not round, by contact.
    pub fn wheels_out_of_round(&self) -> impl Iterator<Item = (usize, &OutOfRound)> {
        self.out_of_round.iter().enumerate().filter_map(|(contact, wheel)| Some((contact, wheel.as_ref()?)))
    }

    /// How long a step may last by what its wheels have ahead of them, s.
    pub(super) fn longest_of_wheels(&self, workspace: &Workspace) -> f64 {
        let time = |(contact, wheel): (usize, &OutOfRound)| {
            let motion = &workspace.system.motions[self.wheelsets[contact / 2].turning[contact % 2]];
            if motion.pitch_rate == 0.0 { f64::INFINITY } else { wheel.reach(motion.pitch, motion.pitch_rate) / motion.pitch_rate.abs() }
        };
        self.wheels_out_of_round().map(time).fold(f64::INFINITY, f64::min)
    }

    /// When a wheel reaches the next edge of a flat, where what it does is not smooth, if it goes on turning as it does at the state `y` at time `t` [s].
    pub fn next_edge_of_a_flat(&self, t: f64, y: &[f64]) -> f64 {
        let edge = |(contact, wheel): (usize, &OutOfRound)| {
            let [angle, rate] = self.system.turn_of_wheel(self.wheelsets[contact / 2].turning[contact % 2], y);
            wheel.next_edge(angle, rate).map_or(f64::INFINITY, |turn| t + turn / rate.abs())
        };
        self.wheels_out_of_round().map(edge).fold(f64::INFINITY, f64::min)
    }

    /// The same model with wheels, by contact, that are not round.
    ///
    /// # Errors
    /// [`AssemblyError::OutOfRound`] where contact is a constraint.
    pub fn with_out_of_round(mut self, wheels: Vec<Option<OutOfRound>>) -> Result<Self, AssemblyError> {
        if wheels.iter().all(Option::is_none) {
            return Ok(self);
        }
        if self.formulation.constrains() {
            return Err(AssemblyError::OutOfRound);
        }
        self.out_of_round = wheels;
        self.surfaces_move = true;
        Ok(self)
    }
}
