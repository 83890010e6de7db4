//! Power spectral density of even samples by Welch's method (P. D. Welch, IEEE Transactions on Audio and Electroacoustics 15, 1967): windows of Hann that overlap by half, each
//! without its mean, averaged; one-sided.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Frequency [Hz] and density [unit of the values squared, per Hz] from zero to half the sampling rate; `window` samples at a time (all where there are fewer).
/// `None` below two samples.
pub fn welch(values: &[f64], interval: f64, window: usize) -> Option<Vec<(f64, f64)>> {
    let size = window.min(values.len());
    if size < 2 || !(interval > 0.0) {
        return None;
    }
    let hann: Vec<f64> = (0..size).map(|k| 0.5 - 0.5 * (TAU * k as f64 / size as f64).cos()).collect();
    let power: f64 = hann.iter().map(|weight| weight * weight).sum();
    let transform = FftPlanner::new().plan_fft_forward(size);
    let step = size - size / 2;
    let begins: Vec<usize> = (0..=values.len() - size).step_by(step).collect();
    let mut density = vec![0.0; size / 2 + 1];
    for begin in &begins {
        let part = &values[*begin..begin + size];
        let mean = part.iter().sum::<f64>() / size as f64;
        let mut lines: Vec<Complex<f64>> =
            part.iter().zip(&hann).map(|(value, weight)| Complex::new(weight * (value - mean), 0.0)).collect();
        transform.process(&mut lines);
        density.iter_mut().zip(&lines).for_each(|(sum, line)| *sum += line.norm_sqr());
    }
    // What stands at both signs of a frequency is counted once, but for zero and half the rate.
    let sides = |line: usize| if line == 0 || 2 * line == size { 1.0 } else { 2.0 };
    let scale = interval / (power * begins.len() as f64);
    Some(density.iter().enumerate().map(|(line, sum)| (line as f64 / (interval * size as f64), sides(line) * scale * sum)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy 1.17.1: signal.welch(x, fs=200, nperseg=64) of x[k] = sin(0.3 k) + 0.5 cos(1.1 k) + 0.01 k, 300 samples; nperseg=63 has no line at half the rate.
    #[test]
    fn validate_welch_is_that_of_scipy() {
        let values: Vec<f64> = (0..300).map(f64::from).map(|k| (0.3 * k).sin() + 0.5 * (1.1 * k).cos() + 0.01 * k).collect();
        for (window, expected) in [(64, SCIPY_64), (63, SCIPY_63)] {
            let found = welch(&values, 1.0 / 200.0, window).unwrap();
            assert_eq!(found.len(), window / 2 + 1);
            for (line, frequency, density) in expected {
                let (f, d) = found[line];
                assert!((f - frequency).abs() < 1e-12 * frequency.max(1.0) && (d / density - 1.0).abs() < 1e-6, "{window} {line}: {f} {d}");
            }
        }
        assert!(welch(&[1.0], 0.1, 8).is_none() && welch(&[1.0, 2.0], 0.1, 8).unwrap().len() == 2);
    }

    const SCIPY_64: [(usize, f64, f64); 6] = [
        (0, 0.0, 3.1747964190614e-05),
        (1, 3.125, 0.0025123247841917964),
        (3, 9.375, 0.10636708164288203),
        (11, 34.375, 0.025256347459392522),
        (20, 62.5, 2.0198805526023417e-09),
        (32, 100.0, 7.323254157515443e-12),
    ];
    const SCIPY_63: [(usize, f64, f64); 6] = [
        (0, 0.0, 5.859740446069658e-06),
        (1, 3.1746031746031744, 0.00237972784776541),
        (3, 9.523809523809524, 0.1050879627536753),
        (11, 34.92063492063492, 0.026219034901907332),
        (20, 63.49206349206349, 9.152403587295926e-11),
        (31, 98.4126984126984, 5.00021010410103e-13),
    ];
}
