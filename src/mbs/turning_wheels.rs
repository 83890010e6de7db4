//! Motions and wrenches of wheels that turn against their axles ([`super::twist`]) in a system.

use super::body::{COORDINATES, PITCH};
use super::system::{System, SystemWorkspace};
use super::twist::{Twist, TwistedAxle};
use crate::geometry::Side;
use nalgebra::Vector3;

impl System {
    /// Axles that twist with the elements that let them, in their order.
    pub(super) fn twisted_axles(&self) -> impl Iterator<Item = TwistedAxle> + '_ {
        let mut state = 0;
        self.forces.iter().enumerate().filter_map(move |(element, force)| {
            let found = force.twist().map(|twist| TwistedAxle { element, body: twist.body, state });
            state += force.states();
            found
        })
    }

    /// Angle by which a wheel has turned [rad], and its rate [rad/s], at the state `y`: of a body, or of a wheel of its own behind those.
    pub fn turn_of_wheel(&self, wheel: usize, y: &[f64]) -> [f64; 2] {
        let turn = |body: usize| [self.coordinates(body), self.velocities(body)].map(|range| y[range.start + PITCH]);
        let Some(number) = wheel.checked_sub(self.bodies.len()) else { return turn(wheel) };
        let Some(axle) = self.twisted_axles().nth(number / 2) else { return [0.0; 2] };
        let factor = self.twist(&axle).map_or(0.0, |twist| twist.factors()[number % 2]);
        let state = 2 * COORDINATES * self.bodies.len() + axle.state;
        let [angle, rate] = turn(axle.body);
        [angle + factor * y[state], rate + factor * y[state + 1] / Twist::TIME]
    }

    /// How the axle of this number twists.
    pub(super) fn twist(&self, axle: &TwistedAxle) -> Option<Twist> {
        self.forces[axle.element].twist()
    }

    /// Gives the wheels of axles that twist their motions, from those of their bodies. `states`: of all force elements.
    #[inline(never)]
    pub(super) fn turn_wheels(&self, states: &[f64], workspace: &mut SystemWorkspace) {
        let SystemWorkspace { motions, twists, .. } = workspace;
        for (number, axle) in twists.iter().enumerate() {
            let Some(twist) = self.twist(axle) else { continue };
            let rate = states[axle.state + 1] / Twist::TIME;
            for (side, factor) in twist.factors().into_iter().enumerate() {
                let mut motion = motions[axle.body];
                motion.pitch += factor * states[axle.state];
                motion.pitch_rate += factor * rate;
                motion.rotation += motion.axle() * (factor * rate);
                motions[self.bodies.len() + 2 * number + side] = motion;
            }
        }
    }

    /// Hands the wrenches on wheels of axles that twist, which are zero from then on, to their bodies, and their moments to the twists' rates.
    #[inline]
    pub fn fold_wheels(&self, workspace: &mut SystemWorkspace) {
        for number in 0..workspace.twists.len() {
            let body = workspace.twists[number].body;
            for side in Side::BOTH {
                let wheel = self.bodies.len() + 2 * number + side.index();
                let wrench = std::mem::take(&mut workspace.wrenches[wheel]);
                self.twist_by(wheel, &wrench.moment, workspace);
                workspace.wrenches[body] += wrench;
            }
        }
    }

    /// Hands a moment about the axle on a wheel, which its body has already, to the twist's rate; nothing where `wheel` is a body.
    #[inline]
    pub fn twist_by(&self, wheel: usize, moment: &Vector3<f64>, workspace: &mut SystemWorkspace) {
        let Some(wheel) = wheel.checked_sub(self.bodies.len()) else { return };
        let axle = workspace.twists[wheel / 2];
        let Some(twist) = self.twist(&axle) else { return };
        let torque = workspace.motions[axle.body].axle().dot(moment);
        workspace.force_rates[axle.state + 1] += Twist::TIME * twist.factors()[wheel % 2] * torque / twist.inertia();
    }
}

impl SystemWorkspace {
    /// Number of the bodies, whose motions come first.
    pub fn bodies(&self) -> usize {
        self.motions.len() - 2 * self.twists.len()
    }

    /// Gives the wheels of axles that twist their bodies' places along the track.
    pub fn carry_wheels(&mut self) {
        let first = self.bodies();
        for (number, axle) in self.twists.iter().enumerate() {
            let (distance, speed) = (self.motions[axle.body].distance, self.motions[axle.body].speed);
            for motion in &mut self.motions[first + 2 * number..][..2] {
                (motion.distance, motion.speed) = (distance, speed);
            }
        }
    }
}
