//! What holds to an axle by its bearings, which hand no moment about it over: axle loads by the lever rule.

use crate::common::start;
use std::fmt::Write;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::settings::Source;
use wheelrail::sim::statics::{self, Statics};

const G: f64 = 9.81;
const HEAD: &str = r#"
[track]
rail_distance = 1.5
inclination = "1:40"
rail = { kind = "arc", radius = 0.3 }
[contact]
formulation = "ECF-A"
friction = 0.4
patch = "ellipse"
creep = { law = "polach" }
material = { youngs_modulus = 2.1e11, poisson_ratio = 0.28 }
[solver]
integrator = "auto"
tolerance = 1e-6
[run]
stop = 1.0
step = 0.01
[vehicle]
template = "free"
speed = 15.0
travel = "free"
wheel_profile = { kind = "cone", radius = 0.46, slope = 0.1 }
"#;

fn wheelset(name: &str, x: f64) -> String {
    format!(
        "[[vehicle.wheelset]]\nname = \"{name}\"\nx = {x}\nmass = 1200\ninertia_xx = 700\ninertia_yy = 100\ninertia_zz = 700\ntread_circle_distance = 1.5\n"
    )
}

fn body(name: &str, mass: f64, position: [f64; 3]) -> String {
    let [x, y, z] = [1.0, 4.0, 4.2].map(|part| part * mass.max(100.0) / 1.2);
    format!(
        "[[vehicle.body]]\nname = \"{name}\"\nmass = {mass}\nposition = {position:?}\ninertia_xx = {x}\ninertia_yy = {y}\ninertia_zz = {z}\n"
    )
}

fn bushing(name: &str, [from, to]: [&str; 2], at: [f64; 3], more: &str) -> String {
    format!(
        "[[vehicle.force]]\nname = \"{name}\"\nkind = \"bushing\"\nmirrored = true\nfrom = \"{from}\"\nto = \"{to}\"\nat = {at:?}\ndamping = [4e4, 4e4, 4e4]\n{more}\n"
    )
}

fn joint(name: &str, kind: &str, [first, second]: [&str; 2], [at, axis]: [[f64; 3]; 2]) -> String {
    let axis = if ["rigid", "spherical"].contains(&kind) { String::new() } else { format!("axis = {axis:?}\n") };
    format!("[[vehicle.joint]]\nname = \"{name}\"\nkind = \"{kind}\"\nfirst = \"{first}\"\nsecond = \"{second}\"\nat = {at:?}\n{axis}")
}

fn open(parts: &[String]) -> Result<Scene, String> {
    let text = parts.iter().fold(HEAD.to_string(), |mut all, part| {
        let _ = write!(all, "{part}");
        all
    });
    let source = Source { file: "wagon.toml".into(), text, overridden: Vec::new(), folder: None };
    load::read("wagon", source, &[]).map_err(|error| error.to_string())
}

fn stands(parts: &[String]) -> Statics {
    let scene = open(parts).unwrap_or_else(|error| panic!("{error}"));
    statics::statics(&scene, &mut start(&scene)).unwrap()
}

fn axles(found: &Statics) -> Vec<f64> {
    found.wheels.iter().map(|wheels| wheels.left + wheels.right).collect()
}

const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// A car of 12 t half a metre ahead of the middle of two axles 4 m apart.
fn wagon() -> Vec<String> {
    vec![body("car", 12e3, [0.5, 0.0, 1.4]), wheelset("w1", 2.0), wheelset("w2", -2.0)]
}

fn lever_rule(found: &Statics, more: f64) {
    let expected = [2.5, 1.5].map(|arm| 12e3 * G * arm / 4.0 + (1200.0 + more) * G);
    println!("{:?} N, by the lever rule {expected:?} N", axles(found));
    for (axle, expected) in axles(found).iter().zip(expected) {
        assert!((axle / expected - 1.0).abs() < 2e-3, "{axle} {expected}");
    }
}

