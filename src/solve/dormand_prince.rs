//! Dormand and Prince's explicit Runge-Kutta pair of order 5(4) with continuous output of order 4.
//!
//! Source: J.R. Dormand, P.J. Prince, J. Comp. Appl. Math. 6 (1980) 19-26; continuous output and step-size
//! controller after Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, sections II.4-II.6.

use super::{Dynamics, IntegrationState, Integrator, Scratch, SolveError};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "dormand_prince",
    summary: "adaptive explicit Runge-Kutta pair 5(4) with continuous output; `tolerance` in m and rad per step",
    reference: "Dormand, Prince, J. Comp. Appl. Math. 6 (1980) 19-26",
    parse,
};

fn parse(section: &Section) -> Result<Integrator, SettingsError> {
    let tolerance = section.positive("tolerance", Dimension::Length)?;
    if !(TOLERANCES.0..=TOLERANCES.1).contains(&tolerance) {
        return Err(section.error("tolerance", format!("found {tolerance}, expected {} to {} (m, rad)", TOLERANCES.0, TOLERANCES.1)));
    }
    Ok(Integrator::DormandPrince { tolerance })
}

/// Tolerances that make sense in double precision and for wheel/rail contact.
pub(super) const TOLERANCES: (f64, f64) = (1e-14, 1e-3);

/// Continuous output: powers 0 to 4 of theta.
pub(super) const DENSE_VECTORS: usize = 5;

