//! The steepest place on which a wheel can stand on its rail with its flange: the angle that guides it, of Nadal's limit.
//!
//! A wheel is lifted by its rail to the height at which it touches; moved across, outward by s, against the section of the rail (u and y outward, R the radius of the wheel):
//!
//! ```text
//! h(s) = max over y of ( z_rail(y) + R(y - s) ),   tan g(s) = z_rail'(y) = -R'(y - s)  where the maximum lies
//! ```
//!
//! The wheel's flank alone says too much where a worn face of the rail is less steep than it: the flank then never comes to stand on the rail with its own angle. Axles are taken level and square to the
//! track; climbing by 10 mm rolls one by 7 mrad, 0.4 degrees.

use crate::geometry::profile::Profile;

/// g, rad, and the steepest angle of the wheel's own flank that faces the rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuidingAngle {
    pub angle: f64,
    pub flank: f64,
}

/// Angles that differ by less are one, rad: 0.3 degrees.
const ALIKE: f64 = 5e-3;

impl GuidingAngle {
    /// Is it the rail's face that is less steep?
    pub fn limited_by_rail(&self) -> bool {
        self.flank - self.angle > ALIKE
    }
}

/// Places on the wheel's flank, and on the rail from its top inward.
const LOOKS: usize = 20_000;
const RAIL_LOOKS: usize = 4000;
/// Steps of the shift, m, and how many lie between those of the first look.
const STEP: f64 = 2e-5;
const COARSE: usize = 10;

/// Of a wheel on a rail whose section is inclined toward the track's centre by `inclination` [rad].
pub fn guiding_angle(wheel: &dyn Profile, rail: &dyn Profile, inclination: f64) -> GuidingAngle {
    let flank = steepest_flank(wheel);
    let (places, first) = (inner_half(rail, inclination), wheel.range().0.min(0.0));
    let touch = |shift: f64| {
        let lift = |place: &[f64; 3]| {
            let u = place[0] - shift;
            (first..=0.0).contains(&u).then(|| (place[1] + wheel.at(u).value, place[2], u))
        };
        let highest = places.iter().filter_map(lift).max_by(|a, b| a.0.total_cmp(&b.0));
        // At an end of either profile slopes say nothing of each other.
        highest.map_or(0.0, |(_, slope, u)| slope.min(-wheel.at(u).d1).max(0.0))
    };
    let Some(last) = places.last() else { return GuidingAngle { angle: flank, flank } };
    let count = ((-first - last[0]).max(0.0) / STEP) as usize;
    let at = |index: usize| touch(last[0] + STEP * index as f64);
    let coarse: Vec<f64> = (0..=count / COARSE).map(|index| at(COARSE * index)).collect();
    let best = (0..coarse.len()).max_by(|a, b| coarse[*a].total_cmp(&coarse[*b])).unwrap_or(0);
    let near = COARSE * best.saturating_sub(1)..=COARSE * (best + 1);
    let steepest = near.map(at).fold(coarse.get(best).copied().unwrap_or(0.0), f64::max);
    GuidingAngle { angle: steepest.atan().min(flank), flank }
}

/// Largest lean of a wheel profile on its flange's side, rad: the flank that faces the rail, not the flange's back.
fn steepest_flank(profile: &dyn Profile) -> f64 {
    let flank = profile.range().0.min(0.0);
    let slope = |k: usize| -profile.at(flank * k as f64 / LOOKS as f64).d1;
    let steepest = (0..=LOOKS).map(slope).filter(|slope| slope.is_finite()).fold(0.0, f64::max);
    steepest.atan()
}

