//! Points on the surfaces of wheel and rail with tangents and second derivatives (Eqs. 2-8).
//!
//! All in the world's axes; on straight track they are those of the track frame.

use super::Side;
use super::profile::{Profile, ProfilePoint};
use nalgebra::{Matrix3, Vector3};

/// A point of a surface r(p, q) and its derivatives, all in the world.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// r, m.
    pub position: Vector3<f64>,
    /// Tangents dr/dp and dr/dq.
    pub t1: Vector3<f64>,
    pub t2: Vector3<f64>,
    /// Second derivatives d2r/dp2, d2r/dpdq, d2r/dq2.
    pub t11: Vector3<f64>,
    pub t12: Vector3<f64>,
    pub t22: Vector3<f64>,
}

/// Third derivatives of a surface that the equations use: d3r/dp3, d3r/dp2dq, d3r/dpdq2, d3r/dq3.
#[derive(Clone, Copy, Debug)]
pub struct ThirdDerivatives {
    pub t111: Vector3<f64>,
    pub t112: Vector3<f64>,
    pub t122: Vector3<f64>,
    pub t222: Vector3<f64>,
}

/// The wheel of one side of a wheelset.
#[derive(Clone, Debug)]
pub struct Wheel {
    pub side: Side,
    pub profile: std::sync::Arc<dyn Profile>,
    /// Distance of the tread circle from the wheelset's centre, m.
    pub half_spacing: f64,
}

impl Wheel {
    /// Has it the same profile as far from the middle, to whichever side?
    pub fn is_like(&self, other: &Wheel) -> bool {
        std::sync::Arc::ptr_eq(&self.profile, &other.profile) && self.half_spacing == other.half_spacing
    }

    /// Wheel surface over (u, angle): coordinate along the axle from the tread circle, outward positive [m], and
    /// angle about the axle from the lowest point, forward positive [rad].
    ///
    /// `r = centre + axes (R sin angle, side (half_spacing + u), -R cos angle)`: Eqs. 7 and 8, with the angle
    /// counted from below instead of above.
    #[inline]
    pub fn point(&self, centre: &Vector3<f64>, axes: &Matrix3<f64>, u: f64, angle: f64) -> (SurfacePoint, ProfilePoint) {
        let r = self.profile.at(u);
        let (sin, cos) = angle.sin_cos();
        let sign = self.side.sign();
        // Axes of the diametric section: radial direction at the angle, and the direction of growing angle.
        let radial = axes.column(0) * sin - axes.column(2) * cos;
        let around = axes.column(0) * cos + axes.column(2) * sin;
        let axle = axes.column(1) * sign;
        let point = SurfacePoint {
            position: centre + axle * (self.half_spacing + u) + radial * r.value,
            t1: axle + radial * r.d1,
            t2: around * r.value,
            t11: radial * r.d2,
            t12: around * r.d1,
            t22: radial * -r.value,
        };
        (point, r)
    }

