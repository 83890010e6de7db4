//! How a located contact moves with its wheelset: derivatives of its place, its normal and its forward tangent.
//!
//! The wheelset is displaced by a small translation d and a small rotation vector w (world axes, about its centre). The surface
//! parameters s follow from the four equations E(s, pose) = 0 of [`super::algebraic`] (Eq. 24), so that (compare
//! [`super::kinematics`])
//!
//! ```text
//! ds = -(dE/ds)^-1 dE,   dE1 = t_s . (d + w x rho),   dE2 = t_eta . (d + w x rho),   dE3 = (w x t_u) . m,   dE4 = (w x t_angle) . m
//! d rho = w x rho + t_u du + t_angle d angle                       rho: from the centre to the wheel's point
//! dn    = (dm - n (n . dm)) / |m|,   dm = m_s ds + m_eta d eta     m: the rail's normal before normalising
//! de1   = (dt - e1 (e1 . dt)) / |t_s|,   dt = t_ss ds + t_seta d eta
//! ```
//!
//! All exact. The penetration needs none of it: `d delta = -n . (d + w x rho)`, because the located points make it stationary.

use super::algebraic::{ContactLocation, Pair, SurfaceParameters};
use nalgebra::{SMatrix, Vector3, Vector4};

/// Derivatives of a vector with respect to translation [m] and rotation vector [rad] of the wheelset.
pub type ByPose = SMatrix<f64, 3, 6>;

/// The contact with its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Wander {
    /// The contact at the given parameters.
    pub location: ContactLocation,
    /// rho, m.
    pub arm: Vector3<f64>,
    /// Of the surface parameters u, angle, distance along the rail, eta.
    pub parameters: SMatrix<f64, 4, 6>,
    /// Of rho.
    pub arm_by_pose: ByPose,
    /// Of the unit normal.
    pub normal_by_pose: ByPose,
    /// Of the unit forward tangent.
    pub forward_by_pose: ByPose,
}

/// Translation and rotation parts next to each other.
fn row(translation: Vector3<f64>, rotation: Vector3<f64>) -> [f64; 6] {
    [translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z]
}

impl Pair<'_> {
    /// Derivatives at a contact with these parameters. Where dE/ds is singular the contact is taken to stay where it is on both
    /// surfaces.
    pub fn wander(&self, parameters: &SurfaceParameters) -> Wander {
        let x = Vector4::new(parameters.wheel, parameters.angle, parameters.lead, parameters.rail);
        let (_, at) = self.residual(&x);
        let location = at.location(&x, 0);
        let (wheel, rail, normal) = (&at.wheel, &at.rail, location.normal);
        let arm = wheel.position - self.centre;
        let rows = [
            row(rail.t1, arm.cross(&rail.t1)),
            row(rail.t2, arm.cross(&rail.t2)),
            row(Vector3::zeros(), wheel.t1.cross(&at.normal)),
            row(Vector3::zeros(), wheel.t2.cross(&at.normal)),
        ];
        let explicit = SMatrix::<f64, 4, 6>::from_fn(|i, j| rows[i][j]);
        let parameters = self.jacobian(&at).try_inverse().map_or_else(SMatrix::zeros, |inverse| -(inverse * explicit));
        let moved = |by_first: Vector3<f64>, by_second: Vector3<f64>, first: usize| -> ByPose {
            by_first * parameters.row(first) + by_second * parameters.row(first + 1)
        };
        let across = |vector: ByPose, unit: Vector3<f64>, length: f64| -> ByPose { (vector - unit * unit.tr_mul(&vector)) / length };
        let mut arm_by_pose = moved(wheel.t1, wheel.t2, 0);
        let turned = arm.cross_matrix();
        arm_by_pose.fixed_view_mut::<3, 3>(0, 3).zip_apply(&turned, |value, turned| *value -= turned);
        let (normal_s, normal_eta) = self.normal_derivatives(&at);
        let length = rail.t1.norm();
        Wander {
            location,
            arm,
            parameters,
            arm_by_pose,
            normal_by_pose: across(moved(normal_s, normal_eta, 2), normal, at.normal.norm()),
            forward_by_pose: across(moved(rail.t11, rail.t12, 2), rail.t1 / length, length),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surfaces::pair;
    use super::*;
    use crate::geometry::Side;
    use crate::math::rotation::AxleFrame;
    use nalgebra::Rotation3;

    #[test]
    fn analytic_wandering_matches_differences_of_located_contacts() {
        for side in Side::BOTH {
            let (wheel, rail) = pair(side, 0.05, true);
            let axes = AxleFrame::new(0.02, 0.003).axes;
            let centre = Vector3::new(1.3, 0.005, 0.457);
            let located = |displacement: [f64; 6]| {
                let [x, y, z, a, b, c] = displacement;
                let axes = Rotation3::new(Vector3::new(a, b, c)).matrix() * axes;
                let centre = centre + Vector3::new(x, y, z);
                let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: 1.3 };
                let found = pair.locate(&SurfaceParameters::default()).unwrap();
                (pair.wander(&found.parameters), found)
            };
            let (wander, found) = located([0.0; 6]);
            for j in 0..6 {
                let h = 1e-6;
                let displaced = |sign: f64| {
                    let mut d = [0.0; 6];
                    d[j] = sign * h;
                    located(d)
                };
                let (ahead, behind) = (displaced(1.0), displaced(-1.0));
                let near = |what: &str, a: Vector3<f64>, b: Vector3<f64>, exact: Vector3<f64>| {
                    let difference = (a - b) / (2.0 * h);
                    assert!((difference - exact).norm() < 2e-6 * (1.0 + exact.norm()), "{side:?} {what} {j}: {difference} {exact}");
                };
                near("rho", ahead.0.arm, behind.0.arm, wander.arm_by_pose.column(j).into());
                near("n", ahead.1.normal, behind.1.normal, wander.normal_by_pose.column(j).into());
                let (a, b) = (ahead.1.forward.normalize(), behind.1.forward.normalize());
                near("e1", a, b, wander.forward_by_pose.column(j).into());
                let (a, b) = (ahead.1.parameters, behind.1.parameters);
                let place = |p: SurfaceParameters| Vector3::new(p.wheel, p.lead, p.rail);
                let by = |i: usize| wander.parameters[(i, j)];
                near("s", place(a), place(b), Vector3::new(by(0), by(2), by(3)));
                let slope = (ahead.1.penetration - behind.1.penetration) / (2.0 * h);
                let lever = wander.arm.cross(&found.normal);
                let exact = -row(found.normal, lever)[j];
                assert!((slope - exact).abs() < 1e-7, "{side:?} penetration {j}: {slope} {exact}");
            }
        }
    }
}
