//! Points on the surface of a rail (Eqs. 5 and 6).

use super::Rail;
use crate::geometry::profile::ProfilePoint;
use crate::geometry::surface::{SurfacePoint, ThirdDerivatives};
use nalgebra::Vector3;

/// Third derivatives of the rail surface at distance `s` and coordinate `eta` where its profile is `profile`.
pub fn rail_third_derivatives(rail: &Rail, s: f64, eta: f64, profile: &ProfilePoint) -> ThirdDerivatives {
    if let Some(line) = rail.line_at(s) {
        return rail.curved_third_derivatives(line, s, eta, profile);
    }
    let zero = Vector3::zeros();
    ThirdDerivatives { t111: rail.section(s).d3, t112: zero, t122: zero, t222: rail.up * profile.d3 }
}

/// Rail surface over (s, eta): distance along the track [m] and coordinate across the section [m].
///
/// `r = origin(s) + eta * outward(s) + f(eta) * up(s)` (Eqs. 5 and 6). Returns the profile value too, whose
/// derivatives give the curvature.
#[inline]
pub fn rail_point(rail: &Rail, s: f64, eta: f64) -> (SurfacePoint, ProfilePoint) {
    let f = rail.profile.at(eta);
    (rail_point_of(rail, s, eta, &f), f)
}

/// The same where the rail's profile is known to be `f`.
#[inline]
pub fn rail_point_of(rail: &Rail, s: f64, eta: f64, f: &ProfilePoint) -> SurfacePoint {
    if let Some(line) = rail.line_at(s) {
        return rail.curved_point(line, s, eta, f);
    }
    let section = rail.section(s);
    SurfacePoint {
        position: section.origin + rail.outward * eta + rail.up * f.value,
        t1: section.d1,
        t2: rail.outward + rail.up * f.d1,
        t11: section.d2,
        t12: Vector3::zeros(),
        t22: rail.up * f.d2,
    }
}
