//! Getting and setting variables; arrays stand for the values of their elements.

use super::super::common::{guard, refuse, report, slice, slice_mut};
use super::super::component::Component as Instance;
use super::super::session::{Boolean, FALSE};
use super::super::types::{Component as Fmi3Instance, FmiString, Status, ValueReference};
use super::super::values::{NULL, fmi2GetInteger, fmi2GetString, fmi2SetInteger, fmi2SetString, get, set_truths};
use super::{call, in_update};
use crate::fmi::variables::Role;

/// Why the host's function may not reach these variables, if it may not.
fn out_of_reach(component: &Instance, references: &[u32], set: bool) -> Option<String> {
    if !component.session.updating {
        return None;
    }
    let is_input = |reference| component.instance.table().find(reference).is_some_and(|found| matches!(found.role, Role::Input(_)));
    let within = |reference: u32| component.session.reachable.binary_search(&reference).is_ok() && (!set || is_input(reference));
    let other = references.iter().find(|reference| !within(**reference))?;
    let what = if set { "set: it is no input" } else { "read: it is none" };
    Some(format!("value reference {other} can't be {what} of requiredIntermediateVariables"))
}

/// Runs a call on the scalars behind `nvr` references with as many values; so many times each reference where it stands for many.
pub(super) fn with_scalars(
    component: &mut Instance,
    references: &[u32],
    values: usize,
    set: bool,
    run: impl FnOnce(&mut Instance, &[u32]) -> Status,
) -> Status {
    if let Some(why) = out_of_reach(component, references, set) {
        return refuse(component, &why);
    }
    let count: usize = references.iter().map(|reference| component.instance.table().size(*reference)).sum();
    if count != values {
        return refuse(component, &format!("nValues is {values}, but these variables have {count} values"));
    }
    if count == references.len() {
        return run(component, references);
    }
    let scalars = component.instance.table().scalars(references);
    run(component, &scalars)
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    values: *mut f64,
    n_values: usize,
) -> Status {
    guard(c, |component| {
        let (Some(references), Some(values)) = (unsafe { slice(vr, nvr) }, unsafe { slice_mut(values, n_values) }) else {
            return refuse(component, NULL);
        };
        with_scalars(component, references, values.len(), false, |component, scalars| {
            let answer = component.instance.get_real(scalars, values);
            report(component, answer)
        })
    })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    values: *const f64,
    n_values: usize,
) -> Status {
    guard(c, |component| {
        let (Some(references), Some(values)) = (unsafe { slice(vr, nvr) }, unsafe { slice(values, n_values) }) else {
            return refuse(component, NULL);
        };
        with_scalars(component, references, values.len(), true, |component, scalars| {
            let answer = component.instance.set_real(scalars, values);
            report(component, answer)
        })
    })
}

/// What `run` answers for scalars, one value a reference; refused in intermediate update mode.
fn one_each(c: Fmi3Instance, function: &str, nvr: usize, n_values: usize, run: impl FnOnce() -> Status) -> Status {
    match in_update(c, function) {
        Some(status) => status,
        None if nvr == n_values => run(),
        None => guard(c, |component| refuse(component, &format!("{function}: nValues is {n_values} for {nvr} scalar variables"))),
    }
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(c: Fmi3Instance, vr: *const ValueReference, nvr: usize, values: *mut i32, n_values: usize) -> Status {
    one_each(c, "fmi3GetInt32", nvr, n_values, || unsafe { fmi2GetInteger(c, vr, nvr, values) })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt32(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    values: *const i32,
    n_values: usize,
) -> Status {
    one_each(c, "fmi3SetInt32", nvr, n_values, || unsafe { fmi2SetInteger(c, vr, nvr, values) })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBoolean(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    values: *mut Boolean,
    n_values: usize,
) -> Status {
    one_each(c, "fmi3GetBoolean", nvr, n_values, || unsafe {
        get(c, vr, nvr, values, |component, reference| component.instance.get_boolean(reference).map(Boolean::from))
    })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBoolean(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    values: *const Boolean,
    n_values: usize,
) -> Status {
    one_each(c, "fmi3SetBoolean", nvr, n_values, || unsafe { set_truths(c, vr, nvr, values, |value| value != FALSE) })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused. The strings live until the next call on the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetString(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    values: *mut FmiString,
    n_values: usize,
) -> Status {
    one_each(c, "fmi3GetString", nvr, n_values, || unsafe { fmi2GetString(c, vr, nvr, values) })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetString(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    values: *const FmiString,
    n_values: usize,
) -> Status {
    one_each(c, "fmi3SetString", nvr, n_values, || unsafe { fmi2SetString(c, vr, nvr, values) })
}

/// Exports functions for types that no variable has: no reference is one of theirs.
macro_rules! absent {
    ($($type:literal: $get:ident, $set:ident, $value:ty;)*) => {
        $(
            absent!(one $get, $type, *mut $value);
            absent!(one $set, $type, *const $value);
        )*
    };
    (one $name:ident, $type:literal, $values:ty) => {
        /// No variable is of this type.
        ///
        /// # Safety
        /// The instance must be null or come from this library.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: Fmi3Instance, vr: *const ValueReference, nvr: usize, _values: $values, _n: usize) -> Status {
            call(c, stringify!($name), |component| unsafe { none_of(component, $type, vr, nvr) })
        }
    };
}

/// # Safety
/// `vr` must be null or `nvr` long.
unsafe fn none_of(component: &mut Instance, kind: &str, vr: *const ValueReference, nvr: usize) -> Status {
    match unsafe { slice(vr, nvr) } {
        None => refuse(component, NULL),
        Some([]) => Status::Ok,
        Some([first, ..]) => refuse(component, &format!("there is no {kind} variable with value reference {first}")),
    }
}

absent! {
    "Float32": fmi3GetFloat32, fmi3SetFloat32, f32;
    "Int8": fmi3GetInt8, fmi3SetInt8, i8;
    "UInt8": fmi3GetUInt8, fmi3SetUInt8, u8;
    "Int16": fmi3GetInt16, fmi3SetInt16, i16;
    "UInt16": fmi3GetUInt16, fmi3SetUInt16, u16;
    "UInt32": fmi3GetUInt32, fmi3SetUInt32, u32;
    "Int64": fmi3GetInt64, fmi3SetInt64, i64;
    "UInt64": fmi3GetUInt64, fmi3SetUInt64, u64;
}

/// No variable is binary.
///
/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBinary(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    _sizes: *mut usize,
    _values: *mut *const u8,
    _n_values: usize,
) -> Status {
    call(c, "fmi3GetBinary", |component| unsafe { none_of(component, "Binary", vr, nvr) })
}

/// No variable is binary.
///
/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBinary(
    c: Fmi3Instance,
    vr: *const ValueReference,
    nvr: usize,
    _sizes: *const usize,
    _values: *const *const u8,
    _n_values: usize,
) -> Status {
    call(c, "fmi3SetBinary", |component| unsafe { none_of(component, "Binary", vr, nvr) })
}