const STAGES: usize = 7;
const C: [f64; STAGES] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const A: [[f64; 6]; STAGES] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Weights of order 5 minus those of order 4.
const E: [f64; STAGES] = [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// Shampine's free interpolant in Hairer's form.
const D: [f64; STAGES] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// Step-size control: safety, limits of change, and the weight of the last error (a PI controller damps the
/// alternation that stiff components would cause at the limit of stability).
const SAFETY: f64 = 0.9;
const LARGEST_GROWTH: f64 = 5.0;
const LARGEST_SHRINK: f64 = 0.2;
const BETA: f64 = 0.08;
const EXPONENT: f64 = 0.2 - 0.75 * BETA;

/// One accepted step.
pub(super) fn step<D: Dynamics>(
    tolerance: f64,
    dynamics: &mut D,
    state: &mut IntegrationState,
    scratch: &mut Scratch,
) -> Result<(), SolveError<D::Error>> {
    let n = state.y.len();
    if !state.derivative_known {
        let IntegrationState { t, y, memory, derivative, .. } = state;
        dynamics.derivative(*t, y, memory, derivative).map_err(SolveError::Evaluation)?;
        state.derivative_known = true;
        state.statistics.evaluations += 1;
    }
    if state.next_step <= 0.0 {
        state.next_step = first_step(tolerance, dynamics, state, scratch);
    }
    let limit = dynamics.next_break(state.t, &state.y, &state.memory);
    let mut h = state.next_step;
    let mut rejected = false;
    loop {
        // A rest of a step that would be tiny is split evenly instead.
        let to_limit = limit - state.t;
        let (step, end) = if h >= to_limit * (1.0 - 1e-12) {
            (to_limit, limit)
        } else if h > 0.5 * to_limit {
            (0.5 * to_limit, state.t + 0.5 * to_limit)
        } else {
            (h, state.t + h)
        };
        let smallest = 1e-12 * state.t.abs().max(1.0);
        if step < smallest && to_limit > smallest {
            return Err(SolveError::StepTooSmall { time: state.t, step, tolerance });
        }
        scratch.memory.copy_from_slice(&state.memory);
        let error = match attempt(dynamics, state, scratch, step) {
            Ok(error) => error / tolerance,
            Err(failure) => {
                state.statistics.rejected += 1;
                if step < 1e-9 * state.t.abs().max(1.0) {
                    return Err(SolveError::Evaluation(failure));
                }
                h = 0.25 * step;
                rejected = true;
                continue;
            }
        };
        // NaN must count as a rejection.
        if !(error <= 1.0) {
            state.statistics.rejected += 1;
            let factor = if error.is_finite() { SAFETY * error.powf(-0.2) } else { LARGEST_SHRINK };
            h = step * factor.clamp(LARGEST_SHRINK, 1.0);
            rejected = true;
            continue;
        }
        let error = error.max(1e-10);
        let growth = SAFETY * error.powf(-EXPONENT) * state.last_error.powf(BETA);
        let largest = if rejected { 1.0 } else { LARGEST_GROWTH };
        let proposed = step * growth.clamp(LARGEST_SHRINK, largest);
        // A step that was cut at a break says nothing against the longer one.
        state.next_step = if step < h && !rejected { proposed.max(h) } else { proposed };
        state.last_error = error.max(1e-4);
        write_dense(state, scratch, step, n);
        state.t_begin = state.t;
        state.t = end;
        state.y.copy_from_slice(&scratch.trial);
        state.memory.copy_from_slice(&scratch.memory);
        // The last stage is evaluated at the end of the step: it is the first of the next one, unless the
        // system is not smooth there.
        state.derivative.copy_from_slice(&scratch.stages[6]);
        state.derivative_known = end < limit;
        state.statistics.steps += 1;
        return Ok(());
    }
}

/// Computes all stages; the solution of order 5 is left in `scratch.trial`. Returns the largest local error of the
/// controlled components.
fn attempt<D: Dynamics>(dynamics: &mut D, state: &mut IntegrationState, scratch: &mut Scratch, h: f64) -> Result<f64, D::Error> {
    scratch.stages[0].copy_from_slice(&state.derivative);
    for stage in 1..STAGES {
        let (done, rest) = scratch.stages.split_at_mut(stage);
        let weights: [f64; 6] = std::array::from_fn(|j| h * A[stage][j]);
        for (i, value) in scratch.trial.iter_mut().enumerate() {
            let mut sum = state.y[i];
            for (weight, k) in weights.iter().zip(done.iter()) {
                sum += weight * k[i];
            }
            *value = sum;
        }
        dynamics.derivative(state.t + C[stage] * h, &scratch.trial, &mut scratch.memory, &mut rest[0])?;
        state.statistics.evaluations += 1;
    }
    let mut largest: f64 = 0.0;
    for i in 0..state.y.len() {
        let error: f64 = h * (0..STAGES).map(|j| E[j] * scratch.stages[j][i]).sum::<f64>();
        if !(error.is_finite() && scratch.trial[i].is_finite()) {
            return Ok(f64::INFINITY);
        }
        if dynamics.controlled(i) {
            largest = largest.max(error.abs());
        }
    }
    Ok(largest)
}

/// Turns Hairer's nested form of the continuous output into powers of theta.
fn write_dense(state: &mut IntegrationState, scratch: &Scratch, h: f64, n: usize) {
    for i in 0..n {
        let k = |j: usize| scratch.stages[j][i];
        let begin = state.y[i];
        let difference = scratch.trial[i] - begin;
        let bend = h * k(0) - difference;
        let r4 = difference - h * k(6) - bend;
        let r5 = h * (0..STAGES).map(|j| D[j] * k(j)).sum::<f64>();
        // y = begin + th (difference + (1-th) (bend + th (r4 + (1-th) r5)))
        let coefficients = [begin, difference + bend, -bend + r4 + r5, -r4 - 2.0 * r5, r5];
        for (power, coefficient) in coefficients.into_iter().enumerate() {
            state.dense[power * n + i] = coefficient;
        }
    }
}

/// A first step on which explicit Euler would just meet the tolerance in the controlled components: cautious, and
/// growth is quick.
fn first_step<D: Dynamics>(tolerance: f64, dynamics: &mut D, state: &mut IntegrationState, scratch: &mut Scratch) -> f64 {
    const GUESS: f64 = 1e-6;
    for (i, value) in scratch.trial.iter_mut().enumerate() {
        *value = state.y[i] + GUESS * state.derivative[i];
    }
    scratch.memory.copy_from_slice(&state.memory);
    state.statistics.evaluations += 1;
    let evaluated = dynamics.derivative(state.t + GUESS, &scratch.trial, &mut scratch.memory, &mut scratch.stages[1]);
    if evaluated.is_err() {
        return GUESS;
    }
    let second = (0..state.y.len())
        .filter(|&i| dynamics.controlled(i))
        .map(|i| ((scratch.stages[1][i] - state.derivative[i]) / GUESS).abs())
        .fold(0.0, f64::max);
    if second > 0.0 && second.is_finite() { (2.0 * tolerance / second).sqrt().clamp(GUESS, 1e-2) } else { 1e-4 }
}
