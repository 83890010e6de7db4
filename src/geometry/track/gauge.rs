//! Gauge: the distance between the rails' inner faces.
//!
//! It is measured between the innermost points of the two heads that lie no deeper than `depth` (14 mm by EN 13848-1) below the
//! heads' highest points, both in the track's plane, with the sections inclined. So the section's origin (eta = 0) stands
//! `gauge / 2 + reach` from the centre line, `reach` being how far the innermost point lies from the origin toward the centre.

use crate::geometry::profile::Profile;

/// Steps along the profile in which top and innermost point are looked for; both are then refined by bisection.
const STEPS: usize = 4000;

/// How far the head's innermost point within `depth` [m] below its top lies toward the track's centre from the section's origin,
/// m, for a section inclined toward the centre by `inclination` [rad].
pub fn reach(profile: &dyn Profile, inclination: f64, depth: f64) -> f64 {
    let (first, last) = profile.range();
    let (sin, cos) = inclination.sin_cos();
    // Section axes: outward (cos, sin) and up (-sin, cos) in (outward, up) of the track, seen from the centre.
    let place = |eta: f64| {
        let value = profile.at(eta).value;
        (value * sin - eta * cos, eta * sin + value * cos)
    };
    let (inward, height) = (|eta: f64| place(eta).0, |eta: f64| place(eta).1);
    let at = |index: usize| first + (last - first) * index as f64 / STEPS as f64;
    let places: Vec<(f64, f64)> = (0..=STEPS).map(|index| place(at(index))).collect();
    let highest = (0..=STEPS).max_by(|a, b| places[*a].1.total_cmp(&places[*b].1)).unwrap_or(0);
    let lowest = places[highest].1 - depth;
    // From the top inward to where the head is too deep.
    let beyond = (0..highest).rev().find(|index| places[*index].1 < lowest);
    let mut best = places[..=highest].iter().filter(|place| place.1 >= lowest).map(|place| place.0).fold(f64::MIN, f64::max);
    if let Some(index) = beyond {
        let (mut deep, mut high) = (at(index), at(index + 1));
        for _ in 0..60 {
            let middle = 0.5 * (deep + high);
            if height(middle) >= lowest { high = middle } else { deep = middle }
        }
        best = best.max(inward(high));
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::profile::ProfilePoint;

    /// A head of radius `R` about (0, -R).
    #[derive(Debug)]
    struct Round(f64);
    impl Profile for Round {
        fn at(&self, eta: f64) -> ProfilePoint {
            ProfilePoint { value: (self.0 * self.0 - eta * eta).max(0.0).sqrt() - self.0, ..ProfilePoint::default() }
        }
        fn range(&self) -> (f64, f64) {
            (-0.99 * self.0, 0.99 * self.0)
        }
        fn describe(&self) -> String {
            "round".into()
        }
    }

    #[test]
    fn analytic_reach_of_a_circle() {
        // Level: at depth d the half chord sqrt(2 R d - d^2). Inclined by a, the circle's centre moves by R sin a.
        let (radius, depth) = (0.04f64, 0.014f64);
        let chord = (2.0 * radius * depth - depth * depth).sqrt();
        assert!((reach(&Round(radius), 0.0, depth) - chord).abs() < 1e-9);
        let inclined = reach(&Round(radius), 0.025, depth);
        assert!((inclined - (chord - radius * 0.025f64.sin())).abs() < 1e-7, "{inclined}");
    }
}
