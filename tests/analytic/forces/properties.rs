//! What must hold for every element of the registry, so also for one that is added later.

use super::stage::{Mechanism, Stage, apply, apply_under, brick, motions, under};
use crate::counting;
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use wheelrail::mbs::body::{BodyMotion, Wrench};
use wheelrail::mbs::force::{ElementInput, ForceElement, Gravity, Guide, GuidedSpring, REGISTRY, VerticalLoad};
use wheelrail::solve::Dynamics;
use wheelrail::units::Unit;

/// Holds one body to a frame that travels on the track with it: neither momentum nor energy are the two bodies' alone.
const GUIDED: &str = "guided_spring";

/// Settings of each kind; places "a" and "b" follow.
const SAMPLES: &[(&str, &str)] = &[
    ("spring_damper", "stiffness = 2e5\ndamping = 3e3\npreload = -5e3"),
    ("spring_damper", "force_over_length = [[-0.1, -9e4], [-0.01, -2e3], [0, 0], [0.05, 1e4]]\nnatural_length = 0.6"),
    (
        "spring_damper",
        "axis = \"y\"\nforce_over_speed = [[-1, -9e3], [-0.1, -5e3], [0.05, 2.5e3], [1, 4e3]]\nspeed_rounding = 0.02\npreload = 700",
    ),
    ("spring_damper", "axis = \"-z\"\nstiffness = 1e5\nrounding = 0.01"),
    ("bushing", "stiffness = [3e6, 2e5, 5e5]\ndamping = [1e3, 2e3, 3e3]\npreload = [0, 100, -2e4]"),
    ("bushing", "rotational_stiffness = [1e5, 2e5, 4e5]\nrotational_damping = [1e3, 5e3, 0]"),
    ("maxwell_damper", "stiffness = 6e6\ndamping = 32e3"),
    ("maxwell_damper", "axis = \"y\"\nstiffness = 1e6\nforce_over_speed = [[-1, -9e3], [-0.1, -5e3], [0.1, 5e3], [1, 9e3]]"),
    ("bump_stop", "axis = \"y\"\nforce_over_displacement = [[0, 0], [0.025, 0], [0.03, 600], [0.05, 17170], [0.065, 23e4]]"),
    ("bump_stop", "stiffness = 1e6\nclearance = 0.02\nsides = \"compression\"\nrounding = 0.005\ndamping = 0.5"),
    ("anti_roll_bar", "stiffness = 940e3\ndamping = 1e3"),
    ("dry_friction", "axis = \"x\"\nlimit = 5e3\nstiffness = 1e6"),
    ("dry_friction", "normal = \"-y\"\nfriction = 0.3\nnormal_force = 8e3\nnormal_stiffness = 4e5\nstiffness = 5e5\nexponent = 3"),
    ("air_spring", "axis = \"z\"\npreload = -1.2e5\narea = 0.25\nvolume = 0.03\nreservoir_volume = 0.05\norifice_damping = 4e4"),
    (
        "air_spring",
        "preload = -9e4\narea = 0.2\nvolume = 0.02\nreservoir_volume = 0.03\narea_growth = 0.3\norifice_damping = 2e4\norifice_turbulence = 2e4",
    ),
    (
        "friction_wedge",
        "axis = \"z\"\nnormal = \"x\"\nangle = 0.6\nfriction = 0.4\nspring_force = 2e4\nspring_stiffness = 3e5\nstiffness = 5e5",
    ),
    (
        "friction_wedge",
        "axis = \"-z\"\nnormal = \"-x\"\nangle = 0.5\nfriction = 0.3\nspring_force = 4e4\nspring_stiffness = 4e5\nstiffness = 3e5\nexponent = 3",
    ),
    (GUIDED, "distance = 1.8\nlongitudinal_stiffness = 2e5\nlongitudinal_damping = 4e3\nlateral_stiffness = 1e5\nlateral_damping = 0"),
    ("motor_gear", "mount = \"shaft\"\nratio = 4.5"),
    ("motor_gear", "mount = \"nose\"\nratio = 3\ngear = \"same\""),
    ("motor_gear", "mount = \"shaft\"\nratio = 4.5\nrotor_inertia = 9\nstiffness = 2e6\ndamping = 3e3"),
    ("motor_gear", "mount = \"nose\"\nratio = 3\nrotor_inertia = 15\nstiffness = 4e6\ndamping = 5e3"),
    // The torque arm on the motor's body, and tests/analytic/forces/cardan.rs has it on a third.
    ("cardan_drive", "arm = \"a\"\nratio = 3.2\nrotor_inertia = 5\nstiffness = 3e5\ndamping = 200"),
    ("cardan_drive", "arm = \"a\"\nratio = 2\nturns = \"anticlockwise\"\nrotor_inertia = 8\nstiffness = 2e5"),
    ("brake", "type = \"disc\"\nstiffness = 6e5"),
    ("brake", "type = \"disc\"\nfriction = 0.35\nradius = 0.25\nstiffness = 4e5\nrelaxation = 0.2\ndamping_time = 0.02"),
    ("brake", "type = \"tread\"\nfriction = 0.2\nstiffness = 3e5\nrelaxation = 0.1"),
    ("running_resistance", "rolling = 3e3\nper_speed = 40\nair = 6"),
    ("eddy_current_brake", "critical_speed = 0.8"),
    ("magnetic_track_brake", "friction = 0.3\nrise_time = 0.1\nstiffness = 3e5\nrelaxation = 2e-4\ndamping_time = 0"),
    (
        "magnetic_track_brake",
        "friction = 0.4\nsliding_friction = 0.1\nhalf_speed = 0.5\nrise_time = 0.2\nstiffness = 2e5\nrelaxation = 0.1",
    ),
    ("flexible_axle", "stiffness = 4e6\ndamping = 200\nleft_share = 0.4"),
    ("independent_wheels", "damping = 3"),
    ("external_load", ""),
    ("external_load", "axes = \"body\""),
    ("actuator", "largest_force = 15e3"),
    ("actuator", "axis = \"y\"\nlargest_force = 3e4\nlag = \"20 ms\""),
    ("coupler", "slack = 0.04\ndraw_stiffness = 3e6\nbuffer_force_over_displacement = [[0, 0], [0.01, 1e4], [0.05, 2e5]]\ndamping = 0.3"),
];

