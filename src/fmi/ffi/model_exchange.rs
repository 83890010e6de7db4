//! The functions of model exchange: present, because some masters refuse a library without the symbols; refused,
//! because this FMU is for co-simulation.

use super::common::{guard, refuse};
use super::types::*;

/// Exports a function that refuses and says why.
macro_rules! refused {
    ($($name:ident($($argument:ident: $type:ty),*);)*) => {
        $(
            /// Model exchange is not supported.
            ///
            /// # Safety
            /// The component must be null or come from fmi2Instantiate.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(c: Component, $($argument: $type),*) -> Status {
                guard(c, |component| refuse(component, concat!(stringify!($name), " belongs to model exchange; this FMU is for co-simulation")))
            }
        )*
    };
}

refused! {
    fmi2EnterEventMode();
    fmi2NewDiscreteStates(_event_info: *mut EventInfo);
    fmi2EnterContinuousTimeMode();
    fmi2CompletedIntegratorStep(_no_set_state_prior: Boolean, _enter_event_mode: *mut Boolean, _terminate: *mut Boolean);
    fmi2SetTime(_time: Real);
    fmi2SetContinuousStates(_x: *const Real, _nx: usize);
    fmi2GetDerivatives(_derivatives: *mut Real, _nx: usize);
    fmi2GetEventIndicators(_indicators: *mut Real, _ni: usize);
    fmi2GetContinuousStates(_x: *mut Real, _nx: usize);
    fmi2GetNominalsOfContinuousStates(_nominals: *mut Real, _nx: usize);
}
