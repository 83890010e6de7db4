//! Rails whose displacements begin behind the place where the vehicle starts (`track.start_fade`).

use crate::geometry::track::DeviationShape;
use crate::geometry::track::waves::Stretch;
use crate::math::smooth_step::{smooth_step, weighted};
use std::sync::Arc;

/// A deviation f times a weight w that rises from 0 at `from` to 1 over `length` in the direction of travel
/// ([`smooth_step`]); derivatives by the product rule.
#[derive(Debug)]
pub(super) struct Faded {
    pub shape: Arc<dyn DeviationShape>,
    /// m.
    pub from: f64,
    /// m.
    pub length: f64,
    /// Does the vehicle travel toward greater distances?
    pub forward: bool,
}

impl DeviationShape for Faded {
    fn at(&self, s: f64) -> [f64; 4] {
        let rate = if self.forward { 1.0 } else { -1.0 } / self.length;
        let along = (s - self.from) * rate;
        if !(along > 0.0) {
            return [0.0; 4];
        }
        let value = self.shape.at(s);
        if along >= 1.0 {
            return value;
        }
        weighted(smooth_step(along), rate, value)
    }

    fn acts(&self) -> Option<(f64, f64)> {
        let (first, last) = self.shape.acts()?;
        let acts = if self.forward { (first.max(self.from), last) } else { (first, last.min(self.from)) };
        (acts.0 < acts.1).then_some(acts)
    }

    fn breaks(&self) -> Vec<f64> {
        self.shape.breaks()
    }

    fn waves(&self) -> Vec<Stretch> {
        let [first, last] = if self.forward { [self.from, f64::INFINITY] } else { [f64::NEG_INFINITY, self.from] };
        let cut = |own: Stretch| Stretch { from: own.from.max(first), to: own.to.min(last), wave: own.wave.min(2.0 * self.length) };
        self.shape.waves().into_iter().map(cut).filter(|own| own.from < own.to).collect()
    }

    fn describe(&self) -> String {
        format!("{}, fading in over {} m from {} m on, where the vehicle starts", self.shape.describe(), self.length, self.from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Sine;

    impl DeviationShape for Sine {
        fn at(&self, s: f64) -> [f64; 4] {
            [s.sin(), s.cos(), -s.sin(), -s.cos()]
        }

        fn breaks(&self) -> Vec<f64> {
            Vec::new()
        }

        fn waves(&self) -> Vec<Stretch> {
            Vec::new()
        }

        fn describe(&self) -> String {
            "sine".into()
        }
    }

    #[test]
    fn analytic_a_faded_sine_and_its_derivatives() {
        for forward in [true, false] {
            let sign = if forward { 1.0 } else { -1.0 };
            let faded = Faded { shape: Arc::new(Sine), from: 3.0 * sign, length: 6.0, forward };
            let h = 1e-4;
            for s in [3.5, 5.0, 8.9, 9.1, 20.0].map(|s| sign * s) {
                for d in 0..3 {
                    let slope = (faded.at(s + h)[d] - faded.at(s - h)[d]) / (2.0 * h);
                    assert!((slope - faded.at(s)[d + 1]).abs() < 1e-6, "{s} {d}: {slope} {}", faded.at(s)[d + 1]);
                }
            }
            assert!((faded.at(6.0 * sign)[0] - 0.5 * (6.0 * sign).sin()).abs() < 1e-15);
            assert_eq!(faded.at(2.9 * sign), [0.0; 4]);
            assert_eq!(faded.at(11.0 * sign)[0], (11.0 * sign).sin());
        }
    }
}
