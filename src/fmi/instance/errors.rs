//! Why a call was refused or an instance could not be made.

use super::Phase;
use crate::fmi::variables::Kind;
use crate::scene::load::SceneError;
use crate::sim::SimulationError;
use crate::sim::serialized::BlobError;

/// Why a call was refused.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    #[error("{function} is not allowed {}", phase.words())]
    Phase { function: &'static str, phase: Phase },
    #[error("there is no {kind:?} variable with value reference {reference}")]
    UnknownReference { reference: u32, kind: Kind },
    #[error("\"{name}\" is {causality}, {variability}; it can't be set {}", phase.words())]
    NotSettable { name: String, causality: &'static str, variability: &'static str, phase: Phase },
    #[error("\"{name}\" can't be set to {value:?}: {problem}")]
    Value { name: String, value: f64, problem: String },
    #[error("\"{name}\" is not a real input, so it has no input derivative")]
    NotAnInput { name: String },
    #[error("\"{name}\" is not a real output, so it has no output derivative")]
    NotAnOutput { name: String },
    #[error("\"{name}\" is not a real output, so it has no directional derivative")]
    NotDerivable { name: String },
    #[error("\"{name}\" is not a real input; outputs are differentiated by inputs alone")]
    NotDerivableBy { name: String },
    #[error("derivative order {order} of \"{name}\" is not supported; expected 1 to {largest}")]
    Order { name: String, order: i32, largest: i32 },
    #[error("{what} is {value:?}; expected {expected}")]
    Time { what: &'static str, value: f64, expected: String },
    #[error("the saved state does not fit this instance")]
    ForeignState,
    #[error("the instance was made for a host without event mode (eventModeUsed is false)")]
    NoEventMode,
    #[error("{0}")]
    Blob(#[from] BlobError),
    #[error("the model can't be started with these parameters: {0}")]
    Start(SimulationError),
    #[error("\"{name}\" is not a finite number at t = {time} s; the inputs or parameters are beyond what the model can follow")]
    NotFinite { name: String, time: f64 },
    #[error("the outputs can't be evaluated: {0}")]
    Evaluation(SimulationError),
}

/// Why an instance cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum InstantiateError {
    #[error("resources/scene.toml: {0}")]
    Scene(#[from] SceneError),
    #[error(
        "the resources belong to GUID {found}, but {wanted} was asked for: modelDescription.xml and resources don't fit, or were changed"
    )]
    Guid { found: String, wanted: String },
}
