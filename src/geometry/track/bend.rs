//! How sharply a rail bends along the track: a wheel touches it at one place along the track only where it is less curved than the wheel.
//!
//! *Upwards.* Above a rail of height z(s) a wheel of radius r, its centre at s0, has the gap `(s - s0)^2 / (2 r) - z(s)` to second order. That is
//! convex, with one least value, where `z'' < 1 / r` everywhere; elsewhere the wheel bridges the bend and stands on two places along the track.
//!
//! *Sideways.* A flank that leans by b against the tread, such as a flange, touches a rail that runs at the angle a against the wheel's plane at a distance of
//! `r tan(b) a` ahead of its lowest point: 50 mm and more. Seen along the rail's tangent beside the wheel, it is off by `y'' x^2 / 2` there; along its parabola, by x^3 / 6
//! of the next derivative.

use super::{Direction, Rail};
use std::sync::Arc;

/// Looks in the shortest wave.
const LOOKS: f64 = 24.0;
/// Looks at a rail at most; very long tracks with short waves are looked at more coarsely.
const MOST: f64 = 4e5;

/// Curvature [1/m] and its rate [1/m2] sideways above which a rail is looked at from several places along the track: the flange's place, 70 mm ahead, is
/// then off by more than 0.25 mm, and 60 mm ahead by 10 um.
const SHARP: [f64; 2] = [0.1, 0.3];
/// Looks in the shortest wave for that.
const SHARP_LOOKS: f64 = 12.0;
/// Furthest lead of a contact and a little more, m.
const LEAD: f64 = 0.15;

/// Where a rail bends sideways sharply.
#[derive(Clone, Debug, Default)]
pub(super) struct Sharp {
    /// Distances within which a wheel may touch such a place, m, in order.
    stretches: Vec<(f64, f64)>,
    /// The sharpest hollow of its inner face [1/m] and where it is [m].
    hollow: Option<(f64, f64)>,
}

impl Rail {
    /// The same, with the stretches known where it bends sideways sharply.
    pub fn with_sharp_bends(mut self) -> Self {
        let sideways = self.deviations.iter().any(|(direction, _)| *direction == Direction::Lateral);
        let cells = if sideways { self.waves.cells() } else { &[] };
        let wanted: f64 = cells.iter().map(|cell| SHARP_LOOKS * (cell.to - cell.from) / cell.wave).sum();
        let share = (MOST / wanted.max(1.0)).min(1.0);
        let mut sharp = Sharp::default();
        for cell in cells {
            let count = (share * SHARP_LOOKS * (cell.to - cell.from) / cell.wave).ceil().max(1.0) as usize;
            for i in 0..=count {
                let s = cell.from + (cell.to - cell.from) * i as f64 / count as f64;
                let [_, _, bend, change] = self.deviation(s)[0];
                if !(bend.abs() > SHARP[0] || change.abs() > SHARP[1]) {
                    continue;
                }
                match sharp.stretches.last_mut() {
                    Some(last) if s - LEAD <= last.1 => last.1 = s + LEAD,
                    _ => sharp.stretches.push((s - LEAD, s + LEAD)),
                }
                let hollow = -bend * self.side.sign();
                if hollow > sharp.hollow.map_or(0.0, |(most, _)| most) {
                    sharp.hollow = Some((hollow, s));
                }
            }
        }
        self.sharp = Arc::new(sharp);
        self
    }

    /// Does it bend sideways sharply where a wheel at `s` [m] may touch it?
    #[inline]
    pub fn is_sharp_near(&self, s: f64) -> bool {
        let stretches = &self.sharp.stretches;
        if stretches.is_empty() {
            return false;
        }
        let before = stretches.partition_point(|stretch| stretch.1 < s);
        stretches.get(before).is_some_and(|stretch| stretch.0 <= s)
    }

    /// The sharpest hollow along its inner face [1/m], of those above [`SHARP`], and the distance at which it is [m].
    pub fn sharpest_hollow(&self) -> Option<(f64, f64)> {
        self.sharp.hollow
    }

