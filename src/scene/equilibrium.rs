//! Steady rolling on straight track: height and pitch rate such that vertical force and axle moment vanish.
//!
//! The wheelset stands centred (y = roll = yaw = 0), does not move sideways or vertically and no input acts. On
//! straight, undisturbed track two numbers are left: z, which fixes the load, and the pitch rate, which fixes the
//! longitudinal creepage so that friction and spin moments about the axle cancel. Where contact is a constraint, z closes the
//! gaps and the load is carried by itself.

use super::spec::Scene;
use crate::formulation::{AssemblyError, Evaluation, EvaluationError, Model, NEUTRAL_INPUTS, Workspace};
use crate::math::newton::{self, NewtonLimits};
use crate::mbs::body::COORDINATES;
use nalgebra::{Matrix1, Matrix2, Vector1, Vector2};

/// The equilibrium of a wheelset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyRolling {
    /// Height of the centre, m.
    pub z: f64,
    /// rad/s.
    pub pitch_rate: f64,
}

impl SteadyRolling {
    /// In the order of [`super::spec::INITIAL`].
    pub fn initial_values(&self) -> [f64; 10] {
        [0.0, 0.0, self.z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, self.pitch_rate]
    }
}

/// There is no equilibrium, or it was not found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EquilibriumError {
    #[error("the wheelset does not press on the rails: weight plus vertical_load is {load} N; it must be positive")]
    NoLoad { load: f64 },
    #[error(
        "no steady rolling equilibrium: vertical force is off by {force:.3e} N and axle moment by {moment:.3e} N m; check profiles, spacing and load"
    )]
    NotFound { force: f64, moment: f64 },
    #[error("no steady rolling equilibrium: {0}")]
    Evaluation(EvaluationError),
    #[error("{0}")]
    Assembly(#[from] AssemblyError),
}

/// Finds the equilibrium of the scene's wheelset.
///
/// # Errors
/// [`EquilibriumError`].
pub fn steady_rolling(scene: &Scene) -> Result<SteadyRolling, EquilibriumError> {
    let spec = &scene.vehicle.wheelset;
    let load = spec.mass * scene.vehicle.gravity * scene.track.grade.cos() + spec.vertical_load;
    if load <= 0.0 {
        return Err(EquilibriumError::NoLoad { load });
    }
    let mut balance = Balance::new(scene)?;
    let radius = balance.model.wheelsets[0].left.profile.at(0.0).value;
    let speed = scene.vehicle.speed;

    if balance.model.formulation.constrains() {
        return balance.on_constraints(radius, speed / radius, spec.axial_inertia, load);
    }

    // Start: the height at which the deeper wheel carries half the load with the stiffness of the first touch.
    const TOUCH: f64 = 1e-5;
    let mut z = radius;
    for _ in 0..3 {
        balance.residual(z, speed / radius).map_err(EquilibriumError::Evaluation)?;
        let deepest = balance.workspace.contacts.iter().map(|contact| contact.penetration).fold(f64::MIN, f64::max);
        z += deepest - TOUCH;
    }
    balance.residual(z, speed / radius).map_err(EquilibriumError::Evaluation)?;
    let stiffness = balance.workspace.contacts.iter().map(|contact| contact.stiffness).fold(0.0, f64::max);
    z += TOUCH - (0.5 * load / stiffness).powf(2.0 / 3.0);

    // Unknowns scaled to be of order one; differences serve as Jacobian here, off the stepping path.
    let (height, turn) = (1e-4, 1e-3 * speed / radius);
    let at = |x: &Vector2<f64>| (z + height * x[0], speed / radius + turn * x[1]);
    let scale = Vector2::new(1.0 / load, 1.0 / (load * radius));
    let mut failure = None;
    let mut residual = |x: &Vector2<f64>| {
        let (z, pitch_rate) = at(x);
        balance.residual(z, pitch_rate).map(|r| r.component_mul(&scale)).unwrap_or_else(|error| {
            failure = Some(error);
            Vector2::repeat(f64::NAN)
        })
    };
    const H: f64 = 1e-5;
    let evaluate = |x: &Vector2<f64>| {
        let mut here = residual(x);
        let columns = [Vector2::new(H, 0.0), Vector2::new(0.0, H)].map(|h| (residual(&(x + h)) - residual(&(x - h))) / (2.0 * H));
        let mut jacobian = Matrix2::from_columns(&columns);
        if jacobian[(1, 1)] == 0.0 {
            // Without friction any pitch rate will do: it stays that of the tread circle.
            (here[1], jacobian[(1, 1)]) = (x[1], 1.0);
        }
        (here, jacobian)
    };
    let mut x = Vector2::zeros();
    let solved = newton::solve(&mut x, NewtonLimits { next_step: 1e-13, iterations: 60 }, evaluate, |_, jacobian| *jacobian);
    let (z, pitch_rate) = at(&x);
    match (solved, failure) {
        (Err(_), Some(error)) => Err(EquilibriumError::Evaluation(error)),
        // Rounding may stop the iteration before the foreseen step is short enough.
        (Err(failed), None) if failed.residual.is_nan() || failed.residual > BALANCED => {
            let rest = balance.residual(z, pitch_rate).map_err(EquilibriumError::Evaluation)?;
            Err(EquilibriumError::NotFound { force: rest[0], moment: rest[1] })
        }
        _ => Ok(SteadyRolling { z, pitch_rate }),
    }
}

