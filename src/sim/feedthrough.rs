//! What outputs depend on at the same instant.
//!
//! Inputs of one wheelset are numbered as in `formulation`: its own first, then those of the rail under its left and its right wheel.
//! Lists may name inputs that a scene does not have.

use crate::formulation::{
    DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, LONGITUDINAL_FORCE, Model, RAIL_INPUTS, RAIL_LATERAL_VELOCITY, RIGHT_FRICTION,
    VERTICAL_FORCE, WHEELSET_INPUTS,
};
use crate::geometry::Side;
use std::sync::Arc;

/// What an output of a wheelset depends on at the same instant.
#[derive(Clone, Copy)]
pub(super) enum Depends {
    /// These inputs of the wheelset, and never another.
    Only(&'static [usize]),
    /// A force of contact: these inputs of the wheelset. Where contact is a constraint, every input: its forces follow from accelerations, and the
    /// loop between normal and creep forces is one for all wheels.
    Contact(&'static [usize]),
    /// An acceleration, or the force that an imposed speed asks for: these inputs of the wheelset and what loads it. Where joints tie it to other
    /// bodies, what acts on any of them; on a curved track, where axes turn with the travel, every force on it; where contact is a constraint,
    /// every input.
    Acceleration(&'static [usize]),
    /// The acceleration that an input of the speed imposes, and nothing else.
    Imposed,
}

/// Where the inputs of the rail under each wheel begin; its displacements stand before its velocities and slopes.
const LEFT_RAIL: usize = WHEELSET_INPUTS;
const RIGHT_RAIL: usize = WHEELSET_INPUTS + RAIL_INPUTS;
const DISPLACEMENTS: usize = RAIL_LATERAL_VELOCITY;
const BOTH_RAILS: usize = 2 * RAIL_INPUTS;

/// `listed`, then inputs in their order beginning with `from`, `N` in all.
const fn then<const M: usize, const N: usize>(listed: [usize; M], from: usize) -> [usize; N] {
    let mut all = [from; N];
    let mut i = 0;
    while i < N {
        all[i] = if i < M { listed[i] } else { from + i - M };
        i += 1;
    }
    all
}

/// What acts on the whole wheelset: an input, and with frictions the rails.
const fn and_wheels(input: usize) -> [usize; 3 + BOTH_RAILS] {
    then([input, LEFT_FRICTION, RIGHT_FRICTION], LEFT_RAIL)
}

/// Coordinates and velocities alone.
pub(super) const STATE: Depends = Depends::Only(&[]);
/// Frictions of both wheels, and with them the rails under them.
pub(super) const FRICTION_INPUTS: &[usize] = &then::<2, { 2 + BOTH_RAILS }>([LEFT_FRICTION, RIGHT_FRICTION], LEFT_RAIL);
/// Of the force that an imposed speed asks for.
pub(super) const DRIVING: Depends = Depends::Acceleration(FRICTION_INPUTS);
/// A torque about the axle turns it by rounding only, but not by nothing.
pub(super) const TURNING: Depends = Depends::Acceleration(&and_wheels(DRIVE_TORQUE));
pub(super) const ALONG: Depends = Depends::Acceleration(&and_wheels(LONGITUDINAL_FORCE));
pub(super) const ACROSS: Depends = Depends::Acceleration(&and_wheels(LATERAL_FORCE));
pub(super) const UPWARD: Depends = Depends::Acceleration(&and_wheels(VERTICAL_FORCE));
pub(super) const ALL: &[usize] = &then::<0, { WHEELSET_INPUTS + BOTH_RAILS }>([], 0);

/// Outputs of one wheel.
#[derive(Clone, Copy)]
pub(super) struct WheelDepends {
    /// Where contacts are.
    pub place: Depends,
    /// How they slip.
    pub slip: Depends,
    /// The normal force, which is a matter of state where contact is elastic and rails rest.
    pub pressing: Depends,
    /// Creep forces, and with them the total.
    pub friction: Depends,
}

pub(super) fn of_wheel(side: Side) -> WheelDepends {
    const LEFT: &[usize; 1 + RAIL_INPUTS] = &then([LEFT_FRICTION], LEFT_RAIL);
    const RIGHT: &[usize; 1 + RAIL_INPUTS] = &then([RIGHT_FRICTION], RIGHT_RAIL);
    let friction: &'static [usize] = if side == Side::Left { LEFT } else { RIGHT };
    let motion = &friction[1..];
    WheelDepends {
        place: Depends::Only(&motion[..DISPLACEMENTS]),
        slip: Depends::Only(motion),
        pressing: Depends::Contact(motion),
        friction: Depends::Contact(friction),
    }
}

/// Bodies that joints tie together, directly or by others: a force on one of them accelerates all at once, and no other body.
pub(super) struct Ties {
    /// By body: all that it is tied to and itself, in order.
    groups: Vec<Arc<[usize]>>,
}

impl Ties {
    pub(super) fn of(model: &Model) -> Ties {
        let count = model.system.bodies.len();
        let mut first: Vec<usize> = (0..count).collect();
        for joint in &model.system.joints {
            if let Some(second) = joint.bodies.second {
                let (a, b) = (first[joint.bodies.first], first[second]);
                first.iter_mut().filter(|own| **own == a.max(b)).for_each(|own| *own = a.min(b));
            }
        }
        let group = |body: usize| (0..count).filter(|other| first[*other] == first[body]).collect();
        Ties { groups: (0..count).map(group).collect() }
    }

    /// A body and all that it is tied to.
    pub(super) fn group(&self, body: usize) -> &Arc<[usize]> {
        &self.groups[body]
    }
}

/// Whose forces change an output at the same instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Those of these bodies; a wheelset is the body of the same number.
    Bodies(Arc<[usize]>),
    /// Those of every body.
    Every,
}

impl Reach {
    fn covers(&self, body: usize) -> bool {
        match self {
            Reach::Bodies(bodies) => bodies.contains(&body),
            Reach::Every => true,
        }
    }
}

/// Inputs of which force elements change what an output shows at the same instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActedOn {
    Nothing,
    /// Those that load bodies within reach.
    Loads,
    /// Those of the vehicle's force element of this number: what it reports.
    Element(usize),
    /// Of none, but those of the speed.
    Speed,
}

/// The inputs that an output depends on at the same instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feedthrough {
    /// Numbers of a wheelset's inputs.
    inputs: &'static [usize],
    reach: Reach,
    acted_on: ActedOn,
    /// The input of the wheelset that enters with a factor which parameters alone say: a force over the mass.
    fixed: Option<usize>,
}

