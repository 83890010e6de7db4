//! The model with its inputs as a system that an integrator can advance.

use super::input::{self, InputSignal};
use crate::formulation::carried::CarriedMotion;
use crate::formulation::flutter::Flutter;
use crate::formulation::swing::Swings;
use crate::formulation::wheel_loads::WheelLoads;
use crate::formulation::{Evaluation, EvaluationError, Model, Workspace};
use crate::mbs::body::{COORDINATES, HEIGHT, ROLL};
use crate::solve::{Dynamics, StiffPart, Undefined};

/// Weight of a wheelset's height and roll in the error control: a loaded wheel's penetration is 0.07 mm, so that an error of
/// 1e-6 m there would be one of 2 % (1.6 kN) in the wheel load. With the weight, wheel loads are about as exact as lateral motion.
const PRESSING: f64 = 100.0;
/// Error of a position that makes a fixed step doubtful, m and rad.
const DOUBTFUL: f64 = 1e-4;
/// Place of the lead in a contact's memory.
const LEAD: usize = 2;

/// A failure before the present time by more than this lies behind, s.
const PASSED: f64 = 1e-9;

/// A model under given input signals.
pub struct ModelDynamics<'a> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    signals: &'a [InputSignal],
    values: &'a mut [f64],
    /// Beside which the last accepted step was made.
    carried: &'a mut CarriedMotion,
    swings: &'a mut Swings,
    flutter: &'a mut Flutter,
    loads: &'a mut WheelLoads,
    constant: bool,
    /// Why the last failed evaluation failed.
    pub failure: Option<EvaluationError>,
}

impl<'a> ModelDynamics<'a> {
    pub fn new(
        model: &'a Model,
        workspace: &'a mut Workspace,
        signals: &'a [InputSignal],
        values: &'a mut [f64],
        (carried, swings, flutter): (&'a mut CarriedMotion, &'a mut Swings, &'a mut Flutter),
        loads: &'a mut WheelLoads,
    ) -> Self {
        let constant = signals.iter().all(|signal| signal.first == 0.0 && signal.second == 0.0);
        input::evaluate(signals, 0.0, values);
        // Inputs are those of the evaluation that found them.
        workspace.findings_marked &= constant;
        ModelDynamics { model, workspace, signals, values, carried, swings, flutter, loads, constant, failure: None }
    }
}

/// Keeps the reason of a failure for whoever advanced the simulation.
fn keep<T>(failure: &mut Option<EvaluationError>, result: Result<T, EvaluationError>) -> Result<T, Undefined> {
    result.map_err(|error| {
        *failure = Some(error);
        Undefined
    })
}

impl Dynamics for ModelDynamics<'_> {
    #[inline]
    fn derivative(&mut self, t: f64, y: &[f64], memory: &mut [f64], dy: &mut [f64]) -> Result<(), Undefined> {
        if !self.constant {
            input::evaluate(self.signals, t, self.values);
        }
        self.workspace.findings_marked = false;
        let at = Evaluation { t, inputs: self.values, y, memory };
        keep(&mut self.failure, self.model.derivative(self.workspace, at, dy))
    }

    /// Positions, angles and force elements' states in metres and radians; those that press wheels into rails weigh more.
    fn error_weight(&self, i: usize) -> f64 {
        let system = &self.model.system;
        let velocities = COORDINATES * system.bodies.len();
        let plain = if (velocities..2 * velocities).contains(&i) || i >= self.model.mean_states(0).start {
            0.0
        } else if i < velocities
            && matches!(i % COORDINATES, HEIGHT | ROLL)
            && self.model.wheelsets.iter().any(|wheelset| wheelset.body == i / COORDINATES)
        {
            PRESSING
        } else {
            1.0
        };
        self.model.formulation.error_weight(self.model, self.workspace, i, plain)
    }

    fn coordinates(&self) -> usize {
        COORDINATES * self.model.system.bodies.len()
    }

    fn longest_step(&self, dy: &[f64]) -> f64 {
        self.model.longest_step(self.workspace, dy).min(self.flutter.longest_step())
    }

    fn longest_known(&self) -> f64 {
        self.model.longest_known(self.workspace)
    }

