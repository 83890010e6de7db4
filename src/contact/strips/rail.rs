//! The rail's head cut into strips along the track, once for all poses.

use crate::geometry::profile::{Profile, ProfilePoint};

/// Widths of strips, m, where the head is bent more sharply than so [1/m]: patches are the narrower the sharper it is.
const WIDTHS: [(f64, f64); 3] = [(1.0 / 0.04, 3.5e-4), (1.0 / 0.15, 7e-4), (0.0, 1.35e-3)];

/// One strip of the rail.
#[derive(Clone, Copy, Debug)]
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
#[derive(Clone, Debug)]
pub struct RailStrips {
    strips: Vec<RailStrip>,
    /// Distances that each strip feels of itself and the next ones, m; beyond them it is that of the middles.
    felt: Vec<[f64; NEIGHBOURS]>,
}

/// Strips that feel each other otherwise than from middle to middle: 0.1 % at the eighth.
const NEIGHBOURS: usize = 9;

impl RailStrips {
    pub fn new(profile: &dyn Profile) -> RailStrips {
        let (first, last) = profile.range();
        let mut strips: Vec<RailStrip> = Vec::new();
        let (mut begin, mut arc) = (first, 0.0);
        while begin < last {
            let at = profile.at(begin);
            let slope = at.d1.hypot(1.0);
            let bend = at.d2.abs() / slope.powi(3);
            let width = WIDTHS.iter().find(|(sharper, _)| bend >= *sharper).map_or(WIDTHS[0].1, |found| found.1);
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

    /// The strip that is nearest to a coordinate.
    pub(super) fn nearest(&self, eta: f64) -> usize {
        let after = self.strips.partition_point(|strip| strip.eta < eta).clamp(1, self.strips.len() - 1);
        if eta - self.strips[after - 1].eta < self.strips[after].eta - eta { after - 1 } else { after }
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
    use crate::geometry::profile::Arch;

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
        let rail = RailStrips::new(&Arch { radius: 0.045 });
        let pairs: Vec<_> = (1..rail.len()).map(|k| (rail.strip(k - 1), rail.strip(k))).collect();
        assert!(pairs.iter().all(|(a, b)| (b.arc - a.arc - 0.5 * (a.width + b.width)).abs() < 1e-12));
        let (first, last) = (rail.strip(0), rail.strip(rail.len() - 1));
        assert!(first.eta < -0.0355 && last.eta > 0.0355);
        assert!((0..rail.len()).all(|k| rail.nearest(rail.strip(k).eta + 5e-5) == k));
    }
}
