//! The assessment of synthetic signals against scipy's filters and numpy's percentiles (tests/reference/assess.py).

use crate::common::data;
use std::f64::consts::PI;
use wheelrail::geometry::Side;
use wheelrail::scene::load;
use wheelrail::sim::recording::Recording;
use wheelrail::study::assess::guiding_angle::GuidingAngle;
use wheelrail::study::assess::known::{Axle, BodySensor, Friction, Known, Vehicle};
use wheelrail::study::assess::sections::{Track, Zone};
use wheelrail::study::assess::signals::Signals;
use wheelrail::study::assess::{Assessment, Verdict};

const RATE: f64 = 500.0;
const DURATION: f64 = 320.0;
const LOAD: f64 = 100e3;

/// The formula of the reference program.
fn waves(t: f64, channel: i32, mean: f64, size: f64) -> f64 {
    let channel = f64::from(channel);
    let wave = |j: i32| {
        let j = f64::from(j);
        let phase = 2.0 * PI * ((0.618033988749895 * j * (channel + 1.0)) % 1.0);
        let slow = 1.0 + 0.5 * (0.02 * j * t + channel).sin();
        size / j.sqrt() * slow * (2.0 * PI * 0.15 * 1.5_f64.powf(j) * t + phase).sin()
    };
    mean + (1..15).map(wave).sum::<f64>()
}

fn signals() -> Signals {
    let names = [
        ("time", "s"),
        ("w.distance", "m"),
        ("w.left.lateralForce", "N"),
        ("w.right.lateralForce", "N"),
        ("w.left.verticalForce", "N"),
        ("w.right.verticalForce", "N"),
        ("w.left.wearNumber", "N"),
        ("w.right.wearNumber", "N"),
        ("floor.distance", "m"),
        ("floor.measuredAx", "m/s2"),
        ("floor.measuredAy", "m/s2"),
        ("floor.measuredAz", "m/s2"),
    ];
    let row = |k: usize| {
        let t = k as f64 / RATE;
        let distance = 20.0 * t + 0.3 * (0.5 * t).sin();
        vec![
            t,
            distance,
            waves(t, 1, -6e3, 1.5e3),
            waves(t, 2, 3e3, 1.2e3),
            waves(t, 3, 52e3, 2.5e3),
            waves(t, 4, 47e3, 2.5e3),
            waves(t, 5, 30.0, 10.0).abs(),
            waves(t, 6, 50.0, 10.0).abs(),
            distance,
            waves(t, 7, 0.0, 0.02),
            waves(t, 8, 0.3, 0.08),
            waves(t, 9, 9.81, 0.1),
        ]
    };
    let rows = (0..=(RATE * DURATION) as usize).map(row).collect();
    let columns = names.map(|(name, unit)| (name.to_string(), unit)).into();
    Signals::of(&Recording { columns, rows, notes: vec![] }).unwrap()
}

/// A flange that stands on its rail with its own angle [deg].
fn guides(degrees: f64) -> GuidingAngle {
    GuidingAngle { angle: degrees.to_radians(), flank: degrees.to_radians() }
}

fn known(track: Track) -> Known {
    let axle = Axle { name: "w".into(), load: LOAD, flange: [guides(70.0); 2] };
    let body_sensors = vec![BodySensor { name: "floor".into(), single_level: false }];
    let friction = Friction { coefficient: 0.35, map: None };
    let vehicle = Vehicle { car: None, axles: vec![axle], friction, body_sensors, frame_sensors: vec![], track };
    Known { vehicle: Some(vehicle), ..Known::default() }
}

/// Every value of the reference program is in the assessment, in one zone, and equal.
fn agrees(found: &Assessment, zone: Zone, reference: &serde_json::Value) -> usize {
    let values = reference.as_object().unwrap();
    for (key, expected) in values {
        let rows: Vec<_> = found.rows.iter().filter(|row| row.key == key).collect();
        assert!(rows.len() == 1 && rows[0].zone.is_none_or(|own| own == zone), "{key}: {rows:?}");
        let (value, expected) = (rows[0].value.unwrap_or(f64::NAN), expected.as_f64().unwrap());
        let error = (value / expected - 1.0).abs();
        println!("{key}: {value} {error:.1e}");
        assert!(error < 1e-10, "{key}: {value}, {expected}");
    }
    values.len()
}

#[test]
fn validate_assessment_against_scipys_filters_and_numpys_percentiles() {
    let reference: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(data("assess.json")).unwrap()).unwrap();
    let signals = signals();
    let straight = Track { line: None, base: 1.5, gravity: 9.81 };
    let found = Assessment::of(&signals, &known(straight)).unwrap();
    assert_eq!(agrees(&found, Zone::Straight, &reference["straight"]), 21);
    // In curves alone: three not assessable.
    assert_eq!(found.rows.iter().filter(|row| row.verdict == Verdict::NotAssessable).count(), 3);
    let changes: Vec<String> = (1..=4)
        .flat_map(|node| [format!("track.node[{node}].curvature=0.0033333333"), format!("track.node[{node}].superelevation=-100 mm")])
        .collect();
    let line = load::open("vehicle_curve", &changes).unwrap_or_else(|error| panic!("{error}")).track.line;
    let found = Assessment::of(&signals, &known(Track { line, base: 1.5, gravity: 9.81 })).unwrap();
    assert_eq!(agrees(&found, Zone::VerySmallRadius, &reference["curve"]), 12);
    assert!(found.sections.len() == 91 && !found.fails(), "{:?}", found.sections.len());
}

