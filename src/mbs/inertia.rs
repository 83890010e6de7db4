//! How a rigid body resists rotation.
//!
//! A body of revolution (transverse inertia J, axial inertia I) has the same inertia about every axis across the
//! axle, so its equations are written in the axle frame `Rz Rx`. With the body's angular velocity `(p, q, r)` and
//! the frame's `(p, w, r)` in that frame and moment M about the centre:
//!
//! ```text
//! J p' = Mx - w J r + r I q,     I q' = My,     J r' = Mz - p I q + w J p
//! p = roll',  w = yaw' sin roll,  q = pitch' + w,  r = yaw' cos roll
//! ```
//!
//! Without gyroscopic moments the frame's w stands for q in the products: the angular momentum I pitch' of the spin turns with the axle and nothing
//! resists. The rate of the kinetic energy stays the moment's power.
//!
//! Any other body has the principal inertias T = diag(Ixx, Iyy, Izz) about its own axes `Rz Rx Ry` and obeys
//! Euler's equations in them, `T o' = M - o x T o`; the components of its angular acceleration in the axle frame,
//! less the turning of that frame, `(p, w, r) x (p, q, r)`, are `(p', q', r')`.

use super::motion::{BodyMotion, turn_about_y};
use nalgebra::{Matrix3, Vector3};

/// Moments of inertia about axes through the centre of mass, kg m2.
#[derive(Clone, Debug, PartialEq)]
pub enum Inertia {
    /// A body of revolution about its Y axis, which may spin.
    Revolution {
        /// J, about any axis across the axle.
        transverse: f64,
        /// I, about the axle.
        axial: f64,
    },
    /// The same, but its spin makes no gyroscopic moments: what a scene with `effects.gyroscopic = "off"` leaves out.
    NotGyroscopic {
        /// J, about any axis across the axle.
        transverse: f64,
        /// I, about the axle.
        axial: f64,
    },
    /// Principal axes along the body's axes.
    General {
        /// Ixx, Iyy, Izz.
        principal: Vector3<f64>,
    },
}

impl Inertia {
    /// Ixx, Iyy, Izz of the body in its design configuration.
    pub fn moments(&self) -> [f64; 3] {
        match *self {
            Inertia::Revolution { transverse, axial } | Inertia::NotGyroscopic { transverse, axial } => [transverse, axial, transverse],
            Inertia::General { principal } => principal.into(),
        }
    }

    /// Accelerations of yaw, roll and pitch under a moment [N m, track frame].
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn accelerations(&self, motion: &BodyMotion, moment: &Vector3<f64>) -> [f64; 3] {
        let (sin, cos) = (motion.frame.sin_roll, motion.frame.cos_roll);
        let p = motion.roll_rate;
        let [p_dot, q_dot, r_dot] = match self {
            Inertia::Revolution { transverse: j, axial: i } => {
                let moment = motion.frame.axes.tr_mul(moment);
                let w = motion.yaw_rate * sin;
                let q = motion.pitch_rate + w;
                let r = motion.yaw_rate * cos;
                [(moment.x - w * j * r + r * i * q) / j, moment.y / i, (moment.z - p * i * q + w * j * p) / j]
            }
            Inertia::NotGyroscopic { transverse: j, axial: i } => {
                let moment = motion.frame.axes.tr_mul(moment);
                let (w, r) = (motion.yaw_rate * sin, motion.yaw_rate * cos);
                [(moment.x + w * (i - j) * r) / j, moment.y / i, (moment.z - w * (i - j) * p) / j]
            }
            Inertia::General { principal } => general_rates(principal, motion, moment).into(),
        };
        // r = yaw' cos roll and q = pitch' + yaw' sin roll, differentiated.
        let yaw = (r_dot + motion.yaw_rate * sin * p) / cos;
        let pitch = q_dot - yaw * sin - motion.yaw_rate * cos * p;
        [yaw, p_dot, pitch]
    }

