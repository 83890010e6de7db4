//! Starts in steady curving: load transfer, balance speed, what a start leaves, mirrored curves, all formulations, errors, cost.

mod common;

use common::start;
use std::collections::HashMap;
use std::time::Instant;
use wheelrail::mbs::body::COORDINATES;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;
use wheelrail::sim::vehicle_outputs::scene_outputs;

const G: f64 = 9.81;
const FORMULATIONS: [&str; 4] = ["ECF-A", "ECF-N", "ECCF", "ACCF"];

fn scene(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// A track that is one curve: radius [m], height of the left rail over the right one [m], grade.
fn curve(radius: f64, height: f64, grade: f64) -> String {
    format!("track.node=[{{distance=0.0, radius={radius:?}, superelevation={height:?}, grade={grade:?}}}]")
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

/// What a start in a curve leaves of accelerations, in all formulations, on canted and climbing curves.
#[test]
fn prop_steady_curving_has_no_accelerations_but_the_patterns() {
    for (name, radius, height, grade) in [
        ("bogie", 600.0, -0.076, 0.0),
        ("vehicle_manchester_1", 600.0, -0.076, 0.0),
        ("vehicle_manchester_1", -300.0, 0.15, 0.02),
        ("vehicle_equalised", 582.192, -0.0762, 0.0),
    ] {
        for formulation in FORMULATIONS {
            let changes = [
                curve(radius, height, grade),
                "vehicle.drive=leading".into(),
                "contact.on_lift=elastic".into(),
                format!("contact.formulation={formulation}"),
            ];
            let scene = scene(name, &changes.each_ref().map(String::as_str));
            let clock = Instant::now();
            match Simulation::new(&scene, 0.0) {
                Ok(mut simulation) => {
                    let time = clock.elapsed().as_secs_f64();
                    let largest = off_the_pattern(&mut simulation, 1.0 / radius);
                    println!("{name} {radius} {formulation}: {largest:.2e} m/s2, {:.0} ms", 1e3 * time);
                }
                Err(error) => println!("{name} {radius} {formulation}: {error}"),
            }
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
            let half_base: f64 = if body.name == "car" { 9.5 } else if body.name.ends_with("frame") { 1.28 } else { 0.0 };
            let [y, z] = ["y", "z"].map(|axis| found[&format!("{}.{axis}", body.name)]);
            let y = y - 0.5 * half_base * half_base / radius;
            let centripetal = speed * speed / (radius - y) * ((radius - y) / radius).powi(2);
            weight += body.mass * G;
            inertial += body.mass * centripetal;
            moment += body.mass * (centripetal * z - G * y);
        }
        let (left, right) = (sum("left", "verticalForce"), sum("right", "verticalForce"));
        let lateral = sum("left", "lateralForce") + sum("right", "lateralForce");
        let transfer = (right - left) * 0.5 * 1.5;
        println!("V {speed}, R {radius}: sum Q {:.2} of {weight:.2} N, sum Y {lateral:.2} of {inertial:.2} N", left + right);
        println!("  outer less inner times half of 1.5 m: {transfer:.1} N m, of the masses {moment:.1} N m");
        assert!(((left + right) / weight - 1.0).abs() < 1e-6);
        assert!((lateral / inertial - 1.0).abs() < 1e-3);
        assert!((transfer / moment - 1.0).abs() < 0.03);
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
    for (radius, height) in [(1500.0, -0.03), (600.0, -0.05)] {
        let read = |nodes: &str| {
            scene("bogie", &["vehicle.drive=leading", "solver.tolerance=1e-8", "track.smoothing=5", &format!("track.node=[{nodes}]")])
        };
        let curved = format!("radius={radius:?}, superelevation={height:?}}}");
        let within = read(&format!("{{distance=0.0, {curved}"));
        let into = read(&format!("{{distance=20.0}}, {{distance=80.0, {curved}"));
        let mut started = start(&within);
        let before = values(&within, &mut started);
        let mut after = before.clone();
        for i in 1..=8 {
            started.advance(0.25 * f64::from(i)).unwrap();
            after = values(&within, &mut started);
            println!("{}: {:?}", 0.25 * f64::from(i), ["wheelset[1].y", "wheelset[2].y", "wheelset[1].left.contact[2].normalForce", "wheelset[1].right.contact[2].normalForce"].map(|n| after.get(n).map_or(f64::NAN, |v| v - before[n])));
        }
        let mut run = start(&into);
        run.advance(16.0).unwrap();
        let arrived = values(&into, &mut run);
        for part in ["wheelset[1]", "wheelset[2]", "frame", "car"] {
            for name in ["y", "z", "yaw", "roll"] {
                let [a, b, c] = [&before, &after, &arrived].map(|values| values[&format!("{part}.{name}")]);
                println!("{radius} {part}.{name}: {a:.9}, 2 s later {:.1e} off, behind a spiral {:.1e} off", b - a, c - a);
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
        let bound = if formulation == "ECF-N" { 2e-5 } else { 1e-8 };
        assert!(y.1.abs() < bound && yaw.1.abs() < bound && y.0.abs() > 1e-4);
        assert_eq!(values(&open(50.0), &mut start(&open(50.0)))["wheelset.yaw"], 0.0);
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
    let changes =
        [curve(600.0, -0.05, 0.0), "vehicle.travel=free".into(), "vehicle.speed=0".into(), "contact.transient={ below = \"2 m/s\" }".into()];
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

/// A train of so many coaches.
fn train(coaches: usize, curve: &str) -> Scene {
    let embedded = wheelrail::scene::embedded::find("vehicle_manchester_1").map_or("", |scene| scene.text);
    let mut places = String::from("[vehicle.module.coach]\ntemplate = \"vehicle_manchester_1\"\n");
    for coach in 1..=coaches {
        let x = -26.0 * (coach - 1) as f64;
        places += &format!("[[vehicle.place]]\nname = \"coach[{coach}]\"\nmodule = \"coach\"\nposition = [{x:?}, 0, 0]\n");
        if coach < coaches {
            let ends =
                [(coach, x - 12.5), (coach + 1, x - 13.5)].map(|(c, x)| format!("{{ body = \"coach[{c}].car\", at = [{x:?}, 0, 1] }}"));
            places += &format!(
                "[[vehicle.force]]\nname = \"coupler[{coach}]\"\nkind = \"coupler\"\nfrom = {}\nto = {}\ndraw_stiffness = 5e6\nbuffer_stiffness = 1e7\n",
                ends[0], ends[1]
            );
        }
    }
    let text = embedded.replace("template = \"vehicle_manchester_1\"", "template = \"free\"").replacen(
        "\n[track]\n",
        &format!("\n{places}\n[track]\n"),
        1,
    );
    let source = Source { file: "train.toml".into(), text, overridden: vec![], folder: None };
    let changes: Vec<String> = if curve.is_empty() { vec![] } else { vec![curve.into()] };
    load::read("train", source, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// The number of evaluations does not grow with the train: its start costs as much per coach.
#[test]
fn hard_cost_of_starting_trains() {
    for curve in ["", &curve(600.0, -0.1, 0.0)] {
        for coaches in [1, 2, 4, 8, 16] {
            let scene = train(coaches, curve);
            let clock = Instant::now();
            match Simulation::new(&scene, 0.0) {
                Ok(_) => println!("{coaches} coaches {curve}: {:.1} ms", 1e3 * clock.elapsed().as_secs_f64()),
                Err(error) => println!("{coaches} coaches {curve}: {error}"),
            }
        }
    }
}
