//! Several contacts per wheel: the state's memory must not decide what touches.

use crate::common;
use crate::common::{read, start, table};
use wheelrail::formulation::events::ContactChange;
use wheelrail::formulation::input_index;
use wheelrail::formulation::memory::ModelMemory;
use wheelrail::formulation::{Evaluation, LATERAL_FORCE, VERTICAL_FORCE};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;

fn scene(changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    let path = common::data("scenes/apta_flange.toml");
    load::open_file(&path, "apta_flange", &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// Numbers between -1 and 1, the same in each run.
fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    }
}

/// The memory without what lets an evaluation pass over a search.
fn forgetful(memory: &ModelMemory) -> ModelMemory {
    let mut memory = memory.clone();
    memory.wheels.iter_mut().for_each(|wheel| wheel.forget());
    memory
}

/// Sum of normal forces of each wheel [N], from the state of the simulation, with its memory and with one that must search.
fn with_and_without_memory(simulation: &mut Simulation) -> [Vec<f64>; 2] {
    let snapshot = simulation.snapshot().unwrap().clone();
    let model = simulation.model();
    let sums = |workspace: &wheelrail::formulation::Workspace| -> Vec<f64> {
        (0..model.contacts()).map(|contact| workspace.reports(contact).map(|c| c.normal_force).sum()).collect()
    };
    [snapshot.memory().clone(), forgetful(snapshot.memory())].map(|mut memory| {
        let mut workspace = model.workspace();
        let mut dy = vec![0.0; snapshot.y.len()];
        let at = Evaluation { t: snapshot.time, inputs: snapshot.inputs(), y: &snapshot.y, memory: &mut memory };
        model.derivative(&mut workspace, at, &mut dy).unwrap();
        sums(&workspace)
    })
}

#[test]
fn regress_a_wheel_that_lifts_off_its_constraint_keeps_its_tread_in_sight() {
    for formulation in ["ECCF", "ACCF"] {
        let scene = scene(&[&format!("contact.formulation={formulation}"), "contact.on_lift=elastic"]);
        let mut simulation = start(&scene);
        simulation.advance(0.05).unwrap();
        // More than weight and load for a while, then the wheelset falls back.
        simulation.set_input(input_index(0, VERTICAL_FORCE), 120e3, 0.0, 0.0);
        simulation.advance(0.06).unwrap();
        simulation.set_input(input_index(0, VERTICAL_FORCE), 0.0, 0.0, 0.0);
        let (mut worst, mut lifted) = (0f64, false);
        for i in 1..=300 {
            simulation.advance(0.06 + i as f64 * 5e-4).unwrap();
            lifted |= simulation.take_events().iter().any(|e| e.change == ContactChange::Lifted);
            let [with, without] = with_and_without_memory(&mut simulation);
            for (a, b) in with.iter().zip(&without) {
                worst = worst.max((a - b).abs());
            }
        }
        println!("{formulation}: lifted {lifted}, memory changes a wheel's normal force by up to {worst:.3e} N");
        assert!(lifted);
        assert!(worst < 1.0, "{formulation}: {worst}");
    }
}

