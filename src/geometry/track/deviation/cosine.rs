//! One full cosine wave: `amplitude / 2 (1 - cos(2 pi (s - from) / (to - from)))` between two distances.
//!
//! It is the haversine, `amplitude hav(2 pi (s - from) / (to - from))`, of bumps and dips: one formula under both names,
//! `cosine` as the paper's "sinusoidal gauge reduction" and `haversine` as bumps are usually called.

use super::{DeviationShape, Stretch, one_wave, read_extent};
use crate::settings::{Entry, Section, SettingsError};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "cosine",
    summary: "rises to `amplitude` and returns, A/2 (1 - cos), between the distances `from` and `to`",
    reference: "paper, section 3.4 (sinusoidal gauge reduction)",
    parse,
};

/// The same shape under its other name.
pub(super) const HAVERSINE: Entry<super::Parse> = Entry {
    name: "haversine",
    summary: "the same as `cosine`, the usual name for a bump or dip",
    reference: "paper, section 5 (bumps of Fig. 17)",
    parse,
};

/// `amplitude / 2 (1 - cos(2 pi (s - from) / (to - from)))`; zero elsewhere. Value and slope are continuous,
/// the second derivative jumps at both ends.
#[derive(Debug, Clone)]
pub struct CosineBump {
    /// Largest displacement, m.
    pub amplitude: f64,
    /// Distance where it begins, m.
    pub from: f64,
    /// Distance where it ends, m.
    pub to: f64,
}

impl DeviationShape for CosineBump {
    #[inline]
    fn at(&self, s: f64) -> [f64; 4] {
        if !(s > self.from && s < self.to) {
            return [0.0; 4];
        }
        let wave_number = TAU / (self.to - self.from);
        let (sin, cos) = (wave_number * (s - self.from)).sin_cos();
        let half = 0.5 * self.amplitude;
        [half * (1.0 - cos), half * wave_number * sin, half * wave_number.powi(2) * cos, -half * wave_number.powi(3) * sin]
    }

    fn acts(&self) -> Option<(f64, f64)> {
        (self.amplitude != 0.0).then_some((self.from, self.to))
    }

    fn breaks(&self) -> Vec<f64> {
        vec![self.from, self.to]
    }

    fn waves(&self) -> Vec<Stretch> {
        one_wave(self.amplitude, self.from, self.to)
    }

    fn describe(&self) -> String {
        format!("cosine, {:.4} mm from {} m to {} m", 1e3 * self.amplitude, self.from, self.to)
    }
}

fn parse(section: &Section) -> Result<Arc<dyn DeviationShape>, SettingsError> {
    // The steepest slope is pi A / L, a quarter from each end.
    let [amplitude, from, to] = read_extent(section, PI)?;
    Ok(Arc::new(CosineBump { amplitude, from, to }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_height_ends_and_derivatives() {
        let bump = CosineBump { amplitude: 0.01, from: 20.0, to: 30.0 };
        assert!((bump.at(25.0)[0] - 0.01).abs() < 1e-17);
        assert_eq!(bump.at(20.0), [0.0; 4]);
        let h = 1e-4;
        for s in [21.0, 23.7, 29.0] {
            for d in 0..3 {
                let slope = (bump.at(s + h)[d] - bump.at(s - h)[d]) / (2.0 * h);
                assert!((slope - bump.at(s)[d + 1]).abs() < 1e-9, "{s} {d}");
            }
        }
    }
}
