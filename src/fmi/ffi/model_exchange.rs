//! The functions of model exchange: present, because some masters refuse a library without the symbols; refused,
//! because this FMU is for co-simulation.

use super::common::{guard, refuse, refused};
use super::types::*;

refused! {
    "belongs to model exchange; this FMU is for co-simulation";
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
