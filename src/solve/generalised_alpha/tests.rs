//! Order, damping at infinity, Newton's iterations.

use super::super::test_systems::*;
use super::*;

fn method(step: f64, rho_infinity: f64) -> GeneralisedAlpha {
    GeneralisedAlpha { step, rho_infinity }
}

#[test]
fn order_two_for_any_damping_and_any_jacobian() {
    for (rho, share) in [(0.0, 1.0), (0.6, 1.0), (1.0, 1.0), (0.6, 0.5), (0.6, 0.0)] {
        let at = |h| errors(&method(h, rho), nonlinear(share), nonlinear_solution, h, 2.0);
        let (ends, inside) = orders(at, 0.05);
        println!("rho {rho}, share {share}: order {ends:.2}, inside {inside:.2}; at 0.05: {:.1e} and {:.1e}", at(0.05).0, at(0.05).1);
        assert!((ends - 2.0).abs() < 0.2 && (inside - 2.0).abs() < 0.25, "{rho} {share}: {ends} {inside}");
    }
}

#[test]
fn analytic_what_is_too_fast_falls_by_rho_in_each_step() {
    for rho in [0.3, 0.6, 0.9] {
        let method = method(0.01, rho);
        let (mut state, mut scratch, mut system) = (method.start(0.0, &[1e-3, 0.0]), Scratch::new(2, 0), stiff_spring());
        let mut positions = vec![];
        for _ in 0..40 {
            method.step(&mut system, &mut state, &mut scratch).unwrap();
            positions.push(state.y[0]);
        }
        // Two equal roots at infinity: n rho^n; the factor of twenty steps apart is rho^20 times about 2.
        let fall = (positions[39] / positions[19]).abs().powf(0.05);
        println!("rho {rho}: falls by {fall:.3} per step");
        assert!((fall - rho * 2f64.powf(0.05)).abs() < 0.02, "{rho}: {fall}");
    }
}

#[test]
fn analytic_error_of_a_slow_vibration() {
    // q'' = -q over one period: the phase is behind by C h^2 per radian, with the C of the module's head.
    for rho in [1.0f64, 0.6, 0.0] {
        let expected = 1.0 / 12.0 + 0.25 * ((1.0 - rho) / (1.0 + rho)).powi(2);
        let steps = 200;
        let h = std::f64::consts::TAU / f64::from(steps);
        let method = method(h, rho);
        let mut system = Watched::new(
            |_, y, dy| (dy[0], dy[1]) = (y[1], -y[0]),
            |_, _| nalgebra::DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -1.0, 0.0]),
            1,
        );
        let (mut state, mut scratch) = (method.start(0.0, &[0.0, 1.0]), Scratch::new(2, 0));
        for _ in 0..steps {
            method.step(&mut system, &mut state, &mut scratch).unwrap();
        }
        let constant = -state.y[0] / (std::f64::consts::TAU * h * h);
        println!("rho {rho}: C = {constant:.4}");
        assert!((constant / expected - 1.0).abs() < 0.03, "{rho}: {constant}");
    }
}

#[test]
fn hard_kaps_stiff_problem_keeps_order_two() {
    let at = |h| errors(&method(h, 0.6), kaps(), kaps_solution, h, 1.0);
    let (ends, inside) = orders(at, 0.1);
    println!("generalised-alpha on Kaps' problem: order {ends:.2}, inside {inside:.2}, {:.1e} and {:.1e} at h = 0.1", at(0.1).0, at(0.1).1);
    assert!((ends - 2.0).abs() < 0.3 && at(0.1).0 < 1e-2);
}

#[test]
fn regress_iterations_and_failure() {
    let method = method(0.01, 0.6);
    let (mut state, mut scratch) = (method.start(0.0, &nonlinear_solution(0.0)), Scratch::new(3, 0));
    method.advance(&mut nonlinear(1.0), &mut state, &mut scratch, 1.0).unwrap();
    let work = state.statistics;
    println!("{work:?}");
    assert!(work.iterations <= 3 * work.steps && work.linearisations == work.steps, "{work:?}");
    // Without a Jacobian a stiff system's equations aren't solved, and the state stays where it was.
    let mut blind = Watched { share: 0.0, ..kaps() };
    let (mut state, mut scratch) = (method.start(0.0, &[1.0, 1.1]), Scratch::new(2, 0));
    let error = method.advance(&mut blind, &mut state, &mut scratch, 1.0).unwrap_err();
    assert!(matches!(error, SolveError::NotConverged { time: 0.0, .. } | SolveError::NotFinite { time: 0.0, .. }), "{error}");
    assert!(state.t == 0.0 && state.y == [1.0, 1.1] && state.statistics.rejected > 2, "{state:?}");
}

#[test]
fn prop_restored_states_go_on_in_the_same_bits() {
    assert_restores_bits(&method(0.007, 0.6), None);
    assert_restores_bits(&method(0.007, 0.6), Some(1.0));
}

#[test]
fn prop_a_step_that_cannot_be_solved_is_divided_and_ends_on_the_grid() {
    // Picard's iteration (no Jacobian) solves y' = -40 (y - cos t) with steps below about 0.03 only.
    let stiff =
        || Watched { share: 0.0, ..Watched::new(|t, y, dy| dy[0] = -40.0 * (y[0] - t.cos()), |_, _| nalgebra::DMatrix::zeros(1, 1), 0) };
    let method = method(0.1, 0.6);
    let (mut state, mut scratch) = (method.start(0.0, &[1.0]), Scratch::new(1, 0));
    method.advance(&mut stiff(), &mut state, &mut scratch, 2.0).unwrap();
    assert!(state.statistics.rejected > 0 && state.statistics.steps > 20, "{:?}", state.statistics);
    assert!((state.t - 2.0).abs() < 1e-12 && state.grid_count == 20, "{} {}", state.t, state.grid_count);
    let exact = (1600.0 * 2f64.cos() + 40.0 * 2f64.sin()) / 1601.0;
    assert!((state.y[0] - exact).abs() < 1e-3, "{} {exact}", state.y[0]);
}
