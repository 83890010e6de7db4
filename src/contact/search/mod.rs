//! Contact search: the points of wheel and rail that touch or come closest.

pub mod algebraic;
pub mod nodal;
pub mod nodes;
