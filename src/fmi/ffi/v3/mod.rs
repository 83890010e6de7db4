//! The C functions of FMI 3.0, thin on the same instance as those of FMI 2.0. What both do alike is done in one place, which knows no version.
//!
//! While `intermediateUpdate` is at work the host may read and set what it has named, and ask for dependencies; every other call is refused then, so that
//! nothing changes under the step that waits for it.

#![allow(clippy::too_many_arguments)] // the standard's signatures

mod dependencies;
mod derivatives;
#[cfg(feature = "cli")]
pub mod host;
mod refused;
pub mod states;
mod step;
pub mod values;

pub use dependencies::*;
pub use derivatives::*;
pub use step::*;

use super::common::{guard, refuse, report, slice, text};
use super::component::{Component as Instance, Log};
use super::session::{Boolean, Environment, FALSE, IntermediateUpdate, LogMessage, Session};
use super::types::{Component as Fmi3Instance, ComponentEnvironment, FmiString, Status};
use super::{check_name, fmi2ExitInitializationMode, fmi2FreeInstance, fmi2Reset, fmi2Terminate, instantiate, set_logging, set_up};
use crate::fmi::instance;
use crate::fmi::uri;
use crate::fmi::variables::{Role, VariableTable};
use crate::fmi::version::Version;

/// Why a call is refused now, if it is: only few are allowed while the host's own function is at work.
fn in_update(c: Fmi3Instance, function: &str) -> Option<Status> {
    let mut refused = None;
    let status = guard(c, |component| {
        if component.session.updating {
            refused = Some(refuse(component, &format!("{function} is not allowed in intermediate update mode")));
        }
        Status::Ok
    });
    refused.or((status != Status::Ok).then_some(status))
}

/// A call that is not allowed in intermediate update mode.
fn call(c: Fmi3Instance, function: &str, run: impl FnOnce(&mut Instance) -> Status) -> Status {
    match in_update(c, function) {
        Some(status) => status,
        None => guard(c, run),
    }
}

/// The same of what FMI 2.0's function does.
fn as_in_two(c: Fmi3Instance, function: &str, run: impl FnOnce() -> Status) -> Status {
    in_update(c, function).unwrap_or_else(run)
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> FmiString {
    super::keep_mark();
    c"3.0".as_ptr()
}

/// Makes an instance; null with a log message when that is not possible.
///
/// # Safety
/// Pointers must be null or valid, strings null-terminated, as FMI 3.0 says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instance_name: FmiString,
    instantiation_token: FmiString,
    resource_path: FmiString,
    _visible: Boolean,
    logging_on: Boolean,
    event_mode_used: Boolean,
    early_return_allowed: Boolean,
    required_intermediate_variables: *const u32,
    n_required_intermediate_variables: usize,
    instance_environment: ComponentEnvironment,
    log_message: Option<LogMessage>,
    intermediate_update: Option<IntermediateUpdate>,
) -> Fmi3Instance {
    let log = || Log::of_three(log_message, instance_environment, logging_on != FALSE);
    instantiate(log, || {
        check_name(unsafe { text(instance_name) })?;
        let token = unsafe { text(instantiation_token) }.ok_or("the instantiation token is missing")?;
        let path = unsafe { text(resource_path) }.ok_or("the resource path is missing: the FMU reads its scene there")?;
        let required = unsafe { slice(required_intermediate_variables, n_required_intermediate_variables) };
        let required = required.ok_or("requiredIntermediateVariables is NULL")?;
        let mut made = instance::Instance::of_version(&uri::path(&path)?, &token, Version::Three).map_err(|error| error.to_string())?;
        let event_mode = event_mode_used != FALSE;
        if event_mode {
            made.use_event_mode();
        }
        let session = Session {
            event_mode,
            early_return: early_return_allowed != FALSE,
            update: intermediate_update,
            environment: Environment(instance_environment),
            reachable: reachable(made.table(), required)?,
            updating: false,
        };
        Ok((made, session))
    })
}

