//! Butterworth's low-pass filter of fourth order, advanced exactly for an input that is linear over a step.
//!
//! ```text
//! H(s) = w^4 / prod_k (s - p_k) = sum_k r_k / (s - p_k),   p_k = w exp(i pi (5, 7, 9, 11)/8),   w = 2 pi f
//! z_k' = p_k z_k + u,   y = sum_k r_k z_k = 2 Re(r_1 z_1 + r_2 z_2)      (the poles are two pairs)
//! over a step D with u = m + g (t - D/2):
//!     z_k -> e^(p_k D) z_k + (e^(p_k D) - 1) (m - g D/2) / p_k + g (e^(p_k D) - 1 - p_k D) / p_k^2,   int z_k dt = (change of z_k - m D) / p_k
//! ```
//!
//! |H| = 1 / sqrt(1 + (frequency / f)^8): -3 dB at f, 24 dB per octave above; a slow signal comes 2.613 / w later, which is 21 ms for 20 Hz.
//!
//! Source: S. Butterworth, Wireless Engineer 7 (1930), 536-541; partial fractions derived here.

use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_8, TAU};

/// The filter's constants.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    /// One pole of each pair, 1/s.
    poles: [Complex<f64>; 2],
    /// Twice their residues, 1/s.
    residues: [Complex<f64>; 2],
}

/// Numbers of a filter's state: two complex ones.
pub const STATES: usize = 4;

impl LowPass {
    /// With the cut-off frequency `frequency`, Hz.
    pub fn new(frequency: f64) -> Self {
        let omega = TAU * frequency;
        let poles = [5.0, 7.0].map(|k| Complex::from_polar(omega, k * FRAC_PI_8));
        let residue = |own: usize| {
            let (p, other) = (poles[own], poles[1 - own]);
            Complex::from(2.0 * omega.powi(4)) / ((p - p.conj()) * (p - other) * (p - other.conj()))
        };
        LowPass { poles, residues: [residue(0), residue(1)] }
    }

    /// Puts the state where a constant input `u` leaves it.
    pub fn settle(&self, u: f64, state: &mut [f64]) {
        for (pair, pole) in state.as_chunks_mut::<2>().0.iter_mut().zip(self.poles) {
            let z = Complex::from(-u) / pole;
            *pair = [z.re, z.im];
        }
    }

    /// Advances the state over `step` [s] under an input of mean `mean` and constant `slope` [1/s]; gives the integral of the output.
    pub fn advance(&self, mean: f64, slope: f64, step: f64, state: &mut [f64]) -> f64 {
        let first = mean - 0.5 * slope * step;
        let mut integral = 0.0;
        for (pair, (pole, residue)) in state.as_chunks_mut::<2>().0.iter_mut().zip(self.poles.into_iter().zip(self.residues)) {
            let (before, growth) = (Complex::new(pair[0], pair[1]), (pole * step).exp());
            let after = growth * before + ((growth - 1.0) * first + (growth - 1.0 - pole * step) * slope / pole) / pole;
            integral += (residue * (after - before - mean * step) / pole).re;
            *pair = [after.re, after.im];
        }
        integral
    }

    /// Output for a state.
    pub fn output(&self, state: &[f64]) -> f64 {
        let pairs = state.as_chunks::<2>().0.iter();
        pairs.zip(self.residues).map(|(pair, residue)| (residue * Complex::new(pair[0], pair[1])).re).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitude of the output for a sine of `frequency`, after the transient.
    fn gain(frequency: f64, step: f64) -> f64 {
        let filter = LowPass::new(20.0);
        let mut state = [0.0; STATES];
        let (mut sums, mut count) = ([0.0; 2], 0.0);
        // Over whole periods, the input as its mean over each step.
        let steps = (4.0 / step).round() as usize;
        for k in 0..steps {
            let (from, to) = (k as f64 * step, (k + 1) as f64 * step);
            let mean = ((TAU * frequency * from).cos() - (TAU * frequency * to).cos()) / (TAU * frequency * step);
            filter.advance(mean, 0.0, step, &mut state);
            if to > 2.0 {
                let y = filter.output(&state);
                sums = [sums[0] + y * (TAU * frequency * to).sin(), sums[1] + y * (TAU * frequency * to).cos()];
                count += 0.5;
            }
        }
        sums[0].hypot(sums[1]) / count
    }

    #[test]
    fn analytic_butterworths_gain() {
        for frequency in [1.0, 10.0, 20.0, 40.0, 80.0] {
            let expected = 1.0 / (1.0 + (frequency / 20.0_f64).powi(8)).sqrt();
            let found = gain(frequency, 1e-4);
            println!("{frequency} Hz: {found:.6}, {expected:.6}");
            assert!((found / expected - 1.0).abs() < 1e-3, "{frequency}: {found} {expected}");
        }
        // At least 24 dB per octave above the cut-off, as the standard asks for.
        assert!(20.0 * (gain(40.0, 1e-4) / gain(80.0, 1e-4)).log10() > 24.0);
    }

    #[test]
    fn analytic_a_ramps_response_does_not_depend_on_the_steps_and_its_integral_is_that_of_the_output() {
        let filter = LowPass::new(20.0);
        let (mut once, mut often) = ([0.0; STATES], [0.0; STATES]);
        // From 2 to 4 in 50 ms.
        let whole = filter.advance(3.0, 40.0, 0.05, &mut once);
        let (mut parts, mut sum) = (0.0, 0.0);
        for k in 0..500 {
            let before = filter.output(&often);
            parts += filter.advance(2.0 + 40.0 * 1e-4 * (f64::from(k) + 0.5), 40.0, 1e-4, &mut often);
            sum += 0.5e-4 * (before + filter.output(&often));
        }
        assert!(once.iter().zip(&often).all(|(a, b)| (a - b).abs() < 1e-12), "{once:?} {often:?}");
        assert!((whole - parts).abs() < 1e-12 && (whole - sum).abs() < 1e-5, "{whole} {parts} {sum}");
        // Long after its begin a ramp comes out later by the delay, 2.613 / w, and not distorted.
        filter.advance(3.0 + 40.0 * 1.025, 40.0, 2.0, &mut once);
        let (end, delay) = (2.0 + 40.0 * 2.05, 2.613_126 / (TAU * 20.0));
        assert!((filter.output(&once) - (end - 40.0 * delay)).abs() < 1e-6, "{}", filter.output(&once));
        let mut settled = [0.0; STATES];
        filter.settle(3.0, &mut settled);
        assert!((filter.output(&settled) - 3.0).abs() < 1e-12 && (filter.advance(3.0, 0.0, 0.1, &mut settled) - 0.3).abs() < 1e-12);
    }
}
