//! Order, limit of stability, self-starting.

use super::super::test_systems::*;
use super::*;

#[test]
fn order_two_and_one_evaluation_per_step() {
    let at = |h| errors(&Zhai { step: h }, nonlinear(0.0), nonlinear_solution, h, 2.0);
    let (ends, inside) = orders(at, 0.1);
    println!("Zhai: order {ends:.2} at the ends, {inside:.2} inside; at 0.1: {:.1e}", at(0.1).0);
    assert!((ends - 2.0).abs() < 0.2 && (inside - 2.0).abs() < 0.25, "{ends} {inside}");
    for event_value in [None, Some(1.0)] {
        let method = Zhai { step: 0.01 };
        let mut state = method.start(0.0, &nonlinear_solution(0.0));
        let mut system = Watched { event_value, ..nonlinear(0.0) };
        method.advance(&mut system, &mut state, &mut Scratch::new(3, usize::from(event_value.is_some())), 1.0).unwrap();
        // One more: the end of the last step has been looked at.
        assert_eq!(state.statistics.evaluations, state.statistics.steps + 1);
    }
}

#[test]
fn analytic_vibrations_are_stable_and_undamped_up_to_two() {
    let vibration = Watched::new(|_, y, dy| (dy[0], dy[1]) = (y[1], -y[0]), |_, _| unreachable!("explicit"), 1);
    let largest = |step: f64, steps: usize| {
        let method = Zhai { step };
        let mut state = method.start(0.0, &[1.0, 0.0]);
        let mut scratch = Scratch::new(2, 0);
        let mut largest: f64 = 0.0;
        for n in 0..steps {
            method.step(&mut vibration.clone(), &mut state, &mut scratch).unwrap();
            largest = if 2 * n > steps { largest.max(state.y[0].abs()) } else { largest };
        }
        largest
    };
    let (slow, near, beyond) = (largest(0.1, 2000), largest(1.98, 2000), largest(2.02, 2000));
    println!("amplitude 1 after 2000 steps: w h = 0.1: {slow:.4}, 1.98: {near:.3e}, 2.02: {beyond:.1e}");
    assert!((slow - 1.0).abs() < 0.02 && near < 100.0 && beyond > 1e6);
}

#[test]
fn analytic_constant_acceleration_is_exact_and_starts_itself_again() {
    let fall = || Watched { breaks: 0.53, ..Watched::new(|_, y, dy| (dy[0], dy[1]) = (y[1], -10.0), |_, _| unreachable!(), 1) };
    let method = Zhai { step: 0.1 };
    let (mut state, mut system, mut scratch) = (method.start(0.0, &[0.0, 3.0]), fall(), Scratch::new(2, 0));
    let mut ends = vec![];
    while state.t < 1.0 {
        method.step(&mut system, &mut state, &mut scratch).unwrap();
        ends.push(state.t);
        assert_eq!(state.record_known, state.t != 0.53, "{}", state.t);
        assert!((state.y[0] - (3.0 * state.t - 5.0 * state.t * state.t)).abs() < 1e-14);
    }
    assert!((ends[5] - 0.53).abs() < 1e-15 && (ends[6] - 0.63).abs() < 1e-15, "{ends:?}");
    state.restart_at(0.98, |_, _| ());
    assert!(!state.record_known && state.grid_start == 0.98);
}

#[test]
fn prop_restored_states_go_on_in_the_same_bits() {
    assert_restores_bits(&Zhai { step: 0.007 }, None);
    assert_restores_bits(&Zhai { step: 0.007 }, Some(1.0));
}
