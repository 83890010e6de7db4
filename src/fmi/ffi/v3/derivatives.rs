//! Derivatives of outputs: with respect to time, and, where the description says so, to inputs.

use super::super::common::{guard, refuse, refused, report, slice, slice_mut};
use super::super::types::{Component, Status, ValueReference};
use super::super::values::NULL;
use super::values::with_scalars;

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    c: Component,
    vr: *const ValueReference,
    nvr: usize,
    orders: *const i32,
    values: *mut f64,
    n_values: usize,
) -> Status {
    guard(c, |component| {
        let slices = unsafe { (slice(vr, nvr), slice(orders, nvr), slice_mut(values, n_values)) };
        let (Some(references), Some(orders), Some(values)) = slices else { return refuse(component, NULL) };
        with_scalars(component, references, values.len(), false, |component, scalars| {
            let table = component.instance.table();
            // Each element of an array has the array's order.
            let each = references.iter().zip(orders).flat_map(|(reference, order)| std::iter::repeat_n(*order, table.size(*reference)));
            let orders: Vec<i32> = each.collect();
            let answer = component.instance.get_output_derivatives(scalars, &orders, values);
            report(component, answer)
        })
    })
}

// To be answered here once they are provided; the description's capabilities say so too (`DIRECTIONAL_DERIVATIVES`).
refused! {
    "is not supported (providesDirectionalDerivatives and providesAdjointDerivatives are false)";
    fmi3GetDirectionalDerivative(_unknowns: *const ValueReference, _nu: usize, _knowns: *const ValueReference, _nk: usize,
        _seed: *const f64, _ns: usize, _sensitivity: *mut f64, _n: usize);
    fmi3GetAdjointDerivative(_unknowns: *const ValueReference, _nu: usize, _knowns: *const ValueReference, _nk: usize,
        _seed: *const f64, _ns: usize, _sensitivity: *mut f64, _n: usize);
}
