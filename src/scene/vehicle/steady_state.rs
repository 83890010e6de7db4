//! Steady running of a free vehicle on ideal track, by Newton's method from the design configuration.
//!
//! All bodies travel with the pattern of a rigid motion: V along the track and the turning speed W = V kappa about the vertical
//! through the centre of the curve at (0, V/W), so that a body at (x, y) has
//!
//! ```text
//! v = (V - W y, W x, 0),   yaw' = W,   a = (-W^2 x, W (V - W y), 0)
//! ```
//!
//! W = 0 on straight track. Unknown are the six coordinates of each body; a wheelset has its pitch rate in place of its pitch.
//! Wheelsets with imposed speed keep their x; where there is none the leading wheelset keeps its x, and in its place stands the
//! common acceleration along the track with which the vehicle slows down (rolling resistance of spin creepage, grade). Zero are
//! the accelerations of the constrained system less those of the pattern, and, where joints or contacts are constraints, the
//! moves that bring the coordinates onto them. This system is consistent, but it has more equations than unknowns; each
//! step is the shortest least-squares one (singular value decomposition), halved until the sum of squares falls.
//! Differences serve as Jacobian here, off the stepping path. First-order states of force elements are at rest.
//!
//! A direction in which nothing pushes a body back has a vanishing singular value: neutral ones (a cylinder across its rail) stay
//! where they are, and if no balance exists the body that moves most in such a direction is named.

use super::FreeVehicle;
use super::assemble::design_state;
use crate::formulation::{AssemblyError, Evaluation, EvaluationError, Model, Workspace, contact_index};
use crate::geometry::Side;
use crate::mbs::body::COORDINATES;
use crate::scene::assemble;
use crate::scene::equilibrium::EquilibriumError;
use crate::scene::spec::Scene;
use faer::Mat;
use faer::linalg::solvers::Svd;

/// A state of steady running.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyState {
    /// The state vector; the design frame's origin is at distance 0.
    pub y: Vec<f64>,
    /// Mean vertical force of a wheel of each wheelset, N.
    pub wheel_loads: Vec<f64>,
}

/// The rigid motion that all bodies take part in.
#[derive(Clone, Copy, Debug)]
struct Pattern {
    /// V, m/s.
    speed: f64,
    /// W, rad/s.
    turning: f64,
}

/// Speed at which a vehicle that starts at rest is balanced, m/s.
const CREEPING: f64 = 1.0;
/// Accelerations count in parts of this, m/s2 or rad/s2.
const UNIT: f64 = 9.81;
/// Moves onto constraints count in parts of this, m or rad.
const MOVE: f64 = 1e-4;
/// Rest of the equations that counts as none: smoothed curvatures of real profiles leave contact forces less smooth than this.
const BALANCED: f64 = 1e-6;
/// Rest at which rounding is reached.
const EXACT: f64 = 1e-13;
const ITERATIONS: usize = 60;
const HALVINGS: i32 = 25;
/// Singular values below this part of the largest are noise.
const NOISE: f64 = 1e-12;
/// Restoring acceleration per displacement below which nothing holds a body, 1/s2 in parts of [`UNIT`].
const LOOSE: f64 = 1e-5;

/// Finds the steady state of a scene's free vehicle.
///
/// # Errors
/// [`EquilibriumError`], with the name of a body that has no support if that is the reason.
pub fn steady_state(scene: &Scene, free: &FreeVehicle) -> Result<SteadyState, EquilibriumError> {
    let load = free.weight(scene.vehicle.gravity) * scene.track.grade.cos();
    if load <= 0.0 {
        return Err(EquilibriumError::NoLoad { load });
    }
    // In slow rolling creepages, and with them the balance, do not depend on the speed.
    let wanted = scene.vehicle.speed;
    let slow = wanted == 0.0 || (scene.contact.transient.is_some() && wanted.abs() < CREEPING);
    let speed = if slow { CREEPING.copysign(wanted) } else { wanted };
    let mut search = Search::new(scene, free, Pattern { speed, turning: 0.0 })?;
    search.stand(load)?;
    search.balance()?;
    Ok(search.found(wanted / speed))
}

/// What Newton's method may change.
#[derive(Clone, Copy, Debug)]
enum Unknown {
    /// A place in the state vector, and how far it is moved for a difference (in units of the unknown).
    State { at: usize, step: f64, unit: f64 },
    /// The common acceleration along the track.
    Slowing,
}

