//! All that an integration remembers: cloning it saves it.

use super::response::Response;
use super::{Doubts, Implicit, Scratch, SolveError, StiffPart, Undefined};
use serde::{Deserialize, Serialize};

/// Work done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected attempts.
    pub rejected: u64,
    /// Evaluations of the right-hand side.
    pub evaluations: u64,
    /// Restarts after a jump of an input.
    pub restarts: u64,
    /// Changes of inputs that the step in hand has taken up: nothing restarted.
    pub taken_up: u64,
    /// Steps whose end was moved onto the constraints.
    pub projections: u64,
    /// Changes of the system's form.
    pub events: u64,
    /// Jacobians.
    pub linearisations: u64,
    /// Factorisations of I - a J.
    pub factorisations: u64,
    /// Newton iterations of implicit methods.
    pub iterations: u64,
}

/// Time, solution, the last step's continuous output and the step-size control.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IntegrationState {
    /// End of the last step, s.
    pub t: f64,
    /// Solution at `t`.
    pub y: Vec<f64>,
    /// Begin of the last step; equal to `t` before the first one and after a restart.
    pub(super) t_begin: f64,
    /// Continuous output over the last step: polynomial coefficients in `(time - t_begin) / (t - t_begin)` in powers
    /// of theta, lowest first, one vector after the other.
    pub(super) dense: Vec<f64>,
    /// Is a motion to be added to the continuous output ([`Implicit::add_frame_motion`])?
    pub(super) in_frame: bool,
    /// What changes of the system within the last step add to it.
    pub(super) response: Response,
    /// f(t, y), valid when `derivative_known`.
    pub(super) derivative: Vec<f64>,
    pub(super) derivative_known: bool,
    /// Does the system change its form at `t`, before the next step?
    pub(super) switch_due: bool,
    /// Length of the next step, s; 0 when it has to be found. Of fixed steps the part that is tried next after a failure, 0 else.
    pub(super) next_step: f64,
    /// Scaled error of the last accepted step, for the step-size controller.
    pub(super) last_error: f64,
    /// For fixed steps: start of the grid and the number of grid steps done.
    pub(super) grid_start: f64,
    pub(super) grid_count: u64,
    /// What a method remembers of earlier steps, a whole number of vectors; it says nothing where it is not `record_known`.
    pub(super) record: Vec<f64>,
    pub(super) record_known: bool,
    /// Steps and rejected ones when it was looked last whether time goes on, and that time, s.
    pub(super) milestone: (u64, u64, f64),
    pub statistics: Statistics,
    /// Of methods with a fixed step.
    pub doubts: Doubts,
}

impl IntegrationState {
    pub(super) fn new(t: f64, y: &[f64], dense_vectors: usize, record_vectors: usize) -> Self {
        IntegrationState {
            t,
            y: y.to_vec(),
            t_begin: t,
            dense: vec![0.0; dense_vectors * y.len()],
            in_frame: false,
            response: Response::default(),
            derivative: vec![0.0; y.len()],
            derivative_known: false,
            switch_due: false,
            next_step: 0.0,
            last_error: 1e-4,
            grid_start: t,
            grid_count: 0,
            record: vec![0.0; record_vectors * y.len()],
            record_known: false,
            milestone: (0, 0, t),
            statistics: Statistics::default(),
            doubts: Doubts::default(),
        }
    }

    /// Begin of the last step, s.
    pub fn step_begin(&self) -> f64 {
        self.t_begin
    }

    /// Writes the solution at `time`, which lies within the last step (or is `t`), to `out`.
    pub fn interpolate(&self, dynamics: &dyn Implicit, time: f64, out: &mut [f64]) {
        self.interpolate_beside(time, out, |ahead, y| dynamics.add_frame_motion(ahead, y));
    }

    /// The same; `frame` adds the moving frame so many seconds after the begin of the step.
    pub fn interpolate_beside(&self, time: f64, out: &mut [f64], frame: impl FnOnce(f64, &mut [f64])) {
        if time >= self.t || self.t_begin >= self.t {
            out.copy_from_slice(&self.y);
        } else {
            self.polynomial(time, out);
            if self.in_frame {
                frame(time - self.t_begin, out);
            }
        }
        self.response.add(time, self.t, out);
    }

    /// Does `time` lie within a step that can take up changes of the system?
    pub fn is_in_hand(&self, time: f64) -> bool {
        self.t_begin <= time && time < self.t && self.response.has_room()
    }

