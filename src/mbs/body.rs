//! Rigid bodies: coordinates, motion, wrenches.
//!
//! Coordinates: position x, y, z [m] of the centre of mass in the world (on straight track the track frame), yaw, roll, pitch [rad] of
//! `Rz(yaw) Rx(roll) Ry(pitch)`; velocities are their time derivatives. A body of revolution that may spin is
//! described in the axle frame `Rz Rx`, which does not spin with it, so the step size is not tied to the
//! revolutions. What is attached to such a body (a spring at its bearing, a joint) sits in the axle frame; what is
//! attached to any other body sits in the body's own axes `Rz Rx Ry`. The coordinates are singular at a roll of
//! 90 degrees.

use super::inertia::Inertia;
use super::kkt::Mobility;
pub use super::motion::{BodyMotion, COORDINATES, HEIGHT, LATERAL, PITCH, ROLL, Wrench, YAW};

/// Mass properties of a rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub name: String,
    /// kg.
    pub mass: f64,
    pub inertia: Inertia,
}

impl BodyMotion {
    /// Overwrites with the motion of `body`; in place, because copies would cost more than what is computed.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn set(&mut self, body: &Body, q: &[f64], v: &[f64]) {
        *self = Self::new(q, v);
        if let Inertia::General { .. } = body.inertia {
            self.follow_pitch();
        }
    }
}

impl Body {
    /// From the body's six coordinates and six velocities.
    pub fn motion(&self, q: &[f64], v: &[f64]) -> BodyMotion {
        match self.inertia {
            Inertia::Revolution { .. } | Inertia::NotGyroscopic { .. } => BodyMotion::new(q, v),
            Inertia::General { .. } => BodyMotion::general(q, v),
        }
    }

    /// Accelerations of the six coordinates under a wrench.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn accelerations(&self, motion: &BodyMotion, wrench: &Wrench) -> [f64; COORDINATES] {
        let [yaw, roll, pitch] = self.inertia.accelerations(motion, &wrench.moment);
        let linear = wrench.force / self.mass;
        [linear.x, linear.y, linear.z, yaw, roll, pitch]
    }

    /// Inverse of the mass matrix of the six coordinates.
    #[inline]
    pub fn mobility(&self, motion: &BodyMotion) -> Mobility {
        let mut mobility = Mobility::zeros();
        for i in 0..3 {
            mobility[(i, i)] = 1.0 / self.mass;
        }
        mobility.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia.mobility(motion));
        mobility
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, motion: &BodyMotion) -> f64 {
        0.5 * self.mass * motion.velocity.norm_squared() + self.inertia.kinetic_energy(motion)
    }
}
