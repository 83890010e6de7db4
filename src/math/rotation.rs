//! Rotations in the order of a wheelset: yaw about Z, then roll about the new X (then pitch about the new Y).

use nalgebra::{Matrix3, Vector3};

/// The frame that follows yaw and roll but does not spin: columns are its axes in the parent frame.
///
/// `A = Rz(yaw) Rx(roll)`, angles in rad.
#[derive(Clone, Copy, Debug)]
pub struct AxleFrame {
    pub axes: Matrix3<f64>,
    pub sin_roll: f64,
    pub cos_roll: f64,
}

impl AxleFrame {
    pub fn new(yaw: f64, roll: f64) -> Self {
        let (sy, cy) = yaw.sin_cos();
        let (sr, cr) = roll.sin_cos();
        AxleFrame { axes: Matrix3::new(cy, -sy * cr, sy * sr, sy, cy * cr, -cy * sr, 0.0, sr, cr), sin_roll: sr, cos_roll: cr }
    }

    /// Angular velocity of the frame itself, in its own axes: `(roll', yaw' sin roll, yaw' cos roll)`.
    pub fn frame_rate(&self, yaw_rate: f64, roll_rate: f64) -> Vector3<f64> {
        Vector3::new(roll_rate, yaw_rate * self.sin_roll, yaw_rate * self.cos_roll)
    }

    /// Angular velocity of the body that also pitches about the frame's Y axis, in the frame's axes.
    pub fn body_rate(&self, yaw_rate: f64, roll_rate: f64, pitch_rate: f64) -> Vector3<f64> {
        let mut rate = self.frame_rate(yaw_rate, roll_rate);
        rate.y += pitch_rate;
        rate
    }
}

/// Motion of a frame, in the parent frame.
#[derive(Clone, Copy, Debug)]
pub struct CarrierMotion {
    /// Of its origin, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub rotation: Vector3<f64>,
    /// Angular acceleration when the angles that describe the frame do not accelerate, rad/s2.
    pub rotation_bias: Vector3<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn analytic_frame_is_rz_rx_and_rates_follow_from_its_derivative() {
        let (yaw, roll) = (0.3, -0.2);
        let frame = AxleFrame::new(yaw, roll);
        let expected = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw) * Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
        assert!((frame.axes - expected.matrix()).norm() < 1e-15);

        // A^T dA/dt is the skew matrix of the angular velocity in the frame's own axes.
        let (yaw_rate, roll_rate, h) = (0.7, -0.4, 1e-6);
        let ahead = AxleFrame::new(yaw + h * yaw_rate, roll + h * roll_rate).axes;
        let behind = AxleFrame::new(yaw - h * yaw_rate, roll - h * roll_rate).axes;
        let skew = frame.axes.transpose() * (ahead - behind) / (2.0 * h);
        let rate = frame.frame_rate(yaw_rate, roll_rate);
        assert!((skew - rate.cross_matrix()).norm() < 1e-9);
    }
}