    fn polynomial(&self, time: f64, out: &mut [f64]) {
        let theta = (time - self.t_begin) / (self.t - self.t_begin);
        let n = self.y.len();
        let vectors = self.dense.len() / n;
        out.copy_from_slice(&self.dense[(vectors - 1) * n..]);
        for vector in (0..vectors - 1).rev() {
            for (value, coefficient) in out.iter_mut().zip(&self.dense[vector * n..(vector + 1) * n]) {
                *value = *value * theta + coefficient;
            }
        }
    }

    /// Has the last step taken up changes of the system?
    pub fn has_taken_up(&self) -> bool {
        self.response.is_there()
    }

    /// Evaluates f at the begin of a step where it is not known from the step before.
    pub(super) fn evaluate_begin(&mut self, dynamics: &mut dyn Implicit) -> Result<(), SolveError> {
        if !self.derivative_known {
            dynamics.rollback();
            self.evaluate_here(dynamics)?;
            dynamics.accept(true);
        }
        Ok(())
    }

    /// The same, starting from what the system remembers at present; it is not accepted yet.
    pub(super) fn evaluate_here(&mut self, dynamics: &mut dyn Implicit) -> Result<(), SolveError> {
        if !self.derivative_known {
            let done = dynamics.derivative_at_end(self.t, &self.y, &mut self.derivative);
            done.map_err(|Undefined| SolveError::Undefined { time: self.t })?;
            self.derivative_known = true;
            self.statistics.evaluations += 1;
        }
        Ok(())
    }

    /// Finds J at (t, y), directly after an evaluation of f there.
    pub(super) fn linearise(&mut self, dynamics: &mut dyn Implicit, part: StiffPart) -> Result<(), SolveError> {
        self.statistics.linearisations += 1;
        dynamics.linearise(self.t, &self.y, part).map_err(|Undefined| SolveError::Undefined { time: self.t })
    }

    /// Takes over the trial solution in `scratch`, and what the system remembers with it, as the solution at `end`; the stage `last` was
    /// evaluated there and serves as f of the next step.
    pub(super) fn accept(&mut self, dynamics: &mut dyn Implicit, end: f64, scratch: &Scratch, last: Option<usize>) {
        dynamics.keep_begin();
        self.t_begin = self.t;
        self.t = end;
        self.y.copy_from_slice(&scratch.trial);
        self.in_frame = false;
        if let Some(last) = last {
            self.derivative.copy_from_slice(&scratch.stages[last]);
        }
        self.derivative_known = last.is_some();
        dynamics.accept(self.derivative_known);
        self.statistics.steps += 1;
    }

    /// Begins anew from (t, y): the system or its inputs are no longer what they were before.
    pub(super) fn forget(&mut self) {
        self.derivative_known = false;
        self.record_known = false;
    }

    /// Evaluates f at the begin of a step so that what the evaluation leaves in the system for [`Implicit::linearise`] is there. It is
    /// not part of the state: where it is gone the evaluation is repeated to the bit (and not counted, so that counters do not tell
    /// whether a state was restored).
    pub(super) fn evaluate_with_cache(&mut self, dynamics: &mut dyn Implicit) -> Result<(), SolveError> {
        if !self.derivative_known {
            return self.evaluate_begin(dynamics);
        }
        if !dynamics.is_cached() {
            let done = dynamics.repeat(self.t, &self.y, &mut self.derivative);
            done.map_err(|Undefined| SolveError::Undefined { time: self.t })?;
        }
        Ok(())
    }

    /// Takes the solution back to `time` within the last step and starts anew there, because the system changes; `frame` as in
    /// [`IntegrationState::interpolate_beside`].
    /// Step-size control is kept: a jump of an input rarely changes the scale of the solution.
    pub fn restart_at(&mut self, time: f64, frame: impl FnOnce(f64, &mut [f64])) {
        let fresh = time == self.t && self.t_begin == self.t && !self.derivative_known;
        if fresh {
            return;
        }
        if time < self.t || self.response.is_there() {
            let mut y = std::mem::take(&mut self.derivative);
            self.interpolate_beside(time, &mut y, frame);
            std::mem::swap(&mut self.y, &mut y);
            self.derivative = y;
        }
        self.response.clear();
        // An event here or beyond will be met again if it still takes place.
        self.switch_due = false;
        self.t = time;
        self.t_begin = time;
        self.milestone = (self.statistics.steps, self.statistics.rejected, time);
        self.forget();
        self.grid_start = time;
        self.grid_count = 0;
        self.statistics.restarts += 1;
    }

    /// Could this state have come from the same system and method as `other`?
    pub fn fits(&self, other: &IntegrationState) -> bool {
        self.y.len() == other.y.len()
            && self.dense.len() == other.dense.len()
            && self.response.fits(&other.response)
            && self.derivative.len() == other.derivative.len()
            && self.record.len() == other.record.len()
    }
}
