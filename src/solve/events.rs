//! What happens at the end of a step: projection, and events between the ends of the step.
//!
//! An event is where one of [`Dynamics::event_values`] falls below zero. It is located on the continuous output of the step; the step is cut
//! there, and the system changes its form when the next step begins. So a solution that is read before the event is that of
//! the old form, and a restart before it (a jump of an input) undoes it.

use super::{Implicit, IntegrationState, Scratch, SolveError, Undefined};

/// An event is located to this fraction of the step, and never finer than rounding of time.
const RESOLUTION: f64 = 1e-12;
const ITERATIONS: usize = 60;
/// How often a step is halved to find a value above zero.
const LOOKS: i32 = 12;
/// Evaluations that finding an event may take; each further one that lies before it in the same step takes up to [`LOOKS`] + 1 more.
pub(super) const MOST_LOOKS: usize = ITERATIONS + LOOKS as usize + 2;
/// More changes of form at one time are a contradiction of the system's.
const MOST_CHANGES: usize = 100;
/// A step that cannot be completed is tried again shorter, down to this, s.
pub(super) const SHORTEST_RETRY: f64 = 1e-9;

impl IntegrationState {
    /// Adds the response to the end of the last step, where the next one begins.
    pub(super) fn settle(&mut self, dynamics: &mut dyn Implicit) -> Result<(), SolveError> {
        if !self.response.is_there() {
            return Ok(());
        }
        self.response.add(self.t, self.t, &mut self.y);
        self.response.clear();
        self.t_begin = self.t;
        self.forget();
        dynamics.rollback();
        let done = dynamics.project(self.t, &mut self.y);
        dynamics.rollback();
        done.map(|_| ()).map_err(|Undefined| SolveError::Undefined { time: self.t })
    }

    /// Changes the system's form as often as that is due before the next step: events that ended the last step, events that a
    /// jump of an input has brought about, and those that follow from them at the same time. Where the new form has no solution the state stays in the
    /// old one, in which it can be read.
    pub(super) fn begin(&mut self, dynamics: &mut dyn Implicit, scratch: &mut Scratch) -> Result<(), SolveError> {
        self.settle(dynamics)?;
        dynamics.rollback();
        let mut changes = 0;
        loop {
            if self.switch_due || !scratch.looks.is_empty() || dynamics.due(self.t).is_some() {
                // What changes is decided from an evaluation at this very state.
                if let Err(error) = self.evaluate_here(dynamics) {
                    if changes == 0 {
                        return Err(error);
                    }
                    self.refuse(dynamics, scratch, error)?;
                    changes = 0;
                    continue;
                }
                if changes == 0 {
                    dynamics.accept(true);
                }
            }
            let Some(event) = dynamics.due(self.t) else { break };
            if changes == 0 {
                scratch.trial.copy_from_slice(&self.y);
            }
            match dynamics.on_event(event, self.t, &mut self.y) {
                Err(Undefined) => {
                    self.refuse(dynamics, scratch, SolveError::Undefined { time: self.t })?;
                    changes = 0;
                    continue;
                }
                // It was only tried: that belongs to the state.
                Ok(false) if changes == 0 => dynamics.accept(true),
                Ok(false) => {}
                Ok(true) if changes == MOST_CHANGES => {
                    self.put_back(dynamics, scratch);
                    return Err(SolveError::EndlessEvents { time: self.t });
                }
                Ok(true) => {
                    changes += 1;
                    self.t_begin = self.t;
                    self.forget();
                    self.statistics.events += 1;
                }
            }
            self.switch_due = false;
        }
        if changes > 0 {
            dynamics.accept(self.derivative_known);
        }
        self.switch_due = false;
        Ok(())
    }

    /// Back to the form that was accepted and the solution that is kept in `scratch.trial`.
    fn put_back(&mut self, dynamics: &mut dyn Implicit, scratch: &Scratch) {
        self.y.copy_from_slice(&scratch.trial);
        dynamics.rollback();
        self.forget();
    }

    /// The form that changes have led to has no solution: back to the old one, without those that need not be. The failure where all of them must be.
    fn refuse(&mut self, dynamics: &mut dyn Implicit, scratch: &Scratch, error: SolveError) -> Result<(), SolveError> {
        self.put_back(dynamics, scratch);
        if !dynamics.refuse(self.t) {
            return Err(error);
        }
        dynamics.accept(false);
        self.switch_due = true;
        Ok(())
    }

