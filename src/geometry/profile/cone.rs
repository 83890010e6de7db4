//! Conical wheel: `R(u) = radius - slope u`.

use super::{Part, Profile, ProfileChoice, ProfilePoint};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "cone",
    summary: "conical wheel tread: radius at the tread circle and slope (1/40 = 0.025); no flange",
    reference: "elementary geometry",
    parse,
};

/// `R(u) = radius - slope u`, u outward positive.
#[derive(Debug, Clone)]
pub struct Cone {
    /// Radius at the tread circle, m.
    pub radius: f64,
    /// Fall of the radius per metre outward, -.
    pub slope: f64,
}

/// A tread is about 135 mm wide; a contact further out than this is not on a wheel.
const HALF_WIDTH: f64 = 0.07;

impl Profile for Cone {
    fn at(&self, u: f64) -> ProfilePoint {
        ProfilePoint { value: self.radius - self.slope * u, d1: -self.slope, d2: 0.0, d3: 0.0 }
    }

    fn range(&self) -> (f64, f64) {
        (-HALF_WIDTH, HALF_WIDTH)
    }

    fn describe(&self) -> String {
        format!("cone, radius {} m, slope {}", self.radius, self.slope)
    }
}

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    if part == Part::Rail {
        return Err(section.error("kind", "a cone is a wheel profile; a rail may be \"60e1\", \"arc\", \"points\", ..."));
    }
    let radius = section.positive("radius", Dimension::Length)?;
    let slope = section.number("slope", Dimension::None)?;
    if slope.abs() * HALF_WIDTH >= radius {
        return Err(section.error("slope", format!("found {slope}, but the cone's tip must stay off the tread (radius {radius} m)")));
    }
    Ok(ProfileChoice::own(Arc::new(Cone { radius, slope })))
}
