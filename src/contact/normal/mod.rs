//! Normal contact laws: penetration to force and patch.

mod assumed;
mod curvature;
pub mod damping;
mod hertz;
pub mod hertz_integrals;
pub mod hertz_table;
mod overlap;
mod shape;
#[cfg(test)]
pub(in crate::contact) mod test_surfaces;
#[cfg(test)]
mod tests;

use super::{Material, Patch};
use crate::settings::{Entry, Section, SettingsError, choose};
use std::sync::Arc;

pub use hertz::Hertz;
pub use shape::{ContactShape, Section as ProfileSection};

/// Elastic part of a normal contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElasticContact {
    /// K_h of Eq. 28, N/m^1.5.
    pub stiffness: f64,
    /// Elastic force, N.
    pub force: f64,
    /// How it grows with the penetration, N/m.
    pub slope: f64,
    /// Patch that belongs to the elastic force.
    pub patch: Patch,
}

/// The surfaces do not fit the law: they are conformal or hollow in one direction.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("half relative curvatures A = {rolling:.4e} 1/m, B = {across:.4e} 1/m; {}", self.wanted())]
pub struct ConformalContact {
    pub rolling: f64,
    /// At the point of contact.
    pub across: f64,
}

impl ConformalContact {
    fn wanted(&self) -> &'static str {
        if self.rolling > 0.0 && self.across > 0.0 {
            "beside the point the surfaces do not part within the width of an ellipse: they are conformal there, beyond Hertz theory \
             (contact.normal.conformal = \"bounded\" goes on)"
        } else {
            "Hertz theory needs both positive (contact.normal.conformal = \"bounded\" goes on)"
        }
    }
}

/// A law from penetration and the surfaces' shape to elastic force.
pub trait NormalLaw: Send + Sync + std::fmt::Debug {
    /// `penetration` > 0 [m].
    ///
    /// # Errors
    /// [`ConformalContact`] when the law does not hold for this shape.
    fn contact(&self, shape: &ContactShape, penetration: f64) -> Result<ElasticContact, ConformalContact>;

    /// The same law read the other way: the penetration [m] under which the elastic force is `force` >= 0 [N], and what belongs
    /// to it.
    ///
    /// # Errors
    /// [`ConformalContact`] when the law does not hold for this shape.
    fn contact_under(&self, shape: &ContactShape, force: f64) -> Result<(f64, ElasticContact), ConformalContact>;

    /// What `wheelrail plan` says behind the law's name.
    fn describe(&self) -> String;
}

/// Builds a law for a material.
pub type Build = Arc<dyn Fn(Material) -> Box<dyn NormalLaw> + Send + Sync>;
type Parse = fn(&Section) -> Result<Build, SettingsError>;

/// Every normal law that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[hertz::ENTRY, assumed::ENTRY];

/// The law of scenes that name none, see [`over_the_patch`].
pub const DEFAULT: &str = hertz::ENTRY.name;

/// Hertz's law with the curvature across taken over the patch, bounded where surfaces are conformal.
pub fn over_the_patch() -> Build {
    Arc::new(|material| Box::new(Hertz::over_the_patch(material)))
}

/// Reads `[contact.normal]`.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<Build, SettingsError> {
    (choose(REGISTRY, section, "law")?.parse)(section)
}
