//! What every exported function needs: the guard around it, slices from pointers, text.

use super::component::Component as Instance;
use super::types::*;
use std::ffi::CStr;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs a call on an instance: null and poisoned instances answer fmi2Error, a panic poisons the instance.
pub fn guard(c: Component, call: impl FnOnce(&mut Instance) -> Status) -> Status {
    let Some(component) = (unsafe { c.cast::<Instance>().as_mut() }) else { return Status::Error };
    if component.poisoned {
        component.log.error(Status::Error, "this instance was stopped by an internal error; free it and make a new one");
        return Status::Error;
    }
    match catch_unwind(AssertUnwindSafe(|| {
        component.strings.clear();
        call(component)
    })) {
        Ok(status) => status,
        Err(panic) => {
            component.poisoned = true;
            let what = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied()).unwrap_or("unknown");
            component.log.error(Status::Error, &format!("internal error, please report it: {what}"));
            Status::Error
        }
    }
}

/// Exports functions that refuse, and say why.
macro_rules! refused {
    ($why:literal; $($name:ident($($argument:ident: $type:ty),*);)*) => {
        $(
            /// Refused: see the module.
            ///
            /// # Safety
            /// The instance must be null or come from this library.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(c: Component, $($argument: $type),*) -> Status {
                guard(c, |component| refuse(component, concat!(stringify!($name), " ", $why)))
            }
        )*
    };
}
pub(super) use refused;

/// Logs why a call was refused.
pub fn refuse(component: &Instance, message: &str) -> Status {
    component.log.error(Status::Error, message);
    Status::Error
}

/// A status from an answer; errors are logged.
pub fn report<E: std::fmt::Display>(component: &Instance, answer: Result<(), E>) -> Status {
    match answer {
        Ok(()) => Status::Ok,
        Err(error) => refuse(component, &error.to_string()),
    }
}

/// Text from the host; `None` for null or text that is not UTF-8.
///
/// # Safety
/// The pointer must be null or a null-terminated string.
pub unsafe fn text(pointer: FmiString) -> Option<String> {
    if pointer.is_null() {
        return None;
    }
    unsafe { CStr::from_ptr(pointer) }.to_str().ok().map(str::to_owned)
}

/// `n` values behind a pointer; an empty slice for n = 0, `None` for null.
///
/// # Safety
/// The pointer must be null or point to `n` values that live as long as the call.
pub unsafe fn slice<'a, T>(pointer: *const T, n: usize) -> Option<&'a [T]> {
    if n == 0 {
        Some(&[])
    } else if pointer.is_null() {
        None
    } else {
        Some(unsafe { std::slice::from_raw_parts(pointer, n) })
    }
}

/// Like [`slice`], to be written to.
///
/// # Safety
/// See [`slice`]; nothing else may refer to the values during the call.
pub unsafe fn slice_mut<'a, T>(pointer: *mut T, n: usize) -> Option<&'a mut [T]> {
    if n == 0 {
        Some(&mut [])
    } else if pointer.is_null() {
        None
    } else {
        Some(unsafe { std::slice::from_raw_parts_mut(pointer, n) })
    }
}
