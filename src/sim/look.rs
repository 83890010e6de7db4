//! What is read of a simulation at its present time: the model is evaluated there, and the state is not touched.

use super::{Simulation, SimulationError, SimulationState, input};
use crate::formulation::memory::ModelMemory;
use crate::formulation::{Evaluation, Workspace};

/// Contacts that may change their form one after the other at one instant.
const MOST_CHANGES: usize = 16;

/// What an output is read from; each has what those before it have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// Positions, velocities, states and inputs of force elements.
    Motion,
    /// Accelerations of bodies that no force of contact reaches at once.
    Bodies,
    /// Contacts and all accelerations.
    Contacts,
}

/// Solution and everything computed from it at one time; outputs are read from it.
#[derive(Clone, Debug)]
pub struct Snapshot {
    pub time: f64,
    pub y: Vec<f64>,
    pub dy: Vec<f64>,
    pub workspace: Workspace,
    pub(super) memory: ModelMemory,
    pub(super) inputs: Vec<f64>,
}

impl Snapshot {
    /// Values of the model's inputs.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// How many contacts of a wheel (by its first contact) carry load.
    pub fn loaded_contacts(&self, contact: usize) -> usize {
        self.workspace.reports(contact).filter(|report| report.normal_force > 0.0).count()
    }

    /// Warm starts as the evaluation left them.
    pub fn memory(&self) -> &ModelMemory {
        &self.memory
    }
}

impl Simulation {
    /// The snapshot that was taken last.
    pub fn last_snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// Evaluates the model at the present time, once per state. The state is not touched: looking changes nothing. After a jump of an input a
    /// contact may have to change its form at once: what is shown is what the next step begins with.
    ///
    /// # Errors
    /// [`SimulationError`] when the model cannot be evaluated here.
    pub fn snapshot(&mut self) -> Result<&Snapshot, SimulationError> {
        if self.known == Some(Needs::Contacts) {
            return Ok(&self.snapshot);
        }
        self.look_and_beyond()?;
        let stands = self.state.integration.t == self.state.time || self.turns();
        let Snapshot { time, y, dy, workspace, memory, inputs } = &mut self.snapshot;
        for _ in 0..if stands { MOST_CHANGES } else { 0 } {
            let Some(due) = self.model.due(*time, memory) else { break };
            let carried = self.model.at(workspace, *time, y, memory).carry_out(due);
            let evaluated = carried.and_then(|_| self.model.derivative(workspace, Evaluation { t: *time, inputs, y, memory }, dy));
            if evaluated.is_err() {
                // The new form has no solution: the next step does without it or says so, and what can be read is the old one.
                self.known = None;
                self.look_and_beyond()?;
                break;
            }
        }
        self.snapshot.workspace.events.clear();
        Ok(&self.snapshot)
    }

    /// The evaluation. Where a constraint's place ceases to exist just beyond a step its equations have no solution at the step's end any more: the next
    /// step goes on without it, and that is what can be read.
    fn look_and_beyond(&mut self) -> Result<(), SimulationError> {
        let mut failure = match self.look() {
            Ok(_) => return Ok(()),
            Err(SimulationError::Evaluation(failure)) => failure,
            Err(other) => return Err(other),
        };
        let Snapshot { time, y, dy, workspace, memory, inputs } = &mut self.snapshot;
        for _ in 0..MOST_CHANGES {
            if !self.model.at(workspace, *time, y, memory).release(&failure)? {
                break;
            }
            match self.model.derivative(workspace, Evaluation { t: *time, inputs, y, memory }, dy) {
                Ok(()) => {
                    self.known = Some(Needs::Contacts);
                    return Ok(());
                }
                Err(next) => failure = next,
            }
        }
        Err(failure.into())
    }

    /// As much of the snapshot as outputs with these needs are read from; what is beyond is of an earlier time. Where contact is a constraint the
    /// whole evaluation is made: it may have to change its form, which moves bodies. What is read has the same bits whatever is asked for.
    ///
    /// # Errors
    /// [`SimulationError`] when the state can't be found.
    pub fn snapshot_with(&mut self, needs: Needs) -> Result<&Snapshot, SimulationError> {
        if self.known >= Some(needs) {
            return Ok(&self.snapshot);
        }
        if needs == Needs::Contacts || self.model.formulation.constrains() {
            return self.snapshot();
        }
        if self.known.is_none() {
            self.find_motion()?;
        }
        if needs == Needs::Bodies {
            let Snapshot { time, y, dy, workspace, .. } = &mut self.snapshot;
            self.model.system.load_bodies(y, &mut workspace.system);
            self.model.accelerate(workspace, *time, y, dy)?;
            self.known = Some(Needs::Bodies);
        }
        Ok(&self.snapshot)
    }

    /// Solution, motions of bodies and inputs at the present time.
    pub(super) fn find_motion(&mut self) -> Result<(), SimulationError> {
        self.find_state(false)?;
        let Snapshot { time, y, workspace, memory, inputs, .. } = &mut self.snapshot;
        self.model.take_inputs(&mut workspace.system, *time, inputs);
        self.model.move_bodies(y, memory, &mut workspace.system);
        self.known = Some(Needs::Motion);
        Ok(())
    }

    /// Solution, memory and inputs at the present time; what is remembered of contacts only where it is asked for.
    pub(super) fn find_state(&mut self, contacts: bool) -> Result<(), SimulationError> {
        let Snapshot { time, y, workspace, memory, inputs, .. } = &mut self.snapshot;
        *time = self.state.time;
        let SimulationState { integration, frame, memories, .. } = &self.state;
        integration.interpolate_beside(*time, y, |ahead, y| self.model.add_frame_motion(frame, ahead, y));
        if contacts {
            memory.clone_from(&memories.accepted);
        } else {
            memory.take_paths(&memories.accepted);
        }
        input::evaluate(&self.model, &self.state.inputs, *time, inputs);
        // The continuous output leaves constraints by its error.
        self.model.at(workspace, *time, y, memory).project()?;
        Ok(())
    }

    /// The evaluation alone, whatever form it asks for. It begins anew where motion was read before: places along the track are then found from where they
    /// were at the end of the step, to the last digit.
    pub(super) fn look(&mut self) -> Result<&Snapshot, SimulationError> {
        if self.known == Some(Needs::Contacts) {
            return Ok(&self.snapshot);
        }
        self.known = None;
        self.find_state(true)?;
        let Snapshot { time, y, dy, workspace, memory, inputs } = &mut self.snapshot;
        self.model.derivative(workspace, Evaluation { t: *time, inputs, y, memory }, dy)?;
        self.known = Some(Needs::Contacts);
        Ok(&self.snapshot)
    }
}