    /// Inverse of the mass matrix of yaw, roll and pitch. With s, c of roll, a body of revolution has the kinetic
    /// energy `(J (roll'^2 + c^2 yaw'^2) + I (pitch' + s yaw')^2) / 2`.
    #[inline]
    pub fn mobility(&self, motion: &BodyMotion) -> Matrix3<f64> {
        let (sin, cos) = (motion.frame.sin_roll, motion.frame.cos_roll);
        match self {
            Inertia::Revolution { transverse, axial } | Inertia::NotGyroscopic { transverse, axial } => {
                let yaw = 1.0 / (transverse * cos * cos);
                let pitch = 1.0 / axial + sin * sin * yaw;
                Matrix3::new(yaw, 0.0, -sin * yaw, 0.0, 1.0 / transverse, 0.0, -sin * yaw, 0.0, pitch)
            }
            Inertia::General { principal } => {
                // (yaw', roll', pitch') from the angular velocity in body axes, by way of the axle frame.
                let from_frame = Matrix3::new(0.0, 0.0, 1.0 / cos, 1.0, 0.0, 0.0, 0.0, 1.0, -sin / cos);
                let from_body = from_frame * turn_about_y(motion.turn.unwrap_or((0.0, 1.0)));
                from_body * Matrix3::from_diagonal(&principal.map(|i| 1.0 / i)) * from_body.transpose()
            }
        }
    }

    /// Kinetic energy of the rotation, J.
    pub fn kinetic_energy(&self, motion: &BodyMotion) -> f64 {
        match self {
            Inertia::Revolution { transverse, axial } | Inertia::NotGyroscopic { transverse, axial } => {
                let rate = motion.frame.body_rate(motion.yaw_rate, motion.roll_rate, motion.pitch_rate);
                0.5 * (transverse * (rate.x * rate.x + rate.z * rate.z) + axial * rate.y * rate.y)
            }
            Inertia::General { principal } => {
                let rate = motion.frame.axes.tr_mul(&motion.rotation);
                0.5 * principal.component_mul(&rate).dot(&rate)
            }
        }
    }
}

