//! How a located contact moves with its wheelset: derivatives of its place on the wheel and of its axes.
//!
//! The wheelset is displaced by a small translation d and a small rotation vector w (world axes, about its centre); rho leads from the
//! centre to the contact. In the contact's axes e1, e2, n, with delta the penetration, S_w and S_r the curvatures of wheel and rail (the
//! second derivative along n of a surface by lengths in the contact plane, a symmetric 2 x 2 matrix), the parts in the contact plane of
//! the contact's way over the wheel a, over the rail b, and of p = d + w x rho, the four equations of [`super::algebraic`] say
//!
//! ```text
//! p + a - b = delta S_r b                  the wheel's point stays above the rail's, along a normal that turns
//! n x w + S_w a = S_r b                    the normals of both surfaces stay parallel
//! b = (S_w - S_r + delta S_w S_r)^-1 (S_w p - n x w),   d rho = w x rho + a = b + delta S_r b - d  in the contact plane
//! ```
//!
//! The axes turn by theta: `dn = -S_r b` and, with the rail's tangent t_s over its parameters s and eta,
//! `theta_n = e2 . (t_ss ds + t_seta d eta) / |t_s|`. The wheel is a surface of revolution: its curvatures are those of its circle,
//! `1 / (R sqrt(1 + R'^2))`, around the axle, and `-R'' / (1 + R'^2)^(3/2)`. All exact. The penetration needs none of it:
//! `d delta = -n . (d + w x rho)`, because the located points make it stationary.

use super::algebraic::{Pair, SurfaceParameters};
use crate::contact::creepage::ContactAxes;
use crate::geometry::profile::ProfilePoint;
use crate::geometry::track::rail_surface::rail_point_of;
use nalgebra::{Matrix2, Vector3};

/// Derivatives with respect to translation [m] and rotation vector [rad] of the wheelset, or to its velocity and angular velocity.
pub type Row = [f64; 6];

/// A contact that was found.
#[derive(Clone, Copy, Debug)]
pub struct Touch<'a> {
    pub parameters: &'a SurfaceParameters,
    pub axes: &'a ContactAxes,
    /// rho, m.
    pub arm: Vector3<f64>,
    /// m.
    pub penetration: f64,
    /// Profiles of wheel and rail.
    pub profiles: &'a [ProfilePoint; 2],
}

/// The derivatives, in the contact's axes.
#[derive(Clone, Copy, Debug)]
pub struct Migration {
    /// Of p.
    pub material: [Row; 3],
    /// Of rho.
    pub arm: [Row; 3],
    /// theta: the rotation of the axes.
    pub turn: [Row; 3],
}

/// Translation and rotation parts next to each other.
#[inline]
pub fn row(translation: &Vector3<f64>, rotation: &Vector3<f64>) -> Row {
    [translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z]
}

/// Adds `factor` times a row.
#[inline(always)]
pub fn add(sum: &mut Row, factor: f64, row: &Row) {
    for (sum, value) in sum.iter_mut().zip(row) {
        *sum += factor * value;
    }
}

/// Sum of rows with factors.
#[inline(always)]
pub fn sum<const N: usize>(factors: [f64; N], rows: [&Row; N]) -> Row {
    let mut sum = [0.0; 6];
    for (j, sum) in sum.iter_mut().enumerate() {
        *sum = factors[0] * rows[0][j];
        for i in 1..N {
            *sum += factors[i] * rows[i][j];
        }
    }
    sum
}

/// Change of the place of the wheel's material point along a unit vector: `unit . (d + w x rho)`.
#[inline]
pub fn material(arm: &Vector3<f64>, unit: &Vector3<f64>) -> Row {
    row(unit, &arm.cross(unit))
}

/// S of the wheel in the plane of e1 and e2. The axle's direction tells that of the circle.
#[inline]
fn wheel_curvature(axes: &ContactAxes, axle: &Vector3<f64>, profile: &ProfilePoint) -> Matrix2<f64> {
    let per_arc = 1.0 / (1.0 + profile.d1 * profile.d1);
    let root = per_arc.sqrt();
    let (around, across) = (root / profile.value, -profile.d2 * root * per_arc);
    let (x, y) = (axle.dot(&axes.e1), axle.dot(&axes.e2));
    let part = (around - across) / (x * x + y * y);
    Matrix2::new(across + part * y * y, -part * x * y, -part * x * y, across + part * x * x)
}

