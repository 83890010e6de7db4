//! How far models are apart: no numerical error of either.

use super::errors::{Errors, Quantity};
use super::study::{Apart, ModelDifference, StudiedModel, Study};

/// Every other model against the first elastic one, or against the first of all.
pub(super) fn differences(models: &[StudiedModel]) -> Vec<ModelDifference> {
    let known = |model: &StudiedModel| model.reference.as_ref().ok().map(|reference| reference.observation.clone());
    let first = models.iter().position(|model| !model.rigid && model.reference.is_ok());
    let Some(base) = first.or_else(|| models.iter().position(|model| model.reference.is_ok())) else { return Vec::new() };
    let Some(standard) = known(&models[base]) else { return Vec::new() };
    let others = models.iter().enumerate().filter(|(index, _)| *index != base);
    others
        .filter_map(|(index, model)| {
            Some(ModelDifference { first: index, second: base, errors: Errors::between(&known(model)?, &standard) })
        })
        .collect()
}

impl Study {
    /// What can be said of the distance of two models; `None` where the quantity does not occur.
    pub fn apart(&self, difference: &ModelDifference, quantity: Quantity) -> Option<Apart> {
        let apart = difference.errors.of(quantity)?;
        let uncertain = |model: usize| {
            let reference = self.models[model].reference.as_ref().ok();
            reference.and_then(|reference| reference.uncertainty.of(quantity)).unwrap_or(f64::INFINITY)
        };
        let least = uncertain(difference.first) + uncertain(difference.second);
        Some(if apart < least { Apart::Untold } else { Apart::Told(apart) })
    }
}
