//! What outputs depend on at the same instant.
//!
//! Inputs of one wheelset are numbered as in `formulation`: its own first, then those of the rail under its left and its right wheel.
//! Lists may name inputs that a scene does not have.

use crate::formulation::{
    DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, LONGITUDINAL_FORCE, RAIL_INPUTS, RAIL_LATERAL_VELOCITY, RIGHT_FRICTION, VERTICAL_FORCE,
    WHEELSET_INPUTS,
};
use crate::geometry::Side;
use crate::mbs::pair_tangent::Ends;

/// What an output depends on at the same instant.
#[derive(Clone, Copy)]
pub(super) enum Depends {
    /// These inputs of the wheelset, and never another.
    Only(&'static [usize]),
    /// These inputs of the wheelset, and all inputs where contact or a joint is a constraint (its forces depend on accelerations).
    On(&'static [usize]),
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
pub(super) const FRICTIONS: Depends = Depends::On(FRICTION_INPUTS);
/// A torque about the axle turns it by rounding only, but not by nothing.
pub(super) const TURNING: Depends = Depends::On(&and_wheels(DRIVE_TORQUE));
pub(super) const ALONG: Depends = Depends::On(&and_wheels(LONGITUDINAL_FORCE));
pub(super) const ACROSS: Depends = Depends::On(&and_wheels(LATERAL_FORCE));
pub(super) const UPWARD: Depends = Depends::On(&and_wheels(VERTICAL_FORCE));
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
        pressing: Depends::On(motion),
        friction: Depends::On(friction),
    }
}

/// Inputs of which force elements change what an output shows at the same instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActedOn {
    Nothing,
    /// That load this body: its accelerations.
    Body(usize),
    /// All: accelerations of a system with constraints.
    System,
    /// Of the vehicle's force element of that number: what it reports.
    Element(usize),
}

impl ActedOn {
    /// Of an output that depends on inputs of a wheelset, which is the body of the same number (`None`: on those of all).
    pub(super) fn of_wheelset(feedthrough: &[usize], wheelset: Option<usize>) -> ActedOn {
        let accelerates = [DRIVE_TORQUE, LATERAL_FORCE, VERTICAL_FORCE, LONGITUDINAL_FORCE].iter().any(|force| feedthrough.contains(force));
        match (accelerates, wheelset) {
            (false, _) => ActedOn::Nothing,
            (true, Some(wheelset)) => ActedOn::Body(wheelset),
            (true, None) => ActedOn::System,
        }
    }

    /// Does an input of this element, between these bodies, change the output?
    pub fn by(self, element: usize, ends: &Ends) -> bool {
        match self {
            ActedOn::Nothing => false,
            ActedOn::Body(body) => ends.contains(&Some(body)),
            ActedOn::System => true,
            ActedOn::Element(own) => own == element,
        }
    }
}

/// The wheelset of an input of a model with `wheelsets` wheelsets, and its number there.
pub fn whose(wheelsets: usize, input: usize) -> (usize, usize) {
    match input.checked_sub(WHEELSET_INPUTS * wheelsets) {
        None => (input / WHEELSET_INPUTS, input % WHEELSET_INPUTS),
        Some(rail) => (rail / (2 * RAIL_INPUTS), WHEELSET_INPUTS + rail % (2 * RAIL_INPUTS)),
    }
}
