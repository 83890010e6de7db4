//! Steady rolling of a lone wheelset. On straight track: height and pitch rate such that vertical force and axle moment vanish.
//!
//! The wheelset stands centred (y = yaw = 0), does not move sideways or vertically and no input acts. On
//! straight, undisturbed track two numbers are left: z, which fixes the load, and the pitch rate, which fixes the
//! longitudinal creepage so that friction and spin moments about the axle cancel. Where the sides differ (profiles or radii) the
//! roll angle comes third, for the roll moment; lateral force and yaw moment then remain: the wheelset starts off its running
//! line. Where contact is a constraint, z and roll close the gaps and the load is carried by itself.
//!
//! A wheelset that starts at rest has pitch rate 0 and the height of slow rolling.
//!
//! On a track of constant curvature, superelevation and grade all coordinates are found, as for a vehicle
//! ([`super::vehicle::steady_state`]): the wheelset is displaced across the track and yaws. On a transition, where there is no steady state,
//! it starts as on straight track.

use super::spec::Scene;
use super::start::{self, Start};
use super::vehicle::steady_state;
use crate::formulation::memory::ModelMemory;
use crate::formulation::{AssemblyError, Evaluation, EvaluationError, Model, NEUTRAL_INPUTS, Workspace};
use crate::geometry::track::centre_line::Node;
use crate::math::newton::{self, NewtonLimits};
use crate::mbs::body::COORDINATES;
use nalgebra::{Matrix1, SMatrix, SVector, Vector1, Vector3};
use std::sync::Arc;

/// The equilibrium of a wheelset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyRolling {
    /// To the left, m; 0 on straight track.
    pub y: f64,
    /// Height of the centre, m.
    pub z: f64,
    /// rad; on straight track 0 where both sides are alike.
    pub roll: f64,
    /// rad; 0 on straight track.
    pub yaw: f64,
    /// rad/s.
    pub pitch_rate: f64,
    /// Across the track and upward [m/s], of roll and yaw [rad/s]: 0 on rails that are where they should be.
    pub riding: [f64; 4],
}