/// Horn guides and rigid joints on the axles themselves took the car's moment: 70.6 kN on both for 85.3 and 55.9 kN.
#[test]
fn analytic_frames_on_axles_stand_by_the_lever_rule_or_are_refused() {
    let springs = |ends: [[&str; 2]; 2]| {
        let spring = |name, ends, x| bushing(name, ends, [x, 1.0, 0.46], "stiffness = [0, 0, 1.2e6]\npreload = \"static\"");
        [spring("front", ends[0], 2.0), spring("rear", ends[1], -2.0)]
    };
    let places = [[2.0, 0.0, 0.46], [-2.0, 0.0, 0.46]];
    let with = |kind: &str| {
        let held = [joint("j1", kind, ["car", "w1"], [places[0], Z]), joint("j2", kind, ["car", "w2"], [places[1], Z])];
        [&wagon()[..], &held, &springs([["car", "w1"], ["car", "w2"]])].concat()
    };
    for kind in ["prismatic", "rigid"] {
        let refused = open(&with(kind)).err().unwrap_or_default();
        assert!(refused.contains("against turning about the axle of w1") && refused.contains("kind"), "{kind}: {refused}");
    }
    let aside = joint("j1", "spherical", ["car", "w1"], [[1.0, 0.0, 0.46], Z]);
    let refused = open(&[&wagon()[..], &[aside], &springs([["car", "w1"], ["car", "w2"]])].concat()).err().unwrap_or_default();
    assert!(refused.contains("against turning"), "{refused}");
    let boxes = |mass| [body("box1", mass, places[0]), body("box2", mass, places[1])];
    let held = [
        joint("r1", "revolute", ["w1", "box1"], [places[0], Y]),
        joint("r2", "revolute", ["w2", "box2"], [places[1], Y]),
        joint("h1", "prismatic", ["car", "box1"], [places[0], Z]),
        joint("h2", "prismatic", ["car", "box2"], [places[1], Z]),
    ];
    lever_rule(&stands(&[&wagon()[..], &boxes(20.0), &held, &springs([["car", "box1"], ["car", "box2"]])].concat()), 20.0);
    // A mass that nothing else acts on may be fixed.
    let lump = [body("caliper", 50.0, places[0]), joint("fixed", "rigid", ["w1", "caliper"], [places[0], Z])];
    let direct = |more: &str| {
        let spring = |name, axle, x| {
            bushing(name, ["car", axle], [x, 1.0, 0.46], &format!("stiffness = [4e6, 4e6, 1.2e6]\npreload = \"static\"\n{more}"))
        };
        [&wagon()[..], &[spring("front", "w1", 2.0), spring("rear", "w2", -2.0)]].concat()
    };
    assert!(open(&[direct(""), lump.to_vec()].concat()).is_ok());
    // Rubber against turning about the axle: its box turns with the car.
    let plain = stands(&direct(""));
    lever_rule(&plain, 0.0);
    let stiff = stands(&direct("rotational_stiffness = [0, 5e7, 0]\nrotational_damping = [0, 1e4, 0]"));
    assert_eq!(axles(&plain), axles(&stiff));
}

/// Preloads from balance of frames whose weight stands aside of their middle: no axle is pulled along the track, which a wheel that rolls freely would not hold
/// (their pull had been 2.5 kN a spring), and axle loads are those of the lever rule.
#[test]
fn analytic_preloads_from_balance_pull_no_axle_along_the_track() {
    let mut parts = vec![body("car", 60e3, [0.0, 0.0, 2.0])];
    for (frame, way) in [("f1", 1.0), ("f2", -1.0)] {
        let middle = 5.0 * way;
        parts.push(body(frame, 12e3, [middle + 0.3 * way, 0.0, 0.8]));
        for (axle, at) in [("a", 1.5), ("b", -1.5)] {
            let (name, x) = (format!("{frame}{axle}"), middle + at * way);
            parts.push(wheelset(&name, x));
            parts.push(bushing(
                &format!("p{name}"),
                [frame, &name],
                [x, 1.0, 0.46],
                "stiffness = [12e6, 6e6, 1.5e6]\npreload = \"static\"",
            ));
        }
        parts.push(bushing(&format!("s{frame}"), ["car", frame], [middle, 1.0, 1.1], "stiffness = [2e5, 2e5, 5e5]\npreload = \"static\""));
        parts.push(bushing(&format!("pivot{frame}"), ["car", frame], [middle, 0.01, 0.7], "stiffness = [1e7, 0, 0]\npreload = \"static\""));
    }
    let found = stands(&parts);
    let expected = [1.0, -1.0].map(|side| (30e3 + 12e3) * G / 2.0 + side * 12e3 * G * 0.3 / 3.0 + 1200.0 * G);
    let loads = axles(&found);
    println!("{loads:?} N, by the lever rule {expected:?} N");
    for wheels in &found.wheels {
        let expected = expected[usize::from(wheels.wheelset.ends_with('b'))];
        assert!(((wheels.left + wheels.right) / expected - 1.0).abs() < 4e-4, "{wheels:?}");
    }
    // Car and frame may pull at each other, by a couple of pivot and springs that carries 0.5 % of the frame's moment.
    for pull in found.elements.iter().filter(|row| row.name.starts_with("pf") && row.name.ends_with(" x")) {
        assert!(pull.force.abs() < 20.0 && pull.displacement.abs() < 2e-5, "{pull:?}");
    }
}
