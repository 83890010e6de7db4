//! What is changed in the scene apart from its integrator: formulation, creep law, node spacing, smoothing of profiles.

use crate::scene::load::{self, SceneError};
use crate::scene::spec::Scene;
use crate::study::digits::rounded;
use serde::Serialize;

/// One way to describe the scene's contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Variant {
    pub formulation: &'static str,
    /// `None`: the scene's.
    pub creep_law: Option<&'static str>,
    /// m.
    pub node_spacing: Option<f64>,
    /// Of the profiles that are made from points, m.
    pub smoothing: Option<f64>,
}

/// Where a profile's smoothing may stand.
const SMOOTHED: [&str; 3] = ["track.rail.smoothing", "vehicle.wheelset.profile.smoothing", "vehicle.wheel_profile.smoothing"];

/// The formulation that looks for contacts among nodes.
const NODAL: &str = "ECF-N";

/// All combinations; an empty list stands for what the scene says. Only ECF-N has nodes.
pub(super) fn variants(formulations: &[&'static str], laws: &[&'static str], spacings: &[f64], smoothings: &[f64]) -> Vec<Variant> {
    fn some<T: Copy>(values: &[T]) -> Vec<Option<T>> {
        if values.is_empty() { vec![None] } else { values.iter().copied().map(Some).collect() }
    }
    let mut all = Vec::new();
    for formulation in formulations {
        for creep_law in some(laws) {
            for node_spacing in some(if *formulation == NODAL { spacings } else { &[] }) {
                for smoothing in some(smoothings) {
                    all.push(Variant { formulation, creep_law, node_spacing, smoothing });
                }
            }
        }
    }
    all
}

impl Variant {
    /// The scene with this change.
    pub(super) fn open(&self, name: &str, overrides: &[String]) -> Result<Scene, SceneError> {
        let mut all = overrides.to_vec();
        all.push(format!("contact.formulation=\"{}\"", self.formulation));
        if let Some(law) = self.creep_law {
            all.push(format!("contact.creep={{law=\"{law}\"}}"));
        }
        if let Some(spacing) = self.node_spacing {
            all.push(format!("contact.node_spacing={spacing:?}"));
        }
        let Some(smoothing) = self.smoothing else { return load::open(name, &all) };
        let mut opened = None;
        let mut refused = None;
        for key in SMOOTHED {
            let with: Vec<String> = all.iter().cloned().chain([format!("{key}={smoothing:?}")]).collect();
            match load::open(name, &with) {
                Ok(scene) => (all, opened) = (with, Some(scene)),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        match (opened, refused) {
            (Some(scene), _) => Ok(scene),
            (None, Some(error)) => Err(error),
            (None, None) => load::open(name, &all),
        }
    }

    /// What is changed beside the formulation: "creep law polach, nodes every 0.2 mm"; empty when nothing is.
    pub fn changes(&self) -> String {
        let law = self.creep_law.map(|law| format!("creep law {law}"));
        let spacing = self.node_spacing.map(|spacing| format!("nodes every {} mm", rounded(1e3 * spacing)));
        let smoothing = self.smoothing.map(|smoothing| format!("smoothing {} mm", rounded(1e3 * smoothing)));
        [law, spacing, smoothing].into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// "ECF-N, nodes every 0.2 mm".
    pub fn label(&self) -> String {
        self.with(self.formulation)
    }

    /// The model that it belongs to: two variants of one model have the same exact solution.
    pub(super) fn model(&self, rigid: bool) -> String {
        self.with(if rigid { "rigid" } else { self.formulation })
    }

    fn with(&self, name: &str) -> String {
        let changes = self.changes();
        if changes.is_empty() { name.into() } else { format!("{name}, {changes}") }
    }
}
