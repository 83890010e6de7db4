//! What stands behind an fmi2Component or fmi3Instance: a safe instance, its logger and what C may still look at.

use super::super::instance;
use super::session::{LogMessage, Session};
use super::text::c_string;
use super::types::*;
use std::collections::HashSet;
use std::ffi::CString;

/// Behind an fmi2Component or fmi3Instance.
pub struct Component {
    pub instance: instance::Instance,
    pub log: Log,
    /// What the host of FMI 3.0 has said of itself.
    pub session: Session,
    /// Status of the last step.
    pub last_step: Status,
    /// Did the last step end because a wheel left its rail? The slave then wants to end the simulation.
    pub derailed: bool,
    /// Set by a panic: the instance then answers fmi2Error for ever.
    pub poisoned: bool,
    /// Strings given to the host; they live until the next call on this instance.
    pub strings: Vec<CString>,
    /// States that it has made and the host has not freed yet.
    pub states: HashSet<FmuState>,
}

impl Component {
    pub fn new(instance: instance::Instance, log: Log) -> Self {
        Component {
            instance,
            log,
            session: Session::default(),
            last_step: Status::Ok,
            derailed: false,
            poisoned: false,
            strings: Vec::new(),
            states: HashSet::new(),
        }
    }
}

/// The host's function for messages.
enum Sink {
    None,
    /// With the instance's name. The message is a format: without arguments, percent signs must be doubled.
    Two(Logger, CString),
    Three(LogMessage),
}

/// The host's logger with what it wants to hear.
pub struct Log {
    sink: Sink,
    environment: ComponentEnvironment,
    on: bool,
    /// Empty: all categories.
    categories: Vec<String>,
}

impl Log {
    /// # Safety
    /// `functions` must be null or valid; the environment is only handed back to the logger.
    pub unsafe fn new(name: Option<&str>, functions: *const CallbackFunctions, on: bool) -> Self {
        let functions = unsafe { functions.as_ref() };
        let logger = functions.and_then(|functions| functions.logger);
        let environment = functions.map_or(std::ptr::null_mut(), |functions| functions.component_environment);
        let sink = logger.map_or(Sink::None, |logger| Sink::Two(logger, c_string(name.unwrap_or("wheelrail"))));
        Log { sink, environment, on, categories: Vec::new() }
    }

    /// Of a host of FMI 3.0; the environment is only handed back to it.
    pub fn of_three(message: Option<LogMessage>, environment: ComponentEnvironment, on: bool) -> Self {
        Log { sink: message.map_or(Sink::None, Sink::Three), environment, on, categories: Vec::new() }
    }

    pub fn configure(&mut self, on: bool, categories: Vec<String>) {
        self.on = on;
        self.categories = categories;
    }

    /// A refused call or a step that ended early: always logged.
    pub fn error(&self, status: Status, message: &str) {
        let category = if status == Status::Discard { c"logStatusDiscard" } else { c"logStatusError" };
        self.send(status, category, message);
    }

    /// Something that the host should know even when it did not ask for messages.
    pub fn remark(&self, message: &str) {
        self.send(Status::Warning, c"logStatusWarning", message);
    }

    /// Something worth knowing, when the host asked for it.
    pub fn event(&self, message: &str) {
        let wanted = |name: &String| name == "logEvents" || name == "logAll";
        if self.on && (self.categories.is_empty() || self.categories.iter().any(wanted)) {
            self.send(Status::Ok, c"logEvents", message);
        }
    }

    fn send(&self, status: Status, category: &std::ffi::CStr, message: &str) {
        match &self.sink {
            Sink::None => {}
            Sink::Two(logger, name) => {
                let message = c_string(&message.replace('%', "%%"));
                unsafe { logger(self.environment, name.as_ptr(), status, category.as_ptr(), message.as_ptr()) };
            }
            Sink::Three(log) => {
                let message = c_string(message);
                unsafe { log(self.environment, status, category.as_ptr(), message.as_ptr()) };
            }
        }
    }
}
