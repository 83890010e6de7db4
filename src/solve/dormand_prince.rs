//! Dormand and Prince's explicit Runge-Kutta pair of order 5(4) with continuous output of order 4.
//!
//! Source: J.R. Dormand, P.J. Prince, J. Comp. Appl. Math. 6 (1980) 19-26; continuous output and step-size
//! controller after Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, sections II.4-II.6.

use super::{Dynamics, IntegrationState, Integrator, Scratch, Setting, SettingKind, SolveError, Undefined, parse_setting};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "dormand_prince",
    summary: "adaptive explicit Runge-Kutta pair 5(4) with continuous output; `tolerance` in m and rad per step",
    reference: "Dormand, Prince, J. Comp. Appl. Math. 6 (1980) 19-26",
    parse,
};

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    let tolerance = parse_setting(section, "tolerance", Dimension::Length, TOLERANCES)?;
    Ok(Arc::new(DormandPrince { tolerance }))
}

/// The adaptive pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DormandPrince {
    /// Bound of the local error of each controlled component per step, m and rad.
    pub tolerance: f64,
}

/// Below, rounding decides. Above, the error is no longer small against the penetration of a loaded wheel (0.07 mm) and
/// wheel loads swing: at 1e-6 by up to 9 % in the scene `suspended_wheelset`, at 1e-7 by 1 %. A looser tolerance would
/// not be faster, because stability limits the step.
const TOLERANCES: (f64, f64) = (1e-14, 1e-6);

/// Continuous output: powers 0 to 4 of theta.
const DENSE_VECTORS: usize = 5;

impl Integrator for DormandPrince {
    fn setting(&self) -> Setting {
        Setting { kind: SettingKind::Tolerance, value: self.tolerance, range: TOLERANCES }
    }

    fn with_setting(&self, tolerance: f64) -> Arc<dyn Integrator> {
        Arc::new(DormandPrince { tolerance })
    }

    fn dense_vectors(&self) -> usize {
        DENSE_VECTORS
    }

    fn step(&self, dynamics: &mut dyn Dynamics, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        step(self.tolerance, dynamics, state, scratch)
    }
}

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
fn step(tolerance: f64, dynamics: &mut dyn Dynamics, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
    let n = state.y.len();
    state.evaluate_begin(dynamics)?;
    if state.next_step <= 0.0 {
        state.next_step = first_step(tolerance, dynamics, state, scratch);
    }
    let limit = dynamics.next_break(state.t, &state.y, &state.memory);
    let mut h = state.next_step;
    let mut rejected = false;
    loop {
        // A rest of a step that would be tiny is split evenly instead.
        let to_limit = limit - state.t;
        let end = if h >= to_limit * (1.0 - 1e-12) {
            limit
        } else if h > 0.5 * to_limit {
            state.t + 0.5 * to_limit
        } else {
            state.t + h
        };
        // What rounding of time leaves of the step.
        let step = end - state.t;
        if !(step > 0.0) {
            return Err(SolveError::NoProgress { time: state.t, step: h });
        }
        scratch.memory.copy_from_slice(&state.memory);
        let error = match attempt(dynamics, state, scratch, step) {
            Ok(error) => error / tolerance,
            Err(Undefined) => {
                state.statistics.rejected += 1;
                if step < SHORTEST {
                    return Err(SolveError::Undefined { time: state.t });
                }
                h = 0.25 * step;
                rejected = true;
                continue;
            }
        };
        // NaN must count as a rejection.
        if !(error <= 1.0) {
            state.statistics.rejected += 1;
            if step < SHORTEST {
                return Err(SolveError::StepTooSmall { time: state.t, step, tolerance });
            }
            let factor = if error.is_finite() { SAFETY * error.powf(-0.2) } else { LARGEST_SHRINK };
            h = step * factor.clamp(LARGEST_SHRINK, 1.0);
            rejected = true;
            continue;
        }
        let error = error.max(1e-10);
        let growth = SAFETY * error.powf(-EXPONENT) * state.last_error.powf(BETA);
        let largest = if rejected { 1.0 } else { LARGEST_GROWTH };
        let proposed = step * growth.clamp(LARGEST_SHRINK, largest);
        // A step that was cut at a break says nothing against the longer one, unless its own error was large.
        let cut = step < h && !rejected && proposed >= step;
        state.next_step = if cut { proposed.max(h) } else { proposed };
        state.last_error = error.max(1e-4);
        write_dense(state, scratch, step, n);
        // The last stage is evaluated at the end of the step: it is the first of the next one, unless the
        // system is not smooth there.
        state.accept(end, scratch, 6, end < limit);
        return Ok(());
    }
}

/// A step shorter than this [s] that fails is hopeless: the fastest motion (contact, 200 Hz) takes milliseconds.
const SHORTEST: f64 = 1e-11;

/// Computes all stages; the solution of order 5 is left in `scratch.trial`. Returns the largest local error of the
/// controlled components.
fn attempt(dynamics: &mut dyn Dynamics, state: &mut IntegrationState, scratch: &mut Scratch, h: f64) -> Result<f64, Undefined> {
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
fn first_step(tolerance: f64, dynamics: &mut dyn Dynamics, state: &mut IntegrationState, scratch: &mut Scratch) -> f64 {
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
