//! The cardan drive between three bodies: its books, its reactions, its frequency, its changes.

use super::stage::{Mechanism, Stage, apply_under, brick, under};
use super::tangent::{Random, changes, wheelset, worst};
use nalgebra::Vector3;
use std::f64::consts::PI;
use wheelrail::mbs::body::{Body, BodyMotion, COORDINATES};
use wheelrail::mbs::force::ForceElement;
use wheelrail::mbs::system::System;

/// Car, bogie frame with the torque arm 0.6 m ahead of the axle, axle.
fn stage() -> Stage {
    let centres = vec![Vector3::new(4.0, 0.0, 1.6), Vector3::new(1.2, 0.0, 0.6), Vector3::new(0.0, 0.0, 0.5)];
    let places = vec![
        ("motor", Some(0), Vector3::new(2.5, 0.0, 1.0)),
        ("arm", Some(1), Vector3::new(0.6, 0.1, 0.7)),
        ("behind", Some(1), Vector3::new(-0.6, 0.1, 0.7)),
        ("above", Some(1), Vector3::new(0.02, 0.0, 1.0)),
        ("axle", Some(2), Vector3::new(0.0, 0.0, 0.5)),
        ("world", None, Vector3::zeros()),
    ];
    Stage { centres, places, mirror: 1.0 }
}

const RATIO: f64 = 3.2;
const INERTIA: f64 = 5.0;
const STIFFNESS: f64 = 3e5;

fn drive(settings: &str) -> Box<dyn ForceElement> {
    let arm = if settings.contains("arm =") { "" } else { "arm = \"arm\"\n" };
    stage().element(&format!(
        "name = \"e\"\nkind = \"cardan_drive\"\nfrom = \"motor\"\nto = \"axle\"\n{arm}ratio = {RATIO}\nrotor_inertia = {INERTIA}\nstiffness = {STIFFNESS:e}\n{settings}"
    ))
}

const AXIAL: f64 = 120.0;

fn bodies() -> Vec<Body> {
    vec![brick(30e3, 50e3, 1e6, 1e6), brick(2600.0, 1500.0, 2500.0, 3500.0), wheelset(1500.0, 800.0, AXIAL)]
}

fn moving(q: &[f64], v: &[f64]) -> Vec<BodyMotion> {
    let of = |(body, data): (usize, &Body)| data.motion(&q[COORDINATES * body..][..COORDINATES], &v[COORDINATES * body..][..COORDINATES]);
    bodies().iter().enumerate().map(of).collect()
}

/// Random small deviations, velocities with a spinning axle, states.
fn random(random: &mut Random) -> [Vec<f64>; 3] {
    let q = stage().design().iter().map(|q| q + 0.05 * random.next()).collect();
    let mut v: Vec<f64> = (0..18).map(|_| 0.5 * random.next()).collect();
    v[17] = 60.0;
    [q, v, vec![0.02 * random.next(), 0.3 + 0.1 * random.next()]]
}

/// Forces sum up to zero, moments to what the rotor's momentum takes; power is what the motor brings in less what is stored and heat: in any position and motion of three bodies.
#[test]
fn prop_a_cardan_drive_keeps_momentum_and_energy() {
    let mut numbers = Random(4);
    for settings in ["damping = 300", "turns = \"anticlockwise\"\ndamping = 0", "arm = \"behind\"\ndamping = 900"] {
        let drive = drive(settings);
        for _ in 0..40 {
            let ([q, v, state], inputs) = (random(&mut numbers), [2e3 * numbers.next()]);
            let now = moving(&q, &v);
            let (wrenches, rates) = apply_under(drive.as_ref(), &now, &state, &inputs);
            let scale = wrenches.iter().map(|wrench| wrench.force.norm() + wrench.moment.norm()).fold(1.0, f64::max);
            let along = |h: f64| -> (Vec<f64>, Vec<f64>) {
                let q = q.iter().zip(&v).map(|(q, v)| q + h * v).collect();
                (q, state.iter().zip(&rates).map(|(state, rate)| state + h * rate).collect())
            };
            let momentum = |h: f64| {
                let (q, state) = along(h);
                drive.angular_momentum(&under(&moving(&q, &v), &inputs), &state)
            };
            let taken = (momentum(1e-6) - momentum(-1e-6)) / 2e-6;
            let force: Vector3<f64> = wrenches.iter().map(|wrench| wrench.force).sum();
            let moment: Vector3<f64> = now.iter().zip(&wrenches).map(|(body, w)| w.moment + body.position.cross(&w.force)).sum();
            assert!(force.norm() < 1e-13 * scale && (moment + taken).norm() < 1e-7 * scale, "{force} {moment} {taken}");
            let stored = |h: f64| {
                let (q, state) = along(h);
                drive.potential_energy(&under(&moving(&q, &v), &inputs), &state)
            };
            let storing = (stored(1e-6) - stored(-1e-6)) / 2e-6;
            let power: f64 = now.iter().zip(&wrenches).map(|(body, w)| w.force.dot(&body.velocity) + w.moment.dot(&body.rotation)).sum();
            let seen = under(&now, &inputs);
            let (heat, supplied) = (drive.dissipated_power(&seen, &state), drive.supplied_power(&seen, &state));
            let scale = power.abs() + storing.abs() + heat + supplied.abs();
            assert!(
                heat >= 0.0 && scale > 1.0 && (power + storing + heat - supplied).abs() < 1e-6 * scale,
                "{power} {storing} {heat} {supplied}"
            );
        }
    }
}

