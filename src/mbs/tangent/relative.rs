//! How the relative motion of two attachments, and the forces that follow it, change with the bodies' coordinates.
//!
//! An element between a (`from`) and b (`to`) sees the place p of b in the axes A of a's frame. With x the bodies' centres, rho = p - x_a,
//! r = p - x_b, and the axes e_1, e_2, e_3 about which yaw, roll and pitch turn (e_3 = 0 for a frame that does not spin with its
//! body):
//!
//! ```text
//! d = A^T rho,     d' = A^T w,  w = S v,     S = [-1, -e_j x rho | 1, e_j x r]     on (x_a, angles_a | x_b, angles_b)
//! Q = -S^T F,      F = A f                    generalised force of the force F on a and -F on b, both at p
//! dQ = -S^T A df - H(F) dq,  H(F) = second derivative of (A f) . rho with f held
//! A d(d') = S dv + R dq
//! ```
//!
//! A turned vector has the second derivatives `e_i x (e_j x r)`, i before j in the order yaw, roll, pitch. All of it is exact: also
//! what the lever arms and axes of the generalised force change by.

use crate::mbs::body::BodyMotion;
use crate::mbs::force::Attachment;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Something linear in the coordinates of `from` and of `to`.
pub type Gradient = [Vector6<f64>; 2];

/// Blocks on (row `from` or `to`, column `from` or `to`).
pub type Blocks = [[Matrix6<f64>; 2]; 2];

/// A body's frame that carries attachments, and a point in it.
#[derive(Clone, Copy, Debug)]
pub struct End {
    body: Option<usize>,
    /// Axes of yaw, roll and pitch; zero where the frame does not turn with the coordinate.
    axes: [Vector3<f64>; 3],
    /// Rates of these angles, rad/s.
    rates: [f64; 3],
    /// From the body's centre to the point, m.
    arm: Vector3<f64>,
    /// Of the frame at the body's centre, m/s and rad/s.
    velocity: Vector3<f64>,
    rotation: Vector3<f64>,
}

impl End {
    /// The frame of an attachment, and a point [m, world].
    #[inline]
    pub fn new(attachment: &Attachment, bodies: &[BodyMotion], point: &Vector3<f64>) -> End {
        match attachment.body {
            Some(body) => End { body: Some(body), ..End::of(&bodies[body], point) },
            None => End {
                body: None,
                axes: [Vector3::zeros(); 3],
                rates: [0.0; 3],
                arm: *point,
                velocity: Vector3::zeros(),
                rotation: Vector3::zeros(),
            },
        }
    }

    /// The same from the motion; without the body's number.
    #[inline]
    pub fn of(motion: &BodyMotion, point: &Vector3<f64>) -> End {
        let (pitch_axis, pitch_rate) = match motion.turn {
            Some(_) => (motion.axle(), motion.pitch_rate),
            None => (Vector3::zeros(), 0.0),
        };
        End {
            body: None,
            axes: [Vector3::z(), motion.roll_axis(), pitch_axis],
            rates: [motion.yaw_rate, motion.roll_rate, pitch_rate],
            arm: point - motion.position,
            velocity: motion.velocity,
            rotation: motion.frame_rotation,
        }
    }

    /// Generalised force of a force at the point.
    #[inline]
    pub fn generalised(&self, force: &Vector3<f64>) -> Vector6<f64> {
        let moment = self.arm.cross(force);
        let [yaw, roll, pitch] = self.axes.map(|axis| axis.dot(&moment));
        Vector6::new(force.x, force.y, force.z, yaw, roll, pitch)
    }

    /// Second derivatives of `direction . vector` by the angles, where `vector` turns with the frame.
    #[inline]
    fn second(&self, vector: &Vector3<f64>, direction: &Vector3<f64>) -> Matrix3<f64> {
        let mut second = Matrix3::zeros();
        for j in 0..3 {
            let turned = self.axes[j].cross(vector);
            for i in 0..=j {
                let value = direction.cross(&self.axes[i]).dot(&turned);
                second[(i, j)] = value;
                second[(j, i)] = value;
            }
        }
        second
    }

    /// Derivatives by the angles of the point's velocity relative to the body's centre, along `direction`.
    #[inline]
    pub fn arm_rate_by_angles(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.second_of_arm(direction) * Vector3::from(self.rates)
    }

    /// Second derivatives by the angles of the point along `direction`.
    #[inline]
    pub fn second_of_arm(&self, direction: &Vector3<f64>) -> Matrix3<f64> {
        self.second(&self.arm, direction)
    }

    /// Turning of the axes inside of angle j: what of the frame's angular velocity turns with it.
    #[inline]
    fn inner(&self, j: usize) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for i in j + 1..3 {
            sum += self.axes[i] * self.rates[i];
        }
        sum
    }

    /// d omega / d angle j, 1/s.
    #[inline]
    fn rotation_by_angle(&self, j: usize) -> Vector3<f64> {
        self.axes[j].cross(&self.inner(j))
    }
}

/// Two ends that meet in the place of `to`.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    ends: [End; 2],
    /// w, m/s, world axes.
    relative_velocity: Vector3<f64>,
}

