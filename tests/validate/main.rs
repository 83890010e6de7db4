//! Against published numbers and other programs.

#[path = "../common/mod.rs"]
mod common;

mod assess;
mod ivp_wheelset;
mod manchester;
mod published;
