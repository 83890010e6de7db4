//! What outputs depend on at the same instant.
//!
//! Inputs of one wheelset are numbered as in `formulation`: its own first, then those of the rail under its left and its right wheel.
//! Lists may name inputs that a scene does not have.

use crate::formulation::{
    DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, LONGITUDINAL_FORCE, RAIL_INPUTS, RAIL_LATERAL, RAIL_LATERAL_SLOPE, RAIL_LATERAL_VELOCITY,
    RAIL_VERTICAL, RAIL_VERTICAL_SLOPE, RAIL_VERTICAL_VELOCITY, RIGHT_FRICTION, VERTICAL_FORCE, WHEELSET_INPUTS,
};
use crate::geometry::Side;

/// What an output depends on at the same instant.
#[derive(Clone, Copy)]
pub(super) enum Depends {
    /// These inputs of the wheelset, and never another.
    Only(&'static [usize]),
    /// These inputs of the wheelset, and all inputs where contact or a joint is a constraint (its forces depend on accelerations).
    On(&'static [usize]),
}

const LEFT_RAIL: usize = WHEELSET_INPUTS;
const RIGHT_RAIL: usize = WHEELSET_INPUTS + RAIL_INPUTS;
const LY: usize = LEFT_RAIL + RAIL_LATERAL;
const LZ: usize = LEFT_RAIL + RAIL_VERTICAL;
const LVY: usize = LEFT_RAIL + RAIL_LATERAL_VELOCITY;
const LVZ: usize = LEFT_RAIL + RAIL_VERTICAL_VELOCITY;
const LSY: usize = LEFT_RAIL + RAIL_LATERAL_SLOPE;
const LSZ: usize = LEFT_RAIL + RAIL_VERTICAL_SLOPE;
const RY: usize = RIGHT_RAIL + RAIL_LATERAL;
const RZ: usize = RIGHT_RAIL + RAIL_VERTICAL;
const RVY: usize = RIGHT_RAIL + RAIL_LATERAL_VELOCITY;
const RVZ: usize = RIGHT_RAIL + RAIL_VERTICAL_VELOCITY;
const RSY: usize = RIGHT_RAIL + RAIL_LATERAL_SLOPE;
const RSZ: usize = RIGHT_RAIL + RAIL_VERTICAL_SLOPE;

/// Coordinates and velocities alone.
pub(super) const STATE: Depends = Depends::Only(&[]);
/// Frictions of both wheels, and with them the rails under them.
pub(super) const FRICTION_INPUTS: &[usize] = &[LEFT_FRICTION, RIGHT_FRICTION, LY, LZ, LVY, LVZ, LSY, LSZ, RY, RZ, RVY, RVZ, RSY, RSZ];
pub(super) const FRICTIONS: Depends = Depends::On(FRICTION_INPUTS);
/// A torque about the axle turns it by rounding only, but not by nothing.
pub(super) const TURNING: Depends =
    Depends::On(&[DRIVE_TORQUE, LEFT_FRICTION, RIGHT_FRICTION, LY, LZ, LVY, LVZ, LSY, LSZ, RY, RZ, RVY, RVZ, RSY, RSZ]);
pub(super) const ALONG: Depends =
    Depends::On(&[LONGITUDINAL_FORCE, LEFT_FRICTION, RIGHT_FRICTION, LY, LZ, LVY, LVZ, LSY, LSZ, RY, RZ, RVY, RVZ, RSY, RSZ]);
pub(super) const ACROSS: Depends =
    Depends::On(&[LATERAL_FORCE, LEFT_FRICTION, RIGHT_FRICTION, LY, LZ, LVY, LVZ, LSY, LSZ, RY, RZ, RVY, RVZ, RSY, RSZ]);
pub(super) const UPWARD: Depends =
    Depends::On(&[VERTICAL_FORCE, LEFT_FRICTION, RIGHT_FRICTION, LY, LZ, LVY, LVZ, LSY, LSZ, RY, RZ, RVY, RVZ, RSY, RSZ]);
pub(super) const ALL: &[usize] = &[
    DRIVE_TORQUE,
    LATERAL_FORCE,
    VERTICAL_FORCE,
    LEFT_FRICTION,
    RIGHT_FRICTION,
    LONGITUDINAL_FORCE,
    LY,
    LZ,
    LVY,
    LVZ,
    LSY,
    LSZ,
    RY,
    RZ,
    RVY,
    RVZ,
    RSY,
    RSZ,
];

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
    match side {
        Side::Left => WheelDepends {
            place: Depends::Only(&[LY, LZ]),
            slip: Depends::Only(&[LY, LZ, LVY, LVZ, LSY, LSZ]),
            pressing: Depends::On(&[LY, LZ, LVY, LVZ, LSY, LSZ]),
            friction: Depends::On(&[LEFT_FRICTION, LY, LZ, LVY, LVZ, LSY, LSZ]),
        },
        Side::Right => WheelDepends {
            place: Depends::Only(&[RY, RZ]),
            slip: Depends::Only(&[RY, RZ, RVY, RVZ, RSY, RSZ]),
            pressing: Depends::On(&[RY, RZ, RVY, RVZ, RSY, RSZ]),
            friction: Depends::On(&[RIGHT_FRICTION, RY, RZ, RVY, RVZ, RSY, RSZ]),
        },
    }
}

/// The wheelset of an input of a model with `wheelsets` wheelsets, and its number there.
pub fn whose(wheelsets: usize, input: usize) -> (usize, usize) {
    match input.checked_sub(WHEELSET_INPUTS * wheelsets) {
        None => (input / WHEELSET_INPUTS, input % WHEELSET_INPUTS),
        Some(rail) => (rail / (2 * RAIL_INPUTS), WHEELSET_INPUTS + rail % (2 * RAIL_INPUTS)),
    }
}
