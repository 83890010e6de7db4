//! What a normal law may ask of the surfaces at a contact: their curvatures there, and how far they part beside it.
//!
//! Both profiles are cut by the plane of the rail's section. Each is read in the frame of its own tangent at the contact, t
//! along the tangent (outward positive), h along the rail's normal; slope p and `c = 1 / sqrt(1 + p^2)` there. At x0 + c t
//! the profile's value has changed by dy, its slope is y', and
//!
//! ```text
//! t' = t + p h',   h' = c (dy - p c t),   dh/dt = (y' - p) / T,   T = 1 + p y'
//! h(t) = h' - (t' - t) (dh/dt - k (t' - t) / 2),   dh/dt at t = dh/dt - k (t' - t),   k = (4 dh/dt - 6 h' / t) / t
//! ```
//!
//! where k is the curvature at t' of the cubic from the contact to there that has the same value and slope: an error of third order in
//! the distance t' - t where the curvature is constant. At the contact the tangents are parallel, so the frames fall together and the
//! gap of the undeformed profiles along the normal is `g(t) = -h_wheel(t) - h_rail(t)`, with `g(0) = g'(0) = 0` and `g''(0) = 2 B`. The
//! wheel turned by a yaw angle shows the section a profile that is wider by 1 / cos(yaw): 2e-4 of t at 20 mrad, left out. Where
//! tangents are parallel only to a nodal search's spacing, they are taken as parallel.

use super::overlap::{Depths, Overlap};
use crate::geometry::profile::{Along, Bend, Profile, ProfilePoint};

/// A profile and the place of the contact on it.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    pub profile: &'a dyn Profile,
    /// u or eta of the contact, m.
    pub at: f64,
    /// The profile there.
    pub point: ProfilePoint,
}

/// The surfaces at one contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactShape<'a> {
    /// Half the relative principal curvature A along e1 at the contact, 1/m.
    pub rolling: f64,
    /// The same along e2, B, 1/m.
    pub across: f64,
    sections: Option<[Section<'a>; 2]>,
}

/// Wheel and rail at the distance t from a contact, along their tangents.
trait Read {
    /// Slope [-] per slope as it is read.
    fn unit(&self) -> [f64; 2];
    /// Values [m] and slopes; NaN where [`Profile::at`] must be asked.
    fn at(&self, t: f64) -> ([f64; 2], [f64; 2]);
}

impl Read for Along<'_> {
    #[inline(always)]
    fn unit(&self) -> [f64; 2] {
        self.unit
    }
    #[inline(always)]
    fn at(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        self.read(t)
    }
}

/// Profiles of any kind: coordinates of the contact, and dx/dt.
struct Any<'a> {
    profiles: [&'a dyn Profile; 2],
    at: [f64; 2],
    along: [f64; 2],
}

impl Read for Any<'_> {
    #[inline]
    fn unit(&self) -> [f64; 2] {
        [1.0; 2]
    }
    #[inline]
    fn at(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        let [wheel, rail] = [0, 1].map(|i| self.profiles[i].value_and_slope(self.at[i] + self.along[i] * t));
        ([wheel.0, rail.0], [wheel.1, rail.1])
    }
}

/// Wheel and rail beside a contact, on one side of it, each in the frame of its tangent. Seen from the contact t > 0 on either side.
struct Gap<'a, R> {
    sections: &'a [Section<'a>; 2],
    read: R,
    value: [f64; 2],
    cos: [f64; 2],
    /// dx/dt and dy/dt on the tangents, p.
    along: [f64; 2],
    rise: [f64; 2],
    slope: [f64; 2],
    /// Slope and p y' per slope as it is read.
    unit: [f64; 2],
    per_unit: [f64; 2],
    turn: [f64; 2],
}

/// Profiles that have turned against their tangents by more than NEAR together (sum of the tangents of the angles) are found exactly at the distance t;
/// up to there and NEARER the closed form is used, between them a mean that leads from one to the other.
const NEARER: f64 = 0.2;
const NEAR: f64 = 0.4;
/// A surface that has turned by these tangents of angles (50 and 70 degrees) faces another way: it is not of this patch. The gap is
/// widened from the first one, by WIDENED [m] at the middle, and is infinite at the second.
const TURNING: f64 = 1.2;
const TURNED: f64 = 2.75;
const WIDENED: f64 = 1e-3;
/// Where a profile is found at a distance: the last step [m], steps, and the least dt/dx times c.
const SETTLED: f64 = 1e-14;
const STEPS: usize = 60;
const LEAST_TURN: f64 = 1e-3;

