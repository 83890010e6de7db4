//! Contact search over nodes of the profiles (section 4.2, ECF-N).
//!
//! *Rail section.* Eq. 29 follows the wheel's point Q (centre of the tread circle, on the axle) along the rail; see
//! [`arc_rate`]. The rail's section at that distance s is searched: origin R, tangent t = R'(s), axes o (outward) and p
//! (up). t need not be normal to the section.
//!
//! *Wheel section.* The paper leaves open how the wheel angle is found. Here each wheel node takes the angle at which
//! the wheel's normal is normal to t, where its circle comes nearest to a rail that runs straight along t. With the
//! axle frame's axes X, Y, Z, `S = +1` left and `-1` right, and R(u) the wheel profile:
//!
//! ```text
//! sin(angle) (X.t) - cos(angle) (Z.t) = R'(u) S (Y.t)
//! angle = b + c,   tan b = (Z.t) / (X.t),   sin c = k R'(u),   k = S (Y.t) / sqrt((X.t)^2 + (Z.t)^2)
//! ```
//!
//! *Pairs.* The node is brought into the rail's section along t. That replaces the rail by its tangent: with the
//! node's distance a along the rail the error is `a^2 |R''| / 2` (for a deviation of 10 mm over 10 m, R'' < 2e-3 1/m,
//! and a = 5 mm: 2.5e-8 m; on a flange of slope 3 at 20 mrad yaw a = 27 mm: 7e-7 m). In the section
//!
//! ```text
//! (eta, h) = (e0, h0) + (eY, hY) (u - k^2 R R') + (eD, hD) sqrt(R^2 - (k R R')^2)
//! ```
//!
//! where (e0, h0) is the point Q, (eY, hY) the axle's outward direction and (eD, hD) that of angle b, all brought into
//! the section along t. The gap in height is taken over the tangent at the rail node i nearest in eta, and a node with
//! G < 0 touches:
//!
//! ```text
//! G = h - f_i - f_i' (eta - eta_i)
//! ```
//!
//! Its partner j is the rail node next to the foot of the normal, found by projecting the node on tangents (first on
//! that of i: `eta + f_i' G / (1 + f_i'^2)`), and the penetration is that of the pair: with the rail's unit normal n at j
//! (normal to t and to the profile) and the gap r = r_wheel - r_rail without its part along t
//!
//! ```text
//! delta = -r . n = -(h - f_j - f_j' (eta - eta_j)) / N,   N = |n| when its part along p is 1
//! ```
//!
//! On a tread i and j are the same. On a flank i is `delta f' / sqrt(1 + f'^2)` beside the foot; as partner it would make
//! delta jump by the share `curvature f' sqrt(1 + f'^2) spacing` when it changes (slope 2 in a corner of 13 mm, 0.1 mm
//! spacing: 3 %), where the foot's node leaves a jump of third order in the spacing. A tangent used up to half a spacing d
//! aside costs at most `curvature (1 + f'^2) d^2 / 8` in delta. A wheel node without a rail node within half a spacing in
//! eta has no partner; a node that does not touch is paired with i.
//!
//! *Between nodes.* The contact is where the overlap is deepest (see `between`): nodes tell which humps there are, the profiles where they are.
//!
//! *Batches.* Consecutive wheel nodes with delta > 0; the deepest pair of each is its contact. The paper has two of them at most; here up to four
//! are returned, so that none loses its force where a wheel touches on two places of its tread and on its flange. The one further out (greater u)
//! is first.
//!
//! *Humps.* Where the depth of a batch has several humps (S1002 on 60E1: 10 mm apart, equally deep at y = 0.2 mm), each is a contact, with the
//! saddles between them: with the deepest alone the contact would jump from one to the other. A hump that
//! stands out by less than 1e-3 of the greatest depth is none among nodes (their surfaces are rough by less), and it rises from there: the
//! saddle is taken to be higher by so much. What lies within that flat a top is told by the profiles.
//!
//! *Passing over nodes.* From node to node G changes by at least `-D` (see `Section::fall`), so from a gap G > 0 the
//! next `G / D` nodes cannot touch. Both profiles' bounds enter, so D is the closing slope of the surfaces and not
//! the slope of either.

mod arc_rate;
mod between;
mod plane;
#[cfg(test)]
mod tests;
mod walk;

pub use arc_rate::arc_rate;

