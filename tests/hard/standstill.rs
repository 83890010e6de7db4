//! Low speed and standstill: `[contact.transient]`.

use crate::common::{read, start, straight, table};
use wheelrail::formulation::input_index;
use wheelrail::formulation::{DRIVE_TORQUE, LONGITUDINAL_FORCE};
use wheelrail::sim::Simulation;

const TRANSIENT: &str = "contact.transient={ below = \"2 m/s\" }";
const FREE: &str = "vehicle.travel=free";
/// vertical_load of the scene, N.
const LOAD: f64 = 98_000.0;

#[test]
fn equiv_above_the_threshold_the_steady_law_holds() {
    for formulation in ["ECF-A", "ECCF", "ACCF", "ECF-N"] {
        let run = |with: bool| {
            let formulation = format!("contact.formulation={formulation}");
            let mut changes = vec![formulation.as_str(), "vehicle.initial.y=2 mm", "solver.tolerance=1e-9"];
            if with {
                changes.push(TRANSIENT);
            }
            let scene = straight(&changes);
            let mut simulation = start(&scene);
            let outputs = table(&simulation, &scene);
            simulation.advance(0.2).unwrap();
            read(&mut simulation, &outputs)
        };
        let (steady, transient) = (run(false), run(true));
        for (name, scale) in [("y", 1e-3), ("yaw", 1e-3), ("left.creepForceX", 1e4), ("left.contact[1].creepForceY", 1e4)] {
            let Some(expected) = steady.get(name) else { continue };
            let difference = (expected - transient[name]).abs() / scale;
            println!("{formulation} {name}: {difference:.1e}");
            // ECF-N jumps from node to node: the steps differ, and with them where they end.
            assert!(difference < if formulation == "ECF-N" { 1e-3 } else { 1e-6 }, "{formulation} {name}");
        }
    }
}