struct Search<'a> {
    free: &'a FreeVehicle,
    pattern: Pattern,
    model: Model,
    workspace: Workspace,
    y: Vec<f64>,
    dy: Vec<f64>,
    memory: Vec<f64>,
    inputs: Vec<f64>,
    /// Are there constraints that coordinates must be moved onto?
    constrained: bool,
    unknowns: Vec<Unknown>,
    /// m/s2.
    slowing: f64,
}

impl<'a> Search<'a> {
    fn new(scene: &Scene, free: &'a FreeVehicle, pattern: Pattern) -> Result<Self, AssemblyError> {
        let mut scene = scene.clone();
        // The balance is that at the speed of the pattern.
        scene.vehicle.speed = pattern.speed;
        let mut model = assemble::model(&scene)?;
        model.track = model.track.ideal();
        // In steady rolling the transient model says what the law says.
        model.laws.transient = None;
        let mut y = design_state(free, &model.system, pattern.speed);
        y.resize(model.dimension(), 0.0);
        for wheelset in &model.wheelsets {
            let radius = wheelset.left.profile.at(0.0).value;
            y[model.system.velocities(wheelset.body).end - 1] = pattern.speed / radius;
        }
        let mut search = Search {
            workspace: model.workspace(),
            dy: vec![0.0; y.len()],
            memory: vec![0.0; model.memory()],
            inputs: model.neutral_inputs(),
            constrained: model.formulation.constrains() || !model.system.joints.is_empty(),
            unknowns: Vec::new(),
            slowing: 0.0,
            free,
            pattern,
            model,
            y,
        };
        search.unknowns = search.unknowns();
        Ok(search)
    }

    fn unknowns(&self) -> Vec<Unknown> {
        const PITCH: usize = COORDINATES - 1;
        let system = &self.model.system;
        let wheelsets = self.free.wheelsets.len();
        let elastic = !self.model.formulation.constrains();
        let mut unknowns = Vec::new();
        for body in 0..system.bodies.len() {
            let driven = system.drives.iter().any(|drive| drive.body == body);
            for coordinate in 0..COORDINATES {
                let unknown = match coordinate {
                    0 if driven => continue,
                    0 if body == 0 && system.drives.is_empty() => Unknown::Slowing,
                    PITCH if body < wheelsets => {
                        let at = system.velocities(body).start + PITCH;
                        Unknown::State { at, step: 1e-7, unit: self.y[at].abs() }
                    }
                    // Height and roll press wheels into rails: 1e-9 m are some newtons.
                    2 | 4 if body < wheelsets && elastic => {
                        Unknown::State { at: system.coordinates(body).start + coordinate, step: 1e-9, unit: 1.0 }
                    }
                    _ => Unknown::State { at: system.coordinates(body).start + coordinate, step: 1e-6, unit: 1.0 },
                };
                unknowns.push(unknown);
            }
        }
        unknowns
    }

    /// Lowers each wheelset until its wheels carry their shares with the stiffness of the first touch.
    fn stand(&mut self, load: f64) -> Result<(), EquilibriumError> {
        const TOUCH: f64 = 1e-5;
        if self.model.formulation.constrains() {
            return Ok(());
        }
        let wheel_load = load / self.model.contacts() as f64;
        let count = self.model.wheelsets.len();
        for _ in 0..3 {
            for level in [true, false] {
                // Without memory the first contact is the deepest.
                self.memory.fill(0.0);
                self.evaluate().map_err(EquilibriumError::Evaluation)?;
                for wheelset in 0..count {
                    let [left, right] = Side::BOTH.map(|side| self.workspace.contacts[contact_index(wheelset, side)].penetration);
                    let q = self.model.system.coordinates(wheelset).start;
                    if level {
                        self.y[q + 4] += (left - right) / (2.0 * self.model.wheelsets[wheelset].left.half_spacing);
                    } else {
                        self.y[q + 2] += left.max(right) - TOUCH;
                    }
                }
            }
        }
        self.evaluate().map_err(EquilibriumError::Evaluation)?;
        for wheelset in 0..count {
            let stiffness = Side::BOTH.map(|side| self.workspace.contacts[contact_index(wheelset, side)].stiffness);
            let at = self.model.system.coordinates(wheelset).start + 2;
            self.y[at] += TOUCH - (wheel_load / stiffness[0].max(stiffness[1])).powf(2.0 / 3.0);
        }
        Ok(())
    }

    /// Accelerations at `y`, which is moved onto the constraints first.
    fn evaluate(&mut self) -> Result<(), EvaluationError> {
        let Search { model, workspace, y, dy, memory, inputs, .. } = self;
        if model.formulation.constrains() || model.formulation.states_per_contact() > 0 {
            model.formulation.start(model, workspace, 0.0, y, memory)?;
        }
        if self.constrained {
            model.formulation.project(model, workspace, 0.0, y, memory)?;
        }
        model.system.settle_forces(y, &mut workspace.system);
        model.derivative(workspace, Evaluation { t: 0.0, inputs, y, memory }, dy)
    }

