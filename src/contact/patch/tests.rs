use super::*;
use crate::contact::Material;
use crate::contact::creep::exact::{Exact, Settings as ExactSettings};
use crate::contact::creep::{CreepLaw, RollingContact};
use crate::contact::creepage::Creepage;
use crate::contact::normal::Hertz;
use crate::contact::normal::test_surfaces::{S1002, Shape, Stand, rail_60e1};
use crate::contact::normal::{NormalLaw, ProfileSection};
use crate::contact::search::algebraic::Pair;
use crate::contact::search::algebraic::SurfaceParameters;
use crate::geometry::Side;
use crate::geometry::profile::{Cone, Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::Rail;
use crate::math::rotation::AxleFrame;
use std::sync::Arc;

const STEEL: Material = Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 };

/// A profile that ends where a real one does.
#[derive(Debug)]
struct Within(Box<dyn Profile>, (f64, f64));

impl Profile for Within {
    fn at(&self, x: f64) -> ProfilePoint {
        self.0.at(x)
    }
    fn range(&self) -> (f64, f64) {
        self.1
    }
    fn describe(&self) -> String {
        self.0.describe()
    }
}

/// A cone on an arc: Hertzian. One side of the track.
fn cone_on_arc(side: Side) -> (Wheel, Rail) {
    let wheel = Wheel { side, profile: Arc::new(Within(Box::new(Cone { radius: 0.46, slope: 0.0 }), (-0.04, 0.06))), half_spacing: 0.75 };
    let head = Within(Box::new(Shape::new(0.0, 0.0, &[(0.0, -1.0 / 0.3)])), (-0.03, 0.03));
    (wheel, Rail::new(side, Arc::new(head), 0.75, 0.0, &[]))
}

fn rolling(yaw: f64, speed: f64) -> Motion {
    let frame = AxleFrame::new(yaw, 0.0);
    Motion { velocity: Vector3::new(speed, 0.0, 0.0), rotation: frame.axes.column(1) * (speed / 0.46), speed }
}

fn on(wheel: &Wheel, rail: &Rail, centre: Vector3<f64>, yaw: f64, motion: Option<&Motion>, n: usize) -> PatchSolution {
    let frame = AxleFrame::new(yaw, 0.0);
    let pair = Pair { wheel, rail, centre: &centre, axes: &frame.axes, distance: 0.0 };
    let pressed =
        Pressed::new(&pair, STEEL, Settings { columns: n, rows: n, extrapolate: motion.is_some(), ..Settings::default() }).unwrap();
    motion.map_or_else(|| pressed.at_rest(), |motion| pressed.roll(motion, 0.3))
}

#[test]
fn analytic_a_cylinder_on_an_arc_presses_as_hertz_says() {
    let (wheel, rail) = cone_on_arc(Side::Left);
    let penetration = 6e-5;
    let shape = crate::contact::normal::ContactShape::new(
        0.5 / 0.46,
        0.5 / 0.3,
        ProfileSection { profile: wheel.profile.as_ref(), at: 0.0, point: wheel.profile.at(0.0) },
        ProfileSection { profile: rail.profile.as_ref(), at: 0.0, point: rail.profile.at(0.0) },
    );
    let hertz = Hertz::at_the_point(STEEL).contact(&shape, penetration).unwrap();
    let mut errors = Vec::new();
    for n in [16, 32, 64] {
        let found = on(&wheel, &rail, Vector3::new(0.0, 0.0, 0.46 - penetration), 0.0, None, n);
        let area = std::f64::consts::PI * hertz.patch.a * hertz.patch.b;
        errors.push([found.load / hertz.force - 1.0, found.area() / area - 1.0]);
        assert!((found.overlap / penetration - 1.0).abs() < 1e-6 && found.parts() == 1);
        assert!(found.centre.x.abs() < 1e-9 && (found.centre.y - 0.75).abs() < 1e-9, "{}", found.centre);
        assert!((found.pressing.z / found.load - 1.0).abs() < 1e-3);
    }
    println!("load and area against Hertz on 16, 32, 64 cells: {errors:?}");
    assert!(errors[1][0].abs() < 6e-3 && errors[2][0].abs() < 2e-3 && errors[2][1].abs() < 0.03, "{errors:?}");
}

