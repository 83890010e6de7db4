//! A smooth ramp: 0 before `from`, `amplitude` after `to`, and it stays there.
//!
//! Between them `amplitude w((s - from) / (to - from))` with the step w of [`smooth_step`]: value and three derivatives are
//! continuous everywhere, so there are no breaks. The steepest slope is 35/16 amplitude / (to - from), in the middle.

use super::{DeviationShape, Stretch, one_wave, read_extent};
use crate::math::smooth_step::{LARGEST_RATE, smooth_step};
use crate::settings::{Entry, Section, SettingsError};
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "ramp",
    summary: "rises smoothly to `amplitude` between the distances `from` and `to` and stays there",
    reference: "polynomial of seventh degree, three continuous derivatives",
    parse,
};

/// A smooth step of a rail.
#[derive(Debug, Clone)]
pub struct Ramp {
    /// Displacement behind the ramp, m.
    pub amplitude: f64,
    /// Distance where it begins, m.
    pub from: f64,
    /// Distance where it ends, m.
    pub to: f64,
}

impl DeviationShape for Ramp {
    #[inline]
    fn at(&self, s: f64) -> [f64; 4] {
        let rate = 1.0 / (self.to - self.from);
        let [w, d1, d2, d3] = smooth_step(rate * (s - self.from));
        [self.amplitude * w, self.amplitude * rate * d1, self.amplitude * rate.powi(2) * d2, self.amplitude * rate.powi(3) * d3]
    }

    fn acts(&self) -> Option<(f64, f64)> {
        (self.amplitude != 0.0).then_some((self.from, f64::INFINITY))
    }

    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }

    fn waves(&self) -> Vec<Stretch> {
        one_wave(self.amplitude, self.from, self.to)
    }

    fn describe(&self) -> String {
        format!("ramp, {:.4} mm from {} m to {} m", 1e3 * self.amplitude, self.from, self.to)
    }
}

fn parse(section: &Section) -> Result<Arc<dyn DeviationShape>, SettingsError> {
    let [amplitude, from, to] = read_extent(section, LARGEST_RATE)?;
    Ok(Arc::new(Ramp { amplitude, from, to }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_height_steepest_slope_and_derivatives() {
        let ramp = Ramp { amplitude: -0.02, from: 10.0, to: 14.0 };
        assert_eq!(ramp.at(10.0), [0.0; 4]);
        assert_eq!(ramp.at(1e4), [-0.02, 0.0, 0.0, 0.0]);
        let [middle, slope, ..] = ramp.at(12.0);
        assert!((middle + 0.01).abs() < 1e-17 && (slope + 35.0 / 16.0 * 0.02 / 4.0).abs() < 1e-17);
        let h = 1e-4;
        for s in [10.3, 11.0, 13.9] {
            for d in 0..3 {
                let slope = (ramp.at(s + h)[d] - ramp.at(s - h)[d]) / (2.0 * h);
                assert!((slope - ramp.at(s)[d + 1]).abs() < 1e-8, "{s} {d}");
            }
        }
    }
}
