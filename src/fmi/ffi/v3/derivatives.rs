//! Derivatives of outputs: with respect to time, and, where the description says so, to inputs.

use super::super::common::{guard, refuse, report, slice, slice_mut};
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

/// Unknowns with their number of values, knowns with theirs: pointers as they come.
struct Pairs {
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    seeds: *const f64,
    n_seeds: usize,
    derivatives: *mut f64,
    n_derivatives: usize,
}

/// Derivatives by the scalars of both lists; `adjoint`: the seeds are those of the unknowns.
unsafe fn derive(c: Component, pairs: Pairs, adjoint: bool) -> Status {
    guard(c, |component| {
        let lists = unsafe { (slice(pairs.unknowns, pairs.n_unknowns), slice(pairs.knowns, pairs.n_knowns)) };
        let numbers = unsafe { (slice(pairs.seeds, pairs.n_seeds), slice_mut(pairs.derivatives, pairs.n_derivatives)) };
        let ((Some(unknowns), Some(knowns)), (Some(seeds), Some(derivatives))) = (lists, numbers) else { return refuse(component, NULL) };
        let (of_unknowns, of_knowns) = if adjoint { (seeds.len(), derivatives.len()) } else { (derivatives.len(), seeds.len()) };
        with_scalars(component, unknowns, of_unknowns, false, |component, unknowns| {
            with_scalars(component, knowns, of_knowns, false, |component, knowns| {
                let answer = match adjoint {
                    true => component.instance.adjoint_derivative((unknowns, seeds), knowns, derivatives),
                    false => component.instance.directional_derivative(unknowns, (knowns, seeds), derivatives),
                };
                report(component, answer)
            })
        })
    })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    c: Component,
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    seeds: *const f64,
    n_seeds: usize,
    derivatives: *mut f64,
    n_derivatives: usize,
) -> Status {
    let pairs = Pairs { unknowns, n_unknowns, knowns, n_knowns, seeds, n_seeds, derivatives, n_derivatives };
    unsafe { derive(c, pairs, false) }
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    c: Component,
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    seeds: *const f64,
    n_seeds: usize,
    derivatives: *mut f64,
    n_derivatives: usize,
) -> Status {
    let pairs = Pairs { unknowns, n_unknowns, knowns, n_knowns, seeds, n_seeds, derivatives, n_derivatives };
    unsafe { derive(c, pairs, true) }
}
