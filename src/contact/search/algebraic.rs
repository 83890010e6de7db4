//! Contact location by the four algebraic equations of ECF-A (Eqs. 24-27), in full 3-D.
//!
//! Unknowns are the four surface parameters: wheel coordinate u, wheel angle, rail distance s, rail coordinate
//! eta. With r = r_wheel - r_rail, the rail's normal n (out of the rail) and the surfaces' tangents the equations
//! say that r is normal to the rail and the tangent planes are parallel:
//!
//! ```text
//! t_s . r = 0,   t_eta . r = 0,   t_u . n = 0,   t_angle . n = 0
//! ```
//!
//! As printed, row 2 of Eq. 24 uses the wheel's second tangent; at zero yaw that repeats row 1 (both are
//! longitudinal) and the system is singular, so the rail's lateral tangent stands here. The equations are solved
//! with n not normalised (same roots, polynomial derivatives); the penetration (Eq. 27) uses the unit normal:
//! `delta = -r . n`, positive when the surfaces overlap. Two of them are solved beforehand wherever that goes ([`super::section`]).

use crate::contact::normal::{ContactShape, ProfileSection};
use crate::geometry::profile::ProfilePoint;
use crate::geometry::surface::{SurfacePoint, Wheel};
use crate::geometry::track::Rail;
use crate::geometry::track::rail_surface::rail_point;
use crate::math::newton::{self, NewtonFailure, NewtonLimits};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Surface parameters of one contact; also the warm start of the next search.
///
/// The rail parameter is kept relative to the wheelset's own distance, so that it stays small while rolling.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SurfaceParameters {
    /// u, m.
    pub wheel: f64,
    /// Angle about the axle from the lowest point, forward positive, rad.
    pub angle: f64,
    /// Distance of the contact ahead of the wheelset's centre, m.
    pub lead: f64,
    /// eta, m.
    pub rail: f64,
}

/// Where the surfaces touch or come closest.
#[derive(Clone, Copy, Debug)]
pub struct ContactLocation {
    pub parameters: SurfaceParameters,
    /// Undeformed material point of the wheel, m.
    pub wheel_point: Vector3<f64>,
    /// Unit normal of the rail, out of it.
    pub normal: Vector3<f64>,
    /// Forward tangent of the rail (not normalised).
    pub forward: Vector3<f64>,
    /// delta, m; positive in contact.
    pub penetration: f64,
    pub wheel_profile: ProfilePoint,
    pub rail_profile: ProfilePoint,
    /// Newton iterations that were needed.
    pub iterations: usize,
}

impl ContactLocation {
    /// Half the relative principal curvatures A along e1 and B along e2, 1/m.
    ///
    /// Along e1 the wheel's circle (principal curvature `1 / (R sqrt(1 + R'^2))` of a surface of revolution) rolls
    /// on a rail whose curvature along X is neglected; along e2 wheel and rail profile add.
    pub fn half_curvatures(&self) -> (f64, f64) {
        let (wheel, rail) = (self.wheel_profile, self.rail_profile);
        let wheel_arc = 1.0 + wheel.d1 * wheel.d1;
        let rail_arc = 1.0 + rail.d1 * rail.d1;
        let rolling = 1.0 / (wheel.value * wheel_arc.sqrt());
        let across = -wheel.d2 / (wheel_arc * wheel_arc.sqrt()) - rail.d2 / (rail_arc * rail_arc.sqrt());
        (0.5 * rolling, 0.5 * across)
    }

    /// What a normal law may ask of this contact of `wheel` and `rail`.
    #[inline]
    pub fn shape<'a>(&self, wheel: &'a Wheel, rail: &'a Rail) -> ContactShape<'a> {
        let (rolling, across) = self.half_curvatures();
        let wheel = ProfileSection { profile: wheel.profile.as_ref(), at: self.parameters.wheel, point: self.wheel_profile };
        let rail = ProfileSection { profile: rail.profile.as_ref(), at: self.parameters.rail, point: self.rail_profile };
        ContactShape::new(rolling, across, wheel, rail)
    }
}

/// Lengths are of the order of a metre, so one number serves lengths and angles. An error of 1e-11 m in the place of the
/// contact changes the penetration by less than rounding and the creepage by less than 1e-12. Where a place is about to cease the equations
/// are singular; what is left then, 4e-12 m, is 4 mN of a normal force.
pub const LIMITS: NewtonLimits = NewtonLimits { next_step: 1e-11, iterations: 25, rounding: 4e-12 };

