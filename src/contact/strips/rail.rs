//! The rail's head cut into strips along the track, once for all poses.

use super::pressed::Pressed;
use crate::geometry::profile::{Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::Rail;

/// Widths of strips, m, where the head is bent more sharply than so [1/m], or the head against a wheel more sharply than that: patches are the narrower
/// the sharper it is.
const WIDTHS: [(f64, f64, f64); 3] = [(1.0 / 0.04, 1.0 / 0.033, 3.5e-4), (1.0 / 0.15, 2.0 / 0.15, 7e-4), (0.0, 0.0, 1.35e-3)];

/// Narrower ones on edges of worn heads, m, where the head turns by so much per length [1/m] over the width of the narrowest strip above: on an edge of 0.3 mm a patch is 0.3 mm wide under 10 kN, and carried 18 % too
/// much on strips of 0.35 mm.
const EDGES: [(f64, f64); 2] = [(600.0, 6e-5), (200.0, 1.2e-4)];

/// One strip of the rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RailStrip {
    /// Coordinate of its middle, m, and the profile there.
    pub eta: f64,
    pub profile: ProfilePoint,
    /// Along the section, m.
    pub width: f64,
    /// Arc length of its middle, m.
    pub arc: f64,
}

/// All strips of a rail, from the inner to the outer end.
#[derive(Clone, Debug, PartialEq)]
pub struct RailStrips {
    strips: Vec<RailStrip>,
    /// Distances that each strip feels of itself and the next ones, m; beyond them it is that of the middles.
    felt: Vec<[f64; NEIGHBOURS]>,
}

/// Strips that feel each other otherwise than from middle to middle: 0.1 % at the eighth.
const NEIGHBOURS: usize = 9;

impl RailStrips {
    /// Strips of a rail for patches with these wheels.
    pub fn new<'w>(rail: &Rail, wheels: impl Iterator<Item = &'w Wheel>) -> RailStrips {
        let profile = rail.profile.as_ref();
        let opposite = Opposite::new(wheels);
        let (first, last) = profile.range();
        let mut strips: Vec<RailStrip> = Vec::new();
        let (mut begin, mut arc) = (first, 0.0);
        while begin < last {
            let at = profile.at(begin);
            let slope = at.d1.hypot(1.0);
            let (bend, relative) = (at.d2.abs() / slope.powi(3), opposite.bend(rail, begin, &at));
            let smooth = WIDTHS.iter().find(|(own, against, _)| bend >= *own || relative >= *against).map_or(WIDTHS[0].2, |found| found.2);
            let turn = turn(profile, [begin - 0.5 * WIDTHS[0].2 / slope, begin + WIDTHS[0].2 / slope]);
            let width = EDGES.iter().find(|(least, _)| turn >= *least).map_or(smooth, |found| found.1);
            let end = begin + width / slope;
            let eta = 0.5 * (begin + end);
            let middle = profile.at(eta);
            let width = (end - begin) * middle.d1.hypot(1.0);
            if end <= last {
                strips.push(RailStrip { eta, profile: middle, width, arc: arc + 0.5 * width });
            }
            (begin, arc) = (end, arc + width);
        }
        let of = |own: usize| {
            std::array::from_fn(|next| {
                let (own, other) = (&strips[own], &strips[(own + next).min(strips.len() - 1)]);
                felt(other.arc - own.arc, own.width, other.width)
            })
        };
        let felt = (0..strips.len()).map(of).collect();
        RailStrips { strips, felt }
    }

    pub fn len(&self) -> usize {
        self.strips.len()
    }

    pub fn is_empty(&self) -> bool {
        self.strips.is_empty()
    }

    #[inline]
    pub(super) fn strip(&self, number: usize) -> &RailStrip {
        &self.strips[number]
    }

    /// Does a strip carry where the rail is steeper than this?
    pub fn carries_beyond(&self, slope: f64, pressed: &[Pressed]) -> bool {
        pressed.iter().any(|own| own.load > 0.0 && self.strip(own.number).profile.d1.abs() > slope)
    }

    /// The strip that is nearest to a coordinate.
    pub(super) fn nearest(&self, eta: f64) -> usize {
        let after = self.strips.partition_point(|strip| strip.eta < eta).clamp(1, self.strips.len() - 1);
        if eta - self.strips[after - 1].eta < self.strips[after].eta - eta { after - 1 } else { after }
    }

    /// Distances at which a strip feels itself and those after it, m, as far as they are not those of the middles.
    #[inline]
    pub(super) fn felt(&self, own: usize) -> &[f64] {
        &self.felt[own]
    }

    /// The distance at which two strips feel each other, m.
    #[inline]
    pub(super) fn apart(&self, one: usize, other: usize) -> f64 {
        let (one, other) = (one.min(other), one.max(other));
        match self.felt[one].get(other - one) {
            Some(felt) => *felt,
            None => self.strips[other].arc - self.strips[one].arc,
        }
    }
}

