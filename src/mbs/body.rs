//! A rigid body of revolution that may spin, described in the frame that does not spin with it.
//!
//! Coordinates: position x, y, z [m] of the centre of mass in the track frame, yaw, roll, pitch [rad] of
//! `Rz(yaw) Rx(roll) Ry(pitch)`; velocities are their time derivatives. The body's inertia is the same about every
//! axis across the axle, so the equations are written in the axle frame `Rz Rx`, and the step size is not tied to
//! the revolutions. With the body's angular velocity `(p, q, r)` and the frame's `(p, w, r)` in that frame,
//! transverse inertia J, axial inertia I and moment M about the centre:
//!
//! ```text
//! J p' = Mx - w J r + r I q,     I q' = My,     J r' = Mz - p I q + w J p
//! p = roll',  w = yaw' sin roll,  q = pitch' + w,  r = yaw' cos roll
//! ```

use super::kkt::{Coefficients, Mobility};
use crate::math::rotation::AxleFrame;
use nalgebra::Vector3;

/// Coordinates of one body in the state vector: x, y, z, yaw, roll, pitch.
pub const COORDINATES: usize = 6;

/// Mass properties of a body of revolution.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub name: String,
    /// kg.
    pub mass: f64,
    /// Moment of inertia about any axis through the centre across the axle, kg m2.
    pub transverse_inertia: f64,
    /// Moment of inertia about the axle, kg m2.
    pub axial_inertia: f64,
}

/// Position and velocity of one body at one instant.
#[derive(Clone, Copy, Debug)]
pub struct BodyMotion {
    /// Centre of mass in the track frame, m and m/s.
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub frame: AxleFrame,
    /// Angular velocity of the axle frame in the track frame, rad/s.
    pub frame_rotation: Vector3<f64>,
    /// Angular velocity of the body in the track frame, rad/s.
    pub rotation: Vector3<f64>,
    pub yaw: f64,
    pub roll: f64,
    pub yaw_rate: f64,
    pub roll_rate: f64,
    pub pitch_rate: f64,
}

impl BodyMotion {
    /// From the body's six coordinates and six velocities.
    #[inline]
    pub fn new(q: &[f64], v: &[f64]) -> Self {
        let frame = AxleFrame::new(q[3], q[4]);
        BodyMotion {
            position: Vector3::new(q[0], q[1], q[2]),
            velocity: Vector3::new(v[0], v[1], v[2]),
            frame_rotation: frame.axes * frame.frame_rate(v[3], v[4]),
            rotation: frame.axes * frame.body_rate(v[3], v[4], v[5]),
            frame,
            yaw: q[3],
            roll: q[4],
            yaw_rate: v[3],
            roll_rate: v[4],
            pitch_rate: v[5],
        }
    }

    /// Velocity of the body's material point at `point` [m, track frame].
    pub fn material_velocity(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.rotation.cross(&(point - self.position))
    }

    /// Track-frame position of a point that is given in axle axes and does not spin.
    pub fn axle_point(&self, local: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.frame.axes * local
    }

    /// Velocity of a point that moves with the axle but does not spin.
    pub fn axle_velocity(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.frame_rotation.cross(&(point - self.position))
    }

    /// A wrench's generalised force on the six coordinates: force, then moment about the axes of yaw, roll and pitch.
    #[inline]
    pub fn generalised_force(&self, wrench: &Wrench) -> Coefficients {
        let (force, moment) = (wrench.force, wrench.moment);
        let roll_axis = self.frame.axes.column(0);
        Coefficients::new(force.x, force.y, force.z, moment.z, roll_axis.dot(&moment), self.axle().dot(&moment))
    }

    /// Unit vector of the axle, pointing left.
    pub fn axle(&self) -> Vector3<f64> {
        self.frame.axes.column(1).into_owned()
    }
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

impl Body {
    /// Accelerations of the six coordinates under a wrench.
    #[inline]
    pub fn accelerations(&self, motion: &BodyMotion, wrench: &Wrench) -> [f64; COORDINATES] {
        let moment = motion.frame.axes.tr_mul(&wrench.moment);
        let (sin, cos) = (motion.frame.sin_roll, motion.frame.cos_roll);
        let (j, i) = (self.transverse_inertia, self.axial_inertia);
        let p = motion.roll_rate;
        let w = motion.yaw_rate * sin;
        let q = motion.pitch_rate + w;
        let r = motion.yaw_rate * cos;
        let p_dot = (moment.x - w * j * r + r * i * q) / j;
        let q_dot = moment.y / i;
        let r_dot = (moment.z - p * i * q + w * j * p) / j;
        // r = yaw' cos roll and q = pitch' + yaw' sin roll, differentiated.
        let yaw = (r_dot + motion.yaw_rate * sin * p) / cos;
        let pitch = q_dot - yaw * sin - motion.yaw_rate * cos * p;
        let linear = wrench.force / self.mass;
        [linear.x, linear.y, linear.z, yaw, p_dot, pitch]
    }

