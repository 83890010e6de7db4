//! Creep laws: creepage to tangential force, for steady rolling along +e1.

mod adapted;
mod demand;
pub mod exact;
mod falling_friction;
mod fastrip;
mod fastsim;
pub mod inline;
pub mod kalker;
mod kalker_linear;
pub mod polach;
mod shen_hedrick_elkins;
pub mod slopes;
mod strips;
#[cfg(test)]
mod tests;
pub mod usetab;

use super::creepage::{CreepForce, Creepage};
use super::{Material, Patch};
use adapted::{KalkerFactors, Reduced, WithoutSpin};
use fastsim::Fastsim;
pub use kalker_linear::KalkerLinear;
pub use shen_hedrick_elkins::ShenHedrickElkins;

use crate::settings::{Entry, Section, SettingsError, choose};
use slopes::CreepSlopes;
use std::sync::Arc;

/// A loaded patch that rolls along +e1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RollingContact {
    pub patch: Patch,
    /// N, N, not negative.
    pub normal_force: f64,
    /// mu, -, not negative.
    pub friction: f64,
    pub creepage: Creepage,
    /// V, m/s, not negative: creepage times V is the speed of sliding, which friction may depend on.
    pub speed: f64,
}

impl RollingContact {
    /// mu N, N.
    #[inline]
    pub fn bound(&self) -> f64 {
        self.friction * self.normal_force
    }

    /// Speed of rigid sliding without spin, `V sqrt(xi_x^2 + xi_y^2)`, m/s.
    #[inline]
    pub fn sliding_speed(&self) -> f64 {
        let (x, y) = (self.creepage.longitudinal, self.creepage.lateral);
        self.speed * (x * x + y * y).sqrt()
    }
}

/// A steady creep law.
pub trait CreepLaw: Send + Sync + std::fmt::Debug {
    /// Force on the wheel. Finite for every finite input; zero where the friction bound is zero.
    fn force(&self, contact: &RollingContact) -> CreepForce;

    /// How the force, which is `force` here, changes. Laws that know no formula of their own are differenced.
    fn slopes(&self, contact: &RollingContact, force: &CreepForce) -> CreepSlopes {
        slopes::differences(self, contact, force)
    }

    /// Of Kalker's theory, which can be solved on any patch: how it is solved numerically.
    fn on_any_patch(&self) -> Option<exact::Settings> {
        None
    }

    /// Does no force of it exceed mu N?
    fn is_bounded(&self) -> bool {
        true
    }

    /// What `wheelrail plan` says behind the law's name.
    fn describe(&self) -> String {
        String::new()
    }
}

/// Kalker's simplified theory as FASTSIM solves it: what stands in for his exact one in slopes.
pub fn simplified_theory(material: Material) -> Box<dyn CreepLaw> {
    Box::new(Fastsim::new(material))
}

/// Builds a law for a material.
pub type Build = Arc<dyn Fn(Material) -> Box<dyn CreepLaw> + Send + Sync>;
type Parse = fn(&Section) -> Result<Build, SettingsError>;

/// Every creep law that a scene can name.
pub static REGISTRY: &[Entry<Parse>] =
    &[kalker_linear::ENTRY, shen_hedrick_elkins::ENTRY, polach::ENTRY, fastsim::ENTRY, fastrip::ENTRY, usetab::ENTRY, exact::ENTRY];

/// Reads `[contact.creep]`: a law, and Kalker factors of any law.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(section: &Section) -> Result<Build, SettingsError> {
    let build = (choose(REGISTRY, section, "law")?.parse)(section)?;
    let Some(factors) = KalkerFactors::parse(section)? else { return Ok(build) };
    Ok(Arc::new(move |material| Box::new(Reduced { law: build(material), factors })))
}

/// The law without spin creepage: it has no part in the lateral force and makes no moment.
pub fn without_spin(law: Box<dyn CreepLaw>) -> Box<dyn CreepLaw> {
    Box::new(WithoutSpin { law })
}
