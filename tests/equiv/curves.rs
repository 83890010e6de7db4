//! Curved track: forces in a steady curve, invariance, and the four formulations on the same curve.

use crate::common;
use crate::common::{column, largest_difference, read, start, table};
use nalgebra::Vector3;
use std::sync::Arc;
use wheelrail::formulation::Evaluation;
use wheelrail::geometry::track::centre_line::{Alignment, CentreLine, Node};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::recording::Recording;

const FORMULATIONS: [&str; 4] = ["ECF-A", "ECF-N", "ECCF", "ACCF"];

fn curve(changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    let file = common::data("scenes/curve.toml");
    load::open(file.to_str().unwrap(), &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn lay(scene: &mut Scene, alignment: Alignment, origin: Vector3<f64>, heading: f64) {
    scene.track.line = CentreLine::new(&alignment, origin, heading).map(Arc::new);
    scene.track.alignment = Some(alignment);
}

/// The line of a scene with another start.
fn moved(mut scene: Scene, origin: Vector3<f64>, heading: f64) -> Scene {
    let alignment = scene.track.alignment.clone().unwrap_or_default();
    lay(&mut scene, alignment, origin, heading);
    scene
}

fn differences(a: &Recording, b: &Recording, names: &[(&str, f64)]) {
    for (name, allowed) in names {
        let difference = largest_difference(&column(a, name), &column(b, name));
        println!("{name}: {difference:.1e}");
        assert!(difference <= *allowed, "{name}: {difference:e} instead of at most {allowed:e}");
    }
}

const RADIUS: f64 = 582.192_365;
const BASE: f64 = 1.432;
const HEIGHT: f64 = 0.0762;
/// Distance in which a wheelset settles, m.
const SETTLING: f64 = 900.0;

/// A wheelset that has settled in a long curve: its forces in the track frame against Newton's law for its centre, which moves on a
/// circle of radius R_P = R - (y cos f - z sin f) with the speed V:
/// along Y: F = m (V^2 / R_P cos f + g sin f), along Z: F = m (g cos f - V^2 / R_P sin f), f < 0 the cant of a left-hand curve.
#[test]
fn analytic_forces_in_a_steady_curve() {
    let cant = -(HEIGHT / BASE).asin();
    let (mass, g, load) = (1568.0, 9.81, 98000.0);
    let balance = (g * RADIUS * HEIGHT / (BASE * BASE - HEIGHT * HEIGHT).sqrt()).sqrt();
    for (speed, formulation) in [(15.0, "ECF-A"), (balance, "ECF-A"), (25.0, "ECF-A"), (balance, "ECCF")] {
        let mut scene = curve(&[
            &format!("vehicle.speed={speed}"),
            "vehicle.initial.distance=100",
            "solver.tolerance=1e-9",
            &format!("contact.formulation={formulation}"),
        ]);
        let node = Node { curvature: 1.0 / RADIUS, superelevation: cant, ..Node::default() };
        lay(&mut scene, Alignment { nodes: vec![node], ..Alignment::default() }, Vector3::zeros(), 0.0);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let duration = SETTLING / speed;
        simulation.advance(duration).unwrap();
        let at = read(&mut simulation, &outputs);
        let sum = |name: &str| at[&format!("left.{name}")] + at[&format!("right.{name}")];
        let springs: f64 = ["left", "right"].iter().map(|side| at[&format!("suspension.{side}.lateralForce")]).sum();
        // With the vertical load, whose mass goes round on the centre line.
        let inside = (at["y"] * cant.cos() - at["z"] * cant.sin()) / RADIUS;
        let outward = load / g * speed * speed / (1.0 - inside) / RADIUS;
        let lateral = sum("lateralForce") + springs - load * cant.sin() - outward * cant.cos();
        let vertical = sum("verticalForce") - load * cant.cos() + outward * cant.sin();
        let radius = RADIUS - (at["y"] * cant.cos() - at["z"] * cant.sin());
        let centripetal = speed * speed / radius;
        let expected = [mass * (centripetal * cant.cos() + g * cant.sin()), mass * (g * cant.cos() - centripetal * cant.sin())];
        println!(
            "{formulation} V {speed:.3} m/s: y {:.3} mm, yaw {:.3} mrad, lateral {lateral:.4} N ({:.4}), vertical {vertical:.4} N ({:.4})",
            1e3 * at["y"],
            1e3 * at["yaw"],
            expected[0],
            expected[1]
        );
        assert!(at["vy"].abs() < 1e-7 && at["yawRate"].abs() < 1e-7, "it must have settled: {} {}", at["vy"], at["yawRate"]);
        assert!((lateral - expected[0]).abs() < 0.02 && (vertical - expected[1]).abs() < 0.02);
        assert!((at["ay"] - centripetal * cant.cos()).abs() < 1e-5 && (at["vx"] - speed).abs() < 1e-9);
        // The share that the centre's own place makes of the balance: m V^2 / R (R / R_P - 1).
        let of_centre = mass * speed * speed * cant.cos() * (1.0 / radius - 1.0 / RADIUS);
        assert!(speed != balance || (lateral - of_centre).abs() < 0.02, "{lateral} {of_centre}");
        // All that wheels and springs take: at the balance speed only those parts of the mean radius are left.
        let net = sum("lateralForce") + springs;
        let expected_net = of_centre + load / g * speed * speed / RADIUS * cant.cos() * (1.0 / (1.0 - inside) - 1.0);
        println!("net lateral force {net:.3} N ({expected_net:.3})");
        assert!(speed != balance || (net - expected_net).abs() < 0.05, "{net} {expected_net}");
        let drive = at["drivingForce"] + sum("longitudinalForce") + 0.0;
        let along: f64 = ["left", "right"].iter().map(|side| at[&format!("suspension.{side}.longitudinalForce")]).sum();
        assert!((drive + along).abs() < 0.02, "{drive} {along}");
        // Distance grows by s' = V / (1 - (P - C) . X_s).
        let travelled = (at["distance"] - 100.0) / SETTLING;
        assert!((travelled - 1.0 - inside).abs() < 1e-5, "{travelled} {inside}");
    }
}

/// A straight track that runs in another direction from another place: whatever is done for curves must leave it what it is.
#[test]
fn equiv_turned_straight_track_is_straight_track() {
    for formulation in FORMULATIONS {
        let changes = [format!("contact.formulation={formulation}"), "solver.tolerance=1e-11".into()];
        let plain = common::scene(&changes.each_ref().map(String::as_str));
        let turned = moved(common::scene(&changes.each_ref().map(String::as_str)), Vector3::new(300.0, -20.0, 5.0), 2.0);
        let (a, b) = (common::run(&plain, 1.5, 0.01), common::run(&turned, 1.5, 0.01));
        println!("{formulation}");
        let loose = if formulation == "ECF-N" { 1e3 } else { 1.0 };
        let names = [
            ("distance", 1e-9),
            ("y", 1e-9),
            ("z", 1e-10),
            ("yaw", 1e-9),
            ("roll", 1e-10),
            ("vx", 1e-8),
            ("pitchRate", 1e-7),
            ("left.contact[1].railDistance", 1e-8),
            ("left.contact[1].longitudinalCreepage", 1e-8),
        ];
        differences(&a, &b, &names.map(|(name, allowed)| (name, loose * allowed)));
        // Normal forces jump at the ends of the deviation (50 and 75 rows down).
        for name in ["left.verticalForce", "right.lateralForce", "suspension.left.longitudinalForce", "drivingForce"] {
            let away = |recording: &Recording| {
                let rows = column(recording, name).into_iter().enumerate().filter(|(row, _)| ![50, 75].contains(row));
                rows.map(|row| row.1).collect::<Vec<_>>()
            };
            let difference = largest_difference(&away(&a), &away(&b));
            println!("{name}: {difference:.1e} N");
            assert!(difference < 0.1 * loose, "{name}: {difference:e}");
        }
    }
}

/// The same with profiles that are searched for several contacts. (ECCF with these ends on straight track too: no solution of the
/// contact equations.)
#[test]
fn equiv_turned_straight_track_with_several_contacts() {
    let scene = || load::open("wheelset_s1002", &["solver.tolerance=1e-9".into()]).unwrap();
    let (a, b) = (common::run(&scene(), 1.5, 0.01), common::run(&moved(scene(), Vector3::new(50.0, -20.0, 5.0), 4.0), 1.5, 0.01));
    differences(&a, &b, &[("y", 1e-7), ("yaw", 1e-7), ("z", 1e-7), ("left.contact[1].wheelCoordinate", 1e-6)]);
}

/// A truck of several bodies on straight track that runs elsewhere: all its outputs stay what they are.
#[test]
fn equiv_turned_straight_track_with_a_truck() {
    let scene = || load::open("bogie", &["solver.tolerance=1e-10".into()]).unwrap();
    let run = |scene: &Scene| {
        let mut simulation = start(scene);
        let outputs = table(&simulation, scene);
        wheelrail::sim::recording::record(&mut simulation, &outputs, 0.3, 0.01, |_| {}).unwrap_or_else(|error| panic!("{error}"))
    };
    let (a, b) = (run(&scene()), run(&moved(scene(), Vector3::new(50.0, -20.0, 5.0), 2.5)));
    // Forces and accelerations that are small at steady running show the rounding of places in the world (1e-14 m).
    let mut worst = (0.0, "");
    for (i, (name, _)) in a.columns.iter().enumerate() {
        let (a, b): (Vec<f64>, Vec<f64>) = a.rows.iter().zip(&b.rows).map(|(a, b)| (a[i], b[i])).unzip();
        let (size, difference) = (a.iter().fold(0.0, |size: f64, value| size.max(value.abs())), largest_difference(&a, &b));
        if difference > 1e-6 * size.max(1.0) {
            println!("{name}: {difference:.1e} of {size:.3e}");
        }
        let least = match () {
            () if name.ends_with("Force") => 1e4,
            () if name.ends_with("Acceleration") || name.ends_with(".ax") => 100.0,
            () => 1.0,
        };
        let difference = difference / size.max(least);
        if difference > worst.0 {
            worst = (difference, name);
        }
    }
    println!("{} outputs, largest difference {:.1e} in {}", a.columns.len(), worst.0, worst.1);
    assert!(worst.0 < 1e-5, "{worst:?}");
}

/// S1002 on 60E1 in a curve of 200 m: the outer flange root must guide, in both directions of the curve alike.
#[test]
fn hard_flange_guides_in_a_tight_curve() {
    let scene = |formulation: &str, hand: f64| {
        let changes = [
            format!("contact.formulation={formulation}"),
            "contact.on_lift=elastic".into(),
            "vehicle.initial.distance=40".into(),
            "vehicle.speed=12".into(),
        ];
        let mut scene = load::open("wheelset_s1002", &changes).unwrap();
        let node =
            |distance, share: f64| Node { distance, curvature: hand * share / 200.0, superelevation: -hand * share * 0.04, grade: 0.0 };
        lay(
            &mut scene,
            Alignment { nodes: vec![node(45.0, 0.0), node(75.0, 1.0)], smoothing: 5.0, ..Alignment::default() },
            Vector3::zeros(),
            0.0,
        );
        scene
    };
    let mut last: Option<(&str, f64)> = None;
    for (formulation, hand, outer, inner) in
        [("ECF-A", 1.0, "right", "left"), ("ECF-A", -1.0, "left", "right"), ("ECCF", 1.0, "right", "left"), ("ACCF", 1.0, "right", "left")]
    {
        let scene = scene(formulation, hand);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        simulation.advance(8.0).unwrap();
        let at = read(&mut simulation, &outputs);
        let guiding = [1, 2].map(|i| at[&format!("{outer}.contact[{i}].normalForce")]);
        let angles = [1, 2].map(|i| at[&format!("{outer}.contact[{i}].angle")]);
        let values = vec![hand * at["y"], hand * at["yaw"], at[&format!("{outer}.verticalForce")], at[&format!("{inner}.verticalForce")]];
        println!("{formulation} {hand}: y, yaw, Q outer, Q inner {values:?}, outer contacts {guiding:?} N at {angles:?} rad");
        assert!(hand * at["y"] < -4e-3, "{}", at["y"]);
        assert!(guiding.iter().zip(angles).any(|(force, angle)| *force > 1e3 && angle > 0.3), "the flange must guide");
        // A constrained tread does not sink in beside its elastic flange: the wheelset lies 0.2 mm further out.
        if let Some((before, y)) = last {
            let bound = match (before, formulation) {
                ("ECF-A", "ECF-A") => 1e-9,
                ("ECCF", "ACCF") => 1e-8,
                _ => 3e-4,
            };
            let difference: f64 = (values[0] - y).abs();
            println!("  {difference:.1e} m from {before}");
            assert!(difference < bound, "{difference:e} m");
        }
        last = Some((formulation, values[0]));
    }
}

/// A curve that starts elsewhere in another direction gives the same.
#[test]
fn prop_start_of_the_track_changes_nothing() {
    for formulation in ["ECF-A", "ACCF", "ECCF"] {
        let scene = || curve(&[&format!("contact.formulation={formulation}"), "solver.tolerance=1e-11"]);
        let a = common::run(&scene(), 5.0, 0.02);
        let b = common::run(&moved(scene(), Vector3::new(-70.0, 900.0, 12.0), -1.3), 5.0, 0.02);
        println!("{formulation}");
        differences(
            &a,
            &b,
            &[("distance", 1e-9), ("y", 1e-9), ("yaw", 1e-9), ("z", 1e-9), ("left.verticalForce", 0.05), ("right.lateralForce", 0.05)],
        );
    }
}

#[test]
fn prop_mirrored_curve_mirrors_the_results() {
    let scene = || curve(&["solver.tolerance=1e-11", "vehicle.initial.y=0.002"]);
    let a = common::run(&scene(), 5.0, 0.02);
    let mut mirrored = curve(&["solver.tolerance=1e-11", "vehicle.initial.y=-0.002"]);
    let mut alignment = mirrored.track.alignment.clone().unwrap();
    for node in &mut alignment.nodes {
        (node.curvature, node.superelevation) = (-node.curvature, -node.superelevation);
    }
    lay(&mut mirrored, alignment, Vector3::zeros(), 0.0);
    let b = common::run(&mirrored, 5.0, 0.02);
    for (name, other, sign) in [
        ("y", "y", -1.0),
        ("yaw", "yaw", -1.0),
        ("z", "z", 1.0),
        ("left.verticalForce", "right.verticalForce", 1.0),
        ("right.lateralForce", "left.lateralForce", -1.0),
    ] {
        let turned: Vec<f64> = column(&b, other).iter().map(|value| sign * value).collect();
        let difference = largest_difference(&column(&a, name), &turned);
        println!("{name}: {difference:.1e}");
        assert!(difference < if name.ends_with("Force") { 0.01 } else { 1e-9 }, "{name}: {difference:e}");
    }
}

/// The same gentle curve in all four: constraints agree with each other, elastic contact lies lower by its penetration.
#[test]
fn equiv_formulations_agree_in_a_curve() {
    let run =
        |formulation: &str| common::run(&curve(&[&format!("contact.formulation={formulation}"), "solver.tolerance=1e-11"]), 8.0, 0.02);
    let [algebraic, nodal, embedded, augmented] = FORMULATIONS.map(run);
    println!("ACCF - ECCF");
    differences(
        &augmented,
        &embedded,
        &[("distance", 1e-8), ("y", 2e-8), ("yaw", 2e-8), ("z", 1e-9), ("left.normalForce", 1.0), ("right.normalForce", 1.0)],
    );
    println!("ECF-N - ECF-A");
    differences(&nodal, &algebraic, &[("y", 5e-5), ("yaw", 5e-5), ("z", 1e-6)]);
    println!("ECCF - ECF-A");
    differences(&embedded, &algebraic, &[("y", 1e-5), ("yaw", 1e-5)]);
    let (y, yaw) = (column(&algebraic, "y"), column(&algebraic, "yaw"));
    println!("in the curve: y {:.3} mm, yaw {:.3} mrad", 1e3 * y[y.len() - 1], 1e3 * yaw[y.len() - 1]);
    let least = column(&embedded, "right.normalForce").into_iter().fold(f64::INFINITY, f64::min);
    assert!(least > 3e4, "{least}");
}

/// Free on a canted, climbing curve, without friction, damping and springs: kinetic, potential and contact energy.
#[test]
fn analytic_energy_on_a_canted_climbing_spiral() {
    let mut scene = curve(&[
        "vehicle.speed=17.4",
        "vehicle.travel=free",
        "vehicle.wheelset.vertical_load=20000",
        "vehicle.initial.distance=20",
        "contact.friction=0",
        "contact.damping=0",
        "contact.normal.law=assumed",
        "contact.normal.stiffness=1e11",
        "solver.tolerance=1e-13",
    ]);
    scene.vehicle.forces.clear();
    let mut alignment = scene.track.alignment.clone().unwrap();
    (alignment.nodes[0].grade, alignment.nodes[1].grade) = (0.0, 0.02);
    lay(&mut scene, alignment, Vector3::zeros(), 0.0);
    let model = wheelrail::scene::assemble::model(&scene).unwrap();
    let mut simulation = start(&scene);
    let mut workspace = model.workspace();
    // What holds the load's mass on its way does work on the wheelset: -M S s' X_s . v.
    let held = 20000.0 / 9.81;
    let mut energy = |simulation: &mut wheelrail::sim::Simulation| {
        let snapshot = simulation.snapshot().unwrap();
        let (mut memory, mut dy) = (snapshot.memory().clone(), vec![0.0; snapshot.y.len()]);
        let at = Evaluation { t: 0.0, inputs: &model.neutral_inputs(), y: &snapshot.y, memory: &mut memory };
        model.derivative(&mut workspace, at, &mut dy).unwrap();
        let contact: f64 = workspace.contacts.iter().map(|c| 0.4 * c.stiffness * c.penetration.max(0.0).powf(2.5)).sum();
        let (station, motion) = (workspace.system.stations.get(0).unwrap(), &workspace.system.motions[0]);
        let power = -held * station.speed * station.travel * station.frame.bend().dot(&motion.velocity);
        (model.system.mechanical_energy(&snapshot.y, &workspace.system) + contact, motion.position, power)
    };
    let (before, from, mut power) = energy(&mut simulation);
    let (mut largest, mut work, mut most_work) = (0f64, 0.0, 0f64);
    let half = 5e-4;
    for i in 0..1000 {
        let mut next = |ahead: i32| {
            simulation.advance(half * f64::from(2 * i + ahead)).unwrap();
            energy(&mut simulation)
        };
        let (middle, end) = (next(1).2, next(2));
        work += half / 3.0 * (power + 4.0 * middle + end.2);
        power = end.2;
        most_work = most_work.max(work.abs());
        largest = largest.max((end.0 - before - work).abs());
    }
    let climbed = energy(&mut simulation).1.z - from.z;
    println!("what holds the load did up to {most_work:.3} J");
    let exchanged = (1568.0 * 9.81 + 20000.0) * climbed;
    println!("climbed {climbed:.4} m: {exchanged:.1} J exchanged, largest drift {largest:.1e} J");
    assert!(exchanged > 100.0 && largest < 1e-6 * exchanged, "{largest:e}");
}

/// Nothing on the stepping path depends on where along the track: 40 km down the line the same curve gives the same.
#[test]
fn equiv_the_same_curve_far_down_the_line() {
    let scene = || curve(&["solver.tolerance=1e-10"]);
    let near = common::run(&scene(), 4.0, 0.02);
    let far = 40e3;
    let mut shifted = curve(&["solver.tolerance=1e-10", "vehicle.initial.distance=40000"]);
    let mut alignment = shifted.track.alignment.clone().unwrap();
    for node in &mut alignment.nodes {
        node.distance += far;
    }
    lay(&mut shifted, alignment, Vector3::zeros(), 0.0);
    let other = common::run(&shifted, 4.0, 0.02);
    for (name, allowed) in [("y", 2e-8), ("yaw", 2e-8), ("left.verticalForce", 20.0)] {
        let difference = largest_difference(&column(&near, name), &column(&other, name));
        println!("{name}: {difference:.1e}");
        assert!(difference < allowed, "{name}: {difference:e}");
    }
}
