//! Digital filters of evenly sampled signals: sections of second order in series, each the bilinear image of an analogue one.
//!
//! ```text
//! (b0 + b1 p + b2 p^2) / (a0 + a1 p + a2 p^2),   p = s / w,   p -> (1 - 1/z) / (1 + 1/z) / tan(w T / 2)
//! ```
//!
//! The image is exact at w (each section is warped at its own frequency). Filters run forward once (causal): a Butterworth filter then is 3 dB
//! down at its cut-off and falls by 24 dB per octave, which running it forth and back would double. Each section begins settled on its
//! first value. In the time domain for equal intervals; [`crate::formulation::low_pass`] is the same low pass for uneven steps of a run, with means
//! over steps as its input.
//!
//! Source: A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing (2010), 7.2; Butterworth's polynomials: S. Butterworth, Wireless
//! Engineer 7 (1930), 536-541.

use std::f64::consts::PI;

/// One section: numerator and denominator in powers of 1/z, the first of the denominator being 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Section {
    numerator: [f64; 3],
    denominator: [f64; 2],
}

impl Section {
    /// From the analogue one in powers of s/w, with w = 2 pi `frequency` [Hz], at the sampling `rate` [Hz].
    fn new(numerator: [f64; 3], denominator: [f64; 3], frequency: f64, rate: f64) -> Section {
        let c = 1.0 / (PI * frequency / rate).tan();
        let image = |[p0, p1, p2]: [f64; 3]| [p0 + c * (p1 + c * p2), 2.0 * (p0 - c * c * p2), p0 - c * (p1 - c * p2)];
        let (above, below) = (image(numerator), image(denominator));
        Section { numerator: above.map(|b| b / below[0]), denominator: [below[1] / below[0], below[2] / below[0]] }
    }

    /// Filters in place.
    fn run(&self, values: &mut [f64]) {
        let Some(first) = values.first().copied() else { return };
        let ([b0, b1, b2], [a1, a2]) = (self.numerator, self.denominator);
        let rest = first * (b0 + b1 + b2) / (1.0 + a1 + a2);
        let mut late = b2 * first - a2 * rest;
        let mut soon = b1 * first - a1 * rest + late;
        for value in values {
            let (x, y) = (*value, b0 * *value + soon);
            soon = b1 * x - a1 * y + late;
            late = b2 * x - a2 * y;
            *value = y;
        }
    }
}

/// Sections in series.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter(Vec<Section>);

impl Filter {
    /// Butterworth's low pass of fourth order, -3 dB at `frequency` [Hz], for signals of the sampling `rate` [Hz].
    pub fn low_pass(frequency: f64, rate: f64) -> Filter {
        Filter::butterworth([1.0, 0.0, 0.0], frequency, rate)
    }

    /// Low pass and high pass of fourth order in series, -3 dB (and what the other one adds) at both frequencies [Hz].
    pub fn band_pass([from, to]: [f64; 2], rate: f64) -> Filter {
        Filter::butterworth([0.0, 0.0, 1.0], from, rate).then(Filter::low_pass(to, rate))
    }

    fn butterworth(numerator: [f64; 3], frequency: f64, rate: f64) -> Filter {
        Filter([1.0, 3.0].map(|k| Section::new(numerator, [1.0, 2.0 * (k * PI / 8.0).sin(), 1.0], frequency, rate)).into())
    }

    /// One section in powers of s/w.
    pub fn section(numerator: [f64; 3], denominator: [f64; 3], frequency: f64, rate: f64) -> Filter {
        Filter(vec![Section::new(numerator, denominator, frequency, rate)])
    }

    /// This one and then another one.
    pub fn then(mut self, other: Filter) -> Filter {
        self.0.extend(other.0);
        self
    }

    /// What it makes of a signal.
    pub fn of(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        self.0.iter().for_each(|section| section.run(&mut values));
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Amplitude of the output for a sine, after the transient, over whole periods.
    fn gain(filter: &Filter, frequency: f64, rate: f64) -> f64 {
        let count = (rate * 40.0) as usize;
        let sine = |k: usize| (TAU * frequency * k as f64 / rate).sin();
        let out = filter.of(&(0..count).map(sine).collect::<Vec<_>>());
        let tail = count / 2..count;
        let parts = tail.clone().map(|k| (out[k] * sine(k), out[k] * (TAU * frequency * k as f64 / rate).cos()));
        let sums = parts.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        2.0 * sums.0.hypot(sums.1) / tail.len() as f64
    }

    #[test]
    fn analytic_butterworths_gain_with_warped_frequencies() {
        let rate = 500.0;
        let warped = |f: f64, cut: f64| (PI * f / rate).tan() / (PI * cut / rate).tan();
        for f in [0.2, 0.4, 1.0, 5.0, 10.0, 20.0, 40.0] {
            let low = 1.0 / (1.0 + warped(f, 20.0).powi(8)).sqrt();
            let found = gain(&Filter::low_pass(20.0, rate), f, rate);
            assert!((found - low).abs() < 1e-9, "{f} Hz: {found} {low}");
            let band = 1.0 / ((1.0 + warped(f, 10.0).powi(8)) * (1.0 + warped(f, 0.4).powi(-8))).sqrt();
            let found = gain(&Filter::band_pass([0.4, 10.0], rate), f, rate);
            assert!((found - band).abs() < 1e-4, "{f} Hz: {found} {band}");
        }
    }

    #[test]
    fn analytic_a_constant_is_settled_from_the_first_value_on() {
        let constant = [7.5; 50];
        assert!(Filter::low_pass(20.0, 200.0).of(&constant).iter().all(|y| (y - 7.5).abs() < 1e-12));
        assert!(Filter::band_pass([0.4, 10.0], 200.0).of(&constant).iter().all(|y| y.abs() < 1e-12));
        assert!(Filter::low_pass(20.0, 200.0).of(&[]).is_empty());
    }
}
