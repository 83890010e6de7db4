//! Floor 6: from the text of a scene to a model.

pub mod assemble;
pub mod embedded;
pub mod equilibrium;
pub mod load;
mod overrides;
pub mod plan;
pub mod solver_choice;
mod remarks;
pub mod spec;
pub mod start;
pub mod vehicle;