use super::algebraic::{ContactLocation, SurfaceParameters};
use super::nodes::{Bounds, NodeError, NodeTable};
use crate::geometry::profile::Profile;
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Rail, RailSection};
use between::{Place, Row};
use nalgebra::{Matrix3, Vector3};
use plane::Section;
use std::sync::Arc;
use walk::{LEAST_HUMP, NodePair, Walk};

/// Rounding of G, m, with a wide margin: a node passed over is at least this far from touching.
const MARGIN: f64 = 1e-12;

/// Wheel nodes without bounds asked for after bounds have gained nothing.
const PATIENCE: usize = 4;

/// Most contacts of one wheel.
pub const MOST: usize = 4;

/// Projections on tangents in search of the foot; each leaves about `curvature delta` of the error before it.
const PROJECTIONS: usize = 4;

/// What a search found.
#[derive(Clone, Copy, Debug)]
pub struct NodalContacts {
    /// The contacts, outer one first. With `count == 0` place 0 holds the pair that comes closest, its penetration not
    /// positive; it is empty only when no wheel node stands above a rail node.
    pub contacts: [Option<ContactLocation>; MOST],
    /// Number of contacts, 0 to [`MOST`].
    pub count: usize,
    /// Penetration at the saddle between each and the next, m, 0 where they belong to different batches.
    pub saddles: [f64; MOST - 1],
    /// Pairs whose gap was evaluated.
    pub evaluated: usize,
    /// Places of the profiles between nodes that were looked at.
    pub looked_at: usize,
    /// Bounds of stretches of nodes that were looked up.
    pub looked_up: usize,
}

/// Nodes of one wheel and its rail, made once.
#[derive(Clone, Debug)]
pub struct NodalSearch {
    wheel: NodeTable,
    rail: NodeTable,
    profiles: [Arc<dyn Profile>; 2],
    half_spacing: f64,
    sign: f64,
}

/// A wheel node in the rail's section: (eta, h), its place among the rail's nodes and the nearest of them.
#[derive(Clone, Copy)]
struct Node {
    eta: f64,
    height: f64,
    place: f64,
    rail: Option<usize>,
}

/// Bounds over a stretch of wheel nodes and the rail below it.
struct Ahead {
    /// Least and greatest change of the place on the rail per wheel node.
    drift: (f64, f64),
    rail: Bounds,
    /// D times the spacing: the most by which G falls per wheel node, m.
    fall: f64,
}

impl NodalSearch {
    /// Nodes of a wheel and its rail, `spacing` [m] apart.
    ///
    /// # Errors
    /// [`NodeError`] when a profile and the spacing give no usable nodes.
    pub fn new(wheel: &Wheel, rail: &Rail, spacing: f64) -> Result<Self, NodeError> {
        Ok(NodalSearch {
            wheel: NodeTable::new(wheel.profile.as_ref(), "wheel", spacing)?,
            rail: NodeTable::new(rail.profile.as_ref(), "rail", spacing)?,
            profiles: [wheel.profile.clone(), rail.profile.clone()],
            half_spacing: wheel.half_spacing,
            sign: wheel.side.sign(),
        })
    }

    /// The wheel's point Q that [`arc_rate`] follows, m.
    #[inline]
    pub fn centre_point(&self, centre: &Vector3<f64>, axes: &Matrix3<f64>) -> Vector3<f64> {
        centre + axes.column(1) * (self.sign * self.half_spacing)
    }

    /// At most `most` contacts of one wheel.
    ///
    /// `centre` [m] and `axes` are the wheelset's position and its frame that does not spin, `distance` [m] its place
    /// along the track (leads count from there), `arc` [m] the rail's distance s and `section` the rail there.
    pub fn search(
        &self,
        centre: &Vector3<f64>,
        axes: &Matrix3<f64>,
        (distance, arc): (f64, f64),
        section: &RailSection,
        most: usize,
    ) -> NodalContacts {
        let plane = self.section(centre, axes, section);
        let walk = self.walked(&plane);
        let Row { places, saddles, looked_at } = self.row(&walk, &plane, most);
        NodalContacts {
            count: places.iter().flatten().filter(|place| place[2] > 0.0).count(),
            contacts: places.map(|place| place.map(|place| self.location(place, &plane, centre, axes, (distance, arc), section))),
            saddles,
            evaluated: walk.evaluated,
            looked_at,
            looked_up: walk.looked_up,
        }
    }

