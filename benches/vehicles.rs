//! Cost of vehicles and trains: steady state, right-hand side, simulated time against accuracy.
//!
//! `cargo bench --bench vehicles` prints tables and what is reached of the aims. Times depend on the machine; nothing here is asserted.

#[path = "common/aims.rs"]
mod aims;

use aims::{Aim, Measured};
use std::hint::black_box;
use std::time::Instant;
use wheelrail::formulation::Evaluation;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;
use wheelrail::solve::Statistics;

fn open(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// A train of so many coaches on the scene `vehicle_manchester_1`.
fn train(coaches: usize) -> Scene {
    let embedded = wheelrail::scene::embedded::find("vehicle_manchester_1").map_or("", |scene| scene.text);
    let places = format!(
        "[vehicle.module.coach]\ntemplate = \"vehicle_manchester_1\"\n\n[[vehicle.place]]\nname = \"coach\"\nmodule = \"coach\"\n\
         position = [0, 0, 0]\ncount = {coaches}\nspacing = [-26, 0, 0]\n\n[[vehicle.place.between]]\nname = \"coupler\"\nkind = \"coupler\"\n\
         from = {{ body = \"car\", at = [-12.5, 0, 1] }}\nto = {{ body = \"car\", at = [12.5, 0, 1] }}\n\
         draw_stiffness = 5e6\nbuffer_stiffness = 1e7\n"
    );
    let text = embedded.replace("template = \"vehicle_manchester_1\"", "template = \"free\"").replacen(
        "\n[track]\n",
        &format!("\n{places}\n[track]\n"),
        1,
    );
    let source = Source { file: "train.toml".into(), text, overridden: vec![], folder: None };
    load::read("train", source, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn start(scene: &Scene) -> (Simulation, f64) {
    let clock = Instant::now();
    let simulation = Simulation::new(scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
    (simulation, clock.elapsed().as_secs_f64())
}

/// Best of several rounds, s.
fn right_hand_side(simulation: &mut Simulation) -> f64 {
    const CALLS: u32 = 200;
    let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{error}")).clone();
    let model = simulation.model();
    let mut workspace = model.workspace();
    let (mut memory, mut dy, mut y) = (snapshot.memory().clone(), snapshot.dy.clone(), snapshot.y.clone());
    let mut best = f64::INFINITY;
    for _ in 0..10 {
        let clock = Instant::now();
        for call in 0..CALLS {
            // As far off as it is from stage to stage of a step.
            y[1] = snapshot.y[1] + if call % 2 == 0 { 1e-6 } else { 0.0 };
            let at = Evaluation { t: 0.0, inputs: snapshot.inputs(), y: black_box(&y), memory: &mut memory };
            model.derivative(&mut workspace, at, &mut dy).unwrap_or_else(|error| panic!("{error}"));
        }
        best = best.min(clock.elapsed().as_secs_f64() / f64::from(CALLS));
    }
    best
}

/// Lateral displacement of all wheelsets [m] and all wheel loads in parts of the static one, every 0.53 ms over 3 s, between the ends of steps.
#[derive(Default)]
struct Motion {
    lateral: Vec<f64>,
    load: Vec<f64>,
}

impl Motion {
    /// Largest distances.
    fn apart(&self, other: &Motion) -> [f64; 2] {
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        [apart(&self.lateral, &other.lateral), apart(&self.load, &other.load)]
    }
}

fn motion(scene: &Scene) -> (Motion, Statistics) {
    const EVERY: f64 = 0.53e-3;
    let (mut simulation, _) = start(scene);
    let wheelsets: Vec<(usize, f64)> = simulation.model().wheelsets.iter().map(|one| (one.body, one.static_wheel_load)).collect();
    let mut found = Motion::default();
    for i in 1..=(3.0 / EVERY) as u32 {
        simulation.advance(EVERY * f64::from(i)).unwrap_or_else(|error| panic!("{error}"));
        let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{error}"));
        for (index, (body, load)) in wheelsets.iter().enumerate() {
            found.lateral.push(snapshot.y[6 * body + 1]);
            found.load.extend([0, 1].map(|side| snapshot.workspace.wheel_force(2 * index + side, *body).z / load));
        }
    }
    (found, simulation.statistics())
}

/// Best of several runs of 3 s without outputs, s per simulated second, and the slowest one over the best.
fn cost(scene: &Scene) -> (f64, f64) {
    /// s.
    const ENOUGH: f64 = 1.5;
    let (mut simulation, _) = start(scene);
    let begin = simulation.state().clone();
    let (mut best, mut worst, mut sum) = (f64::INFINITY, 0.0f64, 0.0);
    while sum < ENOUGH {
        simulation.restore(&begin);
        let clock = Instant::now();
        simulation.advance(3.0).unwrap_or_else(|error| panic!("{error}"));
        let seconds = clock.elapsed().as_secs_f64();
        (best, worst, sum) = (best.min(seconds), worst.max(seconds), sum + seconds);
    }
    (best / 3.0, worst / best)
}

/// Scenes with their changes and the aim of times real time at 1e-5 m with all wheel loads to 1 % at every instant, where there is one.
const CASES: [(&str, &str, Option<f64>, &[&str]); 6] = [
    ("bogie", "bogie", None, &[]),
    ("vehicle_manchester_1, two bumps", "vehicle_manchester_1", None, &[]),
    ("vehicle_equalised, two bumps", "vehicle_equalised", None, &[]),
    (
        "vehicle_manchester_1, irregular straight track (ORE B176 low)",
        "vehicle_manchester_1",
        Some(80.0),
        &["track.deviation=[]", "track.irregularity=[{kind=\"spectrum\", spectrum=\"ore_b176_low\", seed=1, from=15, to=400, fade=5}]"],
    ),
    (
        "vehicle_manchester_1, the same at 60 km/h with FASTSIM 21 x 21",
        "vehicle_manchester_1",
        None,
        &[
            "track.deviation=[]",
            "track.irregularity=[{kind=\"spectrum\", spectrum=\"ore_b176_low\", seed=1, from=15, to=400, fade=5}]",
            "vehicle.speed=\"60 km/h\"",
            "contact.creep.law=fastsim",
            "contact.creep.strips=21",
            "contact.creep.cells=21",
        ],
    ),
    ("vehicle_curve, 582 m with flange contact", "vehicle_curve", Some(30.0), &["vehicle.initial.distance=15"]),
];

fn main() {
    for (label, name, aim, changes) in CASES {
        let (mut simulation, started) = start(&open(name, changes));
        println!("{label}: start {:.1} ms, right-hand side {:.2} us", 1e3 * started, 1e6 * right_hand_side(&mut simulation));
        let with = |integrator: &str, tolerance: &str| {
            let solver = [format!("solver.integrator={integrator}"), format!("solver.tolerance={tolerance}")];
            open(name, &[changes, &solver.each_ref().map(String::as_str)].concat())
        };
        let (reference, _) = motion(&with("dormand_prince", "1e-9"));
        let mut points = Vec::new();
        for (integrator, tolerance) in [
            ("rosenbrock", "1e-4"),
            ("rosenbrock", "5e-5"),
            ("rosenbrock", "3e-5"),
            ("rosenbrock", "2e-5"),
            ("rosenbrock", "1e-5"),
            ("rosenbrock", "1e-6"),
            ("imex", "1e-5"),
            ("dormand_prince", "1e-5"),
            ("dormand_prince", "1e-7"),
            ("rk43", "1e-6"),
        ] {
            let scene = with(integrator, tolerance);
            let (found, work) = motion(&scene);
            let (cost, spread) = cost(&scene);
            let [lateral, load] = found.apart(&reference);
            println!(
                "  {integrator:15} {tolerance}: error of y {lateral:.1e} m, of Q {:4.2} %, {:5.1} times real time; {:5} steps, {:5} evaluations, {:4} Jacobians",
                100.0 * load,
                1.0 / cost,
                work.steps,
                work.evaluations,
                work.linearisations
            );
            // 1 % of a wheel load counts as 1e-5 m.
            let error = lateral.max(1e-3 * load);
            points.push(Measured { integrator: integrator.into(), setting: tolerance.into(), error, factor: 1.0 / cost, spread });
        }
        if let Some(factor) = aim {
            println!("{}", Aim { what: label, factor, error: 1e-5 }.words(&points));
        }
    }
    for coaches in [1, 2, 4, 8, 16] {
        let (mut simulation, started) = start(&train(coaches));
        let cost = right_hand_side(&mut simulation) / coaches as f64;
        println!("train of {coaches:2}: start {:7.1} ms, right-hand side {:.2} us per coach", 1e3 * started, 1e6 * cost);
    }
}
