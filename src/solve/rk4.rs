//! The classical Runge-Kutta method of order 4 with a fixed step and cubic Hermite output.
//!
//! Steps stand on the grid `start + k step`; a step that would pass a point where the system is not smooth is
//! shortened to end there, and the grid starts anew.

use super::{Dynamics, IntegrationState, Integrator, Scratch, SolveError};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "rk4",
    summary: "classical Runge-Kutta of order 4 with a fixed `step` in s; no error control",
    reference: "Kutta, Zeitschrift fuer Mathematik und Physik 46 (1901) 435-453",
    parse,
};

fn parse(section: &Section) -> Result<Integrator, SettingsError> {
    Ok(Integrator::RungeKutta4 { step: section.positive("step", Dimension::Time)? })
}

/// Continuous output: powers 0 to 3 of theta.
pub(super) const DENSE_VECTORS: usize = 4;

/// One step.
pub(super) fn step<D: Dynamics>(
    step: f64,
    dynamics: &mut D,
    state: &mut IntegrationState,
    scratch: &mut Scratch,
) -> Result<(), SolveError<D::Error>> {
    if !state.derivative_known {
        let IntegrationState { t, y, memory, derivative, .. } = state;
        dynamics.derivative(*t, y, memory, derivative).map_err(SolveError::Evaluation)?;
        state.derivative_known = true;
        state.statistics.evaluations += 1;
    }
    let limit = dynamics.next_break(state.t, &state.y, &state.memory);
    let next = state.grid_start + (state.grid_count + 1) as f64 * step;
    let cut = next >= limit - 1e-9 * step;
    let end = if cut { limit } else { next };
    let h = end - state.t;

    let n = state.y.len();
    scratch.memory.copy_from_slice(&state.memory);
    scratch.stages[0].copy_from_slice(&state.derivative);
    let points = [(0.5, 0.5 * h), (0.5, 0.5 * h), (1.0, h)];
    for (stage, (fraction, weight)) in points.into_iter().enumerate() {
        let (done, rest) = scratch.stages.split_at_mut(stage + 1);
        for (i, value) in scratch.trial.iter_mut().enumerate() {
            *value = state.y[i] + weight * done[stage][i];
        }
        evaluate(dynamics, state, state.t + fraction * h, &scratch.trial, &mut scratch.memory, &mut rest[0])?;
    }
    for (i, value) in scratch.trial.iter_mut().enumerate() {
        let k = |j: usize| scratch.stages[j][i];
        *value = state.y[i] + h / 6.0 * (k(0) + 2.0 * (k(1) + k(2)) + k(3));
    }
    if !scratch.trial.iter().all(|value| value.is_finite()) {
        return Err(SolveError::NotFinite { time: state.t, step });
    }
    evaluate(dynamics, state, end, &scratch.trial, &mut scratch.memory, &mut scratch.stages[4])?;

    for i in 0..n {
        let (begin, difference) = (state.y[i], scratch.trial[i] - state.y[i]);
        let (first, last) = (h * scratch.stages[0][i], h * scratch.stages[4][i]);
        let coefficients = [begin, first, 3.0 * difference - 2.0 * first - last, first + last - 2.0 * difference];
        for (power, coefficient) in coefficients.into_iter().enumerate() {
            state.dense[power * n + i] = coefficient;
        }
    }
    state.t_begin = state.t;
    state.t = end;
    state.y.copy_from_slice(&scratch.trial);
    state.memory.copy_from_slice(&scratch.memory);
    state.derivative.copy_from_slice(&scratch.stages[4]);
    state.derivative_known = !cut;
    if cut {
        state.grid_start = end;
        state.grid_count = 0;
    } else {
        state.grid_count += 1;
    }
    state.statistics.steps += 1;
    Ok(())
}

fn evaluate<D: Dynamics>(
    dynamics: &mut D,
    state: &mut IntegrationState,
    t: f64,
    y: &[f64],
    memory: &mut [f64],
    dy: &mut [f64],
) -> Result<(), SolveError<D::Error>> {
    state.statistics.evaluations += 1;
    dynamics.derivative(t, y, memory, dy).map_err(SolveError::Evaluation)
}
