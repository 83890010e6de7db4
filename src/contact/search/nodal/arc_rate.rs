//! How the rail's distance follows a point (Eq. 29).

use crate::geometry::track::RailSection;
use nalgebra::Vector3;

/// Rate of the rail's distance s [m/s] that belongs to a point (Eq. 29, made exact), from the rail's section at s and
/// the point's position and velocity in the world.
///
/// Keeps the point in the plane normal to the rail's space curve R(s): `(r - R) . R' = 0` differentiated gives
///
/// ```text
/// s' = v . R' / (|R'|^2 - (r - R) . R'')
/// ```
///
/// Eq. 29 has `s' = v . t1`. With s counted along the curve that is the same without `(r - R) . R''` (curvature times
/// the point's offset toward the centre of curvature); here s is counted along the track's centre line, hence
/// `|R'|^2`. What Eq. 29 leaves out adds up: R(s) falls behind or runs ahead of the point.
#[inline]
pub fn arc_rate(section: &RailSection, point: &Vector3<f64>, velocity: &Vector3<f64>) -> f64 {
    velocity.dot(&section.d1) / (section.d1.norm_squared() - (point - section.origin).dot(&section.d2))
}
