//! On which inputs a variable depends at the same instant, for each element of an array.

use super::super::common::{guard, refuse, slice_mut};
use super::super::component::Component as Instance;
use super::super::session::{DEPENDENT, FIXED};
use super::super::types::{Component, Status, ValueReference};

/// One dependency: number of the element (from 1; 0 for a scalar), reference of what it depends on, and its kind.
type Dependency = (usize, u32, i32);

/// Those of a variable: on inputs once the run has begun, on all that begins it before.
fn dependencies(component: &Instance, reference: u32) -> Result<Vec<Dependency>, String> {
    let table = component.instance.table();
    let scalars = table.scalars(&[reference]);
    let is_array = table.size(reference) != 1 || scalars != [reference];
    let variable = scalars.first().and_then(|first| table.find(*first));
    let Some(variable) = variable.filter(|variable| variable.causality == "output") else {
        return Err(format!("value reference {reference} is no output"));
    };
    let begins = |causality: &str| matches!(causality, "input" | "parameter");
    let known = |scalar: u32| match table.known_dependencies(scalar) {
        Some(known) if component.instance.has_begun() => {
            known.into_iter().map(|(input, fixed)| (input, if fixed { FIXED } else { DEPENDENT })).collect::<Vec<_>>()
        }
        // Numbers of contacts may react to whatever moves a rail; before the run all follows from all.
        _ => {
            let all = table.variables.iter().filter(|other| begins(other.causality));
            let inputs_alone = component.instance.has_begun();
            all.filter(|other| !inputs_alone || other.causality == "input").map(|other| (other.reference, DEPENDENT)).collect()
        }
    };
    debug_assert!(variable.reference == scalars[0]);
    let place = |index: usize| if is_array { index + 1 } else { 0 };
    Ok(scalars
        .iter()
        .enumerate()
        .flat_map(|(index, scalar)| known(*scalar).into_iter().map(move |(on, kind)| (place(index), on, kind)))
        .collect())
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(c: Component, reference: ValueReference, count: *mut usize) -> Status {
    guard(c, |component| {
        let Some(count) = (unsafe { count.as_mut() }) else {
            return refuse(component, "fmi3GetNumberOfVariableDependencies: the pointer is NULL");
        };
        match dependencies(component, reference) {
            Ok(found) => {
                *count = found.len();
                Status::Ok
            }
            Err(why) => refuse(component, &why),
        }
    })
}

/// # Safety
/// FMI 3.0's rules for pointers; null is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetVariableDependencies(
    c: Component,
    dependent: ValueReference,
    elements_of_dependent: *mut usize,
    independents: *mut ValueReference,
    elements_of_independents: *mut usize,
    kinds: *mut i32,
    n: usize,
) -> Status {
    guard(c, |component| {
        let slices = unsafe {
            (slice_mut(elements_of_dependent, n), slice_mut(independents, n), slice_mut(elements_of_independents, n), slice_mut(kinds, n))
        };
        let (Some(elements), Some(independents), Some(others), Some(kinds)) = slices else {
            return refuse(component, "fmi3GetVariableDependencies: a pointer is NULL");
        };
        let found = match dependencies(component, dependent) {
            Ok(found) if found.len() == n => found,
            Ok(found) => {
                return refuse(component, &format!("fmi3GetVariableDependencies: there are {} dependencies, not {n}", found.len()));
            }
            Err(why) => return refuse(component, &why),
        };
        for (place, (element, on, kind)) in found.into_iter().enumerate() {
            (elements[place], independents[place], others[place], kinds[place]) = (element, on, 0, kind);
        }
        Status::Ok
    })
}
