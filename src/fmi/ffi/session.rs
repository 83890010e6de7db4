//! What a host of FMI 3.0 says of itself, and its C types beyond those that both versions share, written from the standard.

use super::types::{ComponentEnvironment, FmiString, Status};

/// A C bool. Read as a byte: a host's value may be neither 0 nor 1, which Rust's own type must never be.
pub type Boolean = u8;
pub const FALSE: Boolean = 0;

/// fmi3DependencyKind: the input enters the output with a factor that parameters alone say.
pub const FIXED: i32 = 2;
/// fmi3DependencyKind: any change of the input may change the output.
pub const DEPENDENT: i32 = 5;

/// fmi3LogMessageCallback.
pub type LogMessage = unsafe extern "C" fn(ComponentEnvironment, Status, FmiString, FmiString);

/// fmi3IntermediateUpdateCallback.
pub type IntermediateUpdate = unsafe extern "C" fn(ComponentEnvironment, f64, bool, bool, bool, bool, *mut Boolean, *mut f64);

/// What a host says when it makes an instance.
#[derive(Default)]
pub struct Session {
    /// It handles events.
    pub event_mode: bool,
    /// Steps may end early.
    pub early_return: bool,
    /// Called after each step of the integrator, with this.
    pub update: Option<IntermediateUpdate>,
    pub environment: Environment,
    /// What may be read and set in it, in ascending order.
    pub reachable: Vec<u32>,
    /// Is that function at work?
    pub updating: bool,
}

/// The host's own pointer, handed back to it and nothing else.
pub struct Environment(pub ComponentEnvironment);

impl Default for Environment {
    fn default() -> Self {
        Environment(std::ptr::null_mut())
    }
}
