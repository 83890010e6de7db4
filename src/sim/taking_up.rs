//! Changes of inputs that the integrator's step in hand takes up (`solve::response`): forces and torques under elastic contact.
//!
//! What such an input changes of the derivative follows from the equations of motion alone, without a look at any contact. All else (friction, rails that
//! move, contact as a constraint, states that the Jacobian does not know, a wanted speed, whose bound is a kink) restarts the integration.

use super::dynamics::{ModelDynamics, Watched};
use super::input;
use super::{Simulation, SimulationError, SimulationState, Snapshot};

/// Change of the derivative at the present time and at the end of the step in hand.
#[derive(Debug)]
pub(super) struct Push {
    change: [Vec<f64>; 2],
    /// Values of inputs.
    inputs: Vec<f64>,
}

impl Push {
    pub fn new(states: usize, inputs: usize) -> Push {
        Push { change: [0; 2].map(|_| vec![0.0; states]), inputs: vec![0.0; inputs] }
    }
}

impl Simulation {
    /// Takes the inputs that were set up into the step in hand. False where the integration must restart.
    pub(super) fn take_up(&mut self) -> bool {
        if !self.state.integration.is_in_hand(self.state.time) || !self.model.is_bodies_alone() || !self.changes_loads_alone() {
            return false;
        }
        self.known = None;
        if self.find_push().is_err() {
            return false;
        }
        let fresh = !self.state.integration.has_taken_up();
        let SimulationState { time, followed, began, frame, swings, strikes, flutter, integration, memories, .. } = &mut self.state;
        if fresh {
            began.clone_from(followed);
        }
        let watched = Watched { frame, swings, strikes, flutter, loads: &mut self.loads };
        let inputs = (&began[..], &mut self.push.inputs[..]);
        let mut dynamics =
            ModelDynamics::new(&self.model, &mut self.workspace, inputs, (memories, &mut self.trial), watched).again(&mut self.snapshot.dy);
        let [now, then] = &self.push.change;
        self.integrator.take_up(&mut dynamics, integration, &mut self.scratch, *time, [now, then])
    }

    /// Do the inputs that have turned load bodies alone, by values that differ linearly in time?
    fn changes_loads_alone(&self) -> bool {
        let SimulationState { time, inputs, followed, .. } = &self.state;
        let elements = self.model.first_element_input()..self.model.first_travel_input(inputs.len()).unwrap_or(inputs.len());
        followed.iter().zip(inputs).enumerate().filter(|(_, (followed, set))| !followed.goes_on_as(set, *time)).all(
            |(input, (followed, set))| {
                let loads = elements.contains(&input) || self.load_by(input).is_some();
                loads && !self.model.formulation.constrains() && followed.second == set.second
            },
        )
    }

    /// Finds the change of the derivative at the present state, by the inputs now and at the end of the step in hand.
    fn find_push(&mut self) -> Result<(), SimulationError> {
        self.find_state(false)?;
        let Simulation { model, state, snapshot, push, .. } = self;
        let SimulationState { integration, inputs, followed, .. } = state;
        let Snapshot { time, y, dy, workspace, memory, .. } = snapshot;
        model.move_bodies(y, memory, &mut workspace.system);
        let steady = followed.iter().zip(&*inputs).all(|(followed, set)| followed.at(*time)[1] == set.at(*time)[1]);
        let [now, then] = &mut push.change;
        for (change, at) in [(&mut *now, *time), (&mut *then, integration.t)] {
            if steady && at > *time {
                break;
            }
            input::evaluate(model, inputs, at, &mut push.inputs);
            model.loaded_alone(workspace, &push.inputs, (*time, y), dy)?;
            change.clone_from(dy);
            input::evaluate(model, followed, at, &mut push.inputs);
            model.loaded_alone(workspace, &push.inputs, (*time, y), dy)?;
            change.iter_mut().zip(&*dy).for_each(|(change, before)| *change -= before);
        }
        if steady {
            then.clone_from(now);
        }
        Ok(())
    }
}
