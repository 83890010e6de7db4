//! Instructions of one right-hand side, counted by valgrind.

use std::hint::black_box;
use std::time::Instant;
use wheelrail::formulation::Evaluation;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

/// Stages of the Dormand-Prince method as shares of a step.
const STAGES: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

struct Bench {
    simulation: Simulation,
    step: f64,
}

impl Bench {
    fn new(scene: &str, changes: &[&str], time: f64, step: f64) -> Self {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        let scene = load::open(scene, &changes).unwrap();
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        simulation.advance(time).unwrap();
        Bench { simulation, step }
    }
}

#[inline(never)]
fn counted_right_hand_sides(bench: &mut Bench, steps: usize) -> usize {
    let Bench { simulation, step } = bench;
    let snapshot = simulation.snapshot().unwrap().clone();
    let model = simulation.model();
    let mut workspace = model.workspace();
    let (mut memory, mut dy, mut y) = (snapshot.memory().to_vec(), snapshot.dy.clone(), snapshot.y.clone());
    run(model, &mut workspace, &snapshot, &mut memory, &mut dy, &mut y, *step, steps)
}

#[inline(never)]
#[allow(clippy::too_many_arguments)]
fn run(
    model: &wheelrail::formulation::Model,
    workspace: &mut wheelrail::formulation::Workspace,
    snapshot: &wheelrail::sim::Snapshot,
    memory: &mut [f64],
    dy: &mut [f64],
    y: &mut [f64],
    step: f64,
    steps: usize,
) -> usize {
    let mut calls = 0;
    for _ in 0..steps {
        memory.copy_from_slice(snapshot.memory());
        for share in STAGES {
            for i in 0..y.len() {
                y[i] = snapshot.y[i] + share * step * snapshot.dy[i];
            }
            let at = Evaluation { t: simulation_time(snapshot), inputs: snapshot.inputs(), y: black_box(&*y), memory };
            model.derivative(workspace, at, dy).unwrap();
            calls += 1;
        }
    }
    calls
}

fn simulation_time(_: &wheelrail::sim::Snapshot) -> f64 {
    0.0
}

#[test]
#[ignore]
fn worker() {
    let case = std::env::var("CASE").unwrap();
    let mut words = case.split(' ');
    let scene = words.next().unwrap();
    let time: f64 = words.next().unwrap().parse().unwrap();
    let step: f64 = words.next().unwrap().parse().unwrap();
    let steps: usize = words.next().unwrap().parse().unwrap();
    let changes: Vec<&str> = words.collect();
    let mut bench = Bench::new(scene, &changes, time, step);
    let statistics = bench.simulation.statistics();
    let mut best = f64::INFINITY;
    let mut calls = 0;
    for _ in 0..if steps > 20 { 10 } else { 1 } {
        let clock = Instant::now();
        calls = counted_right_hand_sides(&mut bench, steps);
        best = best.min(clock.elapsed().as_secs_f64() / calls as f64);
    }
    println!("{case}: {calls} calls, {:.2} us, {statistics:?}", 1e6 * best);
}
