//! Independent wheels and flexible axles on their rails.

use crate::common::{column, largest_difference, read, run, start, table};
use nalgebra::DMatrix;
use std::path::Path;
use wheelrail::formulation::Evaluation;
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{embedded, load};
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;

pub const INDEPENDENT: &str = "kind = \"independent_wheels\"";

/// A scene with an element that lets the wheels of its wheelset turn against each other, and changes.
pub fn twisted(text: &str, axle: &str, changes: &[&str]) -> Scene {
    read_twisted(text, axle, changes).unwrap_or_else(|error| panic!("{error}"))
}

fn read_twisted(text: &str, axle: &str, changes: &[&str]) -> Result<Scene, String> {
    let entry =
        if axle.is_empty() { String::new() } else { format!("\n[[vehicle.force]]\nname = \"axle\"\nbody = \"wheelset\"\n{axle}\n") };
    let text = text.replacen("\n[track]\n", &format!("{entry}\n[track]\n"), 1);
    let source = Source { file: "twist.toml".into(), text, overridden: vec![], folder: None };
    let changes: Vec<String> = changes.iter().map(|change| change.to_string()).collect();
    load::read("twist", source, &changes).map_err(|error| error.to_string())
}

/// Of the suspended wheelset, or why it is refused.
pub fn twisted_start(axle: &str, changes: &[&str]) -> Result<Simulation, String> {
    let scene = read_twisted(embedded::find("suspended_wheelset").unwrap().text, axle, changes)?;
    Simulation::new(&scene, 0.0).map_err(|error| error.to_string())
}

pub fn suspended(axle: &str, changes: &[&str]) -> Scene {
    twisted(embedded::find("suspended_wheelset").unwrap().text, axle, changes)
}

/// A wheelset 2 mm off that may not yaw: on a rigid axle its wheels roll with different radii, which makes the couple that guides it; wheels that turn on their own hand on none.
/// Free to yaw, the rigid one goes on Klingel's wave and stays within its 2 mm; nothing guides the other: the normal forces turn it further (negative gravitational stiffness in yaw).
#[test]
fn analytic_independent_wheels_are_not_guided_by_creep() {
    let with = |axle: &str, stiffness: &str, stop: f64| {
        let along = format!("vehicle.suspension.longitudinal_stiffness={stiffness}");
        let damping =
            if stiffness == "0" { "vehicle.suspension.longitudinal_damping=0" } else { "vehicle.suspension.longitudinal_damping=1e5" };
        let free = ["vehicle.initial.distance=100", "vehicle.suspension.lateral_stiffness=0", "vehicle.speed=2", "vehicle.initial.y=0.002"];
        run(&suspended(axle, &[&free[..], &[&along, damping, "solver.tolerance=1e-8"]].concat()), stop, 0.02)
    };
    let couple = |axle: &str| {
        let recording = with(axle, "1e9", 1.0);
        let [left, right] = ["left", "right"].map(|side| column(&recording, &format!("{side}.contact[1].creepForceX")));
        left.iter()
            .zip(right)
            .skip(15)
            .map(|(left, right)| 0.5 * (right - left))
            .fold(0.0, |most: f64, force| if force.abs() > most.abs() { force } else { most })
    };
    let (rigid, free) = (couple(""), couple(INDEPENDENT));
    println!("held in yaw: {rigid:.1} N on each wheel of a rigid axle, {free:.4} N on independent ones");
    assert!(rigid.abs() > 300.0 && free.abs() < 2.0);
    let farthest = |axle: &str| column(&with(axle, "0", 4.2), "y").iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    let (rigid, free) = (farthest(""), farthest(INDEPENDENT));
    println!("free in yaw: within {:.3} mm on a rigid axle, {:.1} mm on independent wheels", 1e3 * rigid, 1e3 * free);
    assert!(rigid < 2.1e-3 && free > 5e-3);
}

