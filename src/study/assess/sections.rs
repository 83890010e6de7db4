//! Track sections: stretches of one kind of track, cut to the standard's lengths.
//!
//! | zone | track | section | sections wanted |
//! |---|---|---|---|
//! | 1 | straight, and curves with at most 40 mm of cant deficiency | 250 m; 500 m above 220 km/h | 25 |
//! | 2 | R > 600 m | 100 m up to 140 km/h, 250 m up to 220 km/h, 500 m above | 25 |
//! | 3 | R = 400 to 600 m | 100 m | 50 |
//! | 4 | R = 250 to 400 m | 70 m | 25 |
//!
//! Curvature and cant are constant in a section; transitions belong to none. Curves below 250 m are no zone of the standard; they are told apart and cut
//! as zone 4. A stretch of at least 0.8 of the length makes one section; what is left behind the last whole one is left out.
//!
//! Source: EN 14363:2005, 5.4.2 and UIC 518:2005, 6.1 (lengths within 20 %, numbers of sections), as known from the literature; the texts were not at hand.

use crate::geometry::track::centre_line::CentreLine;
use serde::Serialize;
use std::sync::Arc;

/// Kind of track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Zone {
    Straight,
    LargeRadius,
    SmallRadius,
    VerySmallRadius,
    Tighter,
    /// Nobody said what the track is.
    Unknown,
}

impl Zone {
    pub const ALL: [Zone; 6] = [Zone::Straight, Zone::LargeRadius, Zone::SmallRadius, Zone::VerySmallRadius, Zone::Tighter, Zone::Unknown];

    /// In tables.
    pub fn words(self) -> &'static str {
        match self {
            Zone::Straight => "zone 1, straight",
            Zone::LargeRadius => "zone 2, R > 600 m",
            Zone::SmallRadius => "zone 3, R 400-600 m",
            Zone::VerySmallRadius => "zone 4, R 250-400 m",
            Zone::Tighter => "R < 250 m",
            Zone::Unknown => "track not given",
        }
    }

    /// Sections that its statistics ask for.
    pub fn wanted(self) -> usize {
        if self == Zone::SmallRadius { 50 } else { 25 }
    }

    /// Is it a curve with quasi-static forces to be looked at?
    pub fn is_curve(self) -> bool {
        matches!(self, Zone::LargeRadius | Zone::SmallRadius | Zone::VerySmallRadius | Zone::Tighter)
    }

    /// Length of its sections at a speed [m/s], m.
    pub fn length(self, speed: f64) -> f64 {
        let [slow, fast] = [140.0, 220.0].map(|limit| speed <= limit / 3.6 * (1.0 + 1e-9));
        match self {
            Zone::Straight => [500.0, 250.0][usize::from(fast)],
            Zone::LargeRadius => [[500.0, 250.0][usize::from(fast)], 100.0][usize::from(slow)],
            Zone::SmallRadius | Zone::Unknown => 100.0,
            Zone::VerySmallRadius | Zone::Tighter => 70.0,
        }
    }
}

/// A stretch of track of one kind, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Section {
    pub zone: Zone,
    pub from: f64,
    pub to: f64,
}

/// The track as far as sections need it.
#[derive(Clone, Debug)]
pub struct Track {
    /// `None`: straight and level.
    pub line: Option<Arc<CentreLine>>,
    /// Distance over which cant is counted (between the contact points), m.
    pub base: f64,
    /// m/s2.
    pub gravity: f64,
}

/// Distance of looks at the track, m, and changes per look below which curvature [1/m] and cant [rad] are constant.
const LOOK: f64 = 1.0;
const SAME: [f64; 2] = [2e-8, 2e-7];
/// Least part of a section that still is one.
const PART: f64 = 0.8;
/// What sections together may lack, m: cant is rounded over 2 m at nodes, so a curve of 1100 m between nodes is constant over up to 5 m less.
const ROUNDED: f64 = 5.0;
/// Radii are known so well, in parts of them: a curve of just 600 m is one of 400 to 600 m whatever the last digits of its curvature.
const ROUNDING: f64 = 1e-6;
/// Cant deficiency up to which a curve counts as straight, m.
const SLIGHT: f64 = 0.04;

impl Track {
    /// Curvature [1/m], left-hand positive, and sine of the cant angle, left rail up positive.
    pub(super) fn at(&self, s: f64) -> (f64, f64) {
        const REACH: f64 = 0.05;
        let Some(line) = &self.line else { return (0.0, 0.0) };
        let turn = line.frame(s + REACH).heading - line.frame(s - REACH).heading;
        (turn / (2.0 * REACH), line.frame(s).axes[(2, 1)])
    }

    fn zone(&self, (curvature, cant): (f64, f64), speed: f64) -> Zone {
        let deficiency = self.base * (speed * speed * curvature / self.gravity + cant).abs();
        let radius = 1.0 / curvature.abs().max(1e-9);
        match radius {
            radius if radius > 600.0 * (1.0 + ROUNDING) && deficiency <= SLIGHT * (1.0 + ROUNDING) => Zone::Straight,
            radius if radius > 600.0 * (1.0 + ROUNDING) => Zone::LargeRadius,
            radius if radius > 400.0 * (1.0 - ROUNDING) => Zone::SmallRadius,
            radius if radius > 250.0 * (1.0 - ROUNDING) => Zone::VerySmallRadius,
            _ => Zone::Tighter,
        }
    }

