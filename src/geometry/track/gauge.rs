//! Gauge: the distance between the rails' inner faces.
//!
//! It is measured between the innermost points of the two heads that lie no deeper than `depth` (14 mm by EN 13848-1) below the
//! heads' highest points, both in the track's plane, with the sections inclined. So the section's origin (eta = 0) stands
//! `gauge / 2 + reach` from the centre line, `reach` being how far the innermost point lies from the origin toward the centre.
//!
//! A measured profile may end above that depth. Where its end is upright or leans back, its innermost point is known all the same; else not.

use crate::geometry::profile::Profile;

/// Where the gauge is measured below the heads' highest points, unless a scene says otherwise, m (EN 13848-1).
pub const DEPTH: f64 = 14e-3;

/// Steps along the profile in which top and innermost point are looked for; both are then refined by bisection.
const STEPS: usize = 4000;

/// What may be missed below the end of a profile, m.
const MISSED: f64 = 1e-4;

/// A profile that ends too early to tell the gauge.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the rail's profile ends {:.1} mm below its top, where its face still leans inward, and the gauge is measured {:.1} mm below: the profile must go further down its inner side; or give gauge_depth where the gauge was measured, or rail_distance",
    1e3 * ends, 1e3 * depth
)]
pub struct EndsEarly {
    /// Depth of its end below its top, m, and where the gauge is measured, m.
    pub ends: f64,
    pub depth: f64,
}

/// How far the head's innermost point within `depth` [m] below its top lies toward the track's centre from the section's origin,
/// m, for a section inclined toward the centre by `inclination` [rad].
///
/// # Errors
/// [`EndsEarly`].
pub fn reach(profile: &dyn Profile, inclination: f64, depth: f64) -> Result<f64, EndsEarly> {
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
    } else {
        // Straight on from its end.
        let [end, next] = [places[0], places[1]];
        let missed = (end.0 - next.0) / (next.1 - end.1) * (end.1 - lowest);
        if best <= end.0 + MISSED && missed > MISSED {
            return Err(EndsEarly { ends: places[highest].1 - end.1, depth });
        }
    }
    Ok(best)
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
        assert!((reach(&Round(radius), 0.0, depth).unwrap() - chord).abs() < 1e-9);
        let inclined = reach(&Round(radius), 0.025, depth).unwrap();
        assert!((inclined - (chord - radius * 0.025f64.sin())).abs() < 1e-7, "{inclined}");
    }

    #[test]
    fn prop_a_profile_that_ends_above_the_depth_is_refused_unless_its_end_is_upright() {
        // Half its radius deep at 0.866 R from the middle, and at 0.99 R it is 0.86 R deep.
        let refused = reach(&Round(0.01), 0.0, 0.014).unwrap_err();
        assert!((refused.ends - 0.01 * (1.0 - 0.0199f64.sqrt())).abs() < 1e-6 && refused.depth == 0.014, "{refused}");

        /// Flat on top with a face at -30 mm, 10 mm deep, that leans inward by `lean` of its depth.
        #[derive(Debug)]
        struct Face(f64);
        impl Profile for Face {
            fn at(&self, eta: f64) -> ProfilePoint {
                ProfilePoint { value: ((eta + 0.03) / self.0).min(0.0), ..ProfilePoint::default() }
            }
            fn range(&self) -> (f64, f64) {
                (-0.03 - 0.01 * self.0, 0.03)
            }
            fn describe(&self) -> String {
                "face".into()
            }
        }
        // 4 mm are missing: 0.04 mm of reach where it leans by 1 %, 0.4 where by 10 %.
        assert!((reach(&Face(0.01), 0.0, 0.014).unwrap() - 0.0301).abs() < 1e-9);
        assert!(reach(&Face(0.1), 0.0, 0.014).is_err() && reach(&Face(0.1), 0.0, 0.0099).is_ok());
    }
}
