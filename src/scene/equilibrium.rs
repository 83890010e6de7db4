//! Why a vehicle has no steady state to start from.

use crate::formulation::{AssemblyError, EvaluationError};

/// There is no equilibrium, or it was not found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EquilibriumError {
    #[error("the wheelset does not press on the rails: weight plus vertical_load is {load} N; it must be positive")]
    NoLoad { load: f64 },
    #[error(
        "the vehicle starts on a transition: curvature, superelevation or grade change under it (at {distance:.1} m), and there is no steady state there; start before it or behind it (vehicle.initial.distance, the nodes' distances, track.smoothing)"
    )]
    OnTransition { distance: f64 },
    #[error(
        "the run begins at {place}, within a ramp of vehicle.speed, and there is no steady state under acceleration; begin it where the speed is constant (before the first node or behind the last one), or with vehicle.initial.from_equilibrium = false"
    )]
    Accelerates { place: String },
    #[error(
        "no steady curving where the vehicle starts; it goes up to {percent:.0} % of the curvature and superelevation there: {cause}{advice}"
    )]
    Curving { percent: f64, cause: Box<EquilibriumError>, advice: &'static str },
    #[error(
        "no balance on the rails where the vehicle starts: it goes up to {percent:.0} % of their displacements there: {cause}; track.start_fade = \"30 m\" lets them grow in front of the vehicle, vehicle.initial.distance starts it elsewhere"
    )]
    OnRails { percent: f64, cause: Box<EquilibriumError> },
    #[error(
        "no equilibrium: nothing holds {body} {motion}; a force element or a joint must carry it there (within its slack a coupler does not, nor a stop within its free travel)"
    )]
    Unsupported { body: String, motion: &'static str },
    #[error(
        "no equilibrium: {wheelset} does not press on its rails, so that not even its spin is held: is the centre of mass of what it carries beyond the wheelbase, or does a preload lift it?"
    )]
    Lifted { wheelset: String },
    #[error("no equilibrium was found: {body} is left with {acceleration:.3e} m/s2 (or rad/s2); check stiffnesses, preloads and positions")]
    Unbalanced { body: String, acceleration: f64 },
    #[error("no steady rolling equilibrium: {0}")]
    Evaluation(EvaluationError),
    #[error("{0}")]
    Assembly(#[from] AssemblyError),
}