/// With the shaft's torque S in balance with the motor's, M = S: n S drives the axle, n S / L lifts the frame at the arm ahead of it, the axle is pressed down there; S rolls the axle, to the right where the shaft
/// turns clockwise, and the car to the left.
#[test]
fn analytic_a_cardan_drive_loads_car_frame_and_axle() {
    let (torque, lever) = (1500.0, 0.6);
    for (settings, sense, arm) in [("", 1.0, lever), ("turns = \"anticlockwise\"", -1.0, lever), ("arm = \"behind\"", 1.0, -lever)] {
        let drive = drive(settings);
        let q = stage().design();
        let mut v = vec![0.0; 18];
        v[17] = 30.0;
        let now = moving(&q, &v);
        let inputs = [torque];
        let mut state = [0.0; 2];
        drive.settle(&under(&now, &inputs), &mut state);
        state[0] = torque / STIFFNESS;
        let (on, rates) = apply_under(drive.as_ref(), &now, &state, &inputs);
        let [car, frame, axle] = [0, 1, 2].map(|body| on[body]);
        assert!(rates.iter().all(|rate| rate.abs() < 1e-9), "{rates:?}");
        assert!(car.force.norm() == 0.0 && (car.moment + Vector3::x() * (sense * torque)).norm() < 1e-9, "{car:?}");
        assert!((frame.force - Vector3::z() * (RATIO * torque / arm)).norm() < 1e-9 && (axle.force + frame.force).norm() < 1e-9);
        assert!((axle.moment.y - RATIO * torque).abs() < 1e-9, "{axle:?}");
        // The arm is 0.1 m left of the axle's middle: its force rolls the axle too.
        assert!((axle.moment.x - (sense * torque - 0.1 * RATIO * torque / arm)).abs() < 1e-9, "{axle:?}");
        let seen = under(&now, &inputs);
        let value = |name: &str| drive.quantity(drive.quantities().iter().position(|q| q.name == name).unwrap(), &seen, &state);
        let expected = [
            ("axleTorque", RATIO * torque),
            ("axleSpeed", 30.0),
            ("motorSpeed", RATIO * 30.0),
            ("power", RATIO * 30.0 * torque),
            ("twist", torque / STIFFNESS),
            ("shaftTorque", torque),
            ("armForce", RATIO * torque / arm),
        ];
        for (name, expected) in expected {
            assert!((value(name) / expected - 1.0).abs() < 1e-9, "{name}: {} {expected}", value(name));
        }
    }
}

/// Car and frame far heavier than all else, the axle held (a holder of 1e11 N/m, on which the arm leans, makes 4e-5 less): rotor and axle swing with sqrt(k (1/J + n^2/I)), found to 1e-6 in the zeros of the twist; with the motor on, after whole periods their common
/// speed is n M t / (I + n^2 J).
#[test]
fn analytic_a_cardan_shaft_swings_with_its_frequency() {
    let rock = || brick(1e15, 1e15, 1e15, 1e15);
    let held = stage().element("name = \"h\"\nkind = \"bushing\"\nfrom = \"arm\"\nto = \"axle\"\nstiffness = [3e13, 3e13, 3e13]\nrotational_stiffness = [3e13, 0, 3e13]");
    let mut mechanism = Mechanism::new(vec![rock(), rock(), wheelset(1500.0, 800.0, AXIAL)], vec![drive(""), held]);
    let omega = (STIFFNESS * (1.0 / INERTIA + RATIO * RATIO / AXIAL)).sqrt();
    let mut start = mechanism.state(&stage().design(), &[0.0; 18]);
    let twist = start.len() - 3;
    start[twist] = 2e-3;
    // A cosine: its zero after 10 1/4 periods, by the secant through two instants beside it.
    let expected = 10.25 * 2.0 * PI / omega;
    let [early, late] = [expected - 2e-5, expected + 2e-5].map(|time| mechanism.run(&start, time, 1e-11)[twist]);
    let found = expected - 2e-5 + 4e-5 * early / (early - late);
    println!("{:.6} Hz, formula {:.6} Hz", 10.25 / found, omega / (2.0 * PI));
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    mechanism.workspace.inputs[0] = 400.0;
    start[twist] = 0.0;
    let time = 10.0 * 2.0 * PI / omega;
    let end = mechanism.run(&start, time, 1e-11);
    let speed = RATIO * 400.0 * time / (AXIAL + RATIO * RATIO * INERTIA);
    assert!((end[35] / speed - 1.0).abs() < 1e-5, "{} {speed}", end[35]);
    assert!(mechanism.energy(&end).abs() < 1e-6 * RATIO * 400.0 * speed * time, "{}", mechanism.energy(&end));
}

