//! The other side of the C boundary: loads an FMU's library and calls it, as a master would.

use super::types::*;
use libloading::Library;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_int};
use std::path::Path;

/// Why a library could not be used.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    #[error("the FMU's library can't be loaded: {0}")]
    Load(String),
    #[error("no instance can be made{0}")]
    Instantiate(String),
    #[error("{function} answered {status:?}{message}")]
    Call { function: &'static str, status: Status, message: String },
}

impl From<libloading::Error> for HostError {
    /// With what the system's loader says itself.
    fn from(error: libloading::Error) -> Self {
        let cause = std::error::Error::source(&error).map(|source| format!(": {source}")).unwrap_or_default();
        HostError::Load(format!("{error}{cause}"))
    }
}

thread_local! {
    static LAST_MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Keeps the last message of the library. Its format has no arguments; only doubled percent signs are undone.
unsafe extern "C" fn keep_message(_: ComponentEnvironment, _: FmiString, _: Status, _: FmiString, message: FmiString) {
    if !message.is_null() {
        let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().replace("%%", "%");
        note_message(text);
    }
}

/// The same for FMI 3.0, whose messages are no formats.
pub(super) fn note_message(text: String) {
    LAST_MESSAGE.with(|last| *last.borrow_mut() = text);
}

pub(super) fn last_message() -> String {
    LAST_MESSAGE.with(|last| {
        let text = last.take();
        if text.is_empty() { text } else { format!(": {text}") }
    })
}

type Instantiate = unsafe extern "C" fn(FmiString, c_int, FmiString, FmiString, *const CallbackFunctions, Boolean, Boolean) -> Component;
type Free = unsafe extern "C" fn(Component);
type Setup = unsafe extern "C" fn(Component, Boolean, Real, Real, Boolean, Real) -> Status;
type Simple = unsafe extern "C" fn(Component) -> Status;
type DoStep = unsafe extern "C" fn(Component, Real, Real, Boolean) -> Status;
type SetReal = unsafe extern "C" fn(Component, *const ValueReference, usize, *const Real) -> Status;
type SetDerivatives = unsafe extern "C" fn(Component, *const ValueReference, usize, *const Integer, *const Real) -> Status;
type GetReal = unsafe extern "C" fn(Component, *const ValueReference, usize, *mut Real) -> Status;

/// An instance of either version that is stepped and read.
pub trait Steps {
    /// One communication step. Returns whether it answered with a warning: wheels lifted off or landed.
    ///
    /// # Errors
    /// [`HostError::Call`] for any status but OK and warning.
    fn do_step(&mut self, time: f64, step: f64) -> Result<bool, HostError>;

    /// Values of real variables.
    ///
    /// # Errors
    /// [`HostError::Call`] for any status but OK.
    fn get_real(&mut self, references: &[u32]) -> Result<Vec<f64>, HostError>;
}

impl Steps for LoadedFmu {
    fn do_step(&mut self, time: f64, step: f64) -> Result<bool, HostError> {
        LoadedFmu::do_step(self, time, step)
    }

    fn get_real(&mut self, references: &[u32]) -> Result<Vec<f64>, HostError> {
        LoadedFmu::get_real(self, references)
    }
}

/// An instance made through the C functions of a loaded library.
pub struct LoadedFmu {
    component: Component,
    get_real: GetReal,
    do_step: DoStep,
    set_real: SetReal,
    set_derivatives: SetDerivatives,
    free: Free,
    // Dropped last: the functions live in it.
    _library: Library,
    _callbacks: Box<CallbackFunctions>,
}

impl LoadedFmu {
    /// Loads the library, makes an instance and takes it through initialization.
    ///
    /// # Errors
    /// [`HostError`] with the library's own message.
    pub fn start(library: &Path, guid: &str, resources: &str) -> Result<Self, HostError> {
        // A variadic function cannot be written in stable Rust; one without the dots receives the same fixed arguments
        // on every C calling convention in use.
        let logger: Logger = unsafe {
            std::mem::transmute::<unsafe extern "C" fn(ComponentEnvironment, FmiString, Status, FmiString, FmiString), Logger>(keep_message)
        };
        let callbacks = Box::new(CallbackFunctions {
            logger: Some(logger),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: std::ptr::null_mut(),
        });
        let library = unsafe { Library::new(library)? };
        let (instantiate, free, setup, enter, exit, do_step, get_real, set_real, set_derivatives) = unsafe {
            (
                *library.get::<Instantiate>(b"fmi2Instantiate\0")?,
                *library.get::<Free>(b"fmi2FreeInstance\0")?,
                *library.get::<Setup>(b"fmi2SetupExperiment\0")?,
                *library.get::<Simple>(b"fmi2EnterInitializationMode\0")?,
                *library.get::<Simple>(b"fmi2ExitInitializationMode\0")?,
                *library.get::<DoStep>(b"fmi2DoStep\0")?,
                *library.get::<GetReal>(b"fmi2GetReal\0")?,
                *library.get::<SetReal>(b"fmi2SetReal\0")?,
                *library.get::<SetDerivatives>(b"fmi2SetRealInputDerivatives\0")?,
            )
        };
        let (guid, resources) = (CString::new(guid).unwrap_or_default(), CString::new(resources).unwrap_or_default());
        let component =
            unsafe { instantiate(c"check".as_ptr(), CO_SIMULATION, guid.as_ptr(), resources.as_ptr(), &*callbacks, FALSE, FALSE) };
        if component.is_null() {
            return Err(HostError::Instantiate(last_message()));
        }
        let fmu = LoadedFmu { component, get_real, do_step, set_real, set_derivatives, free, _library: library, _callbacks: callbacks };
        check("fmi2SetupExperiment", unsafe { setup(component, FALSE, 0.0, 0.0, FALSE, 0.0) })?;
        check("fmi2EnterInitializationMode", unsafe { enter(component) })?;
        warned("fmi2ExitInitializationMode", unsafe { exit(component) })?;
        Ok(fmu)
    }

    /// fmi2DoStep. Returns whether it answered fmi2Warning: wheels lifted off or landed.
    ///
    /// # Errors
    /// [`HostError::Call`] for any status but fmi2OK and fmi2Warning.
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<bool, HostError> {
        warned("fmi2DoStep", unsafe { (self.do_step)(self.component, time, step, TRUE) })
    }

    /// fmi2SetReal of one variable.
    ///
    /// # Errors
    /// [`HostError::Call`] for any status but fmi2OK.
    pub fn set_real(&mut self, reference: u32, value: f64) -> Result<(), HostError> {
        check("fmi2SetReal", unsafe { (self.set_real)(self.component, &reference, 1, &value) })
    }

    /// fmi2SetRealInputDerivatives of one input: first and second order.
    ///
    /// # Errors
    /// [`HostError::Call`] for any status but fmi2OK.
    pub fn set_input_derivatives(&mut self, reference: u32, first: f64, second: f64) -> Result<(), HostError> {
        let (references, orders, values) = ([reference; 2], [1, 2], [first, second]);
        let status = unsafe { (self.set_derivatives)(self.component, references.as_ptr(), 2, orders.as_ptr(), values.as_ptr()) };
        check("fmi2SetRealInputDerivatives", status)
    }

    /// fmi2GetReal.
    ///
    /// # Errors
    /// [`HostError::Call`] for any status but fmi2OK.
    pub fn get_real(&mut self, references: &[u32]) -> Result<Vec<f64>, HostError> {
        let mut values = vec![0.0; references.len()];
        check("fmi2GetReal", unsafe { (self.get_real)(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()) })?;
        Ok(values)
    }
}

impl Drop for LoadedFmu {
    fn drop(&mut self) {
        unsafe { (self.free)(self.component) };
    }
}

/// Did it end with a warning?
pub(super) fn warned(function: &'static str, status: Status) -> Result<bool, HostError> {
    if status == Status::Warning { Ok(true) } else { check(function, status).map(|()| false) }
}

pub(super) fn check(function: &'static str, status: Status) -> Result<(), HostError> {
    if status == Status::Ok { Ok(()) } else { Err(HostError::Call { function, status, message: last_message() }) }
}
