//! The wheel as a rail sees it from one pose: a plane curve.
//!
//! The wheel's point of coordinate u that can touch a rail running straight along t has a normal that is normal to t. With
//! the axle a (outward), the forward direction w of the wheel's plane that lies along t, and D normal to both, downward:
//!
//! ```text
//! r(u) = Q + a u + R (w sin c + D cos c),   sin c = k R',   k = (a . t) / |t - a (a . t)|
//! ```
//!
//! Brought along t into the rail's section (axes eta outward, h up) these points are the edge of the wheel's shadow
//!
//! ```text
//! C = C0 + A (u - k^2 R R') + B R cos c,      C' = (1 - k^2 (R'^2 + R R'')) / cos c  (A cos c + B R')
//! ```
//!
//! with A and B the images of a and D. A straight rail's section is normal to t; then A and B are normal to each other and
//! `|A| = 1 / sqrt(1 + k^2)`, `|B| = 1`. Where a deviation slopes by e, lengths and angles in the section are wrong by shares
//! of e^2 (1e-4 for 10 mm/m). Where `m = 1 - k^2 (R'^2 + R R'')` is negative (a hollow of small radius at large yaw: 13 mm
//! at 70 degrees from 34 mrad on) the line along t enters the wheel: no contact.

use crate::contact::search::algebraic::{Pair, SurfaceParameters};
use crate::geometry::profile::ProfilePoint;
use nalgebra::{Vector2, Vector3};

#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub k: f64,
    pub k2: f64,
    /// C0, A and B.
    origin: Vector2<f64>,
    outward: Vector2<f64>,
    down: Vector2<f64>,
    /// Direction of A, rad.
    pub turn: f64,
    /// b: angle on the wheel at which D points, rad.
    lowest: f64,
    /// Where along the track the section stands that is seen, m, its origin and t.
    station: f64,
    section: Vector3<f64>,
    along: Vector3<f64>,
    /// The section's axes in the world: eta and h.
    across: Vector3<f64>,
    height: Vector3<f64>,
}

/// A point of the shadow's edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trace {
    pub point: Vector2<f64>,
    /// Tangent, not normalised.
    pub tangent: Vector2<f64>,
    /// cos c.
    cos: f64,
}

/// Least cos^2 c: a steeper flank is not seen.
const LEAST_COS2: f64 = 0.05;

impl View {
    /// The view from the section at `station` [m]; without one, from the section beside the tread circle's centre.
    #[inline]
    pub fn new(pair: &Pair, station: Option<f64>) -> View {
        let (wheel, rail) = (pair.wheel, pair.rail);
        let sign = wheel.side.sign();
        let axle = pair.axes.column(1) * sign;
        let hub = pair.centre + axle * wheel.half_spacing;
        let mut seen = rail.section(station.unwrap_or(pair.distance));
        let mut at = station.unwrap_or(pair.distance);
        let ahead = (hub - seen.origin).dot(&seen.d1) / seen.d1.norm_squared();
        if station.is_none() && ahead.abs() > 1e-12 {
            at += ahead;
            seen = rail.section(at);
        }
        let t = seen.d1;
        let (forward, up, axial) = (pair.axes.column(0).dot(&t), pair.axes.column(2).dot(&t), axle.dot(&t));
        let across = (forward * forward + up * up).sqrt();
        let k = axial / across;
        // w and D in the wheel's plane.
        let down = (pair.axes.column(0) * up - pair.axes.column(2) * forward) / across;
        // Along t into the section: eta and h of a vector v are those of v - t x, where x is its part along the section's normal.
        let normal = seen.outward.cross(&seen.up);
        let lean = 1.0 / normal.dot(&t);
        let flat = |v: Vector3<f64>| {
            let v = v - t * (normal.dot(&v) * lean);
            Vector2::new(v.dot(&seen.outward), v.dot(&seen.up))
        };
        let down = flat(down);
        View {
            k,
            k2: k * k,
            origin: flat(hub - seen.origin),
            outward: flat(axle),
            down,
            turn: down.x.atan2(-down.y),
            lowest: (up / forward).atan(),
            station: at,
            section: seen.origin,
            along: t,
            across: seen.outward,
            height: seen.up,
        }
    }

    #[inline]
    pub fn trace(&self, u: f64, radius: f64, slope: f64) -> Trace {
        let cos = (1.0 - self.k2 * slope * slope).max(LEAST_COS2).sqrt();
        Trace {
            point: self.origin + self.outward * (u - self.k2 * radius * slope) + self.down * (radius * cos),
            tangent: self.outward * cos + self.down * slope,
            cos,
        }
    }

    /// What yaw adds to the direction atan(R') of the trace, rad (to 1e-9 while `k R' < 0.1`, to 1e-4 at 0.5): the direction is
    /// `atan(f R')`, `f = sqrt((1 + k^2) / (1 - k^2 R'^2))`.
    #[inline]
    pub fn yaw_turn(&self, slope: f64) -> f64 {
        let square = slope * slope;
        let x = (self.k2 * square).min(0.5);
        // Series of f - 1 in k^2 and x.
        let excess = 0.5 * self.k2 + x * (0.5 + x * (0.375 + x * (0.3125 + 0.6 * x * x)));
        let tan = slope * excess / (1.0 + square * (1.0 + excess));
        tan * (1.0 - tan * tan * (1.0 / 3.0))
    }

    /// A bound of it up to a slope, rad.
    #[inline]
    pub fn most_yaw_turn(&self, steepest: f64) -> f64 {
        let square = steepest * steepest;
        let x = self.k2 * square;
        if x > 0.5 { 1.0 } else { self.k2 * steepest * (0.5 + (0.5 + x) * square) / (1.0 + square) }
    }

    /// m: how fast the trace runs along u; negative where it can't touch.
    #[inline]
    pub fn speed(&self, wheel: &ProfilePoint) -> f64 {
        1.0 - self.k2 * (wheel.d1 * wheel.d1 + wheel.value * wheel.d2)
    }

    /// Derivatives of the trace's point and tangent along u.
    #[inline]
    pub fn rates(&self, wheel: &ProfilePoint, trace: &Trace) -> (Vector2<f64>, Vector2<f64>) {
        let point = trace.tangent * (self.speed(wheel) / trace.cos);
        let tangent = self.down * wheel.d2 - self.outward * (self.k2 * wheel.d1 * wheel.d2 / trace.cos);
        (point, tangent)
    }

    /// All four surface parameters of a pair of points of the section.
    pub fn parameters(&self, pair: &Pair, u: f64, slope: f64, eta: f64) -> SurfaceParameters {
        let angle = self.lowest + (self.k * slope).clamp(-0.98, 0.98).asin();
        let (wheel, _) = pair.wheel.point(pair.centre, pair.axes, u, angle);
        let rail = self.section + self.across * eta + self.height * pair.rail.profile.at(eta).value;
        let ahead = (wheel.position - rail).dot(&self.along) / self.along.norm_squared();
        SurfaceParameters { wheel: u, angle, lead: self.station + ahead - pair.distance, rail: eta }
    }
}