/// Changes of forces on all three bodies and of the states with the motion of all three, against differences: of displacements at rest, of velocities and states in motion.
#[test]
fn analytic_changes_of_a_cardan_drive_match_differences() {
    let mut numbers = Random(9);
    let (mut at_rest, mut moving): (f64, f64) = (0.0, 0.0);
    for settings in ["damping = 300", "turns = \"anticlockwise\"\ndamping = 40", "arm = \"behind\"\ndamping = 900"] {
        let system = System {
            bodies: bodies(),
            forces: vec![drive(settings)],
            drives: vec![],
            supported: vec![],
            joints: vec![],
            redundant: vec![],
        };
        for _ in 0..20 {
            let ([q, v, state], inputs) = (random(&mut numbers), [2e3 * numbers.next()]);
            let still = changes(&system, &[q.clone(), vec![0.0; 18], state.clone()].concat(), &inputs);
            at_rest = at_rest.max(worst(&system, &still, 0..18));
            let found = changes(&system, &[q, v, state].concat(), &inputs);
            moving = moving.max(worst(&system, &found, 18..found[0].ncols()));
        }
    }
    println!("relative error by displacements at rest {at_rest:.1e}, by velocities and states {moving:.1e}");
    assert!(at_rest < 1e-5 && moving < 1e-5, "{at_rest:e} {moving:e}");
}

/// The linear system with three bodies coupled through one element is solved as a dense one.
#[test]
fn equiv_three_bodies_are_eliminated_like_a_dense_matrix() {
    use super::tangent::{dense, linearise};
    use nalgebra::{DMatrix, DVector};
    use wheelrail::mbs::tangent::Tangent;
    let system = System {
        bodies: bodies(),
        forces: vec![drive("damping = 300")],
        drives: vec![],
        supported: vec![],
        joints: vec![],
        redundant: vec![],
    };
    let mut numbers = Random(5);
    let [q, v, state] = random(&mut numbers);
    let y = [q, v, state].concat();
    let (mut workspace, mut tangent) = (system.workspace(&[]), Tangent::new(&system, &[], 0));
    linearise(&system, &mut workspace, &y, &mut tangent);
    let j = dense(&tangent, y.len());
    for a in [1e-4, 3e-3, 0.05] {
        tangent.factorise(a, &workspace).unwrap();
        let right = DVector::from_fn(y.len(), |_, _| numbers.next());
        let expected = (DMatrix::identity(y.len(), y.len()) - &j * a).lu().solve(&right).unwrap();
        let mut found = right.as_slice().to_vec();
        tangent.solve(&mut found);
        let error = (DVector::from_vec(found) - &expected).amax() / expected.amax();
        assert!(error < 1e-10, "{a}: {error:e}");
    }
}

#[test]
fn prop_wrong_settings_of_cardan_drives_are_refused() {
    let good = "name = \"e\"\nkind = \"cardan_drive\"\nratio = 3\nrotor_inertia = 4\nstiffness = 1e5\n";
    for (ends, key, word) in [
        ("from = \"motor\"\nto = \"axle\"\narm = \"above\"", "arm", "along the track"),
        ("from = \"world\"\nto = \"axle\"\narm = \"arm\"", "from", "world"),
        ("from = \"axle\"\nto = \"axle\"\narm = \"arm\"", "from", "same body"),
        ("from = \"motor\"\nto = \"axle\"\narm = \"axle\"", "to", "same body"),
        ("from = \"motor\"\nto = \"axle\"\narm = \"world\"", "arm", "world"),
        ("from = \"motor\"\nto = \"axle\"\narm = \"arm\"\nturns = \"left\"", "turns", "clockwise"),
        ("from = \"motor\"\nto = \"axle\"\narm = \"arm\"\nwheel = \"left\"", "wheel", "wheel"),
    ] {
        let error = stage().read(&format!("{good}{ends}")).unwrap_err().to_string();
        assert!(error.contains(key) && error.contains(word), "{ends}: {error}");
    }
    assert!(stage().read(&format!("{good}from = \"motor\"\nto = \"axle\"\narm = \"arm\"")).is_ok());
}