/// The variables that a host names for intermediate updates, sorted.
fn reachable(table: &VariableTable, required: &[u32]) -> Result<Vec<u32>, String> {
    let mut sorted = required.to_vec();
    sorted.sort_unstable();
    let continuous = |reference: u32| {
        let scalar = |reference| table.find(reference).is_some_and(|variable| matches!(variable.role, Role::Input(_) | Role::Output(_)));
        table.scalars(&[reference]).iter().all(|reference| scalar(*reference))
    };
    match sorted.iter().find(|reference| !continuous(**reference)) {
        None => Ok(sorted),
        Some(other) => Err(format!("requiredIntermediateVariables: {other} is no continuous input or output")),
    }
}

/// Frees an instance with the states that the host has not freed; null does nothing.
///
/// # Safety
/// The instance must come from fmi3InstantiateCoSimulation and not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(c: Fmi3Instance) {
    // The step that waits for the host would go on in freed memory. A stopped instance is freed like any other.
    let updating = unsafe { c.cast::<Instance>().as_ref() }.is_some_and(|component| component.session.updating);
    if updating {
        in_update(c, "fmi3FreeInstance");
    } else {
        unsafe { fmi2FreeInstance(c) };
    }
}

/// # Safety
/// The instance must be null or come from this library; `categories` must hold `n` strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(c: Fmi3Instance, logging_on: Boolean, n: usize, categories: *const FmiString) -> Status {
    const NAME: &str = "fmi3SetDebugLogging";
    as_in_two(c, NAME, || unsafe { set_logging(c, NAME, logging_on != FALSE, n, categories) })
}

/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    c: Fmi3Instance,
    tolerance_defined: Boolean,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: Boolean,
    stop_time: f64,
) -> Status {
    call(c, "fmi3EnterInitializationMode", |component| {
        let tolerance = (tolerance_defined != FALSE).then_some(tolerance);
        let stop = (stop_time_defined != FALSE).then_some(stop_time);
        match set_up(component, tolerance, start_time, stop) {
            Status::Ok => {
                let answer = component.instance.enter_initialization();
                report(component, answer)
            }
            refused => refused,
        }
    })
}

/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(c: Fmi3Instance) -> Status {
    as_in_two(c, "fmi3ExitInitializationMode", || unsafe { fmi2ExitInitializationMode(c) })
}

/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(c: Fmi3Instance) -> Status {
    call(c, "fmi3EnterEventMode", |component| {
        let answer = component.instance.enter_event_mode();
        report(component, answer)
    })
}

/// Discrete outputs follow the present state, in one update. No event is known ahead.
///
/// # Safety
/// The instance must be null or come from this library, the other pointers null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    c: Fmi3Instance,
    discrete_states_need_update: *mut Boolean,
    terminate_simulation: *mut Boolean,
    nominals_of_continuous_states_changed: *mut Boolean,
    values_of_continuous_states_changed: *mut Boolean,
    next_event_time_defined: *mut Boolean,
    next_event_time: *mut f64,
) -> Status {
    call(c, "fmi3UpdateDiscreteStates", |component| {
        let flags = unsafe {
            [
                discrete_states_need_update.as_mut(),
                nominals_of_continuous_states_changed.as_mut(),
                values_of_continuous_states_changed.as_mut(),
                next_event_time_defined.as_mut(),
            ]
        };
        let (end, time) = unsafe { (terminate_simulation.as_mut(), next_event_time.as_mut()) };
        let (Some(end), Some(time), true) = (end, time, flags.iter().all(Option::is_some)) else {
            return refuse(component, "fmi3UpdateDiscreteStates: a pointer is NULL");
        };
        let answer = component.instance.update_discrete();
        if answer.is_ok() {
            flags.into_iter().flatten().for_each(|flag| *flag = FALSE);
            (*end, *time) = (Boolean::from(component.derailed), 0.0);
        }
        report(component, answer)
    })
}

/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(c: Fmi3Instance) -> Status {
    call(c, "fmi3EnterStepMode", |component| {
        let answer = component.instance.enter_step_mode();
        report(component, answer)
    })
}

/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(c: Fmi3Instance) -> Status {
    as_in_two(c, "fmi3Terminate", || unsafe { fmi2Terminate(c) })
}

/// # Safety
/// The instance must be null or come from this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(c: Fmi3Instance) -> Status {
    as_in_two(c, "fmi3Reset", || unsafe { fmi2Reset(c) })
}
