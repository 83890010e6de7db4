//! A found minimum made exact in three dimensions.

use super::branch::{Scan, State};
use super::refine::Kink;
use super::view::View;
use super::{GlobalSearch, Minimum};
use crate::contact::search::algebraic::{ContactLocation, Pair};
use nalgebra::Vector4;

/// What [`GlobalSearch::polish`] makes of a minimum.
#[derive(Clone, Copy, Debug)]
pub struct Polished {
    /// Normal and penetration are those of the smooth surface where the other one is at its kink.
    pub location: ContactLocation,
    /// Did Newton solve the four equations? Otherwise the place comes from narrowing phi in the section at the contact's
    /// own station (jump of curvature), or is a vertex or an edge.
    pub smooth: bool,
}

/// How far Newton may end from the candidate in u, m: what a rail's curvature may shift a contact.
const NEAR: f64 = 2e-4;

impl GlobalSearch {
    /// The minimum by the four equations, from the candidate that [`GlobalSearch::find`] gave for the same pose.
    pub fn polish(&self, pair: &Pair, minimum: &Minimum) -> Polished {
        let start = minimum.parameters;
        if minimum.kink == Kink::None && !minimum.at_edge {
            if let Ok(location) = pair.locate(&start)
                && (location.parameters.wheel - start.wheel).abs() < NEAR
                && bending(pair, &location) > 0.0
            {
                return Polished { location, smooth: true };
            }
            if let Some(location) = self.settle(pair, minimum) {
                return Polished { location, smooth: false };
            }
        }
        let x = Vector4::new(start.wheel, start.angle, start.lead, start.rail);
        let at = pair.residual(&x).1;
        let mut location = at.location(&x, 0);
        if minimum.kink == Kink::Rail {
            // The rail has no normal at its vertex: the wheel's, turned out of the rail.
            let normal = at.wheel.t1.cross(&at.wheel.t2);
            let normal = normal * at.normal.dot(&normal).signum() / normal.norm();
            location.normal = normal;
            location.penetration = -at.gap.dot(&normal);
        }
        Polished { location, smooth: false }
    }

    /// Narrows the minimum in the section where it stands until that place stays: for rails that bend along the track.
    pub(super) fn settle(&self, pair: &Pair, minimum: &Minimum) -> Option<ContactLocation> {
        let mut parameters = minimum.parameters;
        for round in 1..=6 {
            let view = View::new(pair, Some(pair.distance + parameters.lead));
            let scan = Scan::seen(self, pair, view, f64::INFINITY);
            let guess = self.rail.place(parameters.rail);
            let (low, high) = (minimum.basin.0, minimum.basin.1);
            let mut span = 1e-6;
            let (mut a, mut b): (State, State);
            loop {
                a = scan.at((parameters.wheel - span).max(low), guess);
                b = scan.at((parameters.wheel + span).min(high), guess);
                if a.phi < 0.0 && b.phi >= 0.0 {
                    break;
                }
                span *= 8.0;
                if span > 4e-3 {
                    return None;
                }
            }
            let spot = scan.narrowed(a, b)?;
            let next = view.parameters(pair, spot.u, spot.slope, spot.eta);
            let change = (next.wheel - parameters.wheel).abs() + (next.lead - parameters.lead).abs();
            parameters = next;
            if change < 1e-11 {
                let x = Vector4::new(next.wheel, next.angle, next.lead, next.rail);
                return Some(pair.residual(&x).1.location(&x, round));
            }
        }
        None
    }
}

/// Is a place that solves the four equations a least distance across the profiles, not a ridge?
#[inline]
pub fn is_least(pair: &Pair, at: &ContactLocation) -> bool {
    bending(pair, at) > 0.0
}

/// Second derivative of the distance along the wheel's trace, 1/m; infinite curvature of the trace counts as positive. k as in
/// [`super::view`], by the tangent of the rail at the contact.
#[inline]
fn bending(pair: &Pair, at: &ContactLocation) -> f64 {
    let (wheel, rail) = (&at.wheel_profile, &at.rail_profile);
    let [forward, axial, up] = [0, 1, 2].map(|axis| pair.axes.column(axis).dot(&at.forward));
    let k2 = axial * axial / (forward * forward + up * up);
    let speed = 1.0 - k2 * (wheel.d1 * wheel.d1 + wheel.value * wheel.d2);
    if speed <= 0.0 {
        return f64::NEG_INFINITY;
    }
    let seen = 1.0 + wheel.d1 * wheel.d1 * (1.0 - k2);
    let own = -wheel.d2 / (seen * seen.sqrt() * speed);
    let across = 1.0 + rail.d1 * rail.d1;
    let other = rail.d2 / (across * across.sqrt());
    own - other / (1.0 + other * at.penetration)
}

/// `k + 2 time dk/dt` [1/m] with k as in `bending`, where u and eta run at `rates` [m/s]: towards a place where least distance and ridge
/// merge k^2 falls evenly, so that this is zero `time` [s] before. The squares of k in [`super::view`] are left out of dk/dt.
#[inline]
pub fn bending_ahead(pair: &Pair, at: &ContactLocation, rates: [f64; 2], time: f64) -> f64 {
    let [own, other] = [&at.wheel_profile, &at.rail_profile].map(|profile| {
        let arc = 1.0 + profile.d1 * profile.d1;
        (profile.d3 - 3.0 * profile.d1 * profile.d2 * profile.d2 / arc) / (arc * arc.sqrt())
    });
    bending(pair, at) - 2.0 * time * (own * rates[0] + other * rates[1])
}
