//! Gaps of a measured series that a spline would fill with track that nobody measured.
//!
//! Over a stretch without points a natural cubic spline swings on from the slopes at both ends: by up to 4/27 of slope times length, and more where it bends there. Series
//! may be uneven; but where points stand far further apart than they mostly do and the spline leaves what was measured anywhere, the file has a hole.

use crate::math::spline::CubicSpline;

/// A gap is so many times as long as most distances between points.
const LONG: f64 = 20.0;
/// It is filled with inventions where the spline leaves the range of all values by this part of it.
const BEYOND: f64 = 0.5;
/// Looks within a gap.
const LOOKS: usize = 32;

/// Stretches without points, m, and how far these mostly stand apart, m.
pub(super) struct Long {
    usual: f64,
    gaps: Vec<(f64, f64)>,
}

/// A gap, m, what the spline makes of it and what was measured at most, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    pub from: f64,
    pub to: f64,
    pub usual: f64,
    pub invented: f64,
    pub measured: f64,
}

/// Gaps of these positions between `from` and `to` [m]; `None` where there is none, as in most series.
pub(super) fn long(positions: &[f64], (from, to): (f64, f64)) -> Option<Long> {
    let mut apart: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    apart.sort_by(f64::total_cmp);
    let usual = *apart.get(apart.len() / 2)?;
    let all = positions.windows(2).map(|pair| (pair[0], pair[1]));
    let gaps: Vec<_> = all.filter(|gap| gap.1 - gap.0 > LONG * usual && gap.1 > from && gap.0 < to).collect();
    (!gaps.is_empty()).then_some(Long { usual, gaps })
}

impl Long {
    /// The gap that these values' spline fills with most that was not measured, if there is one.
    pub fn worst(&self, points: &[(f64, f64)]) -> Option<Gap> {
        let spline = CubicSpline::natural(points).ok()?;
        let values = points.iter().map(|point| point.1);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let beyond = |value: f64| (value - value.clamp(low, high)).abs();
        let found = self.gaps.iter().filter_map(|(from, to)| {
            let looks = (1..LOOKS).map(|k| spline.at(from + (to - from) * k as f64 / LOOKS as f64)[0]);
            let invented = looks.max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)))?;
            let measured = if invented > high { high } else { low };
            Some(Gap { from: *from, to: *to, usual: self.usual, invented, measured })
        });
        found.filter(|gap| beyond(gap.invented) > BEYOND * (high - low)).max_by(|a, b| beyond(a.invented).total_cmp(&beyond(b.invented)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_hole_in_a_series_is_one_where_its_spline_leaves_what_was_measured() {
        let wave = |s: f64| 2e-3 * (0.9 * s).sin() + 1e-3 * (0.31 * s).cos();
        let with = |hole: f64| -> Vec<(f64, f64)> {
            (0..400).map(|k| 0.25 * f64::from(k)).filter(|s| !(40.1..40.1 + hole).contains(s)).map(|s| (s, wave(s))).collect()
        };
        let at = |points: &[(f64, f64)], range| {
            let positions: Vec<f64> = points.iter().map(|point| point.0).collect();
            long(&positions, range)?.worst(points)
        };
        let hole = at(&with(30.0), (0.0, 100.0)).unwrap();
        assert!((hole.from, hole.to, hole.usual) == (40.0, 70.25, 0.25) && hole.invented.abs() > 4.5e-3, "{hole:?}");
        assert!(at(&with(30.0), (0.0, 39.0)).is_none() && at(&with(0.0), (0.0, 100.0)).is_none() && at(&with(3.0), (0.0, 100.0)).is_none());
        // Uneven from the first to the last point.
        let uneven: Vec<(f64, f64)> = (0..60).map(|k| (f64::from(k * k) * 0.1, wave(f64::from(k)))).collect();
        assert!(at(&uneven, (0.0, 350.0)).is_none());
    }
}