/// Everything that the equations take from the surfaces at one choice of parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub wheel: SurfacePoint,
    pub rail: SurfacePoint,
    pub wheel_profile: ProfilePoint,
    pub rail_profile: ProfilePoint,
    /// Wheel point minus rail point, m.
    pub gap: Vector3<f64>,
    /// Not normalised.
    pub normal: Vector3<f64>,
}

/// One wheel, one rail and where the wheelset stands.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    pub wheel: &'a Wheel,
    pub rail: &'a Rail,
    /// Position of the wheelset, m, and its frame that does not spin.
    pub centre: &'a Vector3<f64>,
    pub axes: &'a Matrix3<f64>,
    /// Place of the wheelset along the track, m.
    pub distance: f64,
}

impl Pair<'_> {
    /// Does the rail bend sideways so sharply here that a flange sees another rail ahead than that beside the wheel?
    #[inline]
    pub fn is_on_sharp_bend(&self) -> bool {
        self.rail.is_sharp_near(self.distance)
    }

    /// Residual of the four equations at `x = (u, angle, lead, eta)`.
    #[inline]
    pub(super) fn residual(&self, x: &Vector4<f64>) -> (Vector4<f64>, Candidate) {
        let (w, wheel_profile) = self.wheel.point(self.centre, self.axes, x[0], x[1]);
        let (r, rail_profile) = rail_point(self.rail, self.distance + x[2], x[3]);
        let gap = w.position - r.position;
        let normal = r.t1.cross(&r.t2) * self.rail.side.sign();
        let residual = Vector4::new(r.t1.dot(&gap), r.t2.dot(&gap), w.t1.dot(&normal), w.t2.dot(&normal));
        (residual, Candidate { wheel: w, rail: r, wheel_profile, rail_profile, gap, normal })
    }

    /// Derivatives of the rail's normal (not normalised) with respect to s and eta.
    #[inline]
    pub(super) fn normal_derivatives(&self, at: &Candidate) -> (Vector3<f64>, Vector3<f64>) {
        let (r, sign) = (&at.rail, self.rail.side.sign());
        // The mixed derivative of the rail is zero while sections stay parallel (straight track).
        ((r.t11.cross(&r.t2) + r.t1.cross(&r.t12)) * sign, (r.t12.cross(&r.t2) + r.t1.cross(&r.t22)) * sign)
    }

    /// Exact Jacobian of the residual (Eq. 26).
    #[inline]
    pub(super) fn jacobian(&self, at: &Candidate) -> Matrix4<f64> {
        let Candidate { wheel: w, rail: r, gap, normal, .. } = at;
        let (normal_s, normal_eta) = self.normal_derivatives(at);
        #[rustfmt::skip]
        let jacobian = Matrix4::new(
            r.t1.dot(&w.t1), r.t1.dot(&w.t2), r.t11.dot(gap) - r.t1.dot(&r.t1), r.t12.dot(gap) - r.t1.dot(&r.t2),
            r.t2.dot(&w.t1), r.t2.dot(&w.t2), r.t12.dot(gap) - r.t2.dot(&r.t1), r.t22.dot(gap) - r.t2.dot(&r.t2),
            w.t11.dot(normal), w.t12.dot(normal), w.t1.dot(&normal_s), w.t1.dot(&normal_eta),
            w.t12.dot(normal), w.t22.dot(normal), w.t2.dot(&normal_s), w.t2.dot(&normal_eta),
        );
        jacobian
    }
}

impl Candidate {
    #[inline]
    pub(super) fn location(&self, x: &Vector4<f64>, iterations: usize) -> ContactLocation {
        let normal = self.normal.normalize();
        ContactLocation {
            parameters: SurfaceParameters { wheel: x[0], angle: x[1], lead: x[2], rail: x[3] },
            wheel_point: self.wheel.position,
            normal,
            forward: self.rail.t1,
            penetration: -self.gap.dot(&normal),
            wheel_profile: self.wheel_profile,
            rail_profile: self.rail_profile,
            iterations,
        }
    }
}