/// In the steady curve each of the independent wheels rolls with its own radius r over its own rail of radius R -+ b: `w = V_rail / r`, but for what spin creepage asks for.
#[test]
fn analytic_independent_wheels_roll_their_own_ways_in_a_curve() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scenes/curve.toml")).unwrap();
    for formulation in ["ECF-A", "ECF-N", "ECCF", "ACCF"] {
        let changes = format!("contact.formulation={formulation}");
        let scene = twisted(&text, INDEPENDENT, &["vehicle.initial.distance=120", &changes]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let first = read(&mut simulation, &outputs);
        let slips = ["left", "right"].map(|side| first[&format!("{side}.contact[1].longitudinalCreepage")]);
        let difference = first["axle.leftSpeed"] - first["axle.rightSpeed"];
        // Rails 2 x 0.716 m apart in a curve of 582.192 m, in which the speed of 20 m/s is that of the centre; cones that stand y aside.
        let radius = |sign: f64| 0.457 + sign * 0.02567 * first["y"];
        let expected = 20.0 * ((1.0 - 0.716 / 582.192) / radius(1.0) - (1.0 + 0.716 / 582.192) / radius(-1.0));
        println!("{formulation}: spins differ by {difference:.6} rad/s, rolling asks for {expected:.6}; creepages {slips:?}");
        assert!((difference / expected - 1.0).abs() < 0.03, "{difference} {expected}");
        assert!((slips[0] - slips[1]).abs() < 2e-5 && slips[0].abs() < 1e-4, "{slips:?}");
        simulation.advance(0.5).unwrap();
        let later = read(&mut simulation, &outputs);
        let moved = (later["axle.leftSpeed"] - later["axle.rightSpeed"] - difference).abs();
        println!("  after 0.5 s: moved by {moved:.1e} rad/s, y by {:.1e} m", later["y"] - first["y"]);
        assert!(moved < 1e-4 && (later["y"] - first["y"]).abs() < 1e-6, "it starts in balance");
    }
}

/// A tram on independent wheels starts in a curve of 50 m where a run from straight track comes to, and stays there; to the right it does the same in a mirror. (The balance jumped
/// from flange to flange and was refused.) Loads of the run still change by some parts in a million after 11 s.
#[test]
fn equiv_independent_wheels_start_in_a_curve_where_they_settle() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes/tram_independent_wheels.toml");
    let at = |changes: &[&str], stop: f64| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        let scene = load::open_file(&path, "tram", &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let first = read(&mut simulation, &outputs);
        simulation.advance(stop).unwrap();
        (first, read(&mut simulation, &outputs))
    };
    let (_, settled) = at(&[], 14.0);
    let (begin, later) = at(&["vehicle.initial.distance=90"], 1.0);
    let (right, _) = at(&["vehicle.initial.distance=90", "track.node=[{distance=8},{distance=18,radius=-50}]"], 0.1);
    for axle in ["truck[1].wheelset[1]", "truck[1].wheelset[2]", "truck[2].wheelset[1]", "truck[2].wheelset[2]"] {
        let y = format!("{axle}.y");
        println!(
            "{axle}: y {:.6} mm at once, {:.6} mm 1 s later, {:.6} mm settled, {:.6} mm to the right",
            1e3 * begin[&y],
            1e3 * later[&y],
            1e3 * settled[&y],
            1e3 * right[&y]
        );
        assert!((begin[&y] - later[&y]).abs() < 1e-7 && (begin[&y] + right[&y]).abs() < 1e-7 && (begin[&y] - settled[&y]).abs() < 1e-6);
        for (wheel, other) in [("left", "right"), ("right", "left")] {
            let [load, mirrored] = [wheel, other].map(|wheel| format!("{axle}.{wheel}.verticalForce"));
            assert!((begin[&load] - later[&load]).abs() < 1.0 && (begin[&load] - settled[&load]).abs() < 5.0, "{load}");
            assert!((begin[&load] - right[&mirrored]).abs() < 1.0, "{load}");
        }
    }
    assert!(begin["truck[1].wheelset[1].y"] < -6e-3 && begin["truck[1].wheelset[2].y"] > 6e-3, "on opposite flanges");
}