impl Pair {
    #[inline]
    pub fn new(from: &Attachment, to: &Attachment, bodies: &[BodyMotion]) -> Pair {
        let point = to.point(bodies);
        let [a, b] = [End::new(from, bodies, &point), End::new(to, bodies, &point)];
        let relative_velocity = b.velocity + b.rotation.cross(&b.arm) - a.velocity - a.rotation.cross(&a.arm);
        Pair { ends: [a, b], relative_velocity }
    }

    #[inline]
    pub fn bodies(&self) -> [Option<usize>; 2] {
        [self.ends[0].body, self.ends[1].body]
    }

    /// Part of w across e, m/s.
    #[inline]
    pub fn velocity_across(&self, e: &Vector3<f64>) -> Vector3<f64> {
        self.relative_velocity - e * e.dot(&self.relative_velocity)
    }

    /// S^T e.
    #[inline]
    pub fn gradient(&self, e: &Vector3<f64>) -> Gradient {
        [-self.ends[0].generalised(e), self.ends[1].generalised(e)]
    }

    /// R^T e.
    #[inline]
    pub fn rate_gradient(&self, e: &Vector3<f64>) -> Gradient {
        let [a, b] = &self.ends;
        let swing = a.rotation.cross(e);
        let own = b.arm_rate_by_angles(e);
        let mut gradient = [Vector6::zeros(); 2];
        for i in 0..3 {
            gradient[0][i] = -swing[i];
            gradient[1][i] = swing[i];
        }
        for j in 0..3 {
            gradient[1][3 + j] = own[j] + swing.dot(&b.axes[j].cross(&b.arm));
            let turned = a.inner(j).cross(&a.axes[j]).cross(&a.arm) - a.axes[j].cross(&self.relative_velocity);
            gradient[0][3 + j] = e.dot(&turned);
        }
        gradient
    }

    /// H(F) of the force F [N] on a.
    #[inline]
    pub fn hessian(&self, force: &Vector3<f64>) -> Blocks {
        let [a, b] = &self.ends;
        let mut blocks = [[Matrix6::zeros(); 2]; 2];
        for j in 0..3 {
            let turned = a.axes[j].cross(force);
            for i in 0..3 {
                blocks[0][0][(i, 3 + j)] = -turned[i];
                blocks[0][0][(3 + j, i)] = -turned[i];
                blocks[1][0][(i, 3 + j)] = turned[i];
                blocks[0][1][(3 + j, i)] = turned[i];
                let both = turned.dot(&b.axes[i].cross(&b.arm));
                blocks[1][0][(3 + i, 3 + j)] = both;
                blocks[0][1][(3 + j, 3 + i)] = both;
            }
        }
        blocks[0][0].fixed_view_mut::<3, 3>(3, 3).copy_from(&a.second(force, &a.arm));
        blocks[1][1].fixed_view_mut::<3, 3>(3, 3).copy_from(&b.second_of_arm(force));
        blocks
    }

    /// Coefficients on the velocities of the component along e of the angular velocity of `to` relative to `from`.
    #[inline]
    pub fn turn_gradient(&self, e: &Vector3<f64>) -> Gradient {
        let part = |end: &End, sign: f64| {
            let [yaw, roll, pitch] = end.axes.map(|axis| sign * axis.dot(e));
            Vector6::new(0.0, 0.0, 0.0, yaw, roll, pitch)
        };
        [part(&self.ends[0], -1.0), part(&self.ends[1], 1.0)]
    }

    /// Change with the coordinates of the component of that angular velocity along e, where e is fixed in `from`.
    #[inline]
    pub fn turn_rate_gradient(&self, e: &Vector3<f64>) -> Gradient {
        let [a, b] = &self.ends;
        let relative = b.rotation - a.rotation;
        let mut gradient = [Vector6::zeros(); 2];
        for j in 0..3 {
            gradient[0][3 + j] = -e.dot(&(a.rotation_by_angle(j) + a.axes[j].cross(&relative)));
            gradient[1][3 + j] = e.dot(&b.rotation_by_angle(j));
        }
        gradient
    }

    /// Change with the coordinates of the generalised force of a couple M [N m] on `from` and -M on `to`, where M is fixed in `from`.
    #[inline]
    pub fn couple_by_coordinates(&self, couple: &Vector3<f64>) -> Blocks {
        let [a, b] = &self.ends;
        let mut blocks = [[Matrix6::zeros(); 2]; 2];
        for j in 0..3 {
            let turned = a.axes[j].cross(couple);
            for i in 0..3 {
                // Each axis turns with the angles outside of it, the couple with all of a.
                let moved = |end: &End| if j < i { end.axes[j].cross(&end.axes[i]).dot(couple) } else { 0.0 };
                blocks[0][0][(3 + i, 3 + j)] = a.axes[i].dot(&turned) + moved(a);
                blocks[1][0][(3 + i, 3 + j)] = -b.axes[i].dot(&turned);
                blocks[1][1][(3 + i, 3 + j)] = -moved(b);
            }
        }
        blocks
    }
}
