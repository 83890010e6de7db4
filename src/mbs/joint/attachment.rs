//! Motion of the frame in which a joint sits on a body, or of the ground.
//!
//! The frame's angular velocity is linear in the angles' rates, `o = Z yaw' + X roll' (+ Y pitch')` with the axes of
//! yaw, roll and (only if the frame follows the pitch) pitch; what is left of its angular acceleration when all
//! q'' vanish is `o0 = yaw' roll' Z x X (+ pitch' o x Y)`. A vector d fixed in the frame has, without q'', the
//! second derivative `o0 x d + o x (o x d)`.

use crate::mbs::body::BodyMotion;
use crate::mbs::kkt::Coefficients;
use nalgebra::{Matrix3, Vector3};

/// Frame of a body's attachments, in the track frame; all zero rates on the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attachment {
    /// m, m/s.
    pub centre: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub axes: Matrix3<f64>,
    /// o, rad/s, and o0, rad/s2.
    pub rotation: Vector3<f64>,
    rotation_bias: Vector3<f64>,
    roll_axis: Vector3<f64>,
    /// Zero if the frame does not follow the pitch.
    pitch_axis: Vector3<f64>,
}

impl Attachment {
    pub fn of(motion: &BodyMotion) -> Self {
        let roll_axis = motion.roll_axis();
        let mut rotation_bias = Vector3::z().cross(&roll_axis) * (motion.yaw_rate * motion.roll_rate);
        let mut pitch_axis = Vector3::zeros();
        if motion.turn.is_some() {
            pitch_axis = motion.axle();
            rotation_bias += motion.rotation.cross(&pitch_axis) * motion.pitch_rate;
        }
        Attachment {
            centre: motion.position,
            velocity: motion.velocity,
            axes: motion.frame.axes,
            rotation: motion.frame_rotation,
            rotation_bias,
            roll_axis,
            pitch_axis,
        }
    }

    pub fn ground() -> Self {
        let zero = Vector3::zeros();
        Attachment {
            centre: zero,
            velocity: zero,
            axes: Matrix3::identity(),
            rotation: zero,
            rotation_bias: zero,
            roll_axis: zero,
            pitch_axis: zero,
        }
    }

    /// Velocity of a vector fixed in the frame.
    pub fn rate(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.cross(vector)
    }

    /// Second derivative of a vector fixed in the frame when all q'' vanish.
    pub fn bias(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        self.rotation_bias.cross(vector) + self.rotation.cross(&self.rotation.cross(vector))
    }

    /// Coefficients on the six velocities of `linear . v + angular . o`.
    pub fn coefficients(&self, linear: &Vector3<f64>, angular: &Vector3<f64>) -> Coefficients {
        Coefficients::new(linear.x, linear.y, linear.z, angular.z, self.roll_axis.dot(angular), self.pitch_axis.dot(angular))
    }
}
