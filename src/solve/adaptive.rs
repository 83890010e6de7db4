//! Step-size control shared by the adaptive one-step pairs.
//!
//! A proportional-integral controller after Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.4;
//! the error is the largest local error of the controlled components.

use super::local_error::{END, LocalError, WORK};
use super::moving_frame::MovingFrame;
use super::stability::Explicit;
use super::{Implicit, IntegrationState, Scratch, SolveError, Undefined, integrals, stability};

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
pub(super) trait StepPair {
    /// The local error estimate falls like h^ORDER.
    const ORDER: i32;
    /// Index of the stage that is f at the end of the step and so the first one of the next step; `None` where there is no such.
    const LAST_STAGE: Option<usize>;

    /// What a step needs besides f at its begin, once for all attempts at it.
    fn prepare(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, frame: &mut MovingFrame) -> Result<(), SolveError> {
        state.evaluate_with_cache(dynamics)?;
        frame.note(dynamics, state);
        Ok(())
    }

    /// What it is explicit in.
    fn explicitly(&self) -> Explicit;

    /// Does [`StepPair::check`] see what no stage has seen?
    const CHECKED: bool = false;

    /// Computes all stages; the solution is left in `scratch.trial`. Returns the local error.
    fn attempt(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        h: f64,
    ) -> Result<LocalError, Undefined>;

    /// Error of a step by f at its end, which is in `scratch.stages[END]`.
    fn check(&self, _dynamics: &mut dyn Implicit, _scratch: &mut Scratch, _h: f64) -> LocalError {
        LocalError::default()
    }

    /// Writes the continuous output of a step that was accepted.
    fn write_dense(&self, state: &mut IntegrationState, scratch: &Scratch, h: f64);
}

