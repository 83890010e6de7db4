//! Lankarani and Nikravesh's damping: `D = N_elastic 3 (1 - e^2) / 4 delta' / v`, from a balance of energy for a coefficient
//! of restitution e near 1.
//!
//! v is the speed of approach at first touch. A contact keeps no memory of it here, so it is a number of the scene: at
//! other speeds restitution is that of `hunt_crossley.rs` with `d = 3 (1 - e^2) / 4` times the ratio of speeds. The rebound is
//! faster than e v: 0.913 v for e = 0.9, 0.725 v for e = 0.5 (the tests integrate it).
//!
//! Source: H.M. Lankarani, P.E. Nikravesh, ASME J. Mechanical Design 112 (1990) 369-376.

use super::hunt_crossley::read;
use crate::settings::Entry;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "lankarani_nikravesh",
    summary: "elastic force times 1 + 3 (1 - e^2) / 4 delta' / v, coefficient of restitution e near 1",
    reference: "Lankarani, Nikravesh, ASME J. Mechanical Design 112 (1990) 369",
    parse: |section| read(section, factor),
};

/// `D / N_elastic` at the rate v.
pub(super) fn factor(restitution: f64) -> f64 {
    0.75 * (1.0 - restitution * restitution)
}
