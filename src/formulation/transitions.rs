//! What a run asks of a model: derivatives, and the events at which contacts change.
//!
//! Event functions fall below zero where their event takes place. Per wheel, in this order: a constraint's normal force [N]; how far its
//! place is from being left [1/m]; for each contact beside the first how far it is from beginning or ending [m]. Infinity: can't happen at present.
//! Besides, an elastic contact of a constraint formulation tries to become a constraint again at times that are known before.

use super::elastic::points;
use super::memory::{Mode, ModelMemory};
use super::rigid::modes::{self, Leaving};
use super::step::Step;
use super::wheel_search::MOST_POINTS;
use super::{Evaluation, EvaluationError, Model, OnLift, Workspace};

/// Something that changes the form of a model at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transition {
    /// A contact beside the first of a wheel begins or ends.
    Touch {
        contact: usize,
        slot: usize,
    },
    /// An elastic contact tries to become a constraint.
    Landing {
        contact: usize,
    },
    /// A constraint lifts, or its place ceases.
    Lift {
        contact: usize,
    },
    Vanish {
        contact: usize,
    },
}

/// Kinds of transition before that of the first slot.
const KINDS: usize = 3;
/// Numbers for each contact.
const EACH: usize = KINDS + MOST_POINTS;

impl Transition {
    /// Its number among all that may take place.
    pub fn number(self) -> usize {
        let (contact, kind) = match self {
            Transition::Landing { contact } => (contact, 0),
            Transition::Lift { contact } => (contact, 1),
            Transition::Vanish { contact } => (contact, 2),
            Transition::Touch { contact, slot } => (contact, KINDS + slot),
        };
        contact * EACH + kind
    }

    /// The transition of a number.
    pub fn of(number: usize) -> Transition {
        let contact = number / EACH;
        match number % EACH {
            0 => Transition::Landing { contact },
            1 => Transition::Lift { contact },
            2 => Transition::Vanish { contact },
            kind => Transition::Touch { contact, slot: kind - KINDS },
        }
    }
}

impl Model {
    /// Derivative `dy` of the state `at.y` at time `at.t`; leaves motions, wrenches and contacts in the workspace.
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found or lies outside what the laws cover.
    #[inline]
    pub fn derivative(&self, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        self.take_inputs(&mut workspace.system, at.t, at.inputs);
        let (inputs, y) = (at.inputs, at.y);
        let t = at.t;
        self.formulation.derivative(self, workspace, at, dy)?;
        self.on_the_rails(workspace, t)?;
        self.level_rates(&workspace.system, t, dy)?;
        self.mean_rates(workspace, dy);
        self.book_energy(workspace, inputs, y, dy);
        Ok(())
    }

    /// Number of event functions.
    pub fn event_functions(&self) -> usize {
        let own = if self.formulation.constrains() { 2 } else { 0 };
        let touching = self.searches.iter().filter(|search| search.is_some()).count() * (self.points - 1);
        own * self.contacts() + touching
    }

    /// Their values as the last evaluation left them in the memory.
    pub fn event_values(&self, memory: &ModelMemory, values: &mut [f64]) {
        let leaving = |wheel| {
            self.formulation.on_lift().map(|on_lift| [Leaving::Lifts, Leaving::Vanishes].map(|l| modes::event_value(on_lift, wheel, l)))
        };
        let found = memory.wheels.iter().zip(&self.searches).flat_map(|(wheel, search)| {
            let beside = if search.is_some() { &wheel.places[1..self.points] } else { &[] };
            leaving(wheel).into_iter().flatten().chain(beside.iter().map(points::event_value))
        });
        for (value, found) in values.iter_mut().zip(found) {
            *value = found;
        }
    }

    /// What changes at `t` [s] in the state that was evaluated last. Contacts beside the first come first: they move nothing. Of the constraints that
    /// would leave their rails one goes, because the others may press again then.
    pub fn due(&self, t: f64, memory: &ModelMemory) -> Option<Transition> {
        let wheels = || memory.wheels.iter().enumerate();
        for (contact, wheel) in wheels().filter(|(contact, _)| self.searches[*contact].is_some()) {
            let crossed = |slot: &usize| points::event_value(&wheel.places[*slot]) < 0.0;
            if let Some(slot) = (1..self.points).find(crossed) {
                return Some(Transition::Touch { contact, slot });
            }
        }
        let on_lift = self.formulation.on_lift()?;
        let landing = wheels().find(|(_, wheel)| matches!(wheel.mode, Mode::Elastic { next_try, .. } if !(t < next_try)));
        if let Some((contact, _)) = landing {
            return Some(Transition::Landing { contact });
        }
        let first = |leaving| modes::first_leaving(on_lift, &memory.wheels, leaving);
        let vanishing = first(Leaving::Vanishes).map(|contact| Transition::Vanish { contact });
        vanishing.or_else(|| first(Leaving::Lifts).map(|contact| Transition::Lift { contact }))
    }

    /// Are contacts constraints that may also be elastic for a time (`contact.on_lift`)?
    pub fn may_be_elastic(&self) -> bool {
        self.formulation.on_lift() == Some(OnLift::Elastic)
    }

    /// When an elastic contact tries next to become a constraint again, s; infinity for never.
    pub fn next_try(&self, memory: &ModelMemory) -> f64 {
        let tries = memory.wheels.iter().filter_map(|wheel| match wheel.mode {
            Mode::Elastic { next_try, .. } => Some(next_try),
            Mode::Rigid { .. } => None,
        });
        tries.fold(f64::INFINITY, f64::min)
    }
}

impl Step<'_> {
    /// Starts with all contacts elastic; see [`super::Formulation::start`].
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found.
    pub fn start_elastic(&mut self) -> Result<(), EvaluationError> {
        modes::start_elastic(self);
        self.model.formulation.resettle(self)
    }

    /// Carries out what is due, by what the last evaluation found in this state; returns whether the form of the model has changed.
    ///
    /// # Errors
    /// [`EvaluationError`] when the formulation can't go on.
    pub fn carry_out(&mut self, transition: Transition) -> Result<bool, EvaluationError> {
        let model = self.model;
        match transition {
            Transition::Touch { contact, slot } => {
                points::switch(self, model.wheel(contact), slot);
                Ok(true)
            }
            Transition::Landing { contact } => modes::try_to_land(self, model.wheel(contact)),
            Transition::Lift { contact } => modes::leave(self, model.wheel(contact), Leaving::Lifts).map(|()| true),
            Transition::Vanish { contact } => modes::leave(self, model.wheel(contact), Leaving::Vanishes).map(|()| true),
        }
    }

    /// Hands a constrained contact that can't be found any more to elastic forces, where the scene allows it; returns whether it
    /// did.
    ///
    /// # Errors
    /// [`EvaluationError`] when there is no state nearby in which the other constraints hold.
    pub fn release(&mut self, failure: &EvaluationError) -> Result<bool, EvaluationError> {
        if self.model.may_be_elastic() { modes::release(self, failure) } else { Ok(false) }
    }
}
