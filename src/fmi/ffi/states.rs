//! Saving, restoring and serialising the state of an instance.
//!
//! A state belongs to the instance that made it: that one frees it, at the latest when it is freed itself. While it lives, another instance of the
//! same FMU may read it. Functions without a version do the work of both.

use super::super::instance::SavedState;
use super::common::{guard, refuse, report, slice};
use super::component::Component as Instance;
use super::types::*;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Behind an fmi2FMUstate or fmi3FMUState. The mark often catches a pointer that is not one; FMI obliges the host to pass none.
struct Held {
    mark: u64,
    state: SavedState,
}

const MARK: u64 = 0x5748_4545_4c53_5441;

/// A new state of an instance.
fn keep(component: &mut Instance, state: SavedState) -> FmuState {
    let pointer: FmuState = Box::into_raw(Box::new(Held { mark: MARK, state })).cast();
    component.states.insert(pointer);
    pointer
}

/// # Safety
/// `pointer` must come from [`keep`] and is not used again.
unsafe fn release(pointer: FmuState) {
    let mut held = unsafe { Box::from_raw(pointer.cast::<Held>()) };
    // Whoever still holds the pointer mostly finds that it is no state any more.
    unsafe { std::ptr::write_volatile(&raw mut held.mark, 0) };
}

/// Frees the states that the host has left.
pub(super) fn release_all(component: &mut Instance) {
    for pointer in component.states.drain() {
        unsafe { release(pointer) };
    }
}

unsafe fn held<'a>(state: FmuState) -> Option<&'a mut Held> {
    unsafe { state.cast::<Held>().as_mut() }.filter(|held| held.mark == MARK)
}

/// # Safety
/// `state` must be null or point to null or to a state of this library.
pub(super) unsafe fn get(c: Component, function: &str, state: *mut FmuState) -> Status {
    guard(c, |component| {
        let Some(target) = (unsafe { state.as_mut() }) else { return refuse(component, &format!("{function}: the state pointer is NULL")) };
        let saved = component.instance.save();
        unsafe { put(component, function, target, saved) }
    })
}

/// Puts a state where the host wants it: a new one, or in place of the one there.
///
/// # Safety
/// `target` must be null or a state of this library.
unsafe fn put(component: &mut Instance, function: &str, target: &mut FmuState, saved: SavedState) -> Status {
    if target.is_null() {
        *target = keep(component, saved);
        return Status::Ok;
    }
    match unsafe { held(*target) } {
        Some(held) => {
            held.state = saved;
            Status::Ok
        }
        None => refuse(component, &format!("{function}: the pointer is neither NULL nor a state of this FMU")),
    }
}

/// # Safety
/// `state` must be null or a state of this library.
pub(super) unsafe fn set(c: Component, function: &str, state: FmuState) -> Status {
    guard(c, |component| match unsafe { held(state) } {
        Some(held) => {
            let answer = component.instance.restore(&held.state);
            if answer.is_ok() {
                component.last_step = Status::Ok;
                component.derailed = false;
            }
            report(component, answer)
        }
        None => refuse(component, &format!("{function}: the pointer is not a state of this FMU")),
    })
}

/// # Safety
/// `state` must be null or point to null or to a state of this library.
pub(super) unsafe fn free(c: Component, function: &str, state: *mut FmuState) -> Status {
    // A stopped instance must still be able to give its states back.
    let freed = catch_unwind(AssertUnwindSafe(|| {
        let target = unsafe { state.as_mut() }?;
        let component = unsafe { c.cast::<Instance>().as_mut() }?;
        if !component.states.remove(target) {
            return None;
        }
        unsafe { release(std::mem::replace(target, std::ptr::null_mut())) };
        Some(())
    }));
    match freed {
        Ok(Some(())) => Status::Ok,
        _ => guard(c, |component| match unsafe { state.as_ref() } {
            None => refuse(component, &format!("{function}: the state pointer is NULL")),
            Some(target) if target.is_null() => Status::Ok,
            Some(_) => {
                refuse(component, &format!("{function}: the pointer is not a state of this instance; the one that made a state frees it"))
            }
        }),
    }
}

/// # Safety
/// `state` must be null or a state of this library, `size` null or valid.
pub(super) unsafe fn size(c: Component, function: &str, state: FmuState, size: *mut usize) -> Status {
    guard(c, |component| {
        let (Some(held), Some(size)) = (unsafe { held(state) }, unsafe { size.as_mut() }) else {
            return refuse(component, &format!("{function}: the state or the size pointer is not valid"));
        };
        let answer = component.instance.serialized_size(&held.state).map(|bytes| *size = bytes);
        report(component, answer)
    })
}

/// # Safety
/// `state` must be null or a state of this library, `bytes` null or `size` bytes long.
pub(super) unsafe fn write(c: Component, function: &str, state: FmuState, bytes: *mut u8, size: usize) -> Status {
    guard(c, |component| {
        let Some(held) = (unsafe { held(state) }) else {
            return refuse(component, &format!("{function}: the pointer is not a state of this FMU"));
        };
        if bytes.is_null() {
            return refuse(component, &format!("{function}: the buffer is NULL"));
        }
        match component.instance.serialize(&held.state) {
            Ok(blob) if blob.len() <= size => {
                unsafe { std::ptr::copy_nonoverlapping(blob.as_ptr(), bytes, blob.len()) };
                Status::Ok
            }
            Ok(blob) => refuse(component, &format!("{function}: the buffer holds {size} bytes, {} are needed", blob.len())),
            Err(error) => refuse(component, &error.to_string()),
        }
    })
}

/// # Safety
/// `bytes` must be null or `size` bytes long, `state` null or point to null or to a state of this library.
pub(super) unsafe fn read(c: Component, function: &str, bytes: *const u8, size: usize, state: *mut FmuState) -> Status {
    guard(c, |component| {
        let (Some(blob), Some(target)) = (unsafe { slice(bytes, size) }, unsafe { state.as_mut() }) else {
            return refuse(component, &format!("{function}: the buffer or the state pointer is NULL"));
        };
        match component.instance.deserialize(blob) {
            Ok(saved) => unsafe { put(component, function, target, saved) },
            Err(error) => refuse(component, &error.to_string()),
        }
    })
}

/// # Safety
/// See [`get`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status {
    unsafe { get(c, "fmi2GetFMUstate", state) }
}

/// # Safety
/// See [`set`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: Component, state: FmuState) -> Status {
    unsafe { set(c, "fmi2SetFMUstate", state) }
}

/// # Safety
/// See [`free`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status {
    unsafe { free(c, "fmi2FreeFMUstate", state) }
}

/// # Safety
/// See [`size`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: Component, state: FmuState, bytes: *mut usize) -> Status {
    unsafe { size(c, "fmi2SerializedFMUstateSize", state, bytes) }
}

/// # Safety
/// See [`write`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(c: Component, state: FmuState, bytes: *mut Byte, size: usize) -> Status {
    unsafe { write(c, "fmi2SerializeFMUstate", state, bytes.cast(), size) }
}

/// # Safety
/// See [`read`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(c: Component, bytes: *const Byte, size: usize, state: *mut FmuState) -> Status {
    unsafe { read(c, "fmi2DeSerializeFMUstate", bytes.cast(), size, state) }
}
