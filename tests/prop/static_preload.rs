//! `preload = "static"`, how a vehicle stands at its start, and tables of forces that a run leaves.

use crate::common::start;
use std::process::Command;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::settings::Source;
use wheelrail::sim::recording;
use wheelrail::sim::statics::{self, Statics};
use wheelrail::sim::vehicle_outputs::scene_outputs;

const G: f64 = 9.81;
/// Behind the scene's deviations, and more exact than what is looked at.
const STRAIGHT: &str = "vehicle.initial.distance=150";
const STATIC: [&str; 3] = [
    "vehicle.module.truck.force[primary[1]].preload=static",
    "vehicle.module.truck.force[primary[2]].preload=static",
    "vehicle.module.truck.force[secondary].preload=static",
];

fn open(changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<String> = [STRAIGHT].iter().chain(changes).map(|change| (*change).to_string()).collect();
    load::open("vehicle_manchester_1", &changes).map_err(|error| error.to_string())
}

fn stands(changes: &[&str]) -> Statics {
    let scene = open(changes).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = start(&scene);
    statics::statics(&scene, &mut simulation).unwrap()
}

fn force(found: &Statics, name: &str) -> f64 {
    found.elements.iter().find(|row| row.name == name).unwrap_or_else(|| panic!("no {name}")).force
}

/// The template's preloads are derived by hand from the mass table: an eighth of car and frames per axle box, a quarter of the car per spring.
#[test]
fn analytic_preloads_from_balance_are_those_of_the_mass_table() {
    let found = stands(&STATIC);
    for (name, expected) in [("primary[1].left z", 45653.2875), ("primary[2].right z", 45653.2875), ("secondary.left z", -78480.0)] {
        for truck in 1..=2 {
            let force = force(&found, &format!("truck[{truck}].{name}"));
            println!("truck[{truck}].{name}: {force:.4} N ({expected:.4} N)");
            assert!((force / expected - 1.0).abs() < 1e-5, "{name}: {force}");
        }
    }
    // Wheels and rails give way by a tenth of a millimetre.
    assert!(found.bodies.iter().all(|body| body.settles.abs() < 3e-4), "{:?}", found.bodies);
    assert_eq!(found.notes(&open(&STATIC).unwrap()), Vec::<String>::new());
}

/// Car of another mass whose centre stands 0.95 m ahead: the lever rule for the springs, and it stands where it is drawn.
#[test]
fn analytic_a_heavy_unequally_loaded_car_stands_level() {
    let change = ["vehicle.body[car].position=[0.95, 0, 1.8]", "vehicle.body[car].mass=45000"];
    let found = stands(&[&change[..], &STATIC[..]].concat());
    for (truck, share) in [(1, 0.55), (2, 0.45)] {
        let carried =
            -force(&found, &format!("truck[{truck}].secondary.left z")) - force(&found, &format!("truck[{truck}].secondary.right z"));
        println!("truck[{truck}]: {carried:.2} N ({:.2} N)", 45000.0 * G * share);
        assert!((carried / (45000.0 * G * share) - 1.0).abs() < 1e-4, "{carried}");
    }
    let car = found.bodies.iter().find(|body| body.name == "car").unwrap();
    println!("{car:?}");
    assert!(car.settles.abs() < 4e-4 && car.pitch.abs() < 1e-4 && car.roll.abs() < 1e-6, "{car:?}");
    // With the template's preloads it sinks and dips its nose.
    let before = stands(&change);
    let car = before.bodies.iter().find(|body| body.name == "car").unwrap();
    assert!(car.settles > 0.05 && car.pitch > 1e-3, "{car:?}");
    let notes = before.notes(&open(&change).unwrap());
    assert!(notes.len() == 1 && notes[0].contains("below where it is drawn"), "{notes:?}");
}

/// A load beside the middle: wheels of one truck carry unlike loads; what stands unevenly between trucks is no fault.
#[test]
fn prop_wheels_of_one_truck_with_unlike_loads_are_told() {
    let notes = |changes: &[&str]| {
        let found = stands(changes);
        found.notes(&open(changes).unwrap()).into_iter().filter(|note| note.contains("of the same truck")).collect::<Vec<_>>()
    };
    let aside = ["vehicle.body[car].position=[0, 0.4, 1.8]"];
    let found = notes(&[&aside[..], &STATIC[..]].concat());
    assert!(found.len() == 1 && found[0].contains("left wheel carries") && found[0].contains("right wheel of the same truck"), "{found:?}");
    let ahead = ["vehicle.body[car].position=[4, 0, 1.8]"];
    assert_eq!(notes(&[&ahead[..], &STATIC[..]].concat()), Vec::<String>::new());
}

/// Only the car's springs are asked; the others' given preloads count, and what they lack can't be made up there.
#[test]
fn prop_given_preloads_count_and_what_nothing_carries_is_said() {
    let found = stands(&STATIC[2..]);
    assert!((force(&found, "truck[1].secondary.left z") / -78480.0 - 1.0).abs() < 1e-5);
    let lack = "vehicle.module.truck.force[primary[1]].preload=[0, 0, 0]";
    let error = open(&[STATIC[2], lack]).err().unwrap_or_default();
    println!("{error}");
    assert!(error.contains("preload = \"static\"") && error.contains("frame") && error.contains("N"), "{error}");
    let wrong = open(&["vehicle.module.truck.force[secondary].preload=statc"]).err().unwrap_or_default();
    assert!(wrong.contains("preload: found \"statc\"") && wrong.contains("\"static\""), "{wrong}");
}

