//! Hard cases, each with the number that must hold.

mod common;

use common::{column, read, run, scene, start, straight, table};
use wheelrail::formulation::{DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, RIGHT_FRICTION, VERTICAL_FORCE};
use wheelrail::sim::{Simulation, SimulationError};

#[test]
fn hard_lift_off_and_landing_never_pull_and_lose_energy_only_by_damping() {
    // 20 mm above equilibrium: free fall, impact, several bounces.
    let recording = run(&straight(&["vehicle.initial.z=0.4769"]), 0.8, 1e-4);
    for side in ["left", "right"] {
        let force = column(&recording, &format!("{side}.normalForce"));
        assert!(force.iter().all(|n| *n >= 0.0));
        assert!(force.iter().take(100).all(|n| *n == 0.0), "it must fly first");
        assert!(force.iter().copied().fold(0.0, f64::max) > 5e5, "the impact must be felt");
        assert!((force[force.len() - 1] / 56680.6 - 1.0).abs() < 0.02, "it must come to rest: {}", force[force.len() - 1]);
    }
    // Fall from 20 mm under weight and load: v^2 = 2 (g + W/m) h at the first touch.
    let (z, vz) = (column(&recording, "z"), column(&recording, "vz"));
    let touch = z.iter().position(|z| *z < 0.457).unwrap() - 1;
    let expected = (2.0 * (9.81 + 98_000.0 / 1568.0) * (0.4769 - z[touch])).sqrt();
    assert!((vz[touch] + expected).abs() < 1e-3, "{} {expected}", vz[touch]);
}

#[test]
fn hard_wheel_unloading_by_lateral_start_keeps_one_sided_contact() {
    // 3 mm aside without roll lifts the right wheel; it must land and both must carry half the load later.
    let recording = run(&straight(&["vehicle.initial.y=0.003"]), 1.0, 1e-3);
    let right = column(&recording, "right.normalForce");
    assert_eq!(right[0], 0.0);
    assert!(right.iter().all(|n| *n >= 0.0));
    assert!((right[right.len() - 1] / 56680.6 - 1.0).abs() < 0.05);
}

#[test]
fn hard_slippery_rail_spins_up_within_the_friction_bound() {
    let scene = straight(&[]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    simulation.set_input(LEFT_FRICTION, 0.02, 0.0, 0.0);
    simulation.set_input(RIGHT_FRICTION, 0.02, 0.0, 0.0);
    simulation.set_input(DRIVE_TORQUE, 5000.0, 0.0, 0.0);
    simulation.advance(1.0).unwrap();
    let found = read(&mut simulation, &outputs);
    assert!(found["pitchRate"] > 90.0, "it must spin up: {}", found["pitchRate"]);
    for side in ["left", "right"] {
        let bound = 0.5 * 0.02 * found[&format!("{side}.normalForce")];
        let force = found[&format!("{side}.contact[1].creepForceX")].hypot(found[&format!("{side}.contact[1].creepForceY")]);
        assert!(force <= bound * (1.0 + 1e-12) && force > 0.99 * bound, "{force} {bound}");
    }
    // Euler: I q' = T - 2 mu N r0, within the spin moments.
    let expected = (5000.0 - 2.0 * 0.01 * 56680.0 * 0.457) / 168.0;
    assert!((found["pitchAcceleration"] / expected - 1.0).abs() < 0.01, "{} {expected}", found["pitchAcceleration"]);
}

#[test]
fn hard_no_friction_gives_no_creep_force_and_no_nan() {
    let recording = run(&scene(&["contact.friction=0"]), 1.0, 0.01);
    assert!(column(&recording, "left.contact[1].creepForceY").iter().all(|f| *f == 0.0));
    assert!(recording.rows.iter().flatten().all(|value| value.is_finite()));
}

#[test]
fn hard_a_lateral_force_beyond_reason_ends_in_an_error_and_keeps_what_was_computed() {
    let scene = straight(&[]);
    let mut simulation = start(&scene);
    simulation.advance(0.1).unwrap();
    simulation.set_input(LATERAL_FORCE, 1e7, 0.0, 0.0);
    let error = simulation.advance(5.0).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("wheelset") && text.contains("t = 0."), "{text}");
    let reached = simulation.time();
    assert!((0.1..0.5).contains(&reached), "{reached}");
    let outputs = table(&simulation, &scene);
    assert!(read(&mut simulation, &outputs).values().all(|value| value.is_finite()));
}

