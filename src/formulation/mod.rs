//! Floor 4: how contact enters the equations of motion.
//!
//! A [`Model`] is constant while time runs. A formulation evaluates the derivative of the state from the model, the
//! inputs and the state; everything that moves lives in the [`Workspace`] (scratch) or in the state's memory (warm
//! starts of the contact search, contact modes).
//!
//! The state vector holds the bodies' coordinates and velocities (see `mbs::system`), then each contact's own states, wheel by
//! wheel: none in ECF-A and ECCF, the surface parameters and their rates in ACCF, the arc length in ECF-N.

mod accf;
mod balance;
pub mod carried;
mod eccf;
mod ecf_a;
mod ecf_n;
pub mod events;
mod failure;
pub mod flutter;
mod foresight;
mod handover;
mod lasting;
mod lift;
mod loading;
mod low_pass;
mod model;
pub mod points;
mod rail_motion;
mod rigid;
pub mod sliding_mean;
pub mod swing;
mod tangent;
mod travel;
pub mod wheel_loads;
pub mod work;

pub use failure::{ContactFailure, EvaluationError};
pub use model::{
    ContactLaws, ContactReport, DRIVE_TORQUE, Evaluation, LATERAL_FORCE, LEFT_FRICTION, LOAD_TOLERANCE, LONGITUDINAL_FORCE, Model,
    NEUTRAL_INPUTS, Parts, RIGHT_FRICTION, VERTICAL_FORCE, WHEELSET_INPUTS, Wheelset, Workspace, contact_index,
};
pub use rail_motion::{
    RAIL_INPUTS, RAIL_LATERAL, RAIL_LATERAL_SLOPE, RAIL_LATERAL_VELOCITY, RAIL_VERTICAL, RAIL_VERTICAL_SLOPE, RAIL_VERTICAL_VELOCITY,
    rail_input,
};

use crate::contact::search::nodes::NodeError;
use crate::settings::{Entry, Section, SettingsError, choose};
use lift::OnLift;
use std::sync::Arc;

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
    #[error("vehicle.joint: {0}")]
    Joints(crate::mbs::redundancy::AssemblyError),
    #[error(
        "interface.inputs: \"rail_motion\" needs elastic contact (contact.formulation = \"ECF-A\" or \"ECF-N\"): a constraint between wheel and rail would need the rail's acceleration, which is no input"
    )]
    RailMotion,
    #[error(
        "preload = \"static\": no preloads hold {body} {direction} in its drawn position ({rest:.3} {unit} are left): an element with preload = \"static\" and a stiffness that way, or a joint, must carry it, and its centre of mass must stand between them"
    )]
    StaticPreload { body: String, direction: &'static str, rest: f64, unit: &'static str },
}

/// ECF-A, whose forces are smooth: where the search for a balance with another formulation may begin.
pub fn algebraic() -> Build {
    ecf_a::build()
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
