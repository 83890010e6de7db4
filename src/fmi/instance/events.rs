//! Event mode (FMI 3.0): discrete outputs change there and nowhere else, while a host that handles events runs the instance.

use super::{CallError, Instance, Phase};
use crate::fmi::variables::Kind;
use crate::sim::Simulation;

impl Instance {
    /// The host handles events: initialization ends in event mode. To be said before it begins.
    pub fn use_event_mode(&mut self) {
        self.event_mode = true;
    }

    /// From between two steps into event mode.
    ///
    /// # Errors
    /// [`CallError`] when it comes at the wrong time, or from a host that has said that it does not handle events.
    pub fn enter_event_mode(&mut self) -> Result<(), CallError> {
        self.require("entering event mode", &[Phase::Stepping])?;
        if !self.event_mode {
            return Err(CallError::NoEventMode);
        }
        self.phase = Phase::Event;
        Ok(())
    }

    /// Discrete outputs become those of the present state. They follow from it alone: one update is enough.
    ///
    /// # Errors
    /// [`CallError`] outside event mode, or when the model can't be evaluated here.
    pub fn update_discrete(&mut self) -> Result<(), CallError> {
        self.require("updating discrete states", &[Phase::Event])?;
        self.shown = self.loaded_contacts()?;
        Ok(())
    }

    /// From event mode to the next step.
    ///
    /// # Errors
    /// [`CallError`] outside event mode.
    pub fn enter_step_mode(&mut self) -> Result<(), CallError> {
        self.require("entering step mode", &[Phase::Event])?;
        if self.shown.is_empty() {
            self.shown = self.loaded_contacts()?;
        }
        self.phase = Phase::Stepping;
        Ok(())
    }

    /// Do discrete outputs show what is no longer so?
    pub fn discrete_outputs_are_late(&mut self) -> bool {
        // Where the model can't be evaluated the next step says why.
        self.event_mode && self.loaded_contacts().is_ok_and(|now| now != self.shown)
    }

    /// Does time stand at the end of the integrator's last step?
    pub fn is_at_stop(&self) -> bool {
        self.simulation.as_ref().is_some_and(Simulation::is_at_stop)
    }

    /// Steps of the integrator so far.
    pub fn integrator_steps(&self) -> u64 {
        self.simulation.as_ref().map_or(0, |simulation| simulation.statistics().steps)
    }

    /// How many contacts of each wheel carry load now.
    fn loaded_contacts(&mut self) -> Result<Vec<i32>, CallError> {
        let simulation = self.started()?;
        let wheels = simulation.model().contacts();
        let snapshot = simulation.snapshot().map_err(CallError::Evaluation)?;
        Ok((0..wheels).map(|wheel| snapshot.loaded_contacts(wheel) as i32).collect())
    }

    /// A wheel's number of contacts as a discrete output.
    pub(super) fn contacts_of(&mut self, wheel: usize, reference: u32) -> Result<i32, CallError> {
        let held = self.event_mode && matches!(self.phase, Phase::Stepping | Phase::Terminated) && !self.shown.is_empty();
        let found = if held { self.shown.get(wheel).copied() } else { self.loaded_contacts()?.get(wheel).copied() };
        found.ok_or(CallError::UnknownReference { reference, kind: Kind::Integer })
    }
}
