//! The rail's section as a curve that points are measured from.
//!
//! The foot of a point C is where the curve's tangent T is normal to C - P: `sigma(x) = (C - P(x)) . T(x)` changes from plus
//! to minus there. At a convex kink every direction between both sides' is a tangent. Beyond its ends the curve goes on
//! straight. The foot is found by walking from a guess, so it is the near one where a hollow rail offers several; at concave
//! kinks, where two always compete, the nearer wins.

use super::curve::{Bounds, Curve};
use super::motion::{MOST_STEADY, SWAY, less, more};
use crate::geometry::profile::Profile;
use nalgebra::Vector2;

/// Length, m, by which a stretch of rail is widened on both sides when bounds are asked for: feet may move that far.
pub(super) const SLACK: f64 = SWAY * MOST_STEADY;

/// Greatest slope at which a rail is looked at; no wheel's flank gets there.
const STEEPEST_RAIL_SEEN: f64 = 25.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Stretch (whole part) and share of it; below 0 and above the number of stretches on the straight continuations.
    pub place: f64,
    /// Signed distance, m, positive outside the rail.
    pub distance: f64,
    /// Direction of the tangent, rad.
    pub angle: f64,
}

/// A foot on the profile itself instead of its knots.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExactFoot {
    pub eta: f64,
    pub distance: f64,
    /// Unit tangent.
    pub tangent: Vector2<f64>,
}

/// Bounds over stretches of rail.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facing {
    pub angle: (f64, f64),
    pub curvature: (f64, f64),
}

#[derive(Clone, Debug)]
pub(super) struct RailCurve {
    pub curve: Curve,
    /// First and last stretch within [`SLACK`] of a stretch.
    reach: Vec<(u32, u32)>,
    /// Bounds of 1, 2, 4 ... stretches from each on.
    levels: Vec<Vec<Facing>>,
    /// Concave kinks.
    hollows: Vec<usize>,
    /// Knots at which the curvature jumps while the direction does not.
    pub joints: Vec<usize>,
    /// Length of the curve up to each knot, m.
    lengths: Vec<f64>,
}

impl RailCurve {
    pub fn new(profile: &dyn Profile) -> Self {
        let curve = Curve::new(profile, 1.0, STEEPEST_RAIL_SEEN);
        let mut lengths = vec![0.0];
        let mut length = 0.0;
        for stretch in &curve.stretches {
            length += stretch.length;
            lengths.push(length);
        }
        let count = curve.stretches.len();
        // Both ends of the reach only move forward.
        let (mut first, mut last) = (0, 0);
        let reach = (0..count)
            .map(|i| {
                while first < i && lengths[i] - lengths[first + 1] >= SLACK {
                    first += 1;
                }
                last = last.max(i);
                while last + 1 < count && lengths[last + 1] - lengths[i + 1] < SLACK {
                    last += 1;
                }
                (first as u32, last as u32)
            })
            .collect();
        let mut levels: Vec<Vec<Facing>> =
            vec![curve.stretches.iter().map(|b| Facing { angle: b.angle, curvature: b.curvature }).collect()];
        let mut width = 1;
        while 2 * width <= count {
            let below = &levels[levels.len() - 1];
            let level = (0..=count - 2 * width).map(|i| below[i].merge(&below[i + width])).collect();
            levels.push(level);
            width *= 2;
        }
        let kinked = |b: &Bounds| b.length == 0.0 && b.curvature.0 > 0.0;
        let hollows = (0..count).filter(|i| kinked(&curve.stretches[*i])).collect();
        let smooth = |knot: &usize| !(*knot - 1..=*knot).any(|stretch| curve.stretches[stretch].length == 0.0);
        let joints = curve.joints().filter(smooth).collect();
        RailCurve { curve, reach, levels, hollows, joints, lengths }
    }

    fn is_vertex(&self, i: usize) -> bool {
        self.curve.stretches[i].length == 0.0
    }

