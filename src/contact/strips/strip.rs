//! A strip of the rail's surface along the track, and the wheel over it.
//!
//! A strip is the line `P(x) = P + T x + T' x^2 / 2` of one rail coordinate, x ahead of the wheelset's centre, with the rail's normal n. The wheel of
//! revolution about its axle (direction e) is met at `P(x) - n d`, where
//!
//! ```text
//! F = rho - R(u) = 0,    u: coordinate along the axle, rho: distance from it, r: unit vector from the axle
//! F_d = R' n.e - n.r,    F_x = r.T - R' T.e,    F_xx = (T.T - (T.e)^2 - (T.r)^2) / rho + r.T' - R'' (T.e)^2 - R' T'.e
//! ```
//!
//! The overlap d(x) is greatest where F_x = 0: `lead`. There it bends by `-F_xx / F_d`. Yaw, roll and a rail that is bent along the track are in it;
//! what it leaves out is x^3: 1e-8 m at 10 mm of a yaw of 10 mrad. Where a rail bends sideways sharply the line is that about the strip's own place ahead.

use crate::contact::search::algebraic::Pair;
use crate::geometry::profile::ProfilePoint;
use crate::geometry::track::rail_surface::rail_point_of;
use nalgebra::Vector3;

const ITERATIONS: usize = 8;
/// Changes of overlap and lead, m, after which the next iteration would change the overlap by 1e-13 m: it converges quadratically (profiles bend by
/// up to 100 1/m), and the overlap is stationary in the lead.
const NEXT_OVERLAP: f64 = 3e-8;
const NEXT_LEAD: f64 = 1e-6;

/// The rail's section at one place along the track: affine in the coordinate and the height of its profile.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Of the base point, along the coordinate, along the height: position and its first two derivatives along the track.
    base: [Vector3<f64>; 3],
    outward: [Vector3<f64>; 3],
    up: [Vector3<f64>; 3],
    side: f64,
}

impl Section {
    /// Of the rail of `pair` beside the wheelset's centre.
    pub fn new(pair: &Pair) -> Section {
        Section::ahead(pair, 0.0)
    }

    /// Of the rail at a `station` [m] ahead of it; places are counted from there.
    pub(super) fn ahead(pair: &Pair, station: f64) -> Section {
        let at = |eta: f64, value: f64| {
            let point = rail_point_of(pair.rail, pair.distance + station, eta, &ProfilePoint { value, ..ProfilePoint::default() });
            [point.position - pair.centre, point.t1, point.t11]
        };
        let base = at(0.0, 0.0);
        let from = |end: [Vector3<f64>; 3]| std::array::from_fn(|k| end[k] - base[k]);
        Section { base, outward: from(at(1.0, 0.0)), up: from(at(0.0, 1.0)), side: pair.rail.side.sign() }
    }

    /// Origin of the section x [m] ahead of the wheelset's centre, from there, tangent of the rail, not unit, and directions outward and up.
    pub fn at(&self, x: f64) -> [Vector3<f64>; 4] {
        let [[place, tangent, bend], [outward, twist, _], [up, tilt, _]] = [self.base, self.outward, self.up];
        [place + (tangent + bend * (0.5 * x)) * x, tangent + bend * x, outward + twist * x, up + tilt * x]
    }

    /// How the rail is bent along the track, 1/m.
    pub fn bend(&self) -> &Vector3<f64> {
        &self.base[2]
    }

    /// How the wheelset goes with the rail, for each metre along the track: by how much its centre moves, and turns, 1/m, if it turns with the rail's
    /// direction and its section.
    pub fn course(&self) -> (Vector3<f64>, Vector3<f64>) {
        let [place, tangent, bend] = self.base;
        let along = tangent.normalize();
        let [outward, twist, _] = self.outward;
        let turning = along.cross(&bend) / tangent.norm() + along * along.dot(&outward.cross(&twist));
        (tangent - turning.cross(&place), turning)
    }
}

