//! What happens at the end of a step: projection, and events between the ends of the step.
//!
//! An event is where [`Dynamics::margin`] falls below zero. It is located on the continuous output of the step; the step is cut
//! there, and the system changes its form when the next step begins. So a solution that is read before the event is that of
//! the old form, and a restart before it (a jump of an input) undoes it.

use super::{Dynamics, IntegrationState, Scratch, SolveError, Undefined};

/// An event is located to this fraction of the step, and never finer than rounding of time.
const RESOLUTION: f64 = 1e-12;
const ITERATIONS: usize = 60;
/// How often a step is halved to find a margin.
const LOOKS: i32 = 12;
/// Evaluations that finding an event may take.
pub(super) const MOST_LOOKS: usize = ITERATIONS + LOOKS as usize + 2;
/// More changes of form at one time are a contradiction of the system's.
const MOST_CHANGES: usize = 100;
/// A step that cannot be completed is tried again shorter, down to this, s.
pub(super) const SHORTEST_RETRY: f64 = 1e-9;

impl IntegrationState {
    /// Changes the system's form as often as that is due before the next step: events that ended the last step, events that a
    /// jump of an input has brought about, and those that follow from them at the same time. Where the new form has no solution the state stays in the
    /// old one, in which it can be read.
    pub(super) fn begin(&mut self, dynamics: &mut dyn Dynamics, scratch: &mut Scratch) -> Result<(), SolveError> {
        let mut changed_before = false;
        for _ in 0..MOST_CHANGES {
            let mut due = self.switch_due || dynamics.switch_due(self.t, &self.memory);
            if due || dynamics.margin(&self.memory).is_some() {
                // What changes is decided from an evaluation at this very state.
                if let Err(error) = self.evaluate_begin(dynamics) {
                    if changed_before {
                        self.put_back(scratch);
                    }
                    return Err(error);
                }
                due |= dynamics.margin(&self.memory).is_some_and(|margin| margin < 0.0);
            }
            if !due {
                return Ok(());
            }
            if !changed_before {
                self.keep_in(scratch);
            }
            let IntegrationState { t, y, memory, .. } = self;
            let Ok(changed) = dynamics.switch(*t, y, memory) else {
                self.put_back(scratch);
                return Err(SolveError::Undefined { time: self.t });
            };
            self.switch_due = false;
            if !changed {
                continue;
            }
            changed_before = true;
            self.t_begin = self.t;
            self.forget();
            self.statistics.events += 1;
        }
        Err(SolveError::EndlessEvents { time: self.t })
    }

    /// Keeps solution and record of the present form, for [`IntegrationState::put_back`].
    fn keep_in(&self, scratch: &mut Scratch) {
        scratch.trial.copy_from_slice(&self.y);
        scratch.memory.copy_from_slice(&self.memory);
    }

    /// Back to the form that was kept.
    fn put_back(&mut self, scratch: &Scratch) {
        self.y.copy_from_slice(&scratch.trial);
        self.memory.copy_from_slice(&scratch.memory);
        self.forget();
    }

    /// After a step that failed because the system is not defined, or not smooth, further on: asks for another form of it, which has a
    /// solution.
    pub(super) fn release(&mut self, dynamics: &mut dyn Dynamics, scratch: &mut Scratch, error: SolveError) -> Result<bool, SolveError> {
        let (SolveError::Undefined { .. } | SolveError::StepTooSmall { .. }) = error else { return Ok(false) };
        self.keep_in(scratch);
        // The new form may have no solution either until more of it has changed.
        for _ in 0..MOST_CHANGES {
            let IntegrationState { t, y, memory, .. } = self;
            match dynamics.release(*t, y, memory) {
                Ok(true) => {}
                Ok(false) => break,
                Err(Undefined) => {
                    self.put_back(scratch);
                    return Err(SolveError::Undefined { time: self.t });
                }
            }
            self.t_begin = self.t;
            self.forget();
            self.next_step = 0.0;
            self.statistics.events += 1;
            if self.evaluate_begin(dynamics).is_ok() {
                return Ok(true);
            }
        }
        self.put_back(scratch);
        Ok(false)
    }