/// By how much a head turns outward-down at most over the first width of strips within a range of it, per length, 1/m: noise of points is less there than in its second derivative.
fn turn(profile: &dyn Profile, [from, to]: [f64; 2]) -> f64 {
    const LOOKS: usize = 6;
    let (first, last) = profile.range();
    let angle = |k: usize| profile.at((from + (to - from) * k as f64 / LOOKS as f64).clamp(first, last)).d1.atan();
    let angles: [f64; LOOKS + 1] = std::array::from_fn(angle);
    let pairs = (0..=LOOKS).flat_map(|i| (i..=LOOKS).map(move |j| (i, j)));
    pairs.map(|(i, j)| (angles[i] - angles[j]) / WIDTHS[0].2).fold(0.0, f64::max)
}

/// What wheels may bring to a place of the rail.
struct Opposite {
    /// Places of wheels: distance from the middle of the track, m, angle of the surface, rad, and curvature, 1/m, positive where the wheel is convex.
    places: Vec<[f64; 3]>,
}

/// Wheels' profiles are looked at so often, m.
const LOOKED: f64 = 2.5e-4;
/// They meet a place of the rail at most so far across the track from where they stand in the middle of it, m, ...
const SHIFT: f64 = 0.02;
/// ... under about the same angle, rad: roll, and yaw on a steep flank.
const TURN: f64 = 0.06;

impl Opposite {
    fn new<'w>(wheels: impl Iterator<Item = &'w Wheel>) -> Opposite {
        let mut known: Vec<&Wheel> = Vec::new();
        let mut places = Vec::new();
        for wheel in wheels {
            if known.iter().any(|other| other.is_like(wheel)) {
                continue;
            }
            known.push(wheel);
            let (first, last) = wheel.profile.range();
            let count = ((last - first) / LOOKED).ceil().max(1.0) as usize;
            places.extend((0..=count).map(|k| {
                let u = first + (last - first) * k as f64 / count as f64;
                let at = wheel.profile.at(u);
                [wheel.half_spacing + u, -at.d1.atan(), -at.d2 / at.d1.hypot(1.0).powi(3)]
            }));
        }
        places.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Opposite { places }
    }

    /// The sharpest relative curvature of what may meet the rail at a coordinate, where its profile is `at`, 1/m.
    fn bend(&self, rail: &Rail, eta: f64, at: &ProfilePoint) -> f64 {
        let across = rail.across(eta, at.value);
        let tangent = rail.outward + rail.up * at.d1;
        let angle = tangent.z.atan2(tangent.y * rail.side.sign());
        let own = -at.d2 / at.d1.hypot(1.0).powi(3);
        let begin = self.places.partition_point(|place| place[0] < across - SHIFT);
        let near = self.places[begin..].iter().take_while(|place| place[0] <= across + SHIFT);
        near.filter(|place| (place[1] - angle).abs() < TURN).map(|place| own + place[2]).fold(0.0, f64::max)
    }
}

/// The distance whose logarithm is the mean of that of all distances between two strips: `exp` of the mean of `ln |y1 - y2|` over both widths.
///
/// Influence grows like the logarithm of the distance where strips are near. With `L(v) = v^2 ln|v| / 2 - 3 v^2 / 4`, L'' = ln, the mean is a second
/// difference of L. A strip feels itself at 0.223 of its width.
fn felt(distance: f64, width: f64, other: f64) -> f64 {
    let (sum, difference) = (0.5 * (width + other), 0.5 * (width - other));
    let l = |v: f64| if v == 0.0 { 0.0 } else { v * v * (0.5 * v.abs().ln() - 0.75) };
    let mean = (l(distance + sum) - l(distance + difference) - l(distance - difference) + l(distance - sum)) / (width * other);
    mean.exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Side;
    use crate::geometry::profile::Arch;
    use std::sync::Arc;

    #[test]
    fn analytic_distances_that_strips_feel() {
        // Mean of ln|y1 - y2| over one interval: ln w - 3/2; far away: the distance.
        assert!((felt(0.0, 2e-4, 2e-4) / (2e-4 * (-1.5f64).exp()) - 1.0).abs() < 1e-12);
        assert!((felt(1.5e-3, 2e-4, 2e-4) / 1.5e-3 - 1.0).abs() < 2e-3 && (felt(0.01, 2e-4, 4e-4) / 0.01 - 1.0).abs() < 2e-4);
        // By summation over both intervals, unequal widths.
        let n = 400;
        let place = |k: usize, width: f64| width * ((k as f64 + 0.5) / n as f64 - 0.5);
        let sum: f64 = (0..n).flat_map(|i| (0..n).map(move |j| (6e-4 + place(i, 4e-4) - place(j, 2e-4)).ln())).sum();
        assert!((felt(6e-4, 4e-4, 2e-4) / (sum / (n * n) as f64).exp() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn prop_strips_cover_the_head_once() {
        let rail = RailStrips::new(&Rail::new(Side::Left, Arc::new(Arch { radius: 0.045 }), 0.75, 0.0, &[]), std::iter::empty());
        let pairs: Vec<_> = (1..rail.len()).map(|k| (rail.strip(k - 1), rail.strip(k))).collect();
        assert!(pairs.iter().all(|(a, b)| (b.arc - a.arc - 0.5 * (a.width + b.width)).abs() < 1e-12));
        let (first, last) = (rail.strip(0), rail.strip(rail.len() - 1));
        assert!(first.eta < -0.0355 && last.eta > 0.0355);
        assert!((0..rail.len()).all(|k| rail.nearest(rail.strip(k).eta + 5e-5) == k));
    }
}
