//! How sharply a rail bends upwards along the track: a wheel touches it at one place along the track only where it is less curved than the wheel.
//!
//! Above a rail of height z(s) a wheel of radius r, its centre at s0, has the gap `(s - s0)^2 / (2 r) - z(s)` to second order. That is
//! convex, with one least value, where `z'' < 1 / r` everywhere; elsewhere the wheel bridges the bend and stands on two places along the track.

use super::Rail;

/// Looks in the shortest wave.
const LOOKS: f64 = 24.0;
/// Looks at a rail at most; very long tracks with short waves are looked at more coarsely.
const MOST: f64 = 4e5;

impl Rail {
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
    use super::super::{Deviation, DeviationShape, Direction};
    use super::*;
    use crate::geometry::Side;
    use crate::geometry::profile::{Profile, ProfilePoint};
    use std::sync::Arc;

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
    }
}
