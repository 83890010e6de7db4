//! Ranges of axes, and round numbers on them with labels that differ.

/// An axis from `low` to `high`, which may be the smaller one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    pub log: bool,
}

/// Smallest and largest value; `None` where there is no number.
fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).map(|value| (value, value)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

impl Scale {
    fn linear((low, high): (f64, f64)) -> Scale {
        Scale { low, high, log: false }
    }

    /// From the smallest to the largest value.
    pub(super) fn tight(values: impl Iterator<Item = f64>) -> Scale {
        let (low, high) = extent(values).unwrap_or((0.0, 1.0));
        Scale::linear(if high > low { (low, high) } else { (low - 1.0, low + 1.0) })
    }

    /// With some air around the values; rounding of a constant is not blown up.
    pub(super) fn airy(values: impl Iterator<Item = f64>) -> Scale {
        let (low, high) = extent(values).unwrap_or((-1.0, 1.0));
        let air = (0.08 * (high - low)).max(1e-5 * low.abs().max(high.abs())).max(1e-9);
        Scale::linear((low - air, high + air))
    }

    /// The same about its middle, but at least so wide.
    pub(super) fn spanning(self, span: f64) -> Scale {
        let middle = 0.5 * (self.low + self.high);
        if self.high - self.low >= span { self } else { Scale::linear((middle - 0.5 * span, middle + 0.5 * span)) }
    }

    /// Logarithmic, with air around what is above zero.
    pub(super) fn decades(values: impl Iterator<Item = f64>) -> Scale {
        const AIR: f64 = 1.6;
        let (low, high) = extent(values.filter(|value| *value > 0.0)).unwrap_or((0.1 * AIR, 1.0 / AIR));
        Scale { low: low / AIR, high: high * AIR, log: true }
    }

    /// Place of a value, 0 to 1.
    pub(super) fn part(&self, value: f64) -> f64 {
        match self.log {
            true => (value / self.low).ln() / (self.high / self.low).ln(),
            false => (value - self.low) / (self.high - self.low),
        }
    }

    /// At most about `most` round numbers with their labels.
    pub(super) fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let (low, high) = (self.low.min(self.high), self.low.max(self.high));
        if self.log {
            let decades = |digits: &[u32]| -> Vec<(f64, String)> {
                let all = (low.log10().floor() as i32..=high.log10().floor() as i32)
                    .flat_map(|decade| digits.iter().map(move |digit| (*digit, decade)));
                let ticks = all.map(|(digit, decade)| format!("{digit}e{decade}").parse().unwrap_or(f64::NAN));
                ticks.filter(|tick| (low..=high).contains(tick)).map(|tick| (tick, power(tick))).collect()
            };
            let fine = decades(&[1, 2, 5]);
            match fine.len() {
                0..3 => {} // less than a decade: as on a linear axis
                few if few <= most.min(8) => return fine,
                _ => return decades(&[1]),
            }
        }
        let least = (high - low) / most as f64;
        let decade = 10f64.powf(least.log10().floor());
        let steps = [0.5, 1.0, 2.0, 5.0, 10.0].map(|digit| digit * decade);
        let found = steps.iter().skip(1).position(|step| *step >= least).map_or(4, |k| k + 1);
        let places = |step: f64| (low / step).ceil() as i64..=(high / step).floor() as i64;
        // A lone number tells no scale: rather one more than asked for.
        let step = if places(steps[found]).count() < 2 { steps[found - 1] } else { steps[found] };
        places(step).map(|place| place as f64 * step).map(|tick| (tick, label(tick, step, low.abs().max(high.abs())))).collect()
    }
}

/// A number on a logarithmic axis: 1e-7, 0.01, 10.
fn power(value: f64) -> String {
    if (1e-3..1e5).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}

/// A number on a linear axis with just the decimals that tell it from its neighbours, a `step` away.
fn label(value: f64, step: f64, largest: f64) -> String {
    let exponent = if (1e-3..1e5).contains(&largest) { 0 } else { largest.log10().floor() as i32 };
    let unit = 10f64.powi(exponent);
    let decimals = (-(step / unit * (1.0 + 1e-9)).log10().floor()).max(0.0) as usize;
    let digits = format!("{:.decimals$}", value / unit);
    match digits.trim_start_matches('-').chars().all(|letter| "0.".contains(letter)) {
        true => "0".into(),
        false if exponent == 0 => digits,
        false => format!("{digits}e{exponent}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, most: usize, log: bool) -> Vec<String> {
        Scale { low, high, log }.ticks(most).into_iter().map(|tick| tick.1).collect()
    }

    #[test]
    fn prop_ticks_are_round_and_none_is_missing() {
        assert_eq!(labels(0.0, 200.0, 5, false), ["0", "50", "100", "150", "200"]);
        assert_eq!(labels(200.0, -10.0, 5, false), ["0", "50", "100", "150", "200"], "from right to left");
        assert_eq!(labels(55.82, 56.77, 7, false), ["56.0", "56.2", "56.4", "56.6"]);
        assert_eq!(labels(-49.9, 63.0, 4, false), ["0", "50"]);
        assert_eq!(labels(-9.5, 9.0, 2, false), ["-5", "0", "5"], "a lone 0 tells no scale");
        assert_eq!(labels(-51.0, 63.0, 4, false), ["-50", "0", "50"]);
        assert_eq!(labels(-2.5e-7, 3e-7, 6, false), ["-2e-7", "-1e-7", "0", "1e-7", "2e-7", "3e-7"]);
        assert_eq!(labels(1.5, 60.0, 8, true), ["2", "5", "10", "20", "50"]);
        assert_eq!(labels(5e-7, 2.0, 8, true), ["1e-6", "1e-5", "1e-4", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(labels(2.1, 4.4, 5, true), ["2.5", "3.0", "3.5", "4.0"], "within a decade");
    }

    /// However narrow or far from zero a range is.
    #[test]
    fn prop_no_two_labels_are_equal() {
        for (low, high) in [(-1e-9, 1e-9), (56.0, 56.0 + 1e-5), (0.0, 1.0), (-3e5, 2e4), (1e6, 1e6 + 2.0), (-1e-4, 3e-5), (0.999, 1.001)] {
            let mut found = labels(low, high, 6, false);
            assert!((2..=7).contains(&found.len()), "{found:?}");
            found.dedup();
            assert_eq!(found.len(), labels(low, high, 6, false).len(), "{found:?}");
        }
    }

    #[test]
    fn prop_ranges_hold_their_values_with_air() {
        let values = || [3.0, f64::NAN, 5.0].into_iter();
        assert_eq!(Scale::tight(values()), Scale { low: 3.0, high: 5.0, log: false });
        let airy = Scale::airy(values());
        assert!(airy.low < 3.0 && airy.high > 5.0 && (airy.part(4.0) - 0.5).abs() < 1e-12);
        let still = Scale::airy([2.0, 2.0 + 1e-9].into_iter()).spanning(1e-3);
        assert!((still.high - still.low - 1e-3).abs() < 1e-12 && airy.spanning(1e-3) == airy, "{still:?}");
        let decades = Scale::decades([1e-3, 0.0, 10.0].into_iter());
        assert!(decades.low < 1e-3 && decades.high > 10.0 && (decades.part(0.1) - 0.5).abs() < 1e-12);
        for empty in [Scale::tight([].into_iter()), Scale::airy([f64::NAN].into_iter()), Scale::decades([-1.0].into_iter())] {
            assert!(empty.high > empty.low && !empty.ticks(5).is_empty(), "{empty:?}");
        }
    }
}
