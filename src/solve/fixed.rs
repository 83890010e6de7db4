//! Fixed steps.
//!
//! Steps stand on the grid `start + k step`; a step that would pass a point where the system is not smooth is shortened to end
//! there, and the grid starts anew.
//!
//! A fixed step has no error control, but it has an error. Each method estimates its own from f at the end of the step, which is the begin of the
//! next one, and [`FixedStep::judge`] compares it with what adaptive methods would allow: from [`DOUBTFUL`] times that on a step counts as
//! doubtful ([`super::Doubts`], which whoever runs the simulation reports), from [`WRONG`] times on, or
//! after [`LASTING`] doubtful steps on end, the run ends there and says so. So does a step
//! that is too long to see what the system has ahead of it.

use super::local_error::{END, LocalError, WORK};
use super::{Implicit, IntegrationState, Scratch, SolveError};

/// From so many times what the system allows of forces on, and from [`Dynamics::doubtful_error`] of positions, a step is doubtful.
const DOUBTFUL: f64 = 10.0;
/// From so many times that on it is wrong.
const WRONG: f64 = 10.0;
/// So many doubtful steps on end are no disturbance that passes: the step is too long for the motion.
const LASTING: u64 = 30;
/// Wheels ring on their contacts for some periods of a few steps each, and errors of steps add up: those of so many steps ...
const RINGING: f64 = 16.0;
/// ... are doubtful where they come to so many times what the system allows of forces. (Behind a jump of curvature 7.7 % of a wheel load were lost at
/// steps of 1 ms, none of which was off by more than 5 times that.)
const DOUBTFUL_TOGETHER: f64 = 15.0;
/// A step may be so many times as long as an adaptive one would be before what lies ahead.
const AHEAD: f64 = 2.0;

/// Least part of a step that is tried where it fails, and the parts at most: ten halvings, and what was left each time.
const SHORTEST_PART: f64 = 1e-3;
pub(super) const MOST_PARTS: usize = 20;

/// Steps that end in this life, s.
pub(super) const STEPS: (f64, f64) = (1e-8, 1.0);

/// A step nearer to its end than this fraction of itself has reached it.
pub(super) const SLACK: f64 = 1e-9;

/// The next step on the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct FixedStep {
    /// Its end, s.
    pub end: f64,
    /// Its length, s.
    pub h: f64,
    /// Does it end where the system is not smooth?
    pub cut: bool,
    /// Does it end before the next place of the grid?
    partial: bool,
    /// Length of a whole step, s.
    step: f64,
    /// Where the grid starts, and the steps done on it.
    grid: (f64, u64),
}

impl FixedStep {
    /// The step that is next on the grid with whole steps of `step` [s]; a part of it after one that failed.
    pub fn next(step: f64, dynamics: &dyn Implicit, state: &IntegrationState) -> Result<Self, SolveError> {
        let known = dynamics.longest_known();
        if step > AHEAD * known {
            return Err(SolveError::StepPassesTrack { time: state.t, step, longest: AHEAD * known });
        }
        let limit = dynamics.next_break(state.t, &state.y);
        let next = state.grid_start + (state.grid_count + 1) as f64 * step;
        let cut = next >= limit - SLACK * step;
        let end = if cut { limit } else { next };
        let part = state.t + state.next_step;
        let partial = state.next_step > 0.0 && part < end - SLACK * step;
        let end = if partial { part } else { end };
        let h = end - state.t;
        let grid = (state.grid_start, state.grid_count);
        if h > 0.0 {
            Ok(FixedStep { end, h, cut: cut && !partial, partial, step, grid })
        } else {
            Err(SolveError::NoProgress { time: state.t, step })
        }
    }

    /// After a failure of this step, which has left the state as it was: half of it is tried next, and what is left then is a step of its own. So the
    /// place where a solution ends is found to a thousandth of a step.
    ///
    /// # Errors
    /// The failure, where a shorter step would not help.
    pub fn failed(&self, state: &mut IntegrationState, error: SolveError) -> Result<(), SolveError> {
        let half = 0.5 * self.h;
        let helps = matches!(error, SolveError::Undefined { .. } | SolveError::NotConverged { .. }) && half > SHORTEST_PART * self.step;
        (state.grid_start, state.grid_count) = self.grid;
        state.next_step = if helps { half } else { 0.0 };
        if helps { Ok(()) } else { Err(error) }
    }

    /// The same for an evaluation that failed within the step.
    pub fn undefined(&self, state: &mut IntegrationState) -> Result<(), SolveError> {
        state.statistics.rejected += 1;
        self.failed(state, SolveError::Undefined { time: state.t })
    }

    /// Refuses a solution that is not finite.
    pub fn check(&self, state: &IntegrationState, scratch: &Scratch) -> Result<(), SolveError> {
        let finite = scratch.trial.iter().all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(SolveError::NotFinite { time: state.t, step: self.step }) }
    }

    /// Completes the step that was just accepted (constraints, events) and evaluates f at its end, for [`FixedStep::judge`]; it is then in
    /// `scratch.stages[END]`. False where an event has cut the step, or where it was taken back to be tried in parts: what is left of it says nothing of
    /// its error.
    pub fn complete(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<bool, SolveError> {
        if let Err(error) = state.complete(dynamics, scratch) {
            return self.failed(state, error).map(|()| false);
        }
        state.next_step = 0.0;
        if state.switch_due {
            return Ok(false);
        }
        state.evaluate_begin(dynamics)?;
        dynamics.note_step(state.t, &state.y);
        scratch.stages[END].copy_from_slice(&state.derivative);
        Ok(true)
    }

    /// Judges the step that was just accepted by its error, which is in `scratch.stages[WORK]`.
    pub fn judge(&self, dynamics: &dyn Implicit, state: &mut IntegrationState, scratch: &Scratch) -> Result<(), SolveError> {
        let error = LocalError::unweighted(dynamics, &scratch.stages[WORK]);
        let limit = |times: f64| LocalError { state: times * dynamics.doubtful_error(), load: times * DOUBTFUL, swing: f64::INFINITY };
        let together = state.doubts.together * (1.0 - 1.0 / RINGING) + error.load;
        let doubtful = error.reaches(&limit(1.0)) || together >= DOUBTFUL_TOGETHER;
        state.doubts.together = together;
        state.doubts.run = if error.reaches(&limit(1.0)) { state.doubts.run + 1 } else { 0 };
        if error.reaches(&limit(WRONG)) || state.doubts.run >= LASTING {
            return Err(SolveError::StepTooLong { time: state.t, step: self.h, position: error.state, load: error.load });
        }
        if doubtful {
            let doubts = &mut state.doubts;
            if doubts.steps == 0 {
                doubts.first = state.t;
            }
            doubts.steps += 1;
            (doubts.load, doubts.position) = (doubts.load.max(error.load), doubts.position.max(error.state));
            doubts.lasting_load = doubts.lasting_load.max(together);
        }
        Ok(())
    }

    /// Ends the step with the solution in `scratch.trial`; the stage `last` is f there.
    pub fn accept(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &Scratch, last: Option<usize>) {
        state.accept(dynamics, self.end, scratch, last.filter(|_| !self.cut));
        if self.cut {
            state.grid_start = self.end;
            state.grid_count = 0;
            state.record_known = false;
        } else if !self.partial {
            state.grid_count += 1;
        }
    }
}