    /// What is to vanish, with the unknowns moved by `change`; the state stays as it was unless `keep`.
    fn residual(&mut self, change: &[f64], keep: bool) -> Result<Vec<f64>, EvaluationError> {
        let before = (self.y.clone(), self.slowing);
        for (unknown, change) in self.unknowns.iter().zip(change) {
            match unknown {
                Unknown::State { at, unit, .. } => self.y[*at] += unit * change,
                Unknown::Slowing => self.slowing += UNIT * change,
            }
        }
        self.follow_pattern();
        let asked = self.y.clone();
        let done = self.evaluate();
        let kept = keep && done.is_ok();
        // A state that is kept stands on the constraints.
        let rest = if kept { self.rest(&self.y) } else { self.rest(&asked) };
        if !kept {
            (self.y, self.slowing) = before;
        }
        done.map(|()| rest)
    }

    /// Gives all bodies the velocities of the pattern.
    fn follow_pattern(&mut self) {
        let Pattern { speed, turning } = self.pattern;
        for body in 0..self.model.system.bodies.len() {
            let (q, v) = (self.model.system.coordinates(body).start, self.model.system.velocities(body).start);
            let (x, y) = (self.y[q], self.y[q + 1]);
            self.y[v..v + 5].copy_from_slice(&[speed - turning * y, turning * x, 0.0, turning, 0.0]);
            if body >= self.free.wheelsets.len() {
                self.y[v + 5] = 0.0;
            }
        }
    }

    fn rest(&self, asked: &[f64]) -> Vec<f64> {
        let Pattern { speed, turning } = self.pattern;
        let system = &self.model.system;
        let mut rest = Vec::with_capacity(2 * COORDINATES * system.bodies.len());
        for body in 0..system.bodies.len() {
            let (q, v) = (system.coordinates(body).start, system.velocities(body).start);
            let driven = system.drives.iter().any(|drive| drive.body == body);
            // A wheel that slows down turns more slowly, too.
            let slower = if body < self.free.wheelsets.len() { self.slowing * self.y[v + 5] / speed } else { 0.0 };
            let along = if driven { 0.0 } else { -turning * turning * self.y[q] + self.slowing };
            let wanted = [along, turning * (speed - turning * self.y[q + 1]), 0.0, 0.0, 0.0, slower];
            rest.extend((0..COORDINATES).map(|i| (self.dy[v + i] - wanted[i]) / UNIT));
        }
        if self.constrained {
            let coordinates = COORDINATES * system.bodies.len();
            rest.extend((0..coordinates).map(|i| (self.y[i] - asked[i]) / MOVE));
        }
        rest
    }

    fn balance(&mut self) -> Result<(), EquilibriumError> {
        let none = vec![0.0; self.unknowns.len()];
        let mut rest = self.residual(&none, true).map_err(EquilibriumError::Evaluation)?;
        let mut slopes: Option<Svd<f64>> = None;
        for _ in 0..ITERATIONS {
            if largest(&rest).0 < EXACT {
                break;
            }
            // Differences are dear: they serve for as long as they bring each step near the balance.
            let fresh = slopes.is_none();
            let known = match slopes.take() {
                Some(known) => known,
                None => match self.jacobian(rest.len()).map_err(EquilibriumError::Evaluation)?.thin_svd() {
                    Ok(found) => found,
                    Err(_) => break,
                },
            };
            let before = largest(&rest).0;
            if let Some(change) = self.better(&shortest_solution(&known, &rest), &rest) {
                rest = self.residual(&change, true).map_err(EquilibriumError::Evaluation)?;
            }
            let after = largest(&rest).0;
            if fresh && !(after < 0.5 * before) && (after < BALANCED || after == before) {
                break;
            }
            slopes = (after < 0.1 * before).then_some(known);
        }
        if largest(&rest).0 < BALANCED { Ok(()) } else { Err(self.unsupported(&rest)) }
    }

    /// The step, shortened until it makes the sum of squares smaller.
    fn better(&mut self, step: &[f64], rest: &[f64]) -> Option<Vec<f64>> {
        // Along a step onto the constraints the moves are small of second order: only accelerations are compared.
        let count = COORDINATES * self.model.system.bodies.len();
        let sum = |rest: &[f64]| rest[..count].iter().map(|r| r * r).sum::<f64>();
        let parts = (0..HALVINGS).map(|halvings| 0.5f64.powi(halvings));
        let changes = parts.map(|part| step.iter().map(|step| part * step).collect::<Vec<f64>>());
        changes.into_iter().find(|change| self.residual(change, false).is_ok_and(|found| sum(&found) < sum(rest)))
    }

