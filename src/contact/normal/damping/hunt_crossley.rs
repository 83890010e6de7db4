//! Hunt and Crossley's damping: `D = N_elastic mu delta'`, so `N = K_h delta^1.5 (1 + mu delta')`.
//!
//! The damping grows with the elastic force, so the loop of force over penetration closes at zero. A mass that touches with
//! the speed v and meets nothing else leaves with e v; from `v dv = -(K/m) delta^1.5 (1 + mu v) d(delta)`, separated and taken to
//! the largest penetration from both sides, with d = mu v:
//!
//! ```text
//! (1 + e) d = ln((1 + d) / (1 - e d))
//! ```
//!
//! whatever K, m and the exponent are. Hunt and Crossley's own `d = 3 (1 - e) / 2` is the limit for e near 1; here the
//! equation is solved, so the stated e is met at the stated speed. v is a number of the scene: a contact keeps no memory of the speed with
//! which it began. Slower impacts rebound with a larger share, faster ones with a smaller, as in experiments.
//!
//! Sources: K.H. Hunt, F.R.E. Crossley, ASME J. Applied Mechanics 42 (1975) 440-445; the exact relation: Y. Gonthier et al.,
//! Multibody System Dynamics 11 (2004) 209-233; Y. Zhang, I. Sharf, Proc. Royal Society A 465 (2009) 1701-1720.

use super::{Approach, Build, DampingLaw, DampingSlopes};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "hunt_crossley",
    summary: "elastic force times 1 + mu delta', with the stated coefficient of restitution at the stated impact speed",
    reference: "Hunt, Crossley, ASME J. Applied Mechanics 42 (1975) 440",
    parse: |section| read(section, factor),
};

/// `D = N_elastic per_rate delta'`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hysteresis {
    /// mu, s/m.
    pub per_rate: f64,
    /// e and v [m/s] that it was made for.
    pub restitution: f64,
    pub speed: f64,
}

impl Hysteresis {
    pub fn new(restitution: f64, speed: f64, factor: fn(f64) -> f64) -> Self {
        Hysteresis { per_rate: factor(restitution) / speed, restitution, speed }
    }
}

impl DampingLaw for Hysteresis {
    #[inline]
    fn force(&self, at: &Approach) -> f64 {
        at.elastic * (self.per_rate * at.rate)
    }

    fn slopes(&self, at: &Approach) -> DampingSlopes {
        DampingSlopes { by_elastic: self.per_rate * at.rate, by_penetration: 0.0, by_rate: at.elastic * self.per_rate }
    }

    fn describe(&self) -> String {
        format!("= {:?} s/m of the elastic force (restitution {} at {} m/s)", self.per_rate, self.restitution, self.speed)
    }
}

/// d of the module's equation for e in (0, 1]: the root between 0 and 1 / e, where the difference of the two sides goes
/// from below to above zero once.
pub(super) fn factor(restitution: f64) -> f64 {
    if restitution >= 1.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0 / restitution);
    for _ in 0..200 {
        let d = 0.5 * (low + high);
        if d.ln_1p() - (-restitution * d).ln_1p() > (1.0 + restitution) * d {
            high = d;
        } else {
            low = d;
        }
    }
    0.5 * (low + high)
}

/// Less is a contact without rebound, whose damping would have no limit.
const LEAST_RESTITUTION: f64 = 0.01;

/// Of impacts where the scene does not say it, m/s: a wheel that falls by half a millimetre.
const IMPACT_SPEED: f64 = 0.1;
/// Of contacts whose damping nobody knows: a steel wheel that keeps 80 % of its speed.
const RESTITUTION: f64 = 0.8;

/// The law of a scene that says nothing about damping.
pub(super) fn assumed() -> Hysteresis {
    Hysteresis::new(RESTITUTION, IMPACT_SPEED, factor)
}

/// Reads `restitution` and `impact_speed` (0.1 m/s where it is absent); `factor` is mu v as a function of e.
pub(super) fn read(section: &Section, factor: fn(f64) -> f64) -> Result<(f64, Build), SettingsError> {
    let restitution = section.number("restitution", Dimension::None)?;
    if !(LEAST_RESTITUTION..=1.0).contains(&restitution) {
        return Err(section.error("restitution", format!("found {restitution:?}, expected a number from {LEAST_RESTITUTION} to 1")));
    }
    let speed = section.positive_or("impact_speed", Dimension::Speed, IMPACT_SPEED)?;
    Ok((0.0, Arc::new(move |_| Box::new(Hysteresis::new(restitution, speed, factor)))))
}
