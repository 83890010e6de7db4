//! Floor 4: how contact enters the equations of motion.
//!
//! A [`Model`] is constant while time runs. A formulation evaluates the derivative of the state from the model, the
//! inputs and the state; everything that moves lives in the [`Workspace`] (scratch) or in the state's memory (warm
//! starts of the contact search).

mod ecf_a;

use crate::contact::Patch;
use crate::contact::creep::CreepLaw;
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage};
use crate::contact::normal::{ConformalContact, NormalLaw};
use crate::contact::search::algebraic::SurfaceParameters;
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::Track;
use crate::mbs::system::{System, SystemWorkspace};
use crate::settings::{Entry, Section, SettingsError, choose};
use nalgebra::Vector3;

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
    /// C of Eq. 28, N s/m2.
    pub damping: f64,
    /// mu, -.
    pub friction: f64,
}

/// Everything that stays constant during a simulation.
#[derive(Debug)]
pub struct Model {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
    pub formulation: &'static dyn Formulation,
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
}

/// Scratch of an evaluation; holds its findings until the next one.
#[derive(Clone, Debug)]
pub struct Workspace {
    pub system: SystemWorkspace,
    /// Contacts in the order wheelset 1 left, right, wheelset 2 left, ...
    pub contacts: Vec<ContactReport>,
    /// Newton iterations of contact searches; counted up by each evaluation.
    pub search_iterations: u64,
}

impl Model {
    pub fn workspace(&self) -> Workspace {
        Workspace {
            system: self.system.workspace(&[]),
            contacts: vec![ContactReport::default(); 2 * self.wheelsets.len()],
            search_iterations: 0,
        }
    }

    /// Values of all inputs that leave the model alone.
    pub fn neutral_inputs(&self) -> Vec<f64> {
        NEUTRAL_INPUTS.iter().copied().cycle().take(WHEELSET_INPUTS * self.wheelsets.len()).collect()
    }

    /// Derivative `dy` of the state `y` at time `t` under `inputs`; leaves motions, wrenches and contacts in the workspace.
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found or lies outside what the laws cover.
    #[inline]
    pub fn derivative(
        &self,
        workspace: &mut Workspace,
        t: f64,
        inputs: &[f64],
        y: &[f64],
        memory: &mut [f64],
        dy: &mut [f64],
    ) -> Result<(), EvaluationError> {
        self.formulation.derivative(self, workspace, t, inputs, y, memory, dy)
    }
}

/// How the contact problem is solved.
pub trait Formulation: Send + Sync + std::fmt::Debug {
    /// Numbers per contact that the formulation keeps in the state's memory.
    fn memory_per_contact(&self) -> usize;

    /// How far ahead of its wheelset's centre a contact lies [m], from that contact's memory.
    fn lead(&self, memory: &[f64]) -> f64;

    /// See [`Model::derivative`].
    #[allow(clippy::too_many_arguments)]
    fn derivative(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        t: f64,
        inputs: &[f64],
        y: &[f64],
        memory: &mut [f64],
        dy: &mut [f64],
    ) -> Result<(), EvaluationError>;
}

type Parse = fn(&Section) -> Result<&'static dyn Formulation, SettingsError>;

/// Every formulation that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[ecf_a::ENTRY];

/// Reads `contact.formulation`; returns its name and the formulation.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<(&'static str, &'static dyn Formulation), SettingsError> {
    let entry = choose(REGISTRY, section, "formulation")?;
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
    #[error("{0}")]
    Conformal(#[from] ConformalContact),
    #[error(
        "penetration of {penetration:.4} m is beyond elastic contact (wheelset at z = {z:.4} m): an initial position that is too low, or an impact"
    )]
    TooDeep { penetration: f64, z: f64 },
}