/// The Manchester coach: its weight on four axles, S1002's flange of 70 degrees (EN 13715), what its sensors stand on.
#[test]
fn validate_what_a_scene_says_of_a_coach() {
    let scene = load::open("vehicle_manchester_1", &[]).unwrap();
    let vehicle = Vehicle::of(&scene).unwrap();
    let axle = (32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0) * 9.81 / 4.0;
    assert!(vehicle.axles.len() == 4 && vehicle.axles.iter().all(|one| (one.load / axle - 1.0).abs() < 1e-3), "{:?}", vehicle.axles);
    assert!(
        vehicle.axles.iter().flat_map(|one| one.flange).all(|angle| (angle.angle.to_degrees() - 70.0).abs() < 0.05),
        "{:?}",
        vehicle.axles
    );
    let floor = |name: &str| BodySensor { name: name.into(), single_level: false };
    assert_eq!((vehicle.car.as_deref(), vehicle.body_sensors.as_slice()), (Some("car"), &[floor("floor[1]"), floor("floor[2]")][..]));
    assert!(vehicle.frame_sensors.is_empty() && (vehicle.track.base - 1.5).abs() < 0.02);
}

/// Static loads are those of straight, level, undisturbed track, wherever a run begins: on a wave of the rails axle loads of the first instant were 94 to 117 kN for 109, in a canted curve the
/// outer wheels had 2 % more. Friction counts where the vehicle has been.
#[test]
fn validate_static_loads_and_friction_are_not_those_of_the_start() {
    let axle = (32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0) * 9.81 / 4.0;
    let waves = "track.irregularity=[{kind=\"spectrum\", spectrum=\"fra6\", seed=2, from=\"-200 m\", to=\"200 m\"}]";
    let curve = "track.node=[{distance=0, radius=400, superelevation=\"150 mm\"}, {distance=300, radius=400, superelevation=\"150 mm\"}]";
    let friction = "contact.friction_along=[{rail=\"left\", factors=[[0, 1], [3000, 4]], transition=2}]";
    for changes in [["track.deviation=[]", waves, friction], ["track.deviation=[]", curve, friction]] {
        let scene = load::open("vehicle_manchester_1", &changes.map(str::to_string)).unwrap_or_else(|error| panic!("{error}"));
        let vehicle = Vehicle::of(&scene).unwrap();
        assert!(vehicle.axles.iter().all(|one| (one.load / axle - 1.0).abs() < 1e-3), "{:?}", vehicle.axles);
        let largest = |side, to| vehicle.friction.largest(side, [0.0, to]) / scene.contact.friction;
        let found = [largest(Side::Left, 1000.0), largest(Side::Left, 2999.5), largest(Side::Left, 4000.0), largest(Side::Right, 4000.0)];
        assert!(found[0] == 1.0 && (1.0..2.6).contains(&found[1]) && found[2] == 4.0 && found[3] == 1.0, "{found:?}");
    }
}

/// A light coach behind a heavy locomotive has a car body of its own, not a bogie frame; frames weigh with their trucks; axle boxes are neither.
#[test]
fn validate_each_vehicle_of_a_train_has_its_car_body() {
    let sensor = |name: &str, body: &str| format!("{{name=\"{name}\", body=\"{body}\", at=[0.0, 0.0, 1.0], measured=true}}");
    let changes = [
        "vehicle.module.heavy={template=\"vehicle_manchester_1\", body=[{name=\"car\", mass=90000.0}]}".to_string(),
        format!("vehicle.module.coach.sensor=[{}, {}]", sensor("shelf", "car"), sensor("mast", "truck[1].frame")),
        "interface.only=[\"loco\"]".to_string(),
        // Nothing couples them.
        "vehicle.drive=all".to_string(),
        "vehicle.place=[{name=\"loco\", module=\"heavy\", position=[30.0, 0.0, 0.0]}, {name=\"coach\", module=\"coach\", position=[0.0, 0.0, 0.0], count=2, spacing=[-26.0, 0.0, 0.0]}]"
            .to_string(),
    ];
    let scene = match load::open("train", &changes) {
        Ok(scene) => scene,
        Err(error) => panic!("{error}"),
    };
    let vehicle = Vehicle::of(&scene).unwrap();
    let bodies = &vehicle.body_sensors;
    for name in ["coach[1].shelf", "coach[2].shelf", "loco.floor[1]"] {
        assert!(bodies.iter().any(|sensor| sensor.name == name), "{name}: {bodies:?}");
    }
    let frames: Vec<(&str, f64)> = vehicle.frame_sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.mass)).collect();
    assert!(frames.len() == 2 && frames.iter().all(|frame| (frame.1 - (2615.0 + 2.0 * 1813.0)).abs() < 1e-6), "{frames:?}");
}
