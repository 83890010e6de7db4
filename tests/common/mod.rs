//! Shared by the integration tests.
#![allow(dead_code)] // each test binary uses its part

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;
use wheelrail::sim::outputs::Output;
use wheelrail::sim::recording::{self, Recording};
use wheelrail::sim::vehicle_outputs::scene_outputs;

/// Changes under which a vehicle's time integration is far more exact than what tests of its physics look at.
pub const EXACT: [&str; 2] = ["solver.integrator=dormand_prince", "solver.tolerance=1e-7"];

/// The embedded scene with changes.
pub fn scene(changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open("suspended_wheelset", &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// The same wheelset on straight track: it starts behind the disturbance.
pub fn straight(changes: &[&str]) -> Scene {
    let mut all = vec!["vehicle.initial.distance=100"];
    all.extend(changes);
    scene(&all)
}

pub fn start(scene: &Scene) -> Simulation {
    Simulation::new(scene, 0.0).unwrap_or_else(|error| panic!("{error}"))
}

pub fn table(simulation: &Simulation, scene: &Scene) -> Vec<Output> {
    scene_outputs(scene, simulation.model())
}

/// Outputs by name, without "wheelset.", at the simulation's time.
pub fn read(simulation: &mut Simulation, outputs: &[Output]) -> HashMap<String, f64> {
    let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{error}"));
    outputs.iter().map(|output| (output.name.trim_start_matches("wheelset.").to_string(), output.value(snapshot))).collect()
}

/// Runs a scene with outputs every `step` seconds.
pub fn run(scene: &Scene, stop: f64, step: f64) -> Recording {
    let mut simulation = start(scene);
    let outputs = table(&simulation, scene);
    recording::record(&mut simulation, &outputs, stop, step, |_| {}).unwrap_or_else(|error| panic!("{error}"))
}

pub fn column(recording: &Recording, name: &str) -> Vec<f64> {
    recording.column(&format!("wheelset.{name}")).unwrap_or_else(|| panic!("no column {name}"))
}

pub fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// A CSV with `#` comments and a header, as rows of name -> value.
pub fn read_csv(path: &Path) -> Vec<HashMap<String, f64>> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    reader
        .records()
        .map(|record| {
            let record = record.unwrap();
            header.iter().map(str::to_string).zip(record.iter().map(|cell| cell.parse().unwrap())).collect()
        })
        .collect()
}