impl SteadyRolling {
    /// In the order of [`super::spec::INITIAL`].
    pub fn initial_values(&self) -> [f64; 10] {
        let [vy, vz, roll_rate, yaw_rate] = self.riding;
        [0.0, self.y, self.z, self.roll, self.yaw, vy, vz, roll_rate, yaw_rate, self.pitch_rate]
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
    #[error(
        "the vehicle starts on a transition: curvature, superelevation or grade change under it (at {distance:.1} m), and there is no steady state there; start before it or behind it (vehicle.initial.distance, the nodes' distances, track.smoothing)"
    )]
    OnTransition { distance: f64 },
    #[error(
        "no steady curving where the vehicle starts; it goes up to {percent:.0} % of the curvature and superelevation there: {cause}{advice}"
    )]
    Curving { percent: f64, cause: Box<EquilibriumError>, advice: &'static str },
    #[error(
        "no balance on the rails where the vehicle starts: it goes up to {percent:.0} % of their displacements there: {cause}; track.start_fade = \"30 m\" lets them grow in front of the vehicle, vehicle.initial.distance starts it elsewhere"
    )]
    OnRails { percent: f64, cause: Box<EquilibriumError> },
    #[error("no equilibrium: nothing holds {body} {motion}; a force element or a joint must carry it there")]
    Unsupported { body: String, motion: &'static str },
    #[error("no equilibrium was found: {body} is left with {acceleration:.3e} m/s2 (or rad/s2); check stiffnesses, preloads and positions")]
    Unbalanced { body: String, acceleration: f64 },
    #[error("no steady rolling equilibrium: {0}")]
    Evaluation(EvaluationError),
    #[error("{0}")]
    Assembly(#[from] AssemblyError),
}

/// Have both sides the same profiles? Then the steady wheelset does not roll.
pub(super) fn alike(scene: &Scene) -> bool {
    [&scene.vehicle.wheelset.profiles, &scene.track.rails].iter().all(|[left, right]| Arc::ptr_eq(&left.profile, &right.profile))
}

/// Finds the equilibrium of the scene's wheelset.
///
/// # Errors
/// [`EquilibriumError`].
pub fn steady_rolling(scene: &Scene) -> Result<SteadyRolling, EquilibriumError> {
    let node = match start::start(scene) {
        Start::Curve(node) => Some(node),
        Start::Straight | Start::Transition { .. } => start::displaced(scene).map(|_| Node::default()),
    };
    if let Some(node) = node {
        let found = steady_state::lone_wheelset(scene, &node)?;
        let [y, z, yaw, roll] = [1, 2, 3, 4].map(|i| found[i]);
        let riding = [1, 2, 4, 3].map(|i| found[COORDINATES + i]);
        return Ok(SteadyRolling { y, z, roll, yaw, pitch_rate: found[PITCH_RATE], riding });
    }
    let spec = &scene.vehicle.wheelset;
    let load = (spec.mass * scene.vehicle.gravity + spec.vertical_load) * scene.track.grade.cos();
    if load <= 0.0 {
        return Err(EquilibriumError::NoLoad { load });
    }
    // In slow rolling creepages, and with them this equilibrium, do not depend on the speed.
    let wanted = scene.vehicle.speed;
    let slow = wanted == 0.0 || (scene.contact.transient.is_some() && wanted.abs() < CREEPING);
    let speed = if slow { CREEPING.copysign(wanted) } else { wanted };
    let mut balance = Balance::new(scene, speed)?;
    let wheelset = &balance.model.wheelsets[0];
    let radius = wheelset.left.profile.at(0.0).value;
    balance.alike = alike(scene);
    let mut found = balance.steady_rolling(scene, radius, speed, load)?;
    if slow {
        found.pitch_rate *= wanted / speed;
    }
    Ok(found)
}

impl Balance {
    fn steady_rolling(&mut self, scene: &Scene, radius: f64, speed: f64, load: f64) -> Result<SteadyRolling, EquilibriumError> {
        if self.model.formulation.constrains() {
            return self.on_constraints(radius, speed / radius, scene.vehicle.wheelset.axial_inertia, load);
        }
        let start = self.touch(radius, speed / radius, load)?;
        if self.alike { self.on_springs::<2>(start, radius, load) } else { self.on_springs::<3>(start, radius, load) }
    }

    /// A place at which both wheels (or the deeper one, where they are alike) carry half the load with the stiffness of the first
    /// touch.
    fn touch(&mut self, radius: f64, pitch_rate: f64, load: f64) -> Result<SteadyRolling, EquilibriumError> {
        const TOUCH: f64 = 1e-5;
        let mut at = SteadyRolling { y: 0.0, z: radius, roll: 0.0, yaw: 0.0, pitch_rate, riding: [0.0; 4] };
        for _ in 0..3 {
            // Without memory the first contact is the deepest.
            self.memory = self.model.blank_memory();
            self.residual(&at).map_err(EquilibriumError::Evaluation)?;
            if !self.alike {
                let [left, right] = [0, 1].map(|side| self.workspace.contacts[side].penetration);
                at.roll += (left - right) / (2.0 * self.model.wheelsets[0].left.half_spacing);
                self.memory = self.model.blank_memory();
                self.residual(&at).map_err(EquilibriumError::Evaluation)?;
            }
            let deepest = self.workspace.contacts.iter().map(|contact| contact.penetration).fold(f64::MIN, f64::max);
            at.z += deepest - TOUCH;
        }
        self.residual(&at).map_err(EquilibriumError::Evaluation)?;
        let stiffness = self.workspace.contacts.iter().map(|contact| contact.stiffness).fold(0.0, f64::max);
        at.z += TOUCH - (0.5 * load / stiffness).powf(2.0 / 3.0);
        Ok(at)
    }

    /// Height, pitch rate and, with N = 3, roll on elastic contacts.
    fn on_springs<const N: usize>(&mut self, start: SteadyRolling, radius: f64, load: f64) -> Result<SteadyRolling, EquilibriumError> {
        // Unknowns scaled to be of order one; differences serve as Jacobian here, off the stepping path.
        let (height, turn, tilt) = (1e-4, 1e-3 * start.pitch_rate, 1e-4);
        let at = |x: &SVector<f64, N>| SteadyRolling {
            z: start.z + height * x[0],
            pitch_rate: start.pitch_rate + turn * x[1],
            roll: if N > 2 { start.roll + tilt * x[2] } else { 0.0 },
            ..start
        };
        let scale = Vector3::new(1.0 / load, 1.0 / (load * radius), 1.0 / load);
        let mut failure = None;
        let mut residual = |x: &SVector<f64, N>| {
            let found = self.residual(&at(x)).map(|r| r.component_mul(&scale)).unwrap_or_else(|error| {
                failure = Some(error);
                Vector3::repeat(f64::NAN)
            });
            found.fixed_rows::<N>(0).into_owned()
        };
        const H: f64 = 1e-5;
        let evaluate = |x: &SVector<f64, N>| {
            let mut here = residual(x);
            let mut jacobian = SMatrix::<f64, N, N>::zeros();
            for column in 0..N {
                let mut h = SVector::<f64, N>::zeros();
                h[column] = H;
                jacobian.set_column(column, &((residual(&(x + h)) - residual(&(x - h))) / (2.0 * H)));
            }
            if jacobian[(1, 1)] == 0.0 {
                // Without friction any pitch rate will do: it stays that of the tread circle.
                (here[1], jacobian[(1, 1)]) = (x[1], 1.0);
            }
            (here, jacobian)
        };
        let mut x = SVector::<f64, N>::zeros();
        let solved =
            newton::solve(&mut x, NewtonLimits { next_step: 1e-13, iterations: 60, rounding: 0.0 }, evaluate, |_, jacobian| *jacobian);
        let found = at(&x);
        match (solved, failure) {
            (Err(_), Some(error)) => Err(EquilibriumError::Evaluation(error)),
            // Rounding may stop the iteration before the foreseen step is short enough.
            (Err(failed), None) if failed.residual.is_nan() || failed.residual > BALANCED => {
                let rest = self.residual(&found).map_err(EquilibriumError::Evaluation)?;
                Err(EquilibriumError::NotFound { force: rest[0], moment: rest[1] })
            }
            _ => Ok(found),
        }
    }
}

/// Place of the pitch rate in the state of one wheelset.
const PITCH_RATE: usize = 2 * COORDINATES - 1;

/// Rounds in which a wheelset on unlike sides is brought back to the centre; each leaves a few per cent of the shift.
const CENTRED: usize = 12;

/// Forces relative to the load, and moments relative to load times radius, that count as zero where the iteration can not go on: of a contact a
/// thousand times as stiff as steel, rounding of the height makes 1e-10.
const BALANCED: f64 = 1e-9;

/// Speed at which a wheelset that starts at rest is balanced, m/s.
const CREEPING: f64 = 1.0;

/// Forces on the centred wheelset on straight track.
struct Balance {
    /// Are both sides the same?
    alike: bool,
    model: Model,
    workspace: Workspace,
    y: Vec<f64>,
    dy: Vec<f64>,
    memory: ModelMemory,
}

impl Balance {
    fn new(scene: &Scene, speed: f64) -> Result<Self, AssemblyError> {
        let mut model = super::assemble::model(scene)?;
        model.track = model.track.ideal();
        // In steady rolling the transient model says what the law says.
        model.laws.transient = None;
        for wheelset in &mut model.wheelsets {
            wheelset.imposed_speed = wheelset.imposed_speed.map(|_| speed);
        }
        let dimension = model.dimension();
        let mut y = vec![0.0; dimension];
        y[COORDINATES] = speed;
        Ok(Balance { alike: true, workspace: model.workspace(), dy: vec![0.0; dimension], memory: model.blank_memory(), model, y })
    }

    /// Equilibrium on contacts that are constraints: they fix the height, and the pitch rate must not change.
    fn on_constraints(&mut self, radius: f64, pitch_rate: f64, axial_inertia: f64, load: f64) -> Result<SteadyRolling, EquilibriumError> {
        let formulation = &self.model.formulation;
        (self.y[2], self.y[PITCH_RATE]) = (radius, pitch_rate);
        // Closing the gaps of unlike sides also moves the wheelset sideways a little: back to the centre, and again.
        for _ in 0..if self.alike { 1 } else { CENTRED } {
            (self.y[1], self.y[3]) = (0.0, 0.0);
            let mut step = self.model.at(&mut self.workspace, 0.0, &mut self.y, &mut self.memory);
            formulation.start(&mut step).and_then(|()| formulation.project(&mut step)).map_err(EquilibriumError::Evaluation)?;
        }
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
        let solved = newton::solve(&mut x, NewtonLimits { next_step: 1e-13, iterations: 60, rounding: 0.0 }, evaluate, |_, slope| *slope);
        match (solved, failure) {
            (Err(_), Some(error)) => Err(EquilibriumError::Evaluation(error)),
            (Err(failed), None) if failed.residual.is_nan() || failed.residual > BALANCED => {
                Err(EquilibriumError::NotFound { force: 0.0, moment: failed.residual * load * radius })
            }
            _ => {
                let pitch_rate = start * (1.0 + 1e-3 * x[0]);
                Ok(SteadyRolling { y: 0.0, z: self.y[2], roll: self.y[4], yaw: 0.0, pitch_rate, riding: [0.0; 4] })
            }
        }
    }

    /// Vertical force [N], moment about the axle and moment about the direction of travel [N m].
    fn residual(&mut self, at: &SteadyRolling) -> Result<Vector3<f64>, EvaluationError> {
        self.y[2] = at.z;
        self.y[4] = at.roll;
        self.y[PITCH_RATE] = at.pitch_rate;
        let at = Evaluation { t: 0.0, inputs: &NEUTRAL_INPUTS, y: &self.y, memory: &mut self.memory };
        self.model.derivative(&mut self.workspace, at, &mut self.dy)?;
        let wrench = &self.workspace.system.wrenches[0];
        let axle = self.workspace.system.motions[0].axle();
        Ok(Vector3::new(wrench.force.z, wrench.moment.dot(&axle), wrench.moment.x))
    }
}
