//! A wheelset.

use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::mbs::body::BodyMotion;

/// A body with two wheels on the track.
#[derive(Debug)]
pub struct Wheelset {
    pub name: String,
    pub body: usize,
    /// Whose motion the left and the right wheel have, and whose wrench: the body's, or of an axle that twists their own ([`crate::mbs::twist`]).
    pub turning: [usize; 2],
    pub left: Wheel,
    pub right: Wheel,
    /// Imposed constant travelling speed [m/s], `None` when the wheelset is free along the track or its speed changes: it is then that of its motion.
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