    /// Third derivatives of the wheel surface at `angle` where its profile is `profile`.
    pub fn third_derivatives(&self, axes: &Matrix3<f64>, angle: f64, profile: &ProfilePoint) -> ThirdDerivatives {
        let (sin, cos) = angle.sin_cos();
        let radial = axes.column(0) * sin - axes.column(2) * cos;
        let around = axes.column(0) * cos + axes.column(2) * sin;
        ThirdDerivatives { t111: radial * profile.d3, t112: around * profile.d2, t122: radial * -profile.d1, t222: around * -profile.value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::track::centre_line::{Alignment, CentreLine, Node, Pivot};
    use crate::geometry::track::rail_surface::{rail_point, rail_third_derivatives};
    use crate::geometry::track::{Deviation, Direction, Rail};
    use crate::math::rotation::AxleFrame;
    use std::sync::Arc;

    /// Central differences of a surface against its analytic derivatives.
    fn check(surface: impl Fn(f64, f64) -> SurfacePoint, third: ThirdDerivatives, p: f64, q: f64) {
        let h = 1e-5;
        let point = surface(p, q);
        let along = |f: &dyn Fn(SurfacePoint) -> Vector3<f64>, dp: f64, dq: f64| {
            (f(surface(p + dp * h, q + dq * h)) - f(surface(p - dp * h, q - dq * h))) / (2.0 * h)
        };
        let near = |a: Vector3<f64>, b: Vector3<f64>, what: &str| assert!((a - b).norm() < 1e-8, "{what}: {a} {b}");
        near(point.t1, along(&|x| x.position, 1.0, 0.0), "t1");
        near(point.t2, along(&|x| x.position, 0.0, 1.0), "t2");
        near(point.t11, along(&|x| x.t1, 1.0, 0.0), "t11");
        near(point.t12, along(&|x| x.t1, 0.0, 1.0), "t12");
        near(point.t12, along(&|x| x.t2, 1.0, 0.0), "t21");
        near(point.t22, along(&|x| x.t2, 0.0, 1.0), "t22");
        near(third.t111, along(&|x| x.t11, 1.0, 0.0), "t111");
        near(third.t112, along(&|x| x.t11, 0.0, 1.0), "t112");
        near(third.t122, along(&|x| x.t22, 1.0, 0.0), "t122");
        near(third.t222, along(&|x| x.t22, 0.0, 1.0), "t222");
    }

    #[derive(Debug)]
    struct Bent;
    impl Profile for Bent {
        fn at(&self, x: f64) -> ProfilePoint {
            ProfilePoint { value: 0.46 - 0.1 * x - 2.0 * x * x + x * x * x, d1: -0.1 - 4.0 * x + 3.0 * x * x, d2: -4.0 + 6.0 * x, d3: 6.0 }
        }
        fn range(&self) -> (f64, f64) {
            (-1.0, 1.0)
        }
        fn describe(&self) -> String {
            "parabola".into()
        }
    }

    #[derive(Debug)]
    struct Wave;
    impl crate::geometry::track::DeviationShape for Wave {
        fn at(&self, s: f64) -> [f64; 4] {
            [0.02 * s.sin(), 0.02 * s.cos(), -0.02 * s.sin(), -0.02 * s.cos()]
        }
        fn waves(&self) -> Vec<crate::geometry::track::waves::Stretch> {
            Vec::new()
        }

        fn breaks(&self) -> Vec<f64> {
            vec![]
        }
        fn describe(&self) -> String {
            "wave".into()
        }
    }

    #[test]
    fn analytic_surface_derivatives_match_differences() {
        for side in Side::BOTH {
            let wheel = Wheel { side, profile: Arc::new(Bent), half_spacing: 0.716 };
            let frame = AxleFrame::new(0.03, -0.02);
            let third = wheel.third_derivatives(&frame.axes, 0.05, &Bent.at(0.01));
            check(|u, angle| wheel.point(&Vector3::new(1.0, 0.01, 0.45), &frame.axes, u, angle).0, third, 0.01, 0.05);

            let deviation = |direction| Deviation { side, direction, shape: Arc::new(Wave) };
            let rail = Rail::new(side, Arc::new(Bent), 0.716, 0.025, &[deviation(Direction::Lateral), deviation(Direction::Vertical)]);
            check(|s, eta| rail_point(&rail, s, eta).0, rail_third_derivatives(&rail, 0.8, 0.01, &Bent.at(0.01)), 0.8, 0.01);
            for ahead in [5e-6f64, -5e-6, 2e-3] {
                let (there, continued) = (rail.section(0.8 + ahead), rail.section(0.8).continued(ahead));
                let near = |error: Vector3<f64>, power: i32, factor: f64| {
                    assert!(error.norm() < 0.03 * ahead.abs().powi(power) / factor + 2e-16, "{ahead} {power}: {}", error.norm());
                };
                near(there.origin - continued.origin, 4, 24.0);
                near(there.d1 - continued.d1, 3, 6.0);
                near(there.d2 - continued.d2, 2, 2.0);
            }

            // The same on a track that bends, twists and climbs, more than any would.
            let node = |distance, curvature, superelevation, grade| Node { distance, curvature, superelevation, grade };
            let nodes = vec![node(-3.0, 0.02, -0.05, 0.0), node(0.0, -0.01, 0.1, 0.05), node(4.0, 0.05, -0.1, -0.04)];
            let alignment = Alignment { nodes, smoothing: 5.0, pivot: Pivot::LowRail { base: 1.5 } };
            let rail = rail.along(CentreLine::new(&alignment, Vector3::new(2.0, -1.0, 0.5), 0.7).map(Arc::new));
            for s in [-2.3, 0.8, 2.7] {
                let third = rail_third_derivatives(&rail, s, 0.01, &Bent.at(0.01));
                check(|s, eta| rail_point(&rail, s, eta).0, third, s, 0.01);
                let (h, section) = (1e-5, rail.section(s));
                let (point, profile) = rail_point(&rail, s, 0.01);
                assert!((section.tangent(0.01, profile.value) - point.t1).norm() < 1e-15);
                let (there, continued) = (rail.section(s + 1e-5), section.continued(1e-5));
                assert!((there.outward - continued.outward).norm() < 1e-11 && (there.up - continued.up).norm() < 1e-11);
                assert!((there.origin - continued.origin).norm() < 1e-15 && (there.d1 - continued.d1).norm() < 1e-14);
                let [ahead, behind] = [rail.section(s + h), rail.section(s - h)];
                for (a, b, d) in
                    [(ahead.origin, behind.origin, section.d1), (ahead.d1, behind.d1, section.d2), (ahead.d2, behind.d2, section.d3)]
                {
                    assert!(((a - b) / (2.0 * h) - d).norm() < 1e-8);
                }
            }
        }
    }

    #[test]
    fn analytic_rail_normal_leans_toward_the_centre() {
        for side in Side::BOTH {
            let rail = Rail::new(side, Arc::new(Bent), 0.716, 0.025, &[]);
            let normal = rail.up;
            assert!(normal.z > 0.0 && normal.y * side.sign() < 0.0);
            assert!((normal.y.abs() / normal.z - 0.025f64.tan()).abs() < 1e-15);
        }
    }
}
