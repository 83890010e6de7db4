//! The model's right-hand side and projection, differenced about a state.
//!
//! Central differences over steps that are short beside what contact laws are curved over: creep laws have kinks of second order at vanishing creepage (those of the first: [`super::harmonic`]),
//! so velocities move by 3e-8 of the travelling speed; positions by 1e-7 m, a thousandth of a penetration. Where joints or contacts are
//! constraints each neighbour is moved onto them first: what is found is then the slope along the manifold that they leave,
//!
//! ```text
//! P = dp/dy,   J P = d f(p(y)) / dy
//! ```
//!
//! with p the projection, which meets constraints to 1e-13 m; steps there are ten times as long.

use super::Dense;
use super::turning::Turning;
use crate::formulation::memory::ModelMemory;
use crate::formulation::{Evaluation, EvaluationError, Model, Workspace};
use crate::mbs::body::{COORDINATES, YAW};
use faer::Mat;

/// Steps of positions [m], of angles that are creepages [rad], and of velocities in parts of the travelling speed.
const POSITION: f64 = 1e-7;
const ANGLE: f64 = 3e-8;
const VELOCITY: f64 = 3e-8;
/// Of states of force elements and contacts, in parts of their size or of 1.
const OTHER: f64 = 1e-6;
/// How much longer steps are where states are projected.
const PROJECTED: f64 = 10.0;
/// The least speed that steps of velocities are parts of, m/s.
const SLOWEST: f64 = 1.0;

/// Slopes at a state.
pub(super) struct Linear {
    /// P, and J P.
    pub projector: Dense,
    pub slopes: Dense,
    /// f(y).
    pub rates: Vec<f64>,
    /// How the wheels' loads change with each state, N per its unit, by state and contact.
    pub loads: Vec<Vec<f64>>,
    /// Loads of the wheels at the state, N.
    pub carried: Vec<f64>,
    /// By how far wheels' loads are off on the ways of [`super::across`], in parts of themselves.
    pub off: f64,
}

impl Linear {
    pub fn size(&self) -> usize {
        self.rates.len()
    }
}

/// A state and what is about it.
pub(super) struct Neighbourhood<'a> {
    pub model: &'a Model,
    pub y: Vec<f64>,
    memory: &'a ModelMemory,
    inputs: Vec<f64>,
    workspace: Workspace,
    trial: ModelMemory,
    /// Is anything a constraint?
    constrained: bool,
    speed: f64,
    /// Where the steady motion turns.
    pub turning: Option<Turning>,
}

impl<'a> Neighbourhood<'a> {
    pub fn new(model: &'a Model, y: &[f64], memory: &'a ModelMemory, inputs: Vec<f64>) -> Self {
        Neighbourhood {
            workspace: model.workspace(),
            inputs,
            trial: memory.clone(),
            constrained: model.formulation.constrains() || model.formulation.states_per_contact() > 0 || !model.system.joints.is_empty(),
            speed: travelling(model, y).max(SLOWEST),
            turning: None,
            y: y.to_vec(),
            model,
            memory,
        }
    }

    /// The same seen from a frame that turns with the vehicle, where the state is one of steady running in a curve.
    pub fn turning_with_it(self) -> Self {
        Neighbourhood { turning: Turning::of(self.model.system.bodies.len(), &self.y), ..self }
    }

    /// Step of a state.
    pub fn step(&self, index: usize) -> f64 {
        let count = COORDINATES * self.model.system.bodies.len();
        let own = match index {
            _ if index < count && index % COORDINATES == YAW => ANGLE,
            _ if index < count => POSITION,
            _ if index < 2 * count => VELOCITY * self.speed,
            // Rails press wheels as wheels press rails.
            _ if self.model.weight_of_rail(index).is_some() => POSITION,
            _ => OTHER * self.y[index].abs().max(1.0),
        };
        if self.constrained { PROJECTED * own } else { own }
    }

    /// The state nearest to `y` that is on the constraints, and its rates.
    pub fn rates(&mut self, mut y: Vec<f64>) -> Result<Met, EvaluationError> {
        self.trial.clone_from(self.memory);
        if self.constrained {
            self.model.at(&mut self.workspace, 0.0, &mut y, &mut self.trial).project()?;
        }
        let mut rates = vec![0.0; y.len()];
        let at = Evaluation { t: 0.0, inputs: &self.inputs, y: &y, memory: &mut self.trial };
        self.model.derivative(&mut self.workspace, at, &mut rates)?;
        if let Some(turning) = &self.turning {
            turning.take_off(&y, &mut rates);
        }
        Ok((y, rates))
    }

    /// Slopes with steps of `length` times their usual length.
    pub fn linear(&mut self, length: f64) -> Result<Linear, EvaluationError> {
        let size = self.y.len();
        let mut linear = Linear {
            projector: Mat::zeros(size, size),
            slopes: Mat::zeros(size, size),
            rates: Vec::new(),
            loads: Vec::new(),
            carried: Vec::new(),
            off: 0.0,
        };
        let here = self.y.clone();
        for column in 0..size {
            let loads = self.add_slope(&here, column, length, 1.0, &mut linear)?;
            linear.loads.push(loads);
        }
        linear.rates = self.rates(self.y.clone())?.1;
        linear.carried = self.wheel_loads();
        Ok(linear)
    }

    /// Adds the slope by one state at a place, times a weight, to its column; returns how the wheels' loads change, N per its unit.
    pub fn add_slope(
        &mut self,
        place: &[f64],
        column: usize,
        length: f64,
        weight: f64,
        linear: &mut Linear,
    ) -> Result<Vec<f64>, EvaluationError> {
        let step = length * self.step(column);
        let mut beside = |sign: f64| {
            let mut y = place.to_vec();
            y[column] += sign * step;
            self.rates(y).map(|found| (found, self.wheel_loads()))
        };
        let ((ahead, heavier), (behind, lighter)) = (beside(1.0)?, beside(-1.0)?);
        // What the state really moved by, after rounding.
        let moved = (place[column] + step) - (place[column] - step);
        add_to_column(linear, column, (&ahead, &behind), weight / moved);
        Ok(heavier.iter().zip(&lighter).map(|(a, b)| (a - b) / moved).collect())
    }

    /// Normal force of each wheel as it was evaluated last, N.
    pub fn wheel_loads(&self) -> Vec<f64> {
        let of = |contact: usize| self.workspace.reports(contact).map(|report| report.normal_force).sum();
        (0..self.model.contacts()).map(of).collect()
    }
}

/// Speed of the first body, m/s.
fn travelling(model: &Model, y: &[f64]) -> f64 {
    let count = COORDINATES * model.system.bodies.len();
    y[count].hypot(y[count + 1])
}

/// A state that was met, and its rates.
pub(super) type Met = (Vec<f64>, Vec<f64>);

/// Adds differences of states and rates, times a weight.
pub(super) fn add_to_column(linear: &mut Linear, column: usize, (ahead, behind): (&Met, &Met), weight: f64) {
    for row in 0..ahead.0.len() {
        linear.projector[(row, column)] += (ahead.0[row] - behind.0[row]) * weight;
        linear.slopes[(row, column)] += (ahead.1[row] - behind.1[row]) * weight;
    }
}

pub(super) fn scale_column(linear: &mut Linear, column: usize, by: f64) {
    for matrix in [&mut linear.projector, &mut linear.slopes] {
        (0..matrix.nrows()).for_each(|row| matrix[(row, column)] *= by);
    }
}
