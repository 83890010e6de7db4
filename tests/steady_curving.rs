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
            let changes = [curve(radius, height, grade), "vehicle.drive=leading".into(), format!("contact.formulation={formulation}")];
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