#[test]
fn prop_plan_and_run_tell_of_a_car_that_starts_low() {
    let wheelrail = |arguments: &[&str]| {
        let low = "vehicle.module.truck.force[secondary].preload=[0, 0, 0]";
        let all = [arguments, &["--set", STRAIGHT, "--set", low]].concat();
        let output = Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(all).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
    };
    // A quarter of the car on 430 kN/m: 183 mm; traction rods and dampers' mounts tilt and carry a little.
    let note = "car starts 180 mm below where it is drawn";
    let [plan, _] = wheelrail(&["plan", "vehicle_manchester_1"]);
    assert!(plan.contains(note), "{plan}");
    let [_, messages] = wheelrail(&["run", "vehicle_manchester_1", "--stop", "0"]);
    assert!(messages.contains(note), "{messages}");
    let [report, _] = wheelrail(&["plan", "vehicle_manchester_1", "--static"]);
    println!("{report}");
    for words in ["settles [mm]", "Wheel loads Q", "free travel [mm]", "lateral_stop", "-25.0 .. 25.0", note] {
        assert!(report.contains(words), "{words}: {report}");
    }
    let [json, _] = wheelrail(&["plan", "vehicle_manchester_1", "--static", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    let loads: f64 =
        value["static"]["wheels"].as_array().unwrap().iter().map(|w| w["left"].as_f64().unwrap() + w["right"].as_f64().unwrap()).sum();
    assert!((loads / ((32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0) * G) - 1.0).abs() < 1e-5, "{loads}");
}

/// A damper with a table of small speeds on the vehicle: the plan says how the table goes on, the run that it was left.
#[test]
fn prop_a_run_that_leaves_a_table_says_so() {
    let embedded = wheelrail::scene::embedded::find("vehicle_manchester_1").unwrap().text;
    let notes = |own: &str| {
        let damper = "[[vehicle.force]]\nname = \"extra\"\nkind = \"spring_damper\"\nfrom = \"truck[1].frame\"\nto = \"car\"\nat = [9.5, 0, 0.8]\naxis = \"y\"\n";
        let text = format!("{embedded}\n{damper}{own}\n");
        let source = Source { file: "s.toml".into(), text, overridden: vec![], folder: None };
        let scene = load::read("s", source, &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = start(&scene);
        let plan = wheelrail::scene::plan::plan(&scene, simulation.model()).notes.join("\n");
        let outputs = scene_outputs(&scene, simulation.model());
        let recording = recording::record(&mut simulation, &outputs, 2.0, 0.01, |_| {}).unwrap_or_else(|error| panic!("{error}"));
        (plan, recording.notes.join("\n"))
    };
    let (plan, run) = notes("force_over_speed = [[0, 0], [1e-5, 10]]\nodd = true\nbeyond = \"hold\"");
    println!("{plan}\n{run}");
    assert!(plan.contains("extra: force_over_speed is known from -0.00001 to 0.00001 m/s; beyond, the force at the end holds"), "{plan}");
    assert!(run.contains("extra: force_over_speed ends at") && run.contains("force held there"), "{run}");
    let (plan, run) = notes("force_over_speed = [[0, 0], [5, 500]]");
    println!("{plan}\n{run}");
    assert!(plan.contains("one side of zero alone: odd = true") && plan.contains("the slope at the end goes on"), "{plan}");
    // On the side without points it is left at once, up to the table's other end it is not.
    assert!(run.is_empty() || run.contains("ends at 0 m/s"), "{run}");
    let (_, run) = notes("force_over_speed = [[-5, -500], [0, 0], [5, 500]]");
    assert!(run.is_empty(), "{run}");
}

/// A bag that hardly presses, between car and frame of a bogie that runs over a bump: it would have to pull.
#[test]
fn prop_a_bag_that_pulls_is_told() {
    let notes = |preload: &str| {
        let bag = format!(
            "vehicle.force=[{{name=\"bag\",kind=\"air_spring\",from={{body=\"car\",at=[0,0,1.0]}},to={{body=\"frame\",at=[0,0,0.6]}},preload={preload},area=0.1,volume=0.02,\
             reservoir_volume=0.02,orifice_damping=1e4}}]"
        );
        let bump = "track.deviation=[{rail=\"both\",direction=\"vertical\",shape=\"cosine\",amplitude=\"20 mm\",from=5,to=11}]";
        let scene = load::open("bogie", &[bag, bump.into()]).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = start(&scene);
        let outputs = scene_outputs(&scene, simulation.model());
        let recording = recording::record(&mut simulation, &outputs, 1.0, 0.01, |_| {}).unwrap();
        recording.notes.into_iter().filter(|note| note.starts_with("bag: it pulled")).count()
    };
    assert_eq!([notes("-20"), notes("-5000")], [1, 0]);
}

/// Balance is that of level track, also where the track climbs: the weight's part along the track had asked centre plates for a moment that nothing holds, and a sound wagon was refused.
#[test]
fn analytic_preloads_on_a_grade_are_those_of_level_track() {
    let wagon = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/freight_wagon_wedges.toml");
    let on = |grade: f64| {
        let scene = load::open(wagon, &[format!("track.grade={grade}")]).unwrap_or_else(|error| panic!("{error}"));
        let found = statics::statics(&scene, &mut start(&scene)).unwrap();
        found.wheels.iter().map(|wheels| wheels.left + wheels.right).sum::<f64>()
    };
    let [level, climbing] = [on(0.0), on(0.02)];
    println!("{level:.1} N level, {climbing:.1} N on 2 %");
    assert!((climbing / level / 0.02_f64.cos() - 1.0).abs() < 1e-6);
}
