//! A wheel without its flange: what `effects.flange = "off"` makes of a profile.
//!
//! From where the profile first leans by [`LEAN`] toward the flange it goes on straight with that slope. Value and slope are continuous, the curvature jumps.

use super::{Bend, Profile, ProfilePoint};
use std::sync::Arc;

/// Slope at which the root of the flange begins: treads lean by less (S1002 by 6 deg at most), flanges by 60 to 75 deg.
const LEAN: f64 = 0.176_327; // tan 10 deg
/// Distance of readings, m.
const READING: f64 = 0.1e-3;

/// A profile whose flange is left out.
#[derive(Debug)]
pub struct Flangeless {
    whole: Arc<dyn Profile>,
    from: f64,
    edge: ProfilePoint,
    joints: Vec<f64>,
    bends: Vec<Bend>,
}

impl Flangeless {
    /// `None` where nothing leans so much.
    pub fn new(whole: Arc<dyn Profile>) -> Option<Self> {
        let (first, _) = whole.range();
        let leans = |u: f64| whole.at(u).d1 <= -LEAN;
        let mut low = (1..).map(|k| -READING * f64::from(k)).take_while(|u| *u > first).find(|u| leans(*u))?;
        let mut high = low + READING;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            (low, high) = if leans(middle) { (middle, high) } else { (low, middle) };
        }
        let edge = ProfilePoint { d2: 0.0, d3: 0.0, ..whole.at(high) };
        let jump = Bend { at: high, value: edge.value, slope: edge.d1 };
        let joints = [high].into_iter().chain(whole.joints().into_iter().filter(|at| *at > high)).collect();
        let bends = [jump].into_iter().chain(whole.bends().iter().filter(|bend| bend.at > high).copied()).collect();
        Some(Flangeless { whole, from: high, edge, joints, bends })
    }
}

impl Profile for Flangeless {
    fn at(&self, x: f64) -> ProfilePoint {
        match x >= self.from {
            true => self.whole.at(x),
            false => ProfilePoint { value: self.edge.value + self.edge.d1 * (x - self.from), ..self.edge },
        }
    }

    fn range(&self) -> (f64, f64) {
        self.whole.range()
    }

    fn describe(&self) -> String {
        format!("{}, straight from u = {:.1} mm on instead of its flange", self.whole.describe(), 1e3 * self.from)
    }

    fn joints(&self) -> Vec<f64> {
        self.joints.clone()
    }

    fn bends(&self) -> &[Bend] {
        &self.bends
    }

    fn left_out(&self) -> Option<(&Arc<dyn Profile>, f64)> {
        Some((&self.whole, self.from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::profile::tests::with_section;
    use crate::geometry::profile::{Cone, Part};

    #[test]
    fn prop_the_tread_stays_and_the_flange_goes_on_straight() {
        let whole =
            with_section("kind = \"s1002\"\nradius = 0.46\n", |section| crate::geometry::profile::parse(section.clone(), Part::Wheel))
                .unwrap()
                .profile;
        let cut = Flangeless::new(whole.clone()).unwrap();
        let (_, from) = cut.left_out().unwrap();
        println!("S1002 leans by 10 deg at u = {:.3} mm", 1e3 * from);
        assert!((-30e-3..-20e-3).contains(&from) && (whole.at(from).d1 + LEAN).abs() < 1e-9);
        for u in [30e-3, 0.0, -15e-3, from] {
            assert_eq!(cut.at(u).value, whole.at(u).value);
        }
        // The flange is 28 mm high; without it the radius grows by tan 10 deg.
        let tip = -50e-3;
        assert!(
            (cut.at(tip).value - whole.at(from).value - LEAN * (from - tip)).abs() < 1e-12
                && cut.at(tip).value < whole.at(tip).value - 10e-3
        );
        assert!(cut.joints().windows(2).all(|pair| pair[0] < pair[1]) && cut.joints()[0] == from);
        assert!(Flangeless::new(Arc::new(Cone { radius: 0.457, slope: 0.025 })).is_none());
    }
}