/// p', q', r' of a general body.
#[inline(never)]
fn general_rates(principal: &Vector3<f64>, motion: &BodyMotion, moment: &Vector3<f64>) -> Vector3<f64> {
    let axes = motion.frame.axes;
    let rate = axes.tr_mul(&motion.rotation);
    let momentum = principal.component_mul(&rate);
    let acceleration = (axes.tr_mul(moment) - rate.cross(&momentum)).component_div(principal);
    let frame_rate = motion.frame.frame_rate(motion.yaw_rate, motion.roll_rate);
    let body_rate = motion.frame.body_rate(motion.yaw_rate, motion.roll_rate, motion.pitch_rate);
    turn_about_y(motion.turn.unwrap_or((0.0, 1.0))) * acceleration - frame_rate.cross(&body_rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mbs::body::{Body, Wrench};
    use crate::mbs::kkt::Coefficients;

    const Q: [f64; 6] = [0.0, 0.0, 0.0, 0.4, -0.3, 1.0];
    const V: [f64; 6] = [1.0, 0.0, 2.0, 0.7, 0.5, 20.0];

    fn bodies() -> [Body; 2] {
        let body = |name: &str, inertia| Body { name: name.into(), mass: 2.0, inertia };
        [
            body("gyroscope", Inertia::Revolution { transverse: 3.0, axial: 1.2 }),
            body("brick", Inertia::General { principal: Vector3::new(3.0, 1.2, 2.1) }),
        ]
    }

    fn wrench() -> Wrench {
        Wrench { force: Vector3::new(1.0, 2.0, -3.0), moment: Vector3::new(3.0, -2.0, 5.0) }
    }

    /// Central difference of something along the motion with the body's accelerations.
    fn rate<T: std::ops::Sub<Output = T> + std::ops::Div<f64, Output = T>>(
        body: &Body,
        wrench: &Wrench,
        of: impl Fn(&BodyMotion) -> T,
    ) -> T {
        let a = body.accelerations(&body.motion(&Q, &V), wrench);
        let h = 1e-6;
        let at = |h: f64| {
            let q: Vec<f64> = (0..6).map(|i| Q[i] + h * V[i]).collect();
            let v: Vec<f64> = (0..6).map(|i| V[i] + h * a[i]).collect();
            of(&body.motion(&q, &v))
        };
        (at(h) - at(-h)) / (2.0 * h)
    }

    #[test]
    fn analytic_rate_of_angular_momentum_is_the_moment() {
        for body in bodies() {
            let momentum = |motion: &BodyMotion| match &body.inertia {
                Inertia::Revolution { transverse: j, axial: i } | Inertia::NotGyroscopic { transverse: j, axial: i } => {
                    let axes = motion.frame.axes;
                    axes * axes.tr_mul(&motion.rotation).component_mul(&Vector3::new(*j, *i, *j))
                }
                Inertia::General { principal } => motion.frame.axes * motion.frame.axes.tr_mul(&motion.rotation).component_mul(principal),
            };
            let error = (rate(&body, &wrench(), momentum) - wrench().moment).norm();
            println!("{}: {error:.1e} N m", body.name);
            assert!(error < 1e-6, "{}: {error}", body.name);
        }
    }

    #[test]
    fn analytic_free_rotation_keeps_kinetic_energy() {
        for body in bodies() {
            let power = rate(&body, &Wrench::default(), |motion| body.kinetic_energy(motion));
            assert!(power.abs() < 1e-6, "{}: {power} W", body.name);
        }
    }

    #[test]
    fn equiv_a_general_body_with_equal_inertias_is_one_of_revolution() {
        let [round, _] = bodies();
        let general = Body { inertia: Inertia::General { principal: Vector3::new(3.0, 1.2, 3.0) }, ..round.clone() };
        let (a, b) = (round.motion(&Q, &V), general.motion(&Q, &V));
        let difference = Coefficients::from(round.accelerations(&a, &wrench())) - Coefficients::from(general.accelerations(&b, &wrench()));
        assert!(difference.norm() < 1e-13 * 20.0, "{difference}");
        assert!((round.mobility(&a) - general.mobility(&b)).norm() < 1e-14);
        assert!((round.kinetic_energy(&a) - general.kinetic_energy(&b)).abs() < 1e-12);
        // Only the attachments differ.
        assert!((b.frame.axes - a.frame.axes).norm() > 0.1 && (b.frame_rotation - a.rotation).norm() == 0.0);
    }

    #[test]
    fn analytic_what_is_left_out_is_the_moment_that_turns_the_spin() {
        let [round, _] = bodies();
        let still = Body { inertia: Inertia::NotGyroscopic { transverse: 3.0, axial: 1.2 }, ..round.clone() };
        let motion = round.motion(&Q, &V);
        // The spin's angular momentum I pitch' lies along the axle, which turns with the frame: frame rate x momentum must be put in.
        let axes = motion.frame.axes;
        let turning = axes * motion.frame.frame_rate(motion.yaw_rate, motion.roll_rate);
        let moment = turning.cross(&(axes.column(1) * (1.2 * motion.pitch_rate)));
        assert!(moment.norm() > 10.0);
        let pushed = Wrench { moment: wrench().moment + moment, ..wrench() };
        let difference =
            Coefficients::from(round.accelerations(&motion, &pushed)) - Coefficients::from(still.accelerations(&motion, &wrench()));
        assert!(difference.norm() < 1e-12, "{difference}");
        let power = rate(&still, &Wrench::default(), |motion| still.kinetic_energy(motion));
        assert!(power.abs() < 1e-6, "it does no work: {power} W");
    }

    #[test]
    fn analytic_mobility_turns_generalised_force_into_acceleration() {
        for body in bodies() {
            let motion = body.motion(&Q, &V);
            let loaded = Coefficients::from(body.accelerations(&motion, &wrench()));
            let free = Coefficients::from(body.accelerations(&motion, &Wrench::default()));
            let expected = body.mobility(&motion) * motion.generalised_force(&wrench());
            assert!((loaded - free - expected).norm() < 1e-13 * loaded.norm());
            // The work of the wrench is that of the generalised force.
            let power = wrench().force.dot(&motion.velocity) + wrench().moment.dot(&motion.rotation);
            let rates = Coefficients::from(V);
            assert!((motion.generalised_force(&wrench()).dot(&rates) - power).abs() < 1e-12 * power.abs());
            // The mass matrix, whose quadratic form is twice the kinetic energy.
            let mass = body.mobility(&motion).try_inverse().unwrap();
            let energy = body.kinetic_energy(&motion);
            assert!((0.5 * rates.dot(&(mass * rates)) - energy).abs() < 1e-12 * energy);
        }
    }
}