    /// Bounds over all stretches from one place to another, widened by [`SLACK`] and by `wider` [m].
    #[inline]
    pub fn facing(&self, a: f64, b: f64, wider: f64) -> Facing {
        let last = self.curve.stretches.len() - 1;
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        // A float below 0 becomes 0.
        let mut from = self.reach[(low as usize).min(last)].0 as usize;
        let mut to = self.reach[(high as usize).min(last)].1 as usize;
        if wider > 0.0 {
            let (start, end) = (self.lengths[from] - wider, self.lengths[to + 1] + wider);
            while from > 0 && self.lengths[from] > start {
                from -= 1;
            }
            while to < last && self.lengths[to + 1] < end {
                to += 1;
            }
        }
        self.over(from, to)
    }

    /// First and last stretch between two places, widened by `wider` [m] alone.
    #[inline]
    pub fn within(&self, a: f64, b: f64, wider: f64) -> (usize, usize) {
        let last = self.curve.stretches.len() - 1;
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let at = |place: f64| {
            let j = (place as usize).min(last);
            (j, self.lengths[j] + (place - j as f64).clamp(0.0, 1.0) * self.curve.stretches[j].length)
        };
        let ((mut from, start), (mut to, end)) = (at(low), at(high));
        while from > 0 && self.lengths[from] > start - wider {
            from -= 1;
        }
        while to < last && self.lengths[to + 1] < end + wider {
            to += 1;
        }
        (from, to)
    }

    /// Bounds over the stretches from one to another.
    #[inline]
    pub fn over(&self, from: usize, to: usize) -> Facing {
        let level = (to + 1 - from).ilog2() as usize;
        self.levels[level][from].merge(&self.levels[level][to + 1 - (1 << level)])
    }

    /// The knot at which the curvature jumps between the stretches from one to another, if there is one and no other.
    #[inline]
    pub fn only_joint(&self, from: usize, to: usize) -> Option<usize> {
        let mut inside = self.joints.iter().filter(|knot| (from + 1..=to).contains(*knot));
        inside.next().copied().filter(|_| inside.next().is_none())
    }

    #[inline]
    fn sigma(&self, c: &Vector2<f64>, knot: usize) -> f64 {
        let k = &self.curve.knots[knot];
        (c.x - k.x) * k.cos + (c.y - k.y) * k.sin
    }

    /// Distance from the knot's tangent.
    #[inline]
    fn height(&self, c: &Vector2<f64>, knot: usize) -> f64 {
        let k = &self.curve.knots[knot];
        (c.y - k.y) * k.cos - (c.x - k.x) * k.sin
    }

    /// The foot of `c`, walking from the stretch at `guess`.
    #[inline]
    pub fn foot(&self, c: &Vector2<f64>, guess: f64) -> Foot {
        let foot = self.walk(c, guess);
        if self.hollows.is_empty() { foot } else { self.nearer(c, foot) }
    }

    /// A foot on the other side of a concave kink may be nearer.
    #[cold]
    fn nearer(&self, c: &Vector2<f64>, mut foot: Foot) -> Foot {
        for hollow in &self.hollows {
            let other = if foot.place < *hollow as f64 { self.walk(c, *hollow as f64 + 1.0) } else { self.walk(c, *hollow as f64 - 0.5) };
            if other.distance.abs() < foot.distance.abs() {
                foot = other;
            }
        }
        foot
    }

    #[inline]
    fn walk(&self, c: &Vector2<f64>, guess: f64) -> Foot {
        let last = self.curve.stretches.len() - 1;
        let mut j = (guess as usize).min(last);
        let mut before = self.sigma(c, j);
        // Some strides, then steps that only go one way.
        for _ in 0..4 {
            let stretch = &self.curve.stretches[j];
            let stride = before / (stretch.length + 1e-5);
            if (-1.0..=2.0).contains(&stride) {
                break;
            }
            let bend = 1.0 - stretch.curvature.1 * self.height(c, j);
            j = (j as f64 + stride / bend.clamp(0.7, 20.0)).clamp(0.0, last as f64) as usize;
            before = self.sigma(c, j);
        }
        let mut behind = self.sigma(c, j + 1);
        if before < 0.0 {
            while before < 0.0 && j > 0 {
                j -= 1;
                (behind, before) = (before, self.sigma(c, j));
            }
        } else {
            while behind > 0.0 && j < last {
                j += 1;
                (before, behind) = (behind, self.sigma(c, j + 1));
            }
        }
        self.between(c, j, before, behind)
    }

