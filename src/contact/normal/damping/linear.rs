//! Linear damping that fades in with the penetration: `D = C delta' s(delta / delta_full)`, `s(x) = x^2 (3 - 2 x)` up to x = 1
//! and 1 beyond.
//!
//! A constant damper would make the force jump at first touch and pull at the last. The step function is the one that
//! multibody programs use for the same purpose (the IMPACT function of MSC Adams).

use super::{Approach, DampingLaw, DampingSlopes};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "linear",
    summary: "a damper that fades in smoothly up to a stated penetration",
    reference: "cubic step of the IMPACT function, MSC Adams documentation",
    parse,
};

#[derive(Clone, Copy, Debug)]
pub(super) struct Linear {
    /// C, N s/m.
    pub coefficient: f64,
    /// delta_full, m.
    pub full_at: f64,
}

impl DampingLaw for Linear {
    #[inline]
    fn force(&self, at: &Approach) -> f64 {
        let x = (at.penetration / self.full_at).clamp(0.0, 1.0);
        self.coefficient * at.rate * (x * x * (3.0 - 2.0 * x))
    }

    fn slopes(&self, at: &Approach) -> DampingSlopes {
        let x = (at.penetration / self.full_at).clamp(0.0, 1.0);
        DampingSlopes {
            by_elastic: 0.0,
            by_penetration: self.coefficient * at.rate * (6.0 * x * (1.0 - x)) / self.full_at,
            by_rate: self.coefficient * (x * x * (3.0 - 2.0 * x)),
        }
    }

    fn describe(&self) -> String {
        format!("= {:?} N s/m from {:?} m penetration, fading in below", self.coefficient, self.full_at)
    }
}

fn parse(section: &Section) -> Result<(f64, super::Build), SettingsError> {
    let coefficient = section.not_negative("coefficient", Dimension::Damping)?;
    let full_at = section.positive("full_at", Dimension::Length)?;
    Ok((0.0, Arc::new(move |_| Box::new(Linear { coefficient, full_at }))))
}
