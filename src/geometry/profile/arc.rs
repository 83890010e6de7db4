//! Circular rail head: `f(eta) = sqrt(radius^2 - eta^2) - radius`.

use super::{Part, Profile, ProfileChoice, ProfilePoint};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> =
    Entry { name: "arc", summary: "rail head that is one circular arc, highest at eta = 0", reference: "elementary geometry", parse };

/// `f(eta) = sqrt(radius^2 - eta^2) - radius`, f(0) = 0.
///
/// The head ends at 0.8 of the radius, or 250 mm from the middle where the arc is wider: no rail or roller is, and a search for
/// contacts looks at the whole range.
#[derive(Debug, Clone)]
pub struct Arch {
    /// Radius of the head, m.
    pub radius: f64,
}

/// Share of the radius up to which the arc is used; beyond, a parabola goes on with equal value, slope and
/// curvature, so that an iteration that strays stays finite.
const ROUND_SHARE: f64 = 0.8;
/// Half of the widest head, m.
const WIDEST: f64 = 0.25;
/// Radii that a head may have, m. The largest is flat to 0.03 mm over the widest head.
const RADII: (f64, f64) = (1e-3, 1e3);

impl Profile for Arch {
    fn at(&self, eta: f64) -> ProfilePoint {
        let edge = (ROUND_SHARE * self.radius).copysign(eta);
        let at = if eta.abs() <= ROUND_SHARE * self.radius { eta } else { edge };
        let drop = (self.radius * self.radius - at * at).sqrt();
        let d1 = -at / drop;
        let d2 = -(self.radius * self.radius) / (drop * drop * drop);
        let beyond = eta - at;
        if beyond == 0.0 {
            // -eta^2 / (drop + radius) instead of drop - radius: no cancellation near the top.
            let value = -at * at / (drop + self.radius);
            return ProfilePoint { value, d1, d2, d3: -3.0 * self.radius * self.radius * at / drop.powi(5) };
        }
        ProfilePoint { value: drop - self.radius + beyond * (d1 + 0.5 * beyond * d2), d1: d1 + beyond * d2, d2, d3: 0.0 }
    }

    fn range(&self) -> (f64, f64) {
        let end = (ROUND_SHARE * self.radius).min(WIDEST);
        (-end, end)
    }

    fn describe(&self) -> String {
        format!("arc, radius {} m", self.radius)
    }
}

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    if part == Part::Wheel {
        return Err(section.error("kind", "an arc is a rail profile; a wheel may be \"s1002\", \"cone\", \"points\", ..."));
    }
    let radius = section.within("radius", Dimension::Length, RADII)?;
    Ok(ProfileChoice::own(Arc::new(Arch { radius })))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_derivatives_are_those_of_the_circle() {
        let arc = Arch { radius: 0.3 };
        let h = 1e-4;
        for eta in [-0.239, -0.05, 0.0, 0.01, 0.2, 0.26] {
            let p = arc.at(eta);
            let (ahead, behind) = (arc.at(eta + h), arc.at(eta - h));
            assert!((p.d1 - (ahead.value - behind.value) / (2.0 * h)).abs() < 2e-7 * (1.0 + p.d3.abs() / 6.0), "{eta}");
            assert!((p.d2 - (ahead.d1 - behind.d1) / (2.0 * h)).abs() < 1e-4, "{eta}");
            assert!((p.d3 - (ahead.d2 - behind.d2) / (2.0 * h)).abs() < 1e-2, "{eta}");
        }
        let top = arc.at(0.0);
        assert!(top.value == 0.0 && top.d1 == 0.0 && (top.d2 + 1.0 / 0.3).abs() < 1e-15 && top.d3 == 0.0);
    }
}