#[test]
fn hard_lifted_out_of_the_track_flies_on() {
    let scene = straight(&[]);
    let mut simulation = start(&scene);
    simulation.set_input(VERTICAL_FORCE, 2e5, 0.0, 0.0);
    simulation.advance(0.5).unwrap();
    let outputs = table(&simulation, &scene);
    let found = read(&mut simulation, &outputs);
    let rise = (2e5 - 98_000.0 - 1568.0 * 9.81) / 1568.0;
    assert!((found["az"] / rise - 1.0).abs() < 1e-9 && found["left.normalForce"] == 0.0);
    assert!(found["left.contact[1].penetration"] < -1.0, "the gap is reported: {}", found["left.contact[1].penetration"]);
}

#[test]
fn hard_scenes_without_support_are_refused_with_the_reason() {
    let error = Simulation::new(&scene(&["vehicle.wheelset.vertical_load=-200000"]), 0.0).unwrap_err();
    assert!(matches!(error, SimulationError::Equilibrium(_)));
    assert!(error.to_string().contains("must be positive"), "{error}");
    let narrow = scene(&["track.rail_distance=1.0"]);
    let error = Simulation::new(&narrow, 0.0).unwrap_err();
    assert!(error.to_string().contains("wheel coordinate") || error.to_string().contains("equilibrium"), "{error}");
}

#[test]
fn hard_steps_end_at_the_disturbance() {
    // The right wheel's contact meets the ends of the disturbance (20 m, 30 m) exactly at a step's end.
    let scene = scene(&[]);
    let mut simulation = start(&scene);
    simulation.advance(0.4999).unwrap();
    simulation.advance(0.5 + 1e-9).unwrap();
    assert!((simulation.state().integration.step_begin() - 0.5).abs() < 1e-9 || (simulation.state().integration.t - 0.5).abs() < 1e-9);
}

#[test]
fn hard_the_loosest_tolerance_still_gives_sane_wheel_loads() {
    // Height is held 100 times tighter than the tolerance: 1e-7 m of a penetration of 7e-5 m at the loosest.
    for (tolerance, allowed) in [("1e-5", 0.02), ("1e-6", 0.002), ("1e-8", 2e-5)] {
        let recording = run(&straight(&[&format!("solver.tolerance={tolerance}")]), 2.0, 1e-3);
        let load = (1568.0 * 9.81 + 98_000.0) / 2.0;
        let worst = column(&recording, "left.verticalForce").iter().map(|q| (q / load - 1.0).abs()).fold(0.0, f64::max);
        println!("tolerance {tolerance}: wheel load off by {:.2} %", 100.0 * worst);
        assert!(worst < allowed, "{tolerance}: {worst}");
    }
    let error = wheelrail::scene::load::open("suspended_wheelset", &["solver.tolerance=1e-4".into()]).err().unwrap();
    assert!(error.to_string().contains("expected 1e-15 to 1e-5"), "{error}");
}

#[test]
fn regress_work_of_the_default_scene() {
    let scene = scene(&[]);
    let mut simulation = start(&scene);
    simulation.advance(5.0).unwrap();
    let s = simulation.statistics();
    let per_search = simulation.state().work.search_iterations as f64 / (2 * s.evaluations) as f64;
    println!("{s:?}, {per_search:.3} Newton iterations per contact search");
    assert!(per_search < 1.01, "warm starts must serve: {per_search}");
    // Numbers of this machine's libm; another one may differ in the last bit and so in a few steps.
    let near = |found: u64, pinned: u64| found.abs_diff(pinned) * 50 <= pinned;
    assert!(near(s.steps, 2646) && near(s.evaluations, 16_066) && s.rejected < 60, "{s:?}");
}
