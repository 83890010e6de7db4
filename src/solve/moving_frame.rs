//! A known motion that carries the solution along, so that steps are made for what is left beside it.
//!
//! A wheel follows its rail, a vehicle its curve, held by forces that are stiff. A linearly implicit step knows f and J at its begin; that the
//! rail bends on the way (by `(V h)^2 w'' / 2` until its end) comes to it as an error of stiff components, which is felt as force. So with a
//! motion c(tau), c(0) = 0, of which the system says that the solution follows it from the step's begin t0, y0 on,
//!
//! ```text
//! y = y0 + c(tau) + z(tau),   z' = F(tau, z) = f(t0 + tau, y0 + c + z) - c',   dF/dtau = J c' - c''  at tau = 0
//! ```
//!
//! is solved for z by the same method in its form for systems that depend on time: a stage at a_i h evaluates f at y0 + c(a_i h) + .., takes
//! c'(a_i h) off, and adds `gamma_i h^2 dF/dtau`, gamma_i the sum of its row of gammas. Where f itself depends on t and the system knows how, that is part of dF/dtau too.
//!
//! Explicit methods need less: a stage at c_i h evaluates f at y0 + c(c_i h) + .. and takes c'(c_i h) off. Without it their stages leave the track
//! along its tangent, and their embedded estimates are those of the contact forces that this makes: in curves they took 1.5 to 7 times the steps.
//!
//! A W-method keeps its order whatever c is. With the exact J a motion that is linear in tau changes nothing at all: what c is for is its
//! curvature. Continuous output: that of z, plus c itself, which the system keeps for the step that was accepted last.

use super::{Implicit, IntegrationState};

/// c over one step.
#[derive(Clone, Debug)]
pub(super) struct MovingFrame {
    /// c and c' at the place asked for last.
    pub shift: Vec<f64>,
    pub rate: Vec<f64>,
    /// dF/dtau at the step's begin.
    change: Vec<f64>,
    in_frame: bool,
}

impl MovingFrame {
    pub fn new(dimension: usize) -> Self {
        let zero = || vec![0.0; dimension];
        MovingFrame { shift: zero(), rate: zero(), change: zero(), in_frame: false }
    }

    /// At the begin of a step, after [`Implicit::linearise`] there.
    pub fn begin(&mut self, dynamics: &mut dyn Implicit) {
        self.in_frame = dynamics.frame_at(0.0, &mut self.shift, &mut self.rate);
        if self.in_frame {
            dynamics.frame_change(&mut self.change);
        } else {
            for vector in [&mut self.shift, &mut self.rate] {
                vector.fill(0.0);
            }
        }
    }

    /// For a method without a Jacobian, once for all attempts at a step; directly after f was evaluated at its begin.
    pub fn note(&mut self, dynamics: &mut dyn Implicit, state: &IntegrationState) {
        dynamics.note_begin(state.t, &state.y);
        self.in_frame = dynamics.note_frame();
    }

    /// Adds c at the place asked for last.
    pub fn add_shift(&self, y: &mut [f64]) {
        if self.in_frame {
            y.iter_mut().zip(&self.shift).for_each(|(y, shift)| *y += shift);
        }
    }

    /// Component `i` of c there.
    pub fn shift_of(&self, i: usize) -> f64 {
        if self.in_frame { self.shift[i] } else { 0.0 }
    }

    /// Takes c' there off f.
    pub fn take_rate_off(&self, f: &mut [f64]) {
        if self.in_frame {
            f.iter_mut().zip(&self.rate).for_each(|(f, rate)| *f -= rate);
        }
    }

    /// Finds c and c' at `ahead` [s] after the begin.
    pub fn move_to(&mut self, dynamics: &mut dyn Implicit, ahead: f64) {
        if self.in_frame {
            dynamics.frame_at(ahead, &mut self.shift, &mut self.rate);
        }
    }

