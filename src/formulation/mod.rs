//! Floor 4: how contact enters the equations of motion.
//!
//! A [`Model`] is constant while time runs. A formulation evaluates the derivative of the state from the model, the
//! inputs and the state; everything that moves lives in the [`Workspace`] (scratch) or in the state's memory (warm
//! starts of the contact search, contact modes).
//!
//! The state vector holds the bodies' coordinates and velocities (see `mbs::system`), then each contact's own states, wheel by
//! wheel: none in ECF-A and ECCF, the surface parameters and their rates in ACCF, the arc length in ECF-N.

mod accf;
mod eccf;
mod ecf_a;
mod ecf_n;
pub mod events;
mod lift;
mod loading;
mod rigid;
pub mod work;

use crate::contact::Patch;
use crate::contact::creep::CreepLaw;
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage};
use crate::contact::normal::damping::DampingLaw;
use crate::contact::normal::{ConformalContact, NormalLaw};
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::nodes::NodeError;
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::Track;
use crate::mbs::system::{System, SystemWorkspace};
use crate::settings::{Entry, Section, SettingsError, choose};
use events::ContactEvent;
use lift::OnLift;
use nalgebra::Vector3;
use rigid::RigidScratch;
use std::sync::Arc;
use work::Work;

/// Inputs of one wheelset, in the order in which they stand in the input vector.
pub const WHEELSET_INPUTS: usize = 5;
pub const DRIVE_TORQUE: usize = 0;
pub const LATERAL_FORCE: usize = 1;
pub const VERTICAL_FORCE: usize = 2;
pub const LEFT_FRICTION: usize = 3;
pub const RIGHT_FRICTION: usize = 4;
/// Values of a wheelset's inputs that leave it alone.
pub const NEUTRAL_INPUTS: [f64; WHEELSET_INPUTS] = [0.0, 0.0, 0.0, 1.0, 1.0];

/// A body with two wheels on the track.
#[derive(Debug)]
pub struct Wheelset {
    pub name: String,
    pub body: usize,
    pub left: Wheel,
    pub right: Wheel,
    /// Imposed travelling speed [m/s], `None` when the wheelset is free along the track.
    pub imposed_speed: Option<f64>,
    /// Vertical force of each wheel on level track at rest, N.
    pub static_wheel_load: f64,
}

impl Wheelset {
    pub fn wheel(&self, side: Side) -> &Wheel {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }
}

/// Place of a wheel's contact in [`Workspace::contacts`] and, times the memory per contact, in the state's memory.
pub fn contact_index(wheelset: usize, side: Side) -> usize {
    2 * wheelset + usize::from(side == Side::Right)
}

/// Laws and constants of contact.
#[derive(Debug)]
pub struct ContactLaws {
    pub normal: Box<dyn NormalLaw>,
    pub creep: Box<dyn CreepLaw>,
    pub damping: Box<dyn DampingLaw>,
    /// mu, -.
    pub friction: f64,
}

/// Everything that stays constant during a simulation, before a formulation is chosen.
#[derive(Debug)]
pub struct Parts {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
}

/// Everything that stays constant during a simulation.
#[derive(Debug)]
pub struct Model {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
    pub formulation: Box<dyn Formulation>,
}

/// One contact as it was found and loaded at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactReport {
    pub parameters: SurfaceParameters,
    /// delta, m, negative when the surfaces are apart; its rate, m/s.
    pub penetration: f64,
    pub penetration_rate: f64,
    /// K_h, N/m^1.5; zero without contact.
    pub stiffness: f64,
    /// N, N.
    pub normal_force: f64,
    pub patch: Patch,
    pub axes: ContactAxes,
    pub creepage: Creepage,
    pub creep_force: CreepForce,
    /// Force on the wheelset in the track frame, N.
    pub force: Vector3<f64>,
    pub iterations: usize,
    /// Is the contact a constraint (its normal force a multiplier), not elastic?
    pub constrained: bool,
}

/// Scratch of an evaluation; holds its findings until the next one.
#[derive(Clone, Debug)]
pub struct Workspace {
    pub system: SystemWorkspace,
    /// First contacts of all wheels in the order wheelset 1 left, right, wheelset 2 left, ...
    pub contacts: Vec<ContactReport>,
    /// Second contacts in the same order; empty where the formulation finds only one.
    pub second_contacts: Vec<ContactReport>,
    /// What constraint formulations work in.
    pub(crate) rigid: RigidScratch,
    /// Counted up by each evaluation.
    pub work: Work,
    /// Lift-offs and landings since they were last taken away.
    pub events: Vec<ContactEvent>,
}

/// Time, inputs and state of an evaluation; the memory is both read and written.
#[derive(Debug)]
pub struct Evaluation<'a> {
    pub t: f64,
    pub inputs: &'a [f64],
    pub y: &'a [f64],
    pub memory: &'a mut [f64],
}