#[test]
fn analytic_a_free_wheelset_accelerates_as_a_rolling_body() {
    // F = (m + M + I / r^2) a while it rolls; r is the rolling radius of the centred wheelset, M g the load that rests on it.
    let scene = straight(&[FREE, "vehicle.speed=20"]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    simulation.set_input(input_index(0, LONGITUDINAL_FORCE), 2000.0, 0.0, 0.0);
    simulation.advance(0.5).unwrap();
    let before = read(&mut simulation, &outputs);
    simulation.advance(1.5).unwrap();
    let after = read(&mut simulation, &outputs);
    let radius = before["vx"] / before["pitchRate"];
    let expected = 2000.0 / (1568.0 + LOAD / 9.81 + 168.0 / (radius * radius));
    let found = after["vx"] - before["vx"];
    println!("acceleration {found:.6} m/s2, rolling body {expected:.6} m/s2 (spin and creep cost the rest)");
    assert!((found / expected - 1.0).abs() < 2e-3);
}

/// A brake that holds: torque against the rotation, at most `most` [N m], a stiff spring once the wheel stands.
fn brake(simulation: &mut Simulation, outputs: &[wheelrail::sim::outputs::Output], most: f64, held: &mut f64, step: f64) {
    const DAMPING: f64 = 2.0e4;
    const STIFFNESS: f64 = 2.0e6;
    let turning = read(simulation, outputs)["pitchRate"];
    *held = (*held + turning * step).clamp(-most / STIFFNESS, most / STIFFNESS);
    let torque = -(DAMPING * turning + STIFFNESS * *held).clamp(-most, most);
    simulation.set_input(input_index(0, DRIVE_TORQUE), torque, 0.0, 0.0);
}

#[test]
fn hard_brakes_to_a_standstill_stays_on_a_grade_and_starts_again() {
    for formulation in ["ECF-A", "ECCF"] {
        let scene = straight(&[
            FREE,
            TRANSIENT,
            "vehicle.speed=3",
            "track.grade=0.03",
            "solver.tolerance=1e-9",
            &format!("contact.formulation={formulation}"),
        ]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let (mut held, step) = (0.0, 5e-4);
        let mut advance_braked = |simulation: &mut Simulation, from: usize, to: usize| {
            for i in from..to {
                brake(simulation, &outputs, 3000.0, &mut held, step);
                simulation.advance((i + 1) as f64 * step).unwrap_or_else(|error| panic!("{formulation}: {error}"));
            }
        };
        advance_braked(&mut simulation, 0, 12000);
        let stopped = read(&mut simulation, &outputs);
        advance_braked(&mut simulation, 12000, 16000);
        let later = read(&mut simulation, &outputs);
        let crept = (later["distance"] - stopped["distance"]).abs();
        let grade = 0.03f64.atan();
        let downhill = (1568.0 * 9.81 + LOAD) * grade.sin();
        let held_by = later["left.longitudinalForce"] + later["right.longitudinalForce"];
        println!(
            "{formulation}: stands at {:.4} m, v = {:.1e} m/s, crept {crept:.1e} m in 2 s; rails hold {held_by:.3} N of {downhill:.3} N",
            later["distance"], later["vx"]
        );
        assert!(crept < 1e-6, "{formulation}: it creeps {crept} m");
        assert!(later["vx"].abs() < 1e-6 && (held_by / downhill - 1.0).abs() < 1e-3);
        // Released it rolls back and reverses.
        simulation.set_input(input_index(0, DRIVE_TORQUE), 0.0, 0.0, 0.0);
        simulation.advance(10.0).unwrap();
        let rolling = read(&mut simulation, &outputs);
        let radius = rolling["vx"] / rolling["pitchRate"];
        let expected = -9.81 * grade.sin() / (1.0 + 168.0 / ((1568.0 + LOAD / 9.81) * radius * radius)) * 2.0;
        println!("{formulation}: after 2 s of rolling back v = {:.5} m/s, rolling body {expected:.5} m/s", rolling["vx"]);
        assert!((rolling["vx"] / expected - 1.0).abs() < 5e-3);
    }
}

#[test]
fn hard_too_slow_without_the_model_is_said() {
    let scene = straight(&[FREE, "vehicle.speed=1"]);
    let mut simulation = start(&scene);
    simulation.set_input(input_index(0, LONGITUDINAL_FORCE), -20_000.0, 0.0, 0.0);
    let error = simulation.advance(5.0).unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("[contact.transient]"), "{error}");
}

#[test]
fn prop_slow_rolling_starts_in_the_same_equilibrium_at_any_speed() {
    let initial = |speed: &str| {
        let scene = straight(&[FREE, TRANSIENT, &format!("vehicle.speed={speed}")]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let first = read(&mut simulation, &outputs);
        simulation.advance(0.05).unwrap();
        let later = read(&mut simulation, &outputs);
        let moved = [(later["z"] - first["z"]).abs(), (later["vx"] - first["vx"]).abs()];
        println!("{speed} m/s: after 50 ms z has moved by {:.1e} m, the speed changed by {:.1e} m/s", moved[0], moved[1]);
        // Rolling costs a little: the patches spin.
        assert!(moved[0] < 1e-7 && moved[1] < 1e-4, "{speed} {moved:?}");
        (first["z"], first["pitchRate"])
    };
    let (height, turn) = initial("1");
    for (speed, factor) in [("0.2", 0.2), ("0.02", 0.02), ("1e-6", 1e-6), ("-0.02", -0.02), ("0", 0.0)] {
        let (z, pitch_rate) = initial(speed);
        println!("{speed} m/s: z differs by {:.1e} m, pitch rate {pitch_rate:.6e} rad/s", z - height);
        assert!((z - height).abs() < 1e-7 && (pitch_rate - factor * turn).abs() <= 1e-5 * factor.abs() * turn);
    }
}

#[test]
fn hard_starts_from_rest() {
    let scene = straight(&[FREE, TRANSIENT, "vehicle.speed=0"]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    simulation.advance(0.5).unwrap();
    let rest = read(&mut simulation, &outputs);
    println!("at rest after 0.5 s: v {:.1e} m/s, y {:.1e} m", rest["vx"], rest["y"]);
    assert!(rest["vx"].abs() < 1e-6 && rest["y"].abs() < 1e-6);
    simulation.set_input(input_index(0, DRIVE_TORQUE), 1500.0, 0.0, 0.0);
    simulation.advance(2.5).unwrap();
    let going = read(&mut simulation, &outputs);
    let radius = going["vx"] / going["pitchRate"];
    let expected = 2.0 * 1500.0 / radius / (1568.0 + LOAD / 9.81 + 168.0 / (radius * radius));
    println!("after 2 s of 1500 N m: {:.4} m/s, rolling body {expected:.4} m/s", going["vx"]);
    assert!((going["vx"] / expected - 1.0).abs() < 0.01);
}

/// Polach's law on wet rails nears its bound slowly: the deflection of a sliding wheel was bounded where the law is at 0.84 of it.
#[test]
fn hard_a_spinning_wheel_on_a_wet_rail_has_all_of_its_friction_at_low_speed() {
    let wet = "contact.creep={ law=\"polach\", surface=\"wet\", friction_ratio=1.0 }";
    let scene = straight(&[TRANSIENT, "vehicle.speed=0.5", "contact.friction=0.3", wet, "solver.integrator=auto", "solver.tolerance=1e-5"]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    simulation.set_input(input_index(0, DRIVE_TORQUE), 20e3, 0.0, 0.0);
    simulation.advance(1.0).unwrap();
    let found = read(&mut simulation, &outputs);
    for side in ["left", "right"] {
        let used = found[&format!("{side}.longitudinalForce")].abs() / (0.3 * found[&format!("{side}.normalForce")]);
        println!("{side}: {used:.4} of mu N at {:.1} rad/s", found["pitchRate"]);
        assert!(used > 0.99 && used < 1.0001 && found["pitchRate"] > 10.0, "{used}");
    }
}

/// An axle whose wheels spin rings against next to no damping; steps of milliseconds took its swing away within some tenths of a second.
#[test]
fn hard_the_axle_of_spinning_wheels_rings_as_long_as_it_does() {
    let swings = |solver: &str| {
        let axle =
            "vehicle.force=[{ name=\"axle\", kind=\"flexible_axle\", body=\"wheelset\", stiffness=6e6, damping=100, left_share=0.45 }]";
        let dry = "contact.creep={ law=\"polach\", surface=\"dry\" }";
        let scene = straight(&[FREE, "vehicle.speed=10", axle, dry, "contact.friction=0.55", solver]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        simulation.advance(0.1).unwrap();
        simulation.set_input(input_index(0, DRIVE_TORQUE), 36e3, 0.0, 0.0);
        let mut torque = |from: u32| {
            let rows = (0..100).map(|k| {
                simulation.advance(1e-3 * f64::from(from + k)).unwrap();
                read(&mut simulation, &outputs)["axle.torque"]
            });
            let (low, high) = rows.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), now| (low.min(now), high.max(now)));
            high - low
        };
        [300, 600, 900].map(&mut torque)
    };
    let default = swings("solver={ integrator=\"auto\", tolerance=1e-5 }");
    let exact = swings("solver={ integrator=\"dormand_prince\", tolerance=1e-9, load_tolerance=1e-5 }");
    println!("{default:.1?} N m, {exact:.1?} N m");
    for (found, expected) in default.iter().zip(exact) {
        assert!(expected > 50.0 && (found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    }
}

/// A wheelset that is pushed till it slides and let go: its inertia rings on the patches' stiffness (330 Hz). Where errors of the deflection counted as ones of a place, creep forces after it had stuck were
/// off by 20 kN of 52 kN of load, with the wrong sign.
#[test]
fn hard_forces_of_a_wheel_that_slides_and_sticks_are_right() {
    for (speed, law) in [(0.925, "polach"), (0.3, "fastsim"), (0.597, "shen_hedrick_elkins")] {
        let run = |solver: &str| -> Vec<f64> {
            let (speed, law) = (format!("vehicle.speed={speed}"), format!("contact.creep={{ law=\"{law}\" }}"));
            let scene = straight(&[TRANSIENT, FREE, &speed, &law, "contact.friction=0.3", solver]);
            let mut simulation = start(&scene);
            let outputs = table(&simulation, &scene);
            simulation.advance(0.1).unwrap();
            let push = |simulation: &mut Simulation, part: f64| {
                for (input, value) in [(LONGITUDINAL_FORCE, 56e3), (DRIVE_TORQUE, -26e3)] {
                    simulation.set_input(input_index(0, input), part * value, 0.0, 0.0);
                }
            };
            push(&mut simulation, 1.0);
            let mut rows = Vec::new();
            for k in 1..=1000 {
                simulation.advance(0.1 + 1e-4 * f64::from(k)).unwrap();
                if k == 207 {
                    push(&mut simulation, 0.0);
                }
                rows.push(read(&mut simulation, &outputs)["left.longitudinalForce"]);
            }
            rows
        };
        let default = run("solver={ integrator=\"auto\", tolerance=1e-5 }");
        let exact = run("solver={ integrator=\"dormand_prince\", tolerance=1e-9, load_tolerance=1e-5 }");
        let largest = exact.iter().map(|force| force.abs()).fold(0.0, f64::max);
        let error = default.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{law}: {error:.0} N of up to {largest:.0} N");
        assert!(largest > 12e3 && error < 0.04 * 0.5 * LOAD, "{error}");
    }
}

/// A locked wheel slips by all of its speed at any speed: creepage 1, and the work of friction per way is the force. Below the transient speed both were those of the deflection, a thousandth.
#[test]
fn hard_a_locked_wheel_wears_at_any_speed() {
    let scene =
        straight(&[TRANSIENT, "vehicle.speed=0.8", "contact.friction=0.2", "interface.outputs=[\"motion\",\"wheels\",\"contacts\"]"]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    // Slowed down against the friction of both wheels, and caught when it stands.
    simulation.set_input(input_index(0, DRIVE_TORQUE), -20e3, 0.0, 0.0);
    let mut time = 0.0;
    let found = loop {
        time += 1e-4;
        simulation.advance(time).unwrap();
        let found = read(&mut simulation, &outputs);
        assert!(time < 1.0, "{found:?}");
        if found["pitchRate"] < 0.0 {
            break found;
        }
    };
    let (creepage, force) = (found["left.contact[1].longitudinalCreepage"], found["left.longitudinalForce"]);
    println!(
        "creepage {creepage:.4}, wear number {:.1} N, friction work {:.1} N, force {force:.1} N",
        found["left.wearNumber"], found["left.frictionWork"]
    );
    assert!((creepage - 1.0).abs() < 0.05 && force.abs() > 5e3);
    assert!((found["left.wearNumber"] / force.abs() - 1.0).abs() < 0.05 && (found["left.frictionWork"] / force.abs() - 1.0).abs() < 0.05);
}

/// Deflections of hardly loaded patches are no positions: the first step was refused for being "off by 1.4e-2 m or rad", where the wheelset moves by 1e-7 m.
#[test]
fn hard_fixed_steps_do_not_take_deflections_for_positions() {
    let run = |solver: &str| {
        let scene = straight(&[
            TRANSIENT,
            "vehicle.speed=1",
            "vehicle.wheelset.profile={ kind=\"s1002\", radius=0.46 }",
            "track.rail={ kind=\"60e1\" }",
            "track.node=[{ distance=0, radius=\"150 m\", superelevation=\"-60 mm\" }]",
            "contact.formulation=ECCF",
            "contact.on_lift=elastic",
            solver,
        ]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        simulation.advance(0.3).unwrap_or_else(|error| panic!("{solver}: {error}"));
        read(&mut simulation, &outputs)
    };
    let exact = run("solver={ integrator=\"rosenbrock\", tolerance=1e-8 }");
    for (method, step) in [("real_time", "1 ms"), ("generalised_alpha", "0.5 ms"), ("zhai", "0.1 ms")] {
        let found = run(&format!("solver={{ integrator=\"{method}\", step=\"{step}\" }}"));
        let apart = (found["y"] - exact["y"]).abs();
        println!("{method}: y within {:.1e} m, Q {:.1} and {:.1} N", apart, found["right.verticalForce"], exact["right.verticalForce"]);
        assert!(apart < 2e-5 && (found["right.verticalForce"] / exact["right.verticalForce"] - 1.0).abs() < 0.01, "{method}");
    }
}
