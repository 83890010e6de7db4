//! Wheels of an axle that turn against each other.
//!
//! An axle's body of revolution turns as a whole with its spin w (about the axle, `I` its moment of inertia there). Both wheels, with the parts of the
//! axle that turn with them, have the moments of inertia `J_l + J_r = I` and the spins
//!
//! ```text
//! w_l = w + f_l tau',   w_r = w + f_r tau',   f_l = J_r / I,   f_r = -J_l / I,   tau' = w_l - w_r
//! (J_l w_l^2 + J_r w_r^2) / 2 = I w^2 / 2 + mu tau'^2 / 2,   mu = J_l J_r / I
//! ```
//!
//! so that `I w = J_l w_l + J_r w_r` is the angular momentum about the axle: neither the inertia of the twist tau nor gyroscopic moments couple it with the
//! body's motion, whose equations stay what they are under the sum of what acts on both wheels. With M_l, M_r [N m] about the axle on each of them, k and c of the axle,
//!
//! ```text
//! mu tau'' = f_l M_l + f_r M_r - k tau - c tau'
//! ```
//!
//! `k = 0` is an axle bridge with wheels that turn on their own, great k the rigid axle. A torque on the body itself, which names no wheel, is shared as the inertias are:
//! it turns both alike and does not twist.
//!
//! The workspace has a motion and a wrench for each such wheel behind those of the bodies, left before right: who follows the spin of a wheel or turns it (contacts,
//! brakes) takes these; [`super::system::System::fold_wheels`] hands the wrenches to body and twist.

use super::body::Body;
use crate::geometry::Side;

/// How both wheels of an axle turn against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// The axle.
    pub body: usize,
    /// J_l / I, between 0 and 1.
    pub left_share: f64,
    /// I, kg m2.
    pub axial_inertia: f64,
    /// k, N m/rad, and c, N m s/rad.
    pub stiffness: f64,
    pub damping: f64,
}

impl Twist {
    /// The second state of a twist is tau' times this, s: error control weighs it like an angle.
    pub const TIME: f64 = 0.01;

    /// mu, kg m2.
    #[inline]
    pub fn inertia(&self) -> f64 {
        self.left_share * (1.0 - self.left_share) * self.axial_inertia
    }

    /// f_l and f_r.
    #[inline]
    pub fn factors(&self) -> [f64; 2] {
        [1.0 - self.left_share, -self.left_share]
    }
}

/// An axle with a twist in a workspace.
#[derive(Clone, Copy, Debug)]
pub struct TwistedAxle {
    /// The force element that says how it twists.
    pub element: usize,
    pub body: usize,
    /// Where tau and tau' times [`Twist::TIME`] stand among the states of force elements.
    pub state: usize,
}

/// The axles of a system, for elements that turn a wheel.
#[derive(Clone, Copy, Debug)]
pub struct Axles<'a> {
    pub bodies: &'a [Body],
    /// Those that twist, in the order of their elements.
    pub twisted: &'a [usize],
}

impl Axles<'_> {
    /// Whose motion a wheel of an axle has, and whose wrench: its own, or that of a body which does not twist.
    pub fn turning(&self, body: usize, side: Side) -> usize {
        let own = self.twisted.iter().position(|twisted| *twisted == body);
        own.map_or(body, |twist| self.bodies.len() + 2 * twist + side.index())
    }
}
