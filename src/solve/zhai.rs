//! Zhai's explicit two-step method with a fixed step: one evaluation per step.
//!
//! With a_n the acceleration at (x_n, v_n) and the step h,
//!
//!   x_{n+1} = x_n + v_n h + (1/2 + psi) a_n h^2 - psi a_{n-1} h^2,
//!   v_{n+1} = v_n + (1 + phi) a_n h - phi a_{n-1} h,
//!
//! with phi = psi = 1/2, and 0 where there is no step before: at the start, after a jump of an input, an event, or a place where the
//! system is not smooth. Where a step is shortened to end at such a place both are r / 2, r the ratio to the step before: that is
//! the second-order method of Adams and Bashforth for v, and also what first-order states are integrated by. Order 2.
//!
//! Vibrations of circular frequency w are stable, and undamped by the method, for w h <= 2 without damping; damping lowers the limit:
//! to 1.8 for a twentieth of critical damping, 1.4 for a fifth, 0.47 for critical damping.
//! Continuous output: x as cubic Hermite polynomial of its values and velocities at both ends, the rest as parabola of its values
//! and its rate at the begin.
//!
//! Error of a step, estimated from a at its end: `h^2 / 3 (a_n - a_{n-1})` of x, `5 h / 12 (a_{n+1} - 2 a_n + a_{n-1})` of v.
//!
//! Source: W.M. Zhai, Int. J. Numer. Meth. Engng 39 (1996) 4199-4214.

use super::fixed::{FixedStep, STEPS};
use super::{Implicit, IntegrationState, Integrator, Scratch, Setting, SettingKind, SolveError, dense, parse_setting};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "zhai",
    summary: "explicit two-step method of order 2 with a fixed `step` in s: one evaluation per step",
    reference: "Zhai, Int. J. Numer. Meth. Engng 39 (1996) 4199-4214",
    parse,
};

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    Ok(Arc::new(Zhai { step: parse_setting(section, "step", Dimension::Time, STEPS)? }))
}

/// The method with a fixed step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zhai {
    /// s.
    pub step: f64,
}

impl Integrator for Zhai {
    fn setting(&self) -> Setting {
        Setting { kind: SettingKind::Step, value: self.step, range: STEPS }
    }

    fn with_setting(&self, step: f64) -> Arc<dyn Integrator> {
        Arc::new(Zhai { step })
    }

    fn dense_vectors(&self) -> usize {
        dense::CUBIC
    }

    /// Adams and Bashforth's method of order 2 is stable to one time constant a step.
    fn least_time_constant(&self) -> f64 {
        self.step
    }

    /// f at the begin of the step before.
    fn record_vectors(&self) -> usize {
        1
    }

    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        state.evaluate_with_cache(dynamics)?;
        dynamics.note_begin(state.t, &state.y);
        let step = FixedStep::next(self.step, dynamics, state)?;
        scratch.looks.begin(dynamics, state.t);
        let h = step.h;
        // phi and psi.
        let weight = if state.record_known { 0.5 * h / (state.t - state.t_begin) } else { 0.0 };
        let coordinates = dynamics.coordinates();
        let IntegrationState { y, derivative, record, dense, .. } = state;
        for (i, value) in scratch.trial.iter_mut().enumerate() {
            *value = if i < coordinates {
                let (now, before) = (derivative[coordinates + i], record[coordinates + i]);
                y[i] + h * (y[coordinates + i] + h * (0.5 * now + weight * (now - before)))
            } else {
                y[i] + h * (derivative[i] + weight * (derivative[i] - record[i]))
            };
        }
        dense::write_cubic(dense, y, &scratch.trial, |i| {
            if i < coordinates {
                [h * y[coordinates + i], h * scratch.trial[coordinates + i]]
            } else {
                let first = h * derivative[i];
                [first, 2.0 * (scratch.trial[i] - y[i]) - first]
            }
        });
        step.check(state, scratch)?;
        dynamics.rollback();
        let Scratch { stages: [begin, before, ..], .. } = scratch;
        begin.copy_from_slice(&state.derivative);
        // Without a step before, the change within this one stands for that of the last.
        let two_steps = weight > 0.0;
        before.copy_from_slice(if two_steps { &state.record } else { &state.derivative });
        state.record.copy_from_slice(&state.derivative);
        state.record_known = true;
        step.accept(dynamics, state, scratch, None);
        if !step.complete(dynamics, state, scratch)? {
            return Ok(());
        }
        let Scratch { stages: [begin, before, .., end, error], .. } = scratch;
        for (i, value) in error.iter_mut().enumerate() {
            *value = if i < coordinates {
                h * h / 3.0 * (begin[coordinates + i] - before[coordinates + i])
            } else {
                5.0 / 12.0 * h * (end[i] - 2.0 * begin[i] + before[i])
            };
        }
        step.judge(dynamics, state, scratch)
    }
}

#[cfg(test)]
mod tests;
