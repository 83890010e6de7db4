//! `wheelrail`: vehicles on nonlinear three-dimensional wheel/rail contact, from a scene file to an FMI 2.0
//! co-simulation FMU.
//!
//! The house has floors; a module uses only lower ones (`tests/architecture/` checks it): mathematics, units and
//! settings (0), geometry (1), contact (2), multibody system (3), formulations (4), integration (5, needs only 0),
//! scenes (6), simulation (7), FMI and studies (8), command line (9).
#![deny(unsafe_code)]

pub mod cli;
pub mod contact;
pub mod fmi;
pub mod formulation;
pub mod geometry;
pub mod math;
pub mod mbs;
pub mod scene;
pub mod settings;
pub mod sim;
pub mod solve;
pub mod study;
pub mod units;
