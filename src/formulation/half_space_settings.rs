//! What `contact.patch = "exact"` takes from the scene's creep law ([`super::elastic::half_spaces`] has the patches).

use crate::contact::Material;
use crate::contact::creep::{CreepLaw, exact, simplified_theory};
use crate::contact::patch::Settings;

/// How patches are solved, from the scene's creep law, and the law that takes its place in slopes; `None` where that law is of ellipses alone.
pub(super) fn settings(law: &dyn CreepLaw, material: Material) -> Option<(Settings, Box<dyn CreepLaw>)> {
    let exact::Settings { grid, extrapolate, tolerance } = law.on_any_patch()?;
    let cells = grid.unwrap_or(Settings::default().columns);
    Some((Settings { columns: cells, rows: cells, extrapolate, tolerance }, simplified_theory(material)))
}
