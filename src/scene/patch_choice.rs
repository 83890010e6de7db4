//! What `contact.patch = "auto"` stands for.

use super::spec::{PatchSpec, Scene};
use crate::contact::patch::{AUTO, PatchLaw};
use crate::formulation::CONSTRAINTS;
use crate::settings::{Section, SettingsError};

/// What asks for an ellipse: a key of `[contact]`, and why.
const ELLIPSES_ALONE: [(&str, &str); 3] = [
    ("transient", "[contact.transient] keeps the tangential deflection of an ellipse"),
    ("normal", "[contact.normal] is the law of an ellipse"),
    ("points", "contact.points counts ellipses"),
];

const RIGID: &str = "constraints hold one place of each wheel";

/// The patch of a scene from what it names, `None` where that is left open, and from its formulation: does it constrain?
///
/// The patch that really forms wherever it can be had: against half-space contact the ellipse at the deepest place is off by up to
/// a third of mu N on profiles of railways (docs/real_profiles.md). A constraint holds one place of each wheel, which is the ellipse's.
///
/// # Errors
/// Where strips and a count of places are both asked for.
pub(super) fn choose(section: &Section, named: Option<PatchLaw>, constrains: bool) -> Result<PatchSpec, SettingsError> {
    let asked = ELLIPSES_ALONE.iter().find(|(key, _)| section.has(key)).map(|(_, why)| *why);
    match named {
        Some(law) if law.forms() && section.has("points") => {
            let problem = format!("stands beside contact.patch = \"{}\", which counts no places; expected one of them", law.name());
            Err(section.error("points", problem))
        }
        Some(law) => Ok(PatchSpec { law, why: None }),
        None if constrains && asked.is_none() => Ok(PatchSpec { law: PatchLaw::Ellipse, why: Some(RIGID) }),
        None => Ok(match asked {
            Some(why) => PatchSpec { law: PatchLaw::Ellipse, why: Some(why) },
            None => PatchSpec { law: PatchLaw::Strips, why: Some("the patch that really forms") },
        }),
    }
}

/// The change after which a scene has the same patch with all of these formulations; `None` where it has so already, or names its patch.
pub fn alike(scene: &Scene, formulations: &[&str]) -> Option<String> {
    let rigid = |name: &&str| CONSTRAINTS.contains(name);
    let mixed = formulations.iter().any(rigid) && !formulations.iter().all(rigid);
    let PatchSpec { law, why } = scene.contact.patch;
    let open = law == PatchLaw::Strips && why.is_some() || why == Some(RIGID);
    (mixed && open).then(|| format!("contact.patch=\"{}\"", PatchLaw::Ellipse.name()))
}

/// `contact.patch = "strips"`, and where the choice is the program's, why.
pub fn describe(patch: &PatchSpec) -> String {
    match patch.why {
        Some(why) => format!("contact.patch = \"{AUTO}\" is {}: {why}", patch.law.name()),
        None => format!("contact.patch = \"{}\"", patch.law.name()),
    }
}
