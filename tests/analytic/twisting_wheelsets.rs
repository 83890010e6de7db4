//! Axles that twist with wheels that are not round, and on track that gives way.

use crate::common::{column, largest_difference, read, run, start, table};
use crate::twist::{INDEPENDENT, suspended, twisted, twisted_start};
use std::collections::HashMap;
use std::f64::consts::TAU;

const POLYGONS: &str = "vehicle.wheelset.out_of_round=[{kind=\"polygon\",order=9,depth=6e-5,wheel=\"left\"},{kind=\"polygon\",order=7,depth=6e-5,wheel=\"right\"}]";
const BETWEEN: &str = "kind = \"flexible_axle\"\nstiffness = 2e5\ndamping = 100\nleft_share = 0.4";

/// What both wheels' turning, and the rails', changes in a run through the disturbance.
fn loads(axle: &str, changes: &[&str]) -> [Vec<f64>; 3] {
    let scene = suspended(axle, &[&["vehicle.initial.distance=17", "vehicle.speed=25", POLYGONS][..], changes].concat());
    let recording = run(&scene, 0.3, 5e-4);
    ["left.verticalForce", "right.verticalForce", "y"].map(|name| column(&recording, name))
}

/// A stiff axle is the rigid one, on rails of every kind, whose wheels have waves of their own.
#[test]
fn equiv_a_stiff_axle_and_a_rigid_one() {
    for rails in [&[][..], &["track.flexibility=travelling"], &["track.flexibility=beam"]] {
        let solver = [&["solver.integrator=rosenbrock", "solver.tolerance=1e-8"], rails].concat();
        let [rigid, stiff, soft] = [
            "",
            "kind = \"flexible_axle\"\nstiffness = 1e9\ndamping = 1e4",
            "kind = \"flexible_axle\"\nstiffness = 1e4\ndamping = 10\nleft_share = 0.4",
        ]
        .map(|axle| loads(axle, &solver));
        let off = |other: &[Vec<f64>; 3]| [0, 1, 2].map(|k| largest_difference(&rigid[k], &other[k]));
        let (none, some) = (off(&stiff), off(&soft));
        let swing = rigid[0].iter().map(|load| (load - rigid[0][0]).abs()).fold(0.0, f64::max);
        println!("{rails:?}: Q swings by {swing:.0} N; stiff {none:?}, soft {some:?}");
        assert!(swing > 1e3 && none[0] < 2.0 && none[1] < 2.0 && none[2] < 1e-7, "{none:?}");
        assert!(some[0] > 20.0 * none[0] && some[2] > 20.0 * none[2], "a soft axle is another one: {some:?}");
    }
}

/// Every method comes to the same: what J leaves out of rails and twists costs no accuracy.
#[test]
fn equiv_integrators_on_axles_that_twist() {
    for rails in ["track.flexibility=travelling", "track.flexibility=beam"] {
        let exact = loads(BETWEEN, &["solver.integrator=dormand_prince", "solver.tolerance=1e-10", rails]);
        for (method, tolerance, within) in [("rosenbrock", "1e-8", 2.0), ("rosenbrock", "1e-5", 150.0), ("imex", "1e-7", 10.0)] {
            let [integrator, tolerance] = [format!("solver.integrator={method}"), format!("solver.tolerance={tolerance}")];
            let found = loads(BETWEEN, &[&integrator, &tolerance, rails]);
            let off = [0, 1, 2].map(|k| largest_difference(&exact[k], &found[k]));
            println!("{rails}, {method} {tolerance}: {off:?}");
            assert!(off[0] < within && off[1] < within, "{rails}, {method}: {off:?}");
        }
    }
}

