//! Contact search: the points of wheel and rail that touch or come closest.

pub mod algebraic;
pub mod global;
mod humps;
pub mod kinematics;
mod locate;
pub mod migration;
pub mod nodal;
pub mod nodes;
pub mod point_contact;
mod section;
#[cfg(test)]
mod test_surfaces;
