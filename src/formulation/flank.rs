//! How far a wheel may move outward until its flange meets its rail.
//!
//! Both in a plane across the track, the wheel standing on the rail's top: at each height h the rail's gauge face stands at `y_r(h)`, the flange at `y_w(h)` (both
//! outward from the middle of the track), and the way is the least `y_r - y_w`. What the wheel sinks or climbs by on the way, and its roll, are left out: 0.3 mm for
//! S1002 on 60E1. It says which wheels are near a strike; where they touch the search finds.

use super::Wheelset;
use super::wheel_search::flange_tip;
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Rail, Track};

/// Points on the rail's inner half and on the flange.
const POINTS: usize = 200;
/// A flange begins where the wheel's profile is so steep, -: 30 degrees.
const STEEP: f64 = 0.577;

/// Of one wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Flank {
    /// How far it may move outward, m; infinity without a flange, or where it would not meet the rail.
    pub way: f64,
    /// Wheel coordinate of the flange's tip, m; minus infinity without a flange.
    pub tip: f64,
}

/// By wheel, the left one of each wheelset first. Wheels that are like the one before on the same side are not looked at anew.
pub(super) fn flanks(wheelsets: &[Wheelset], track: &Track) -> Vec<Flank> {
    let mut known: [Option<(&Wheel, Flank)>; 2] = [None; 2];
    let both = wheelsets.iter().flat_map(|wheelset| Side::BOTH.map(|side| wheelset.wheel(side)));
    both.map(|wheel| {
        let flank = match known[usize::from(wheel.side == Side::Right)] {
            Some((other, flank)) if wheel.is_like(other) => flank,
            _ => Flank { way: way_to_flange(wheel, track.rail(wheel.side)), tip: flange_tip(wheel.profile.as_ref()) },
        };
        known[usize::from(wheel.side == Side::Right)] = Some((wheel, flank));
        flank
    })
    .collect()
}

/// The way, m; infinity without a flange, or where it would not meet the rail.
fn way_to_flange(wheel: &Wheel, rail: &Rail) -> f64 {
    let (first, last) = rail.profile.range();
    let place = |k: usize| {
        let eta = first + (last - first) * k as f64 / POINTS as f64;
        let height = rail.profile.at(eta).value;
        (rail.across(eta, height), rail.outward.z * eta + rail.up.z * height)
    };
    // From the middle of the track outward: the gauge face goes up to the rail's top.
    let face: Vec<(f64, f64)> = (0..=POINTS).map(place).collect();
    let Some((top, highest)) = face.iter().copied().enumerate().max_by(|a, b| a.1.1.total_cmp(&b.1.1)).map(|(k, point)| (k, point.1))
    else {
        return f64::INFINITY;
    };
    let inner = &face[..=top];
    let (first, _) = wheel.profile.range();
    let tread = wheel.profile.at(0.0).value;
    let mut way = f64::INFINITY;
    for k in 0..POINTS {
        let u = first * (1.0 - k as f64 / POINTS as f64);
        let radius = wheel.profile.at(u);
        let height = highest + tread - radius.value;
        if -radius.d1 < STEEP {
            continue;
        }
        let above = inner.partition_point(|point| point.1 < height);
        if above == 0 || above == inner.len() {
            continue;
        }
        let [below, above] = [inner[above - 1], inner[above]];
        let across = below.0 + (above.0 - below.0) * (height - below.1) / (above.1 - below.1);
        way = way.min(across - (wheel.half_spacing + u));
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::profile::{Profile, ProfilePoint};
    use std::sync::Arc;

    /// Level, then a straight flank of the given slope inward of `-from`.
    #[derive(Debug)]
    struct Flanked {
        level: f64,
        from: f64,
        slope: f64,
    }

    impl Profile for Flanked {
        fn at(&self, x: f64) -> ProfilePoint {
            let (rise, d1) = if x < -self.from { (self.slope * (-self.from - x), -self.slope) } else { (0.0, 0.0) };
            ProfilePoint { value: self.level + rise, d1, d2: 0.0, d3: 0.0 }
        }

        fn range(&self) -> (f64, f64) {
            (-0.06, 0.04)
        }

        fn describe(&self) -> String {
            "straight flank".into()
        }
    }

    /// A flange that begins at 40 mm beside a gauge face at 35 mm, steeper than the flange: with both wheels' middles 1 mm apart they meet at the rail's edge after 5 - 1 mm.
    /// With the rail laid over by f the wheel stands on its outer end, 40 mm sin f above its middle, and the edge is 75 mm sin f below that: the flange is further inward there.
    #[test]
    fn analytic_the_way_to_a_straight_flank() {
        let wheel = |slope| Wheel { side: Side::Left, profile: Arc::new(Flanked { level: 0.46, from: 0.04, slope }), half_spacing: 0.751 };
        let rail = |lean: f64| Rail::new(Side::Left, Arc::new(Flanked { level: 0.0, from: 0.035, slope: -5.0 }), 0.75, lean, &[]);
        let way = way_to_flange(&wheel(2.7), &rail(0.0));
        assert!((way - 4e-3).abs() < 2e-4, "{way}");
        assert_eq!(way_to_flange(&wheel(0.3), &rail(0.0)), f64::INFINITY, "no flange");
        let leaning = way_to_flange(&wheel(2.7), &rail(0.05));
        let expected = 4e-3 + 0.075 * 0.05f64.sin() / 2.7 + 0.035 * (1.0 - 0.05f64.cos());
        assert!((leaning - expected).abs() < 2e-4, "{leaning} {expected}");
    }
}