impl Pair<'_> {
    /// The contact by Newton's method on all four equations.
    #[inline(never)]
    pub(super) fn solve_four(&self, start: &SurfaceParameters) -> Result<(ContactLocation, Candidate), NewtonFailure> {
        let mut x = Vector4::new(start.wheel, start.angle, start.lead, start.rail);
        // Far along the track distances are rounded more coarsely.
        let limits = NewtonLimits { next_step: LIMITS.next_step.max(4.0 * f64::EPSILON * self.distance.abs()), ..LIMITS };
        let (found, iterations) = newton::solve(&mut x, limits, |x| self.residual(x), |_, at| self.jacobian(at))?;
        Ok((found.location(&x, iterations), found))
    }

    /// What is at parameters that are known to solve the equations.
    pub fn at(&self, parameters: &SurfaceParameters) -> ContactLocation {
        let x = Vector4::new(parameters.wheel, parameters.angle, parameters.lead, parameters.rail);
        self.residual(&x).1.location(&x, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surfaces::{Parabola, locate, pair};
    use super::*;
    use crate::geometry::Side;
    use crate::geometry::track::Rail;
    use crate::math::rotation::AxleFrame;
    use std::sync::Arc;

    #[test]
    fn analytic_jacobian_matches_central_differences() {
        for side in Side::BOTH {
            let (wheel, rail) = pair(side, 0.05, true);
            let frame = AxleFrame::new(0.02, 0.01);
            let centre = Vector3::new(3.0, 0.004, 0.457);
            let x = Vector4::new(0.004, 0.01, 0.003, -0.006);
            let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &frame.axes, distance: 3.0 };
            let jacobian = pair.jacobian(&pair.residual(&x).1);
            for column in 0..4 {
                let mut step = Vector4::zeros();
                step[column] = 1e-6;
                let ahead = pair.residual(&(x + step)).0;
                let behind = pair.residual(&(x - step)).0;
                assert!(((ahead - behind) / 2e-6 - jacobian.column(column)).norm() < 1e-9, "{side:?} column {column}");
            }
        }
    }

    #[test]
    fn prop_solution_is_the_deepest_point_and_planes_are_parallel() {
        for side in Side::BOTH {
            for (yaw, roll, y, s) in [(0.0, 0.0, 0.0, 0.0), (0.02, 0.003, 0.006, 1.3), (-0.015, -0.004, -0.008, 4.0)] {
                let (wheel, rail) = pair(side, 0.05, true);
                let frame = AxleFrame::new(yaw, roll);
                let centre = Vector3::new(s, y, 0.457);
                let found = locate(&wheel, &rail, &centre, &frame.axes, s, &SurfaceParameters::default()).unwrap();
                let p = found.parameters;
                let tangents = wheel.point(&centre, &frame.axes, p.wheel, p.angle).0;
                assert!(tangents.t1.dot(&found.normal).abs() < 1e-10 && tangents.t2.dot(&found.normal).abs() < 1e-10);
                // No wheel point near by lies deeper below the rail's tangent plane at the contact.
                for (du, dangle) in [(1e-3, 0.0), (-1e-3, 0.0), (0.0, 2e-3), (0.0, -2e-3)] {
                    let other = wheel.point(&centre, &frame.axes, p.wheel + du, p.angle + dangle).0.position;
                    assert!((other - found.wheel_point).dot(&found.normal) > 1e-8, "{side:?} {du} {dangle}");
                }
            }
        }
    }

    #[test]
    fn analytic_yaw_moves_the_contact_ahead_by_radius_times_slope_times_yaw() {
        // Cone of slope 0.025: lead = R tan(slope) yaw to first order, ahead on the left for yaw > 0, behind on the right.
        for side in Side::BOTH {
            let wheel = Wheel { side, profile: Arc::new(Parabola { value: 0.457, slope: -0.025, curvature: 0.0 }), half_spacing: 0.716 };
            let head = Arc::new(Parabola { value: 0.0, slope: 0.0, curvature: -1.0 / 0.3 });
            let rail = Rail::new(side, head, 0.716, 0.025f64.atan(), &[]);
            let yaw = 1e-4;
            let found =
                locate(&wheel, &rail, &Vector3::new(0.0, 0.0, 0.457), &AxleFrame::new(yaw, 0.0).axes, 0.0, &SurfaceParameters::default())
                    .unwrap();
            let angle_lead = 0.457 * found.parameters.angle;
            assert!((angle_lead - side.sign() * 0.457 * 0.025 * yaw).abs() < 1e-9, "{side:?}: {angle_lead}");
        }
    }

    #[test]
    fn prop_mirrored_pose_gives_mirrored_contact() {
        let frame = |sign: f64| AxleFrame::new(sign * 0.01, sign * 0.003).axes;
        let solve = |side: Side, sign: f64| {
            let (wheel, rail) = pair(side, 0.05, false);
            locate(&wheel, &rail, &Vector3::new(0.0, sign * 0.004, 0.4569), &frame(sign), 0.0, &SurfaceParameters::default()).unwrap()
        };
        let (left, right) = (solve(Side::Left, 1.0), solve(Side::Right, -1.0));
        assert!((left.penetration - right.penetration).abs() < 1e-15);
        assert!((left.parameters.lead - right.parameters.lead).abs() < 1e-15);
        assert!((left.wheel_point.y + right.wheel_point.y).abs() < 1e-15);
    }
}
