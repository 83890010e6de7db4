//! `vertical_load`: the weight of what rests on a wheelset, on grades, in curves and when the speed changes.

use crate::common;
use crate::common::{read, start, table};
use std::collections::HashMap;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;

const FORMULATIONS: [&str; 4] = ["ECF-A", "ECF-N", "ECCF", "ACCF"];
const G: f64 = 9.81;
/// Of the scene, kg, kg m2 and N.
const MASS: f64 = 1568.0;
const AXIAL: f64 = 168.0;
const LOAD: f64 = 98_000.0;

/// The wheelset of tests/data/scenes/curve.toml on other nodes.
fn on_nodes(nodes: &str, changes: &[&str]) -> Scene {
    let mut all = vec![nodes.to_string(), "vehicle.initial.distance=100".into()];
    all.extend(changes.iter().map(|change| (*change).to_string()));
    let file = common::data("scenes/curve.toml");
    load::open(file.to_str().unwrap(), &all).unwrap_or_else(|error| panic!("{error}"))
}

fn after(scene: &Scene, times: [f64; 2]) -> [HashMap<String, f64>; 2] {
    let mut simulation = start(scene);
    let outputs = table(&simulation, scene);
    times.map(|time| {
        simulation.advance(time).unwrap_or_else(|error| panic!("{error}"));
        read(&mut simulation, &outputs)
    })
}

fn both(at: &HashMap<String, f64>, name: &str) -> f64 {
    at[&format!("left.{name}")] + at[&format!("right.{name}")]
}

/// Rolling freely on a grade of 3 %, whichever key says so: `(m + M) g sin g = (m + M + I / r^2) a`, M = load / g.
#[test]
fn analytic_a_loaded_wheelset_rolls_downhill_on_either_kind_of_grade() {
    let slope = 0.03f64.atan();
    for formulation in FORMULATIONS {
        let formulation = format!("contact.formulation={formulation}");
        let changes = [formulation.as_str(), "vehicle.travel=free", "solver.tolerance=1e-9"];
        let level = "track.node=[{ distance = 0, grade = \"3 %\" }]";
        let mut tilted = vec!["vehicle.initial.distance=100", "track.grade=3 %"];
        tilted.extend(changes);
        let scenes = [on_nodes(level, &changes), common::scene(&tilted)];
        let [by_node, by_key] = scenes.map(|scene| {
            let [before, later] = after(&scene, [0.2, 1.2]);
            let radius = before["vx"] / before["pitchRate"];
            let expected = -G * slope.sin() * (MASS + LOAD / G) / (MASS + LOAD / G + AXIAL / (radius * radius));
            let found = later["vx"] - before["vx"];
            println!("{formulation}: {found:.6} m/s2 ({expected:.6})");
            // Spin and creep cost the rest.
            assert!((found / expected - 1.0).abs() < 2e-3, "{formulation}: {found} instead of {expected}");
            found
        });
        assert!((by_node / by_key - 1.0).abs() < 2e-3, "{by_node} {by_key}");
    }
}

/// With imposed speed the drive pulls wheelset and load uphill, and the wheels carry both square to the track.
#[test]
fn analytic_a_driven_wheelset_pulls_its_load_uphill() {
    let slope = 0.03f64.atan();
    for (formulation, key) in FORMULATIONS.into_iter().flat_map(|formulation| [(formulation, true), (formulation, false)]) {
        let formulation = format!("contact.formulation={formulation}");
        let scene = match key {
            true => common::scene(&["vehicle.initial.distance=100", "track.grade=0.03", &formulation]),
            false => on_nodes("track.node=[{ distance = 0, grade = 0.03 }]", &[&formulation]),
        };
        let [_, at] = after(&scene, [0.1, 0.2]);
        let weight = MASS * G + LOAD;
        let along = at["drivingForce"] + both(&at, "longitudinalForce");
        let square = both(&at, "verticalForce");
        println!(
            "{formulation} {key}: along {along:.3} N ({:.3}), square {square:.3} N ({:.3})",
            weight * slope.sin(),
            weight * slope.cos()
        );
        assert!((along / (weight * slope.sin()) - 1.0).abs() < 1e-4 && (square / (weight * slope.cos()) - 1.0).abs() < 1e-5);
    }
}

