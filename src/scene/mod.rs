//! Floor 6: from the text of a scene to a model.

pub mod assemble;
mod cautions;
pub mod embedded;
pub mod equilibrium;
mod fade;
mod identifier;
pub mod load;
mod overrides;
pub mod plan;
mod remarks;
pub mod solver_choice;
pub mod spec;
pub mod start;
pub mod vehicle;
