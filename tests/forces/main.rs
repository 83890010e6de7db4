//! Force elements: properties that all of them share, and each against its formula.

#[path = "../common/counting.rs"]
mod counting;

mod friction;
mod laws;
mod motion;
mod properties;
mod stage;
mod tangent;
