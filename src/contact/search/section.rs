//! Contact location in the rail's section: the four equations of [`super::algebraic`] with two unknowns left.
//!
//! A section has the origin o(s) and the axes eta outward and h up; t is the rail's tangent along the track at the contact. Then
//! t_angle . n = 0 is solved by the wheel's angle and t_s . r = 0 by the distance s. With the axle a (outward), the direction w of t in the wheel's plane, D normal to both, downward, and the centre Q of the tread
//! circle, the wheel's point of coordinate u whose normal is normal to t is
//!
//! ```text
//! r(u) = Q + a u + R (w sin c + D cos c),   sin c = k R',   k = (a . t) / |t - a (a . t)|
//! ```
//!
//! Brought along t into the section (flat: v - t v_x / t_x in eta, h) these points are a plane curve with the tangent T
//!
//! ```text
//! C = flat(Q - o) + A (u - k^2 R R') + B R cos c,   C' = m / cos c  T,   T = A cos c + B R',   m = 1 - k^2 (R'^2 + R R'')
//! ```
//!
//! A = flat(a), B = flat(D). With v = C - (eta, f) and e = (1, f') what is left is
//!
//! ```text
//! T x e = 0,   v . M e = 0,   M = I - p p' / t^2,   p = (t . eta, t . h)
//! ```
//!
//! M takes the length along t out of that in the section. On a straight centre line t is the same all over a section; where sections
//! turn with omega it is `o' + omega x (eta, h)`, and what changes its direction is twist alone: a circle turns them about an axis in which
//! they lie, and t only becomes longer or shorter. Newton's method solves them for u and eta. Each reading of the profiles also tells
//! how far ahead of the section the wheel's point lies; where the rail bends along the track, wheel and rail are seen from the section
//! there before the step is made, along the t of the place where the rail was read. What is then left of that distance errs by the
//! rail's change of direction in between. Whatever does not converge at once is left to the four equations.

use super::algebraic::{ContactLocation, Pair, SurfaceParameters};
use crate::geometry::profile::{Piecewise, Profile, ProfilePoint};
use crate::geometry::track::RailSection;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Most readings of the profiles; a start one step of integration away takes three.
const MOST: usize = 8;
/// A step that is shorter than this need not be made, m: the penetration changes by less than rounding.
const NEXT_STEP: f64 = 1e-12;
/// Residuals (m, rad) that are nothing but rounding.
const ROUNDING: f64 = 1e-16;
/// Change of the rail's direction between the section and the contact that may be left out, rad.
const TURN: f64 = 2e-12;
/// Distance along the track, m, over which a section is continued by its third derivative: on a wave of 100 mm and 1 mm that errs
/// by 3e-13 rad, on a bump of 10 mm by 3e-9 rad.
const NEAR: f64 = 5e-6;
/// Longer steps, m, and those after which the residual has grown, may lead to another place of contact.
const LONGEST: f64 = 3e-4;
/// Least cos^2 c: a steeper flank is not seen along the rail.
const LEAST_COS2: f64 = 0.05;

/// The wheel seen along the rail from one of its sections.
struct Sight {
    lead: f64,
    section: RailSection,
    /// Where on the section t is taken (eta, h), m, and t.
    place: Vector2<f64>,
    along: Vector3<f64>,
    hub: Vector3<f64>,
    axle: Vector3<f64>,
    forward: Vector3<f64>,
    down: Vector3<f64>,
    /// k and k^2.
    k: f64,
    k2: f64,
    /// flat(Q - o), A, B.
    flat_hub: Vector2<f64>,
    flat_axle: Vector2<f64>,
    flat_down: Vector2<f64>,
    metric: Matrix2<f64>,
    /// Components along t over t^2: of Q - o, of a, of w, of eta and h.
    ahead: [f64; 5],
    /// How fast the rail turns along the track, rad/m.
    bend: f64,
}

/// Wheel and rail at one choice of u and eta.
struct Reading {
    wheel: ProfilePoint,
    rail: ProfilePoint,
    sin: f64,
    cos: f64,
    residual: Vector2<f64>,
    jacobian: Matrix2<f64>,
    /// How far ahead of the section the wheel's point lies, m.
    ahead: f64,
}

