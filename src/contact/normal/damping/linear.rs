//! Linear damping that fades in with the penetration: `D = C delta' s(delta / delta_full)`, `s(x) = x^2 (3 - 2 x)` up to x = 1
//! and 1 beyond.
//!
//! A constant damper would make the force jump at first touch and pull at the last. The step function is the one that
//! multibody programs use for the same purpose (the IMPACT function of MSC Adams).

use super::{Approach, DampingLaw, DampingSlopes};
use crate::math::smooth_step::cubic_step;
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
        self.coefficient * at.rate * cubic_step(at.penetration / self.full_at)
    }

    fn slopes(&self, at: &Approach) -> DampingSlopes {
        let x = (at.penetration / self.full_at).clamp(0.0, 1.0);
        DampingSlopes {
            by_elastic: 0.0,
            by_penetration: self.coefficient * at.rate * (6.0 * x * (1.0 - x)) / self.full_at,
            by_rate: self.coefficient * cubic_step(x),
        }
    }

    fn describe(&self) -> String {
        format!("= {:?} N s/m from {:?} m penetration, fading in below", self.coefficient, self.full_at)
    }
}

/// K of the contact that `full_at` is derived for where a scene does not give it, N/m^1.5: a steel wheel on a steel rail.
pub(super) const REFERENCE_STIFFNESS: f64 = 1e11;
/// Speed of parting up to which the damper then lets the wheel go, m/s.
pub(super) const REFERENCE_SPEED: f64 = 0.1;

/// delta_full [m] where the scene gives none: the least one with which the damper never pulls in parting at v = 0.1 m/s. With x = delta /
/// delta_full its share of the elastic force K delta^1.5 is
///
/// ```text
/// C v x^2 (3 - 2 x) / (K delta_full^1.5 x^1.5),   greatest at x = 1/2: sqrt(2) C v / (K delta_full^1.5)
/// ```
///
/// which is 1 for delta_full = (sqrt(2) C v / K)^(2/3): 27 um for C = 1e5 N s/m. An undamped contact needs no length: 1 um.
pub(super) fn derived(coefficient: f64) -> f64 {
    const LEAST: f64 = 1e-6;
    (std::f64::consts::SQRT_2 * coefficient * REFERENCE_SPEED / REFERENCE_STIFFNESS).powf(2.0 / 3.0).max(LEAST)
}

fn parse(section: &Section) -> Result<(f64, super::Build), SettingsError> {
    let coefficient = section.not_negative("coefficient", Dimension::Damping)?;
    let full_at = if section.has("full_at") { section.positive("full_at", Dimension::Length)? } else { derived(coefficient) };
    Ok((0.0, Arc::new(move |_| Box::new(Linear { coefficient, full_at }))))
}
