//! C types of the FMI 2.0 headers (`fmi2TypesPlatform.h`, `fmi2FunctionTypes.h`), written from the standard.

use std::ffi::{c_char, c_int, c_uint, c_void};

pub type Component = *mut c_void;
pub type ComponentEnvironment = *mut c_void;
pub type FmuState = *mut c_void;
pub type ValueReference = c_uint;
pub type Real = f64;
pub type Integer = c_int;
/// A C int: 0 is false, 1 is true.
pub type Boolean = c_int;
pub type Char = c_char;
pub type FmiString = *const c_char;
pub type Byte = c_char;

pub const FALSE: Boolean = 0;
pub const TRUE: Boolean = 1;

/// fmi2Status.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code)] // the host side and C use all of them
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
    Pending = 5,
}

/// fmi2Type.
pub const CO_SIMULATION: c_int = 1;

/// fmi2StatusKind.
pub const DO_STEP_STATUS: c_int = 0;
pub const PENDING_STATUS: c_int = 1;
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
pub const TERMINATED: c_int = 3;

/// The logger takes printf arguments after the message.
pub type Logger = unsafe extern "C" fn(ComponentEnvironment, FmiString, Status, FmiString, FmiString, ...);

/// fmi2CallbackFunctions. Allocation callbacks are not used (canNotUseMemoryManagementFunctions).
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    pub logger: Option<Logger>,
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    pub step_finished: Option<unsafe extern "C" fn(ComponentEnvironment, Status)>,
    pub component_environment: ComponentEnvironment,
}

/// fmi2EventInfo of model exchange; only its address is passed here.
#[repr(C)]
pub struct EventInfo {
    _private: [u8; 0],
}