/// On straight track nothing but their weight leads independent wheels, and where rails are displaced there mostly is no balance of them ("it goes up to 6 % of their displacements", for
/// each of these). They start as wheels that turn together: without a blow.
#[test]
fn hard_independent_wheels_start_on_displaced_straight_rails() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes/tram_independent_wheels.toml");
    for (seed, scale, patch) in [(1, 0.3, "strips"), (1, 0.3, "ellipse"), (2, 1.0, "ellipse"), (3, 1.0, "strips"), (4, 0.3, "ellipse")] {
        let irregular = format!(
            "track.irregularity=[{{kind=\"spectrum\",spectrum=\"ore_b176_low\",seed={seed},from=-100,to=900,shortest=1,scale={scale}}}]"
        );
        let changes =
            [&irregular, "track.node=[{distance=800},{distance=810,radius=50}]", "vehicle.speed=10", &format!("contact.patch={patch}")]
                .map(String::from);
        let scene = load::open_file(&path, "tram", &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let mut first = [f64::INFINITY, 0.0f64, 0.0f64];
        for millisecond in 0..60 {
            simulation.advance(1e-3 * f64::from(millisecond)).unwrap();
            for (name, value) in read(&mut simulation, &outputs) {
                if name.ends_with("t.verticalForce") {
                    first = [first[0].min(value), first[1].max(value), first[2]];
                } else if name.ends_with("t.lateralForce") {
                    first[2] = first[2].max(value.abs());
                }
            }
        }
        let of = |part: f64| part / (0.5 * (first[0] + first[1]));
        println!(
            "seed {seed}, scale {scale}, {patch}: Q from {:.0} to {:.0} N, Y up to {:.0} N in the first 60 ms",
            first[0], first[1], first[2]
        );
        assert!(of(first[1] - first[0]) < 0.25 && of(first[2]) < 0.1, "{first:?}");
    }
}

/// A very stiff axle is a rigid one, a very soft one no axle, in all formulations.
#[test]
fn equiv_an_axle_between_rigid_and_none() {
    for formulation in ["ECF-A", "ECF-N", "ECCF", "ACCF"] {
        let contact = format!("contact.formulation={formulation}");
        let with = |axle: &str| {
            let scene = suspended(
                axle,
                &[
                    "vehicle.initial.y=0.003",
                    "vehicle.initial.distance=18",
                    "vehicle.speed=20",
                    &contact,
                    "solver.tolerance=1e-8",
                    "solver.integrator=rosenbrock",
                ],
            );
            column(&run(&scene, 0.8, 0.01), "y")
        };
        let flexible = |k: &str| with(&format!("kind = \"flexible_axle\"\ndamping = 100\nstiffness = {k}"));
        let (rigid, none) = (with(""), with("kind = \"independent_wheels\"\ndamping = 100"));
        let off = |a: &[f64], b: &[f64]| largest_difference(a, b);
        let stiff = ["1e8", "1e9"].map(|k| off(&flexible(k), &rigid));
        let soft = off(&flexible("1e-3"), &none);
        println!(
            "{formulation}: 1e8 {:.1e} m, 1e9 {:.1e} m, soft {soft:.1e} m; rigid and none differ by {:.1e} m",
            stiff[0],
            stiff[1],
            off(&rigid, &none)
        );
        assert!(off(&rigid, &none) > 1e-4);
        // ECF-N's forces have small jumps between nodes.
        let rest = if formulation == "ECF-N" { 2e-6 } else { 2e-7 };
        assert!(stiff[0] < 2e-5 && stiff[1] < 0.2 * stiff[0] + rest && soft < rest);
    }
}