    fn load_error(&self, error: &[f64]) -> f64 {
        self.model.load_error(self.workspace, error)
    }

    fn doubtful_error(&self) -> f64 {
        DOUBTFUL
    }

    fn swing_error(&self, error: &[f64]) -> f64 {
        self.model.swing_error(self.swings, error)
    }

    fn note_step(&mut self, t: f64) {
        self.model.note_swings(self.workspace, t, self.swings);
        self.model.note_wheel_loads(self.workspace, t, self.loads);
    }

    fn clear_findings(&mut self) {
        self.workspace.findings_marked = false;
    }

    fn mark_findings(&mut self) {
        self.workspace.findings_marked = true;
    }

    fn findings_stand(&self) -> bool {
        self.workspace.findings_marked
    }

    fn repeat(&mut self, t: f64, y: &[f64], memory: &mut [f64], dy: &mut [f64]) -> Result<(), Undefined> {
        let work = self.workspace.work;
        let done = self.derivative(t, y, memory, dy);
        self.workspace.work = work;
        done
    }

    fn linearise(&mut self, t: f64, y: &[f64], memory: &[f64], part: StiffPart) -> Result<(), Undefined> {
        self.model.linearise(self.workspace, (y, memory), self.values, part == StiffPart::All);
        self.model.note_flutter(self.workspace, t, self.flutter);
        Ok(())
    }

    fn factorise(&mut self, a: f64) -> Result<(), Undefined> {
        keep(&mut self.failure, self.model.factorise(self.workspace, a).map_err(|error| self.model.singular_tangent(self.workspace, error)))
    }

    fn solve_linear(&mut self, x: &mut [f64]) {
        self.model.solve_linear(self.workspace, x);
    }

    fn solve_linear_pushed(&mut self, x: &mut [f64], weight: f64, push: &[f64]) {
        self.model.solve_linear_pushed(self.workspace, x, weight, push);
    }

    fn carry(&mut self, ahead: f64, shift: &mut [f64], rate: &mut [f64]) -> bool {
        self.model.carry(self.workspace, ahead, shift, rate);
        true
    }

    fn keep_carried(&mut self) {
        self.carried.take_over(self.model.carried_motion(self.workspace));
    }

    fn add_carried(&self, ahead: f64, y: &mut [f64]) {
        self.model.add_carried(self.carried, ahead, y);
    }

    fn carried_change(&mut self, change: &mut [f64]) {
        self.model.carried_change(self.workspace, change);
    }

    fn project(&mut self, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<bool, Undefined> {
        let marked = std::mem::take(&mut self.workspace.findings_marked);
        let moved = keep(&mut self.failure, self.model.project(self.workspace, t, y, memory))?;
        // Where nothing moves, bodies' motions are found again to the bit, and so are their places along a curved track: the search ends where it begins.
        self.workspace.findings_marked = marked && !moved;
        self.model.note_means(t, y, memory);
        Ok(moved)
    }

    fn margin(&self, memory: &[f64]) -> Option<f64> {
        self.model.margin(memory)
    }

    fn switch_due(&self, t: f64, memory: &[f64]) -> bool {
        t >= self.model.next_return(memory)
    }

    fn switch(&mut self, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<bool, Undefined> {
        let changed = keep(&mut self.failure, self.model.switch(self.workspace, t, y, memory))?;
        self.workspace.findings_marked &= !changed;
        Ok(changed)
    }

    fn release(&mut self, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<bool, Undefined> {
        // A failure that lies behind was overcome by a shorter step and says nothing.
        let Some(failure) = self.failure.clone().filter(|failure| failure.time > t - PASSED) else { return Ok(false) };
        self.workspace.findings_marked = false;
        keep(&mut self.failure, self.model.release(&failure, self.workspace, t, y, memory))
    }

    /// When a wheel's contact reaches a place where its rail is not smooth.
    fn next_break(&self, t: f64, y: &[f64], memory: &[f64]) -> f64 {
        let next = self.model.next_return(memory).min(self.model.formulation.next_break(self.model, t, y));
        let lead = |contact| memory[self.model.contact_memory(contact)][LEAD];
        next.min(self.model.next_rough_place(t, y, memory, lead))
    }
}
