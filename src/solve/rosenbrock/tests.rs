//! Coefficients, order with any Jacobian, stiff problems.

use super::super::DormandPrince;
use super::super::test_systems::*;
use super::*;
use nalgebra::{Complex, Matrix4, RowVector4, Vector4};

fn free(part: StiffPart) -> Rosenbrock {
    Rosenbrock { tolerance: 1e9, part }
}

fn tables() -> (Matrix4<f64>, Matrix4<f64>) {
    (Matrix4::from_fn(|i, j| ALPHAS[i][j]), Matrix4::from_fn(|i, j| GAMMAS[i][j]))
}

/// Left-hand minus right-hand sides of the conditions of order 1 to 3 for W-methods: each tree once for f' and J alike.
fn conditions(weights: Row) -> [f64; 8] {
    let (alpha, gamma) = tables();
    let b = RowVector4::from(weights);
    let (a, c) = (alpha.column_sum(), gamma.column_sum());
    let of = |vector: Vector4<f64>| (b * vector)[0];
    [
        of(Vector4::repeat(1.0)) - 1.0,
        of(a) - 0.5,
        of(c),
        of(a.component_mul(&a)) - 1.0 / 3.0,
        of(alpha * a) - 1.0 / 6.0,
        of(alpha * c),
        of(gamma * a),
        of(gamma * c),
    ]
}

/// R(z) = 1 + z b (I - z (alpha + gamma))^-1 1.
fn stability(weights: Row, z: Complex<f64>) -> f64 {
    let (alpha, gamma) = tables();
    let matrix = Matrix4::identity() - (alpha + gamma).map(|entry| z * entry);
    let solved = matrix.lu().solve(&Vector4::repeat(Complex::new(1.0, 0.0))).unwrap();
    let sum: Complex<f64> = (0..STAGES).map(|i| solved[i] * weights[i]).sum();
    (Complex::new(1.0, 0.0) + z * sum).norm()
}

#[test]
fn analytic_all_conditions_of_w_methods_hold() {
    let worst = |conditions: &[f64]| conditions.iter().fold(0f64, |worst, value| worst.max(value.abs()));
    assert!(worst(&conditions(WEIGHTS)) < 4e-16, "{:?}", conditions(WEIGHTS));
    let embedded = conditions(EMBEDDED);
    assert!(worst(&embedded[..3]) < 4e-16 && worst(&embedded[3..]) > 0.05, "order 2 and not 3: {embedded:?}");
    // gamma is the root of g^3 - 3 g^2 + 3 g / 2 - 1/6 that makes the method L-stable.
    assert!((GAMMA.powi(3) - 3.0 * GAMMA.powi(2) + 1.5 * GAMMA - 1.0 / 6.0).abs() < 1e-15);
}

#[test]
fn analytic_conditions_of_the_continuous_output() {
    let sum: Row = std::array::from_fn(|i| DENSE.iter().map(|weights| weights[i]).sum());
    assert!(sum.iter().zip(WEIGHTS).all(|(sum, weight)| (sum - weight).abs() < 1e-14), "it ends in the solution: {sum:?}");
    for step in 0..=10 {
        let theta = 0.1 * f64::from(step);
        let weights: Row = std::array::from_fn(|i| theta * (DENSE[0][i] + theta * (DENSE[1][i] + theta * DENSE[2][i])));
        let [one, time, j, square, ff, fj, jf, jj] = conditions(weights);
        // For any J to order 2; to order 3 the sum over f' and J, which is what an exact J makes of the last four.
        assert!((one + 1.0 - theta).abs() < 1e-14 && (time + 0.5 - theta.powi(2) / 2.0).abs() < 1e-14 && j.abs() < 1e-14);
        assert!((square + (1.0 - theta.powi(3)) / 3.0).abs() < 1e-14);
        assert!((ff + fj + jf + jj + (1.0 - theta.powi(3)) / 6.0).abs() < 1e-14);
    }
}