pub fn stage(mirror: f64) -> Stage {
    let side = |x: f64, y: f64, z: f64| Vector3::new(x, y * mirror, z);
    let places = vec![("a", Some(0), side(-0.9, 0.8, 0.5)), ("b", Some(1), side(-0.6, 1.1, 1.0))];
    Stage { centres: vec![side(-1.0, 0.1, 0.6), side(0.5, -0.2, 1.8)], places, mirror }
}

fn samples(stage: &Stage) -> Vec<Box<dyn ForceElement>> {
    for entry in REGISTRY {
        assert!(SAMPLES.iter().any(|sample| sample.0 == entry.name), "no sample of {}: add one", entry.name);
    }
    let settings = |(kind, own): &(&str, &str)| {
        let outer = ["running_resistance", "eddy_current_brake", "magnetic_track_brake", "external_load"].contains(kind);
        let places = if [GUIDED, "flexible_axle", "independent_wheels"].contains(kind) {
            "body = \"b\""
        } else if outer {
            "on = \"b\""
        } else {
            "from = \"a\"\nto = \"b\""
        };
        format!("name = \"e\"\nkind = \"{kind}\"\n{places}\n{own}\n")
    };
    SAMPLES.iter().map(|sample| stage.element(&settings(sample))).collect()
}

/// Deviations of two bodies from the design configuration, their velocities, and states of an element.
#[derive(Clone, Debug)]
pub struct Case {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub state: Vec<f64>,
    pub inputs: Vec<f64>,
}