impl Model {
    /// Completes the parts with a formulation.
    ///
    /// # Errors
    /// [`AssemblyError`] when the formulation can't treat the parts.
    pub fn new(parts: Parts, build: &Build) -> Result<Model, AssemblyError> {
        let formulation = build(&parts)?;
        let Parts { system, track, wheelsets, laws } = parts;
        Ok(Model { system, track, wheelsets, laws, formulation })
    }

    pub fn contacts(&self) -> usize {
        2 * self.wheelsets.len()
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        self.system.dimension() + self.contacts() * self.formulation.states_per_contact()
    }

    /// Length of the state's memory.
    pub fn memory(&self) -> usize {
        self.contacts() * self.formulation.memory_per_contact()
    }

    /// A contact's own states in the state vector.
    pub fn contact_states(&self, contact: usize) -> std::ops::Range<usize> {
        let count = self.formulation.states_per_contact();
        let start = self.system.dimension() + contact * count;
        start..start + count
    }

    /// A contact's part of the state's memory.
    pub fn contact_memory(&self, contact: usize) -> std::ops::Range<usize> {
        let count = self.formulation.memory_per_contact();
        contact * count..(contact + 1) * count
    }

    pub fn workspace(&self) -> Workspace {
        let both = |wheelset: &Wheelset| [wheelset.body; 2];
        let constrained: Vec<usize> =
            if self.formulation.constrains() { self.wheelsets.iter().flat_map(both).collect() } else { Vec::new() };
        let second = if self.formulation.points_per_wheel() > 1 { self.contacts() } else { 0 };
        Workspace {
            system: self.system.workspace(&constrained),
            contacts: vec![ContactReport::default(); self.contacts()],
            second_contacts: vec![ContactReport::default(); second],
            rigid: if self.formulation.constrains() { RigidScratch::new(self) } else { RigidScratch::default() },
            work: Work::default(),
            events: Vec::new(),
        }
    }

    /// Values of all inputs that leave the model alone.
    pub fn neutral_inputs(&self) -> Vec<f64> {
        NEUTRAL_INPUTS.iter().copied().cycle().take(WHEELSET_INPUTS * self.wheelsets.len()).collect()
    }

    /// Derivative `dy` of the state `at.y` at time `at.t`; leaves motions, wrenches and contacts in the workspace.
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found or lies outside what the laws cover.
    #[inline]
    pub fn derivative(&self, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        self.formulation.derivative(self, workspace, at, dy)
    }

    /// The smallest normal force [N] of a constrained contact as it was found last; `None` when there is no constraint that could
    /// pull.
    pub fn margin(&self, memory: &[f64]) -> Option<f64> {
        self.formulation.on_lift().and_then(|_| rigid::least_pressed(self, memory)).map(|(_, force)| force)
    }

    /// When an elastic contact becomes a constraint again if nothing disturbs it, s; infinity for never.
    pub fn next_return(&self, memory: &[f64]) -> f64 {
        self.formulation.on_lift().map_or(f64::INFINITY, |_| lift::next_return(self, memory))
    }

    /// Changes the mode of the contacts that are to change it.
    ///
    /// # Errors
    /// [`EvaluationError`] when the formulation can't go on.
    pub fn switch(&self, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        self.formulation.on_lift().map_or(Ok(()), |on_lift| lift::switch(on_lift, self, workspace, t, y, memory))
    }
}

/// How the contact problem is solved.
///
/// `y` and `memory` are those of the whole model.
pub trait Formulation: Send + Sync + std::fmt::Debug {
    /// How it finds and treats contacts, for `wheelrail plan`.
    fn describe(&self) -> String;

    /// States that each contact adds to the state vector.
    fn states_per_contact(&self) -> usize {
        0
    }

    /// Numbers per contact that the formulation keeps in the state's memory; the first four are the surface parameters of the
    /// last evaluation (u, angle, lead, eta).
    fn memory_per_contact(&self) -> usize;

    /// Contacts per wheel that can be loaded at the same time.
    fn points_per_wheel(&self) -> usize {
        1
    }

    /// What it does where a constraint would begin to pull; `None`: contact is no constraint.
    fn on_lift(&self) -> Option<OnLift> {
        None
    }

    /// Is the contact a constraint, with the normal force as multiplier?
    fn constrains(&self) -> bool {
        self.on_lift().is_some()
    }

    /// Fills the contacts' states and memory for a start at `y`'s body coordinates and velocities.
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found.
    fn start(
        &self,
        _model: &Model,
        _workspace: &mut Workspace,
        _t: f64,
        _y: &mut [f64],
        _memory: &mut [f64],
    ) -> Result<(), EvaluationError> {
        Ok(())
    }

