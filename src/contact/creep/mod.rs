//! Creep laws: creepage to tangential force, for steady rolling along +e1.

pub mod kalker;
mod shen_hedrick_elkins;

use super::creepage::{CreepForce, Creepage};
use super::{Material, Patch};
use crate::settings::{Entry, Section, SettingsError, choose};
use std::sync::Arc;

/// A steady creep law.
pub trait CreepLaw: Send + Sync + std::fmt::Debug {
    /// Force on the wheel for a patch loaded with `normal_force` >= 0 [N] under friction coefficient `friction` >= 0.
    /// Finite for every finite input; zero where the friction bound is zero.
    fn force(&self, patch: Patch, normal_force: f64, friction: f64, creepage: Creepage) -> CreepForce;
}

/// Builds a law for a material.
pub type Build = Arc<dyn Fn(Material) -> Box<dyn CreepLaw> + Send + Sync>;
type Parse = fn(&Section) -> Result<Build, SettingsError>;

/// Every creep law that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[shen_hedrick_elkins::ENTRY];

/// Reads `[contact.creep]`.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<Build, SettingsError> {
    (choose(REGISTRY, section, "law")?.parse)(section)
}
