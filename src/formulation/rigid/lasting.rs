//! How long the place of a rigid contact lasts: when the idealisation of rigid surfaces ends.
//!
//! A constraint holds the wheel at one least distance d(u) of the surfaces. Its relative curvature `k = d''(u)` [1/m] says how fast the
//! place runs where the surfaces slide past each other with v [m/s], and what acceleration the constraint asks of the wheel:
//!
//! ```text
//! u' = k_rail v / k,   g'' = k_wheel k_rail v^2 / k
//! ```
//!
//! Least distance and ridge merge where k falls to zero (a fold), and before that d has the form `c u^3 / 6`, so `k' = -c u'` and
//!
//! ```text
//! k^2 = 2 c k_rail v tau,   tau = -k / (2 dk/dt): time until the place ceases to exist
//! ```
//!
//! u' and the normal force grow like tau^(-1/2) without bound. Nothing of that is physical: a real wheel stands on a patch of some
//! millimetres in which it sinks by some 60 um, and answers to a change of shape under it within about the inverse of its contact
//! frequency, `sqrt(m delta / (1.5 N))`: 0.5 to 1 ms for half a wheelset (750 to 1000 kg), 55 to 80 kN and 50 to 75 um. A place that lasts
//! no longer than that is left for the elastic contact. The condition
//!
//! ```text
//! k + 2 T dk/dt < 0,   T = 1 ms
//! ```
//!
//! is that of tau < T without its pole at dk/dt = 0; it is a function of the state (with third derivatives of the profiles), so that the
//! integrators find its root like any event's. Not in dk/dt: what yaw adds to k (its square, 1e-4) and the change of yaw.
//! Where the curvature of a profile jumps k may also jump to below zero: there is no approach to such an end, and no growth before it.
//!
//! A wheel becomes a constraint again only at a place that lasts longer than 3 T at present.

use crate::contact::search::algebraic::ContactLocation;
use crate::contact::search::global::bending_ahead;
use crate::formulation::Model;
use crate::formulation::elastic::points;
use crate::formulation::step::WheelRef;
use crate::mbs::body::BodyMotion;

/// T, s.
const TIME: f64 = 1e-3;
/// That of a place at which a wheel lands, s.
const AT_LANDING: f64 = 3.0 * TIME;

fn bending(model: &Model, wheel: WheelRef, motion: &BodyMotion, found: &ContactLocation, rates: [f64; 2], time: f64) -> f64 {
    if !points::searched(model, wheel.contact) {
        return f64::INFINITY;
    }
    bending_ahead(&wheel.pair(model, motion), found, rates, time)
}

/// How far a constrained place is from being left, 1/m; infinity where there is but one place. `rates`: those of u and eta, m/s.
#[inline]
pub(super) fn remaining(model: &Model, wheel: WheelRef, motion: &BodyMotion, found: &ContactLocation, rates: [f64; 2]) -> f64 {
    bending(model, wheel, motion, found, rates, TIME)
}

/// May a wheel land there?
pub(super) fn bears(model: &Model, wheel: WheelRef, motion: &BodyMotion, found: &ContactLocation, rates: [f64; 2]) -> bool {
    bending(model, wheel, motion, found, rates, 0.0) > 0.0 && bending(model, wheel, motion, found, rates, AT_LANDING) > 0.0
}