    fn jacobian(&mut self, rows: usize) -> Result<Mat<f64>, EvaluationError> {
        let mut jacobian = Mat::zeros(rows, self.unknowns.len());
        for column in 0..self.unknowns.len() {
            let step = match self.unknowns[column] {
                Unknown::State { step, .. } => step,
                Unknown::Slowing => 1e-3,
            };
            let mut change = vec![0.0; self.unknowns.len()];
            change[column] = step;
            let ahead = self.residual(&change, false)?;
            change[column] = -step;
            let behind = self.residual(&change, false)?;
            for row in 0..rows {
                jacobian[(row, column)] = (ahead[row] - behind[row]) / (2.0 * step);
            }
        }
        Ok(jacobian)
    }

    /// Why there is no balance: the body that nothing holds, or the one that is off it most.
    fn unsupported(&mut self, rest: &[f64]) -> EquilibriumError {
        const MOTIONS: [&str; COORDINATES] =
            ["along x", "along y", "along z", "about z (yaw)", "about x (roll)", "about y (pitch, of a wheelset its spin)"];
        let slopes = self.jacobian(rest.len()).ok().and_then(|jacobian| jacobian.thin_svd().ok());
        let name = |body: usize| self.model.system.bodies[body].name.clone();
        let coordinates = COORDINATES * self.model.system.bodies.len();
        // How far each unknown takes part in motions that nothing resists, times how far its body is off balance there.
        let mut moved = vec![0.0; coordinates];
        if let Some(svd) = slopes {
            for (column, unknown) in self.unknowns.iter().enumerate() {
                let Unknown::State { at, .. } = unknown else { continue };
                let loose = (0..svd.V().ncols()).filter(|k| svd.S().column_vector()[*k] < LOOSE);
                let part: f64 = loose.map(|k| svd.V()[(column, k)].powi(2)).sum();
                let place = at % coordinates;
                moved[place] = part * rest[place].abs();
            }
        }
        let (most, place) = largest(&moved);
        if most > BALANCED {
            return EquilibriumError::Unsupported { body: name(place / COORDINATES), motion: MOTIONS[place % COORDINATES] };
        }
        let (worst, row) = largest(&rest[..coordinates]);
        EquilibriumError::Unbalanced { body: name(row / COORDINATES), acceleration: worst * UNIT }
    }

    /// The state, with all speeds scaled.
    fn found(mut self, scale: f64) -> SteadyState {
        let loads = (0..self.model.wheelsets.len()).map(|wheelset| {
            let mut force = 0.0;
            for side in Side::BOTH {
                let contact = contact_index(wheelset, side);
                let others = self.model.points - 1;
                let further = &self.workspace.further_contacts[contact * others..(contact + 1) * others];
                force += std::iter::once(&self.workspace.contacts[contact]).chain(further).map(|report| report.force.z).sum::<f64>();
            }
            0.5 * force
        });
        let wheel_loads = loads.collect();
        let coordinates = COORDINATES * self.model.system.bodies.len();
        if scale != 1.0 {
            self.y[coordinates..2 * coordinates].iter_mut().for_each(|velocity| *velocity *= scale);
        }
        self.y.truncate(self.model.system.dimension());
        SteadyState { y: self.y, wheel_loads }
    }
}

/// The largest absolute value and its place; what is not a number is larger than all.
fn largest(values: &[f64]) -> (f64, usize) {
    let pick = |found: (f64, usize), (place, value): (usize, &f64)| {
        if value.abs() > found.0 || value.is_nan() { (if value.is_nan() { f64::INFINITY } else { value.abs() }, place) } else { found }
    };
    values.iter().enumerate().fold((0.0, 0), pick)
}

/// The shortest x that makes `|J x + rest|` least.
fn shortest_solution(jacobian: &Svd<f64>, rest: &[f64]) -> Vec<f64> {
    let (left, values, right) = (jacobian.U(), jacobian.S().column_vector(), jacobian.V());
    let mut solution = vec![0.0; right.nrows()];
    for k in (0..right.ncols()).take_while(|k| values[*k] > NOISE * values[0]) {
        let part: f64 = rest.iter().enumerate().map(|(row, rest)| left[(row, k)] * rest).sum::<f64>() / values[k];
        for (row, x) in solution.iter_mut().enumerate() {
            *x -= part * right[(row, k)];
        }
    }
    solution
}