impl Case {
    pub fn coordinates(&self, stage: &Stage) -> Vec<f64> {
        stage.design().iter().zip(&self.q).map(|(design, q)| design + q).collect()
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let q = proptest::collection::vec(-0.08..0.08f64, 12);
    let v = proptest::collection::vec(-1.0..1.0f64, 12);
    let state = proptest::collection::vec(-0.03..0.03f64, 2);
    (q, v, state).prop_map(|(q, v, state)| Case { q, v, state, inputs: Vec::new() })
}

/// The same cases each time: a case at a corner of a table can't be differenced.
pub fn walk(stage: &Stage, mut check: impl FnMut(&dyn ForceElement, &Case)) {
    for element in samples(stage) {
        let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
        let mut runner = TestRunner::new_with_rng(Config { failure_persistence: None, ..Config::with_cases(40) }, rng);
        for _ in 0..40 {
            let mut case = cases().new_tree(&mut runner).unwrap().current();
            case.state.truncate(element.states());
            let input = |(i, input): (usize, &ElementInput)| {
                // N and N m, or m/s.
                let value = if input.unit == Unit::MetrePerSecond { 20.0 } else { 2e4 } * case.q[i] / 0.08;
                // Braking: from none to much.
                if input.least.is_some() { value.max(0.0) } else { value }
            };
            case.inputs = element.inputs().iter().enumerate().map(input).collect();
            check(element.as_ref(), &case);
        }
    }
}

fn size(wrenches: &[Wrench]) -> f64 {
    wrenches.iter().map(|wrench| wrench.force.norm() + wrench.moment.norm()).fold(1.0, f64::max)
}

/// The same, of elements between two bodies.
fn walk_between(stage: &Stage, mut check: impl FnMut(&dyn ForceElement, &Case)) {
    walk(stage, |element, case| {
        if !element.bodies().contains(&None) {
            check(element, case);
        }
    });
}

/// Power of the wrenches = -d(potential)/dt - dissipated power + power that inputs bring in. The stored energy may depend on velocities, which the bodies' accelerations
/// change: those of rotors are states.
fn check_energy_bill(
    element: &dyn ForceElement,
    q: &[f64],
    v: &[f64],
    [state, inputs]: [&[f64]; 2],
    motion: impl Fn(&[f64]) -> Vec<BodyMotion>,
) {
    let bodies = motion(q);
    let (wrenches, rates) = apply_under(element, &bodies, state, inputs);
    let power: f64 = bodies.iter().zip(&wrenches).map(|(body, w)| w.force.dot(&body.velocity) + w.moment.dot(&body.rotation)).sum();
    let h = 1e-6;
    let stored = |h: f64| {
        let q: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + h * v).collect();
        let state: Vec<f64> = state.iter().zip(&rates).map(|(z, rate)| z + h * rate).collect();
        element.potential_energy(&(&motion(&q)[..]).into(), &state)
    };
    let storing = (stored(h) - stored(-h)) / (2.0 * h);
    let heat = element.dissipated_power(&under(&bodies, inputs), state);
    let supplied = element.supplied_power(&under(&bodies, inputs), state);
    assert!(heat >= 0.0, "{element:?}: {heat}");
    let scale = 1.0 + power.abs() + storing.abs() + heat + supplied.abs();
    assert!((power + storing + heat - supplied).abs() < 1e-6 * scale, "{element:?} at {q:?}: {power} {storing} {heat} {supplied}");
}

#[test]
fn prop_each_element_pays_its_energy_bill() {
    let stage = stage(1.0);
    walk_between(&stage, |element, case| {
        check_energy_bill(element, &case.coordinates(&stage), &case.v, [&case.state, &case.inputs], |q| motions(q, &case.v));
    });
    walk(&stage, |element, case| {
        // Guided springs are held by the track, of which nobody keeps books.
        if element.bodies()[1].is_none() && !element.inputs().is_empty() || element.twist().is_some() {
            check_energy_bill(element, &case.coordinates(&stage), &case.v, [&case.state, &case.inputs], |q| motions(q, &case.v));
        }
    });
    // On a spinning axle the bearing lets through what belongs to the axle's frame only.
    walk_between(&stage, |element, case| {
        let mut v = case.v.clone();
        v[11] = 80.0;
        let motion = |q: &[f64]| vec![BodyMotion::general(&q[..6], &v[..6]), BodyMotion::new(&q[6..], &v[6..])];
        check_energy_bill(element, &case.coordinates(&stage), &v, [&case.state, &case.inputs], motion);
    });
    // Elements that no scene names alone.
    let guide = Some(Guide { stiffness: 1.3e5, damping: 2.0e4 });
    let spring = |longitudinal, lateral| GuidedSpring { name: "s".into(), body: 0, distance: 0.9, longitudinal, lateral };
    let elements: Vec<Box<dyn ForceElement>> = vec![
        Box::new(Gravity { body: 0, mass: 12.0, acceleration: 9.81, grade: 0.03 }),
        Box::new(VerticalLoad::new(0, 500.0, 9.81, 0.0)),
        Box::new(spring(guide, None)),
        Box::new(spring(None, guide)),
    ];
    let v = [0.0, 0.2, -0.1, 0.3, 0.4, 80.0];
    for element in &elements {
        check_energy_bill(element.as_ref(), &[0.0, 0.003, 0.46, 0.02, -0.01, 0.0], &v, [&[], &[]], |q| vec![BodyMotion::new(q, &v)]);
    }
}

