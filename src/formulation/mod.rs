//! Floor 4: how contact enters the equations of motion.
//!
//! A [`Model`] is constant while time runs. A formulation evaluates the derivative of the state from the model, the
//! inputs and the state; everything that moves lives in the [`Workspace`] (scratch) or in the state's [`memory`] (warm
//! starts of the contact search, contact modes).
//!
//! From below: model, workspace and memory; [`elastic`] (ECF-A, ECF-N); [`rigid`] (ECCF, ACCF), which hands contacts to elastic ones; what a run
//! asks of a model ([`transitions`], [`tangent`], [`foresight`] and others); the registry.
//!
//! The state vector holds the bodies' coordinates and velocities (see `mbs::system`), then each contact's own states, wheel by
//! wheel: none in ECF-A and ECCF, the surface parameters and their rates in ACCF, the arc length in ECF-N.

mod assembly;
mod beam_rails;
pub mod beat;
mod body_modes;
mod body_swings;
mod contact_report;
mod deflections;
mod derailment;
mod drift;
pub mod elastic;
pub mod energy;
pub mod energy_books;
mod envelope;
pub mod events;
mod failure;
mod flange;
mod flank;
pub mod flexibility;
pub mod flutter;
mod foresight;
pub mod frame_motion;
mod half;
mod half_space_settings;
mod half_swings;
mod hand_overs;
mod hunting;
pub mod inputs;
mod linear_contact;
mod linear_range;
mod loading;
mod low_pass;
mod means;
pub mod memory;
pub mod mode_swings;
mod model;
mod moving_frame;
pub mod one_wheel;
mod out_of_round;
pub mod partition;
mod patch_loads;
pub mod patch_tables;
mod prediction;
mod projection;
pub mod rail_beam;
mod rail_motion;
pub mod rail_scratch;
mod resting_rails;
mod rigid;
mod rigid_scratch;
pub mod sliding_mean;
pub mod step;
pub mod strikes;
pub mod swing;
mod tangent;
pub mod timers;
mod torsion;
pub mod transitions;
mod travel;
pub mod travelling_track;
pub mod vibration;
pub mod wheel_loads;
pub mod wheel_search;
pub mod wheelset;
pub mod work;
mod workspace;
mod yielding_rails;

pub use assembly::{AssemblyError, Build, Parts};
pub use contact_report::ContactReport;
pub use failure::{Asymmetry, ContactFailure, EvaluationError};
pub use inputs::{
    DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, LONGITUDINAL_FORCE, RAIL_INPUTS, RAIL_LATERAL, RAIL_LATERAL_SLOPE, RAIL_LATERAL_VELOCITY,
    RAIL_VERTICAL, RAIL_VERTICAL_SLOPE, RAIL_VERTICAL_VELOCITY, RIGHT_FRICTION, VERTICAL_FORCE, WHEELSET_INPUTS, input_index, rail_input,
};
pub use linear_contact::LinearContact;
pub use means::derailment_quotient;
pub use model::{ContactLaws, LOAD_TOLERANCE, Model, factor_at};
pub use wheelset::{Wheelset, contact_index};
pub use workspace::{Cached, Evaluation, Workspace};

use crate::settings::{Entry, Section, SettingsError, choose};
use step::Step;

/// How the contact problem is solved.
///
pub trait Formulation: Send + Sync + std::fmt::Debug {
    /// How it finds and treats contacts, for `wheelrail plan`.
    fn describe(&self) -> String;

    /// States that each contact adds to the state vector.
    fn states_per_contact(&self) -> usize {
        0
    }

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

    /// Fills the contacts' states and memory for a start at the bodies' coordinates and velocities.
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found.
    fn start(&self, _step: &mut Step) -> Result<(), EvaluationError> {
        Ok(())
    }

    /// See [`Model::derivative`].
    ///
    /// # Errors
    /// [`EvaluationError`].
    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError>;

    /// Moves positions and velocities onto the constraints; returns whether the state was changed.
    ///
    /// # Errors
    /// [`EvaluationError`] when there is no such state nearby.
    fn project(&self, step: &mut Step) -> Result<bool, EvaluationError> {
        if step.model.system.joints.is_empty() {
            return Ok(false);
        }
        projection::project(step, |_, _| Ok(()))
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
    /// [`EvaluationError`] when there is no such state nearby.
    fn resettle(&self, step: &mut Step) -> Result<(), EvaluationError> {
        self.project(step).map(|_| ())
    }
}

/// What to do where the constraint would begin to pull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnLift {
    /// End the run with an error that says so.
    Stop,
    /// Hand the contact to elastic forces until it has settled again.
    Elastic,
}

impl OnLift {
    pub fn describe(self) -> &'static str {
        match self {
            OnLift::Stop => "a wheel that lifts ends the run",
            OnLift::Elastic => "a wheel that lifts is elastic until it has settled",
        }
    }
}

/// ECF-A, whose forces are smooth: where the search for a balance with another formulation may begin.
pub fn algebraic() -> Build {
    elastic::ecf_a::build()
}

type Parse = fn(&Section) -> Result<Build, SettingsError>;

/// Every formulation that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[rigid::accf::ENTRY, rigid::eccf::ENTRY, elastic::ecf_a::ENTRY, elastic::ecf_n::ENTRY];

/// Names of those whose contact is a constraint: [`Formulation::constrains`] before there is a model.
pub const CONSTRAINTS: [&str; 2] = [rigid::accf::ENTRY.name, rigid::eccf::ENTRY.name];

/// Reads `contact.formulation`; returns its name and the formulation.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<(&'static str, Build), SettingsError> {
    let entry = choose(REGISTRY, section, "formulation")?;
    // Each formulation takes what it needs; the rest may stay for the next choice.
    rigid::modes::parse(section)?;
    elastic::ecf_n::parse_spacing(section)?;
    Ok((entry.name, (entry.parse)(section)?))
}
