//! The classical Runge-Kutta method of order 4 with a fixed step and cubic Hermite output.
//!
//! Its error is estimated as that of the pair 4(3) (see `rk43`), or by how far the step is from the trapezoidal rule where that is
//! more: beyond the limit of stability a saturating force can hold the method at a wrong state, in which its stages repeat themselves and an
//! embedded estimate sees nothing, but the state does not move as f says.

use super::dense;
use super::fixed::{FixedStep, STEPS};
use super::local_error::END;
use super::{Implicit, IntegrationState, Integrator, Scratch, Setting, SettingKind, SolveError, Undefined, parse_setting};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "rk4",
    summary: "classical Runge-Kutta of order 4 with a fixed `step` in s; no error control",
    reference: "Kutta, Zeitschrift fuer Mathematik und Physik 46 (1901) 435-453",
    parse,
};

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    Ok(Arc::new(RungeKutta4 { step: parse_setting(section, "step", Dimension::Time, STEPS)? }))
}

/// The method with a fixed step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RungeKutta4 {
    /// s.
    pub step: f64,
}

impl Integrator for RungeKutta4 {
    fn setting(&self) -> Setting {
        Setting { kind: SettingKind::Step, value: self.step, range: STEPS }
    }

    fn with_setting(&self, step: f64) -> Arc<dyn Integrator> {
        Arc::new(RungeKutta4 { step })
    }

    fn dense_vectors(&self) -> usize {
        dense::CUBIC
    }

    /// The classical method is stable to 2.785 time constants a step.
    fn least_time_constant(&self) -> f64 {
        self.step / 2.785
    }

    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        state.evaluate_with_cache(dynamics)?;
        scratch.frame.note(dynamics, state);
        let step = FixedStep::next(self.step, dynamics, state)?;
        dynamics.rollback();
        scratch.looks.begin(dynamics, state.t);
        if stages(dynamics, state, scratch, step.end, step.h).is_err() {
            return step.undefined(state);
        }
        step.check(state, scratch)?;
        write_dense(state, scratch, step.h);
        let Scratch { stages: [first, _, _, last, end, .., error], trial, frame, .. } = scratch;
        for (i, error) in error.iter_mut().enumerate() {
            let embedded = step.h / 6.0 * (last[i] - end[i]);
            let trapezoid = trial[i] - frame.shift_of(i) - state.y[i] - 0.5 * step.h * (first[i] + end[i]);
            *error = if trapezoid.abs() > embedded.abs() { trapezoid } else { embedded };
        }
        step.accept(dynamics, state, scratch, Some(END));
        scratch.frame.keep(dynamics, state);
        if !step.complete(dynamics, state, scratch)? {
            return Ok(());
        }
        step.judge(dynamics, state, scratch)
    }
}

/// The four stages, the solution at `end` = t + h in `scratch.trial`, and f there as fifth stage, all beside the moving frame; f itself is in
/// `scratch.stages[END]`.
pub(super) fn stages(
    dynamics: &mut dyn Implicit,
    state: &mut IntegrationState,
    scratch: &mut Scratch,
    end: f64,
    h: f64,
) -> Result<(), Undefined> {
    let Scratch { stages, frame, trial, looks, .. } = scratch;
    stages[0].copy_from_slice(&state.derivative);
    frame.move_to(dynamics, 0.0);
    frame.take_rate_off(&mut stages[0]);
    let points = [(0.5, 0.5 * h), (0.5, 0.5 * h), (1.0, h)];
    for (stage, (fraction, weight)) in points.into_iter().enumerate() {
        for (i, value) in trial.iter_mut().enumerate() {
            *value = state.y[i] + weight * stages[stage][i];
        }
        if stage != 1 {
            frame.move_to(dynamics, fraction * h);
        }
        frame.add_shift(trial);
        state.statistics.evaluations += 1;
        dynamics.derivative(state.t + fraction * h, trial, &mut stages[stage + 1])?;
        frame.take_rate_off(&mut stages[stage + 1]);
        looks.stage(dynamics, state.t + fraction * h);
    }
    for (i, value) in trial.iter_mut().enumerate() {
        let k = |j: usize| stages[j][i];
        *value = state.y[i] + h / 6.0 * (k(0) + 2.0 * (k(1) + k(2)) + k(3));
    }
    frame.add_shift(trial);
    state.statistics.evaluations += 1;
    let [.., last, _, _, end_rate, _] = stages;
    dynamics.derivative_at_end(end, trial, end_rate)?;
    last.copy_from_slice(end_rate);
    frame.take_rate_off(last);
    Ok(())
}

/// Cubic Hermite polynomial through both ends of the step.
pub(super) fn write_dense(state: &mut IntegrationState, scratch: &Scratch, h: f64) {
    let slopes = |i: usize| [h * scratch.stages[0][i], h * scratch.stages[4][i]];
    let n = state.y.len();
    for i in 0..n {
        dense::write_one(&mut state.dense, (i, n), [state.y[i], scratch.trial[i] - scratch.frame.shift_of(i)], slopes(i));
    }
}