#[test]
fn analytic_the_method_is_stiffly_accurate_and_l_stable() {
    let (alpha, gamma) = tables();
    let last = (alpha + gamma).row(STAGES - 1).into_owned();
    assert!((last - RowVector4::from(WEIGHTS)).amax() < 4e-16);
    let imaginary = |weights| (-30..60).map(|k| stability(weights, Complex::new(0.0, 10f64.powf(0.1 * f64::from(k))))).fold(0.0, f64::max);
    // Bounded on the imaginary axis and at infinity, poles on the right: bounded on the whole left half plane.
    assert!(imaginary(WEIGHTS) <= 1.0 + 1e-13 && imaginary(EMBEDDED) <= 1.0 + 1e-13);
    let far = Complex::new(-1e12, 0.0);
    let (solution, embedded) = (stability(WEIGHTS, far), stability(EMBEDDED, far));
    assert!(solution < 1e-11 && (embedded - 0.4783).abs() < 1e-4, "{solution:e} {embedded}");
}

#[test]
fn order_three_with_any_jacobian_and_output_of_order_three() {
    // The last one is `imex`.
    let (all, contact) = (StiffPart::All, StiffPart::Contact);
    for (share, part) in [(1.0, all), (0.5, all), (0.0, all), (-0.3, all), (1.0, contact)] {
        let at = |h| errors(&free(part), nonlinear(share), nonlinear_solution, h, 2.0);
        let (ends, inside) = orders(at, 0.1);
        println!(
            "share {share} of the Jacobian ({part:?}): order {ends:.2} at the ends, {inside:.2} inside, errors at 0.1: {:.1e} and {:.1e}",
            at(0.1).0,
            at(0.1).1
        );
        assert!((ends - 3.0).abs() < 0.2 && (inside - 3.0).abs() < 0.25, "{share}: {ends} {inside}");
    }
}

#[test]
fn order_output_inside_a_single_step() {
    // From the exact solution: the end of one step is off by h^4, and so is the inside where J is exact.
    for (share, least) in [(1.0, 3.5), (0.0, 2.8)] {
        let at = |h: f64| errors(&free(StiffPart::All), nonlinear(share), nonlinear_solution, h, 0.5 * h);
        let (end, inside) = orders(at, 0.2);
        println!("share {share}: one step: order {end:.2}, inside {inside:.2}");
        assert!(end > 3.7 && inside > least, "{share}: {end} {inside}");
    }
}

#[test]
fn order_the_error_estimate_falls_with_order_three() {
    for share in [1.0, 0.0] {
        let estimate = |h: f64| {
            let (method, mut system) = (free(StiffPart::All), nonlinear(share));
            let mut state = method.start(0.3, &nonlinear_solution(0.3));
            let mut scratch = Scratch::new(3, 0);
            method.prepare(&mut system, &mut state, &mut scratch.frame).unwrap();
            method.attempt(&mut system, &mut state, &mut scratch, h).unwrap().state
        };
        let order = (estimate(0.04) / estimate(0.01)).log2() / 2.0;
        assert!((order - 3.0).abs() < 0.2, "{share}: {order}");
    }
}

#[test]
fn hard_a_decay_a_million_times_faster_than_the_step_is_gone_after_one_step() {
    let method = free(StiffPart::All);
    let (mut system, mut scratch) = (relaxation(), Scratch::new(1, 0));
    let mut state = method.start(0.0, &[2.0]);
    for _ in 0..10 {
        state.next_step = 0.1;
        method.step(&mut system, &mut state, &mut scratch).unwrap();
        let error = (state.y[0] - state.t.cos()).abs();
        println!("{:.1}: {error:.1e}", state.t);
        assert!(error < 1e-4, "{} at {}", state.y[0], state.t);
    }
    let mut spring = stiff_spring();
    let (mut state, mut scratch) = (method.start(0.0, &[1e-3, 0.0]), Scratch::new(2, 0));
    state.next_step = 0.01;
    method.step(&mut spring, &mut state, &mut scratch).unwrap();
    assert!(state.y[0].abs() < 1e-6, "a stiff spring comes to rest: {:?}", state.y);
}

