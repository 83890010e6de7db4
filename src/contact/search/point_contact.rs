//! The five constraints of non-conformal contact with the surface parameters as unknowns of their own (Eqs. 9-12).
//!
//! With r = r_wheel - r_rail, the rail's tangents t_s, t_eta and normal m (not normalised), the wheel's tangents t_u, t_angle:
//!
//! ```text
//! C1 = t_s . r,   C2 = t_eta . r,   C3 = m . r,   C4 = t_u . m,   C5 = t_angle . m
//! ```
//!
//! Eq. 10 is printed without its fifth row. Surface parameters are `(u, angle, s, eta)`; s is the distance along the track.
//! Derivatives with respect to the wheelset are given on the axle frame's velocity v and angular velocity W: row i changes
//! at fixed parameters with `force_i . v + moment_i . W`.

use super::algebraic::{Candidate, Pair};
use crate::geometry::track::rail_surface::rail_third_derivatives;
use crate::math::rotation::CarrierMotion;
use nalgebra::{SMatrix, SVector, Vector3, Vector4};

/// Number of constraints per contact, and of surface parameters.
pub const CONSTRAINTS: usize = 5;
pub const PARAMETERS: usize = 4;

pub type Residual = SVector<f64, CONSTRAINTS>;
/// C_s: constraints by surface parameters.
pub type ParameterJacobian = SMatrix<f64, CONSTRAINTS, PARAMETERS>;

/// Residual and first derivatives at one choice of parameters.
#[derive(Clone, Copy, Debug)]
pub struct PointContact {
    at: Candidate,
    parameters: Vector4<f64>,
    pub residual: Residual,
    /// C_s.
    pub by_parameters: ParameterJacobian,
    /// Derivatives with respect to v and W.
    pub by_velocity: [Vector3<f64>; CONSTRAINTS],
    pub by_rotation: [Vector3<f64>; CONSTRAINTS],
}

impl Pair<'_> {
    /// Evaluates the constraints at `(u, angle, s, eta)`.
    #[inline]
    pub fn point_contact(&self, parameters: &Vector4<f64>) -> PointContact {
        let x = Vector4::new(parameters[0], parameters[1], parameters[2] - self.distance, parameters[3]);
        let (four, at) = self.residual(&x);
        let jacobian = self.jacobian(&at);
        let Candidate { wheel: w, rail: r, gap, normal, .. } = &at;
        let arm = w.position - self.centre;
        let (normal_s, normal_eta) = self.normal_derivatives(&at);
        let mut by_parameters = ParameterJacobian::zeros();
        for (row, four) in [(0, 0), (1, 1), (3, 2), (4, 3)] {
            by_parameters.set_row(row, &jacobian.row(four));
        }
        let third = [normal.dot(&w.t1), normal.dot(&w.t2), normal_s.dot(gap) - normal.dot(&r.t1), normal_eta.dot(gap) - normal.dot(&r.t2)];
        by_parameters.set_row(2, &third.into());
        let zero = Vector3::zeros();
        PointContact {
            residual: Residual::new(four[0], four[1], normal.dot(gap), four[2], four[3]),
            by_parameters,
            by_velocity: [r.t1, r.t2, *normal, zero, zero],
            by_rotation: [arm.cross(&r.t1), arm.cross(&r.t2), arm.cross(normal), w.t1.cross(normal), w.t2.cross(normal)],
            parameters: x,
            at,
        }
    }

    /// Second time derivatives of the constraints when neither coordinates nor parameters accelerate: -Q_c of Eq. 12.
    ///
    /// `rates` are those of (u, angle, s, eta).
    pub fn bias(&self, contact: &PointContact, rates: &Vector4<f64>, carrier: &CarrierMotion) -> Residual {
        let Candidate { wheel: w, rail: r, wheel_profile, rail_profile, gap, normal } = &contact.at;
        let wheel3 = self.wheel.third_derivatives(self.axes, contact.parameters[1], wheel_profile);
        let rail3 = rail_third_derivatives(self.rail, self.distance + contact.parameters[2], contact.parameters[3], rail_profile);
        let [u, angle, s, eta] = [rates[0], rates[1], rates[2], rates[3]];
        let carried = |vector: &Vector3<f64>, own1: Vector3<f64>, own2: Vector3<f64>| {
            let turned = carrier.rotation.cross(vector);
            let first = turned + own1;
            let second = carrier.rotation_bias.cross(vector) + carrier.rotation.cross(&(turned + own1 * 2.0)) + own2;
            (first, second)
        };
        let quadratic = |a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>, p: f64, q: f64| a * (p * p) + b * (2.0 * p * q) + c * (q * q);

        let arm = w.position - self.centre;
        let (arm1, arm2) = carried(&arm, w.t1 * u + w.t2 * angle, quadratic(w.t11, w.t12, w.t22, u, angle));
        let (tu1, tu2) = carried(&w.t1, w.t11 * u + w.t12 * angle, quadratic(wheel3.t111, wheel3.t112, wheel3.t122, u, angle));
        let (ta1, ta2) = carried(&w.t2, w.t12 * u + w.t22 * angle, quadratic(wheel3.t112, wheel3.t122, wheel3.t222, u, angle));
        let gap1 = carrier.velocity + arm1 - r.t1 * s - r.t2 * eta;
        let gap2 = arm2 - quadratic(r.t11, r.t12, r.t22, s, eta);
        let (ts1, ts2) = (r.t11 * s + r.t12 * eta, quadratic(rail3.t111, rail3.t112, rail3.t122, s, eta));
        let (te1, te2) = (r.t12 * s + r.t22 * eta, quadratic(rail3.t112, rail3.t122, rail3.t222, s, eta));
        let sign = self.rail.side.sign();
        let normal1 = (ts1.cross(&r.t2) + r.t1.cross(&te1)) * sign;
        let normal2 = (ts2.cross(&r.t2) + ts1.cross(&te1) * 2.0 + r.t1.cross(&te2)) * sign;
        let product = |a: &Vector3<f64>, a1: &Vector3<f64>, a2: &Vector3<f64>, b: &Vector3<f64>, b1: &Vector3<f64>, b2: &Vector3<f64>| {
            a2.dot(b) + 2.0 * a1.dot(b1) + a.dot(b2)
        };
        Residual::new(
            product(&r.t1, &ts1, &ts2, gap, &gap1, &gap2),
            product(&r.t2, &te1, &te2, gap, &gap1, &gap2),
            product(normal, &normal1, &normal2, gap, &gap1, &gap2),
            product(&w.t1, &tu1, &tu2, normal, &normal1, &normal2),
            product(&w.t2, &ta1, &ta2, normal, &normal1, &normal2),
        )
    }

    /// The point as a located contact, for the laws of contact.
    pub fn location(&self, contact: &PointContact) -> super::algebraic::ContactLocation {
        contact.at.location(&contact.parameters, 0)
    }
}

