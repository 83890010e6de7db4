//! Saving, restoring and serialising the state of an instance: as in FMI 2.0.

use super::super::states::{free, get, read, set, size, write};
use super::super::types::{Component, FmuState, Status};
use super::as_in_two;

/// # Safety
/// `state` must be null or point to null or to a state of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(c: Component, state: *mut FmuState) -> Status {
    as_in_two(c, "fmi3GetFMUState", || unsafe { get(c, "fmi3GetFMUState", state) })
}

/// # Safety
/// `state` must be null or a state of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(c: Component, state: FmuState) -> Status {
    as_in_two(c, "fmi3SetFMUState", || unsafe { set(c, "fmi3SetFMUState", state) })
}

/// # Safety
/// `state` must be null or point to null or to a state of this library. A stopped instance gives its states back too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(c: Component, state: *mut FmuState) -> Status {
    unsafe { free(c, "fmi3FreeFMUState", state) }
}

/// # Safety
/// `state` must be null or a state of this library, `bytes` null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(c: Component, state: FmuState, bytes: *mut usize) -> Status {
    as_in_two(c, "fmi3SerializedFMUStateSize", || unsafe { size(c, "fmi3SerializedFMUStateSize", state, bytes) })
}

/// # Safety
/// `state` must be null or a state of this library, `bytes` null or `size` bytes long.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(c: Component, state: FmuState, bytes: *mut u8, size: usize) -> Status {
    as_in_two(c, "fmi3SerializeFMUState", || unsafe { write(c, "fmi3SerializeFMUState", state, bytes, size) })
}

/// # Safety
/// `bytes` must be null or `size` bytes long, `state` null or point to null or to a state of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(c: Component, bytes: *const u8, size: usize, state: *mut FmuState) -> Status {
    as_in_two(c, "fmi3DeserializeFMUState", || unsafe { read(c, "fmi3DeserializeFMUState", bytes, size, state) })
}
