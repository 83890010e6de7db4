//! The generalised-alpha method for first-order systems with a fixed step.
//!
//! With d the method's own approximation of y',
//!
//!   d_{n+am} = f(t_{n+af}, y_{n+af}),   x_{n+a} = x_n + a (x_{n+1} - x_n),   y_{n+1} = y_n + h (d_n + gamma (d_{n+1} - d_n)),
//!   am = (3 - rho) / (2 (1 + rho)),   af = 1 / (1 + rho),   gamma = 1/2 + am - af .
//!
//! Order 2, A-stable, and |R(infinity)| = rho: that much of what is too fast for the step is left after each step. rho = 1 is the
//! midpoint rule, rho = 0 damps as Gear's method does. A vibration of circular frequency w that the step resolves comes late by
//! C (w h)^2 of its phase, C = 1/12 + ((1 - rho) / (1 + rho))^2 / 4: 0.083 for rho = 1, 0.099 for 0.6, 0.33 for 0. The default 0.6 has nearly the
//! accuracy of the first and leaves 4e-5 of what is too fast after 20 steps.
//!
//! Each step is solved for d_{n+1} by modified Newton iterations, am (I - a J) delta = f - d_{n+am} with a = af gamma h / am: the Jacobian is
//! found at the prediction d_{n+1} = d_n and again after [`REFRESH`] iterations. They end when what is left of y_{n+1}, foreseen from how the
//! steps shrink, is below 1e-10 of the step's own movement (weighted as for the error).
//!
//! Where the iterations do not end the step is divided: its first half is tried alone, and the rest is the next step. Where f jumps
//! (a contact that changes its place on the profile), what is left need only be below [`ACCEPTED`].
//!
//! Error of a step, estimated: `a (I - a J)^-1 (f - d)` at its end, with the matrix of its iterations.
//!
//! d is part of the state. It starts as f, also after a jump of an input, an event or a place where the system is not smooth.
//! Continuous output: cubic Hermite polynomial with d at both ends.
//!
//! Source: K.E. Jansen, C.H. Whiting, G.M. Hulbert, Comput. Methods Appl. Mech. Engrg. 190 (2000) 305-319.

use super::fixed::{FixedStep, STEPS};
use super::{
    Implicit, IntegrationState, Integrator, Scratch, Setting, SettingKind, SolveError, StiffPart, Undefined, dense, parse_setting,
};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "generalised_alpha",
    summary: "implicit, order 2, fixed `step` in s; `rho_infinity`, 0 to 1 (0.6): what is left of too fast vibrations after a step",
    reference: "Jansen, Whiting, Hulbert, Comput. Methods Appl. Mech. Engrg. 190 (2000) 305-319",
    parse,
};

const RHO: f64 = 0.6;

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    let rho_infinity = section.number_or("rho_infinity", Dimension::None, RHO)?;
    if !(0.0..=1.0).contains(&rho_infinity) {
        return Err(section.error("rho_infinity", format!("found {rho_infinity:?}, expected 0 to 1")));
    }
    Ok(Arc::new(GeneralisedAlpha { step: parse_setting(section, "step", Dimension::Time, STEPS)?, rho_infinity }))
}

/// The method with a fixed step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralisedAlpha {
    /// s.
    pub step: f64,
    /// What is left of a component that is infinitely fast after a step, -.
    pub rho_infinity: f64,
}

/// Iterations, and after how many the Jacobian is found anew.
const MOST_ITERATIONS: usize = 10;
const REFRESH: usize = 4;
/// What may be left: of the step's movement, and in any case (below rounding of weighted positions), m and rad.
const RELATIVE: f64 = 1e-10;
const ABSOLUTE: f64 = 1e-13;
/// What may be left where f itself jumps (a contact that changes its place on the profile), m and rad: there is no solution to full
/// accuracy then. For a wheelset's height it is 0.1 um, 0.2 % of the wheel load.
const ACCEPTED: f64 = 1e-5;

/// am, af and gamma.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weights {
    rates: f64,
    states: f64,
    gamma: f64,
}

impl GeneralisedAlpha {
    fn weights(&self) -> Weights {
        let rho = self.rho_infinity;
        let (rates, states) = (0.5 * (3.0 - rho) / (1.0 + rho), 1.0 / (1.0 + rho));
        Weights { rates, states, gamma: 0.5 + rates - states }
    }

