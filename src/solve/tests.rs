//! Order tests on problems with known solutions, which implement the same trait as the vehicle.

use super::*;
/// Forced oscillator y'' = -y + t with solution t + sin t (start 0, 2): smooth, not autonomous.
struct Oscillator;

impl Dynamics for Oscillator {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        dy[0] = y[1];
        dy[1] = -y[0] + t;
        Ok(())
    }
    fn error_weight(&self, i: usize) -> f64 {
        if i == 0 { 1.0 } else { 0.0 }
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}
impl Implicit for Oscillator {}

fn oscillator(integrator: &dyn Integrator) -> (IntegrationState, Scratch) {
    (integrator.start(0.0, &[0.0, 2.0]), Scratch::new(2, 0))
}

/// Polynomial y' = degree t^(degree - 1).
struct Power(i32);

impl Dynamics for Power {
    fn derivative(&mut self, t: f64, _: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        dy[0] = f64::from(self.0) * t.powi(self.0 - 1);
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}
impl Implicit for Power {}

/// Largest error at the steps' ends and inside the steps (dense output), with a step forced to `h`.
fn errors(integrator: &dyn Integrator, h: f64) -> (f64, f64) {
    let (mut state, mut scratch) = oscillator(integrator);
    let (mut end, mut dense) = (0f64, 0f64);
    let mut y = [0.0; 2];
    while state.t < 3.0 - 1e-9 {
        state.next_step = h;
        integrator.step(&mut Oscillator, &mut state, &mut scratch).unwrap();
        end = end.max((state.y[0] - state.t - state.t.sin()).abs());
        for k in 1..10 {
            let t = state.t_begin + (state.t - state.t_begin) * f64::from(k) / 10.0;
            state.interpolate_beside(t, &mut y, |_, _| ());
            dense = dense.max((y[0] - t - t.sin()).abs());
        }
    }
    (end, dense)
}

#[test]
fn order_dormand_prince_converges_with_order_5_and_dense_output_with_order_4_locally_5() {
    // tolerance so loose that the forced step is always accepted
    let at = |h| errors(&DormandPrince { tolerance: 1e9 }, h);
    let (coarse, fine) = (at(0.1), at(0.025));
    let order = (coarse.0 / fine.0).log2() / 2.0;
    let dense = (coarse.1 / fine.1).log2() / 2.0;
    println!("Dormand-Prince: order {order:.2} at the ends, {dense:.2} inside the steps");
    assert!((order - 5.0).abs() < 0.2 && (dense - 5.0).abs() < 0.3);
}

#[test]
fn order_rk4_converges_with_order_4_inside_too() {
    let at = |h| errors(&RungeKutta4 { step: h }, h);
    let (coarse, fine) = (at(0.05), at(0.0125));
    let order = (coarse.0 / fine.0).log2() / 2.0;
    let dense = (coarse.1 / fine.1).log2() / 2.0;
    println!("RK4: order {order:.2} at the ends, {dense:.2} inside the steps");
    assert!((order - 4.0).abs() < 0.2 && (dense - 4.0).abs() < 0.3);
}

#[test]
fn order_rk43_converges_with_order_4_and_its_estimate_with_order_4() {
    let at = |h| errors(&RungeKutta43 { tolerance: 1e9 }, h);
    let (coarse, fine) = (at(0.05), at(0.0125));
    let order = (coarse.0 / fine.0).log2() / 2.0;
    println!("RK4(3): order {order:.2} at the ends");
    assert!((order - 4.0).abs() < 0.2);
    // The embedded solution of order 3 is exact on a cubic, so the estimate vanishes there; on t^4 it is h^4 times a
    // constant: classical weights are exact, the others give h^4 (4 (1/3 + 1/3) / 8 + 4/6) = h^4 on t in [0, h] but 1/24 off.
    let estimate = |degree: i32, h: f64| {
        let pair = RungeKutta43 { tolerance: 1e9 };
        let mut state = pair.start(0.0, &[0.0]);
        let mut scratch = Scratch::new(1, 0);
        state.evaluate_begin(&mut Power(degree)).unwrap();
        adaptive::StepPair::attempt(&pair, &mut Power(degree), &mut state, &mut scratch, h).unwrap().state
    };
    assert!(estimate(3, 0.7) < 1e-15);
}

#[test]
fn order_methods_are_exact_on_polynomials_of_their_order() {
    let methods: [(&dyn Integrator, i32, i32); 3] =
        [(&DormandPrince { tolerance: 1e9 }, 5, 4), (&RungeKutta43 { tolerance: 1e9 }, 4, 3), (&RungeKutta4 { step: 0.7 }, 4, 3)];
    for (integrator, exact, dense) in methods {
        for degree in 1..=exact + 1 {
            let mut state = integrator.start(0.0, &[0.0]);
            state.next_step = 0.7;
            let mut scratch = Scratch::new(1, 0);
            integrator.step(&mut Power(degree), &mut state, &mut scratch).unwrap();
            let error = (state.y[0] - 0.7f64.powi(degree)).abs();
            assert_eq!(error < 1e-14, degree <= exact, "{integrator:?} degree {degree}: {error:e}");
            let mut y = [0.0];
            state.interpolate_beside(0.3, &mut y, |_, _| ());
            let error = (y[0] - 0.3f64.powi(degree)).abs();
            assert_eq!(error < 1e-14, degree <= dense, "{integrator:?} dense, degree {degree}: {error:e}");
        }
    }
}

#[test]
fn order_error_falls_with_tolerance_and_work_is_pinned() {
    let run = |tolerance| {
        let integrator = DormandPrince { tolerance };
        let (mut state, mut scratch) = oscillator(&integrator);
        integrator.advance(&mut Oscillator, &mut state, &mut scratch, 20.0).unwrap();
        let mut y = [0.0; 2];
        state.interpolate_beside(20.0, &mut y, |_, _| ());
        ((y[0] - 20.0 - 20f64.sin()).abs(), state.statistics)
    };
    let (loose, few) = run(1e-5);
    let (tight, many) = run(1e-10);
    assert!(loose < 1e-3 && tight < 1e-8, "{loose:e} {tight:e}");
    // regress: work, on any machine
    assert_eq!((few.steps, few.rejected), (81, 0), "{few:?}");
    assert_eq!((many.steps, many.rejected), (739, 0), "{many:?}");
}

/// y' = 1 before t = 1/3, 2 after it: wrong unless a step ends there.
struct Kink;

impl Dynamics for Kink {
    fn derivative(&mut self, t: f64, _: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        dy[0] = if t < 1.0 / 3.0 { 1.0 } else { 2.0 };
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, t: f64, _: &[f64]) -> f64 {
        if t < 1.0 / 3.0 { 1.0 / 3.0 } else { f64::INFINITY }
    }
}
impl Implicit for Kink {}

#[test]
fn analytic_steps_end_where_the_system_is_not_smooth() {
    // The last stage lies on the kink's far side, so the step before it is exact only to the weight of that stage
    // in the solution, which is zero for Dormand-Prince; RK4 uses it with weight 1/6.
    let integrator = DormandPrince { tolerance: 1e-3 };
    let mut state = integrator.start(0.0, &[0.0]);
    let mut ends = vec![];
    let mut scratch = Scratch::new(1, 0);
    while state.t < 1.0 {
        integrator.step(&mut Kink, &mut state, &mut scratch).unwrap();
        ends.push(state.t);
    }
    assert!(ends.contains(&(1.0 / 3.0)));
    let rk4 = RungeKutta4 { step: 0.05 };
    let mut state = rk4.start(0.0, &[0.0]);
    rk4.advance(&mut Kink, &mut state, &mut scratch, 0.5).unwrap();
    assert!((state.grid_start - 1.0 / 3.0).abs() < 1e-15, "the grid starts anew at the kink");
}

#[test]
fn prop_result_does_not_depend_on_where_it_is_read() {
    let methods: [&dyn Integrator; 3] =
        [&DormandPrince { tolerance: 1e-7 }, &RungeKutta43 { tolerance: 1e-7 }, &RungeKutta4 { step: 0.013 }];
    for integrator in methods {
        let read = |steps: u32| {
            let (mut state, mut scratch) = oscillator(integrator);
            let mut y = [0.0; 2];
            for i in 1..=steps {
                let t = 4.0 * f64::from(i) / f64::from(steps);
                integrator.advance(&mut Oscillator, &mut state, &mut scratch, t).unwrap();
                state.interpolate_beside(t, &mut y, |_, _| ());
            }
            y
        };
        assert_eq!(read(1), read(1000));
    }
}

#[test]
fn prop_restart_continues_from_the_dense_output() {
    let integrator = DormandPrince { tolerance: 1e-9 };
    let (mut state, mut scratch) = oscillator(&integrator);
    integrator.advance(&mut Oscillator, &mut state, &mut scratch, 1.234).unwrap();
    assert!(state.t > 1.234);
    state.restart_at(1.234, |_, _| ());
    assert!((state.y[0] - 1.234 - 1.234f64.sin()).abs() < 1e-8);
    integrator.advance(&mut Oscillator, &mut state, &mut scratch, 3.0).unwrap();
    let mut y = [0.0; 2];
    state.interpolate_beside(3.0, &mut y, |_, _| ());
    assert!((y[0] - 3.0 - 3f64.sin()).abs() < 1e-7);
    assert_eq!(state.statistics.restarts, 1);
}

/// Blows up at t = 1.
struct Pole;

impl Dynamics for Pole {
    fn derivative(&mut self, _: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        dy[0] = y[0] * y[0];
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}
impl Implicit for Pole {}

#[test]
fn hard_a_pole_ends_in_an_error_and_keeps_the_last_good_state() {
    let mut scratch = Scratch::new(1, 0);
    let methods: [&dyn Integrator; 3] =
        [&DormandPrince { tolerance: 1e-6 }, &RungeKutta43 { tolerance: 1e-6 }, &RungeKutta4 { step: 0.01 }];
    for integrator in methods {
        let mut state = integrator.start(0.0, &[1.0]);
        let error = integrator.advance(&mut Pole, &mut state, &mut scratch, 2.0).unwrap_err();
        assert!(state.y[0].is_finite() && state.t < 1.2, "{error} at {}", state.t);
    }
}

/// A relay: it drives y to zero and keeps it there, by turning round without end.
struct Relay;
impl Dynamics for Relay {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        dy[0] = (100.0 * t).sin() - 1e3 * y[0].signum();
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}
impl Implicit for Relay {}

#[test]
fn hard_forces_that_jump_to_and_fro_end_in_an_error_and_not_in_days_of_steps() {
    let (integrator, mut state, mut scratch) =
        (DormandPrince { tolerance: 1e-9 }, DormandPrince { tolerance: 1e-9 }.start(0.0, &[0.1]), Scratch::new(1, 0));
    let error = integrator.advance(&mut Relay, &mut state, &mut scratch, 1.0).unwrap_err();
    assert!(matches!(error, SolveError::Crawls { steps: 2000, .. }), "{error}");
    // It got to where the forces jump, and what it found until then is kept.
    assert!((state.t - 1e-4).abs() < 1e-5 && state.y[0].abs() < 1e-6, "{} {:?}", state.t, state.y);
}

#[test]
fn hard_a_time_that_no_longer_moves_is_an_error_and_not_a_loop() {
    for start in [1e12, 1e16] {
        let methods: [&dyn Integrator; 2] = [&DormandPrince { tolerance: 1e-9 }, &RungeKutta4 { step: 1e-5 }];
        for integrator in methods {
            let mut state = integrator.start(start, &[0.0, 2.0]);
            let error = integrator.advance(&mut Oscillator, &mut state, &mut Scratch::new(2, 0), start + 4.0).unwrap_err();
            assert!(matches!(error, SolveError::NoProgress { .. }), "{error}");
        }
    }
}

#[test]
fn hard_a_start_of_unix_epoch_size_loses_only_the_digits_of_time() {
    // t = 1.7e9 s is known to 2.4e-7 s only; steps must still fit together.
    let start = 1.7e9;
    let integrator = DormandPrince { tolerance: 1e-9 };
    let mut state = integrator.start(start, &[1.0]);
    let mut scratch = Scratch::new(1, 0);
    integrator.advance(&mut Decay, &mut state, &mut scratch, start + 2.0).unwrap();
    let mut y = [0.0];
    state.interpolate_beside(start + 2.0, &mut y, |_, _| ());
    assert!((y[0] - (-2f64).exp()).abs() < 1e-8, "{}", y[0]);
}

/// y' = -y.
struct Decay;

impl Dynamics for Decay {
    fn derivative(&mut self, _: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        dy[0] = -y[0];
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}
impl Implicit for Decay {}

/// A ball that falls from 1 m and bounces: its event function is its height; each event turns its speed.
struct Ball {
    height: f64,
}
impl Dynamics for Ball {
    fn derivative(&mut self, _: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        (dy[0], dy[1]) = (y[1], -10.0);
        self.height = y[0];
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
    fn event_functions(&self) -> usize {
        1
    }
    fn event_values(&self, values: &mut [f64]) {
        values[0] = self.height;
    }
    fn due(&self, _: f64) -> Option<Event> {
        (self.height < 0.0).then_some(Event(0))
    }
    fn on_event(&mut self, _: Event, _: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        y[1] *= -0.5;
        y[0] = 0.0;
        Ok(true)
    }
}
impl Implicit for Ball {}

#[test]
fn analytic_events_are_located_and_read_in_the_right_form() {
    for integrator in [&DormandPrince { tolerance: 1e-10 } as &dyn Integrator, &RungeKutta4 { step: 0.01 }] {
        let mut state = integrator.start(0.0, &[1.0, 0.0]);
        let mut scratch = Scratch::new(2, 1);
        let mut ball = Ball { height: 1.0 };
        // It lands at sqrt(0.2) with -sqrt(20), rises to a quarter, and lands again sqrt(0.2) later.
        let landing = 0.2f64.sqrt();
        let mut y = [0.0; 2];
        for (time, height, speed) in [(0.9 * landing, 1.0 - 0.81, -0.9 * 20f64.sqrt()), (1.5 * landing, 0.25, 0.0)] {
            integrator.advance(&mut ball, &mut state, &mut scratch, time).unwrap();
            state.interpolate_beside(time, &mut y, |_, _| ());
            assert!((y[0] - height).abs() < 1e-9 && (y[1] - speed).abs() < 1e-9, "{time}: {y:?}");
        }
        assert_eq!(state.statistics.events, 1);
        integrator.advance(&mut ball, &mut state, &mut scratch, 2.1 * landing).unwrap();
        assert_eq!(state.statistics.events, 2);
    }
}

#[test]
fn prop_a_restart_before_an_event_undoes_it() {
    let integrator = DormandPrince { tolerance: 1e-10 };
    let mut state = integrator.start(0.0, &[1.0, 0.0]);
    let (mut scratch, mut ball) = (Scratch::new(2, 1), Ball { height: 1.0 });
    // The step that holds the landing has begun before 0.44.
    integrator.advance(&mut ball, &mut state, &mut scratch, 0.44).unwrap();
    assert!(state.switch_due && (state.t - 0.2f64.sqrt()).abs() < 1e-9, "{}", state.t);
    state.restart_at(0.44, |_, _| ());
    assert!(!state.switch_due && state.t == 0.44 && (state.y[0] - 0.032).abs() < 1e-12);
}

/// A point on the unit circle whose speed is slightly wrong outward: projection must bring it back.
struct Circle;
impl Dynamics for Circle {
    fn derivative(&mut self, _: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        (dy[0], dy[1]) = (-y[1] + 1e-3 * y[0], y[0] + 1e-3 * y[1]);
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
    fn project(&mut self, _: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        let radius = y[0].hypot(y[1]);
        y.iter_mut().for_each(|value| *value /= radius);
        Ok(true)
    }
}
impl Implicit for Circle {}

#[test]
fn analytic_projection_holds_the_circle_and_is_counted() {
    let integrator = RungeKutta4 { step: 0.01 };
    let mut state = integrator.start(0.0, &[1.0, 0.0]);
    integrator.advance(&mut Circle, &mut state, &mut Scratch::new(2, 0), 3.0).unwrap();
    assert!((state.y[0].hypot(state.y[1]) - 1.0).abs() < 1e-15);
    assert!((state.y[0] - 3f64.cos()).abs() < 1e-6);
    assert_eq!(state.statistics.projections, state.statistics.steps);
}