/// At V^2 = g R tan(cant) weight and centrifugal force add up square to the track, for the load as for the wheelset: today's 8 kN of a load
/// without centrifugal force go. What is left is `m V^2 cos(cant) (1/R_P - 1/R)`, because the centres are not on the centre line, and the
/// share of the load likewise: hand calculation from R, cant, height of the axle 0.457 m and its y.
#[test]
fn analytic_nothing_is_left_at_the_balance_speed() {
    let (radius, height, base) = (582.192_365, 0.0762f64, 1.432);
    let cant = (height / base).asin();
    let speed = (G * radius * cant.tan()).sqrt();
    for formulation in FORMULATIONS {
        let node = "track.node=[{ distance = 0, curvature = \"3 deg\", superelevation = \"-3 in\" }]";
        let scene =
            on_nodes(node, &[&format!("contact.formulation={formulation}"), &format!("vehicle.speed={speed}"), "solver.tolerance=1e-9"]);
        let [_, at] = after(&scene, [1.0, 2.0]);
        let springs: f64 = ["left", "right"].iter().map(|side| at[&format!("suspension.{side}.lateralForce")]).sum();
        let net = both(&at, "lateralForce") + springs;
        let centripetal = speed * speed / radius * cant.cos();
        // A left-hand curve: the left rail is low, the axle stands inside of the centre line by y cos + z sin.
        let inside = (at["y"] * cant.cos() + at["z"] * cant.sin()) / radius;
        let expected = (MASS + LOAD / G) * centripetal * inside;
        println!(
            "{formulation}: net lateral force {net:.3} N ({expected:.3} N); without the load's centrifugal force {:.1} N",
            -LOAD / G * centripetal
        );
        assert!((net - expected).abs() < 2.0 && net.abs() < 10.0, "{formulation}: {net} {expected}");
        assert!((both(&at, "verticalForce") / ((MASS * G + LOAD) / cant.cos()) - 1.0).abs() < 1e-4);
    }
}

/// Over the top of a hill (vertical radius 2 km) the load weighs less by M V^2 / R; in the dip more.
#[test]
fn analytic_crests_unload_and_dips_load() {
    for (sign, formulation) in [(1.0, "ECF-A"), (-1.0, "ECF-A"), (-1.0, "ECCF")] {
        let nodes = format!(
            "track.node=[{{ distance = 0 }}, {{ distance = 50, grade = 0 }}, {{ distance = 150, grade = \"{} rad\" }}]",
            -0.05 * sign
        );
        let scene = on_nodes(
            &nodes,
            &["vehicle.initial.distance=10", "vehicle.speed=20", &format!("contact.formulation={formulation}"), "solver.tolerance=1e-8"],
        );
        let [_, at] = after(&scene, [4.0, 4.5]);
        let (climb, load) = ((at["distance"] - 50.0) * 5e-4, MASS * G + LOAD);
        let expected = load * climb.cos() - sign * load / G * 400.0 * 5e-4;
        let found = both(&at, "verticalForce");
        println!("{formulation} {sign}: {found:.1} N ({expected:.1} N, {load:.1} N on the level)");
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
}

/// A load that pulls upward, or one without gravity, is a force without mass.
#[test]
fn prop_a_force_that_is_no_weight_has_no_mass() {
    use wheelrail::mbs::force::VerticalLoad;
    assert!((VerticalLoad::new(0, 981.0, 9.81, 0.0).mass - 100.0).abs() < 1e-12);
    assert!([(-981.0, 9.81), (981.0, 0.0), (981.0, 1e-300)].iter().all(|(force, g)| VerticalLoad::new(0, *force, *g, 0.0).mass == 0.0));
}
