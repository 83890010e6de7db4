//! Track that a spline invents between the points of a series.
//!
//! Through evenly measured points a cubic spline leaves what was measured by no more than waves do that lie between samples: by 0.33 of the range of the six points
//! around, rounded white noise. Where short distances between points meet long ones (a table made by hand, a hole in a measurement) it swings on from the slopes of the short ones:
//! a gauge of 0, 0, 0, 8, 8, 0, 0 mm at 0, 30, 60, 60.5, 70, 70.5, 100 m became one of -82 to 45 mm. Such a series is refused.

use crate::math::spline::CubicSpline;

/// Points on each side of an interval's that are around it.
const AROUND: usize = 2;
/// What a spline may leave their range by, in parts of it; their range counts as at least so much of the range of all points.
const BEYOND: f64 = 0.4;
const LEAST: f64 = 0.2;
/// Less than this is none, m.
const NOTHING: f64 = 1e-6;
/// Looks within an interval.
const LOOKS: usize = 16;

/// How far a spline leaves the points around it, at the worst place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Overshoot {
    /// The points between which it does, m.
    pub from: f64,
    pub to: f64,
    /// Its value there, and that of the points around that is nearest, m.
    pub invented: f64,
    pub measured: f64,
    /// Of what is allowed, 1 and more: too much.
    pub part: f64,
}

/// The worst place of the natural spline through these points between `from` and `to` [m].
pub(super) fn worst(spline: &CubicSpline, points: &[(f64, f64)], (from, to): (f64, f64)) -> Option<Overshoot> {
    let whole = range(points);
    let least = LEAST * (whole.1 - whole.0);
    let of = |k: usize| {
        let (a, b) = (points[k].0, points[k + 1].0);
        let around = range(&points[k.saturating_sub(AROUND)..(k + 2 + AROUND).min(points.len())]);
        let beyond = |value: f64| (value - value.clamp(around.0, around.1)).abs();
        let looks = (1..LOOKS).map(|look| spline.at(a + (b - a) * look as f64 / LOOKS as f64)[0]);
        let invented = looks.max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)))?;
        let allowed = (BEYOND * least.max(around.1 - around.0)).max(NOTHING);
        let part = beyond(invented) / allowed;
        Some(Overshoot { from: a, to: b, invented, measured: invented.clamp(around.0, around.1), part })
    };
    let acting = (0..points.len().saturating_sub(1)).filter(|k| points[k + 1].0 > from && points[*k].0 < to);
    acting.filter_map(of).max_by(|a, b| a.part.total_cmp(&b.part))
}

/// Least and largest value.
fn range(points: &[(f64, f64)]) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| (low.min(point.1), high.max(point.1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(points: &[(f64, f64)]) -> f64 {
        let spline = CubicSpline::natural(points).unwrap();
        worst(&spline, points, (points[0].0, points[points.len() - 1].0)).unwrap().part
    }

    fn table(places: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
        places.iter().zip(values).map(|(place, value)| (*place, 1e-3 * value)).collect()
    }

    #[test]
    fn prop_what_a_spline_invents_between_points_by_hand_is_too_much() {
        for (places, values) in [
            (&[0.0, 30.0, 60.0, 60.5, 70.0, 70.5, 100.0, 130.0][..], &[0.0, 0.0, 0.0, 8.0, 8.0, 0.0, 0.0, 0.0][..]),
            (&[0.0, 50.0, 52.0, 100.0, 150.0], &[0.0, 0.0, 5.0, 5.0, 5.0]),
            (&[0.0, 50.0, 63.0, 80.0, 93.0, 150.0], &[0.0, 0.0, 15.0, 15.0, 0.0, 0.0]),
            (&[0.0, 30.0, 40.0, 60.0, 70.0, 100.0], &[0.0, 0.0, 15.0, 15.0, 0.0, 0.0]),
        ] {
            let points = table(places, values);
            assert!(found(&points) > 1.0, "{points:?}: {}", found(&points));
        }
        // One joint of 0.05 mm among points 10 m apart.
        let mut joint: Vec<(f64, f64)> = (0..20).map(|k| (10.0 * f64::from(k), 0.0)).collect();
        joint.splice(11..11, [(100.2, 0.0), (100.4, -5e-5), (100.6, 0.0)]);
        assert!(found(&joint) > 10.0);
    }

    #[test]
    fn prop_waves_between_samples_are_not_too_much() {
        let mut state = 7u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1u32 << 24) - 0.5
        };
        let noise: Vec<(f64, f64)> = (0..40_000).map(|k| (0.25 * f64::from(k), 1e-3 * next())).collect();
        let step: Vec<(f64, f64)> = noise.iter().map(|point| (point.0, if point.0 > 40.0 { 8e-3 } else { 0.0 })).collect();
        let rounded: Vec<(f64, f64)> = noise.iter().map(|point| (point.0, 2e-4 * (point.1 / 2e-4).round())).collect();
        let uneven: Vec<(f64, f64)> = noise.iter().map(|point| (point.0 + 100.0 * next() * 1e-3, 2e-3 * (0.9 * point.0).sin())).collect();
        for points in [noise, step, rounded, uneven] {
            assert!(found(&points) < 1.0, "{}", found(&points));
        }
    }
}
