//! Damping laws: what the normal force is more or less than the elastic force while the penetration changes.
//!
//! `N = max(0, N_elastic + D(N_elastic, delta, delta'))`: never tensile, and each D is zero at zero penetration, so a contact
//! begins and ends without a jump.

mod hunt_crossley;
mod lankarani_nikravesh;
mod linear;
mod none;
mod proportional;

pub use proportional::Proportional;

use crate::settings::{Entry, Section, SettingsError, choose};
use std::sync::Arc;

/// A contact on its way in or out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Elastic force, N.
    pub elastic: f64,
    /// delta, m.
    pub penetration: f64,
    /// delta', m/s.
    pub rate: f64,
}

/// Derivatives of D.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DampingSlopes {
    /// dD/dN_elastic, -.
    pub by_elastic: f64,
    /// dD/ddelta at constant elastic force, N/m.
    pub by_penetration: f64,
    /// dD/ddelta', N s/m.
    pub by_rate: f64,
}

/// A law of contact damping.
pub trait DampingLaw: Send + Sync + std::fmt::Debug {
    /// D [N], positive on the way in; zero at zero penetration.
    fn force(&self, approach: &Approach) -> f64;

    /// Derivatives of D.
    fn slopes(&self, approach: &Approach) -> DampingSlopes;

    /// For `wheelrail plan`, read behind `contact.damping`.
    fn describe(&self) -> String;
}

/// Normal force [N] from elastic force [N], penetration > 0 [m] and its rate [m/s].
#[inline]
pub fn damped_force(law: &dyn DampingLaw, elastic: f64, penetration: f64, rate: f64) -> f64 {
    (elastic + law.force(&Approach { elastic, penetration, rate })).max(0.0)
}

/// Builds a law; the number is C of Eq. 28 for the law that has it, which an FMU can set.
pub type Build = Arc<dyn Fn(f64) -> Box<dyn DampingLaw> + Send + Sync>;
type Parse = fn(&Section) -> Result<(f64, Build), SettingsError>;

/// The law that a scene names.
#[derive(Clone)]
pub struct Choice {
    pub name: &'static str,
    pub build: Build,
}

impl Choice {
    /// Does it take anything, with that C [N s/m2]?
    pub fn damps(&self, coefficient: f64) -> bool {
        self.name != none::ENTRY.name && (self.name != proportional::ENTRY.name || coefficient > 0.0)
    }
}

/// Every damping law that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[proportional::ENTRY, hunt_crossley::ENTRY, lankarani_nikravesh::ENTRY, linear::ENTRY, none::ENTRY];

/// Reads `damping` of `[contact]`: a number, which is C of the law `proportional`, or a table `[contact.damping]` with `law`
/// (`hunt_crossley` where it has a `restitution` and no law). Absent: `hunt_crossley` with a restitution of 0.8 at 0.1 m/s.
/// Returns C too, 0 for laws without it.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(contact: &Section) -> Result<(f64, Choice), SettingsError> {
    if !contact.has("damping") {
        let build: Build = Arc::new(|_| Box::new(hunt_crossley::assumed()));
        return Ok((0.0, Choice { name: hunt_crossley::ENTRY.name, build }));
    }
    if !contact.has_table("damping") {
        let (coefficient, build) = proportional::read(contact, "damping")?;
        return Ok((coefficient, Choice { name: proportional::ENTRY.name, build }));
    }
    let section = contact.section("damping")?;
    // A restitution alone says enough.
    let entry = match section.has("law") || !section.has("restitution") {
        true => choose(REGISTRY, &section, "law")?,
        false => &hunt_crossley::ENTRY,
    };
    let (coefficient, build) = (entry.parse)(&section)?;
    section.finish()?;
    Ok((coefficient, Choice { name: entry.name, build }))
}

#[cfg(test)]
mod tests;
