//! The other side of FMI 3.0: loads an FMU's library and steps it, as a plain master would, without events, early returns or updates.

use super::super::host::{HostError, Steps, check, last_message, note_message, warned};
use super::super::session::{Boolean, IntermediateUpdate, LogMessage};
use super::super::types::{Component, ComponentEnvironment, FmiString, Status, ValueReference};
use libloading::Library;
use std::ffi::{CStr, CString};
use std::path::Path;

type Instantiate = unsafe extern "C" fn(
    FmiString,
    FmiString,
    FmiString,
    Boolean,
    Boolean,
    Boolean,
    Boolean,
    *const ValueReference,
    usize,
    ComponentEnvironment,
    Option<LogMessage>,
    Option<IntermediateUpdate>,
) -> Component;
type Free = unsafe extern "C" fn(Component);
type Enter = unsafe extern "C" fn(Component, Boolean, f64, f64, Boolean, f64) -> Status;
type Simple = unsafe extern "C" fn(Component) -> Status;
type DoStep = unsafe extern "C" fn(Component, f64, f64, Boolean, *mut Boolean, *mut Boolean, *mut Boolean, *mut f64) -> Status;
type Get = unsafe extern "C" fn(Component, *const ValueReference, usize, *mut f64, usize) -> Status;
type Set = unsafe extern "C" fn(Component, *const ValueReference, usize, *const f64, usize) -> Status;

/// An instance made through the C functions of a loaded library.
pub struct LoadedFmu {
    component: Component,
    get: Get,
    set: Set,
    do_step: DoStep,
    free: Free,
    // Dropped last: the functions live in it.
    _library: Library,
}

/// Keeps the last message of the library.
unsafe extern "C" fn keep_message(_: ComponentEnvironment, _: Status, _: FmiString, message: FmiString) {
    if !message.is_null() {
        note_message(unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned());
    }
}

impl LoadedFmu {
    /// Loads the library, makes an instance with the resources in a folder and takes it through initialization.
    ///
    /// # Errors
    /// [`HostError`] with the library's own message.
    pub fn start(library: &Path, token: &str, resources: &Path) -> Result<Self, HostError> {
        let library = unsafe { Library::new(library)? };
        let (instantiate, free, enter, exit, do_step, get, set) = unsafe {
            (
                *library.get::<Instantiate>(b"fmi3InstantiateCoSimulation\0")?,
                *library.get::<Free>(b"fmi3FreeInstance\0")?,
                *library.get::<Enter>(b"fmi3EnterInitializationMode\0")?,
                *library.get::<Simple>(b"fmi3ExitInitializationMode\0")?,
                *library.get::<DoStep>(b"fmi3DoStep\0")?,
                *library.get::<Get>(b"fmi3GetFloat64\0")?,
                *library.get::<Set>(b"fmi3SetFloat64\0")?,
            )
        };
        // The path ends with a separator.
        let folder = resources.join("").to_string_lossy().into_owned();
        let (token, folder) = (CString::new(token).unwrap_or_default(), CString::new(folder).unwrap_or_default());
        let (nobody, none) = (std::ptr::null_mut(), std::ptr::null());
        let component = unsafe {
            instantiate(c"check".as_ptr(), token.as_ptr(), folder.as_ptr(), 0, 0, 0, 0, none, 0, nobody, Some(keep_message), None)
        };
        if component.is_null() {
            return Err(HostError::Instantiate(last_message()));
        }
        let fmu = LoadedFmu { component, get, set, do_step, free, _library: library };
        check("fmi3EnterInitializationMode", unsafe { enter(component, 0, 0.0, 0.0, 0, 0.0) })?;
        warned("fmi3ExitInitializationMode", unsafe { exit(component) })?;
        Ok(fmu)
    }

    /// fmi3SetFloat64 of one variable.
    ///
    /// # Errors
    /// [`HostError::Call`] for any status but fmi3OK.
    pub fn set_real(&mut self, reference: u32, value: f64) -> Result<(), HostError> {
        check("fmi3SetFloat64", unsafe { (self.set)(self.component, &reference, 1, &value, 1) })
    }
}

impl Steps for LoadedFmu {
    fn do_step(&mut self, time: f64, step: f64) -> Result<bool, HostError> {
        let ([mut event, mut end, mut early], mut reached) = ([0; 3], 0.0);
        let status = unsafe { (self.do_step)(self.component, time, step, 1, &mut event, &mut end, &mut early, &mut reached) };
        let warned = warned("fmi3DoStep", status)?;
        if end != 0 {
            let message = format!("{} (it asks to end the simulation at t = {reached} s)", last_message());
            return Err(HostError::Call { function: "fmi3DoStep", status, message });
        }
        Ok(warned)
    }

    fn get_real(&mut self, references: &[u32]) -> Result<Vec<f64>, HostError> {
        let mut values = vec![0.0; references.len()];
        let status = unsafe { (self.get)(self.component, references.as_ptr(), references.len(), values.as_mut_ptr(), values.len()) };
        check("fmi3GetFloat64", status)?;
        Ok(values)
    }
}

impl Drop for LoadedFmu {
    fn drop(&mut self) {
        unsafe { (self.free)(self.component) };
    }
}
