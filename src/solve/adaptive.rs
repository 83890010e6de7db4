//! Step-size control shared by the adaptive one-step pairs.
//!
//! A proportional-integral controller after Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.4;
//! the error is the largest local error of the controlled components.

use super::{Dynamics, IntegrationState, Scratch, SolveError, Undefined};

/// Step-size control: safety, limits of change, and the weight of the last error (a PI controller damps the
/// alternation that stiff components would cause at the limit of stability).
const SAFETY: f64 = 0.85;
const LARGEST_GROWTH: f64 = 5.0;
const LARGEST_SHRINK: f64 = 0.2;
const BETA: f64 = 0.08;

/// Tolerances that a scene or a master may set: below, rounding decides; above, errors are no longer small against what a
/// vehicle does on its rails, and time is not saved, because stability limits the step.
pub(super) const TOLERANCES: (f64, f64) = (1e-15, 1e-5);

/// A pair of one-step methods of neighbouring orders.
pub(super) trait Pair {
    /// The local error estimate falls like h^ORDER.
    const ORDER: i32;
    /// Index of the stage that is f at the end of the step and so the first one of the next step; `None` where there is no such.
    const LAST_STAGE: Option<usize>;

    /// What a step needs besides f at its begin, once for all attempts at it.
    fn prepare(&self, dynamics: &mut dyn Dynamics, state: &mut IntegrationState) -> Result<(), SolveError> {
        state.evaluate_begin(dynamics)
    }

    /// Computes all stages; the solution is left in `scratch.trial`. Returns the largest local error of the controlled
    /// components, infinity when a number is not finite.
    fn attempt(&self, dynamics: &mut dyn Dynamics, state: &mut IntegrationState, scratch: &mut Scratch, h: f64) -> Result<f64, Undefined>;

    /// Writes the continuous output of a step that was accepted.
    fn write_dense(&self, state: &mut IntegrationState, scratch: &Scratch, h: f64);
}

/// One accepted step.
pub(super) fn step<P: Pair>(
    pair: &P,
    tolerance: f64,
    dynamics: &mut dyn Dynamics,
    state: &mut IntegrationState,
    scratch: &mut Scratch,
) -> Result<(), SolveError> {
    let exponent = 1.0 / f64::from(P::ORDER) - 0.75 * BETA;
    if state.next_step <= 0.0 {
        state.evaluate_begin(dynamics)?;
        state.next_step = first_step(tolerance, dynamics, state, scratch);
    }
    pair.prepare(dynamics, state)?;
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
        let error = match pair.attempt(dynamics, state, scratch, step) {
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
            let factor = if error.is_finite() { SAFETY * error.powf(-1.0 / f64::from(P::ORDER)) } else { LARGEST_SHRINK };
            h = step * factor.clamp(LARGEST_SHRINK, 1.0);
            rejected = true;
            continue;
        }
        let error = error.max(1e-10);
        let growth = SAFETY * error.powf(-exponent) * state.last_error.powf(BETA);
        let largest = if rejected { 1.0 } else { LARGEST_GROWTH };
        let proposed = step * growth.clamp(LARGEST_SHRINK, largest);
        // A step that was cut at a break says nothing against the longer one, unless its own error was large.
        let cut = step < h && !rejected && proposed >= step;
        state.next_step = if cut { proposed.max(h) } else { proposed };
        state.last_error = error.max(1e-4);
        pair.write_dense(state, scratch, step);
        // A stage at the end of the step is the first of the next one, unless the system is not smooth there.
        state.accept(end, scratch, P::LAST_STAGE.filter(|_| end < limit));
        return Ok(());
    }
}

/// A step shorter than this [s] that fails is hopeless: the fastest motion (contact, 200 Hz) takes milliseconds.
const SHORTEST: f64 = 1e-11;

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
        .map(|i| dynamics.error_weight(i) * ((scratch.stages[1][i] - state.derivative[i]) / GUESS).abs())
        .fold(0.0, f64::max);
    if second > 0.0 && second.is_finite() { (2.0 * tolerance / second).sqrt().clamp(GUESS, 1e-2) } else { 1e-4 }
}