    /// The humps of nodes that touch; where nothing touches the pair that comes closest.
    fn walked(&self, plane: &Section) -> Walk {
        let mut walk = Walk::default();
        self.walk(plane, &mut walk);
        if walk.humps.is_empty() {
            // Nothing touches: once more, for the pair that comes closest.
            walk.closest_wanted = true;
            self.walk(plane, &mut walk);
        }
        walk.humps.settle(MOST, LEAST_HUMP);
        walk
    }

    /// Axes, angle and normals of the rail's section as this wheel sees it.
    fn section(&self, centre: &Vector3<f64>, axes: &Matrix3<f64>, section: &RailSection) -> Section {
        let t = &section.d1;
        let (outward, up) = (&section.outward, &section.up);
        let across = outward.cross(up);
        let along = across.dot(t);
        let flat = |v: &Vector3<f64>| {
            let ahead = across.dot(v) / along;
            (outward.dot(v) - ahead * outward.dot(t), up.dot(v) - ahead * up.dot(t))
        };
        let (x, y, z) = (axes.column(0), axes.column(1) * self.sign, axes.column(2));
        let (xt, zt) = (x.dot(t), z.dot(t));
        let length = xt.hypot(zt);
        let turn = y.dot(t) / length;
        Section {
            turn,
            turn2: turn * turn,
            base: flat(&(centre + y * self.half_spacing - section.origin)),
            axle: flat(&y),
            down: flat(&((x * zt - z * xt) / length)),
            angle: zt.atan2(xt),
            lean: (-up.dot(t) / along, outward.dot(t) / along),
        }
    }

    /// Height of a wheel node over the tangent at a rail node, m.
    #[inline]
    fn gap(&self, rail: usize, node: &Node) -> f64 {
        let f = self.rail.point(rail);
        node.height - f.value - f.d1 * (node.eta - self.rail.coordinate(rail))
    }

    /// Place of a wheel node in the section and among the rail's nodes.
    #[inline]
    fn node(&self, plane: &Section, index: usize) -> Option<Node> {
        let wheel = self.wheel.point(index);
        let (eta, height) = plane.place(self.wheel.coordinate(index), wheel.value, wheel.d1)?;
        let place = self.rail.place(eta);
        let over_rail = place >= -0.5 && place < self.rail.count() as f64 - 0.5;
        let rail = over_rail.then(|| self.rail.nearest(place));
        Some(Node { eta, height, place, rail })
    }

    /// Partner of a touching node and the node's depth under the partner's tangent, m, from the nearest rail node and the
    /// gap there: the node is projected on the tangent until it falls next to the tangent's own node.
    #[inline]
    fn foot(&self, nearest: usize, mut gap: f64, node: &Node) -> (usize, f64) {
        let mut rail = nearest;
        for _ in 0..PROJECTIONS {
            let slope = self.rail.point(rail).d1;
            let eta = node.eta + slope * gap / (1.0 + slope * slope);
            // On a tread the first guess holds; asking is cheaper than looking up.
            if (eta - self.rail.coordinate(rail)).abs() <= 0.5 * self.rail.spacing {
                break;
            }
            rail = self.rail.nearest(self.rail.place(eta));
            gap = self.gap(rail, node);
        }
        (rail, -gap)
    }

    /// Visits every wheel node that a bound does not exclude.
    fn walk(&self, plane: &Section, walk: &mut Walk) {
        let nodes = self.wheel.count();
        let mut level = self.wheel.top();
        let mut ask = 0;
        let mut index = 0;
        while index < nodes {
            let Some(node) = self.node(plane, index) else {
                index += 1;
                continue;
            };
            let mut gap = f64::NAN;
            if let Some(rail) = node.rail {
                gap = self.gap(rail, &node);
                if gap < 0.0 {
                    index = self.batch(plane, walk, index);
                    continue;
                }
                walk.evaluated += 1;
                walk.apart(NodePair { wheel: index, rail, penetration: -gap / plane.norm2(self.rail.point(rail).d1).sqrt() });
            }
            let mut passed = 0;
            if index >= ask {
                passed = self.pass(plane, walk, index, node.place, gap, &mut level);
                if passed == 0 {
                    ask = index + PATIENCE;
                }
            }
            index += 1 + passed;
        }
    }