    /// After a step that failed because the system is not defined, or not smooth, further on: asks for another form of it, which has a
    /// solution.
    pub(super) fn release(&mut self, dynamics: &mut dyn Implicit, scratch: &mut Scratch, error: SolveError) -> Result<bool, SolveError> {
        let (SolveError::Undefined { .. } | SolveError::StepTooSmall { .. }) = error else { return Ok(false) };
        dynamics.rollback();
        scratch.trial.copy_from_slice(&self.y);
        // The new form may have no solution either until more of it has changed.
        for _ in 0..MOST_CHANGES {
            match dynamics.release(self.t, &mut self.y) {
                Ok(true) => {}
                Ok(false) => break,
                Err(Undefined) => {
                    self.put_back(dynamics, scratch);
                    return Err(SolveError::Undefined { time: self.t });
                }
            }
            self.t_begin = self.t;
            self.forget();
            self.next_step = 0.0;
            self.statistics.events += 1;
            if self.evaluate_here(dynamics).is_ok() {
                dynamics.accept(true);
                return Ok(true);
            }
        }
        self.put_back(dynamics, scratch);
        Ok(false)
    }

    /// Completes an accepted step: moves its end onto the constraints, and cuts it where the system changes its form. A step that
    /// cannot be completed is taken back.
    pub(super) fn complete(&mut self, dynamics: &mut dyn Implicit, scratch: &mut Scratch) -> Result<(), SolveError> {
        let done = self.try_complete(dynamics, scratch);
        if done.is_err() {
            self.take_back();
        }
        done
    }

    /// Takes the last step back: the next one is shorter.
    pub(super) fn take_back(&mut self) {
        let count = self.y.len();
        self.y.copy_from_slice(&self.dense[..count]);
        // The step that was taken back may have asked for a longer one already.
        self.next_step = 0.25 * self.next_step.min(self.t - self.t_begin);
        self.t = self.t_begin;
        self.grid_start = self.t;
        self.grid_count = 0;
        self.forget();
        self.statistics.rejected += 1;
    }

    fn try_complete(&mut self, dynamics: &mut dyn Implicit, scratch: &mut Scratch) -> Result<(), SolveError> {
        self.project(dynamics, scratch)?;
        if scratch.looks.is_empty() {
            return Ok(());
        }
        self.evaluate_begin(dynamics)?;
        if scratch.looks.end(dynamics, self.t) { self.cut_at_event(dynamics, scratch, 1.0) } else { self.look_within(dynamics, scratch) }
    }

    fn project(&mut self, dynamics: &mut dyn Implicit, scratch: &Scratch) -> Result<(), SolveError> {
        if dynamics.project(self.t, &mut self.y).map_err(|Undefined| SolveError::Undefined { time: self.t })? {
            self.derivative_known = false;
            self.statistics.projections += 1;
        } else {
            // What rounding did counts as nothing: f was evaluated without it.
            self.y.copy_from_slice(&scratch.trial);
        }
        dynamics.accept(self.derivative_known);
        Ok(())
    }

    /// Looks within the last step, whose end is on this side of any event, where one of its stages lay beyond one or an event function may have dipped
    /// below zero: the continuous output tells whether the solution itself did.
    pub(super) fn look_within(&mut self, dynamics: &mut dyn Implicit, scratch: &mut Scratch) -> Result<(), SolveError> {
        let Some(time) = scratch.looks.doubt().filter(|time| *time > self.t_begin && *time < self.t) else { return Ok(()) };
        let theta = (time - self.t_begin) / (self.t - self.t_begin);
        if self.look(dynamics, scratch, theta)? { self.cut_at_event(dynamics, scratch, theta) } else { Ok(()) }
    }