#[test]
fn prop_normal_forces_are_those_of_the_pose_whatever_was_before() {
    let mut random = random(12345);
    let cases: Vec<(String, Scene)> = {
        let open = |name: &str, changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
            load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
        };
        let mut cases = Vec::new();
        for points in [2, 3, 4] {
            let points = format!("contact.points={points}");
            cases.push((format!("s1002 {points}"), open("wheelset_s1002", &[&points])));
            cases.push((format!("apta {points}"), scene(&[&points])));
        }
        cases
    };
    let mut failures = Vec::new();
    for (name, scene) in cases {
        let simulation = start(&scene);
        let model = simulation.model();
        let start = simulation.state().integration.y.clone();
        let mut workspace = model.workspace();
        let mut dy = vec![0.0; start.len()];
        let inputs = model.neutral_inputs();
        let (mut worst, mut worst_pose, mut evaluated, mut several, mut beyond) = (0f64, [0.0; 4], 0, 0, 0);
        for _ in 0..300 {
            let mut memory = model.blank_memory();
            let mut y = start.clone();
            (y[1], y[3]) = (9e-3 * random(), 0.02 * random());
            y[2] += 1e-3 * random();
            y[4] = 1e-3 * random();
            for _ in 0..60 {
                for (i, size) in [(1, 1.5e-4), (2, 5e-5), (3, 1e-4), (4, 5e-5)] {
                    y[i] += size * random();
                }
                let at = Evaluation { t: 0.0, inputs: &inputs, y: &y, memory: &mut memory };
                if model.derivative(&mut workspace, at, &mut dy).is_err() {
                    beyond += 1;
                    break;
                }
                let sums = |workspace: &wheelrail::formulation::Workspace| -> Vec<f64> {
                    (0..2).map(|contact| workspace.reports(contact).map(|c| c.normal_force).sum()).collect()
                };
                let with = sums(&workspace);
                let pressed = workspace.contacts.iter().chain(&workspace.further_contacts).filter(|c| c.normal_force > 0.0).count();
                let mut cold = model.blank_memory();
                let at = Evaluation { t: 0.0, inputs: &inputs, y: &y, memory: &mut cold };
                if model.derivative(&mut workspace, at, &mut dy).is_err() {
                    break;
                }
                let without = sums(&workspace);
                evaluated += 1;
                several += usize::from(pressed > 2);
                for (a, b) in with.iter().zip(&without) {
                    let error = (a - b).abs() / (1e3 + b.abs());
                    if error > worst {
                        (worst, worst_pose) = (error, [y[1], y[2] - start[2], y[3], y[4]]);
                    }
                }
            }
        }
        println!("{name}: {evaluated} poses, {several} with more than two pressed, {beyond} beyond; worst {worst:.2e} at {worst_pose:?}");
        if worst > 1e-6 {
            failures.push(name);
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}

#[test]
fn prop_places_of_one_patch_are_followed_and_give_the_forces_of_a_search() {
    // Around the centre S1002 touches 60E1 at two places of one patch with a pressed ridge between them.
    let steps = if cfg!(debug_assertions) { 4000 } else { 100_000 };
    for points in [2, 3] {
        let scene = load::open("wheelset_s1002", &[format!("contact.points={points}")]).unwrap_or_else(|error| panic!("{error}"));
        let simulation = start(&scene);
        let model = simulation.model();
        let start = simulation.state().integration.y.clone();
        let mut random = random(77);
        let (mut workspace, mut dy, inputs) = (model.workspace(), vec![0.0; start.len()], model.neutral_inputs());
        let mut memory = model.blank_memory();
        let (mut worst, mut worst_pose, mut followed, mut pressed, mut jump) = (0f64, [0.0; 4], 0, 0, 0f64);
        let (mut offset, mut before) = ([0.0; 5], Vec::new());
        for _ in 0..steps {
            // A walk that stays near: lateral and vertical position, yaw and roll.
            for (i, size, most) in [(1, 4e-6, 2e-3), (2, 4e-7, 2e-5), (3, 4e-6, 2e-3), (4, 4e-7, 3e-5)] {
                let next: f64 = offset[i] + size * random();
                offset[i] = next.clamp(-most, most);
            }
            let mut y = start.clone();
            (1..5).for_each(|i| y[i] += offset[i]);
            let mut forces = |memory: &mut ModelMemory| -> Vec<f64> {
                model.derivative(&mut workspace, Evaluation { t: 0.0, inputs: &inputs, y: &y, memory }, &mut dy).unwrap();
                let force = |c: &wheelrail::formulation::ContactReport| c.force;
                let n = model.points - 1;
                let wheel = |w: usize| {
                    workspace.further_contacts[w * n..(w + 1) * n].iter().map(force).fold(force(&workspace.contacts[w]), |sum, f| sum + f)
                };
                pressed += workspace.further_contacts.iter().filter(|c| c.normal_force > 0.0).count();
                (0..2).flat_map(|w| wheel(w).iter().copied().collect::<Vec<f64>>()).collect()
            };
            let known = memory.clone();
            let with = forces(&mut memory);
            let without = forces(&mut model.blank_memory());
            followed += (0..2)
                .filter(|w| {
                    let [before, now] = [&known, &memory].map(|memory| memory.wheels[*w].searched);
                    now.budget > 0.0 && before.from == now.from
                })
                .count();
            let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let error = largest(&with, &without);
            if error > worst {
                (worst, worst_pose) = (error, [offset[1], offset[2], offset[3], offset[4]]);
            }
            if !before.is_empty() {
                jump = jump.max(largest(&with, &before));
            }
            before = with;
        }
        let share = followed as f64 / (2 * steps) as f64;
        println!("{points} points: {:.2} further contacts pressed, {:.1} % followed", 0.5 * pressed as f64 / steps as f64, 100.0 * share);
        println!("  forces off by {worst:.1e} N at {worst_pose:?}; largest change in one step {jump:.0} N");
        assert!(worst < 1e-2 && share > 0.7 && jump < 4e3);
    }
}

#[test]
fn hard_flange_impacts_with_long_steps_end_and_give_one_begin_for_each_end() {
    for formulation in ["ECF-A", "ECCF", "ACCF"] {
        let scene = scene(&[
            &format!("contact.formulation={formulation}"),
            "contact.on_lift=elastic",
            "solver.tolerance=1e-6",
            "vehicle.initial.vy=0.4",
        ]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        simulation.set_input(input_index(0, LATERAL_FORCE), 15e3, 0.0, 0.0);
        let mut error = None;
        for i in 1..=100 {
            if let Err(e) = simulation.advance(0.01 * f64::from(i)) {
                error = Some(e);
                break;
            }
        }
        let statistics = simulation.statistics();
        println!("{formulation}: {statistics:?} {error:?}");
        let events = simulation.take_events();
        let touched = events.iter().filter(|e| matches!(e.change, ContactChange::Touched { .. })).count();
        let parted = events.iter().filter(|e| matches!(e.change, ContactChange::Parted { .. })).count();
        println!("{formulation}: begun {touched}, ended {parted}");
        assert!(error.is_none(), "{formulation}: {error:?}");
        let pressed = read(&mut simulation, &outputs).iter().filter(|(n, v)| n.contains("[2].normalForce") && **v > 0.0).count();
        assert_eq!(touched, parted + pressed, "{formulation}: {events:#?}");
    }
}

#[test]
fn hard_s1002_on_60e1_runs_through_its_jumps_of_contact() {
    let mut failures = Vec::new();
    let normal = "{ law = \"hertz\", curvature = \"patch\", conformal = \"bounded\" }";
    for formulation in ["ECF-A", "ECCF", "ACCF"] {
        let changes =
            [format!("contact.formulation={formulation}"), "contact.on_lift=elastic".to_string(), format!("contact.normal={normal}")];
        let scene = load::open("wheelset_s1002", &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let (mut most, mut least) = (0f64, f64::INFINITY);
        for i in 1..=240 {
            if let Err(error) = simulation.advance(2.5e-3 * f64::from(i)) {
                println!("{formulation} {normal}: {error}");
                failures.push(format!("{formulation} {normal}: {error}"));
                break;
            }
            let now = read(&mut simulation, &outputs);
            for side in ["left", "right"] {
                most = most.max(now[&format!("{side}.verticalForce")]);
                least = least.min(now[&format!("{side}.verticalForce")]);
            }
        }
        let events = simulation.take_events();
        println!("{formulation} {normal}: t = {:.4} s, Q {least:.0} to {most:.0} N, {} events", simulation.time(), events.len());
        println!("  {:?}", simulation.statistics());
        if most > 150e3 {
            failures.push(format!("{formulation} {normal}: Q up to {most:.0} N"));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn hard_equilibrium_on_wheels_of_unlike_size_is_that_of_the_constraints() {
    let z = |formulation: &str| {
        let scene =
            scene(&[&format!("contact.formulation={formulation}"), "vehicle.wheelset.left_profile={ kind = \"s1002\", radius = 0.461 }"]);
        let found = wheelrail::scene::steady_state::steady_state(&scene).unwrap_or_else(|error| panic!("{formulation}: {error}"));
        let [_, _, z, roll, ..] = found.initial_values();
        [z, roll]
    };
    let (elastic, rigid) = (z("ECF-A"), z("ECCF"));
    println!("{elastic:?}\n{rigid:?}");
    assert!((elastic[1] - rigid[1]).abs() < 1e-4 && (elastic[0] - rigid[0]).abs() < 2e-4);
}