#[test]
fn prop_momentum_and_angular_momentum_balance() {
    let stage = stage(1.0);
    let (mut worst, mut rotors): (f64, usize) = (0.0, 0);
    walk_between(&stage, |element, case| {
        let bodies = motions(&case.coordinates(&stage), &case.v);
        let (wrenches, rates) = apply_under(element, &bodies, &case.state, &case.inputs);
        let force = wrenches[0].force + wrenches[1].force;
        let moment: Vector3<f64> = bodies.iter().zip(&wrenches).map(|(body, w)| w.moment + body.position.cross(&w.force)).sum();
        let own = |h: f64| {
            let q: Vec<f64> = case.coordinates(&stage).iter().zip(&case.v).map(|(q, v)| q + h * v).collect();
            let state: Vec<f64> = case.state.iter().zip(&rates).map(|(z, rate)| z + h * rate).collect();
            element.angular_momentum(&under(&motions(&q, &case.v), &case.inputs), &state)
        };
        // What turns in the element takes the rest, which differences know to 1e-9.
        let taken = (own(1e-6) - own(-1e-6)) / 2e-6;
        if taken != Vector3::zeros() {
            rotors += 1;
            assert!((moment + taken).norm() + force.norm() < 1e-8 * size(&wrenches), "{element:?}: {force} {moment} {taken}");
            return;
        }
        worst = worst.max((force.norm() + moment.norm()) / size(&wrenches));
        assert!(worst < 1e-14, "{element:?}: {force} {moment}");
    });
    assert!(rotors >= 80);
    println!("largest imbalance {worst:.1e} of the forces");
}

#[test]
fn prop_rigid_motion_of_all_bodies_changes_no_force() {
    let stage = stage(1.0);
    let turn: Matrix3<f64> = *Rotation3::from_euler_angles(0.7, -0.4, 2.1).matrix();
    let (shift, velocity, rotation) = (Vector3::new(900.0, -40.0, 3.0), Vector3::new(20.0, 5.0, 1.0), Vector3::new(0.1, -0.3, 0.4));
    walk_between(&stage, |element, case| {
        let bodies = motions(&case.coordinates(&stage), &case.v);
        // A rotor's absolute speed is a state: turning everything on would change it.
        let rotation = if element.rotor_carrier().is_some() { Vector3::zeros() } else { rotation };
        let moved: Vec<BodyMotion> = bodies
            .iter()
            .map(|body| {
                let mut moved = *body;
                moved.position = turn * body.position + shift;
                moved.velocity = turn * body.velocity + velocity + rotation.cross(&(turn * body.position));
                moved.frame.axes = turn * body.frame.axes;
                moved.frame_rotation = turn * body.frame_rotation + rotation;
                moved.rotation = moved.frame_rotation;
                moved
            })
            .collect();
        let of = |bodies: &[BodyMotion]| apply_under(element, bodies, &case.state, &case.inputs);
        let ((one, one_rates), (other, other_rates)) = (of(&bodies), of(&moved));
        let scale = size(&one);
        for (one, other) in one.iter().zip(&other) {
            let difference = (turn * one.force - other.force).norm() + (turn * one.moment - other.moment).norm();
            // Positions of 900 m are rounded to 1e-13 m, the stiffest sample has 5e7 N/m.
            assert!(difference < 1e-9 * scale + 1e-4, "{element:?}: {difference}");
        }
        for (one, other) in one_rates.iter().zip(&other_rates) {
            assert!((one - other).abs() < 1e-8 * (1.0 + one.abs()), "{element:?}");
        }
    });
}

#[test]
fn prop_mirrored_copies_give_mirrored_forces() {
    let (left, right) = (stage(1.0), stage(-1.0));
    let mut copies = samples(&right).into_iter().flat_map(|element| (0..40).map(move |_| element.clone_box()));
    let mirrored =
        |values: &[f64]| -> Vec<f64> { values.iter().zip([1.0, -1.0, 1.0, -1.0, -1.0, 1.0].iter().cycle()).map(|(a, b)| a * b).collect() };
    walk(&left, |element, case| {
        let copy = copies.next().unwrap();
        let q = case.coordinates(&left);
        let (one, rates) = apply_under(element, &motions(&q, &case.v), &case.state, &case.inputs);
        let (other, other_rates) = apply_under(copy.as_ref(), &motions(&mirrored(&q), &mirrored(&case.v)), &case.state, &case.inputs);
        for (one, other) in one.iter().zip(&other) {
            let force = Vector3::new(one.force.x, -one.force.y, one.force.z) - other.force;
            let moment = Vector3::new(-one.moment.x, one.moment.y, -one.moment.z) - other.moment;
            assert!(force.norm() + moment.norm() < 1e-10 * size(&[*one]), "{element:?}: {force} {moment}");
        }
        assert!(rates.iter().zip(&other_rates).all(|(a, b)| (a - b).abs() < 1e-10 * (1.0 + a.abs())), "{element:?}");
    });
}

