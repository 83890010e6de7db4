//! Where a body is and how it moves: coordinates, motion, wrenches.

use super::kkt::Coefficients;
use crate::math::rotation::{AxleFrame, CarrierMotion};
use nalgebra::{Matrix3, Vector3};

/// Coordinates of one body in the state vector: x, y, z, yaw, roll, pitch.
pub const COORDINATES: usize = 6;
/// Places of some of them.
pub const LATERAL: usize = 1;
pub const HEIGHT: usize = 2;
pub const YAW: usize = 3;
pub const ROLL: usize = 4;
pub const PITCH: usize = 5;

/// Position and velocity of one body at one instant.
#[derive(Clone, Copy, Debug)]
pub struct BodyMotion {
    /// Centre of mass in the track frame, m and m/s.
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    /// Frame of the attachments: yaw and roll, and for a body that is not one of revolution the pitch too, so that
    /// its axes are the body's own. The sine and cosine are the roll's in both cases.
    pub frame: AxleFrame,
    /// Angular velocity of `frame` in the track frame, rad/s.
    pub frame_rotation: Vector3<f64>,
    /// Sine and cosine of the pitch if `frame` follows it.
    pub turn: Option<(f64, f64)>,
    /// Angular velocity of the body in the track frame, rad/s.
    pub rotation: Vector3<f64>,
    pub yaw: f64,
    pub roll: f64,
    pub pitch: f64,
    pub yaw_rate: f64,
    pub roll_rate: f64,
    pub pitch_rate: f64,
    /// Distance of the centre along the track, m, and its speed along the track, m/s: x and x' unless a curved track is followed.
    pub distance: f64,
    pub speed: f64,
}

impl BodyMotion {
    /// A body of revolution, from its six coordinates and six velocities.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn new(q: &[f64], v: &[f64]) -> Self {
        let frame = AxleFrame::new(q[3], q[4]);
        BodyMotion {
            position: Vector3::new(q[0], q[1], q[2]),
            velocity: Vector3::new(v[0], v[1], v[2]),
            frame_rotation: frame.axes * frame.frame_rate(v[3], v[4]),
            turn: None,
            rotation: frame.axes * frame.body_rate(v[3], v[4], v[5]),
            frame,
            yaw: q[3],
            roll: q[4],
            pitch: q[5],
            yaw_rate: v[3],
            roll_rate: v[4],
            pitch_rate: v[5],
            distance: q[0],
            speed: v[0],
        }
    }

    /// Any other body: its attachments follow the pitch.
    pub fn general(q: &[f64], v: &[f64]) -> Self {
        let mut motion = Self::new(q, v);
        motion.follow_pitch();
        motion
    }

    /// Lets the frame turn with the body. Out of line: the wheelset's path has no use for it.
    #[inline(never)]
    pub(super) fn follow_pitch(&mut self) {
        let turn = self.pitch.sin_cos();
        self.frame.axes *= turn_about_y(turn);
        self.frame_rotation = self.rotation;
        self.turn = Some(turn);
    }

    /// Velocity of the body's material point at `point` [m, track frame].
    pub fn material_velocity(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.rotation.cross(&(point - self.position))
    }

    /// Track-frame position of an attachment that is given in the axes of `frame`.
    pub fn attachment_point(&self, local: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.frame.axes * local
    }

    /// Velocity of an attachment that is at `point` [m, track frame]; on a body of revolution it does not spin.
    pub fn attachment_velocity(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.frame_rotation.cross(&(point - self.position))
    }

    /// Motion of the frame that carries what does not spin.
    #[inline]
    pub fn carrier(&self) -> CarrierMotion {
        // W = Z yaw' + X roll' with X turning about Z.
        let bias = Vector3::z().cross(&self.frame.axes.column(0)) * (self.yaw_rate * self.roll_rate);
        CarrierMotion { velocity: self.velocity, rotation: self.frame_rotation, rotation_bias: bias }
    }

    /// Coefficients on the body's coordinates of a quantity that changes with `by_velocity . v + by_rotation . W`, where v and W
    /// belong to the frame that does not spin.
    #[inline]
    pub fn coefficients(&self, by_velocity: &Vector3<f64>, by_rotation: &Vector3<f64>) -> Coefficients {
        let (a, b) = (by_velocity, by_rotation);
        Coefficients::new(a.x, a.y, a.z, b.z, b.dot(&self.frame.axes.column(0)), 0.0)
    }

    /// A wrench's generalised force on the six coordinates: force, then moment about the axes of yaw, roll and pitch.
    #[inline]
    pub fn generalised_force(&self, wrench: &Wrench) -> Coefficients {
        let (force, moment) = (wrench.force, wrench.moment);
        let roll_axis = self.roll_axis();
        Coefficients::new(force.x, force.y, force.z, moment.z, roll_axis.dot(&moment), self.axle().dot(&moment))
    }

    /// Unit vector about which the roll turns.
    #[inline]
    pub fn roll_axis(&self) -> Vector3<f64> {
        let (x, z) = (self.frame.axes.column(0), self.frame.axes.column(2));
        match self.turn {
            None => x.into_owned(),
            Some((sin, cos)) => x * cos + z * sin,
        }
    }

    /// Unit vector of the axle, about which the pitch turns, pointing left.
    pub fn axle(&self) -> Vector3<f64> {
        self.frame.axes.column(1).into_owned()
    }
}

/// Rotation about Y, from sine and cosine.
pub(super) fn turn_about_y((sin, cos): (f64, f64)) -> Matrix3<f64> {
    Matrix3::new(cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos)
}

/// Force and moment about the body's centre, in the track frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// N.
    pub force: Vector3<f64>,
    /// N m.
    pub moment: Vector3<f64>,
}

impl Wrench {
    /// Adds a force that acts at `point` on a body whose centre is at `centre`.
    #[inline]
    pub fn add_at(&mut self, force: Vector3<f64>, point: &Vector3<f64>, centre: &Vector3<f64>) {
        self.force += force;
        self.moment += (point - centre).cross(&force);
    }
}

impl std::ops::AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.moment += other.moment;
    }
}
