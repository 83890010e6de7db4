//! Inputs by a table: what they make of a vehicle is known, and where results are read or a run is stopped changes nothing.

use crate::common::{largest_difference, start};
use std::ops::ControlFlow;
use wheelrail::formulation::inputs::{DRIVE_TORQUE, LONGITUDINAL_FORCE, WANTED_SPEED, input_index};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::input_table::InputTable;
use wheelrail::sim::recording::{Recording, Run, Times};
use wheelrail::sim::vehicle_outputs::scene_outputs;

fn open(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{changes:?}: {error}"))
}

fn run(scene: &Scene, table: &InputTable, stop: f64, step: f64) -> Recording {
    let mut simulation = start(scene);
    let outputs = scene_outputs(scene, simulation.model());
    let mut run = Run::new(&simulation, &outputs);
    run.inputs = Some(table.clone());
    run.go_on(&mut simulation, &outputs, Times { stop, step }, |_, _| ControlFlow::Continue(())).unwrap_or_else(|error| panic!("{error}"));
    run.end()
}

/// A wheelset that is pulled by a force F(t) of lines and jumps has the momentum of F's integral; what rolls with it counts as mass.
#[test]
fn analytic_momentum_of_a_force_by_a_table() {
    let times: Vec<f64> = vec![0.1003, 0.3, 0.3, 0.4507, 0.4507, 0.52];
    let forces = vec![0.0, 900.0, -600.0, -600.0, 300.0, 0.0];
    let momentum = |t: f64| -> f64 {
        let mut sum = 0.0;
        for k in 1..times.len() {
            let (from, to) = (times[k - 1], times[k].min(t));
            if to > from {
                let slope = (forces[k] - forces[k - 1]) / (times[k] - from);
                sum += (to - from) * (forces[k - 1] + 0.5 * slope * (to - from));
            }
        }
        sum
    };
    for method in ["solver.integrator=rosenbrock", "solver.integrator=dormand_prince"] {
        let scene = open("suspended_wheelset", &["vehicle.travel=free", "track.deviation=[]", "solver.tolerance=1e-9", method]);
        let pulled = InputTable::new(times.clone(), vec![(input_index(0, LONGITUDINAL_FORCE), forces.clone())]).unwrap();
        let rests = InputTable::new(vec![0.0], vec![(input_index(0, LONGITUDINAL_FORCE), vec![0.0])]).unwrap();
        let [found, plain] = [&pulled, &rests].map(|table| run(&scene, table, 0.8, 0.02));
        let column = |recording: &Recording, name: &str| recording.column(name).unwrap_or_else(|| panic!("{name}"));
        let speeds: Vec<f64> =
            column(&found, "wheelset.vx").iter().zip(column(&plain, "wheelset.vx")).map(|(with, without)| with - without).collect();
        // Mass with what it supports and rolls, from the end.
        let last = *speeds.last().unwrap();
        let mass = momentum(1.0) / last;
        println!("{method}: {mass:.1} kg");
        let own = 1568.0 + 98_000.0 / 9.81 + 168.0 / (0.457 * 0.457);
        assert!((mass / own - 1.0).abs() < 0.02, "{mass} kg, {own} kg");
        for (t, speed) in column(&found, "time").iter().zip(&speeds) {
            let expected = momentum(*t) / mass;
            // Creepage holds a little of the force's change back.
            assert!((speed - expected).abs() < 0.02 * 900.0 * 0.2 / mass, "{method}, {t}: {speed:e}, {expected:e}");
        }
    }
}

#[test]
fn prop_rows_and_stops_change_nothing() {
    let scene = open("suspended_wheelset", &["vehicle.speed={start=20}", "solver.integrator=rosenbrock", "solver.tolerance=1e-8"]);
    let speed = start(&scene).model().first_travel_input(start(&scene).state().inputs.len()).unwrap() + WANTED_SPEED;
    let columns = vec![(speed, vec![20.0, 20.0, 21.0, 20.5]), (input_index(0, DRIVE_TORQUE), vec![0.0, 0.0, 1500.0, -700.0])];
    let table = InputTable::new(vec![0.0, 0.111, 0.611, 0.911], columns.clone()).unwrap();
    let coarse = run(&scene, &table, 1.2, 0.1);
    let fine = run(&scene, &table, 1.2, 0.004);
    for name in ["wheelset.y", "wheelset.vx", "wheelset.yaw"] {
        let every: Vec<f64> = fine.column(name).unwrap().into_iter().step_by(25).collect();
        let apart = largest_difference(&coarse.column(name).unwrap(), &every);
        println!("{name}: {apart:.1e}");
        assert!(apart < 1e-12, "{name}: {apart:e}");
    }
    // Rows on the lines between say nothing new.
    let between = [0.0, 0.05, 0.111, 0.361, 0.611, 0.761, 0.911, 3.0];
    let more = columns.iter().map(|(input, _)| (*input, between.iter().map(|t| table.value(*input, *t).unwrap()).collect())).collect();
    let same = run(&scene, &InputTable::new(between.to_vec(), more).unwrap(), 1.2, 0.1);
    for name in ["wheelset.y", "wheelset.vx", "wheelset.yaw"] {
        let apart = largest_difference(&coarse.column(name).unwrap(), &same.column(name).unwrap());
        println!("{name} with more rows: {apart:.1e}");
        assert!(apart < 1e-9, "{name}: {apart:e}");
    }
    // V is what the table wants: straight lines with their slopes.
    let (times, found) = (coarse.column("time").unwrap(), coarse.column("wheelset.vx").unwrap());
    let worst = times.iter().zip(&found).map(|(t, v)| (v - table.value(speed, *t).unwrap()).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-6, "{worst:e} m/s");
}
