//! The C functions of FMI 2.0 and, in `v3`, of FMI 3.0, and in `host` their callers, which the program has (feature `cli`) and the FMU's
//! library has not: the only unsafe code of the program.
//!
//! Each function checks its pointers, takes the instance, catches panics and turns the answer into a status. A panic
//! poisons its instance only: that one answers fmi2Error ever after. `nvr == 0` returns before any slice is made.

mod common;
mod component;
#[cfg(feature = "cli")]
pub mod host;
mod model_exchange;
pub mod session;
pub mod states;
mod text;
pub mod types;
pub mod v3;
pub mod values;

use crate::formulation::events::ContactEvent;
use common::{guard, refuse, report, text};
use component::{Component as Instance, Log};
use session::Session;
use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use types::*;

/// Found in the library's bytes by `wheelrail export`, which refuses a library of another build. `fmi2GetVersion` and `fmi3GetVersion` hold on to it: a symbol of its own would
/// be one that is not FMI's.
static WHEELRAIL_BUILD_MARK: [u8; super::build_mark::BUILD_MARK.len()] = mark();

const fn mark() -> [u8; super::build_mark::BUILD_MARK.len()] {
    let source = super::build_mark::BUILD_MARK.as_bytes();
    let mut bytes = [0; super::build_mark::BUILD_MARK.len()];
    let mut i = 0;
    while i < source.len() {
        bytes[i] = source[i];
        i += 1;
    }
    bytes
}

fn keep_mark() {
    std::hint::black_box(&WHEELRAIL_BUILD_MARK);
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> FmiString {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> FmiString {
    keep_mark();
    c"2.0".as_ptr()
}

/// Makes an instance; null with a log message when that is not possible.
///
/// # Safety
/// Pointers must be null or valid, strings null-terminated, as FMI 2.0 says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: FmiString,
    fmu_type: c_int,
    guid: FmiString,
    resource_location: FmiString,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    logging_on: Boolean,
) -> Component {
    let log = || unsafe { Log::new(text(instance_name).as_deref(), functions, logging_on != FALSE) };
    instantiate(log, || {
        if fmu_type != CO_SIMULATION {
            return Err("this FMU is for co-simulation; fmi2ModelExchange is not supported".to_string());
        }
        if functions.is_null() {
            return Err("the callback functions are NULL".into());
        }
        check_name(unsafe { text(instance_name) })?;
        let guid = unsafe { text(guid) }.ok_or("the GUID is missing")?;
        let location = unsafe { text(resource_location) }.ok_or("the resource location is missing")?;
        let made = super::instance::Instance::new(&super::uri::path(&location)?, &guid).map_err(|error| error.to_string())?;
        Ok((made, Session::default()))
    })
}

/// What stands behind an instance that `build` makes; null with a log message where it does not.
fn instantiate(log: impl Fn() -> Log, build: impl FnOnce() -> Result<(super::instance::Instance, Session), String>) -> Component {
    let made = catch_unwind(AssertUnwindSafe(|| {
        let log = log();
        match build() {
            Ok((instance, session)) => {
                let mut made = Instance::new(instance, log);
                made.session = session;
                Box::into_raw(Box::new(made)).cast()
            }
            Err(message) => {
                log.error(Status::Error, &message);
                std::ptr::null_mut()
            }
        }
    }));
    made.unwrap_or_else(|_| {
        log().error(Status::Error, "internal error while making an instance, please report it");
        std::ptr::null_mut()
    })
}

/// An instance needs a name.
fn check_name(name: Option<String>) -> Result<(), String> {
    name.filter(|name| !name.trim().is_empty()).map(|_| ()).ok_or_else(|| "the instance name is missing or not UTF-8".into())
}

/// Frees an instance with the states that the host has not freed; null does nothing.
///
/// # Safety
/// The component must come from fmi2Instantiate and not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: Component) {
    if !c.is_null() {
        // Dropping runs no foreign code, but nothing may unwind into C.
        let _ = catch_unwind(AssertUnwindSafe(|| {
            let mut instance = unsafe { Box::from_raw(c.cast::<Instance>()) };
            states::release_all(&mut instance);
        }));
    }
}

/// # Safety
/// The component must be null or come from fmi2Instantiate; `categories` must hold `n` strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(c: Component, logging_on: Boolean, n: usize, categories: *const FmiString) -> Status {
    unsafe { set_logging(c, "fmi2SetDebugLogging", logging_on != FALSE, n, categories) }
}

/// # Safety
/// See [`fmi2SetDebugLogging`].
unsafe fn set_logging(c: Component, function: &str, on: bool, n: usize, categories: *const FmiString) -> Status {
    guard(c, |component| {
        let Some(categories) = (unsafe { common::slice(categories, n) }) else {
            return refuse(component, &format!("{function}: the categories are NULL"));
        };
        let mut names = Vec::new();
        for category in categories {
            match unsafe { text(*category) } {
                Some(name) if super::description::LOG_CATEGORIES.iter().any(|category| category.0 == name) => names.push(name),
                Some(name) => return refuse(component, &format!("{function}: there is no log category \"{name}\"")),
                None => return refuse(component, &format!("{function}: a category is NULL")),
            }
        }
        component.log.configure(on, names);
        Status::Ok
    })
}

