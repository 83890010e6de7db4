//! Getting and setting variables.

use super::super::instance::CallError;
use super::super::variables::Kind;
use super::common::{guard, refuse, report, slice, slice_mut};
use super::component::Component as Instance;
use super::text::c_string;
use super::types::*;

pub(super) const NULL: &str = "a pointer to value references or values is NULL";

/// Reads `nvr` values one by one; nothing is written unless all can be read.
///
/// # Safety
/// FMI's rules for pointers; null is refused.
pub(super) unsafe fn get<T: Copy>(
    c: Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *mut T,
    mut read: impl FnMut(&mut Instance, u32) -> Result<T, CallError>,
) -> Status {
    guard(c, |component| {
        let (Some(references), Some(values)) = (unsafe { slice(vr, nvr) }, unsafe { slice_mut(value, nvr) }) else {
            return refuse(component, NULL);
        };
        let found: Result<Vec<T>, CallError> = references.iter().map(|reference| read(component, *reference)).collect();
        report(component, found.map(|found| values.copy_from_slice(&found)))
    })
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: Component, vr: *const ValueReference, nvr: usize, value: *mut Real) -> Status {
    guard(c, |component| {
        let (Some(references), Some(values)) = (unsafe { slice(vr, nvr) }, unsafe { slice_mut(value, nvr) }) else {
            return refuse(component, NULL);
        };
        let answer = component.instance.get_real(references, values);
        report(component, answer)
    })
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: Component, vr: *const ValueReference, nvr: usize, value: *mut Integer) -> Status {
    unsafe { get(c, vr, nvr, value, |component, reference| component.instance.get_integer(reference)) }
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: Component, vr: *const ValueReference, nvr: usize, value: *mut Boolean) -> Status {
    unsafe { get(c, vr, nvr, value, |component, reference| component.instance.get_boolean(reference).map(Boolean::from)) }
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused. The strings live until the next call on the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(c: Component, vr: *const ValueReference, nvr: usize, value: *mut FmiString) -> Status {
    unsafe {
        get(c, vr, nvr, value, |component, reference| {
            let string = c_string(component.instance.get_string(reference)?);
            let pointer = string.as_ptr();
            component.strings.push(string);
            Ok(pointer)
        })
    }
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: Component, vr: *const ValueReference, nvr: usize, value: *const Real) -> Status {
    guard(c, |component| {
        let (Some(references), Some(values)) = (unsafe { slice(vr, nvr) }, unsafe { slice(value, nvr) }) else {
            return refuse(component, NULL);
        };
        let answer = component.instance.set_real(references, values);
        report(component, answer)
    })
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: Component, vr: *const ValueReference, nvr: usize, value: *const Boolean) -> Status {
    unsafe { set_truths(c, vr, nvr, value, |value| value != FALSE) }
}

/// Sets `nvr` values that are true or false in the version's own type.
///
/// # Safety
/// FMI's rules for pointers; null is refused.
pub(super) unsafe fn set_truths<T: Copy>(
    c: Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *const T,
    truth: impl Fn(T) -> bool,
) -> Status {
    guard(c, |component| {
        let (Some(references), Some(values)) = (unsafe { slice(vr, nvr) }, unsafe { slice(value, nvr) }) else {
            return refuse(component, NULL);
        };
        let values: Vec<bool> = values.iter().map(|value| truth(*value)).collect();
        let answer = component.instance.set_boolean(references, &values);
        report(component, answer)
    })
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: Component, vr: *const ValueReference, nvr: usize, value: *const Integer) -> Status {
    unsafe { set_nothing(c, vr, nvr, value, Kind::Integer) }
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(c: Component, vr: *const ValueReference, nvr: usize, value: *const FmiString) -> Status {
    unsafe { set_nothing(c, vr, nvr, value, Kind::String) }
}

/// No integer or string can be set; says so for the first reference.
unsafe fn set_nothing<T>(c: Component, vr: *const ValueReference, nvr: usize, value: *const T, kind: Kind) -> Status {
    guard(c, |component| {
        let (Some(references), false) = (unsafe { slice(vr, nvr) }, nvr > 0 && value.is_null()) else { return refuse(component, NULL) };
        let answer = component.instance.refuse_to_set(references, kind);
        report(component, answer)
    })
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: Component,
    vr: *const ValueReference,
    nvr: usize,
    order: *const Integer,
    value: *const Real,
) -> Status {
    guard(c, |component| {
        let slices = unsafe { (slice(vr, nvr), slice(order, nvr), slice(value, nvr)) };
        let (Some(references), Some(orders), Some(values)) = slices else { return refuse(component, NULL) };
        let answer = component.instance.set_input_derivatives(references, orders, values);
        report(component, answer)
    })
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: Component,
    vr: *const ValueReference,
    nvr: usize,
    order: *const Integer,
    value: *mut Real,
) -> Status {
    guard(c, |component| {
        let slices = unsafe { (slice(vr, nvr), slice(order, nvr), slice_mut(value, nvr)) };
        let (Some(references), Some(orders), Some(values)) = slices else { return refuse(component, NULL) };
        let answer = component.instance.get_output_derivatives(references, orders, values);
        report(component, answer)
    })
}

/// # Safety
/// FMI 2.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: Component,
    unknown: *const ValueReference,
    n_unknown: usize,
    known: *const ValueReference,
    n_known: usize,
    dv_known: *const Real,
    dv_unknown: *mut Real,
) -> Status {
    guard(c, |component| {
        let unknowns = unsafe { (slice(unknown, n_unknown), slice_mut(dv_unknown, n_unknown)) };
        let knowns = unsafe { (slice(known, n_known), slice(dv_known, n_known)) };
        let ((Some(unknowns), Some(derivatives)), (Some(knowns), Some(seeds))) = (unknowns, knowns) else {
            return refuse(component, NULL);
        };
        let answer = component.instance.directional_derivative(unknowns, (knowns, seeds), derivatives);
        report(component, answer)
    })
}