/// The profiles of wheel and rail as they are read.
enum Profiles<'a> {
    Tables([&'a Piecewise; 2]),
    Any([&'a dyn Profile; 2]),
}

impl<'a> Profiles<'a> {
    #[inline]
    fn of(pair: &Pair<'a>) -> Self {
        let any = [pair.wheel.profile.as_ref(), pair.rail.profile.as_ref()];
        match any.map(|profile| profile.piecewise()) {
            [Some(wheel), Some(rail)] => Profiles::Tables([wheel, rail]),
            _ => Profiles::Any(any),
        }
    }

    #[inline]
    fn at(&self, u: f64, eta: f64) -> [ProfilePoint; 2] {
        match self {
            Profiles::Tables(both) => Piecewise::near_both(*both, [u, eta]),
            Profiles::Any([wheel, rail]) => [wheel.at(u), rail.at(eta)],
        }
    }
}

impl Sight {
    /// Seen from the section `ahead` [m] of this one, along the rail's tangent at `place`.
    #[inline]
    fn moved(self, pair: &Pair, ahead: f64, place: Vector2<f64>) -> Sight {
        let lead = self.lead + ahead;
        let smooth = ahead.abs() <= NEAR && !pair.rail.has_break_near(pair.distance + lead, NEAR);
        let section = if smooth { self.section.continued(ahead) } else { pair.rail.section(pair.distance + lead) };
        Self::new(pair, lead, section, place)
    }

    /// Seen from the `section` at a distance of `lead` [m] ahead of the wheelset's own, along the rail's tangent at `place`.
    #[inline]
    fn new(pair: &Pair, lead: f64, section: RailSection, place: Vector2<f64>) -> Sight {
        let axle = pair.axes.column(1) * pair.wheel.side.sign();
        let hub = pair.centre + axle * pair.wheel.half_spacing;
        let t = section.tangent(place.x, place.y);
        let (x, z) = (pair.axes.column(0), pair.axes.column(2));
        let (forward, up, axial) = (x.dot(&t), z.dot(&t), axle.dot(&t));
        let across = (forward * forward + up * up).sqrt();
        let per_across = 1.0 / across;
        let k = axial * per_across;
        let down = (x * up - z * forward) * per_across;
        let normal = section.outward.cross(&section.up);
        let lean = t / normal.dot(&t);
        let flat = |v: Vector3<f64>| {
            let v = v - lean * normal.dot(&v);
            Vector2::new(v.dot(&section.outward), v.dot(&section.up))
        };
        let (to_hub, per_square) = (hub - section.origin, 1.0 / t.norm_squared());
        let p = Vector2::new(t.dot(&section.outward), t.dot(&section.up));
        Sight {
            lead,
            place,
            along: t,
            hub,
            axle,
            forward: (x * forward + z * up) * per_across,
            down,
            k,
            k2: k * k,
            flat_hub: flat(to_hub),
            flat_axle: flat(axle),
            flat_down: flat(down),
            metric: Matrix2::identity() - p * p.transpose() * per_square,
            ahead: [to_hub.dot(&t), axial, across, p.x, p.y].map(|along| along * per_square),
            bend: section.d2.norm(),
            section,
        }
    }

    #[inline]
    fn read(&self, [wheel, rail]: [ProfilePoint; 2], u: f64, eta: f64) -> Option<Reading> {
        let sin = self.k * wheel.d1;
        let cos2 = 1.0 - sin * sin;
        let speed = 1.0 - self.k2 * (wheel.d1 * wheel.d1 + wheel.value * wheel.d2);
        if !(cos2 >= LEAST_COS2 && speed > 0.0) {
            return None;
        }
        let cos = cos2.sqrt();
        let per_cos = 1.0 / cos;
        let place = self.flat_hub + self.flat_axle * (u - self.k2 * wheel.value * wheel.d1) + self.flat_down * (wheel.value * cos);
        let tangent = self.flat_axle * cos + self.flat_down * wheel.d1;
        let tangent_u = self.flat_down * wheel.d2 - self.flat_axle * (self.k2 * wheel.d1 * wheel.d2 * per_cos);
        let (v, e) = (place - Vector2::new(eta, rail.value), Vector2::new(1.0, rail.d1));
        let across = self.metric * e;
        let residual = Vector2::new(tangent.y - rail.d1 * tangent.x, across.dot(&v));
        let jacobian = Matrix2::new(
            tangent_u.y - rail.d1 * tangent_u.x,
            -rail.d2 * tangent.x,
            across.dot(&tangent) * (speed * per_cos),
            rail.d2 * (self.metric.m12 * v.x + self.metric.m22 * v.y) - across.dot(&e),
        );
        let [hub, axle, forward, outward, up] = self.ahead;
        let ahead = hub + u * axle + wheel.value * sin * forward - eta * outward - rail.value * up;
        Some(Reading { wheel, rail, sin, cos, residual, jacobian, ahead })
    }

    /// By how much t at the place of a contact turns from the one that is looked along, rad: because the wheel's point is ahead of
    /// the section, and because the rail was read at another `place`.
    #[inline]
    fn turned(&self, ahead: f64, place: &Vector2<f64>) -> f64 {
        let bend = ahead.abs() * self.bend;
        if self.section.is_parallel() {
            return bend;
        }
        let off = place - self.place;
        let change = self.section.turn.cross(&(self.section.outward * off.x + self.section.up * off.y));
        bend + change.cross(&self.along).norm()
    }

    #[inline]
    fn location(&self, pair: &Pair, u: f64, eta: f64, at: &Reading, iterations: usize) -> ContactLocation {
        let section = &self.section;
        let radial = self.forward * at.sin + self.down * at.cos;
        let wheel_point = self.hub + self.axle * u + radial * at.wheel.value;
        let normal = (self.along.cross(&(section.outward + section.up * at.rail.d1)) * pair.rail.side.sign()).normalize();
        let rail_point = section.origin + section.outward * eta + section.up * at.rail.value;
        ContactLocation {
            parameters: SurfaceParameters {
                wheel: u,
                angle: radial.dot(&pair.axes.column(0)).asin(),
                lead: self.lead + at.ahead,
                rail: eta,
            },
            wheel_point,
            normal,
            forward: self.along,
            // t is normal to n: that the rail's point lies behind does not matter.
            penetration: (rail_point - wheel_point).dot(&normal),
            wheel_profile: at.wheel,
            rail_profile: at.rail,
            iterations,
        }
    }
}

/// The contact near `start`; `None` where the iteration does not settle at once.
#[inline]
pub(super) fn locate(pair: &Pair, start: &SurfaceParameters) -> Option<ContactLocation> {
    let profiles = Profiles::of(pair);
    let (mut u, mut eta) = (start.wheel, start.rail);
    let mut points = profiles.at(u, eta);
    let mut sight = Sight::new(pair, start.lead, pair.rail.section(pair.distance + start.lead), Vector2::new(eta, points[1].value));
    let mut last = f64::INFINITY;
    for iteration in 0..MOST {
        let place = Vector2::new(eta, points[1].value);
        let mut at = sight.read(points, u, eta)?;
        let elsewhere = sight.turned(at.ahead, &place) > TURN;
        if elsewhere {
            sight = sight.moved(pair, at.ahead, place);
            at = sight.read(points, u, eta)?;
        }
        let turned = sight.turned(at.ahead, &place) > TURN;
        let norm = at.residual.norm();
        let j = &at.jacobian;
        let per_determinant = 1.0 / (j.m11 * j.m22 - j.m12 * j.m21);
        let step =
            Vector2::new(j.m22 * at.residual.x - j.m12 * at.residual.y, j.m11 * at.residual.y - j.m21 * at.residual.x) * per_determinant;
        let length = step.norm();
        if !turned && (length <= NEXT_STEP || norm <= ROUNDING) {
            return Some(sight.location(pair, u, eta, &at, iteration.max(1)));
        }
        // The residual may grow where it is that of another section.
        if !(length <= LONGEST && (elsewhere || norm < last)) {
            return None;
        }
        (u, eta) = (u - step.x, eta - step.y);
        last = norm;
        points = profiles.at(u, eta);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::test_surfaces::pair;
    use super::*;
    use crate::geometry::Side;
    use crate::geometry::track::centre_line::{Alignment, CentreLine, Node, Pivot};
    use crate::geometry::track::frame::TrackFrame;
    use crate::math::rotation::AxleFrame;
    use proptest::prelude::*;
    use std::sync::Arc;

    /// Some bent, twisted and climbing track, ten times more than any would.
    fn curve() -> Option<Arc<CentreLine>> {
        let node = |distance, curvature, superelevation, grade| Node { distance, curvature, superelevation, grade };
        let nodes = vec![node(-3.0, 0.002, -0.01, 0.0), node(0.0, -0.001, 0.02, 0.05), node(4.0, 0.005, -0.02, -0.04)];
        let alignment = Alignment { nodes, smoothing: 5.0, pivot: Pivot::LowRail { base: 1.5 } };
        CentreLine::new(&alignment, Vector3::new(2.0, -1.0, 0.5), 0.7).map(Arc::new)
    }

    proptest! {
        #[test]
        fn equiv_two_unknowns_find_what_four_equations_find(
            yaw in -0.04..0.04, roll in -0.01..0.01, y in -0.008..0.008, s in -3.0..3.0, off in -2e-4..2e-4,
            left in any::<bool>(), wavy in any::<bool>(), curved in any::<bool>(),
        ) {
            let side = if left { Side::Left } else { Side::Right };
            let (wheel, rail) = pair(side, 0.05, wavy);
            let line = if curved { curve() } else { None };
            let track = line.as_ref().map_or_else(|| TrackFrame { origin: Vector3::new(s, 0.0, 0.0), ..Default::default() }, |line| line.frame(s));
            let rail = rail.along(line);
            let axes = track.axes * AxleFrame::new(yaw, roll).axes;
            let centre = track.origin + track.axes * Vector3::new(0.0, y, 0.457);
            let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: s };
            let exact = pair.solve_four(&SurfaceParameters::default()).unwrap().0;
            let p = exact.parameters;
            let start = SurfaceParameters { wheel: p.wheel + off, lead: p.lead - off, rail: p.rail - 0.5 * off, ..p };
            let found = locate(&pair, &start).unwrap();
            let q = found.parameters;
            let differences = [q.wheel - p.wheel, q.angle - p.angle, q.lead - p.lead, q.rail - p.rail];
            prop_assert!(differences.iter().all(|d| d.abs() < 2e-10), "{differences:?} {} {}", found.iterations, exact.iterations);
            prop_assert!((found.penetration - exact.penetration).abs() < 1e-14, "{:e}", found.penetration - exact.penetration);
            prop_assert!((found.wheel_point - exact.wheel_point).norm() < 1e-9 && (found.normal - exact.normal).norm() < 1e-9);
            prop_assert!((found.forward - exact.forward).norm() < 1e-9);
        }
    }
}
