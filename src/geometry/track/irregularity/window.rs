//! The part of the track that an irregularity covers, with smooth ends.
//!
//! An irregularity f becomes w f, w rising from 0 to 1 over the length `fade` behind `from` and falling likewise before `to`
//! ([`smooth_step`]); derivatives by the product rule, so that w f has the smoothness of f and is exactly zero outside.

use crate::geometry::track::DeviationShape;
use crate::geometry::track::waves::Stretch;
use crate::math::monotone_spline::MonotoneSpline;
use crate::math::smooth_step::{smooth_step, weighted};
use crate::math::spline::CubicSpline;
use crate::math::uniform_spline::UniformSpline;
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// Where an irregularity acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    /// Distances, m.
    pub from: f64,
    pub to: f64,
    /// Length over which it grows and vanishes, m.
    pub fade: f64,
}

impl Window {
    /// Reads `fade`; without it, it is `usual` [m] or a quarter of the length, whichever is shorter.
    pub fn read(section: &Section, from: f64, to: f64, usual: f64) -> Result<Self, SettingsError> {
        let length = to - from;
        if !(length > 0.0) {
            return Err(section.error("to", format!("found {to} m, expected more than {from} m, where the irregularity begins")));
        }
        if !section.has("fade") {
            return Ok(Window { from, to, fade: usual.min(0.25 * length) });
        }
        let fade = section.positive("fade", Dimension::Length)?;
        if 2.0 * fade > length {
            return Err(
                section.error("fade", format!("found {fade} m, expected at most half of the {length} m that the irregularity covers"))
            );
        }
        Ok(Window { from, to, fade })
    }

    /// Value and derivatives of w f at `s`, from those of f.
    #[inline]
    pub fn apply(&self, s: f64, f: impl FnOnce(f64) -> [f64; 4]) -> [f64; 4] {
        if !(s > self.from && s < self.to) {
            return [0.0; 4];
        }
        let value = f(s);
        let (behind, ahead) = (s - self.from, self.to - s);
        if behind >= self.fade && ahead >= self.fade {
            return value;
        }
        let (inward, sign) = if behind < ahead { (behind, 1.0) } else { (ahead, -1.0) };
        let rate = sign / self.fade;
        weighted(smooth_step(inward / self.fade), rate, value)
    }

    pub fn describe(&self) -> String {
        format!("from {} m to {} m, fading over {} m", self.from, self.to, self.fade)
    }
}

/// What a window can be laid over: a value with its first three derivatives.
pub(super) trait Spline: Send + Sync + std::fmt::Debug {
    fn at(&self, s: f64) -> [f64; 4];

    /// Is it zero everywhere?
    fn is_zero(&self) -> bool;
}

impl Spline for CubicSpline {
    #[inline]
    fn at(&self, s: f64) -> [f64; 4] {
        CubicSpline::at(self, s)
    }

    fn is_zero(&self) -> bool {
        CubicSpline::is_zero(self)
    }
}

impl Spline for MonotoneSpline {
    fn at(&self, s: f64) -> [f64; 4] {
        MonotoneSpline::at(self, s)
    }

    fn is_zero(&self) -> bool {
        MonotoneSpline::is_zero(self)
    }
}

impl Spline for UniformSpline {
    #[inline]
    fn at(&self, s: f64) -> [f64; 4] {
        UniformSpline::at(self, s)
    }

    fn is_zero(&self) -> bool {
        UniformSpline::is_zero(self)
    }
}

/// A spline under its window, as a displacement of a rail.
#[derive(Debug)]
pub(super) struct Windowed<S> {
    pub spline: S,
    pub window: Window,
    pub description: String,
    /// How short its waves are.
    pub waves: Vec<Stretch>,
}

impl<S: Spline> DeviationShape for Windowed<S> {
    #[inline]
    fn at(&self, s: f64) -> [f64; 4] {
        self.window.apply(s, |s| self.spline.at(s))
    }

    fn acts(&self) -> Option<(f64, f64)> {
        (!self.spline.is_zero()).then_some((self.window.from, self.window.to))
    }

    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }

    fn waves(&self) -> Vec<Stretch> {
        self.waves.clone()
    }

    fn describe(&self) -> String {
        self.description.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_product_of_step_and_sine() {
        let window = Window { from: 5.0, to: 25.0, fade: 6.0 };
        let at = |s: f64| window.apply(s, |s| [s.sin(), s.cos(), -s.sin(), -s.cos()]);
        let h = 1e-4;
        for s in [5.5, 8.0, 10.999, 11.001, 15.0, 19.5, 24.0] {
            for d in 0..3 {
                let slope = (at(s + h)[d] - at(s - h)[d]) / (2.0 * h);
                assert!((slope - at(s)[d + 1]).abs() < 3e-7, "{s} {d}: {slope} {}", at(s)[d + 1]);
            }
        }
        assert!((at(8.0)[0] - 0.5 * 8f64.sin()).abs() < 1e-15);
        assert_eq!(at(15.0)[0], 15f64.sin());
        for s in [5.0, 25.0, -3.0, 1e9, f64::NAN] {
            assert_eq!(at(s), [0.0; 4]);
        }
        for s in [5.0 + 1e-5, 25.0 - 1e-5] {
            assert!(at(s).iter().all(|v| v.abs() < 1e-3), "{s}: {:?}", at(s));
        }
    }
}
