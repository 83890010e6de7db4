//! `wheelrail`: vehicles on nonlinear three-dimensional wheel/rail contact, from a scene file to a co-simulation
//! FMU (FMI 2.0 or 3.0).
//!
//! ```
//! use wheelrail::{Simulation, open};
//!
//! let scene = open("wheelset_s1002", &["vehicle.speed=15 m/s".into()])?;
//! let mut simulation = Simulation::new(&scene, 0.0)?;
//! simulation.advance(0.1)?;
//! let left = &simulation.snapshot()?.workspace.contacts[0];
//! assert!(left.normal_force > 1e4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `examples/` has more: a vehicle built in code, a creep law of one's own, a contact alone. With `default-features = false` the library comes without
//! the command line (`cli`) and its pictures (`plot`).
//!
//! The house has floors; a module uses only lower ones (`tests/architecture/` checks it): mathematics, units and
//! settings (0), geometry (1), contact (2), multibody system (3), formulations (4), integration (5, needs only 0),
//! scenes (6), simulation (7), FMI and studies (8), command line (9).
#![deny(unsafe_code)]

#[cfg(feature = "cli")]
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

pub use contact::Material;
pub use contact::creep::CreepLaw;
pub use contact::normal::NormalLaw;
pub use formulation::{ContactLaws, Model, Parts, Wheelset};
pub use geometry::profile::Profile;
pub use scene::load::open;
pub use scene::spec::Scene;
pub use sim::Simulation;
pub use solve::Integrator;