/// Forces and torque on a wheelset by number, with which its accelerations change.
const FORCES: [usize; 4] = [DRIVE_TORQUE, LATERAL_FORCE, VERTICAL_FORCE, LONGITUDINAL_FORCE];

impl Feedthrough {
    /// Nothing: the state alone.
    pub(super) fn none() -> Feedthrough {
        Feedthrough { inputs: &[], reach: Reach::Bodies(Arc::new([])), acted_on: ActedOn::Nothing, fixed: None }
    }

    /// Of what a force element reports.
    pub(super) fn of_element(number: usize) -> Feedthrough {
        Feedthrough { acted_on: ActedOn::Element(number), ..Feedthrough::none() }
    }

    /// Of a wheelset's output.
    pub(super) fn of_wheelset(model: &Model, ties: &Ties, body: usize, depends: Depends) -> Feedthrough {
        let own = |inputs| Feedthrough { inputs, reach: Reach::Bodies(Arc::new([body])), ..Feedthrough::none() };
        match depends {
            Depends::Only(inputs) => own(inputs),
            Depends::Imposed => Feedthrough { acted_on: ActedOn::Speed, ..own(&[]) },
            Depends::Contact(_) | Depends::Acceleration(_) if model.formulation.constrains() => Feedthrough::every(),
            Depends::Contact(inputs) => own(inputs),
            Depends::Acceleration(inputs) => {
                let alone = ties.group(body).len() == 1 && model.track.line().is_none();
                let fixed = inputs.iter().copied().find(|input| FORCES.contains(input) && *input != DRIVE_TORQUE);
                Feedthrough {
                    inputs: if alone { inputs } else { ALL },
                    fixed: fixed.filter(|_| alone),
                    ..Feedthrough::of_acceleration(model, ties, body)
                }
            }
        }
    }

    /// Of accelerations of a body in all directions.
    pub(super) fn of_acceleration(model: &Model, ties: &Ties, body: usize) -> Feedthrough {
        if model.formulation.constrains() {
            return Feedthrough::every();
        }
        let reach = Reach::Bodies(Arc::clone(ties.group(body)));
        Feedthrough { inputs: ALL, reach, acted_on: ActedOn::Loads, fixed: None }
    }

    /// Every input.
    pub(super) fn every() -> Feedthrough {
        Feedthrough { inputs: ALL, reach: Reach::Every, acted_on: ActedOn::Loads, fixed: None }
    }

    /// Does input `number` of a wheelset change the output?
    pub fn by_wheelset(&self, wheelset: usize, number: usize) -> bool {
        self.reach.covers(wheelset) && self.inputs.contains(&number)
    }

    /// Does an input of this element, between these bodies, change it?
    pub fn by_element(&self, element: usize, bodies: &[Option<usize>]) -> bool {
        match self.acted_on {
            ActedOn::Nothing | ActedOn::Speed => false,
            ActedOn::Loads => bodies.iter().flatten().any(|body| self.reach.covers(*body)),
            ActedOn::Element(own) => own == element,
        }
    }

    /// Does the acceleration along the track change it that an input imposes on these bodies? What acts across it, alone on straight track, does not feel it.
    pub fn by_speed(&self, driven: &[usize]) -> bool {
        let along = self.inputs.contains(&LONGITUDINAL_FORCE) || !self.inputs.iter().any(|input| FORCES.contains(input));
        let reacts = self.acted_on == ActedOn::Speed || self.acted_on == ActedOn::Loads && along;
        reacts && driven.iter().any(|body| self.reach.covers(*body))
    }

    /// Is the factor of this input of a wheelset, on which it depends, a number that parameters alone say?
    pub fn is_fixed(&self, number: usize) -> bool {
        self.fixed == Some(number)
    }
}

/// The wheelset of an input of a model with `wheelsets` wheelsets, and its number there.
pub fn whose(wheelsets: usize, input: usize) -> (usize, usize) {
    match input.checked_sub(WHEELSET_INPUTS * wheelsets) {
        None => (input / WHEELSET_INPUTS, input % WHEELSET_INPUTS),
        Some(rail) => (rail / (2 * RAIL_INPUTS), WHEELSET_INPUTS + rail % (2 * RAIL_INPUTS)),
    }
}
