//! A linear axis with labels at round numbers. (That of the drawing library leaves some of them out.)

use super::short;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// An axis between two values with at most about `most` labels.
pub(super) struct Axis {
    pub range: (f64, f64),
    pub most: usize,
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let (low, high) = self.range;
        let place = (value - low) / (high - low);
        limit.0 + (f64::from(limit.1 - limit.0) * place).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        ticks(self.range.0, self.range.1, self.most)
    }

    fn range(&self) -> Range<f64> {
        self.range.0..self.range.1
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(value: &f64) -> String {
        short(*value)
    }
}

/// At most `most` round numbers at equal distances between two values.
fn ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    let least = (high - low) / most as f64;
    let decade = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|digit| digit * decade).find(|step| *step >= least).unwrap_or(least);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_ticks_are_round_and_none_is_missing() {
        let close = |found: Vec<f64>, wanted: &[f64]| {
            assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {wanted:?}");
        };
        close(ticks(0.0, 200.0, 11), &[0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0]);
        close(ticks(55.82, 56.77, 7), &[56.0, 56.2, 56.4, 56.6]);
        close(ticks(-49.9, 63.0, 4), &[0.0, 50.0]);
        close(ticks(-51.0, 63.0, 4), &[-50.0, 0.0, 50.0]);
        for (low, high) in [(-1e-9, 1e-9), (56.0, 56.0 + 1e-6), (0.0, 1.0), (-3e5, 2e4)] {
            let found = ticks(low, high, 6);
            assert!((2..=7).contains(&found.len()) && found.iter().all(|tick| (low..=high).contains(tick)), "{found:?}");
        }
    }
}