/// The same run by every method.
#[test]
fn equiv_integrators_agree_on_a_flexible_axle() {
    let with = |solver: &[&str]| {
        let axle = "kind = \"flexible_axle\"\nstiffness = 2e5\ndamping = 100\nleft_share = 0.4";
        let scene = suspended(axle, &[&["vehicle.initial.y=0.003", "vehicle.initial.distance=18", "vehicle.speed=20"], solver].concat());
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        simulation.advance(0.7).unwrap_or_else(|error| panic!("{solver:?}: {error}"));
        let found = read(&mut simulation, &outputs);
        [found["y"], found["axle.twist"], found["axle.leftSpeed"]]
    };
    let exact = with(&["solver.integrator=dormand_prince", "solver.tolerance=1e-10"]);
    println!("{exact:?}");
    let methods: [&[&str]; 6] = [
        &["solver.integrator=rosenbrock", "solver.tolerance=1e-7"],
        &["solver.integrator=imex", "solver.tolerance=1e-7"],
        &["solver.integrator=rk43", "solver.tolerance=1e-7"],
        &["solver.integrator=generalised_alpha", "solver.step=0.0002"],
        &["solver.integrator=real_time", "solver.step=0.0005"],
        &["solver.integrator=rk4", "solver.step=0.0005"],
    ];
    for method in methods {
        let found = with(method);
        let off: Vec<f64> = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).collect();
        println!("{method:?}: {off:?}");
        assert!(off[0] < 5e-5 && off[1] < 5e-5 && off[2] < 0.02, "{method:?}: {off:?}");
    }
}

/// All of J, contacts with and without states of their own, against differences of the model: rows of the twist, and what the twist does to all others.
#[test]
fn analytic_the_twist_is_in_the_jacobian() {
    let axle = "kind = \"flexible_axle\"\nstiffness = 2e5\ndamping = 100\nleft_share = 0.4\n";
    let transient = "contact.transient={ below = \"2 m/s\" }";
    for (entries, changes) in [
        (axle.to_string(), &["vehicle.speed=20"][..]),
        (axle.to_string(), &["vehicle.speed=0.3", transient]),
        (axle.to_string(), &["vehicle.speed=0.3", transient, "contact.formulation=ECF-N"]),
    ] {
        let scene =
            suspended(
                &entries,
                &[
                    &[
                        "vehicle.initial.y=0.003",
                        "vehicle.initial.yaw=0.002",
                        "vehicle.initial.distance=100",
                        "solver.integrator=rosenbrock",
                    ][..],
                    changes,
                ]
                .concat(),
            );
        let mut simulation = start(&scene);
        simulation.advance(0.05).unwrap_or_else(|error| panic!("{error}"));
        let model = simulation.model();
        let (y, memory) = (&simulation.state().integration.y, &simulation.state().memories.accepted);
        let inputs = model.start_inputs();
        let mut workspace = model.workspace();
        model.prepare_tangent(&mut workspace);
        let mut rates = |y: &[f64], workspace: &mut wheelrail::formulation::Workspace| {
            let (mut memory, mut dy) = (memory.clone(), vec![0.0; y.len()]);
            model.derivative(workspace, Evaluation { t: 0.0, inputs: &inputs, y, memory: &mut memory }, &mut dy).unwrap();
            dy
        };
        rates(y, &mut workspace);
        model.linearise(&mut workspace, (y, memory), &inputs, true);
        let (n, a) = (y.len(), 1e-3);
        model.factorise(&mut workspace, a).unwrap();
        let mut inverse = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut x = vec![0.0; n];
            x[j] = 1.0;
            model.solve_linear(&mut workspace, &mut x);
            inverse.column_mut(j).copy_from_slice(&x);
        }
        let found = (DMatrix::identity(n, n) - inverse.try_inverse().unwrap()) / a;
        let first = 12 * model.system.bodies.len();
        let axle = model.system.forces.iter().position(|force| force.name() == "axle").unwrap();
        let states = model.system.states_of_force(axle);
        let difference = |j: usize,
                          h: f64,
                          workspace: &mut wheelrail::formulation::Workspace,
                          rates: &mut dyn FnMut(&[f64], &mut wheelrail::formulation::Workspace) -> Vec<f64>| {
            let mut at = |sign: f64| {
                let mut moved = y.clone();
                moved[j] += sign * h;
                rates(&moved, workspace)
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            ahead.iter().zip(behind).map(|(a, b)| (a - b) / (2.0 * h)).collect::<Vec<f64>>()
        };
        for state in states.clone() {
            let exact = difference(state, 1e-6, &mut workspace, &mut rates);
            let size = exact.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let error = (0..n).map(|i| (found[(i, state)] - exact[i]).abs()).fold(0.0, f64::max);
            println!("{changes:?}: column {}: {error:.1e} of {size:.1e}", state - first);
            assert!(size > 1.0 && error < 0.01 * size, "{changes:?} column {state}");
        }
        let row = states.start + 1;
        let exact: Vec<f64> =
            (0..n).map(|j| difference(j, if j < first / 2 { 1e-7 } else { 1e-6 }, &mut workspace, &mut rates)[row]).collect();
        for (range, what) in [(0..first / 2, "positions"), (first / 2..first, "velocities"), (first..n, "states")] {
            let norm = |x: f64, y: f64| x.hypot(y);
            let size = range.clone().map(|j| exact[j]).fold(0.0, norm);
            let error = range.map(|j| found[(row, j)] - exact[j]).fold(0.0, norm);
            println!("  row by {what}: {error:.1e} of {size:.1e}");
            // Left out is the turn of the axle on which wheel loads' moments are projected: 2 N b P f / mu = 10.
            assert!(error < 0.02 * size + if what == "positions" { 12.0 } else { 0.1 }, "{changes:?} by {what}");
        }
    }
}