#[test]
fn hard_kaps_stiff_problem_keeps_its_accuracy() {
    let at = |h| errors(&free(StiffPart::All), kaps(), kaps_solution, h, 1.0);
    let (ends, inside) = orders(at, 0.1);
    println!("Kaps, k = 1e8: order {ends:.2}, inside {inside:.2}; error at h = 0.1: {:.1e} and {:.1e}", at(0.1).0, at(0.1).1);
    assert!(at(0.1).0 < 1e-3 && at(0.1).1 < 2e-3 && ends > 2.7 && inside > 2.7, "{ends} {inside}");
}

#[test]
fn hard_van_der_pol_takes_few_steps_and_keeps_the_jacobian_on_rejection() {
    let method = Rosenbrock { tolerance: 1e-2, part: StiffPart::All };
    let mut state = method.start(0.0, &[2.0, 0.0]);
    let mut y = [0.0; 2];
    method.advance(&mut van_der_pol(), &mut state, &mut Scratch::new(2, 0), 2.0).unwrap();
    state.interpolate_beside(2.0, &mut y, |_, _| ());
    let work = state.statistics;
    println!("van der Pol: {y:?} {work:?}");
    // Hairer, Wanner, Solving Ordinary Differential Equations II, section IV.10: y1(2) = 1.706167732170469.
    assert!((y[0] - 1.706167732170469).abs() < 1e-2, "{y:?}");
    assert!(work.rejected > 0 && work.linearisations == work.steps, "{work:?}");
    assert_eq!(work.factorisations, work.steps + work.rejected);
    // Three within a step, one at its end, also where that is what rejects it.
    let plain = work.steps + 3 * (work.steps + work.rejected) + 1;
    assert!((plain..=plain + work.rejected).contains(&work.evaluations), "{work:?}");
    assert!(work.steps < 5000, "{work:?}");
}

#[test]
fn prop_restored_states_go_on_in_the_same_bits() {
    for part in [StiffPart::All, StiffPart::Contact] {
        let method = Rosenbrock { tolerance: 1e-5, part };
        assert_restores_bits(&method, None);
        assert_restores_bits(&method, Some(1.0));
    }
}

#[test]
fn regress_work_on_a_smooth_problem() {
    let work = |tolerance| {
        let method = Rosenbrock { tolerance, part: StiffPart::All };
        let mut state = method.start(0.0, &nonlinear_solution(0.0));
        method.advance(&mut nonlinear(1.0), &mut state, &mut Scratch::new(3, 0), 2.0).unwrap();
        let mut y = [0.0; 3];
        state.interpolate_beside(2.0, &mut y, |_, _| ());
        let error = (y[0] - 2f64.sin()).abs();
        (error, state.statistics)
    };
    let explicit = DormandPrince { tolerance: 1e-6 };
    let mut state = explicit.start(0.0, &nonlinear_solution(0.0));
    explicit.advance(&mut nonlinear(1.0), &mut state, &mut Scratch::new(3, 0), 2.0).unwrap();
    let (loose, few) = work(1e-4);
    let (tight, many) = work(1e-8);
    println!("1e-4: {loose:.1e} {few:?}\n1e-8: {tight:.1e} {many:?}\nexplicit, 1e-6: {:?}", state.statistics);
    assert!(loose < 1e-4 && tight < 1e-8, "{loose:e} {tight:e}");
    assert_eq!((few.steps, few.rejected, few.evaluations), (22, 0, 90), "{few:?}");
    assert_eq!((many.steps, many.rejected, many.evaluations), (410, 0, 1642), "{many:?}");
}