    /// Solves (I - a J) x = x + weight dF/dtau in place.
    pub fn solve(&self, dynamics: &mut dyn Implicit, x: &mut [f64], weight: f64) {
        if self.in_frame { dynamics.solve_linear_pushed(x, weight, &self.change) } else { dynamics.solve_linear(x) }
    }

    /// Notes in a state that was just accepted whether its last step was made beside such a motion.
    pub fn keep(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState) {
        state.in_frame = self.in_frame;
        if self.in_frame {
            dynamics.keep_frame();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_systems::*;
    use super::super::{DormandPrince, Integrator, RealTime, Rosenbrock, RungeKutta4, RungeKutta43, StiffPart};
    use std::sync::Arc;

    fn methods(h: f64) -> [(Arc<dyn Integrator>, f64); 5] {
        [
            (Arc::new(Rosenbrock { tolerance: 1e9, part: StiffPart::All }), 3.0),
            (Arc::new(RealTime { step: h }), 2.0),
            (Arc::new(DormandPrince { tolerance: 1e9 }), 5.0),
            (Arc::new(RungeKutta43 { tolerance: 1e9 }), 4.0),
            (Arc::new(RungeKutta4 { step: h }), 4.0),
        ]
    }

    #[test]
    fn analytic_a_stiff_motion_that_is_carried_is_exact() {
        // What is left is zero.
        let frame = Watched {
            motion: Some(|_, y, ahead| {
                let [(from, _), (to, cos)] = [y[0], y[0] + ahead].map(|x| (2.0 * x).sin_cos());
                [vec![ahead, to - from], vec![1.0, 2.0 * cos], vec![0.0, -4.0 * to]]
            }),
            ..rail()
        };
        for (method, _) in methods(0.02) {
            let (ends, inside) = errors(method.as_ref(), frame.clone(), rail_solution, 0.02, 1.0);
            let (own, _) = errors(method.as_ref(), rail(), rail_solution, 0.02, 1.0);
            println!("{method:?}: {ends:.1e}, inside {inside:.1e}; without the moving frame {own:.1e}");
            assert!(ends < 1e-13 && inside < 1e-13 && own > 1e-9);
        }
    }

    #[test]
    fn order_is_kept_whatever_motion_is_carried() {
        let frame = |share| Watched {
            motion: Some(|t, y, ahead| {
                let (sin, cos) = (1.5 * ahead).sin_cos();
                let [a, b, c] = [0.5 + y[0], 0.3 * t, -0.4];
                let [shift, rate, second] = [sin, 1.5 * cos, -2.25 * sin].map(|x| vec![a * x, b * x, c * x]);
                [shift, rate, second]
            }),
            ..nonlinear(share)
        };
        for share in [1.0, 0.4] {
            for kind in 0..methods(0.1).len() {
                let expected = methods(0.1)[kind].1;
                let at = |h: f64| errors(methods(h)[kind].0.as_ref(), frame(share), nonlinear_solution, h, 1.0);
                // What the methods of higher order leave of shorter steps is rounding; their order comes out in the limit.
                let (ends, _) = orders(at, if expected > 3.0 { 0.2 } else { 0.02 });
                println!("order {expected} with {share} of J: {ends:.2}");
                assert!((ends - expected).abs() < if expected > 3.0 { 0.5 } else { 0.25 });
            }
        }
    }

    #[test]
    fn equiv_a_linear_motion_changes_nothing() {
        let frame = Watched { motion: Some(|_, _, ahead| [vec![0.3 * ahead; 3], vec![0.3; 3], vec![0.0; 3]]), ..nonlinear(1.0) };
        // What t itself does to f is left out of J both times.
        let (with, _) = errors(methods(0.1)[0].0.as_ref(), frame, nonlinear_solution, 0.1, 0.1);
        let (without, _) = errors(methods(0.1)[0].0.as_ref(), nonlinear(1.0), nonlinear_solution, 0.1, 0.1);
        assert!((with - without).abs() < 1e-15 + 1e-9 * without, "{with:e} {without:e}");
    }
}