/// From 0 to 1 without a slope at either end, for a share between them.
#[inline(always)]
fn blend(share: f64) -> f64 {
    share * share * (3.0 - 2.0 * share)
}

// Both profiles side by side, so that the compiler makes vector instructions of it.
impl<'a, R: Read> Gap<'a, R> {
    #[inline(always)]
    fn new(sections: &'a [Section<'a>; 2], side: f64, cos: [f64; 2], read: R) -> Self {
        let slope = sections.each_ref().map(|section| section.point.d1);
        let unit = read.unit();
        let along = cos.map(|cos| side * cos);
        Gap {
            sections,
            read,
            value: sections.each_ref().map(|section| section.point.value),
            cos,
            along,
            rise: [slope[0] * along[0], slope[1] * along[1]],
            slope: slope.map(|p| side * p),
            unit: unit.map(|unit| side * unit),
            per_unit: unit.map(|unit| 1.0 / unit),
            turn: [slope[0] * unit[0], slope[1] * unit[1]],
        }
    }

    /// The gap [m] and its slope dg/dt at the distance t > 0, from values and slopes there; and by how much the profiles have turned, infinite
    /// or NaN where curves must be read.
    #[inline(always)]
    fn of(&self, t: f64, (values, slopes): ([f64; 2], [f64; 2])) -> (f64, f64, f64) {
        let per_t = 1.0 / t;
        let high = [0, 1].map(|i| (values[i] - self.value[i] - self.rise[i] * t) * self.cos[i]);
        let turned = [1.0 + self.turn[0] * slopes[0], 1.0 + self.turn[1] * slopes[1]].map(|turn| if turn > 0.0 { turn } else { 0.0 });
        let climb = [0, 1].map(|i| (slopes[i] * self.unit[i] - self.slope[i]) / turned[i]);
        let off = [0, 1].map(|i| self.slope[i] * high[i]);
        let bent = [0, 1].map(|i| (4.0 * climb[i] - 6.0 * per_t * high[i]) * per_t * off[i]);
        let [wheel, rail] = [0, 1].map(|i| high[i] - off[i] * (climb[i] - 0.5 * bent[i]));
        let [down, fall] = [0, 1].map(|i| climb[i] - bent[i]);
        (-(wheel + rail), -(down + fall), climb[0].abs() + climb[1].abs())
    }

    /// The gap [m] and its slope at t > 0, where a bend of wheel or rail may be; `None` where a profile has turned away.
    #[inline(always)]
    fn at(&self, t: f64, bends: [Option<&Bend>; 2]) -> Option<(f64, f64)> {
        let (mut values, mut slopes) = self.read.at(t);
        for i in 0..2 {
            if let Some(bend) = bends[i] {
                (values[i], slopes[i]) = (bend.value, bend.slope * self.per_unit[i]);
            }
        }
        let found = self.of(t, (values, slopes));
        if found.2 < NEARER { Some((found.0, found.1)) } else { self.turned(t, found) }
    }

    /// The same where profiles have turned, or must be read from their curves.
    #[cold]
    #[inline(never)]
    fn turned(&self, t: f64, mut found: (f64, f64, f64)) -> Option<(f64, f64)> {
        if found.2.is_nan() {
            let read = [0, 1].map(|i| self.sections[i].profile.value_and_slope(self.sections[i].at + self.along[i] * t));
            found = self.of(t, (read.map(|(value, _)| value), [0, 1].map(|i| read[i].1 * self.per_unit[i])));
        }
        let (near, opening_near, turned) = found;
        if turned < NEARER {
            return Some((near, opening_near));
        }
        let [wheel, rail] = [self.foot(0, t)?, self.foot(1, t)?];
        let (mut gap, mut opening) = (-(wheel.0 + rail.0), -(wheel.1 + rail.1));
        if turned < NEAR {
            let share = (turned - NEARER) / (NEAR - NEARER);
            let exact = blend(share);
            (gap, opening) = (near + exact * (gap - near), opening_near + exact * (opening - opening_near));
        }
        for (_, climb) in [wheel, rail] {
            let beyond = (climb.abs() - TURNING) / (TURNED - TURNING);
            if beyond >= 1.0 {
                return None;
            }
            if beyond > 0.0 {
                gap += 2.0 * WIDENED * beyond * beyond / (1.0 - beyond);
            }
        }
        Some((gap, opening))
    }

    /// Height [m] and slope over its tangent of a profile at the distance t along that, on the branch that begins at the contact; `None` where that turns back
    /// before. With x measured from the contact towards t, `t'(x) = c (x + p (y - y0))`, `dt'/dx = c (1 + p y')`: Newton's method between bounds.
    fn foot(&self, i: usize, t: f64) -> Option<(f64, f64)> {
        let (Section { profile, at, point }, side) = (&self.sections[i], self.along[i].signum());
        let (cos, slope) = (self.cos[i], self.slope[i]);
        let (mut low, mut high, mut x) = (0.0, f64::INFINITY, cos * t);
        for _ in 0..STEPS {
            let (value, read) = profile.value_and_slope(at + side * x);
            let (rise, steep) = (value - point.value, side * read);
            let (short, turn) = (t - cos * (x + slope * rise), 1.0 + slope * steep);
            // Beyond a place where it turns back all distances are another branch's.
            if turn < LEAST_TURN || short < 0.0 {
                high = x
            } else {
                low = x
            }
            let step = short / (cos * turn);
            if turn >= LEAST_TURN && step.abs() <= SETTLED {
                return Some((cos * (rise - slope * x), (steep - slope) / turn));
            }
            let next = x + step;
            x = if turn >= LEAST_TURN && next > low && next < high { next } else { 0.5 * (low + high.min(2.0 * x)) };
        }
        None
    }
}

