//! Wheels that turn against each other: the twist alone, and with brakes and motors on single wheels.

use super::stage::{Mechanism, Stage, brick};
use super::tangent::{Random, dense, linearise, wheelset};
use nalgebra::{DMatrix, Vector3};
use wheelrail::mbs::body::{Body, COORDINATES};
use wheelrail::mbs::force::ForceElement;
use wheelrail::mbs::system::System;
use wheelrail::mbs::tangent::Tangent;
use wheelrail::mbs::twist::{Axles, Twist};

/// About the axle, kg m2.
const AXIAL: f64 = 120.0;

fn stage() -> Stage {
    let places = vec![("axle", Some(0), Vector3::new(0.0, 0.0, 0.46)), ("frame", Some(1), Vector3::new(0.5, 0.1, 0.7))];
    Stage { centres: vec![Vector3::new(0.0, 0.0, 0.46), Vector3::new(1.2, 0.0, 0.8)], places, mirror: 1.0 }
}

/// A wheelset and a frame with elements that know them.
fn system(elements: &[&str]) -> System {
    let stage = stage();
    let bodies: Vec<Body> = vec![wheelset(1500.0, 800.0, AXIAL), brick(2600.0, 1500.0, 2000.0, 2500.0)];
    let mut forces: Vec<Box<dyn ForceElement>> = elements.iter().map(|text| stage.element(&format!("name = \"e\"\n{text}"))).collect();
    let twisted: Vec<usize> = forces.iter().filter_map(|force| force.twist()).map(|twist| twist.body).collect();
    forces.iter_mut().for_each(|force| force.fit(&Axles { bodies: &bodies, twisted: &twisted }));
    System { bodies, forces, drives: vec![], supported: vec![], joints: vec![], redundant: vec![] }
}

/// Coordinates and velocities at rest in the design configuration.
fn still() -> [Vec<f64>; 2] {
    [stage().design(), vec![0.0; 2 * COORDINATES]]
}

/// `tau'' + 2 d tau' + w^2 tau = 0` with `w^2 = k (1/J_l + 1/J_r)`, `2 d = c (1/J_l + 1/J_r)`, beside a spin of the whole axle that it does not change.
#[test]
fn analytic_an_axle_swings_in_torsion() {
    for (stiffness, damping, share) in [(5e6, 0.0, 0.5), (5e6, 900.0, 0.3), (2e4, 50.0, 0.8)] {
        let keys = format!("kind = \"flexible_axle\"\nbody = \"axle\"\nstiffness = {stiffness}\ndamping = {damping}\nleft_share = {share}");
        let mut mechanism = Mechanism::of(system(&[&keys]));
        let [q, mut v] = still();
        v[5] = 40.0;
        let mut y = mechanism.state(&q, &v);
        (y[24], y[25]) = (0.01, 0.0);
        let softness = 1.0 / (share * AXIAL) + 1.0 / ((1.0 - share) * AXIAL);
        let (decay, square) = (0.5 * damping * softness, stiffness * softness);
        let frequency = (square - decay * decay).sqrt();
        let before = mechanism.energy(&y);
        for periods in [0.25, 1.0, 3.4] {
            let t = periods * std::f64::consts::TAU / frequency;
            let found = mechanism.run(&y, t, 1e-11);
            let (sin, cos) = (frequency * t).sin_cos();
            let expected = 0.01 * (-decay * t).exp() * (cos + decay / frequency * sin);
            println!(
                "k {stiffness:e}, c {damping}: {:.3} Hz, twist {:.9} rad, formula {expected:.9}",
                frequency / std::f64::consts::TAU,
                found[24]
            );
            assert!((found[24] - expected).abs() < 1e-8, "{found:?}");
            assert!((found[12 + 5] - 40.0).abs() < 1e-12, "the axle as a whole goes on");
            assert!((mechanism.energy(&found) / before - 1.0).abs() < 1e-9);
        }
    }
}

