//! Floor 8: the FMI 2.0 co-simulation interface.
//!
//! `ffi` holds the C functions and the only unsafe code; it checks pointers, catches panics and calls `instance`, which
//! is safe Rust. Variables come from one table, which also writes modelDescription.xml.

mod build_mark;
pub mod description;
pub mod documentation;
#[allow(unsafe_code)]
pub mod ffi;
pub mod instance;
pub mod package;
mod packed_scene;
pub mod parameters;
mod real_parameter;
pub mod serialized;
pub mod uri;
mod variable;
pub mod variables;
