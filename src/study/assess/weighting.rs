//! How much people feel of an acceleration, by its frequency.
//!
//! ISO 2631 (as EN 12299 and ISO 8041 have it), with p = s / (2 pi f), each section 1 at its pass band:
//!
//! ```text
//! band limits   p1^2 / (1 + sqrt2 p1 + p1^2),  1 / (1 + sqrt2 p2 + p2^2)          f1 = 0.4 Hz, f2 = 100 Hz
//! a-v           (1 + p3) / (1 + p3/Q4 + p3^2)                                     f3 = f4
//! upward step   (f5/f6)^2 (1 + p5/Q5 + p5^2) / (1 + p6/Q6 + p6^2)
//!
//!        f3 [Hz]  Q4    f5    Q5    f6    Q6    gain
//! Wb     16       0.55  2.5   0.90  4.0   0.95  1.024    vertical, in trains (ISO 2631-4)
//! Wd     2        0.63  -     -     -     -     1        horizontal
//! Wk     12.5     0.63  2.37  0.91  3.35  0.91  1        vertical (ISO 2631-1)
//! ```
//!
//! Sperling's comfort weighting, f in Hz, 0.588 vertical and 0.737 lateral:
//!
//! ```text
//! B(f)^2 = g^2 (1.911 f^2 + (0.25 f^2)^2) / ((1 - 0.277 f^2)^2 + (1.563 f - 0.0368 f^3)^2)
//!        = |g (sqrt(1.911) p + 0.25 p^2) / (1 + 1.563 p + 0.277 p^2 + 0.0368 p^3)|^2,   p = i f
//! ```
//!
//! which is a filter of third order (stable: 1.563 x 0.277 > 0.0368); its phase is not part of the definition and has no part in an rms. Images
//! are bilinear (`filter.rs`) at [`RATE`] or more, to which signals are refined: 0.3 dB of what is at 100 Hz then is lost, 0.01 dB at 20 Hz.
//!
//! Sources: ISO 8041-1:2017, Table 3 (numbers of Wb, Wd and Wk); ISO 2631-4:2001; EN 12299:2009, Annex C; Sperling's B(f) after
//! A. H. Wickens, Fundamentals of Rail Vehicle Dynamics (2003), and J. Förstberg, KTH TRITA-FKT 2000:28. The standards themselves were not at hand.

use super::filter::Filter;
use std::f64::consts::SQRT_2;

/// Least sampling rate of weighted signals, Hz.
pub const RATE: f64 = 1000.0;

/// A weighting of accelerations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    Wb,
    Wd,
    Wk,
    SperlingVertical,
    SperlingLateral,
}

impl Weighting {
    /// The filter for a sampling rate, Hz.
    pub fn filter(self, rate: f64) -> Filter {
        match self {
            Weighting::Wb => human(16.0, 0.55, Some([2.5, 0.90, 4.0, 0.95]), 1.024, rate),
            Weighting::Wd => human(2.0, 0.63, None, 1.0, rate),
            Weighting::Wk => human(12.5, 0.63, Some([2.37, 0.91, 3.35, 0.91]), 1.0, rate),
            Weighting::SperlingVertical => sperling(0.588, rate),
            Weighting::SperlingLateral => sperling(0.737, rate),
        }
    }
}

fn human(f3: f64, q4: f64, step: Option<[f64; 4]>, gain: f64, rate: f64) -> Filter {
    let band = |numerator, frequency| Filter::section(numerator, [1.0, SQRT_2, 1.0], frequency, rate);
    let limited = band([0.0, 0.0, gain], 0.4).then(band([1.0, 0.0, 0.0], 100.0));
    let weighted = limited.then(Filter::section([1.0, 1.0, 0.0], [1.0, 1.0 / q4, 1.0], f3, rate));
    match step {
        None => weighted,
        Some([f5, q5, f6, q6]) => {
            let ratio = f5 / f6;
            weighted.then(Filter::section([ratio * ratio, ratio / q5, 1.0], [1.0, 1.0 / q6, 1.0], f6, rate))
        }
    }
}

