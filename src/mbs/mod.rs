//! Floor 3: bodies, forces between them, and their equations of motion.

pub mod body;
pub mod carried;
mod constrained;
pub mod constraints;
pub mod driving;
pub mod force;
mod imposed;
pub mod inertia;
pub mod joint;
pub mod kkt;
pub mod motion;
pub mod moving;
pub mod on_track;
pub mod pair_tangent;
pub mod projection;
pub mod redundancy;
pub mod ring;
pub mod speed_input;
pub mod speed_profile;
pub mod supported;
pub mod system;
pub mod tangent;
mod turning_wheels;
pub mod twist;