/// # Safety
/// The component must be null or come from fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: Component,
    tolerance_defined: Boolean,
    tolerance: Real,
    start_time: Real,
    stop_time_defined: Boolean,
    stop_time: Real,
) -> Status {
    guard(c, |component| {
        let tolerance = (tolerance_defined != FALSE).then_some(tolerance);
        let stop = (stop_time_defined != FALSE).then_some(stop_time);
        set_up(component, tolerance, start_time, stop)
    })
}

/// Start and stop time and tolerance of the run, with a remark where the tolerance is not taken as it is.
fn set_up(component: &mut Instance, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Status {
    match component.instance.setup_experiment(tolerance, start, stop) {
        Ok(remark) => {
            if let Some(remark) = remark {
                component.log.remark(&remark);
            }
            Status::Ok
        }
        Err(error) => refuse(component, &error.to_string()),
    }
}

/// # Safety
/// The component must be null or come from fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: Component) -> Status {
    guard(c, |component| {
        let answer = component.instance.enter_initialization();
        report(component, answer)
    })
}

/// # Safety
/// The component must be null or come from fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: Component) -> Status {
    guard(c, |component| match component.instance.exit_initialization() {
        Ok(events) => {
            component.log.event(&component.instance.summary());
            remarks(component, &events)
        }
        Err(error) => refuse(component, &error.to_string()),
    })
}

/// # Safety
/// The component must be null or come from fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: Component) -> Status {
    guard(c, |component| {
        let answer = component.instance.terminate();
        let status = report(component, answer);
        if status == Status::Ok {
            component.instance.notes().iter().for_each(|note| component.log.remark(note));
            component.log.event(&component.instance.summary());
        }
        status
    })
}

/// # Safety
/// The component must be null or come from fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: Component) -> Status {
    guard(c, |component| {
        component.instance.reset();
        component.last_step = Status::Ok;
        component.derailed = false;
        Status::Ok
    })
}

/// Logs events of contacts: a warning when one has changed between constraint and elastic force; contacts beside the first that
/// begin or end belong to ordinary running, and are for a host that asked for messages.
fn remarks(component: &Instance, events: &[ContactEvent]) -> Status {
    for event in events {
        match event.change.changes_mode() {
            true => component.log.remark(&event.to_string()),
            false => component.log.event(&event.to_string()),
        }
    }
    if events.iter().any(|event| event.change.changes_mode()) { Status::Warning } else { Status::Ok }
}

/// # Safety
/// The component must be null or come from fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: Component,
    current_communication_point: Real,
    communication_step_size: Real,
    _no_set_state_prior: Boolean,
) -> Status {
    use super::instance::StepOutcome;
    guard(c, |component| match component.instance.do_step(current_communication_point, communication_step_size) {
        Ok(StepOutcome::Done) => {
            component.last_step = Status::Ok;
            component.derailed = false;
            Status::Ok
        }
        Ok(StepOutcome::DoneWithRemarks(events, doubt)) => {
            component.last_step = remarks(component, &events);
            if let Some(doubt) = doubt {
                component.log.remark(&doubt);
                component.last_step = Status::Warning;
            }
            component.derailed = false;
            component.last_step
        }
        Ok(StepOutcome::Discarded(error, events)) => {
            remarks(component, &events);
            component.derailed = error.is_derailed();
            component.last_step = Status::Discard;
            let reached = component.instance.time();
            component.log.error(Status::Discard, &format!("the step ended early at t = {reached} s: {error}"));
            Status::Discard
        }
        Err(error) => refuse(component, &error.to_string()),
    })
}

/// Steps are never pending, so there is nothing to cancel.
///
/// # Safety
/// The component must be null or come from fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: Component) -> Status {
    guard(c, |component| refuse(component, "fmi2CancelStep: steps are never pending"))
}

/// Answers one question about the last step.
fn step_status<T>(c: Component, value: *mut T, kind: c_int, answer: impl FnOnce(&mut Instance, c_int) -> Option<T>) -> Status {
    guard(c, |component| {
        if value.is_null() {
            return refuse(component, "the status value is NULL");
        }
        match answer(component, kind) {
            Some(found) => {
                unsafe { value.write(found) };
                Status::Ok
            }
            None => refuse(component, &format!("status kind {kind} is not answered by this function")),
        }
    })
}

/// # Safety
/// The component must be null or come from fmi2Instantiate, `value` null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: Component, kind: c_int, value: *mut Status) -> Status {
    step_status(c, value, kind, |component, kind| (kind == DO_STEP_STATUS).then_some(component.last_step))
}

/// # Safety
/// The component must be null or come from fmi2Instantiate, `value` null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: Component, kind: c_int, value: *mut Real) -> Status {
    step_status(c, value, kind, |component, kind| (kind == LAST_SUCCESSFUL_TIME).then(|| component.instance.time()))
}

/// # Safety
/// The component must be null or come from fmi2Instantiate, `value` null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: Component, kind: c_int, value: *mut Integer) -> Status {
    step_status(c, value, kind, |_, _| None)
}

/// # Safety
/// The component must be null or come from fmi2Instantiate, `value` null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: Component, kind: c_int, value: *mut Boolean) -> Status {
    step_status(c, value, kind, |component, kind| (kind == TERMINATED).then_some(Boolean::from(component.derailed)))
}

/// # Safety
/// The component must be null or come from fmi2Instantiate, `value` null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: Component, kind: c_int, value: *mut FmiString) -> Status {
    step_status(c, value, kind, |_, kind| (kind == PENDING_STATUS).then_some(c"".as_ptr() as *const c_char))
}