/// Distances of the nodes, which the end of the reach measures on a level tread. Patches of S1002 on 60E1 end at 0.01 to 0.16.
static NODES: [f64; 19] = [0.04, 0.09, 0.15, 0.25, 0.4, 0.7, 1.0, 1.5, 2.3, 3.5, 5.0, 8.0, 12.0, 20.0, 32.0, 50.0, 80.0, 130.0, 200.0];
/// Nodes are closer on a slope p, by 1 + STEEP p^2 for wheel and rail together: gauge corner and flange have small radii.
const STEEP: f64 = 20.0;
/// Share of the first node's distance below which two nodes are one. A bend that is left out so near the contact is felt in proportion
/// to its distance, so this is small: 1e-10 m, 1e-8 of the integral; rounding of the gap, 1e-16 m, is still far below.
const CLOSE: f64 = 2e-8;

impl<'a> ContactShape<'a> {
    #[inline]
    pub fn new(rolling: f64, across: f64, wheel: Section<'a>, rail: Section<'a>) -> Self {
        ContactShape { rolling, across, sections: Some([wheel, rail]) }
    }

    /// Surfaces whose half relative curvatures A and B are the same all over the patch.
    pub fn of_constant_curvature(rolling: f64, across: f64) -> Self {
        ContactShape { rolling, across, sections: None }
    }

    /// For the side of t < 0 and that of t > 0 the mean depth of the overlap, in the form
    ///
    /// ```text
    /// integral over |t| of (1 - G / L)^2 where G < L,   G(t) = the largest g between the contact and t [m]
    /// ```
    ///
    /// with L = `level` > 0 [m], above the same of 1 - G / L. `None` for a side on which the profiles have not parted by L / 4 within `reach` [m]. G instead of g
    /// lets a second place of contact beyond a ridge count as little as the ridge is low under L.
    ///
    /// Gap and slope are read at nodes that depend on `reach` and on the slope at the contact alone, and at the profiles' bends;
    /// [`super::overlap`] integrates the cubics between them. No node depends on where L is reached, so the integral is as smooth in
    /// the pose as the gap, whether two places of contact join or part.
    #[inline]
    pub(super) fn overlap(&self, level: f64, reach: f64) -> [Option<Depths>; 2] {
        match &self.sections {
            None => {
                let t = (level / self.across).sqrt();
                // NaN of a hollow shape is not within reach.
                [(0.5 * t <= reach).then(|| Depths::new(8.0 / 15.0 * t, 2.0 / 3.0 * t)); 2]
            }
            Some(sections) => {
                let cos = sections.each_ref().map(|section| 1.0 / (1.0 + section.point.d1 * section.point.d1).sqrt());
                let at = sections.each_ref().map(|section| section.at);
                let profiles = sections.each_ref().map(|section| section.profile);
                let bends = [0, 1].map(|i| Bends::new(profiles[i].bends(), at[i]));
                let both = (profiles[0].piecewise(), profiles[1].piecewise());
                [-1.0, 1.0].map(|side| {
                    let along = cos.map(|cos| side * cos);
                    match both {
                        (Some(w), Some(r)) => one_side(&Gap::new(sections, side, cos, Along::new([w, r], at, along)), bends, level, reach),
                        _ => one_side(&Gap::new(sections, side, cos, Any { profiles, at, along }), bends, level, reach),
                    }
                })
            }
        }
    }
}

