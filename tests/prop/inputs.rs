//! Inputs that go on as they were told restart nothing.

use crate::common;
use wheelrail::formulation::{DRIVE_TORQUE, LATERAL_FORCE};
use wheelrail::sim::Simulation;

const STEP: f64 = 1e-3;
const STEPS: u32 = 200;

/// Changes of inputs that the integration has met: restarts, and those that a step in hand has taken up.
fn turns(simulation: &Simulation) -> u64 {
    simulation.statistics().restarts + simulation.statistics().taken_up
}

/// Runs in steps of a millisecond under a force on a parabola; `told` hands it over at the begin of each step.
fn run(integrator: &str, told: impl Fn(&mut Simulation, u32, [f64; 3])) -> (Vec<u64>, u64) {
    let scene = common::scene(&[&format!("solver.integrator={integrator}")]);
    let mut simulation = common::start(&scene);
    let outputs = common::table(&simulation, &scene);
    let mut bits = Vec::new();
    for i in 0..STEPS {
        let t = STEP * f64::from(i);
        told(&mut simulation, i, [400.0 + t * (3e3 - 5e3 * t), 3e3 - 1e4 * t, -1e4]);
        simulation.advance(STEP * f64::from(i + 1)).unwrap();
        let snapshot = simulation.snapshot().unwrap();
        bits.extend(outputs.iter().map(|output| output.value(snapshot).to_bits()));
    }
    (bits, turns(&simulation))
}

#[test]
fn equiv_an_input_that_goes_on_is_as_if_it_had_been_set_once() {
    for integrator in ["rosenbrock", "dormand_prince"] {
        let once = run(integrator, |simulation, i, [value, first, second]| {
            if i == 0 {
                simulation.set_input(LATERAL_FORCE, value, first, second);
            }
        });
        // As a master does it: the value, which ends the derivatives, then these again.
        let again = run(integrator, |simulation, _, [value, first, second]| {
            simulation.set_input(LATERAL_FORCE, value, 0.0, 0.0);
            simulation.set_input(LATERAL_FORCE, value, first, second);
        });
        assert_eq!(once.1, again.1, "{integrator}: restarts");
        assert!(once.0 == again.0, "{integrator}: bits");
        // Another input that turns breaks the step, and both are right.
        let turned = run(integrator, |simulation, i, [value, first, second]| {
            simulation.set_input(LATERAL_FORCE, value, first, second);
            simulation.set_input(DRIVE_TORQUE, if i == 50 { 10.0 } else { simulation.input(DRIVE_TORQUE)[0] }, 0.0, 0.0);
        });
        assert_eq!(turned.1, once.1 + 1, "{integrator}");
        let held = run(integrator, |simulation, _, [value, ..]| simulation.set_input(LATERAL_FORCE, value, 0.0, 0.0));
        assert!(held.1 >= u64::from(STEPS) - 1, "{integrator}: held values turn at each step: {}", held.1);
    }
}

/// More than rounding is a change, for values and for derivatives; a constant is the same or another one.
#[test]
fn prop_what_differs_by_more_than_rounding_restarts() {
    let scene = common::scene(&[]);
    let restarts = |tell: &dyn Fn(&mut Simulation, f64)| {
        let mut simulation = common::start(&scene);
        simulation.set_input(LATERAL_FORCE, 100.0, 2e3, 0.0);
        simulation.advance(0.1).unwrap();
        let before = turns(&simulation);
        let [value, ..] = simulation.input(LATERAL_FORCE);
        tell(&mut simulation, value);
        simulation.advance(0.2).unwrap();
        turns(&simulation) - before
    };
    assert_eq!(restarts(&|simulation, value| simulation.set_input(LATERAL_FORCE, value * (1.0 + 2e-16), 2e3, 0.0)), 0);
    assert_eq!(restarts(&|simulation, value| simulation.set_input(LATERAL_FORCE, value * (1.0 + 1e-13), 2e3, 0.0)), 1);
    assert_eq!(restarts(&|simulation, value| simulation.set_input(LATERAL_FORCE, value, 2e3 * (1.0 + 1e-13), 0.0)), 1);
    assert_eq!(restarts(&|simulation, value| simulation.set_input(LATERAL_FORCE, value, 2e3, 1e-9)), 1);
    assert_eq!(restarts(&|simulation, value| simulation.set_input(LATERAL_FORCE, value, 0.0, 0.0)), 1);
    // Set and set back before time goes on.
    assert_eq!(
        restarts(&|simulation, value| {
            simulation.set_input(LATERAL_FORCE, 5e3, 0.0, 0.0);
            simulation.set_input(LATERAL_FORCE, value, 2e3, 0.0);
        }),
        0
    );
    assert_eq!(restarts(&|simulation, _| simulation.set_input(DRIVE_TORQUE, f64::MIN_POSITIVE, 0.0, 0.0)), 1);
}

/// A state that was saved between setting and going on goes on to the same bits.
#[test]
fn prop_a_state_saved_with_an_input_just_set_goes_on_the_same() {
    let scene = common::scene(&["solver.integrator=rosenbrock"]);
    let mut simulation = common::start(&scene);
    simulation.set_input(LATERAL_FORCE, 100.0, 2e3, 0.0);
    simulation.advance(0.55).unwrap();
    for change in [[simulation.input(LATERAL_FORCE)[0], 2e3], [7e3, 0.0]] {
        simulation.set_input(LATERAL_FORCE, change[0], change[1], 0.0);
        let saved = simulation.state().clone();
        simulation.advance(0.7).unwrap();
        let first = simulation.snapshot().unwrap().dy.clone();
        let mut other = common::start(&scene);
        assert!(other.restore(&saved));
        other.advance(0.7).unwrap();
        assert_eq!(first, other.snapshot().unwrap().dy);
        assert!(simulation.restore(&saved));
    }
}

/// A master tries a step, takes the state back and goes another way: nothing is told of the course that it gave up.
#[test]
fn prop_notes_of_an_abandoned_course_are_forgotten() {
    let scene = wheelrail::scene::load::open("wheelset_s1002", &[]).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    simulation.advance(0.1).unwrap();
    let told = simulation.notes();
    let state = simulation.state().clone();
    simulation.set_input(LATERAL_FORCE, 3e5, 0.0, 0.0);
    let _ = simulation.advance(0.2);
    assert!(simulation.notes() != told, "the wheelset was meant to be thrown off");
    assert!(simulation.restore(&state));
    assert_eq!(simulation.notes(), told);
    simulation.advance(0.2).unwrap();
    let mut other = Simulation::new(&scene, 0.0).unwrap();
    other.advance(0.2).unwrap();
    assert_eq!(simulation.notes(), other.notes());
}
