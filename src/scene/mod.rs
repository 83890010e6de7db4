//! Floor 6: from the text of a scene to a model.

pub mod assemble;
mod cautions;
mod detail;
pub mod effects;
pub mod embedded;
pub mod equilibrium;
mod error;
mod fade;
mod identifier;
pub mod improbable;
mod leave_out;
mod limits;
pub mod load;
mod overrides;
pub mod patch_choice;
pub mod plan;
mod profiles;
mod read;
mod remarks;
mod rough_track;
pub mod solver_choice;
pub mod spec;
pub mod start;
pub mod steady_state;
pub mod table_store;
pub mod vehicle;
