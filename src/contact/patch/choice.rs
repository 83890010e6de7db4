//! What a wheel's patch is in the equations of motion: `contact.patch`.

use crate::settings::{Entry, Section, SettingsError};

/// A law of the patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchLaw {
    /// An ellipse at each least distance of the undeformed surfaces.
    Ellipse,
    /// Strips along the track over all that overlaps ([`crate::contact::strips`]).
    Strips,
    /// The same, read from a table of the pair of profiles where that knows it.
    Table,
    /// The first order of the strips' patch about the middle of the track.
    Linear,
    /// Half-space contact on a grid, with Kalker's tangential problem on it ([`super`]).
    Exact,
}

impl PatchLaw {
    /// Is it the patch that really forms, or made of it?
    pub fn forms(self) -> bool {
        self != PatchLaw::Ellipse
    }

    /// Does it ask for a formulation that finds every place of a wheel by itself, without nodes?
    pub fn needs_all_places(self) -> bool {
        matches!(self, PatchLaw::Table | PatchLaw::Linear)
    }

    /// As scenes call it.
    pub fn name(self) -> &'static str {
        REGISTRY.iter().find(|entry| entry.parse == self).map_or(AUTO, |entry| entry.name)
    }
}

/// The word for: what fits the scene.
pub const AUTO: &str = "auto";

/// Every patch that a scene can name.
pub static REGISTRY: &[Entry<PatchLaw>] = &[
    Entry {
        name: "strips",
        summary: "half-space contact of the real profiles by strips: any shape, patches join and part, forces at the load's centre (default of ECF-A, ECF-N)",
        reference: "least potential of semi-elliptic strips, own derivation; N within 1 % of half-space contact on a grid on average, 3 % at worst",
        parse: PatchLaw::Strips,
    },
    Entry {
        name: "table",
        summary: "the same read from a table, made once for a pair of profiles: treads at the price of a formula; flanges and what else lies outside by strips (ECF-A)",
        reference: "cubic convolution (Keys 1981) of the strips' patches over place, lean and load",
        parse: PatchLaw::Table,
    },
    Entry {
        name: "exact",
        summary: "the reference: half-space contact of the real profiles and Kalker's tangential problem on a grid in each evaluation, slow (with creep.law = \"exact\")",
        reference: "Kalker 1990; Polonsky and Keer, Wear 231 (1999); 5e-4 of N on 32 x 32 cells",
        parse: PatchLaw::Exact,
    },
    Entry {
        name: "ellipse",
        summary: "an ellipse at each least distance of the undeformed surfaces (default of ECCF, ACCF, of low speed and where [contact.normal] is named)",
        reference: "Hertz 1881; paper, Eq. 28",
        parse: PatchLaw::Ellipse,
    },
    Entry {
        name: "linear",
        summary: "the strips' patch and creep force linear about the centred, loaded wheel: for eigenvalues and controls; the run says where it does not hold (ECF-A)",
        reference: "Klingel 1883; Wickens 2003, 2.4; Kalker's linear theory",
        parse: PatchLaw::Linear,
    },
];

/// Reads `contact.patch`; `None` where it is left to what fits the scene.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<Option<PatchLaw>, SettingsError> {
    let names: Vec<&'static str> = REGISTRY.iter().map(|entry| entry.name).chain([AUTO]).collect();
    let word = section.word_or("patch", &names, AUTO)?;
    Ok(REGISTRY.iter().find(|entry| entry.name == word).map(|entry| entry.parse))
}