/// One accepted step, its end on the constraints and looked at for events.
///
/// An attempt is judged three times: by the pair's own estimate; by whether its end can be moved onto the constraints and evaluated;
/// and, where no stage stands at the end ([`StepPair::CHECKED`]), by what f there says of the step. Each of them may ask for a shorter one.
pub(super) fn step<P: StepPair>(
    pair: &P,
    tolerance: f64,
    dynamics: &mut dyn Implicit,
    state: &mut IntegrationState,
    scratch: &mut Scratch,
) -> Result<(), SolveError> {
    let exponent = 1.0 / f64::from(P::ORDER) - 0.75 * BETA;
    if state.next_step <= 0.0 {
        state.evaluate_begin(dynamics)?;
        state.next_step = first_step(tolerance, dynamics, state, scratch);
    }
    pair.prepare(dynamics, state, &mut scratch.frame)?;
    let limit = dynamics.next_break(state.t, &state.y);
    let mut h = state.next_step.min(dynamics.longest_step(&state.derivative));
    h = stability::bounded(h, pair.explicitly(), dynamics.fastest_vibration());
    let mut rejected = false;
    loop {
        let end = end_of_step(state.t, h, limit);
        // What rounding of time leaves of the step.
        let step = end - state.t;
        if !(step > 0.0) {
            return Err(SolveError::NoProgress { time: state.t, step: h });
        }
        dynamics.rollback();
        scratch.looks.begin(dynamics, state.t);
        let judged = pair.attempt(dynamics, state, scratch, step).and_then(|error| {
            let error = error.over(tolerance);
            // NaN must count as a rejection.
            if error <= 1.0 {
                finish(pair, dynamics, state, scratch, end, step, tolerance).map(|end| (error, end))
            } else {
                Ok((error, End::default()))
            }
        });
        let (error, ending) = match judged {
            Ok(judged) => judged,
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
        let worst = if ending.error > 1.0 { ending.error } else { error };
        if !(worst <= 1.0) {
            state.statistics.rejected += 1;
            if step < SHORTEST {
                return Err(SolveError::StepTooSmall { time: state.t, step, tolerance });
            }
            let factor = if worst.is_finite() { SAFETY * worst.powf(-1.0 / f64::from(P::ORDER)) } else { LARGEST_SHRINK };
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
        if P::CHECKED {
            integrals::keep_rates(dynamics, state, scratch);
        }
        state.accept(dynamics, end, scratch, ending.stage.filter(|_| end < limit));
        look_back(dynamics, state, scratch, &ending)?;
        if P::CHECKED {
            integrals::integrate(dynamics, state, scratch);
        }
        return goes_on(state);
    }
}

/// Steps after which it is looked whether time goes on, and the least mean step, s: below the first a run would take days; below the second where
/// every other step is rejected, as it is where the solution runs along a jump of its forces and steps become as short as the tolerance.
const MILE: u64 = 2000;
const LEAST: f64 = 2e-9;
const LEAST_WITH_REJECTIONS: f64 = 1e-7;

/// Ends an integration that crawls.
fn goes_on(state: &mut IntegrationState) -> Result<(), SolveError> {
    let (steps, rejected, since) = state.milestone;
    let made = state.statistics.steps - steps;
    if made < MILE {
        return Ok(());
    }
    let (rejected, span) = (state.statistics.rejected - rejected, state.t - since);
    state.milestone = (state.statistics.steps, state.statistics.rejected, state.t);
    let mean = span / made as f64;
    let chatters = 2 * rejected > made && mean < LEAST_WITH_REJECTIONS;
    if mean < LEAST || chatters { Err(SolveError::Crawls { time: state.t, steps: made, rejected, span }) } else { Ok(()) }
}

/// Where a step of length `h` from `t` on ends before a limit: a rest that would be tiny is split evenly instead.
fn end_of_step(t: f64, h: f64, limit: f64) -> f64 {
    let to_limit = limit - t;
    if h >= to_limit * (1.0 - 1e-12) {
        limit
    } else if h > 0.5 * to_limit {
        t + 0.5 * to_limit
    } else {
        t + h
    }
}

/// Looks at a step that has just been accepted: does an event end it?
fn look_back(dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch, ending: &End) -> Result<(), SolveError> {
    state.statistics.projections += u64::from(ending.moved);
    dynamics.note_step(state.t, &state.y);
    scratch.frame.keep(dynamics, state);
    let found = if ending.beyond { state.cut_at_event(dynamics, scratch, 1.0) } else { state.look_within(dynamics, scratch) };
    if found.is_err() {
        state.take_back();
        // Too short a step to be tried again: the form itself has no solution further on.
        return if state.next_step < super::events::SHORTEST_RETRY { found } else { Ok(()) };
    }
    Ok(())
}

/// What the end of an attempt showed.
#[derive(Clone, Copy, Debug, Default)]
struct End {
    /// The stage that is f there.
    stage: Option<usize>,
    /// Was it moved onto the constraints?
    moved: bool,
    /// Does it lie beyond an event?
    beyond: bool,
    /// Of the check, in parts of what is allowed.
    error: f64,
}

/// Moves the end of an attempt onto the constraints, evaluates f there where that is needed, and checks the step by it.
fn finish<P: StepPair>(
    pair: &P,
    dynamics: &mut dyn Implicit,
    state: &mut IntegrationState,
    scratch: &mut Scratch,
    end: f64,
    h: f64,
    tolerance: f64,
) -> Result<End, Undefined> {
    scratch.stages[WORK].copy_from_slice(&scratch.trial);
    let moved = dynamics.project(end, &mut scratch.trial)?;
    if !moved {
        // What rounding did counts as nothing: f was evaluated without it.
        scratch.trial.copy_from_slice(&scratch.stages[WORK]);
    }
    let mut stage = P::LAST_STAGE.filter(|_| !moved);
    if stage.is_none() && (P::CHECKED || !scratch.looks.is_empty()) {
        state.statistics.evaluations += 1;
        dynamics.derivative_at_end(end, &scratch.trial, &mut scratch.stages[END])?;
        stage = Some(END);
    }
    let beyond = scratch.looks.end(dynamics, end);
    // At an event f changes its form: what it says there is no error.
    let error = if P::CHECKED && !beyond { pair.check(dynamics, scratch, h).over(tolerance) } else { 0.0 };
    Ok(End { stage, moved, beyond, error: if error.is_nan() { f64::INFINITY } else { error } })
}

/// A step shorter than this [s] that fails is hopeless: the fastest motion (contact, 200 Hz) takes milliseconds.
const SHORTEST: f64 = 1e-11;

/// A first step on which explicit Euler would just meet the tolerance in the controlled components: cautious, and
/// growth is quick.
fn first_step(tolerance: f64, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> f64 {
    const GUESS: f64 = 1e-6;
    for (i, value) in scratch.trial.iter_mut().enumerate() {
        *value = state.y[i] + GUESS * state.derivative[i];
    }
    dynamics.rollback();
    state.statistics.evaluations += 1;
    let evaluated = dynamics.derivative(state.t + GUESS, &scratch.trial, &mut scratch.stages[1]);
    dynamics.rollback();
    if evaluated.is_err() {
        return GUESS;
    }
    let second = (0..state.y.len())
        .map(|i| dynamics.error_weight(i) * ((scratch.stages[1][i] - state.derivative[i]) / GUESS).abs())
        .fold(0.0, f64::max);
    if second > 0.0 && second.is_finite() { (2.0 * tolerance / second).sqrt().clamp(GUESS, 1e-2) } else { 1e-4 }
}