/// A brake on one independent wheel slows down that wheel by M / J and the other by nothing; its reaction turns the frame.
#[test]
fn analytic_a_brake_on_one_wheel_leaves_the_other_alone() {
    for (share, side) in [(0.5, "left"), (0.3, "left"), (0.3, "right")] {
        let axle = format!("kind = \"independent_wheels\"\nbody = \"axle\"\nleft_share = {share}");
        let brake = format!("kind = \"brake\"\ntype = \"disc\"\nstiffness = 1e6\nfrom = \"frame\"\nto = \"axle\"\nwheel = \"{side}\"");
        let mut mechanism = Mechanism::of(system(&[&axle, &brake]));
        mechanism.workspace.inputs[0] = 500.0;
        let [q, mut v] = still();
        v[5] = 40.0;
        let y = mechanism.state(&q, &v);
        let speeds = |mechanism: &mut Mechanism, y: &[f64]| {
            mechanism.system.move_bodies(y, &mut mechanism.workspace);
            [0, 1].map(|k| mechanism.system.forces[0].quantity(k, &mechanism.workspace.moving(), &y[24..26]))
        };
        let before = mechanism.energy(&y);
        // Once the brake has taken hold.
        let ends = [0.1, 0.6].map(|t| mechanism.run(&y, t, 1e-10));
        let found = ends.each_ref().map(|y| speeds(&mut mechanism, y));
        let (own, other, inertia) = if side == "left" { (0, 1, share * AXIAL) } else { (1, 0, (1.0 - share) * AXIAL) };
        let slowing = (found[0][own] - found[1][own]) / 0.5;
        println!("{side} of {share}: {slowing:.6} rad/s2, M / J {:.6}; the other one at {:.9} rad/s", 500.0 / inertia, found[1][other]);
        assert!((slowing / (500.0 / inertia) - 1.0).abs() < 1e-5);
        assert!((found[1][other] - 40.0).abs() < 1e-9);
        let frame = ends.each_ref().map(|y| y[12 + 11]);
        assert!(((frame[1] - frame[0]) * 2000.0 / (500.0 * 0.5) - 1.0).abs() < 1e-5, "{frame:?}");
        assert!((mechanism.energy(&ends[1]) / before - 1.0).abs() < 1e-7);
    }
}

const SYSTEMS: [&[&str]; 4] = [
    &["kind = \"flexible_axle\"\nbody = \"axle\"\nstiffness = 3e5\ndamping = 70\nleft_share = 0.35"],
    &[
        "kind = \"independent_wheels\"\nbody = \"axle\"\ndamping = 20",
        "kind = \"brake\"\ntype = \"disc\"\nstiffness = 2e5\nrelaxation = 0.1\nfrom = \"frame\"\nto = \"axle\"\nwheel = \"right\"",
    ],
    &[
        "kind = \"motor_gear\"\nmount = \"shaft\"\nratio = 4\nrotor_inertia = 3\nstiffness = 1e5\ndamping = 900\nfrom = \"frame\"\nto = \"axle\"\nwheel = \"left\"",
        "kind = \"brake\"\ntype = \"tread\"\nfriction = 0.3\nstiffness = 2e5\nrelaxation = 0.1\nfrom = \"frame\"\nto = \"axle\"\nwheel = \"left\"",
        "kind = \"flexible_axle\"\nbody = \"axle\"\nstiffness = 3e5\nleft_share = 0.6",
        "kind = \"brake\"\ntype = \"disc\"\nstiffness = 2e5\nfrom = \"frame\"\nto = \"axle\"",
    ],
    &[
        "kind = \"motor_gear\"\nmount = \"shaft\"\nratio = 4\nfrom = \"frame\"\nto = \"axle\"\nwheel = \"left\"",
        "kind = \"motor_gear\"\nmount = \"nose\"\nratio = 4\nrotor_inertia = 3\nstiffness = 1e5\ndamping = 900\nfrom = \"frame\"\nto = \"axle\"",
        "kind = \"independent_wheels\"\nbody = \"axle\"\nleft_share = 0.6",
    ],
];

/// A state in motion, with what the inputs ask for.
fn moving(system: &System, random: &mut Random) -> (Vec<f64>, Vec<f64>) {
    let mut y = stage().design();
    y.iter_mut().for_each(|q| *q += 0.02 * random.next());
    y.extend((0..system.dimension() - y.len()).map(|i| if i < 2 * COORDINATES { random.next() } else { 0.02 * random.next() }));
    y[12 + 5] += 6.0;
    let inputs = (0..system.force_inputs()).map(|_| 4e3 * (1.0 + 0.5 * random.next())).collect();
    (y, inputs)
}

