//! Floor 5: integration of ordinary differential equations. Knows nothing of railways.
//!
//! A system implements [`Dynamics`]; an [`Integrator`] advances an [`IntegrationState`], which holds all memory of the
//! past. Steps are the integrator's own: they pass communication points, where the solution is read from the dense
//! output of the last step, so results do not depend on where a master looks. Steps end where the system is not
//! smooth ([`Dynamics::next_break`]).

mod dormand_prince;
mod rk4;
mod state;

pub use state::{IntegrationState, Statistics};

use crate::settings::{Entry, Section, SettingsError, choose};

/// A system `y' = f(t, y)`.
pub trait Dynamics {
    /// Why an evaluation failed.
    type Error: std::error::Error;

    /// Length of y.
    fn dimension(&self) -> usize;

    /// Writes f(t, y) to `dy`. `memory` is the system's own record (warm starts) and belongs to the state.
    ///
    /// # Errors
    /// When f is not defined at (t, y); the integrator then tries a shorter step.
    fn derivative(&mut self, t: f64, y: &[f64], memory: &mut [f64], dy: &mut [f64]) -> Result<(), Self::Error>;

    /// Is the local error of component `i` controlled? (positions and angles, in metres and radians)
    fn controlled(&self, i: usize) -> bool;

    /// The next time after `t` where f is not smooth; infinity when there is none. A prediction is enough: it is
    /// asked for before each step.
    fn next_break(&self, t: f64, y: &[f64], memory: &[f64]) -> f64;
}

/// An integration stopped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError<E: std::error::Error> {
    #[error("{0}")]
    Evaluation(E),
    #[error(
        "t = {time:.9} s: a step of {step:.1e} s still misses the tolerance {tolerance:.1e}; loosen solver.tolerance or look for a jump in the scene"
    )]
    StepTooSmall { time: f64, step: f64, tolerance: f64 },
    #[error("t = {time:.9} s: the solution is no longer finite; reduce solver.step (it is {step:.1e} s)")]
    NotFinite { time: f64, step: f64 },
}

/// A method with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// Adaptive Dormand-Prince 5(4) with continuous output of order 4; `tolerance` bounds the local error of each
    /// controlled component, m and rad.
    DormandPrince { tolerance: f64 },
    /// Classical Runge-Kutta of order 4 with a fixed step, s; cubic Hermite output.
    RungeKutta4 { step: f64 },
}

impl Integrator {
    /// Evaluations of f per attempted step, and the number of vectors of length n that the dense output needs.
    fn dense_vectors(self) -> usize {
        match self {
            Integrator::DormandPrince { .. } => dormand_prince::DENSE_VECTORS,
            Integrator::RungeKutta4 { .. } => rk4::DENSE_VECTORS,
        }
    }

    /// A state at (t, y) with the system's initial memory; the first step length is found when it is needed.
    pub fn start(self, t: f64, y: &[f64], memory: &[f64]) -> IntegrationState {
        IntegrationState::new(t, y, memory, self.dense_vectors())
    }

    /// Advances until the state reaches `target` or passes it; [`IntegrationState::interpolate`] then gives the
    /// solution at `target`.
    ///
    /// # Errors
    /// [`SolveError`]; the state then stands at the last successful step.
    pub fn advance<D: Dynamics>(
        self,
        dynamics: &mut D,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        target: f64,
    ) -> Result<(), SolveError<D::Error>> {
        while state.t < target {
            self.step(dynamics, state, scratch)?;
        }
        Ok(())
    }

    /// One accepted step, which ends at the next break at the latest.
    ///
    /// # Errors
    /// See [`Integrator::advance`].
    pub fn step<D: Dynamics>(
        self,
        dynamics: &mut D,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
    ) -> Result<(), SolveError<D::Error>> {
        match self {
            Integrator::DormandPrince { tolerance } => dormand_prince::step(tolerance, dynamics, state, scratch),
            Integrator::RungeKutta4 { step } => rk4::step(step, dynamics, state, scratch),
        }
    }
}

/// Vectors that a step works in; nothing in here outlives it.
#[derive(Clone, Debug)]
pub struct Scratch {
    stages: [Vec<f64>; 7],
    trial: Vec<f64>,
    memory: Vec<f64>,
}

impl Scratch {
    pub fn new(dimension: usize, memory: usize) -> Self {
        Scratch { stages: std::array::from_fn(|_| vec![0.0; dimension]), trial: vec![0.0; dimension], memory: vec![0.0; memory] }
    }
}

type Parse = fn(&Section) -> Result<Integrator, SettingsError>;

/// Every integrator that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[dormand_prince::ENTRY, rk4::ENTRY];

/// Reads `[solver]`; returns the method's name and the method.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<(&'static str, Integrator), SettingsError> {
    let entry = choose(REGISTRY, section, "integrator")?;
    // Each method takes the one that it needs; the other may stay for the next choice.
    let _ = (section.has("tolerance"), section.has("step"));
    Ok((entry.name, (entry.parse)(section)?))
}

#[cfg(test)]
mod tests;