/// A wheelset on independent wheels in its suspension at standstill with contact at low speed: nothing turns by itself.
#[test]
fn hard_independent_wheels_stand_still() {
    let text = embedded::find("wheelset_standstill").unwrap().text;
    let scene = twisted(text, INDEPENDENT, &["vehicle.speed=0", "track.grade=0"]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    simulation.advance(3.0).unwrap_or_else(|error| panic!("{error}"));
    let found = read(&mut simulation, &outputs);
    println!(
        "spins {:.1e}, {:.1e} rad/s after 3 s, {} steps",
        found["axle.leftSpeed"],
        found["axle.rightSpeed"],
        simulation.statistics().steps
    );
    assert!(found["axle.leftSpeed"].abs() < 1e-6 && found["axle.rightSpeed"].abs() < 1e-6);
}

/// Two elements for one axle, and one for a body that is no wheelset, are refused in words.
#[test]
fn prop_twists_without_an_axle_of_their_own_are_refused() {
    let text = embedded::find("bogie").unwrap().text;
    let with = |entries: &str| {
        let text = text.replacen("\n[track]\n", &format!("\n{entries}\n[track]\n"), 1);
        let source = Source { file: "twist.toml".into(), text, overridden: vec![], folder: None };
        match load::read("twist", source, &[]) {
            Ok(scene) => wheelrail::sim::Simulation::new(&scene, 0.0).err().map(|error| error.to_string()).unwrap_or_default(),
            Err(error) => error.to_string(),
        }
    };
    let axle = |name: &str, body: &str| format!("[[vehicle.force]]\nname = \"{name}\"\nkind = \"independent_wheels\"\nbody = \"{body}\"\n");
    let cases = [
        (axle("a", "frame"), "is no wheelset"),
        (axle("a", "wheelset[1]") + &axle("b", "wheelset[1]"), "both let the wheels of wheelset[1] turn"),
    ];
    for (entries, words) in cases {
        let error = with(&entries);
        println!("{error}");
        assert!(error.contains(words), "{error}");
    }
    assert_eq!(with(&(axle("a", "wheelset[1]") + &axle("b", "wheelset[2]"))), "");
}