/// Place of the pitch rate in the state of one wheelset.
const PITCH_RATE: usize = 2 * COORDINATES - 1;

/// Forces relative to the load, and moments relative to load times radius, that count as zero.
const BALANCED: f64 = 1e-11;

/// Forces on the centred wheelset on straight track.
struct Balance {
    model: Model,
    workspace: Workspace,
    y: Vec<f64>,
    dy: Vec<f64>,
    memory: Vec<f64>,
}

impl Balance {
    fn new(scene: &Scene) -> Result<Self, AssemblyError> {
        let mut model = super::assemble::model(scene)?;
        model.track = model.track.ideal();
        let dimension = model.dimension();
        let mut y = vec![0.0; dimension];
        y[COORDINATES] = scene.vehicle.speed;
        Ok(Balance { workspace: model.workspace(), dy: vec![0.0; dimension], memory: vec![0.0; model.memory()], model, y })
    }

    /// Equilibrium on contacts that are constraints: they fix the height, and the pitch rate must not change.
    fn on_constraints(&mut self, radius: f64, pitch_rate: f64, axial_inertia: f64, load: f64) -> Result<SteadyRolling, EquilibriumError> {
        let formulation = &self.model.formulation;
        (self.y[2], self.y[PITCH_RATE]) = (radius, pitch_rate);
        formulation
            .start(&self.model, &mut self.workspace, 0.0, &mut self.y, &mut self.memory)
            .and_then(|()| formulation.project(&self.model, &mut self.workspace, 0.0, &mut self.y, &mut self.memory))
            .map_err(EquilibriumError::Evaluation)?;
        let start = self.y[PITCH_RATE];
        let mut failure = None;
        let mut moment = |x: f64| {
            self.y[PITCH_RATE] = start * (1.0 + 1e-3 * x);
            let at = Evaluation { t: 0.0, inputs: &NEUTRAL_INPUTS, y: &self.y, memory: &mut self.memory };
            match self.model.derivative(&mut self.workspace, at, &mut self.dy) {
                Ok(()) => self.dy[PITCH_RATE] * axial_inertia / (load * radius),
                Err(error) => {
                    failure = Some(error);
                    f64::NAN
                }
            }
        };
        const H: f64 = 1e-5;
        let evaluate = |x: &Vector1<f64>| {
            let (here, slope) = (moment(x[0]), (moment(x[0] + H) - moment(x[0] - H)) / (2.0 * H));
            // Without friction any pitch rate will do: it stays that of the tread circle.
            let (here, slope) = if slope == 0.0 { (x[0], 1.0) } else { (here, slope) };
            (Vector1::new(here), Matrix1::new(slope))
        };
        let mut x = Vector1::zeros();
        let solved = newton::solve(&mut x, NewtonLimits { next_step: 1e-13, iterations: 60 }, evaluate, |_, slope| *slope);
        match (solved, failure) {
            (Err(_), Some(error)) => Err(EquilibriumError::Evaluation(error)),
            (Err(failed), None) if failed.residual.is_nan() || failed.residual > BALANCED => {
                Err(EquilibriumError::NotFound { force: 0.0, moment: failed.residual * load * radius })
            }
            _ => Ok(SteadyRolling { z: self.y[2], pitch_rate: start * (1.0 + 1e-3 * x[0]) }),
        }
    }

    /// Vertical force [N] and moment about the axle [N m].
    fn residual(&mut self, z: f64, pitch_rate: f64) -> Result<Vector2<f64>, EvaluationError> {
        self.y[2] = z;
        self.y[PITCH_RATE] = pitch_rate;
        let at = Evaluation { t: 0.0, inputs: &NEUTRAL_INPUTS, y: &self.y, memory: &mut self.memory };
        self.model.derivative(&mut self.workspace, at, &mut self.dy)?;
        let wrench = &self.workspace.system.wrenches[0];
        let axle = self.workspace.system.motions[0].axle();
        Ok(Vector2::new(wrench.force.z, wrench.moment.dot(&axle)))
    }
}
