//! Starts in steady curving: load transfer, balance speed, what a start leaves, mirrored curves, all formulations, errors, cost.

use crate::common;
use crate::common::start;
use std::collections::HashMap;
use wheelrail::formulation::contact_index;
use wheelrail::geometry::Side;
use wheelrail::mbs::body::COORDINATES;
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{assemble, load, plan};
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;
use wheelrail::sim::vehicle_outputs::scene_outputs;

const G: f64 = 9.81;
const FORMULATIONS: [&str; 4] = ["ECF-A", "ECF-N", "ECCF", "ACCF"];

fn scene(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = common::EXACT.iter().chain(changes).map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// A track that is one curve: radius [m], height of the left rail over the right one [m], grade.
fn curve(radius: f64, height: f64, grade: f64) -> String {
    format!("track.node=[{{distance=0.0, radius={radius:?}, superelevation=\"{height:?} m\", grade={grade:?}}}]")
}

fn values(scene: &Scene, simulation: &mut Simulation) -> HashMap<String, f64> {
    let outputs = scene_outputs(scene, simulation.model());
    let snapshot = simulation.snapshot().unwrap();
    outputs.iter().map(|output| (output.name.clone(), output.value(snapshot))).collect()
}

/// Largest accelerations relative to the pattern: the bodies turn about the vertical through the curve's centre.
fn off_the_pattern(simulation: &mut Simulation, curvature: f64) -> f64 {
    let bodies = simulation.model().system.bodies.len();
    let snapshot = simulation.snapshot().unwrap();
    let (y, dy) = (&snapshot.y, &snapshot.dy);
    let mut largest = 0.0f64;
    for body in 0..bodies {
        let v = COORDINATES * (bodies + body);
        let turning = y[v + 3];
        assert!((turning / curvature).abs() < 100.0);
        let off = [dy[v] + turning * y[v + 1], dy[v + 1] - turning * y[v], dy[v + 2], dy[v + 3], dy[v + 4], dy[v + 5]];
        largest = off.into_iter().fold(largest, |most, off| most.max(off.abs()));
    }
    largest
}

/// Friction along the track is that of where the vehicle stands: with the friction of distance 0 a truck in a dry curve began with Y of 35 for 16 kN.
#[test]
fn equiv_a_start_has_the_friction_of_its_place() {
    for (name, factor, from) in [("bogie", 0.4, 30.0), ("bogie", 0.4, -2000.0), ("wheelset_s1002", 0.3, 150.0)] {
        let track = curve(300.0, -0.1, 0.0);
        let common = ["track.deviation=[]", &track, "vehicle.initial.distance=200", "vehicle.speed=15"];
        let friction = load::open(name, &[]).unwrap().contact.friction;
        let (map, plain) = (
            format!("contact.friction_along=[{{factors=[[{:?},1.0],[{from:?},{factor:?}]],transition=\"2 m\"}}]", from - 30.0),
            format!("contact.friction={}", factor * friction),
        );
        let mut starts = [&map, &plain].map(|own| start(&scene(name, &[&common[..], &[own]].concat())));
        let [there, uniform] = starts.each_mut().map(|start| off_the_pattern(start, 1.0 / 300.0));
        println!("{name}: {there:.1e} with friction along the track, {uniform:.1e} with the same everywhere");
        assert!(there < 1e-3 && uniform < 1e-3, "{name}, {from} m");
        let places = starts.each_mut().map(|start| start.snapshot().unwrap().workspace.beside_track(0));
        assert!((0..2).all(|k| (places[0][k] - places[1][k]).abs() < 1e-8), "{name}: {places:?}");
    }
}

/// Dry friction holds at the start what the way into the curve leaves it: a wagon with wedges and side bearers starts as it runs after a long spiral. (Without friction Y of its leading outer wheels
/// was 34.7 and 34.6 kN where the run has 37.1 and 32.7.)
#[test]
fn equiv_dry_friction_starts_in_a_curve_as_a_spiral_leaves_it() {
    let wagon = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/freight_wagon_wedges.toml");
    let forces = |nodes: &str, stop: f64| {
        let changes = ["track.deviation=[]", nodes, "vehicle.speed=15", "solver.tolerance=1e-4"].map(String::from);
        let scene = load::open(wagon, &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = start(&scene);
        simulation.advance(stop).unwrap_or_else(|error| panic!("{error}"));
        let found = values(&scene, &mut simulation);
        [
            "truck[1].wheelset[1].right.lateralForce",
            "truck[2].wheelset[1].right.lateralForce",
            "truck[1].side_bearer.left.frictionForce1",
            "truck[2].side_bearer.left.frictionForce1",
        ]
        .map(|name| found[name])
    };
    let curve = "radius=300,superelevation=\"-60 mm\"";
    let starts = forces(&format!("track.node=[{{distance=0,{curve}}}]"), 0.0);
    let stays = forces(&format!("track.node=[{{distance=0,{curve}}}]"), 0.5);
    let runs = forces(&format!("track.node=[{{distance=0}},{{distance=20}},{{distance=120,{curve}}}]"), 11.0);
    println!("start {starts:.1?}, after 0.5 s {stays:.1?}, behind the spiral {runs:.1?} N");
    for wheel in 0..2 {
        assert!((starts[wheel] / runs[wheel] - 1.0).abs() < 0.01, "{starts:?} {runs:?}");
    }
    for (start, stay) in starts.iter().zip(stays) {
        assert!((start - stay).abs() < 5.0, "{starts:?} {stays:?}");
    }
    // Both side bearers of a truck that has turned in by 16 mrad are at their limit of 6 kN, and those of both trucks hold against opposite turns.
    assert!(starts[2] > 5.9e3 && starts[3] < -5.9e3 && runs[2] > 5.2e3 && runs[3] < -5.2e3, "{starts:?} {runs:?}");
}

/// A train starts in a curve in which its coaches do: the work of a search was bounded for a train as for one coach, and three of them were refused.
#[test]
fn hard_a_train_starts_in_a_curve_in_which_its_coaches_do() {
    let changes = ["track.deviation=[]", "vehicle.drive=leading", "contact.patch=ellipse", &curve(400.0, -0.06, 0.0)];
    let mut train = scene("train", &changes);
    train.interface.only = None;
    let mut start = start(&train);
    let largest = off_the_pattern(&mut start, 1.0 / 400.0);
    let found = values(&train, &mut start);
    let loads = [1, 2, 3].map(|coach| found[&format!("coach[{coach}].truck[1].wheelset[1].right.verticalForce")]);
    println!("{largest:.2e} m/s2 or rad/s2, Q of the leading outer wheels {loads:?} N");
    assert!(largest < 1e-4 && loads.iter().all(|load| (load / loads[1] - 1.0).abs() < 0.02), "{largest} {loads:?}");
}

/// What a start in a curve leaves of accelerations, in all formulations, on canted and climbing curves. Contact among nodes jumps.
#[test]
fn prop_steady_curving_has_no_accelerations_but_the_patterns() {
    for (name, radius, height, grade, formulations) in [
        ("bogie", 600.0, -0.076, 0.0, &FORMULATIONS[..]),
        ("vehicle_manchester_1", -500.0, 0.08, 0.01, &FORMULATIONS[..1]),
        ("vehicle_equalised", 582.192, -0.0762, 0.0, &FORMULATIONS[..1]),
    ] {
        for formulation in formulations {
            let changes = [
                curve(radius, height, grade),
                "vehicle.drive=leading".into(),
                "contact.on_lift=elastic".into(),
                format!("contact.formulation={formulation}"),
            ];
            let scene = scene(name, &changes.each_ref().map(String::as_str));
            let largest = off_the_pattern(&mut start(&scene), 1.0 / radius);
            println!("{name} {radius} {formulation}: {largest:.2e} m/s2 or rad/s2");
            // A wheel of the coach stands on a joint of its profile: what counts as balance in a curve is 1e-5 g.
            let bound = if name == "bogie" { 1e-5 } else { 1e-4 };
            assert!(largest < bound, "{name} {formulation}: {largest}");
        }
    }
}

/// The vehicle's forces on the track against Newton's law for its bodies, each on its own circle: sums over all wheels of vertical and
/// lateral forces, and the load that centrifugal forces at the heights of the centres of mass and their shift to the outside bring
/// over to the outer wheels (distance of the contacts: that of the rolling circles within 1 %).
#[test]
fn analytic_load_transfer_in_a_curve() {
    for (speed, radius) in [(20.0, 600.0), (20.0, -600.0), (25.0, 900.0)] {
        let changes = [curve(radius, 0.0, 0.0), "vehicle.drive=leading".into(), format!("vehicle.speed={speed:?}")];
        let scene = scene("vehicle_manchester_1", &changes.each_ref().map(String::as_str));
        let mut simulation = start(&scene);
        let found = values(&scene, &mut simulation);
        let model = simulation.model();
        let wheelsets: Vec<String> = model.wheelsets.iter().map(|wheelset| wheelset.name.clone()).collect();
        let sum = |side: &str, name: &str| wheelsets.iter().map(|w| found[&format!("{w}.{side}.{name}")]).sum::<f64>();
        let (mut weight, mut inertial, mut moment) = (0.0, 0.0, 0.0);
        for body in &model.system.bodies {
            // A car's middle lies inside of the line through its trucks, a frame's inside of that through its wheelsets.
            let half_base: f64 = if body.name == "car" {
                9.5
            } else if body.name.ends_with("frame") {
                1.28
            } else {
                0.0
            };
            let [y, z] = ["y", "z"].map(|axis| found[&format!("{}.{axis}", body.name)]);
            let y = y - 0.5 * half_base * half_base / radius;
            let centripetal = speed * speed / (radius - y) * ((radius - y) / radius).powi(2);
            weight += body.mass * G;
            inertial += body.mass * centripetal;
            moment += body.mass * (centripetal * z - G * y);
            // Wheelsets are gyroscopes: the moment that turns their axles with the curve.
            if half_base == 0.0 {
                moment += 112.0 * (speed / 0.46) * (speed / radius);
            }
        }
        let vertical = sum("left", "verticalForce") + sum("right", "verticalForce");
        let lateral = sum("left", "lateralForce") + sum("right", "lateralForce");
        // Each contact's force at its place on the rail.
        let half = scene.track.half_rail_distance;
        let snapshot = simulation.snapshot().unwrap();
        let workspace = &snapshot.workspace;
        let mut transfer = 0.0;
        for (number, wheelset) in wheelsets.iter().enumerate() {
            for side in Side::BOTH {
                for report in workspace.reports(contact_index(number, side)).filter(|report| report.normal_force > 0.0) {
                    let force = workspace.in_track(number, report.force);
                    let q = found[&format!("{wheelset}.{}.verticalForce", side.name())];
                    assert!(force.z <= q + 1e-6);
                    transfer -= force.z * side.sign() * (half + report.parameters.rail);
                }
            }
        }
        println!("V {speed}, R {radius}: sum Q {vertical:.2} of {weight:.2} N, sum Y {lateral:.2} of {inertial:.2} N");
        println!("  load transfer {transfer:.1} N m, of the masses {moment:.1} N m");
        assert!((vertical / weight - 1.0).abs() < 1e-6);
        assert!((lateral / inertial - 1.0).abs() < 1e-3);
        assert!((transfer / moment - 1.0).abs() < 0.012);
    }
}

/// At the balance speed, V^2 = g R tan(cant), nothing pushes the vehicle to either side.
#[test]
fn analytic_balance_speed_leaves_no_lateral_force() {
    let (radius, height) = (800.0, 0.1);
    let probe = scene("vehicle_manchester_1", &[&curve(radius, -height, 0.0)]);
    let cant = (height / (2.0 * probe.track.half_rail_distance)).asin();
    let speed = (G * radius * cant.tan()).sqrt();
    let lateral = |speed: f64| {
        let changes = [curve(radius, -height, 0.0), "vehicle.drive=leading".into(), format!("vehicle.speed={speed:?}")];
        let scene = scene("vehicle_manchester_1", &changes.each_ref().map(String::as_str));
        let mut simulation = start(&scene);
        let found = values(&scene, &mut simulation);
        let names: Vec<String> = simulation.model().wheelsets.iter().map(|w| w.name.clone()).collect();
        let force: f64 = names.iter().map(|w| found[&format!("{w}.left.lateralForce")] + found[&format!("{w}.right.lateralForce")]).sum();
        println!("V {speed:.4} m/s: sum of lateral forces {force:.2} N, car y {:.3} mm", 1e3 * found["car.y"]);
        (force, found["car.y"])
    };
    let ((balanced, inside), (faster, outside)) = (lateral(speed), lateral(speed + 2.0));
    let weight = 436368.0;
    assert!(balanced.abs() < 2e-4 * weight, "{balanced}");
    let expected = weight / G * ((speed + 2.0).powi(2) / radius * cant.cos() - G * cant.sin());
    assert!((faster / expected - 1.0).abs() < 2e-3 && outside < inside - 1e-3, "{faster} {expected} {outside}");
}

/// A start in the curve stays where it is, and is where a run ends that comes from straight track through a spiral.
#[test]
fn equiv_start_in_a_curve_is_the_end_of_a_run_into_it() {
    for (radius, height) in [(600.0, -0.05)] {
        // Behind the scene's deviations.
        let read = |nodes: &str| {
            let nodes = format!("track.node=[{nodes}]");
            scene("bogie", &["vehicle.drive=leading", "solver.tolerance=1e-8", "track.smoothing=5", "vehicle.initial.distance=150", &nodes])
        };
        let curved = format!("radius={radius:?}, superelevation=\"{height:?} m\"}}");
        let within = read(&format!("{{distance=0.0, {curved}"));
        let into = read(&format!("{{distance=170.0}}, {{distance=230.0, {curved}"));
        let mut started = start(&within);
        let before = values(&within, &mut started);
        started.advance(2.0).unwrap();
        let after = values(&within, &mut started);
        let mut run = start(&into);
        run.advance(16.0).unwrap();
        let arrived = values(&into, &mut run);
        // The car's yaw, which one truck hardly holds, has not settled by then: what is left is its.
        for part in ["wheelset[1]", "wheelset[2]", "frame"] {
            for name in ["y", "z", "yaw", "roll"] {
                let [a, b, c] = [&before, &after, &arrived].map(|values| values[&format!("{part}.{name}")]);
                println!("{radius} {part}.{name}: {a:.9}, 2 s later {:.1e} off, behind a spiral {:.1e} off", b - a, c - a);
                assert!((b - a).abs() < 1e-7, "{part}.{name} moves");
                assert!((c - a).abs() < 2e-5, "{part}.{name} differs");
            }
        }
    }
}

/// The mirrored curve has the mirrored steady state.
#[test]
fn prop_mirrored_curve_has_the_mirrored_state() {
    let found = |hand: f64| {
        let scene = scene("vehicle_manchester_1", &[&curve(hand * 500.0, hand * -0.08, 0.01), "vehicle.drive=leading"]);
        values(&scene, &mut start(&scene))
    };
    let (left, right) = (found(1.0), found(-1.0));
    for part in ["truck[1].wheelset[1]", "truck[2].wheelset[2]", "truck[1].frame", "car"] {
        for (name, sign) in [("y", -1.0), ("z", 1.0), ("yaw", -1.0), ("roll", -1.0)] {
            let key = format!("{part}.{name}");
            let difference = left[&key] - sign * right[&key];
            println!("{key}: {:.6e}, mirrored {difference:.1e} off", left[&key]);
            assert!(difference.abs() < 1e-8, "{key}");
        }
    }
}

/// A lone wheelset on a curve starts displaced and yawed, and stays; on a transition it starts as on straight track.
#[test]
fn prop_a_lone_wheelset_starts_in_steady_curving() {
    for formulation in FORMULATIONS {
        let file = common::data("scenes/curve.toml");
        let open = |distance: f64| {
            let changes = [format!("contact.formulation={formulation}"), format!("vehicle.initial.distance={distance:?}")];
            load::open(file.to_str().unwrap(), &changes).unwrap_or_else(|error| panic!("{error}"))
        };
        let scene = open(100.0);
        let mut simulation = start(&scene);
        let before = values(&scene, &mut simulation);
        simulation.advance(1.0).unwrap();
        let after = values(&scene, &mut simulation);
        let [y, yaw] = ["wheelset.y", "wheelset.yaw"].map(|name| (before[name], after[name] - before[name]));
        println!("{formulation}: y {:.6e} m ({:.1e} after 1 s), yaw {:.6e} rad ({:.1e})", y.0, y.1, yaw.0, yaw.1);
        assert!(y.1.abs() < 1e-8 && yaw.1.abs() < 1e-8 && y.0.abs() > 1e-4);
        let straight = values(&open(50.0), &mut start(&open(50.0)));
        assert!(straight["wheelset.yaw"].abs() < 1e-5 && straight["wheelset.y"].abs() < 1e-4);
    }
}

/// Who starts in a curve without support is named, as on straight track.
#[test]
fn hard_a_body_without_support_is_named_in_a_curve() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fmu/scenes/bogie.toml")).unwrap();
    let brick = "[[vehicle.body]]\nname = \"brick\"\nmass = 10\ninertia_xx = 1\ninertia_yy = 1\ninertia_zz = 1\nposition = [0, 0, 1]\n";
    let text = text.replace("[track]\n", &format!("{brick}\n[track]\n"));
    let source = Source { file: "s.toml".into(), text, overridden: vec![], folder: None };
    let scene = load::read("s", source, &[curve(500.0, -0.05, 0.0)]).unwrap();
    let error = Simulation::new(&scene, 0.0).unwrap_err().to_string();
    assert!(error.contains("nothing holds brick along z"), "{error}");
    // Far beyond what friction and flanges can hold: 30 m/s at 80 m.
    let scene = self::scene("bogie", &[&curve(80.0, 0.0, 0.0), "vehicle.speed=30"]);
    let error = Simulation::new(&scene, 0.0).unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("no steady curving where the vehicle starts") && error.contains('%'), "{error}");
}