    /// Completes an accepted step: moves its end onto the constraints, and cuts it where the system changes its form. A step that
    /// cannot be completed is taken back.
    pub(super) fn complete(&mut self, dynamics: &mut dyn Dynamics, scratch: &mut Scratch) -> Result<(), SolveError> {
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

    fn try_complete(&mut self, dynamics: &mut dyn Dynamics, scratch: &mut Scratch) -> Result<(), SolveError> {
        self.project(dynamics, scratch)?;
        if dynamics.margin(&self.memory).is_some() {
            self.evaluate_begin(dynamics)?;
            if let Some(margin) = dynamics.margin(&self.memory).filter(|margin| *margin < 0.0) {
                return self.cut_at_event(dynamics, scratch, margin, 1.0);
            }
            return self.look_within(dynamics, scratch);
        }
        Ok(())
    }

    fn project(&mut self, dynamics: &mut dyn Dynamics, scratch: &Scratch) -> Result<(), SolveError> {
        let IntegrationState { t, y, memory, .. } = self;
        if dynamics.project(*t, y, memory).map_err(|Undefined| SolveError::Undefined { time: *t })? {
            self.derivative_known = false;
            self.statistics.projections += 1;
        } else {
            // What rounding did counts as nothing: f was evaluated without it.
            self.y.copy_from_slice(&scratch.trial);
        }
        Ok(())
    }

    /// Looks within the last step, whose end is on this side of any event, where one of its stages lay beyond one: the continuous output tells
    /// whether the solution itself did.
    pub(super) fn look_within(&mut self, dynamics: &mut dyn Dynamics, scratch: &mut Scratch) -> Result<(), SolveError> {
        let Some(time) = scratch.beyond.take().filter(|time| *time > self.t_begin && *time < self.t) else { return Ok(()) };
        let theta = (time - self.t_begin) / (self.t - self.t_begin);
        let margin = self.margin_at(dynamics, scratch, theta)?;
        dynamics.clear_findings();
        if margin < 0.0 { self.cut_at_event(dynamics, scratch, margin, theta) } else { Ok(()) }
    }

    /// Finds where the margin passes zero within the last step before the fraction `until` of it, where it is `at_end` (Illinois variant of the
    /// false position), and ends the step there.
    pub(super) fn cut_at_event(
        &mut self,
        dynamics: &mut dyn Dynamics,
        scratch: &mut Scratch,
        at_end: f64,
        until: f64,
    ) -> Result<(), SolveError> {
        let (mut low, mut high) = (0.0, until);
        let mut above = self.margin_at(dynamics, scratch, low)?;
        let mut below = at_end;
        // Right after an event the margin may begin at zero: then it is looked for inside the step.
        for halvings in 1..=LOOKS {
            if above > 0.0 {
                break;
            }
            let theta = until * 0.5f64.powi(halvings);
            let margin = self.margin_at(dynamics, scratch, theta)?;
            if margin > 0.0 {
                (low, above) = (theta, margin);
            } else {
                (high, below) = (theta, margin);
            }
        }
        if above > 0.0 {
            let mut kept_low = false;
            let mut kept_high = false;
            for _ in 0..ITERATIONS {
                // A margin that only exists further on (infinite here) is approached by halving.
                let theta = if above.is_finite() { low + (high - low) * above / (above - below) } else { 0.5 * (low + high) };
                if high - low <= RESOLUTION || !(theta > low && theta < high) {
                    break;
                }
                let margin = self.margin_at(dynamics, scratch, theta)?;
                // An end that stays twice in a row weighs half as much.
                if margin >= 0.0 {
                    (low, above) = (theta, margin);
                    below *= if kept_high { 0.5 } else { 1.0 };
                } else {
                    (high, below) = (theta, margin);
                    above *= if kept_low { 0.5 } else { 1.0 };
                }
                (kept_low, kept_high) = (margin < 0.0, margin >= 0.0);
            }
        } else {
            // The margin is used up when the step begins; the step after it is shorter, lest it end here again and again.
            high = 0.0;
            self.next_step *= 0.25;
        }
        if high < 1.0 {
            self.cut(dynamics, high);
        }
        self.switch_due = true;
        Ok(())
    }

    /// The margin at a fraction of the last step.
    fn margin_at(&mut self, dynamics: &mut dyn Dynamics, scratch: &mut Scratch, theta: f64) -> Result<f64, SolveError> {
        let time = self.t_begin + theta * (self.t - self.t_begin);
        self.interpolate(dynamics, time, &mut scratch.trial);
        scratch.memory.copy_from_slice(&self.memory);
        self.statistics.evaluations += 1;
        let evaluated = dynamics.derivative(time, &scratch.trial, &mut scratch.memory, &mut scratch.stages[1]);
        evaluated.map_err(|Undefined| SolveError::Undefined { time })?;
        Ok(dynamics.margin(&scratch.memory).unwrap_or(f64::INFINITY))
    }

    /// Ends the last step at a fraction of its length; the continuous output then spans the shorter step.
    fn cut(&mut self, dynamics: &dyn Dynamics, theta: f64) {
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
