//! Cross-sections of wheels and rails as smooth functions of one coordinate.
//!
//! A wheel profile is the radius R(u) [m], u [m] measured along the axle from the tread circle, outward
//! positive (flange at negative u). A rail profile is the height f(eta) [m] over the section's base line, eta
//! [m] outward positive. Both are the paper's g and f (Eqs. 6 and 8).

mod apta;
mod arc;
mod cleaning;
mod cone;
mod doubts;
mod drawing;
mod flangeless;
mod groove;
mod measured;
mod miniprof;
mod orientation;
mod outline;
mod piecewise;
mod points;
mod rail_head;
mod s1002;
mod simpack;
mod swinging;
mod table;
#[cfg(test)]
pub(crate) mod test_profiles;
#[cfg(test)]
mod tests;

use super::file::SceneFile;
use crate::settings::{Entry, Section, SettingsError, choose};
pub use arc::Arch;
pub use cone::Cone;
pub use flangeless::Flangeless;
pub use piecewise::{Along, Piecewise};
use std::sync::Arc;

/// Value and first three derivatives of a profile at one coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProfilePoint {
    /// Radius or height, m.
    pub value: f64,
    /// First derivative, -.
    pub d1: f64,
    /// Second derivative, 1/m.
    pub d2: f64,
    /// Third derivative, 1/m2.
    pub d3: f64,
}

/// A place where the curvature of a profile jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Coordinate, m.
    pub at: f64,
    /// Radius or height there, m.
    pub value: f64,
    /// Slope there, -.
    pub slope: f64,
}

/// A smooth profile.
pub trait Profile: Send + Sync + std::fmt::Debug {
    /// Value and derivatives at `x` [m]. Defined and finite for every finite `x`; outside [`Profile::range`] it
    /// is a continuation that only serves iterations on their way.
    fn at(&self, x: f64) -> ProfilePoint;

    /// Value and slope, where nothing else is needed: those of [`Profile::at`] to within 1e-13 m and 1e-10.
    #[inline]
    fn value_and_slope(&self, x: f64) -> (f64, f64) {
        let p = self.at(x);
        (p.value, p.d1)
    }

    /// The profile as the kind that is read at many places of one contact without a dynamic call for each.
    fn piecewise(&self) -> Option<&Piecewise> {
        None
    }

    /// Coordinates [m] between which the profile describes a real surface.
    fn range(&self) -> (f64, f64);

    /// One line for `wheelrail plan`.
    fn describe(&self) -> String;

    /// Coordinates [m], increasing, at which the second derivative jumps: what depends on curvature steps there.
    fn joints(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Those of them, increasing, at which it jumps by so much that readings on both sides must not be joined by one smooth curve.
    fn bends(&self) -> &[Bend] {
        &[]
    }

    /// Of a wheel whose flange is left out: the whole profile, and the coordinate [m] where its flange begins.
    fn left_out(&self) -> Option<(&Arc<dyn Profile>, f64)> {
        None
    }

    /// Coordinates [m], increasing, at which the slope jumps. No profile of this program has any: angles of
    /// drawings are rounded when they are read.
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// Wheel or rail: the two readings of a profile file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Wheel,
    Rail,
}

/// A profile as a scene names it, with the files that it was read from.
#[derive(Clone, Debug)]
pub struct ProfileChoice {
    pub profile: Arc<dyn Profile>,
    /// File and its content, which an FMU must carry with it.
    pub file: Option<SceneFile>,
    /// What the user should know about how the profile was read: assumed datums, points left out.
    pub notes: Vec<String>,
    /// Where its curvature is more than doubtful, and what may be done about it.
    pub doubt: Option<String>,
}

impl ProfileChoice {
    /// A profile that needs no file.
    fn own(profile: Arc<dyn Profile>) -> Self {
        ProfileChoice { profile, file: None, notes: Vec::new(), doubt: None }
    }
}

/// Folder of an FMU's resources in which profile files lie.
const FOLDER: &str = "profiles";

type Parse = fn(&Section, Part) -> Result<ProfileChoice, SettingsError>;

/// Every profile format that a scene can name with `kind`.
pub static REGISTRY: &[Entry<Parse>] = &[
    cone::ENTRY,
    s1002::ENTRY,
    apta::ENTRY,
    arc::ENTRY,
    rail_head::E1,
    rail_head::E2,
    rail_head::UIC60,
    points::ENTRY,
    miniprof::ENTRY,
    simpack::ENTRY,
];

/// Reads a profile table `{ kind = "...", ... }`.
///
/// # Errors
/// [`SettingsError`] with file and line, of the scene or of the profile file.
pub fn parse(section: Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    let choice = (choose(REGISTRY, &section, "kind")?.parse)(&section, part)?;
    section.finish()?;
    Ok(choice)
}
