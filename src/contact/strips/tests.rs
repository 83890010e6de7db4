use super::*;
use crate::contact::Material;
use crate::contact::normal::{ContactShape, Hertz, NormalLaw, ProfileSection};
use crate::contact::search::algebraic::Pair;
use crate::geometry::Side;
use crate::geometry::profile::{Arch, Cone, Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::Rail;
use crate::math::rotation::AxleFrame;
use nalgebra::Vector3;
use std::sync::Arc;

const STEEL: Material = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };

/// A cylinder on an arc.
fn pair(side: Side, radius: f64) -> (Wheel, Rail) {
    let wheel = Wheel { side, profile: Arc::new(Cone { radius: 0.46, slope: 0.0 }), half_spacing: 0.75 };
    (wheel, Rail::new(side, Arc::new(Arch { radius }), 0.75, 0.0, &[]))
}

/// Strips and parts of a wheel in a pose.
fn pressed(side: Side, radius: f64, centre: Vector3<f64>, yaw: f64) -> (Vec<Pressed>, Vec<Part>, Scratch) {
    let (wheel, rail) = pair(side, radius);
    let frame = AxleFrame::new(yaw, 0.0);
    let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &frame.axes, distance: 0.0 };
    let strips = RailStrips::new(&rail, std::iter::once(&wheel));
    let mut scratch = Scratch::new(strips.len());
    let found = press_anywhere(&pair, &strips, STEEL, &mut scratch).to_vec();
    let parts = Parts::new(&found, &strips, MOST);
    let part = |k| Part::new(parts.share(&found, k, k), &strips, wheel.profile.as_ref(), STEEL);
    let parts = (0..parts.len()).map(part).collect();
    (found, parts, scratch)
}

#[test]
fn analytic_a_cylinder_on_an_arc_presses_as_hertz_says() {
    for radius in [0.3, 0.08, 0.02] {
        let (wheel, rail) = pair(Side::Left, radius);
        for penetration in [3e-5, 8e-5] {
            let at = |profile: &Arc<dyn Profile>| profile.at(0.0);
            let shape = ContactShape::new(
                0.5 / 0.46,
                0.5 / radius,
                ProfileSection { profile: wheel.profile.as_ref(), at: 0.0, point: at(&wheel.profile) },
                ProfileSection { profile: rail.profile.as_ref(), at: 0.0, point: at(&rail.profile) },
            );
            let hertz = Hertz::at_the_point(STEEL).contact(&shape, penetration).unwrap();
            let (_, parts, _) = pressed(Side::Left, radius, Vector3::new(0.0, 0.0, 0.46 - penetration), 0.0);
            let [part] = parts[..] else { panic!("{} parts", parts.len()) };
            let off = [part.force / hertz.force, part.patch.a / hertz.patch.a, part.patch.b / hertz.patch.b].map(|ratio| ratio - 1.0);
            println!("radius {radius}, {penetration}: N, a, b off by {off:.4?}");
            assert!(off[0].abs() < 0.03 && off[1].abs() < 0.05 && off[2].abs() < 0.08, "{off:?}");
            assert!((part.overlap / penetration - 1.0).abs() < 0.02 && (part.arm.y - 0.75).abs() < 5e-5 && part.arm.x.abs() < 1e-9);
        }
    }
}

#[test]
fn prop_sides_mirror_each_other() {
    let left = pressed(Side::Left, 0.3, Vector3::new(0.0, 1e-3, 0.46 - 6e-5), 5e-3).1[0];
    let right = pressed(Side::Right, 0.3, Vector3::new(0.0, -1e-3, 0.46 - 6e-5), -5e-3).1[0];
    assert!((left.force / right.force - 1.0).abs() < 1e-12 && (left.lead - right.lead).abs() < 1e-12);
    assert!((left.arm.y + right.arm.y).abs() < 1e-12 && (left.normal.y + right.normal.y).abs() < 1e-12);
}

/// A tread that is round across: a false flange, the tip of a flange.
#[derive(Debug)]
struct Tyre(Arch);

impl Profile for Tyre {
    fn at(&self, u: f64) -> ProfilePoint {
        let at = self.0.at(u);
        ProfilePoint { value: 0.46 + at.value, ..at }
    }
    fn range(&self) -> (f64, f64) {
        self.0.range()
    }
    fn describe(&self) -> String {
        "tyre".into()
    }
}

/// Strips that were cut for the flat rail alone were as wide as the patch: N was off by up to 68 %.
/// Radii stand on both sides of each change of widths; patches of 1.5 mm across (penetration 0.03 mm) are the hardest.
#[test]
fn analytic_a_sharp_wheel_on_a_flat_rail_presses_as_hertz_says() {
    let rail = Rail::new(Side::Left, Arc::new(Arch { radius: 0.3 }), 0.75, 0.0, &[]);
    let frame = AxleFrame::new(0.0, 0.0);
    for radius in [0.2, 0.15, 0.1, 0.06, 0.05, 0.04, 0.035, 0.03, 0.012] {
        let wheel = Wheel { side: Side::Left, profile: Arc::new(Tyre(Arch { radius })), half_spacing: 0.75 };
        let strips = RailStrips::new(&rail, std::iter::once(&wheel));
        let mut scratch = Scratch::new(strips.len());
        for (penetration, y) in [3e-5, 8e-5].into_iter().flat_map(|penetration| [0.0, 3e-4, 7e-4].map(|y| (penetration, y))) {
            let centre = Vector3::new(0.0, y, 0.46 - penetration);
            let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &frame.axes, distance: 0.0 };
            let shape = ContactShape::new(
                0.5 / 0.46,
                0.5 / 0.3 + 0.5 / radius,
                ProfileSection { profile: wheel.profile.as_ref(), at: 0.0, point: wheel.profile.at(0.0) },
                ProfileSection { profile: rail.profile.as_ref(), at: 0.0, point: rail.profile.at(0.0) },
            );
            // Beside each other both circles are farther apart.
            let nearest = penetration - 0.5 * y * y / (0.3 + radius);
            let hertz = Hertz::at_the_point(STEEL).contact(&shape, nearest).unwrap();
            let load: f64 = press_anywhere(&pair, &strips, STEEL, &mut scratch).iter().map(|own| own.load).sum();
            println!("radius {radius}, {penetration}, y {y}: N off by {:+.4}", load / hertz.force - 1.0);
            assert!((load / hertz.force - 1.0).abs() < if penetration < 5e-5 { 0.04 } else { 0.01 });
        }
    }
}
