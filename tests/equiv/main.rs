//! Two ways of ours to the same result.

#[path = "../common/mod.rs"]
mod common;

mod assess;
mod curves;
mod formulations;
mod half_spaces;
mod linear;
mod patches;
mod rigid_places;