/// In a curve each wheel's wave beats with the wheel's own turning: independent wheels' differ as their ways do.
#[test]
fn analytic_waves_of_independent_wheels_follow_their_own_turning() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scenes/curve.toml")).unwrap();
    let waves = "vehicle.wheelset.out_of_round=[{kind=\"polygon\",order=9,depth=4e-5}]";
    let changes = [
        "vehicle.initial.distance=120",
        "interface.outputs=[\"motion\",\"wheels\",\"forces\"]",
        waves,
        "solver.integrator=rosenbrock",
        "solver.tolerance=1e-7",
    ];
    let step = 5e-4;
    let recording = run(&twisted(&text, INDEPENDENT, &changes), 1.2, step);
    let turned = |side: &str| {
        let force = column(&recording, &format!("{side}.verticalForce"));
        let late = &force[force.len() / 4..];
        let mean = late.iter().sum::<f64>() / late.len() as f64;
        let ups = late.windows(2).enumerate().filter(|(_, pair)| pair[0] < mean && pair[1] >= mean);
        let times: Vec<f64> = ups.map(|(k, pair)| step * (k as f64 + (mean - pair[0]) / (pair[1] - pair[0]))).collect();
        TAU / 9.0 * (times.len() - 1) as f64 / (times[times.len() - 1] - times[0])
    };
    let spin = |side: &str| {
        let spins = recording.column(&format!("axle.{side}Speed")).unwrap();
        let late = &spins[spins.len() / 4..];
        late.iter().sum::<f64>() / late.len() as f64
    };
    let [left, right] = ["left", "right"].map(|side| (turned(side), spin(side)));
    println!("waves turn with {:.4} and {:.4} rad/s, wheels with {:.4} and {:.4} rad/s", left.0, right.0, left.1, right.1);
    assert!((right.1 - left.1).abs() > 0.05, "the curve asks for it");
    // Each wheel's load has some of the other's wave, which shifts where it crosses its mean.
    assert!((left.0 / left.1 - 1.0).abs() < 5e-4 && (right.0 / right.1 - 1.0).abs() < 5e-4);
    assert!(((right.0 - left.0) / (right.1 - left.1) - 1.0).abs() < 0.2);
}

/// Books of energy close with waves, rails that give way and a twist; and the three that cannot go together are refused.
#[test]
fn analytic_energy_of_a_twisting_axle_on_track_that_gives_way() {
    for rails in ["track.flexibility=travelling", "track.flexibility=beam"] {
        let changes =
            [POLYGONS, rails, "vehicle.initial.distance=17", "solver.tolerance=1e-8", "interface.outputs=[\"motion\",\"energy\"]"];
        let scene = suspended(BETWEEN, &changes);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        // What is stored, less what came in, and what has become heat.
        let balance = |found: &HashMap<String, f64>| {
            let sum = |names: &[&str]| names.iter().map(|name| found[*name]).sum::<f64>();
            let heat = sum(&["left.frictionHeat", "right.frictionHeat", "energy.suspensionHeat"]);
            let stored = sum(&["energy.kinetic", "energy.height", "energy.elements"]);
            (stored + heat - sum(&["inputWork", "drivingWork", "energy.contactWork"]), heat)
        };
        let first = balance(&read(&mut simulation, &outputs)).0;
        let (mut worst, mut lost) = (0f64, 0f64);
        for step in 1..=100 {
            simulation.advance(3e-3 * f64::from(step)).unwrap();
            let (now, heat) = balance(&read(&mut simulation, &outputs));
            (worst, lost) = (worst.max((now - first).abs()), lost.max(heat));
        }
        println!("{rails}: {worst:.1e} J while {lost:.2} J become heat");
        assert!(lost > 1.0 && worst < 1e-3 * lost);
    }
}

/// Two of the three go together.
#[test]
fn prop_rails_that_give_way_twists_and_tangential_states_are_refused_with_reasons() {
    let rails = "track.flexibility=travelling";
    let states = "contact.transient={below=\"1 m/s\"}";
    for changes in [&[rails][..], &[states]] {
        twisted_start(BETWEEN, changes).unwrap_or_else(|error| panic!("{changes:?}: {error}"));
    }
    let refused = twisted_start(BETWEEN, &[rails, states]).err().unwrap_or_default();
    assert!(refused.contains("[contact.transient]") && refused.contains("flexible_axle"), "{refused}");
}