    /// Inverse of the mass matrix of the six coordinates. With s, c of roll, the kinetic energy of rotation is
    /// `(J (roll'^2 + c^2 yaw'^2) + I (pitch' + s yaw')^2) / 2`.
    #[inline]
    pub fn mobility(&self, motion: &BodyMotion) -> Mobility {
        let (sin, cos) = (motion.frame.sin_roll, motion.frame.cos_roll);
        let yaw = 1.0 / (self.transverse_inertia * cos * cos);
        let mut mobility = Mobility::zeros();
        for i in 0..3 {
            mobility[(i, i)] = 1.0 / self.mass;
        }
        mobility[(3, 3)] = yaw;
        mobility[(4, 4)] = 1.0 / self.transverse_inertia;
        mobility[(5, 5)] = 1.0 / self.axial_inertia + sin * sin * yaw;
        mobility[(3, 5)] = -sin * yaw;
        mobility[(5, 3)] = -sin * yaw;
        mobility
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, motion: &BodyMotion) -> f64 {
        let rate = motion.frame.body_rate(motion.yaw_rate, motion.roll_rate, motion.pitch_rate);
        0.5 * self.mass * motion.velocity.norm_squared()
            + 0.5 * (self.transverse_inertia * (rate.x * rate.x + rate.z * rate.z) + self.axial_inertia * rate.y * rate.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gyroscope() -> Body {
        Body { name: "gyroscope".into(), mass: 2.0, transverse_inertia: 3.0, axial_inertia: 1.2 }
    }

    /// Angular momentum in the track frame.
    fn momentum(body: &Body, q: &[f64], v: &[f64]) -> Vector3<f64> {
        let motion = BodyMotion::new(q, v);
        let rate = motion.frame.body_rate(v[3], v[4], v[5]);
        motion.frame.axes * Vector3::new(body.transverse_inertia * rate.x, body.axial_inertia * rate.y, body.transverse_inertia * rate.z)
    }

    #[test]
    fn analytic_rate_of_angular_momentum_is_the_moment() {
        let body = gyroscope();
        let q = [0.0, 0.0, 0.0, 0.4, -0.3, 1.0];
        let v = [0.0, 0.0, 0.0, 0.7, 0.5, 20.0];
        let wrench = Wrench { force: Vector3::zeros(), moment: Vector3::new(3.0, -2.0, 5.0) };
        let a = body.accelerations(&BodyMotion::new(&q, &v), &wrench);
        let h = 1e-6;
        let at = |h: f64| {
            let q: Vec<f64> = (0..6).map(|i| q[i] + h * v[i]).collect();
            let v: Vec<f64> = (0..6).map(|i| v[i] + h * a[i]).collect();
            momentum(&body, &q, &v)
        };
        assert!(((at(h) - at(-h)) / (2.0 * h) - wrench.moment).norm() < 1e-6);
    }

    #[test]
    fn analytic_mobility_turns_generalised_force_into_acceleration() {
        let body = gyroscope();
        let motion = BodyMotion::new(&[0.0, 0.0, 0.0, 0.4, -0.3, 1.0], &[1.0, 0.0, 2.0, 0.7, 0.5, 20.0]);
        let wrench = Wrench { force: Vector3::new(1.0, 2.0, -3.0), moment: Vector3::new(3.0, -2.0, 5.0) };
        let loaded = Coefficients::from(body.accelerations(&motion, &wrench));
        let free = Coefficients::from(body.accelerations(&motion, &Wrench::default()));
        let expected = body.mobility(&motion) * motion.generalised_force(&wrench);
        assert!((loaded - free - expected).norm() < 1e-13 * loaded.norm());
        // The work of the wrench is that of the generalised force.
        let power = wrench.force.dot(&motion.velocity) + wrench.moment.dot(&motion.rotation);
        let rates = Coefficients::new(1.0, 0.0, 2.0, 0.7, 0.5, 20.0);
        assert!((motion.generalised_force(&wrench).dot(&rates) - power).abs() < 1e-12 * power.abs());
        // The mass matrix, whose quadratic form is twice the kinetic energy.
        let mass = body.mobility(&motion).try_inverse().unwrap();
        assert!((0.5 * rates.dot(&(mass * rates)) - body.kinetic_energy(&motion)).abs() < 1e-12 * body.kinetic_energy(&motion));
    }

    #[test]
    fn analytic_free_spin_keeps_kinetic_energy() {
        // d(T)/dt = 0 without a wrench: the gyroscopic terms do no work.
        let body = gyroscope();
        let (q, v) = ([0.0, 0.0, 0.0, 0.4, -0.3, 1.0], [1.0, 0.0, 2.0, 0.7, 0.5, 20.0]);
        let a = body.accelerations(&BodyMotion::new(&q, &v), &Wrench::default());
        let h = 1e-6;
        let at = |h: f64| {
            let q: Vec<f64> = (0..6).map(|i| q[i] + h * v[i]).collect();
            let v: Vec<f64> = (0..6).map(|i| v[i] + h * a[i]).collect();
            body.kinetic_energy(&BodyMotion::new(&q, &v))
        };
        assert!(((at(h) - at(-h)) / (2.0 * h)).abs() < 1e-6);
    }
}
