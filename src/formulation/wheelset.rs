//! A wheelset, and what a master may apply to it.

use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::mbs::body::BodyMotion;

/// Inputs of one wheelset, in the order in which they stand in the input vector.
pub const WHEELSET_INPUTS: usize = 6;
pub const DRIVE_TORQUE: usize = 0;
pub const LATERAL_FORCE: usize = 1;
pub const VERTICAL_FORCE: usize = 2;
pub const LEFT_FRICTION: usize = 3;
pub const RIGHT_FRICTION: usize = 4;
pub const LONGITUDINAL_FORCE: usize = 5;
/// Values of a wheelset's inputs that leave it alone.
pub const NEUTRAL_INPUTS: [f64; WHEELSET_INPUTS] = [0.0, 0.0, 0.0, 1.0, 1.0, 0.0];

/// A body with two wheels on the track.
#[derive(Debug)]
pub struct Wheelset {
    pub name: String,
    pub body: usize,
    pub left: Wheel,
    pub right: Wheel,
    /// Imposed travelling speed [m/s], `None` when the wheelset is free along the track.
    pub imposed_speed: Option<f64>,
    /// Vertical force of each wheel on level track at rest, N.
    pub static_wheel_load: f64,
}

impl Wheelset {
    /// Travelling speed that creepages are relative to, m/s; with the sign of the direction.
    #[inline]
    pub fn speed(&self, motion: &BodyMotion) -> f64 {
        self.imposed_speed.unwrap_or(motion.speed)
    }

    pub fn wheel(&self, side: Side) -> &Wheel {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }
}

/// Place of a wheel's first contact among all contacts and in what is remembered.
pub fn contact_index(wheelset: usize, side: Side) -> usize {
    2 * wheelset + usize::from(side == Side::Right)
}
