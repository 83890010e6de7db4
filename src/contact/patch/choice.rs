//! What a wheel's patch is in the equations of motion: `contact.patch`.

use crate::settings::{Entry, Section, SettingsError, choose};

/// A law of the patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatchLaw {
    /// An ellipse at each least distance of the undeformed surfaces.
    #[default]
    Ellipse,
    /// Strips along the track over all that overlaps ([`crate::contact::strips`]).
    Strips,
}

/// Every patch that a scene can name.
pub static REGISTRY: &[Entry<PatchLaw>] = &[
    Entry {
        name: "ellipse",
        summary: "an ellipse at each least distance of the undeformed surfaces (default)",
        reference: "Hertz 1881; paper, Eq. 28",
        parse: PatchLaw::Ellipse,
    },
    Entry {
        name: "strips",
        summary: "half-space contact of the real profiles by strips: any shape, patches join and part, forces at the load's centre",
        reference: "least potential of semi-elliptic strips, own derivation; 1 % of N against half-space contact on a grid",
        parse: PatchLaw::Strips,
    },
];

/// Reads `contact.patch`; returns its name and the law.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<(&'static str, PatchLaw), SettingsError> {
    if !section.has("patch") {
        return Ok((REGISTRY[0].name, PatchLaw::default()));
    }
    let entry = choose(REGISTRY, section, "patch")?;
    Ok((entry.name, entry.parse))
}
