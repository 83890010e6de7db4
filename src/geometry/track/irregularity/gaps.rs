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

/// A gap, m, what the spline makes of it and what was measured at most, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    pub from: f64,
    pub to: f64,
    pub usual: f64,
    pub invented: f64,
    pub measured: f64,
}

/// The worst gap between `from` and `to` [m], if there is one.
pub(super) fn worst(points: &[(f64, f64)], spline: &CubicSpline, (from, to): (f64, f64)) -> Option<Gap> {
    let mut apart: Vec<f64> = points.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    apart.sort_by(f64::total_cmp);
    let usual = *apart.get(apart.len() / 2)?;
    let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| (low.min(point.1), high.max(point.1)));
    let room = BEYOND * (high - low);
    let gaps =
        points.windows(2).map(|pair| (pair[0].0, pair[1].0)).filter(|gap| gap.1 - gap.0 > LONG * usual && gap.1 > from && gap.0 < to);
    let found = gaps.filter_map(|(begin, end)| {
        let looks = (1..LOOKS).map(|k| spline.at(begin + (end - begin) * k as f64 / LOOKS as f64)[0]);
        let invented = looks.max_by(|a, b| (a - a.clamp(low, high)).abs().total_cmp(&(b - b.clamp(low, high)).abs()))?;
        let beyond = (invented - invented.clamp(low, high)).abs();
        let measured = if invented > high { high } else { low };
        (beyond > room).then_some((beyond, Gap { from: begin, to: end, usual, invented, measured }))
    });
    found.max_by(|a, b| a.0.total_cmp(&b.0)).map(|found| found.1)
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
        let at = |points: &[(f64, f64)], range| worst(points, &CubicSpline::natural(points).unwrap(), range);
        let hole = at(&with(30.0), (0.0, 100.0)).unwrap();
        assert!((hole.from, hole.to, hole.usual) == (40.0, 70.25, 0.25) && hole.invented.abs() > 4.5e-3, "{hole:?}");
        assert!(at(&with(30.0), (0.0, 39.0)).is_none() && at(&with(0.0), (0.0, 100.0)).is_none() && at(&with(3.0), (0.0, 100.0)).is_none());
        // Uneven from the first to the last point.
        let uneven: Vec<(f64, f64)> = (0..60).map(|k| (f64::from(k * k) * 0.1, wave(f64::from(k)))).collect();
        assert!(at(&uneven, (0.0, 350.0)).is_none());
    }
}
