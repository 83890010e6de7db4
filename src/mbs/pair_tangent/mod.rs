//! What a force element hands in of its changes with the motion of its two bodies, and what the elements of a pair of bodies add up to.

pub mod pair;
mod state;

pub use pair::PairTangent;
pub(super) use state::{Across, Terms, TwistTerms, dot};
pub use state::{Ends, Gradient, StateTangent};