    /// Ends the last step where the first event function falls below zero before the fraction `until` of it, at which their values are in
    /// `scratch.looks`.
    pub(super) fn cut_at_event(&mut self, dynamics: &mut dyn Implicit, scratch: &mut Scratch, until: f64) -> Result<(), SolveError> {
        let mut high = until;
        let mut looks = 0;
        scratch.at_event.copy_from_slice(&scratch.looks.values);
        // Each time for the functions that are below zero at the event found last: one of them may have been so earlier.
        for _ in 0..scratch.looks.values.len() {
            let below = scratch.at_event.iter().enumerate().filter(|(_, value)| **value < 0.0);
            let Some(event) = below.min_by(|a, b| a.1.total_cmp(b.1)).map(|(event, _)| event) else { break };
            let Some(found) = self.locate(dynamics, scratch, event, high, &mut looks)? else {
                // The value is used up when the step begins; the step after it is shorter, lest it end here again and again.
                high = 0.0;
                self.next_step *= 0.25;
                break;
            };
            high = found;
            scratch.at_event[event] = f64::INFINITY;
        }
        if high < 1.0 {
            self.cut(dynamics, high);
            dynamics.note_cut(self.t, &self.y);
        }
        self.switch_due = true;
        dynamics.rollback();
        Ok(())
    }

    /// The fraction of the last step, up to `until`, at which an event function has just fallen below zero (Illinois variant of the false
    /// position); `None` where it is not above zero before. `scratch.at_event` holds all values at `until`, then those at the fraction found.
    fn locate(
        &mut self,
        dynamics: &mut dyn Implicit,
        scratch: &mut Scratch,
        event: usize,
        until: f64,
        looks: &mut usize,
    ) -> Result<Option<f64>, SolveError> {
        let mut below = scratch.at_event[event];
        let mut value_at = |theta: f64| -> Result<f64, SolveError> {
            self.look(dynamics, scratch, theta)?;
            if scratch.looks.values[event] < 0.0 {
                scratch.at_event.copy_from_slice(&scratch.looks.values);
            }
            Ok(scratch.looks.values[event])
        };
        let (mut low, mut high) = (0.0, until);
        let mut above = value_at(low)?;
        // Right after an event the value may begin at zero: then it is looked for inside the step.
        for halvings in 1..=LOOKS {
            if above > 0.0 {
                break;
            }
            let theta = until * 0.5f64.powi(halvings);
            let value = value_at(theta)?;
            if value > 0.0 {
                (low, above) = (theta, value);
            } else {
                (high, below) = (theta, value);
            }
        }
        if !(above > 0.0) {
            return Ok(None);
        }
        let mut kept_low = false;
        let mut kept_high = false;
        while *looks < ITERATIONS {
            // A function that only exists further on (infinite here) is approached by halving.
            let theta = if above.is_finite() { low + (high - low) * above / (above - below) } else { 0.5 * (low + high) };
            if high - low <= RESOLUTION || !(theta > low && theta < high) {
                break;
            }
            *looks += 1;
            let value = value_at(theta)?;
            // An end that stays twice in a row weighs half as much.
            if value >= 0.0 {
                (low, above) = (theta, value);
                below *= if kept_high { 0.5 } else { 1.0 };
            } else {
                (high, below) = (theta, value);
                above *= if kept_low { 0.5 } else { 1.0 };
            }
            (kept_low, kept_high) = (value < 0.0, value >= 0.0);
        }
        Ok(Some(high))
    }

    /// Finds the event functions' values at a fraction of the last step. Is one of them below zero?
    fn look(&mut self, dynamics: &mut dyn Implicit, scratch: &mut Scratch, theta: f64) -> Result<bool, SolveError> {
        let time = self.t_begin + theta * (self.t - self.t_begin);
        self.interpolate(dynamics, time, &mut scratch.trial);
        dynamics.rollback();
        self.statistics.evaluations += 1;
        let evaluated = dynamics.derivative(time, &scratch.trial, &mut scratch.stages[1]);
        evaluated.map_err(|Undefined| SolveError::Undefined { time })?;
        Ok(scratch.looks.at(dynamics))
    }

    /// Ends the last step at a fraction of its length; the continuous output then spans the shorter step.
    fn cut(&mut self, dynamics: &dyn Implicit, theta: f64) {
        let time = self.t_begin + theta * (self.t - self.t_begin);
        let mut y = std::mem::take(&mut self.derivative);
        self.interpolate(dynamics, time, &mut y);
        std::mem::swap(&mut self.y, &mut y);
        self.derivative = y;
        self.forget();
        let mut power = 1.0;
        for vector in self.dense.chunks_exact_mut(self.y.len()) {
            vector.iter_mut().for_each(|coefficient| *coefficient *= power);
            power *= theta;
        }
        self.t = time;
        self.grid_start = time;
        self.grid_count = 0;
    }
}
