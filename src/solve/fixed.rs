//! Fixed steps.
//!
//! Steps stand on the grid `start + k step`; a step that would pass a point where the system is not smooth is shortened to end
//! there, and the grid starts anew.

use super::{Dynamics, IntegrationState, Scratch, SolveError};

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
}

impl FixedStep {
    /// The step that is next on the grid with whole steps of `step` [s].
    pub fn next(step: f64, dynamics: &dyn Dynamics, state: &IntegrationState) -> Result<Self, SolveError> {
        let limit = dynamics.next_break(state.t, &state.y, &state.memory);
        let next = state.grid_start + (state.grid_count + 1) as f64 * step;
        let cut = next >= limit - SLACK * step;
        let end = if cut { limit } else { next };
        let h = end - state.t;
        if h > 0.0 { Ok(FixedStep { end, h, cut, partial: false, step }) } else { Err(SolveError::NoProgress { time: state.t, step }) }
    }

    /// The first part of this step; the rest is a step of its own. `None` where that would be too short to help.
    pub fn shortened(&self, state: &IntegrationState) -> Option<Self> {
        const FRACTION: f64 = 0.25;
        const SHORTEST: f64 = 1e-3;
        let end = state.t + FRACTION * self.h;
        let h = end - state.t;
        (h > SHORTEST * self.step).then_some(FixedStep { end, h, cut: false, partial: true, ..*self })
    }

    /// The failure of an evaluation in this step.
    pub fn undefined(state: &IntegrationState) -> SolveError {
        SolveError::Undefined { time: state.t }
    }

    /// Refuses a solution that is not finite.
    pub fn check(&self, state: &IntegrationState, scratch: &Scratch) -> Result<(), SolveError> {
        let finite = scratch.trial.iter().all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(SolveError::NotFinite { time: state.t, step: self.step }) }
    }

    /// Ends the step with the solution in `scratch.trial`; the stage `last` is f there.
    pub fn accept(&self, state: &mut IntegrationState, scratch: &Scratch, last: Option<usize>) {
        state.accept(self.end, scratch, last.filter(|_| !self.cut));
        if self.cut {
            state.grid_start = self.end;
            state.grid_count = 0;
            state.record_known = false;
        } else if !self.partial {
            state.grid_count += 1;
        }
    }
}