/// Every column by velocity and state, and the way back through I - a J.
#[test]
fn analytic_changes_with_twists_match_differences() {
    let mut random = Random(11);
    for elements in SYSTEMS {
        let system = system(elements);
        let mut workspace = system.workspace(&[]);
        for _ in 0..10 {
            let (y, inputs) = moving(&system, &mut random);
            workspace.inputs.copy_from_slice(&inputs);
            let mut tangent = Tangent::new(&system, &[], 0);
            linearise(&system, &mut workspace, &y, &mut tangent);
            let own = dense(&tangent, y.len());
            let mut exact = DMatrix::zeros(y.len(), y.len());
            for j in 0..y.len() {
                let h = if j < 24 { 1e-5 } else { 1e-6 };
                let mut at = |sign: f64| {
                    let (mut moved, mut dy) = (y.clone(), vec![0.0; y.len()]);
                    moved[j] += sign * h;
                    system.apply_forces(&moved, &mut workspace);
                    system.constrained_derivative(0.0, &moved, &mut workspace, &mut dy).unwrap();
                    dy
                };
                let (ahead, behind) = (at(1.0), at(-1.0));
                exact.column_mut(j).iter_mut().zip(ahead.iter().zip(&behind)).for_each(|(value, (a, b))| *value = (a - b) / (2.0 * h));
            }
            for i in 12..y.len() {
                let (a, b) = (own.row(i).columns_range(12..).into_owned(), exact.row(i).columns_range(12..).into_owned());
                // Gyroscopic terms of the frame, which does not spin fast, are left out: 1 rad/s.
                let (error, scale) = ((&a - &b).amax(), b.amax());
                assert!(error < 1e-5 * scale + if i < 24 { 3.0 } else { 1e-6 }, "{elements:?} row {i}: {a} {b}");
            }
            for a in [1e-4, 3e-3, 0.5] {
                tangent.factorise(a, &workspace).unwrap();
                let x: Vec<f64> = (0..y.len()).map(|_| random.next()).collect();
                let mut image = vec![0.0; y.len()];
                tangent.times(&x, &mut image);
                let mut back: Vec<f64> = x.iter().zip(&image).map(|(x, jx)| x - a * jx).collect();
                tangent.solve(&mut back);
                let error = x.iter().zip(&back).map(|(x, back)| (x - back).abs()).fold(0.0, f64::max);
                assert!(error < 1e-7, "{elements:?}, a = {a}: {error:.1e}");
            }
        }
    }
}

/// What cannot be is refused where it stands; shares at their bounds are taken.
#[test]
fn prop_wrong_settings_of_twists_are_refused() {
    let places = "from = \"frame\"\nto = \"axle\"\n";
    let cases = [
        ("kind = \"flexible_axle\"\nbody = \"axle\"\nstiffness = 0".to_string(), "stiffness"),
        ("kind = \"flexible_axle\"\nbody = \"axle\"".to_string(), "stiffness"),
        ("kind = \"flexible_axle\"\nbody = \"axle\"\nstiffness = 1e6\ndamping = -1".to_string(), "damping"),
        ("kind = \"flexible_axle\"\nbody = \"axle\"\nstiffness = 1e6\nleft_share = 0".to_string(), "left_share"),
        ("kind = \"independent_wheels\"\nbody = \"axle\"\nleft_share = 1".to_string(), "left_share"),
        ("kind = \"independent_wheels\"\nbody = \"axle\"\nstiffness = 1e6".to_string(), "stiffness"),
        (format!("kind = \"motor_gear\"\nmount = \"nose\"\nratio = 3\nwheel = \"left\"\n{places}"), "wheel"),
        (format!("kind = \"brake\"\ntype = \"disc\"\nstiffness = 1e6\nwheel = \"front\"\n{places}"), "wheel"),
        ("kind = \"magnetic_track_brake\"\non = \"frame\"\nfriction = 0.3\nstiffness = 1e7".to_string(), "rise_time"),
        ("kind = \"magnetic_track_brake\"\non = \"frame\"\nfriction = 0.3\nstiffness = 1e7\nrise_time = 0".to_string(), "rise_time"),
        (
            "kind = \"magnetic_track_brake\"\non = \"frame\"\nfriction = 0.3\nhalf_speed = 3\nstiffness = 1e7\nrise_time = 0.1".to_string(),
            "sliding_friction",
        ),
    ];
    for (text, key) in cases {
        let error = stage().read(&format!("name = \"e\"\n{text}\n")).err().map(|error| error.to_string()).unwrap_or_default();
        println!("{error}");
        assert!(error.contains(key), "{text}: {error}");
    }
    let least = stage().element("name = \"e\"\nkind = \"independent_wheels\"\nbody = \"axle\"\nleft_share = 0.01\n");
    assert_eq!(least.twist().map(|twist: Twist| twist.left_share), Some(0.01));
}