#[test]
fn equiv_creep_forces_on_an_ellipse_are_those_of_the_exact_law() {
    let (wheel, rail) = cone_on_arc(Side::Left);
    for (yaw, faster) in [(0.0, 1e-3), (1.5e-3, 0.0), (2e-3, -1e-3), (8e-3, 0.0)] {
        let speed = 20.0;
        let mut motion = rolling(yaw, speed);
        motion.rotation *= 1.0 + faster;
        let found = on(&wheel, &rail, Vector3::new(0.0, 0.0, 0.46 - 6e-5), yaw, Some(&motion), 64);
        // An ellipse of that load and area with the creepages at its centre: the wheel's lowest point is at rest but for these.
        let shape = crate::contact::normal::ContactShape::new(
            0.5 / 0.46,
            0.5 / 0.3,
            ProfileSection { profile: wheel.profile.as_ref(), at: 0.0, point: wheel.profile.at(0.0) },
            ProfileSection { profile: rail.profile.as_ref(), at: 0.0, point: rail.profile.at(0.0) },
        );
        let hertz = Hertz::at_the_point(STEEL).contact(&shape, 6e-5).unwrap();
        let slip = (motion.velocity + motion.rotation.cross(&Vector3::new(0.0, 0.0, -0.46))) / speed;
        let contact = RollingContact {
            patch: hertz.patch,
            normal_force: hertz.force,
            friction: 0.3,
            creepage: Creepage { longitudinal: slip.x, lateral: slip.y, spin: motion.rotation.z / speed },
            ..RollingContact::default()
        };
        let expected = Exact::new(STEEL, ExactSettings::default()).force(&contact);
        let bound = 0.3 * hertz.force;
        let off = [(found.creep_force.x - expected.longitudinal) / bound, (found.creep_force.y - expected.lateral) / bound];
        println!("yaw {yaw}, faster by {faster}: {:.4?} of {:.4?}", [found.creep_force.x / bound, found.creep_force.y / bound], off);
        assert!(off.iter().all(|off| off.abs() < 0.006) && found.residual < 1e-5, "{off:?}");
    }
}

#[test]
fn validate_load_of_s1002_on_60e1_against_another_program() {
    // Of `normal::tests`: given overlap 70 um, gap along the normal at the deepest place; kN.
    let exact = [(-3.0, 58.53), (-1.0, 66.11), (0.0, 79.10), (0.5, 89.16), (1.0, 80.67), (1.5, 63.20), (2.5, 47.41), (4.0, 47.25)];
    let stand = Stand::s1002_on_60e1();
    let wheel = Wheel { side: Side::Left, profile: Arc::new(S1002), half_spacing: 0.75 };
    let rail = Rail::new(Side::Left, Arc::new(Within(Box::new(rail_60e1()), (-0.0359, 0.0359))), 0.7535, 0.025, &[]);
    let mut worst: f64 = 0.0;
    for (y, force) in exact {
        let start = if y < 0.7 { 0.0 } else { -0.011 };
        let at = stand.pressed(1e-3 * y, 7e-5, &SurfaceParameters { rail: start, wheel: start, ..Default::default() }).unwrap();
        // The pose in which that place overlaps by as much.
        let centre = Vector3::new(0.0, 1e-3 * y, at.wheel_point.z + at.wheel_profile.value);
        let found = on(&wheel, &rail, centre, 0.0, None, 64);
        let off = 1e-3 * found.load / force - 1.0;
        println!(
            "y {y:4.1} mm: {:.2} kN, {:+.2} %, overlap {:.2} um, {} cells",
            1e-3 * found.load,
            100.0 * off,
            1e6 * found.overlap,
            found.cells.len()
        );
        worst = worst.max(off.abs());
    }
    assert!(worst < 0.01, "{worst}");
}

#[test]
fn prop_sides_and_directions_mirror_each_other() {
    let solve = |side: Side, y: f64, yaw: f64, speed: f64| {
        let (wheel, rail) = cone_on_arc(side);
        on(&wheel, &rail, Vector3::new(0.0, y, 0.46 - 6e-5), yaw, Some(&rolling(yaw, speed)), 16)
    };
    let left = solve(Side::Left, 1e-3, 2e-3, 20.0);
    let right = solve(Side::Right, -1e-3, -2e-3, 20.0);
    assert!((left.load / right.load - 1.0).abs() < 1e-9);
    let [a, b] = [left.creep_force, right.creep_force];
    assert!((a.x - b.x).abs() < 1e-6 * left.load && (a.y + b.y).abs() < 1e-6 * left.load, "{a} {b}");
    assert!((left.creep_moment.z + right.creep_moment.z).abs() < 1e-9 * left.load);
    // Backward, the axle's slip across turns round with the direction: yaw the other way about.
    let back = solve(Side::Left, 1e-3, -2e-3, -20.0);
    let c = back.creep_force;
    assert!((a.x + c.x).abs() < 1e-3 * left.load && (a.y - c.y).abs() < 1e-3 * left.load, "{a} {c}");
}

#[test]
fn prop_a_load_that_is_asked_for_is_carried() {
    let (wheel, rail) = cone_on_arc(Side::Left);
    let frame = AxleFrame::new(0.0, 0.0);
    let centre = Vector3::new(0.0, 0.0, 0.46);
    let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &frame.axes, distance: 0.0 };
    let settings = Settings { columns: 16, rows: 16, extrapolate: false, ..Settings::default() };
    for load in [1e3, 5e4, 2e5] {
        let (depth, pressed) = depth_under_load(&pair, load, STEEL, settings, None).unwrap();
        let found = pressed.at_rest();
        let near = depth_under_load(&pair, load, STEEL, settings, Some(1.3 * depth)).unwrap().0;
        assert!((near / depth - 1.0).abs() < 1e-6, "{near} {depth}");
        assert!((found.pressing.z / load - 1.0).abs() < 1e-6 && depth > 0.0, "{load} {}", found.pressing.z);
    }
}