/// The bends of a profile before and behind a contact.
#[derive(Clone, Copy)]
struct Bends<'a> {
    before: &'a [Bend],
    behind: &'a [Bend],
}

impl<'a> Bends<'a> {
    #[inline]
    fn new(all: &'a [Bend], at: f64) -> Self {
        let count = all.iter().take_while(|bend| bend.at <= at).count();
        let (before, behind) = all.split_at(count);
        Bends { before, behind }
    }

    /// Takes the next one on a side.
    #[inline(always)]
    fn next(&mut self, side: f64) -> Option<&'a Bend> {
        let rest = if side > 0.0 { self.behind.split_first() } else { self.before.split_last() };
        let (next, rest) = rest?;
        *(if side > 0.0 { &mut self.behind } else { &mut self.before }) = rest;
        Some(next)
    }
}

/// One side of [`ContactShape::overlap`].
#[inline(never)]
fn one_side<R: Read>(gap: &Gap<R>, mut bends: [Bends; 2], level: f64, reach: f64) -> Option<Depths> {
    let unit = reach / (1.0 + STEEP * (gap.slope[0] * gap.slope[0] + gap.slope[1] * gap.slope[1]));
    // Slopes beyond all measure (a spike among measured points) leave nothing to go by.
    if !(unit > 0.0 && unit.is_finite()) {
        return None;
    }
    let (per_level, close) = (1.0 / level, CLOSE * NODES[0] * unit);
    let mut overlap = Overlap::new();
    let mut from = 0.0;
    // A gap that can't be read is very wide.
    let depth =
        |open: Option<(f64, f64)>| open.map_or((f64::NEG_INFINITY, 0.0), |(open, opening)| (1.0 - open * per_level, -opening * per_level));
    // A bend whose distance is no number is none.
    let distance = |i: usize, bend: Option<&Bend>| {
        let away = bend.map_or(f64::INFINITY, |bend| (bend.at - gap.sections[i].at) / gap.along[i]);
        if away.is_nan() { f64::INFINITY } else { away }
    };
    let mut next = [0, 1].map(|i| bends[i].next(gap.along[i]));
    let mut bent = [0, 1].map(|i| distance(i, next[i]));
    for &share in &NODES {
        let node = share * unit;
        loop {
            let (mut t, mut here) = (node, [None; 2]);
            if bent[0] <= node || bent[1] <= node {
                t = if bent[0] < bent[1] { bent[0] } else { bent[1] };
                for i in 0..2 {
                    if t == bent[i] {
                        here[i] = next[i];
                        next[i] = bends[i].next(gap.along[i]);
                        bent[i] = distance(i, next[i]);
                    }
                }
            }
            if t - from > close {
                let node = depth(gap.at(t, here));
                if node.0 <= 1.0 - NARROW {
                    return Some(last_interval(gap, overlap, (from, t), node, depth));
                }
                if overlap.add(t - from, node) {
                    return Some(overlap.sum);
                }
                from = t;
            }
            if t == node {
                break;
            }
        }
        if node >= reach && overlap.depth > 0.75 {
            return None;
        }
    }
    Some(overlap.sum)
}

/// An interval at whose end the gap is more than NARROW L is halved; from there on its whole gives way to its halves, until the gap is
/// WIDE L, so that nothing jumps.
const NARROW: f64 = 10.0;
const WIDE: f64 = 20.0;
const HALVINGS: usize = 8;

/// The integral up to its end, which lies in an interval; `node` is the depth at the interval's end and its slope.
#[inline(never)]
fn last_interval<R: Read>(
    gap: &Gap<R>,
    mut overlap: Overlap,
    (mut from, mut to): (f64, f64),
    mut node: (f64, f64),
    depth: impl Fn(Option<(f64, f64)>) -> (f64, f64),
) -> Depths {
    let (mut sum, mut rest) = (Depths::zeros(), 1.0);
    for _ in 0..HALVINGS {
        let share = (1.0 - node.0 - NARROW) * (1.0 / (WIDE - NARROW));
        if share < 1.0 {
            let mut whole = overlap;
            whole.add(to - from, node);
            if share <= 0.0 {
                return sum + rest * whole.sum;
            }
            let halved = blend(share);
            sum += rest * (1.0 - halved) * whole.sum;
            rest *= halved;
        }
        let middle = 0.5 * (from + to);
        let found = depth(gap.at(middle, [None; 2]));
        if found.0 <= 0.0 {
            (to, node) = (middle, found);
        } else if overlap.add(middle - from, found) {
            break;
        } else {
            from = middle;
        }
    }
    sum + rest * overlap.sum
}