    #[inline]
    fn between(&self, c: &Vector2<f64>, j: usize, before: f64, behind: f64) -> Foot {
        let (a, b) = (&self.curve.knots[j], &self.curve.knots[j + 1]);
        if before < 0.0 {
            return Foot { place: -1e-9, distance: self.height(c, j), angle: a.angle };
        }
        if behind > 0.0 {
            return Foot { place: (j + 1) as f64, distance: self.height(c, j + 1), angle: b.angle };
        }
        let spread = before - behind;
        let share = if spread > 0.0 { before / spread } else { 0.5 };
        // Far along a rail of many stretches the sum itself may round up to the next one.
        let place = (j as f64 + share).min(((j + 1) as f64).next_down());
        if self.is_vertex(j) {
            // In front of a convex kink, or behind a concave one.
            let side = if b.angle > a.angle { -1.0 } else { 1.0 };
            let (x, y) = ((c.x - a.x) * side, (c.y - a.y) * side);
            return Foot { place, distance: side * x.hypot(y), angle: (-x).atan2(y) };
        }
        let turn = b.angle - a.angle;
        let height = (1.0 - share) * self.height(c, j) + share * self.height(c, j + 1);
        // The knots' tangents lie above a convex curve between them.
        Foot { place, distance: height - 0.25 * turn * share * before, angle: a.angle + share * turn }
    }

    /// The foot on the profile itself, near one on the knots.
    pub fn exact(&self, profile: &dyn Profile, c: &Vector2<f64>, near: &Foot) -> ExactFoot {
        let last = self.curve.stretches.len() - 1;
        if near.place < 0.0 || near.place as usize > last {
            let k = &self.curve.knots[if near.place < 0.0 { 0 } else { last + 1 }];
            let along = (c.x - k.x) * k.cos + (c.y - k.y) * k.sin;
            return ExactFoot { eta: k.x + along * k.cos, distance: near.distance, tangent: Vector2::new(k.cos, k.sin) };
        }
        let j = near.place as usize;
        let (a, b) = (&self.curve.knots[j], &self.curve.knots[j + 1]);
        if self.is_vertex(j) {
            let (sin, cos) = near.angle.sin_cos();
            return ExactFoot { eta: a.x, distance: near.distance, tangent: Vector2::new(cos, sin) };
        }
        let (mut low, mut high) = (a.x, b.x);
        let mut eta = low + (near.place - j as f64) * (high - low);
        let mut p = profile.at(eta);
        for _ in 0..40 {
            let rise = c.y - p.value;
            let sigma = (c.x - eta) + rise * p.d1;
            if sigma > 0.0 {
                low = eta
            } else {
                high = eta
            }
            let slope = -(1.0 + p.d1 * p.d1) + rise * p.d2;
            let step = sigma / slope;
            let trial = eta - step;
            eta = if slope < 0.0 && trial >= low && trial <= high { trial } else { 0.5 * (low + high) };
            p = profile.at(eta);
            if step.abs() < 1e-9 && slope < 0.0 || high - low < 1e-15 {
                break;
            }
        }
        let tangent = Vector2::new(1.0, p.d1) / (1.0 + p.d1 * p.d1).sqrt();
        ExactFoot { eta, distance: (c.y - p.value) * tangent.x - (c.x - eta) * tangent.y, tangent }
    }

    /// The stretch at a coordinate.
    pub fn place(&self, eta: f64) -> f64 {
        (self.curve.knots.partition_point(|k| k.x <= eta).max(1) - 1) as f64
    }

    /// Coordinates of the first and last knot, m.
    pub fn ends(&self) -> (f64, f64) {
        (self.curve.knots[0].x, self.curve.knots[self.curve.knots.len() - 1].x)
    }
}

impl Facing {
    #[inline]
    fn merge(&self, other: &Facing) -> Facing {
        Facing {
            angle: (less(self.angle.0, other.angle.0), more(self.angle.1, other.angle.1)),
            curvature: (less(self.curvature.0, other.curvature.0), more(self.curvature.1, other.curvature.1)),
        }
    }
}