/// A strip with the wheel over it, at its deepest place.
#[derive(Clone, Copy, Debug, Default)]
pub struct Strip {
    /// Largest overlap, m; negative: a gap.
    pub overlap: f64,
    /// Where it is, ahead of the wheelset's centre along the track, m.
    pub lead: f64,
    /// How it falls off: d = overlap - curvature x^2 / 2, 1/m.
    pub curvature: f64,
    /// On the rail, from the wheelset's centre, m.
    pub point: Vector3<f64>,
    /// Forward along the rail, about unit, and out of it, unit.
    pub forward: Vector3<f64>,
    pub normal: Vector3<f64>,
    /// Normal of the wheel, as long as its part along the rail's normal is 1: the overlap changes by `-against . v` where the wheel's material moves by v.
    pub against: Vector3<f64>,
    /// Of the wheel there.
    pub wheel: f64,
    pub radius: f64,
    pub slope: f64,
}

impl Strip {
    /// The strip at the rail coordinate `eta`, where the rail's profile is `profile`, looked for from about where it is (lead and overlap, m); `None` where
    /// the wheel is not met near by.
    #[inline]
    pub fn new(pair: &Pair, section: &Section, (eta, profile): (f64, &ProfilePoint), about: (f64, f64)) -> Option<Strip> {
        let line: [Vector3<f64>; 3] = std::array::from_fn(|k| section.base[k] + section.outward[k] * eta + section.up[k] * profile.value);
        let across = section.outward[0] + section.up[0] * profile.d1;
        let normal = (line[1].cross(&across) * section.side).normalize();
        let axle = pair.axes.column(1) * pair.wheel.side.sign();
        let along = normal.dot(&axle);
        let (first, last) = pair.wheel.profile.range();
        let (mut lead, mut overlap) = about;
        for _ in 0..ITERATIONS {
            let point = line[0] + (line[1] + line[2] * (0.5 * lead)) * lead;
            let tangent = line[1] + line[2] * lead;
            let from = point - normal * overlap;
            let axial = from.dot(&axle);
            let radial = from - axle * axial;
            let rho = radial.norm();
            let outward = radial / rho;
            let u = axial - pair.wheel.half_spacing;
            let wheel = pair.wheel.profile.at(u);
            let (turning, sideways) = (tangent.dot(&outward), tangent.dot(&axle));
            let by_overlap = wheel.d1 * along - normal.dot(&outward);
            let by_lead = turning - wheel.d1 * sideways;
            let bend = (tangent.norm_squared() - sideways * sideways - turning * turning) / rho + line[2].dot(&outward)
                - wheel.d2 * sideways * sideways
                - wheel.d1 * line[2].dot(&axle);
            // The normal must look at the axle, and the wheel must part from the rail ahead and behind.
            if !(by_overlap > 0.0 && bend > 0.0 && (first..=last).contains(&u)) {
                return None;
            }
            let (ahead, deeper) = (-by_lead / bend, (wheel.value - rho + 0.5 * by_lead * by_lead / bend) / by_overlap);
            lead += ahead;
            overlap += deeper;
            if !(overlap.abs() < FAR_ON_THE_WAY && lead.abs() < FAR_AHEAD) {
                return None;
            }
            if ahead.abs() < NEXT_LEAD && deeper.abs() < NEXT_OVERLAP {
                if overlap.abs() > FAR {
                    return None;
                }
                let curvature = bend / by_overlap;
                let against = (axle * wheel.d1 - outward) / by_overlap;
                return Some(Strip {
                    overlap,
                    lead,
                    curvature,
                    point: point + tangent * ahead,
                    forward: tangent,
                    against,
                    normal,
                    wheel: u,
                    radius: wheel.value,
                    slope: wheel.d1,
                });
            }
        }
        None
    }
}

/// Beyond these distances [m] nothing is looked for.
const FAR: f64 = 6e-3;
const FAR_ON_THE_WAY: f64 = 3e-2;
const FAR_AHEAD: f64 = 0.2;
