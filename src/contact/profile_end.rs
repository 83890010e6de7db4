//! Patches that reach the end of a profile's points: nothing is known of what lies beyond, and the last point presses like an edge of the steel.

use crate::geometry::profile::Profile;
use serde::{Deserialize, Serialize};

/// Slope of a profile beyond which nothing presses: 73 degrees.
const STEEPEST: f64 = 3.3;

/// The end of a profile within a patch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProfileEnd {
    /// The wheel's, else the rail's.
    pub wheel: bool,
    /// Its coordinate, m.
    pub at: f64,
}

impl ProfileEnd {
    /// Of a patch that lies between such coordinates of a wheel and of a rail [m].
    pub fn within(wheel: (&dyn Profile, [f64; 2]), rail: (&dyn Profile, [f64; 2])) -> Option<ProfileEnd> {
        [(true, wheel), (false, rail)].into_iter().find_map(|(wheel, (profile, [from, to]))| {
            let (first, last) = profile.range();
            let at = if from <= first { Some(first) } else { (to >= last).then_some(last) };
            // Side faces of heads and flanges, where curves of a coordinate end, carry nothing.
            at.filter(|at| profile.at(*at).d1.abs() < STEEPEST).map(|at| ProfileEnd { wheel, at })
        })
    }

    /// Of a wheel's patch, named so, in a sentence.
    pub fn words(&self, patch: &str) -> String {
        let (part, letter) = if self.wheel { ("wheel", "u") } else { ("rail", "eta") };
        format!(
            "{patch} reaches the end of the {part}'s profile ({letter} = {:.2} mm): nothing presses beyond it, and pressure, load's centre and creep force are those of an edge there; where the \
             steel goes on, expected a profile that does",
            1e3 * self.at
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::profile::ProfilePoint;

    /// A slope.
    #[derive(Debug)]
    struct Inclined(f64);

    impl Profile for Inclined {
        fn at(&self, _: f64) -> ProfilePoint {
            ProfilePoint { d1: self.0, ..ProfilePoint::default() }
        }

        fn range(&self) -> (f64, f64) {
            (-0.03, 0.02)
        }

        fn describe(&self) -> String {
            String::new()
        }
    }

    #[test]
    fn prop_ends_within_a_patch_are_found() {
        let of = |wheel: [f64; 2], rail: [f64; 2]| {
            ProfileEnd::within((&Inclined(0.1), wheel), (&Inclined(-1.0), rail)).map(|end| (end.wheel, end.at))
        };
        assert_eq!(of([-0.01, 0.01], [0.0, 0.015]), None);
        assert_eq!((of([-0.031, 0.01], [0.0, 0.01]), of([0.0, 0.01], [0.01, 0.02])), (Some((true, -0.03)), Some((false, 0.02))));
        assert_eq!(ProfileEnd::within((&Inclined(0.1), [0.0; 2]), (&Inclined(-20.0), [-0.04, 0.0])), None, "a side face");
        let words = ProfileEnd { wheel: false, at: 8e-3 }.words("the right wheel's patch");
        assert!(words.starts_with("the right wheel's patch reaches the end of the rail's profile (eta = 8.00 mm)"), "{words}");
    }
}
