//! Floor 8: the FMI 2.0 co-simulation interface.
//!
//! `ffi` holds the C functions and the only unsafe code; it checks pointers, catches panics and calls `instance`, which
//! is safe Rust. Variables come from one table, which also writes modelDescription.xml.

pub mod description;
pub mod documentation;
#[allow(unsafe_code)]
pub mod ffi;
pub mod instance;
pub mod package;
pub mod parameters;
pub mod serialized;
pub mod uri;
pub mod variables;
