//! Which states the books of a vehicle's energy ([`super::energy`]) have: what elements without inputs turn into heat, what contacts do beside friction; of each wheelset friction
//! of both wheels and its inputs; of each driving constraint its work; of each element with inputs what they bring in and its heat, where either can be;
//! and what guides of elements without inputs hold along the track against gravity (`vehicle.detail`), where there are such.

use crate::geometry::Side;
use crate::mbs::force::ForceElement;
use crate::mbs::system::System;
use std::ops::Range;

/// Heat of elements without inputs, and what contacts do beside friction.
pub const SUSPENSION: usize = 0;
pub const CONTACT: usize = 1;
const WHEELSETS: usize = 2;
/// States of each wheelset: friction of the left and the right wheel, inputs.
const EACH: usize = 3;
const INPUTS: usize = 2;

/// The places of a model's books, J each.
#[derive(Clone, Debug)]
pub struct EnergyBooks {
    wheelsets: usize,
    pub(super) accounts: Vec<Account>,
    /// Place of what elements without inputs bring in: those whose other body is a guide.
    pub guides: Option<usize>,
    states: usize,
}

/// A force element that has something to book.
#[derive(Clone, Debug)]
pub(super) struct Account {
    /// Among the system's elements; its inputs and states.
    pub element: usize,
    pub inputs: Range<usize>,
    pub own: Range<usize>,
    /// Places of what its inputs bring in and of its heat.
    pub work: Option<usize>,
    pub heat: Option<usize>,
}

impl EnergyBooks {
    pub fn new(system: &System, wheelsets: usize) -> EnergyBooks {
        let mut states = WHEELSETS + EACH * wheelsets + system.drives.len();
        let mut place = |asked: bool| {
            asked.then(|| {
                states += 1;
                states - 1
            })
        };
        let guided =
            system.forces.iter().enumerate().any(|(element, force)| system.inputs_of_force(element).is_empty() && force.is_supplied());
        let guides = place(guided);
        let account = |(element, force): (usize, &dyn ForceElement)| {
            let (inputs, own) = (system.inputs_of_force(element), system.states_of_force(element));
            let [supplied, dissipative] = [force.is_supplied(), force.is_dissipative()];
            let [work, heat] = match inputs.is_empty() {
                true => [guides.filter(|_| supplied), dissipative.then_some(SUSPENSION)],
                false => [place(supplied), place(dissipative)],
            };
            (work.is_some() || heat.is_some()).then_some(Account { element, inputs, own, work, heat })
        };
        let accounts = system.forces.iter().map(AsRef::as_ref).enumerate().filter_map(account).collect();
        EnergyBooks { wheelsets, accounts, guides, states }
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.states
    }

    /// What friction has taken at a wheel.
    pub fn friction(&self, wheelset: usize, side: Side) -> usize {
        WHEELSETS + EACH * wheelset + side.index()
    }

    /// What the inputs of a wheelset have done.
    pub fn inputs(&self, wheelset: usize) -> usize {
        WHEELSETS + EACH * wheelset + INPUTS
    }

    /// What the driving constraint of that number has done.
    pub fn drive(&self, index: usize) -> usize {
        WHEELSETS + EACH * self.wheelsets + index
    }

    /// What the inputs of an element have brought in, and its heat; `None` for one without inputs.
    pub fn element(&self, element: usize) -> [Option<usize>; 2] {
        let account = self.accounts.iter().find(|account| account.element == element && !account.inputs.is_empty());
        account.map_or([None; 2], |account| [account.work, account.heat])
    }
}
