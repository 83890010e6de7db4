//! Functions of what this FMU is not or has not: other kinds of FMU, clocks, structural parameters. They are there, because masters look for them, and
//! refuse.

use super::super::common::{guard, refuse, refused};
use super::super::component::Log;
use super::super::session::{Boolean, FALSE, LogMessage};
use super::super::types::{Component, ComponentEnvironment, FmiString, Status, ValueReference};
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Says why there is no instance.
fn no_instance(message: Option<LogMessage>, environment: ComponentEnvironment, logging_on: Boolean, why: &str) -> Component {
    let _ = catch_unwind(AssertUnwindSafe(|| Log::of_three(message, environment, logging_on != FALSE).error(Status::Error, why)));
    std::ptr::null_mut()
}

/// # Safety
/// `log_message` must be null or a function of that type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _instance_name: FmiString,
    _instantiation_token: FmiString,
    _resource_path: FmiString,
    _visible: Boolean,
    logging_on: Boolean,
    environment: ComponentEnvironment,
    log_message: Option<LogMessage>,
) -> Component {
    no_instance(log_message, environment, logging_on, "this FMU is for co-simulation; model exchange is not supported")
}

/// # Safety
/// `log_message` must be null or a function of that type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instance_name: FmiString,
    _instantiation_token: FmiString,
    _resource_path: FmiString,
    _visible: Boolean,
    logging_on: Boolean,
    environment: ComponentEnvironment,
    log_message: Option<LogMessage>,
    _clock_update: *const c_void,
    _lock_preemption: *const c_void,
    _unlock_preemption: *const c_void,
) -> Component {
    no_instance(log_message, environment, logging_on, "this FMU is for co-simulation; scheduled execution is not supported")
}

refused! {
    "belongs to model exchange; this FMU is for co-simulation";
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(_no_set_state_prior: Boolean, _enter_event_mode: *mut Boolean, _terminate: *mut Boolean);
    fmi3SetTime(_time: f64);
    fmi3SetContinuousStates(_x: *const f64, _nx: usize);
    fmi3GetContinuousStateDerivatives(_derivatives: *mut f64, _nx: usize);
    fmi3GetEventIndicators(_indicators: *mut f64, _ni: usize);
    fmi3GetContinuousStates(_x: *mut f64, _nx: usize);
    fmi3GetNominalsOfContinuousStates(_nominals: *mut f64, _nx: usize);
    fmi3GetNumberOfEventIndicators(_ni: *mut usize);
    fmi3GetNumberOfContinuousStates(_nx: *mut usize);
}

refused! {
    "belongs to scheduled execution; this FMU is for co-simulation";
    fmi3ActivateModelPartition(_clock: ValueReference, _time: f64);
}

refused! {
    "is not supported: this FMU has no structural parameters";
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
}

refused! {
    "is not supported (providesEvaluateDiscreteStates is false)";
    fmi3EvaluateDiscreteStates();
}

refused! {
    "is not supported: this FMU has no clocks";
    fmi3GetClock(_vr: *const ValueReference, _nvr: usize, _values: *mut Boolean);
    fmi3SetClock(_vr: *const ValueReference, _nvr: usize, _values: *const Boolean);
    fmi3GetIntervalDecimal(_vr: *const ValueReference, _nvr: usize, _intervals: *mut f64, _qualifiers: *mut i32);
    fmi3GetIntervalFraction(_vr: *const ValueReference, _nvr: usize, _counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut i32);
    fmi3GetShiftDecimal(_vr: *const ValueReference, _nvr: usize, _shifts: *mut f64);
    fmi3GetShiftFraction(_vr: *const ValueReference, _nvr: usize, _counters: *mut u64, _resolutions: *mut u64);
    fmi3SetIntervalDecimal(_vr: *const ValueReference, _nvr: usize, _intervals: *const f64);
    fmi3SetIntervalFraction(_vr: *const ValueReference, _nvr: usize, _counters: *const u64, _resolutions: *const u64);
    fmi3SetShiftDecimal(_vr: *const ValueReference, _nvr: usize, _shifts: *const f64);
    fmi3SetShiftFraction(_vr: *const ValueReference, _nvr: usize, _counters: *const u64, _resolutions: *const u64);
}