impl PointContact {
    /// |m|.
    pub fn normal_length(&self) -> f64 {
        self.at.normal.norm()
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surfaces::{Wave, pair};
    use super::*;
    use crate::geometry::Side;
    use crate::math::rotation::AxleFrame;

    /// Position, yaw and roll of a wheelset that moves without accelerating in its coordinates.
    struct Path {
        centre: Vector3<f64>,
        velocity: Vector3<f64>,
        angles: [f64; 2],
        angle_rates: [f64; 2],
        parameters: Vector4<f64>,
        rates: Vector4<f64>,
    }

    impl Path {
        fn example(side: Side) -> Path {
            Path {
                centre: Vector3::new(3.0, 0.004, 0.4571),
                velocity: Vector3::new(20.0, 0.3, -0.2),
                angles: [0.02, 0.01],
                angle_rates: [0.4, -0.3],
                parameters: Vector4::new(0.004, 0.01, 3.003, -0.006),
                rates: Vector4::new(0.2, 0.3, 20.1, side.sign() * 0.15),
            }
        }

        fn at(&self, side: Side, t: f64) -> (PointContact, Residual) {
            let (wheel, rail) = pair(side, 0.05, true);
            let centre = self.centre + self.velocity * t;
            let frame = AxleFrame::new(self.angles[0] + t * self.angle_rates[0], self.angles[1] + t * self.angle_rates[1]);
            let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &frame.axes, distance: centre.x };
            let contact = pair.point_contact(&(self.parameters + self.rates * t));
            let rotation = frame.axes * frame.frame_rate(self.angle_rates[0], self.angle_rates[1]);
            let bias = Vector3::z().cross(&frame.axes.column(0)) * (self.angle_rates[0] * self.angle_rates[1]);
            let carrier = CarrierMotion { velocity: self.velocity, rotation, rotation_bias: bias };
            (contact, pair.bias(&contact, &self.rates, &carrier))
        }
    }

    #[test]
    fn analytic_derivatives_along_a_motion_match_differences() {
        for side in Side::BOTH {
            let path = Path::example(side);
            let (contact, bias) = path.at(side, 0.0);
            let value = |t: f64| path.at(side, t).0.residual;
            let h = 1e-5;
            let first = (value(h) - value(-h)) / (2.0 * h);
            let rotation = AxleFrame::new(path.angles[0], path.angles[1]);
            let rotation = rotation.axes * rotation.frame_rate(path.angle_rates[0], path.angle_rates[1]);
            let mut expected = contact.by_parameters * path.rates;
            for i in 0..CONSTRAINTS {
                expected[i] += contact.by_velocity[i].dot(&path.velocity) + contact.by_rotation[i].dot(&rotation);
            }
            assert!((first - expected).norm() < 1e-7 * expected.norm(), "{side:?}: {first} {expected}");
            let h = 2e-4;
            // Fourth order, so that rounding and truncation both stay small.
            let second = (-value(2.0 * h) + 16.0 * value(h) - 30.0 * value(0.0) + 16.0 * value(-h) - value(-2.0 * h)) / (12.0 * h * h);
            for i in 0..CONSTRAINTS {
                assert!((second[i] - bias[i]).abs() < 1e-5 * (1.0 + bias[i].abs()), "{side:?} row {i}: {} {}", second[i], bias[i]);
            }
        }
    }

    #[test]
    fn prop_the_wave_has_the_derivatives_that_it_states() {
        use crate::geometry::track::DeviationShape;
        let (h, s) = (1e-4, 0.7);
        let [_, d1, d2, d3] = Wave.at(s);
        let [ahead, behind] = [Wave.at(s + h), Wave.at(s - h)];
        for (order, exact) in [(0, d1), (1, d2), (2, d3)] {
            assert!(((ahead[order] - behind[order]) / (2.0 * h) - exact).abs() < 1e-8);
        }
    }
}