    /// The largest upward curvature of its deviations [1/m] and the distance at which it is [m]; `None` where nothing bends it upwards.
    pub fn sharpest_bend(&self) -> Option<(f64, f64)> {
        let cells = self.waves.cells();
        let wanted: f64 = cells.iter().map(|cell| LOOKS * (cell.to - cell.from) / cell.wave).sum();
        let share = if self.deviations.is_empty() { return None } else { (MOST / wanted).min(1.0) };
        let mut sharpest: Option<(f64, f64)> = None;
        for cell in cells {
            let count = (share * LOOKS * (cell.to - cell.from) / cell.wave).ceil().max(1.0) as usize;
            for i in 0..=count {
                let s = cell.from + (cell.to - cell.from) * i as f64 / count as f64;
                let bend = self.deviation(s)[1][2];
                if bend > sharpest.map_or(0.0, |(most, _)| most) {
                    sharpest = Some((bend, s));
                }
            }
        }
        sharpest
    }
}

#[cfg(test)]
mod tests {
    use super::super::waves::Stretch;
    use super::super::{Deviation, DeviationShape};
    use super::*;
    use crate::geometry::Side;
    use crate::geometry::profile::{Profile, ProfilePoint};

    /// 1 mm high waves of 0.1 m between 4 and 5 m.
    #[derive(Debug)]
    struct Ripple;

    #[derive(Debug)]
    struct Flat;

    impl Profile for Flat {
        fn at(&self, _: f64) -> ProfilePoint {
            ProfilePoint::default()
        }

        fn range(&self) -> (f64, f64) {
            (-0.03, 0.03)
        }

        fn describe(&self) -> String {
            "flat".into()
        }
    }

    const NUMBER: f64 = 20.0 * std::f64::consts::PI;

    impl DeviationShape for Ripple {
        fn at(&self, s: f64) -> [f64; 4] {
            let (sin, cos) = (NUMBER * (s - 4.0)).sin_cos();
            if (4.0..5.0).contains(&s) {
                [1e-3 * sin, 1e-3 * NUMBER * cos, -1e-3 * NUMBER * NUMBER * sin, -1e-3 * NUMBER.powi(3) * cos]
            } else {
                [0.0; 4]
            }
        }

        fn breaks(&self) -> Vec<f64> {
            vec![4.0, 5.0]
        }

        fn waves(&self) -> Vec<Stretch> {
            vec![Stretch { from: 4.0, to: 5.0, wave: 0.1 }]
        }

        fn describe(&self) -> String {
            "ripple".into()
        }
    }

    #[test]
    fn analytic_ripple_bends_most_in_its_troughs() {
        let ripple = |direction| [Deviation { side: Side::Left, direction, shape: Arc::new(Ripple) }];
        let rail = |direction| {
            let profile = Arc::new(Flat);
            Rail::new(Side::Left, profile, 0.75, 0.0, &ripple(direction))
        };
        let (bend, s) = rail(Direction::Vertical).sharpest_bend().unwrap();
        assert!((bend / (1e-3 * NUMBER * NUMBER) - 1.0).abs() < 0.01, "{bend}");
        assert!(((s - 4.075) / 0.1).fract().abs() < 0.03, "{s}");
        assert!(rail(Direction::Lateral).sharpest_bend().is_none());
        let (hollow, s) = rail(Direction::Lateral).with_sharp_bends().sharpest_hollow().unwrap();
        assert!((hollow / (1e-3 * NUMBER * NUMBER) - 1.0).abs() < 0.01 && ((s - 4.025) / 0.1).fract().abs() < 0.09, "{hollow} at {s}");
        let sharp = |direction, places: [f64; 5]| {
            let rail = rail(direction).with_sharp_bends();
            places.map(|s| rail.is_sharp_near(s))
        };
        assert_eq!(sharp(Direction::Lateral, [3.8, 3.9, 4.5, 5.1, 5.2]), [false, true, true, true, false]);
        assert_eq!(sharp(Direction::Vertical, [3.8, 3.9, 4.5, 5.1, 5.2]), [false; 5]);
    }
}