/// The denominator as `0.0368 (p + r) (p^2 + b p + c)`.
fn sperling(gain: f64, rate: f64) -> Filter {
    const CUBIC: f64 = 0.0368;
    let (mut low, mut high) = (0.0, 1.0);
    // r between 0 and 1 Hz, where the polynomial at -r passes zero.
    for _ in 0..60 {
        let r: f64 = 0.5 * (low + high);
        if 1.0 - r * (1.563 - r * (0.277 - CUBIC * r)) > 0.0 { low = r } else { high = r }
    }
    let r = 0.5 * (low + high);
    let (b, c) = (0.277 / CUBIC - r, 1.0 / (CUBIC * r));
    let w = c.sqrt();
    // p / (p + r) and (sqrt(1.911) + 0.25 p) / (p^2 + b p + c), in powers of p / r and p / w.
    let first = Filter::section([0.0, 1.0, 0.0], [1.0, 1.0, 0.0], r, rate);
    let scale = gain / CUBIC / c;
    first.then(Filter::section([scale * 1.911_f64.sqrt(), scale * 0.25 * w, 0.0], [1.0, b / w, 1.0], w, rate))
}

/// Sperling's Wz from the rms of the weighted acceleration [m/s2]: `(sum a^2 B^2)^(1/6.67)` with amplitudes in cm/s2, `4.42 rms^0.3`.
pub fn ride_index(rms: f64) -> f64 {
    (100.0 * SQRT_2 * rms).powf(0.3)
}

/// |B| of Sperling's weighting at a frequency [Hz], as published.
#[cfg(test)]
fn published(gain: f64, f: f64) -> f64 {
    let above = 1.911 * f * f + (0.25 * f * f).powi(2);
    gain * (above / ((1.0 - 0.277 * f * f).powi(2) + (1.563 * f - 0.0368 * f.powi(3)).powi(2))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn gain(weighting: Weighting, f: f64) -> f64 {
        let count = 40 * RATE as usize;
        let sine = |k: usize| (2.0 * PI * f * k as f64 / RATE).sin();
        let out = weighting.filter(RATE).of(&(0..count).map(sine).collect::<Vec<_>>());
        (2.0 * out[count / 2..].iter().map(|y| y * y).sum::<f64>() / (count / 2) as f64).sqrt()
    }

    #[test]
    fn validate_sperlings_filter_has_the_published_magnitude() {
        for f in [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0] {
            for (weighting, factor) in [(Weighting::SperlingVertical, 0.588), (Weighting::SperlingLateral, 0.737)] {
                let (found, expected) = (gain(weighting, f), published(factor, f));
                assert!((found / expected - 1.0).abs() < 5e-3, "{f} Hz: {found} {expected}");
            }
        }
    }

    /// Factors of ISO 2631-1:1997, Table 3 (in thousandths, at one-third octaves), and of ISO 2631-4 for Wb.
    #[test]
    fn validate_weighting_factors_at_one_third_octaves() {
        let known = [
            (Weighting::Wk, [(1.0, 0.482), (2.0, 0.531), (4.0, 0.967), (8.0, 1.036), (16.0, 0.768), (31.5, 0.405)]),
            (Weighting::Wd, [(1.0, 1.011), (2.0, 0.890), (4.0, 0.512), (8.0, 0.253), (16.0, 0.125), (31.5, 0.0632)]),
        ];
        for (weighting, factors) in known {
            for (f, factor) in factors {
                let found = gain(weighting, f);
                assert!((found / factor - 1.0).abs() < 0.01, "{weighting:?} {f} Hz: {found} {factor}");
            }
        }
        // Wb: 0.4 at low frequencies, 1.0 around 8 Hz.
        assert!((gain(Weighting::Wb, 1.0) / 0.388 - 1.0).abs() < 0.02 && (gain(Weighting::Wb, 8.0) / 1.03 - 1.0).abs() < 0.03);
    }

    #[test]
    fn analytic_a_ride_index_is_442_times_the_rms_to_the_03() {
        assert!((ride_index(1.0) - 4.42).abs() < 0.005 && (ride_index(0.2) / (4.417 * 0.2_f64.powf(0.3)) - 1.0).abs() < 1e-3);
    }
}
