//! Steps: what a host may ask for, how far one goes, and how it is taken back.

use super::{CallError, Instance, Phase};
use crate::formulation::events::ContactEvent;
use crate::formulation::wheel_loads::WheelLoads;
use crate::sim::{SimulationError, SimulationState};

/// How a step ended.
#[derive(Debug)]
pub enum StepOutcome {
    Done,
    /// Contacts that are constraints lifted off or landed on the way, or others began or ended; or fixed steps were doubtful, in words.
    DoneWithRemarks(Vec<ContactEvent>, Option<String>),
    /// The model could not be advanced to the end; time stands at the last successful step. With what happened before.
    Discarded(SimulationError, Vec<ContactEvent>),
}

/// How far an advance goes at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// To the end of the step.
    Through,
    /// To the end of the integrator's step in hand.
    ToStop,
}

/// What a step changes: the simulation's state and the inputs as they were set.
pub(super) type Before = (SimulationState, Vec<[f64; 3]>, WheelLoads);

/// By how much two communication times may differ and still be the same: 1e-9 of their size (at least of 1 s), but no more
/// than a thousandth of the step, lest a master far from t = 0 skips time unnoticed, and no less than rounding.
fn slack(time: f64, step: f64) -> f64 {
    let size = time.abs().max(1.0);
    (1e-9 * size).min(1e-3 * step.abs()).max(8.0 * f64::EPSILON * size)
}

impl Instance {
    /// A step to its end.
    ///
    /// # Errors
    /// [`CallError`] for a call that makes no sense; a model that cannot go on is [`StepOutcome::Discarded`].
    pub fn do_step(&mut self, current: f64, step: f64) -> Result<StepOutcome, CallError> {
        let target = self.step_end(current, step)?;
        self.advance(target, Pace::Through)
    }

    /// Checks a step that the host asks for; returns the time at which it ends, s.
    ///
    /// # Errors
    /// [`CallError`] for a call that makes no sense.
    pub fn step_end(&self, current: f64, step: f64) -> Result<f64, CallError> {
        self.require("a step", &[Phase::Stepping])?;
        let time = self.time();
        if !(step > 0.0 && step.is_finite()) {
            return Err(CallError::Time { what: "communicationStepSize", value: step, expected: "a finite number greater than 0".into() });
        }
        if !((current - time).abs() <= slack(time, step)) {
            return Err(CallError::Time {
                what: "currentCommunicationPoint",
                value: current,
                expected: format!("the instance's time {time}"),
            });
        }
        let target = current + step;
        if let Some(stop) = self.experiment.stop.filter(|stop| target > stop + slack(*stop, step)) {
            return Err(CallError::Time {
                what: "communicationStepSize",
                value: step,
                expected: format!("a step that ends by the stop time {stop}"),
            });
        }
        if !(target > time) {
            return Err(CallError::Time {
                what: "communicationStepSize",
                value: step,
                expected: format!("a step that moves time beyond {time}"),
            });
        }
        Ok(target)
    }

    /// Advances towards `target`, which [`Instance::step_end`] has found.
    ///
    /// # Errors
    /// [`CallError::Start`] when there is no simulation and none can be made; a model that cannot go on is [`StepOutcome::Discarded`].
    pub fn advance(&mut self, target: f64, pace: Pace) -> Result<StepOutcome, CallError> {
        let simulation = self.started()?;
        let doubtful = simulation.doubts().steps;
        let advanced = match pace {
            Pace::Through => simulation.advance(target),
            Pace::ToStop => simulation.advance_to_stop(target),
        };
        let doubt = (simulation.doubts().steps > doubtful).then(|| simulation.doubts().to_string());
        // None may be left for a later step, which may begin elsewhere.
        let events = simulation.take_events();
        Ok(match advanced {
            Ok(()) if events.is_empty() && doubt.is_none() => StepOutcome::Done,
            Ok(()) => StepOutcome::DoneWithRemarks(events, doubt),
            Err(error) => StepOutcome::Discarded(error, events),
        })
    }
    /// Keeps where a step begins, so that [`Instance::take_back`] can undo it.
    pub fn keep_begin(&mut self) {
        let Some(simulation) = &self.simulation else { return };
        match &mut self.before {
            Some(before) => {
                before.0.clone_from(simulation.state());
                before.1.clone_from(&self.inputs);
                before.2.copy_from(simulation.loads());
            }
            None => self.before = Some(Box::new((simulation.state().clone(), self.inputs.clone(), simulation.loads().clone()))),
        }
    }

    /// Back to where the step under way began.
    pub fn take_back(&mut self) {
        let (Some(before), Some(simulation)) = (&self.before, &mut self.simulation) else { return };
        simulation.restore(&before.0);
        simulation.put_loads(&before.2);
        self.inputs.clone_from(&before.1);
    }
}