    /// Stretches of constant curvature and cant between two distances [m] at a speed [m/s].
    pub fn stretches(&self, from: f64, to: f64, speed: f64) -> Vec<Section> {
        let looks = ((to - from) / LOOK).floor().max(0.0) as usize;
        let mut found: Vec<Section> = Vec::new();
        let mut before = self.at(from);
        let mut begun = from;
        let mut close = |begun: f64, end: f64| {
            if end > begun {
                found.push(Section { zone: self.zone(self.at(0.5 * (begun + end)), speed), from: begun, to: end });
            }
        };
        for k in 1..=looks {
            let s = from + LOOK * k as f64;
            let here = self.at(s);
            if (here.0 - before.0).abs() > SAME[0] || (here.1 - before.1).abs() > SAME[1] {
                close(begun, s - LOOK);
                begun = s;
            }
            before = here;
        }
        close(begun, to);
        found
    }
}

/// Whole sections of the stretches.
pub fn cut(stretches: &[Section], speed: f64) -> Vec<Section> {
    let mut sections = Vec::new();
    for stretch in stretches {
        let (all, wanted) = (stretch.to - stretch.from, stretch.zone.length(speed));
        let count = ((all + ROUNDED) / wanted).floor() as usize;
        let (count, length) = if count == 0 && all >= PART * wanted { (1, all) } else { (count, wanted.min(all / count.max(1) as f64)) };
        sections.extend((0..count).map(|k| Section {
            zone: stretch.zone,
            from: stretch.from + length * k as f64,
            to: stretch.from + length * (k + 1) as f64,
        }));
    }
    sections
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    #[test]
    fn analytic_the_papers_curve_is_cut_into_straight_transition_and_full_curve() {
        let changes = ["vehicle.speed=20", "track.node[4].distance=1500 ft"].map(String::from);
        let scene = load::open("vehicle_curve", &changes).unwrap();
        let track = Track { line: scene.track.line.clone(), base: 1.5, gravity: 9.81 };
        let stretches = track.stretches(-300.0, 457.0, 20.0);
        let long: Vec<&Section> = stretches.iter().filter(|stretch| stretch.to - stretch.from > 5.0).collect();
        // 3 degrees of a 100 ft chord: R = 582 m; straight up to 100 ft, full curve from 200 ft.
        assert_eq!(long.iter().map(|stretch| stretch.zone).collect::<Vec<_>>(), [Zone::Straight, Zone::SmallRadius], "{stretches:?}");
        assert!((long[0].to - 30.48).abs() < 1.5 && (long[1].from - 60.96).abs() < 1.5 && long[1].to == 457.0, "{long:?}");
        let sections = cut(&stretches, 20.0);
        let of = |zone: Zone| sections.iter().filter(|section| section.zone == zone).count();
        assert_eq!((of(Zone::Straight), of(Zone::SmallRadius), sections.len()), (1, 4, 5));
    }

    /// Nodes eleven sections apart hold eleven, though cant is rounded at both; half a section less is one less.
    #[test]
    fn analytic_a_curve_of_whole_sections_is_all_of_them() {
        let of = |to: f64| {
            let sections = cut(&[Section { zone: Zone::LargeRadius, from: 1502.0, to }], 20.0);
            (sections.len(), sections.last().unwrap().to)
        };
        let length = Zone::LargeRadius.length(20.0);
        assert_eq!(of(1500.0 + 11.0 * length - 2.0), (11, 1500.0 + 11.0 * length - 2.0));
        assert_eq!(of(1502.0 + 10.5 * length), (10, 1502.0 + 10.0 * length));
    }

    #[test]
    fn analytic_zones_by_radius_and_cant_deficiency() {
        let track = Track { line: None, base: 1.5, gravity: 9.81 };
        let zone = |radius: f64, cant: f64, speed: f64| track.zone((1.0 / radius, cant / 1.5), speed);
        assert_eq!(zone(f64::INFINITY, 0.0, 80.0), Zone::Straight);
        // v^2/R/g x 1.5 m: 153 mm at 40 m/s on 1600 m; 120 mm of cant (left-hand curve: right rail higher) leave 33 mm.
        assert_eq!([zone(1600.0, 0.0, 40.0), zone(1600.0, -0.12, 40.0)], [Zone::LargeRadius, Zone::Straight]);
        assert_eq!([500.0, -300.0, 200.0].map(|r| zone(r, 0.0, 20.0)), [Zone::SmallRadius, Zone::VerySmallRadius, Zone::Tighter]);
        // Design radii on a border, with what differences of headings leave of them.
        for last in [-1e-9, 0.0, 1e-9] {
            let zones = [600.0, 400.0, -250.0].map(|r: f64| zone(r * (1.0 + last), 0.0, 20.0));
            assert_eq!(zones, [Zone::SmallRadius, Zone::SmallRadius, Zone::VerySmallRadius]);
            // A cant deficiency of just 40 mm.
            assert_eq!(zone(1.5 * 40.0 * 40.0 / (9.81 * 0.04) * (1.0 + last), 0.0, 40.0), Zone::Straight);
        }
        assert_eq!([600.1, 399.9, 249.9].map(|r| zone(r, 0.0, 25.0)), [Zone::LargeRadius, Zone::VerySmallRadius, Zone::Tighter]);
        assert_eq!([30.0, 50.0, 70.0].map(|v| Zone::LargeRadius.length(v)), [100.0, 250.0, 500.0]);
        assert_eq!([30.0, 70.0].map(|v| Zone::Straight.length(v)), [250.0, 500.0]);
        let stretch = |to: f64| cut(&[Section { zone: Zone::Straight, from: 0.0, to }], 30.0).iter().map(|s| s.to).collect::<Vec<_>>();
        assert_eq!((stretch(190.0), stretch(210.0), stretch(740.0)), (vec![], vec![210.0], vec![250.0, 500.0]));
    }
}