impl Pair<'_> {
    /// Derivatives at a contact. Where the surfaces fit so closely that it has no definite place it is taken to stay where it is on both.
    #[inline]
    pub fn migration(&self, touch: &Touch) -> Migration {
        let Touch { parameters, axes, arm, penetration, profiles: [wheel, rail] } = touch;
        let ContactAxes { e1, e2, normal } = axes;
        let lever = [arm.cross(e1), arm.cross(e2), arm.cross(normal)];
        let material = [row(e1, &lever[0]), row(e2, &lever[1]), row(normal, &lever[2])];
        let at = rail_point_of(self.rail, self.distance + parameters.lead, parameters.rail, rail);
        // t_s = l e1 and t_eta = c e1 + h e2.
        let (per_l, c, per_h) = (1.0 / at.t1.dot(e1), at.t2.dot(e1), 1.0 / at.t2.dot(e2));
        let in_plane = |ss: f64, mixed: f64| {
            let along = ss * per_l * per_l;
            (along, (mixed * per_l - along * c) * per_h)
        };
        let mixed = at.t12.dot(normal);
        let (r11, r12) = in_plane(at.t11.dot(normal), mixed);
        let r22 = (at.t22.dot(normal) - c * (2.0 * mixed * per_l - c * r11)) * per_h * per_h;
        let (g1, g2) = in_plane(at.t11.dot(e2), at.t12.dot(e2));
        let rail = Matrix2::new(r11, r12, r12, r22);
        let wheel = wheel_curvature(axes, &self.axes.column(1).into(), wheel);
        let parting = wheel - rail + wheel * rail * *penetration;
        let determinant = parting.m11 * parting.m22 - parting.m12 * parting.m21;
        if !(determinant.abs() > 0.0) {
            let zero = Vector3::zeros();
            return Migration { material, arm: lever.map(|lever| row(&zero, &lever)), turn: [[0.0; 6]; 3] };
        }
        let inverse = Matrix2::new(parting.m22, -parting.m12, -parting.m21, parting.m11) * (1.0 / determinant);
        let by_material = inverse * wheel;
        let mut way = [[0.0; 6]; 2];
        for (i, way) in way.iter_mut().enumerate() {
            *way = sum([by_material[(i, 0)], by_material[(i, 1)]], [&material[0], &material[1]]);
            for j in 0..3 {
                way[3 + j] += inverse[(i, 0)] * e2[j] - inverse[(i, 1)] * e1[j];
            }
        }
        let turn = [sum([r12, r22], [&way[0], &way[1]]), sum([-r11, -r12], [&way[0], &way[1]]), sum([g1, g2], [&way[0], &way[1]])];
        let mut arm = [sum([1.0, -penetration], [&way[0], &turn[1]]), sum([1.0, *penetration], [&way[1], &turn[0]]), [0.0; 6]];
        for j in 0..3 {
            arm[0][j] -= e1[j];
            arm[1][j] -= e2[j];
            arm[2][3 + j] = lever[2][j];
        }
        Migration { material, arm, turn }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surfaces::pair;
    use super::*;
    use crate::geometry::Side;
    use crate::geometry::track::centre_line::{Alignment, CentreLine, Node, Pivot};
    use crate::math::rotation::AxleFrame;
    use nalgebra::{Matrix3, Rotation3};
    use std::sync::Arc;

    #[test]
    fn analytic_migration_matches_differences_of_located_contacts() {
        // A straight and wavy track, and one that bends, twists and climbs besides.
        let node = |distance, curvature, superelevation, grade| Node { distance, curvature, superelevation, grade };
        let nodes = vec![node(-3.0, 0.002, -0.01, 0.0), node(0.0, -0.001, 0.02, 0.05), node(4.0, 0.005, -0.02, -0.04)];
        let alignment = Alignment { nodes, smoothing: 5.0, pivot: Pivot::LowRail { base: 1.5 } };
        let line = CentreLine::new(&alignment, Vector3::new(2.0, -1.0, 0.5), 0.7).map(Arc::new);
        assert!(line.is_some());
        for (side, line) in Side::BOTH.map(|side| [(side, None), (side, line.clone())]).into_iter().flatten() {
            let (wheel, rail) = pair(side, 0.05, true);
            let distance = 1.3;
            let place = line.as_ref().map_or((Vector3::new(distance, 0.0, 0.0), Matrix3::identity()), |line| {
                let frame = line.frame(distance);
                (frame.origin, frame.axes)
            });
            let rail = rail.along(line);
            let axes = place.1 * AxleFrame::new(0.02, 0.003).axes;
            let centre = place.0 + place.1 * Vector3::new(0.0, 0.005, 0.457);
            let located = |displacement: [f64; 6]| {
                let [x, y, z, a, b, c] = displacement;
                let axes = Rotation3::new(Vector3::new(a, b, c)).matrix() * axes;
                let centre = centre + Vector3::new(x, y, z);
                let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance };
                let found = pair.locate(&SurfaceParameters::default()).unwrap();
                let axes = ContactAxes::new(found.normal, found.forward);
                let (arm, profiles) = (found.wheel_point - centre, [found.wheel_profile, found.rail_profile]);
                let (parameters, penetration) = (&found.parameters, found.penetration);
                (pair.migration(&Touch { parameters, axes: &axes, arm, penetration, profiles: &profiles }), axes, arm, penetration)
            };
            let (migration, axes, ..) = located([0.0; 6]);
            let basis = Matrix3::from_columns(&[axes.e1, axes.e2, axes.normal]);
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
                let column = |rows: &[Row; 3]| basis * Vector3::from(rows.map(|row| row[j]));
                let turn = column(&migration.turn);
                near("rho", ahead.2, behind.2, column(&migration.arm));
                near("n", ahead.1.normal, behind.1.normal, turn.cross(&axes.normal));
                near("e1", ahead.1.e1, behind.1.e1, turn.cross(&axes.e1));
                let slope = (ahead.3 - behind.3) / (2.0 * h);
                let exact = -migration.material[2][j];
                assert!((slope - exact).abs() < 1e-7, "{side:?} penetration {j}: {slope} {exact}");
            }
        }
    }
}
