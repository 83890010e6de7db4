//! Kalker's linear theory as a creep law: forces of vanishing slip, see [`super::kalker`].
//!
//! **Not bounded by friction**: beyond about a third of mu N the true force stays behind the linear one, and at large creepage
//! the force of this law grows without end. For eigenvalues, for stability of the centred position and as the limit that the
//! other laws have to reach. Where nothing can be transmitted (no load, no friction, empty patch) the force is zero.

use super::kalker::LinearTheory;
use super::slopes::CreepSlopes;
use super::{Build, CreepLaw, RollingContact};
use crate::contact::Material;
use crate::contact::creepage::CreepForce;
use crate::settings::{Entry, Section, SettingsError};
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "kalker_linear",
    summary: "Kalker's linear theory, NOT bounded by friction; for vanishing creepage, eigenvalues",
    reference: "Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, Kluwer (1990)",
    parse,
};

/// The unbounded linear law.
#[derive(Debug, Clone)]
pub struct KalkerLinear(LinearTheory);

impl KalkerLinear {
    pub fn new(material: Material) -> Self {
        KalkerLinear(LinearTheory::new(material))
    }
}

impl CreepLaw for KalkerLinear {
    #[inline]
    fn force(&self, contact: &RollingContact) -> CreepForce {
        if contact.bound() > 0.0 { self.0.force(contact.patch, contact.creepage) } else { CreepForce::default() }
    }

    fn slopes(&self, contact: &RollingContact, _: &CreepForce) -> CreepSlopes {
        let normal_force = if contact.bound() > 0.0 { contact.normal_force } else { 0.0 };
        self.0.slopes(contact.patch, contact.creepage, normal_force)
    }

    fn is_bounded(&self) -> bool {
        false
    }
}

fn parse(_: &Section) -> Result<Build, SettingsError> {
    Ok(Arc::new(|material| Box::new(KalkerLinear::new(material))))
}
