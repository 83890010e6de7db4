//! ROS2: a Rosenbrock-W method of order 2 with a fixed step, and a step's work is always the same.
//!
//! For hosts that must answer in time. A step takes two evaluations of f (one more after a restart), one Jacobian, one factorisation and three
//! solutions of linear systems; nothing is iterated and nothing rejected:
//!
//!   (I - gamma h J) k1 = h f(t, y),    (I - gamma h J) k2 = h f(t + h, y + k1) - 2 k1,    y1 = y + 3/2 k1 + 1/2 k2 .
//!
//! Order 2 whatever J is, also where f depends on t (see `rosenbrock`). R(z) = (1 + (1 - 2 gamma) z) / (1 - gamma z)^2 is L-stable for
//! gamma = 1 - 1/sqrt(2) and 1 + 1/sqrt(2). The first has an error constant 1/6 - 3 gamma^2 + 2 gamma^3 of -0.040, the second one of
//! 1.37, 34 times more; the second keeps the sign of decaying components, which concentrations in air chemistry need and wheels
//! do not. Hence the first. Without J the method is Heun's: it needs J for stability as much as any explicit one lacks it.
//!
//! Continuous output: with the stages in standard form, K1 = k1 and K2 = k2 + 2 k1, y + theta K1 + theta^2 / 2 (K2 - K1): of order 2
//! like the method, and free of f, whose stiff part would swing it far between the ends.
//!
//! Both for what is left beside a moving frame, where the system knows one ([`super::moving_frame`]; dF/dtau counts gamma h^2 in the first
//! stage, -gamma h^2 in the second).
//!
//! Error of a step, estimated: `gamma h (I - gamma h J)^-1 (f - y')` with f at its end and y' the rate of the continuous output there, of order 3
//! like the error itself. That evaluation is the first one of the next step.
//!
//! What else may happen in a step depends on the system: an event is located by up to [`super::events::MOST_LOOKS`] more evaluations; a
//! system with a margin takes one more evaluation in each step.
//!
//! A step that ends within 1e-9 of itself before a communication point has reached it: else rounding would cost a step more now and then.
//!
//! Source: J.G. Verwer, E.J. Spee, J.G. Blom, W. Hundsdorfer, SIAM J. Sci. Comput. 20 (1999) 1456-1480.

use super::fixed::{FixedStep, MOST_PARTS, SLACK, STEPS};
use super::{
    Implicit, IntegrationState, Integrator, Scratch, Setting, SettingKind, SolveError, StiffPart, Undefined, events, parse_setting,
};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "real_time",
    summary: "fixed `step` in s with bounded work: Rosenbrock-W method ROS2 of order 2, L-stable",
    reference: "Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20 (1999) 1456-1480",
    parse,
};

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    Ok(Arc::new(RealTime { step: parse_setting(section, "step", Dimension::Time, STEPS)? }))
}

/// The method with a fixed step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealTime {
    /// s.
    pub step: f64,
}

const GAMMA: f64 = 1.0 - FRAC_1_SQRT_2;

/// Continuous output: powers 0 to 2 of theta.
const DENSE_VECTORS: usize = 3;

impl Integrator for RealTime {
    fn setting(&self) -> Setting {
        Setting { kind: SettingKind::Step, value: self.step, range: STEPS }
    }

    fn with_setting(&self, step: f64) -> Arc<dyn Integrator> {
        Arc::new(RealTime { step })
    }

    fn dense_vectors(&self) -> usize {
        DENSE_VECTORS
    }

    fn linearises(&self) -> bool {
        true
    }

    fn lags_in_integrals(&self) -> bool {
        true
    }

    fn worst_case(&self) -> Option<String> {
        Some(format!(
            "each step of {} s: 2 evaluations, 1 Jacobian, 1 factorisation, 3 linear solutions; 1 evaluation more after a restart, up to {} more in a step that an event ends; a step in which a contact loses its place is tried in halves, up to {} times",
            self.step,
            events::MOST_LOOKS,
            MOST_PARTS
        ))
    }

    fn slack(&self) -> f64 {
        SLACK * self.step
    }

    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        state.evaluate_with_cache(dynamics)?;
        state.linearise(dynamics, StiffPart::All)?;
        let step = FixedStep::next(self.step, dynamics, state)?;
        scratch.looks.begin(dynamics, state.t);
        dynamics.rollback();
        if stages(dynamics, state, scratch, &step).is_err() {
            return step.undefined(state);
        }
        step.check(state, scratch)?;
        let n = state.y.len();
        for i in 0..n {
            let first = scratch.stages[0][i];
            let second = scratch.stages[1][i] + 2.0 * first;
            for (power, coefficient) in [state.y[i], first, 0.5 * (second - first)].into_iter().enumerate() {
                state.dense[power * n + i] = coefficient;
            }
        }
        scratch.frame.move_to(dynamics, step.h);
        step.accept(dynamics, state, scratch, None);
        scratch.frame.keep(dynamics, state);
        if !step.complete(dynamics, state, scratch)? {
            return Ok(());
        }
        let Scratch { stages: [first, second, .., end, error], frame, .. } = scratch;
        // u' h of the continuous output at the end is K2.
        for (i, value) in error.iter_mut().enumerate() {
            *value = GAMMA * (step.h * (end[i] - frame.rate[i]) - second[i] - 2.0 * first[i]);
        }
        dynamics.solve_linear(error);
        step.judge(dynamics, state, scratch)
    }
}

/// Both stages and the solution at the end.
fn stages(dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch, step: &FixedStep) -> Result<(), Undefined> {
    let Scratch { stages: [first, second, ..], frame, trial, .. } = scratch;
    state.statistics.factorisations += 1;
    dynamics.factorise(GAMMA * step.h)?;
    frame.begin(dynamics);
    // The gammas of the second stage sum up to minus the first one's.
    let change = GAMMA * step.h * step.h;
    for (i, value) in first.iter_mut().enumerate() {
        *value = step.h * (state.derivative[i] - frame.rate[i]);
    }
    frame.solve(dynamics, first, change);
    frame.move_to(dynamics, step.h);
    for (i, value) in trial.iter_mut().enumerate() {
        *value = state.y[i] + frame.shift[i] + first[i];
    }
    state.statistics.evaluations += 1;
    dynamics.derivative(step.end, trial, second)?;
    for (i, value) in second.iter_mut().enumerate() {
        *value = step.h * (*value - frame.rate[i]) - 2.0 * first[i];
    }
    frame.solve(dynamics, second, -change);
    for (i, value) in trial.iter_mut().enumerate() {
        *value = state.y[i] + frame.shift[i] + 1.5 * first[i] + 0.5 * second[i];
    }
    Ok(())
}

#[cfg(test)]
mod tests;