/// A vehicle that stands in a canted curve stays there.
#[test]
fn hard_a_vehicle_that_stands_in_a_curve_stays() {
    let changes = [
        curve(600.0, -0.05, 0.0),
        "vehicle.travel=free".into(),
        "vehicle.speed=0".into(),
        "contact.transient={ below = \"2 m/s\" }".into(),
    ];
    let scene = scene("bogie", &changes.each_ref().map(String::as_str));
    let mut simulation = start(&scene);
    let before = values(&scene, &mut simulation);
    simulation.advance(0.5).unwrap();
    let after = values(&scene, &mut simulation);
    for part in ["wheelset[1]", "wheelset[2]", "frame", "car"] {
        for name in ["y", "z", "yaw", "roll"] {
            let moved = after[&format!("{part}.{name}")] - before[&format!("{part}.{name}")];
            println!("{part}.{name}: {moved:.1e}");
            assert!(moved.abs() < 5e-4, "{part}.{name}");
        }
    }
}

/// The plan says what curve it is, and that a wheelset on a transition starts as on straight track.
#[test]
fn prop_the_plan_says_how_a_scene_starts() {
    let said = |file: &str, changes: &[String]| {
        let scene = load::open(common::data(file).to_str().unwrap(), changes).unwrap_or_else(|error| panic!("{error}"));
        let plan = plan::plan(&scene, &assemble::model(&scene).unwrap());
        plan.effects.into_iter().find(|effect| effect.name == "steady curving start").map(|effect| (effect.included, effect.why))
    };
    let (included, why) = said("scenes/coach_in_curve.toml", &[]).unwrap();
    assert!(included && why.contains("radius 600.0 m to the left, superelevation -100.0 mm, grade 0.00 %"), "{why}");
    let (included, why) = said("scenes/curve.toml", &["vehicle.initial.distance=50".into()]).unwrap();
    assert!(!included && why.contains("as on straight level track"), "{why}");
    assert_eq!(said("scenes/curve.toml", &["vehicle.initial.distance=300".into()]), None);
}
