//! Order with any Jacobian, stability, and the same work in each step.

use super::super::test_systems::*;
use super::*;

#[test]
fn order_two_with_any_jacobian() {
    for share in [1.0, 0.5, 0.0, -0.3] {
        let at = |h| errors(&RealTime { step: h }, nonlinear(share), nonlinear_solution, h, 2.0);
        let (ends, inside) = orders(at, 0.05);
        println!("ROS2, share {share}: order {ends:.2}, inside {inside:.2}; at 0.05: {:.1e} and {:.1e}", at(0.05).0, at(0.05).1);
        assert!((ends - 2.0).abs() < 0.2 && (inside - 2.0).abs() < 0.25, "{share}: {ends} {inside}");
    }
}

#[test]
fn analytic_stability_function() {
    // y' = z y with h = 1 gives R(z); the coefficient of z^3 gives the error constant.
    let after = |z: f64| {
        thread_local! { static Z: std::cell::Cell<f64> = const { std::cell::Cell::new(0.0) } }
        Z.set(z);
        let mut system = Watched::new(|_, y, dy| dy[0] = Z.get() * y[0], |_, _| nalgebra::DMatrix::from_element(1, 1, Z.get()), 0);
        let method = RealTime { step: 1.0 };
        let mut state = method.start(0.0, &[1.0]);
        method.step(&mut system, &mut state, &mut Scratch::new(1, 0)).unwrap();
        state.y[0]
    };
    for z in [-1e-2f64, -1.0, -10.0, -1e3, -1e9] {
        let expected = (1.0 + (1.0 - 2.0 * GAMMA) * z) / (1.0 - GAMMA * z).powi(2);
        assert!((after(z) - expected).abs() < 1e-13 && expected.abs() < 1.0, "{z}");
    }
    let z = -1e-3f64;
    let constant = (z.exp() - after(z)) / z.powi(3);
    assert!((constant - (1.0 / 6.0 - 3.0 * GAMMA.powi(2) + 2.0 * GAMMA.powi(3))).abs() < 1e-4, "{constant}");
    assert!(after(-1e9).abs() < 1e-8);
}

#[test]
fn hard_stiff_systems_at_steps_of_thousands_of_their_time_constants() {
    let (ends, inside) = errors(&RealTime { step: 0.05 }, kaps(), kaps_solution, 0.05, 1.0);
    println!("ROS2 on Kaps' problem: {ends:.1e} and {inside:.1e} inside at h = 0.05");
    assert!(ends < 1e-2 && inside < 1e-2);
    let method = RealTime { step: 0.01 };
    let (mut state, mut scratch) = (method.start(0.0, &[1e-3, 0.0]), Scratch::new(2, 0));
    method.step(&mut stiff_spring(), &mut state, &mut scratch).unwrap();
    assert!(state.y[0].abs() < 1e-6, "{:?}", state.y);
    let mut y = [0.0; 2];
    for k in 1..10 {
        state.interpolate_beside(1e-3 * f64::from(k), &mut y, |_, _| ());
        assert!(y[0].abs() < 2e-3, "the output does not swing: {y:?}");
    }
}

#[test]
fn regress_work_per_communication_step_is_always_the_same() {
    // Steps of a tenth of the communication step, which an input restarts each time.
    let method = RealTime { step: 1e-4 };
    let (mut state, mut system, mut scratch) = (method.start(0.0, &nonlinear_solution(0.0)), nonlinear(1.0), Scratch::new(3, 0));
    let mut before = state.statistics;
    for i in 1..=500 {
        let target = 1e-3 * f64::from(i);
        method.advance(&mut system, &mut state, &mut scratch, target).unwrap();
        let now = state.statistics;
        assert_eq!((now.steps - before.steps, now.evaluations - before.evaluations), (10, 21), "{i}");
        assert_eq!((now.linearisations - before.linearisations, now.factorisations - before.factorisations), (10, 10));
        before = now;
        state.restart_at(target, |_, _| ());
    }
    assert!((state.y[0] - 0.5f64.sin()).abs() < 1e-8);
}

#[test]
fn prop_restored_states_go_on_in_the_same_bits() {
    assert_restores_bits(&RealTime { step: 0.007 }, None);
    assert_restores_bits(&RealTime { step: 0.007 }, Some(1.0));
}
