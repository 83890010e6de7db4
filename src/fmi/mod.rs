//! Floor 8: the co-simulation interface, FMI 2.0 and 3.0.
//!
//! `ffi` holds the C functions of both versions and the only unsafe code; it checks pointers, catches panics and calls `instance`, which
//! is safe Rust and knows no version. Variables come from one table, which also writes modelDescription.xml.

mod additions;
mod build_mark;
#[cfg(feature = "cli")]
pub mod check;
pub mod description;
pub mod documentation;
#[allow(unsafe_code)]
pub mod ffi;
pub mod instance;
pub mod libraries;
pub mod package;
mod packed_scene;
pub mod parameters;
pub mod platform;
mod real_parameter;
pub mod reference_results;
pub mod system_structure;
mod terminals;
pub mod uri;
mod variable;
pub mod variables;
mod vehicle_picture;
pub mod version;