    /// See [`Model::derivative`].
    ///
    /// # Errors
    /// [`EvaluationError`].
    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError>;

    /// Moves positions and velocities onto the constraints; returns whether `y` was changed.
    ///
    /// # Errors
    /// [`EvaluationError`] when there is no such state near `y`.
    fn project(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        t: f64,
        y: &mut [f64],
        _memory: &mut [f64],
    ) -> Result<bool, EvaluationError> {
        if model.system.joints.is_empty() {
            return Ok(false);
        }
        rigid::project(model, workspace, t, y, |_| Ok(()))
    }

    /// Weight of state `i`'s local error, given that of a plain position in metres or radians.
    fn error_weight(&self, _model: &Model, _workspace: &Workspace, _i: usize, plain: f64) -> f64 {
        plain
    }

    /// A further time at which a step must end, s; infinity for never.
    fn next_break(&self, _model: &Model, _t: f64, _y: &[f64]) -> f64 {
        f64::INFINITY
    }

    /// Moves the state onto the constraints after contacts have changed their mode.
    ///
    /// # Errors
    /// [`EvaluationError`] when there is no such state near `y`.
    fn resettle(&self, model: &Model, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        eccf::project(model, workspace, t, y, memory).map(|_| ())
    }
}

/// Builds a formulation for the parts of a model.
pub type Build = Arc<dyn Fn(&Parts) -> Result<Box<dyn Formulation>, AssemblyError> + Send + Sync>;

/// A formulation can't treat a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    #[error("contact.node_spacing: {0}")]
    Nodes(NodeError),
}

type Parse = fn(&Section) -> Result<Build, SettingsError>;

/// Every formulation that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[accf::ENTRY, eccf::ENTRY, ecf_a::ENTRY, ecf_n::ENTRY];

/// Reads `contact.formulation`; returns its name and the formulation.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<(&'static str, Build), SettingsError> {
    let entry = choose(REGISTRY, section, "formulation")?;
    // Each formulation takes what it needs; the rest may stay for the next choice.
    lift::parse(section)?;
    ecf_n::parse_spacing(section)?;
    Ok((entry.name, (entry.parse)(section)?))
}

/// Why the equations could not be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("t = {time:.9} s, {wheelset}, {} wheel: {cause}", side.name())]
pub struct EvaluationError {
    /// s.
    pub time: f64,
    pub wheelset: String,
    pub side: Side,
    pub cause: ContactFailure,
}

impl EvaluationError {
    fn new(time: f64, wheelset: &Wheelset, side: Side, cause: ContactFailure) -> Self {
        EvaluationError { time, wheelset: wheelset.name.clone(), side, cause }
    }
}

/// What went wrong at one contact.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ContactFailure {
    #[error(
        "the contact search found no solution ({iterations} iterations, residual {residual:.1e}, wheelset at y = {y:.4} m); \
         the wheelset may have left the rails, or the profile is not smooth enough for ECF-A"
    )]
    NotFound { iterations: usize, residual: f64, y: f64 },
    #[error(
        "contact at the {part} coordinate {found:.4} m, but its profile reaches only from {first:.4} m to {last:.4} m (wheelset at y = {y:.4} m)"
    )]
    OffProfile { part: &'static str, found: f64, first: f64, last: f64, y: f64 },
    #[error("no node of the wheel stands over a node of the rail (wheelset at y = {y:.4} m): the wheelset has left the rails")]
    OffRail { y: f64 },
    #[error("{0}")]
    Conformal(#[from] ConformalContact),
    #[error(
        "penetration of {penetration:.4} m is beyond elastic contact (wheelset at z = {z:.4} m): an initial position that is too low, or an impact"
    )]
    TooDeep { penetration: f64, z: f64 },
    #[error(
        "the normal force has come to {normal_force:.1e} N and the contact constraint would have to pull: the wheel lifts off; use an elastic \
         formulation (contact.formulation = \"ECF-A\") or contact.on_lift = \"elastic\""
    )]
    Tensile { normal_force: f64 },
    #[error(
        "normal force and creep forces do not settle ({iterations} iterations, rest {residual:.1e} N): friction too large for a rigid contact this steep"
    )]
    NotSettled { iterations: usize, residual: f64 },
    #[error("the constraints of the contact are not independent: the surfaces touch along a line or are conformal here")]
    Dependent,
    #[error("the constraints do not determine their forces (row {row}; wheelset at y = {y:.4} m)")]
    Singular { row: usize, y: f64 },
    #[error("no position near this one satisfies the constraints ({iterations} iterations, gap {gap:.1e} m, wheelset at y = {y:.4} m)")]
    NotClosed { iterations: usize, gap: f64, y: f64 },
}