    /// Takes the batch that begins at the wheel node `begin`; returns the node after its last.
    fn batch(&self, plane: &Section, walk: &mut Walk, begin: usize) -> usize {
        walk.humps.part();
        let mut index = begin;
        while index < self.wheel.count()
            && let Some(node) = self.node(plane, index)
            && let Some(nearest) = node.rail
        {
            let gap = self.gap(nearest, &node);
            if !(gap < 0.0) {
                break;
            }
            let (foot, below) = self.foot(nearest, gap, &node);
            // Between two nodes the two tangents may differ in their last digits about whether anything touches.
            if below > 0.0 {
                walk.humps.pass(below / plane.norm2(self.rail.point(foot).d1).sqrt(), (index, foot));
            }
            index += 1;
        }
        walk.evaluated += index - begin;
        index
    }

    /// What is known about the stretch of `level` that begins at a wheel node; `None` when the wheel is too steep for its
    /// yaw.
    #[inline]
    fn ahead(&self, plane: &Section, index: usize, place: f64, level: usize) -> Option<Ahead> {
        let length = NodeTable::stretch(level);
        let steps = plane.steps(&self.wheel.bounds(index as f64, (index + length - 1) as f64, level))?;
        let drift = plane.drift(&steps);
        let reach = length as f64;
        let rail = self.rail.bounds(place + reach * drift.0.min(0.0), place + reach * drift.1.max(0.0), level);
        Some(Ahead { drift, rail, fall: plane.fall(&steps, &rail) * self.wheel.spacing })
    }

    /// Number of wheel nodes after `index` that have no partner or cannot touch (or come closer than the closest pair so
    /// far). `gap` is NaN at a node that stands beside the rail.
    fn pass(&self, plane: &Section, walk: &mut Walk, index: usize, place: f64, gap: f64, level: &mut usize) -> usize {
        let last = self.rail.count() as f64 - 1.0;
        loop {
            walk.looked_up += 1;
            let length = NodeTable::stretch(*level);
            let reach = length as f64;
            let mut passed = 0;
            if let Some(ahead) = self.ahead(plane, index, place, *level) {
                let free = if gap.is_nan() {
                    // Distance to the rail's nearer end over the speed toward it.
                    let (beside, speed) = if place < 0.0 { (-0.5 - place, ahead.drift.1) } else { (place - last - 0.5, -ahead.drift.0) };
                    if speed > 0.0 { (beside - MARGIN / self.rail.spacing) / speed } else { reach }
                } else {
                    let spare = gap - 2.0 * ahead.rail.misfit - walk.least_gap(plane, &ahead.rail) - MARGIN;
                    if spare < 0.0 {
                        0.0
                    } else if ahead.fall > 0.0 {
                        spare / ahead.fall
                    } else {
                        reach
                    }
                };
                // A cast of a negative number gives 0.
                passed = free.min(reach) as usize;
            }
            if passed == length && *level < self.wheel.top() {
                *level += 1;
            }
            if 2 * passed >= length || *level == 0 {
                return passed;
            }
            *level -= 1;
        }
    }

    /// Everything that the laws of contact need from a place.
    fn location(
        &self,
        [u, eta, penetration]: Place,
        plane: &Section,
        centre: &Vector3<f64>,
        axes: &Matrix3<f64>,
        (distance, arc): (f64, f64),
        section: &RailSection,
    ) -> ContactLocation {
        let [wheel, rail] = [self.profiles[0].at(u), self.profiles[1].at(eta)];
        let angle = plane.angle + (plane.turn * wheel.d1).asin();
        let (sin, cos) = angle.sin_cos();
        let radial = axes.column(0) * sin - axes.column(2) * cos;
        let wheel_point = self.centre_point(centre, axes) + axes.column(1) * (self.sign * u) + radial * wheel.value;
        let across = section.outward.cross(&section.up);
        let ahead = across.dot(&(wheel_point - section.origin)) / across.dot(&section.d1);
        let lean = plane.lean.0 + plane.lean.1 * rail.d1;
        ContactLocation {
            parameters: SurfaceParameters { wheel: u, angle, lead: arc + ahead - distance, rail: eta },
            wheel_point,
            normal: (section.up - section.outward * rail.d1 + across * lean) / plane.norm2(rail.d1).sqrt(),
            forward: section.d1,
            penetration,
            wheel_profile: wheel,
            rail_profile: rail,
            iterations: 0,
        }
    }
}