/// Sliding at a constant speed: the force rises to mu(v) A with the rise time; released it falls as A does; at rest it holds up to M.
#[test]
fn analytic_a_magnetic_track_brake_rises_slides_and_holds() {
    let text = "kind = \"magnetic_track_brake\"\non = \"frame\"\nfriction = 0.35\nsliding_friction = 0.1\nhalf_speed = 5\nrise_time = 0.15\nstiffness = 2e7";
    // So heavy that it goes on as it is.
    let bodies = vec![brick(1.0, 1.0, 1.0, 1.0), brick(1e12, 1e12, 1e12, 1e12)];
    let mut mechanism = Mechanism::new(bodies, vec![stage().element(&format!("name = \"e\"\n{text}\n"))]);
    mechanism.workspace.inputs[0] = 6e4;
    for speed in [20.0, 3.0, -8.0f64] {
        let [q, mut v] = still();
        v[6] = speed;
        let y = mechanism.state(&q, &v);
        for t in [0.05, 0.3, 2.0] {
            let found = mechanism.run(&y, t, 1e-9);
            mechanism.system.move_bodies(&found, &mut mechanism.workspace);
            let force = mechanism.system.forces[0].quantity(0, &mechanism.workspace.with_inputs(0..1), &found[24..26]);
            let attraction = 6e4 * (1.0 - (-t / 0.15f64).exp());
            let expected = -(0.1 + 0.25 / (1.0 + speed.abs() / 5.0)) * attraction * speed.signum();
            println!("{speed} m/s, {t} s: {force:.1} N, formula {expected:.1} N");
            // While it still rises the deflection follows it, and its damper adds to it.
            assert!(
                (force / expected - 1.0).abs()
                    < if t < 0.1 {
                        0.1
                    } else if t < 1.0 {
                        0.03
                    } else {
                        1e-4
                    },
                "{force} {expected}"
            );
        }
    }
    // 5 kN pull on 10 t at rest; twice as much in the first swing is below 0.7 x 0.35 x 60 kN: it dies away, nothing creeps.
    let pull = stage().element("name = \"pull\"\nkind = \"external_load\"\non = \"frame\"\n");
    let brake = stage().element(&format!("name = \"e\"\n{text}\nattraction = 6e4\n"));
    let mut mechanism = Mechanism::new(vec![brick(1.0, 1.0, 1.0, 1.0), brick(1e4, 1e12, 1e12, 1e12)], vec![brake, pull]);
    mechanism.workspace.inputs[0] = 6e4;
    let [q, v] = still();
    let y = mechanism.state(&q, &v);
    let closed = mechanism.run(&y, 2.0, 1e-10);
    mechanism.workspace.inputs[1] = 5e3;
    let held = mechanism.run(&closed, 3.0, 1e-10);
    let later = mechanism.run(&held, 5.0, 1e-10);
    println!("deflected by {:.6} mm, {:.1e} m more after 5 s", 1e3 * (held[6] - closed[6]), later[6] - held[6]);
    assert!(((held[6] - closed[6]) / (5e3 / 2e7) - 1.0).abs() < 0.05 && (later[6] - held[6]).abs() < 1e-8);
}
