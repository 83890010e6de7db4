//! Against published numbers and other programs.

#[path = "../common/mod.rs"]
mod common;

mod ivp_wheelset;
mod published;
