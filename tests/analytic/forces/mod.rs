//! Force elements: properties that all of them share, and each against its formula.

mod cardan;
mod friction;
mod laws;
mod motion;
mod properties;
mod stage;
mod tangent;
mod traction;
mod twist;