    /// Solves for d at the end of the step, in `scratch.stages[0]`.
    fn iterate(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        step: &FixedStep,
    ) -> Result<(), SolveError> {
        let Weights { rates, states, gamma } = self.weights();
        let h = step.h;
        let undefined = |Undefined| SolveError::Undefined { time: state.t };
        let Scratch { stages: [rate, change, ..], trial, .. } = scratch;
        rate.copy_from_slice(&state.record);
        let movement = (0..state.y.len()).map(|i| dynamics.error_weight(i) * (h * state.record[i]).abs()).fold(0.0, f64::max);
        let allowed = RELATIVE * movement + ABSOLUTE;
        let mut last = f64::INFINITY;
        for iteration in 0..MOST_ITERATIONS {
            for (i, value) in trial.iter_mut().enumerate() {
                *value = state.y[i] + states * h * (state.record[i] + gamma * (rate[i] - state.record[i]));
            }
            let time = state.t + states * h;
            dynamics.rollback();
            state.statistics.evaluations += 1;
            state.statistics.iterations += 1;
            dynamics.derivative(time, trial, change).map_err(undefined)?;
            if iteration % REFRESH == 0 {
                state.statistics.linearisations += 1;
                state.statistics.factorisations += 1;
                dynamics.linearise(time, trial, StiffPart::All).map_err(undefined)?;
                dynamics.factorise(states * gamma * h / rates).map_err(undefined)?;
                last = f64::INFINITY;
            }
            for (i, value) in change.iter_mut().enumerate() {
                *value = (*value - state.record[i]) / rates - (rate[i] - state.record[i]);
            }
            dynamics.solve_linear(change);
            let mut length: f64 = 0.0;
            for (i, value) in rate.iter_mut().enumerate() {
                *value += change[i];
                let moved = dynamics.error_weight(i) * (gamma * h * change[i]).abs();
                length = if moved.is_nan() { f64::INFINITY } else { length.max(moved) };
            }
            if !length.is_finite() {
                last = length;
                break;
            }
            // What all further changes would sum up to if they went on shrinking as the last two did.
            let shrink = length / last;
            let foreseen = if last.is_finite() && shrink < 0.5 { length * shrink / (1.0 - shrink) } else { length };
            if foreseen <= allowed {
                return Ok(());
            }
            last = length;
        }
        if last <= ACCEPTED {
            return Ok(());
        }
        Err(SolveError::NotConverged { time: state.t, step: h, iterations: MOST_ITERATIONS })
    }
}

impl Integrator for GeneralisedAlpha {
    fn setting(&self) -> Setting {
        Setting { kind: SettingKind::Step, value: self.step, range: STEPS }
    }

    fn with_setting(&self, step: f64) -> Arc<dyn Integrator> {
        Arc::new(GeneralisedAlpha { step, ..*self })
    }

    fn dense_vectors(&self) -> usize {
        dense::CUBIC
    }

    /// d at the end of the last step.
    fn record_vectors(&self) -> usize {
        1
    }

    fn linearises(&self) -> bool {
        true
    }

    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        state.evaluate_with_cache(dynamics)?;
        if !state.record_known {
            state.record.copy_from_slice(&state.derivative);
            state.record_known = true;
        }
        let step = FixedStep::next(self.step, dynamics, state)?;
        scratch.looks.begin(dynamics, state.t);
        if let Err(error) = self.iterate(dynamics, state, scratch, &step) {
            state.statistics.rejected += 1;
            return step.failed(state, error);
        }
        let (h, gamma) = (step.h, self.weights().gamma);
        let rate = &scratch.stages[0];
        for (i, value) in scratch.trial.iter_mut().enumerate() {
            *value = state.y[i] + h * (state.record[i] + gamma * (rate[i] - state.record[i]));
        }
        step.check(state, scratch)?;
        dense::write_cubic(&mut state.dense, &state.y, &scratch.trial, |i| [h * state.record[i], h * scratch.stages[0][i]]);
        state.record.copy_from_slice(&scratch.stages[0]);
        step.accept(dynamics, state, scratch, None);
        if !step.complete(dynamics, state, scratch)? {
            return Ok(());
        }
        let Weights { rates, states, gamma } = self.weights();
        let Scratch { stages: [rate, .., end, error], .. } = scratch;
        let a = states * gamma * h / rates;
        for (error, (end, rate)) in error.iter_mut().zip(end.iter().zip(rate.iter())) {
            *error = a * (end - rate);
        }
        dynamics.solve_linear(error);
        step.judge(dynamics, state, scratch)
    }
}

#[cfg(test)]
mod tests;
