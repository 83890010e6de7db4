//! What a study finds.

use super::communication::Coupled;
use super::errors::{Errors, Quantity};
use super::reference::{Reference, Standing};
use super::run::{Measured, Setting};
use super::variant::Variant;
use crate::scene::load::SceneError;
use serde::Serialize;

/// What became of a point.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant)] // some hundred points
pub enum Outcome {
    Done {
        measured: Measured,
        errors: Errors,
    },
    /// It was run, and this is why there is no result.
    Failed(String),
    /// It was not run, and this is why.
    Skipped(String),
}

/// One variant with one integrator at one setting.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Index in [`Study::variants`].
    pub variant: usize,
    pub setting: Setting,
    pub outcome: Outcome,
}

/// A description of contact that has one exact solution.
#[derive(Clone, Debug, Serialize)]
pub struct StudiedModel {
    pub name: String,
    pub rigid: bool,
    /// Indices in [`Study::variants`].
    pub variants: Vec<usize>,
    pub reference: Result<Reference, String>,
}

/// How far the references of two models are apart: no error of either.
#[derive(Clone, Debug, Serialize)]
pub struct ModelDifference {
    /// Indices in [`Study::models`].
    pub first: usize,
    pub second: usize,
    pub errors: Errors,
}

/// A distance of two models in the light of their references.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Apart {
    /// SI.
    Told(f64),
    /// Smaller than what both references together are uncertain by.
    Untold,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    pub scene: String,
    pub title: String,
    /// s.
    pub stop: f64,
    pub step: f64,
    pub wheelset: Option<String>,
    pub budget: f64,
    pub variants: Vec<Variant>,
    pub models: Vec<StudiedModel>,
    pub points: Vec<Point>,
    pub differences: Vec<ModelDifference>,
    pub coupled: Vec<Coupled>,
    /// What was shortened, left out or could not be started.
    pub notes: Vec<String>,
}

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error("{0}")]
    Scene(#[from] SceneError),
    #[error("{0}")]
    Setting(String),
    #[error("{0}")]
    Refused(String),
}

impl StudiedModel {
    /// "rigid" or "elastic".
    pub fn kind(&self) -> &'static str {
        if self.rigid { "rigid" } else { "elastic" }
    }
}

impl Study {
    /// Cost and errors of a point that was run to its end.
    pub fn done(point: &Point) -> Option<(&Measured, &Errors)> {
        if let Outcome::Done { measured, errors } = &point.outcome { Some((measured, errors)) } else { None }
    }

    /// Points of some standing.
    pub fn count(&self, quantity: Quantity, of: impl Fn(Standing) -> bool) -> usize {
        self.points.iter().filter(|point| of(self.standing(point, quantity))).count()
    }

    /// The model of a variant.
    pub fn model_of(&self, variant: usize) -> Option<&StudiedModel> {
        self.models.iter().find(|model| model.variants.contains(&variant))
    }

    /// What is known of a point's error.
    pub fn standing(&self, point: &Point, quantity: Quantity) -> Standing {
        let reference = self.model_of(point.variant).and_then(|model| model.reference.as_ref().ok());
        match (&point.outcome, reference) {
            (Outcome::Done { errors, .. }, Some(reference)) => reference.standing(errors, quantity),
            _ => Standing::Absent,
        }
    }

    /// Does the study have anything to show? References must agree 100 times better than the best point that is drawn.
    pub(super) fn refuse(&self) -> Result<(), StudyError> {
        if Quantity::ALL.iter().any(|quantity| self.count(*quantity, |standing| matches!(standing, Standing::Shown(_))) > 0) {
            return Ok(());
        }
        let reference = |model: &StudiedModel| match &model.reference {
            Ok(Reference { methods: [first, second], tolerance, uncertainty, .. }) => {
                let (y, load) = (uncertainty.y.largest, uncertainty.vertical.largest);
                format!("{}: {first} and {second} at tolerance {tolerance:.0e} agree to {y:.1e} m, {load:.1e} N", model.name)
            }
            Err(reason) => format!("{}: no reference: {reason}", model.name),
        };
        let failure = self.points.iter().find_map(|point| match &point.outcome {
            Outcome::Failed(reason) => Some(format!("{}, {}: {reason}", self.variants[point.variant].label(), point.setting.words())),
            _ => None,
        });
        let first = "refused: there is no point whose error is 100 times the uncertainty of its reference".to_string();
        let last = "A larger --budget gives tighter references, looser --tolerances and longer --steps larger errors.".to_string();
        let notes = self.notes.iter().map(|note| format!("note: {note}"));
        let lines = [first].into_iter().chain(self.models.iter().map(reference)).chain(failure).chain([last]).chain(notes);
        Err(StudyError::Refused(lines.collect::<Vec<_>>().join("\n  ")))
    }
}