/// What an element says that it may be set to is what it reads, and setting it changes forces as other settings in the scene do.
#[test]
fn prop_constants_read_as_they_are_set() {
    let stage = stage(1.0);
    for (element, (kind, settings)) in samples(&stage).into_iter().zip(SAMPLES) {
        let constants = element.constants();
        assert!(!constants.is_empty(), "{kind} with {settings} has none");
        for constant in &constants {
            let label = format!("{kind}.{}", constant.name);
            assert!(constant.number < 50 && !constant.description.is_empty(), "{label}");
            assert!(constant.least.is_none_or(|least| constant.value >= least), "{label} = {}", constant.value);
            let twice = constants.iter().filter(|other| other.number == constant.number || other.name == constant.name).count();
            let reported = element.quantities().iter().any(|quantity| quantity.name == constant.name);
            assert!(twice == 1 && !reported, "{label} names something else");
            let mut changed = element.clone_box();
            let value = 1.25 * constant.value + 1e-3;
            changed.set_constant(constant.number, value);
            let found = changed.constants();
            assert_eq!(found.len(), constants.len(), "{label}");
            for (found, before) in found.iter().zip(&constants) {
                let wanted = if before.number == constant.number { value } else { before.value };
                assert_eq!(found.value, wanted, "{label}: {}", before.name);
            }
            changed.set_constant(constant.number, constant.value);
            assert_eq!(format!("{changed:?}"), format!("{element:?}"), "{label} set back");
        }
    }
}

/// In the design configuration, settled, nothing is displaced and the force is the preload.
#[test]
fn prop_design_configuration_is_at_rest() {
    let stage = stage(1.0);
    let bodies = motions(&stage.design(), &[0.0; 12]);
    for element in samples(&stage) {
        let mut state = vec![0.3; element.states()];
        element.settle(&(&bodies[..]).into(), &mut state);
        let (_, rates) = apply(element.as_ref(), &bodies, &state);
        assert!(rates.iter().all(|rate| rate.abs() < 1e-12), "{element:?}: {rates:?}");
        assert!(element.dissipated_power(&(&bodies[..]).into(), &state).abs() < 1e-12);
        let names: Vec<&str> = element.quantities().iter().map(|quantity| quantity.name).collect();
        assert!(!names.is_empty(), "{element:?} reports nothing");
        for (index, name) in names.iter().enumerate() {
            let value = element.quantity(index, &(&bodies[..]).into(), &state);
            let moved = name.starts_with("displacement") || name.starts_with("angle");
            assert!(!moved || value.abs() < 1e-15, "{element:?}: {name} = {value}");
        }
    }
    let preload = |settings: &str| stage.element(&format!("name = \"e\"\nfrom = \"a\"\nto = \"b\"\n{settings}"));
    let spring = preload("kind = \"spring_damper\"\nstiffness = 2e5\npreload = -5e3");
    assert!((spring.quantity(0, &(&bodies[..]).into(), &[]) + 5e3).abs() < 1e-9);
    let bushing = preload("kind = \"bushing\"\nstiffness = [1e6, 1e6, 1e6]\npreload = [0, 100, -2e4]");
    let forces: Vec<f64> = (0..3).map(|i| bushing.quantity(i, &(&bodies[..]).into(), &[])).collect();
    assert!((Vector3::from_column_slice(&forces) - Vector3::new(0.0, 100.0, -2e4)).norm() < 1e-9);
}

/// All elements in one system: no allocation in a right-hand side; the time of each is printed.
#[test]
fn prop_right_hand_side_does_not_allocate() {
    let stage = stage(1.0);
    let mut system = Mechanism::new(vec![brick(100.0, 10.0, 20.0, 30.0), brick(300.0, 40.0, 50.0, 60.0)], samples(&stage));
    let y = system.state(&stage.design(), &[0.01; 12]);
    assert_eq!(
        y.len(),
        24 + 5 + 7 + 8 + 4 + 1 + 6 + 1,
        "two air springs, two wedges, two Maxwell dampers, one friction in a line and one in a plane; two rotors and two behind cardan shafts, three brakes; two track brakes, two twists, an actuator that lags"
    );
    let mut dy = vec![0.0; y.len()];
    let before = counting::count();
    system.derivative(0.0, &y, &mut dy).unwrap();
    assert_eq!(counting::count() - before, 0);
}