/// The rail's section in the track's plane from its top inward, as far as it does not lean back: y outward, height and slope.
fn inner_half(rail: &dyn Profile, inclination: f64) -> Vec<[f64; 3]> {
    let (first, last) = rail.range();
    let (sin, cos) = inclination.sin_cos();
    let place = |index: usize| {
        let eta = last + (first - last) * index as f64 / RAIL_LOOKS as f64;
        let point = rail.at(eta);
        let [across, up] = [cos - point.d1 * sin, sin + point.d1 * cos];
        ([eta * cos - point.value * sin, eta * sin + point.value * cos, up / across], across)
    };
    let places: Vec<([f64; 3], f64)> = (0..=RAIL_LOOKS).map(place).collect();
    let top = (0..places.len()).max_by(|a, b| places[*a].0[1].total_cmp(&places[*b].0[1])).unwrap_or(0);
    places[top..].iter().take_while(|(_, across)| *across > 0.0).map(|(place, _)| *place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::profile::{self, Part};
    use crate::settings::{Section, Source};
    use std::sync::Arc;

    fn read(settings: &str, part: Part) -> Arc<dyn Profile> {
        let text = format!("profile = {settings}\n");
        let source = Source { file: "t".into(), text: text.clone(), overridden: vec![], folder: None };
        let document = toml_edit::Document::parse(text).unwrap();
        profile::parse(Section::root(document.as_table(), &source).section("profile").unwrap(), part).unwrap().profile
    }

    /// A head whose inner face leans by `face` [rad] from the vertical from 3 mm below its top on, under a round corner.
    #[derive(Debug)]
    struct Worn {
        face: f64,
    }

    impl Profile for Worn {
        fn at(&self, eta: f64) -> profile::ProfilePoint {
            let (radius, slope) = (13e-3, 1.0 / self.face.tan());
            // The arc meets the face where its slope is the face's.
            let meets = -radius * slope.atan().sin();
            let arc = |x: f64| (radius * radius - x * x).sqrt() - radius;
            match eta {
                x if x >= 0.0 => profile::ProfilePoint { value: -1e-3 * x, d1: -1e-3, d2: 0.0, d3: 0.0 },
                x if x >= meets => profile::ProfilePoint { value: arc(x), d1: -x / (radius * radius - x * x).sqrt(), d2: 0.0, d3: 0.0 },
                x => profile::ProfilePoint { value: arc(meets) + slope * (x - meets), d1: slope, d2: 0.0, d3: 0.0 },
            }
        }

        fn range(&self) -> (f64, f64) {
            (-35e-3, 35e-3)
        }

        fn describe(&self) -> String {
            "worn".into()
        }
    }

    /// On new rails a flange has its own angle, 70 degrees of S1002; on a face that is less steep it has the face's, with the inclination.
    #[test]
    fn analytic_a_flange_is_guided_by_the_less_steep_of_flank_and_face() {
        let wheel = read("{ kind = \"s1002\", radius = 0.46 }", Part::Wheel);
        for inclination in [0.0, 0.025, 0.05] {
            for kind in ["60e1", "60e2", "uic60"] {
                let found = guiding_angle(wheel.as_ref(), read(&format!("{{ kind = \"{kind}\" }}"), Part::Rail).as_ref(), inclination);
                println!("{kind}, {inclination} rad: {:.3} of {:.3} degrees", found.angle.to_degrees(), found.flank.to_degrees());
                assert!((found.angle.to_degrees() - 70.0).abs() < 0.1 && !found.limited_by_rail(), "{kind}: {found:?}");
            }
            for face in [20.0_f64, 26.0, 32.0, 45.0] {
                let found = guiding_angle(wheel.as_ref(), &Worn { face: face.to_radians() }, inclination);
                let by_hand = f64::min(90.0 - face + inclination.to_degrees(), 70.0);
                println!("face {face}, {inclination} rad: {:.3}, by hand {by_hand:.3} degrees", found.angle.to_degrees());
                assert!((found.angle.to_degrees() - by_hand).abs() < 0.2, "{face}: {found:?}");
                assert_eq!(found.limited_by_rail(), by_hand < 69.6, "{face}: {found:?}");
            }
        }
    }
}
