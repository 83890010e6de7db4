//! Damping in proportion to the penetration: `D = C delta delta'` (paper, Eq. 28 with delta > 0 in contact).

use super::{Approach, Build, DampingLaw, DampingSlopes};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "proportional",
    summary: "C delta delta'; what a plain number means",
    reference: "paper, Eq. 28",
    parse: |section| read(section, "coefficient"),
};

/// C, N s/m2.
#[derive(Clone, Copy, Debug)]
pub struct Proportional(pub f64);

impl DampingLaw for Proportional {
    #[inline]
    fn force(&self, at: &Approach) -> f64 {
        self.0 * at.penetration * at.rate
    }

    fn slopes(&self, at: &Approach) -> DampingSlopes {
        DampingSlopes { by_elastic: 0.0, by_penetration: self.0 * at.rate, by_rate: self.0 * at.penetration }
    }

    fn describe(&self) -> String {
        format!("= {:?} N s/m2", self.0)
    }
}

/// C at `key`.
pub(super) fn read(section: &Section, key: &'static str) -> Result<(f64, Build), SettingsError> {
    let coefficient = section.not_negative(key, Dimension::PenetrationDamping)?;
    Ok((coefficient, Arc::new(|coefficient| Box::new(Proportional(coefficient)))))
}
