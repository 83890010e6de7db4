//! A model from its parts.

use super::Formulation;
use super::model::{ContactLaws, LOAD_TOLERANCE, Model, Wheelset};
use super::wheel_search::{self, PreparedSearches};
use crate::contact::search::nodes::NodeError;
use crate::geometry::track::Track;
use crate::mbs::system::System;
use std::sync::Arc;

/// Everything that stays constant during a simulation, before a formulation is chosen.
#[derive(Debug)]
pub struct Parts {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
    /// Contacts that each wheel may have at the same time, at least 1.
    pub points: usize,
    /// Searches for them that other models of the same scene have prepared.
    pub prepared: PreparedSearches,
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

impl Model {
    /// Completes the parts with a formulation.
    ///
    /// # Errors
    /// [`AssemblyError`] when the formulation can't treat the parts.
    pub fn new(parts: Parts, build: &Build) -> Result<Model, AssemblyError> {
        let formulation = build(&parts)?;
        let Parts { system, track, wheelsets, laws, points, prepared } = parts;
        let own = formulation.points_per_wheel();
        let searches = wheel_search::searches(&wheelsets, &track, own == 1, &prepared);
        let points = if searches.iter().any(Option::is_some) { points } else { own };
        let contact_states_begin = system.dimension();
        Ok(Model {
            system,
            track,
            wheelsets,
            laws,
            formulation,
            points,
            contact_states_begin,
            searches,
            load_tolerance: LOAD_TOLERANCE,
            means: None,
            rail_motion: false,
        })
    }
}
