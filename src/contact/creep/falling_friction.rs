//! Friction that falls with the speed of sliding.
//!
//! `mu(w) = mu0 ((1 - A) exp(-B w) + A)`: mu0 is the scene's friction coefficient (at rest), A = mu(infinity)/mu0, B in s/m.
//! w is the speed of rigid sliding of the whole contact, `V sqrt(xi_x^2 + xi_y^2)`, one value for the patch, as Polach (2005)
//! and, for FASTSIM, Spiryagin, Polach and Cole (Vehicle System Dynamics 51 (2013), 1765-1783) have it. (Friction that depends
//! on the slip of each cell is found too, e.g. Gimenez, Alonso and Gomez (2005); it makes the traction of a cell ambiguous
//! where friction falls faster than the elastic slip grows, and hardly changes the total.) Spin is not part of w.
//!
//! Without creepage w has a corner (it is a length): under spin alone the force has a corner there too, of size
//! `(1 - A) B V` in dF/(mu0 N)/d(creepage), e.g. 7 at 20 m/s on a dry rail, where the elastic slope is several hundred.

use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// The two numbers of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FallingFriction {
    /// A, -.
    pub ratio: f64,
    /// B, s/m.
    pub decay: f64,
}

impl FallingFriction {
    /// Friction that does not depend on sliding.
    pub const CONSTANT: FallingFriction = FallingFriction { ratio: 1.0, decay: 0.0 };

    /// mu at `speed` of sliding [m/s], from `friction` at rest.
    #[inline]
    pub fn at(&self, friction: f64, speed: f64) -> f64 {
        if self.ratio == 1.0 {
            return friction;
        }
        friction * ((1.0 - self.ratio) * (-self.decay * speed).exp() + self.ratio)
    }

    /// Reads `friction_ratio` and `friction_decay`; `default` where they are absent.
    pub fn parse(section: &Section, default: Self) -> Result<Self, SettingsError> {
        let ratio = section.number_or("friction_ratio", Dimension::None, default.ratio)?;
        if !(0.0..=1.0).contains(&ratio) {
            return Err(section.error("friction_ratio", format!("found {ratio:?}, expected a number from 0 to 1")));
        }
        let decay = section.number_or("friction_decay", Dimension::None, default.decay)?;
        if decay < 0.0 {
            return Err(section.error("friction_decay", format!("found {decay:?}, expected 0 s/m or more")));
        }
        Ok(FallingFriction { ratio, decay })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_ends_and_slope() {
        let law = FallingFriction { ratio: 0.4, decay: 0.6 };
        assert_eq!(law.at(0.55, 0.0), 0.55);
        assert!((law.at(0.55, 1e3) - 0.22).abs() < 1e-15);
        let slope = (law.at(0.55, 1e-6) - law.at(0.55, 0.0)) / 1e-6;
        assert!((slope + 0.55 * 0.6 * 0.6).abs() < 1e-6, "{slope}");
        assert_eq!(FallingFriction::CONSTANT.at(0.3, 7.0), 0.3);
        assert_eq!(law.at(0.55, f64::INFINITY), 0.55 * 0.4);
    }
}
