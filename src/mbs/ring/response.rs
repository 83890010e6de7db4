//! What a ring does under forces that are known: harmonic ones at a place, and constant ones that travel.
//!
//! A force of 1 N that has travelled for ever with the speed V is, for a mode, a sum of harmonic forces `c_j e^{i k_j (x + V t)}`; with `D(w) = omega^2 - w^2 + i w C`
//!
//! ```text
//! q = sum_j D(k_j V)^-1 c_j e^{i k_j x}      q' = sum_j i k_j V D(k_j V)^-1 c_j e^{i k_j x}      (real parts for cosines, imaginary ones for sines)
//! ```
//!
//! Exact, with the ripple of the sleepers; for V = 0 it is the deflection at rest.

use super::waves::Family;
use super::{Placed, Ring};
use nalgebra::{Complex, DMatrix, DVector};

impl Ring {
    /// Displacement at `to` [m] for a harmonic force of 1 N at `from`, of the circular frequency `w` [rad/s], m/N.
    pub fn receptance(&self, from: f64, to: f64, w: f64) -> Complex<f64> {
        let [mut pushed, mut seen, mut slope] = [0; 3].map(|_| vec![0.0; self.modes()]);
        self.shapes(from, &mut pushed, &mut slope);
        self.shapes(to, &mut seen, &mut slope);
        let mut sum = Complex::default();
        for Placed { family, even, odd } in &self.families {
            for first in even.iter().chain(odd) {
                let force = DVector::from_fn(family.waves.len(), |i, _| Complex::from(pushed[first + i]));
                let Some(found) = dynamic(family, w).lu().solve(&force) else { continue };
                sum += found.iter().zip(&seen[*first..]).map(|(found, seen)| found * *seen).sum::<Complex<f64>>();
            }
        }
        sum
    }

    /// q and q' under a force of 1 N on the rail at `x` [m] that travels with `speed` [m/s]; both as long as there are modes.
    pub fn carried(&self, x: f64, speed: f64, q: &mut [f64], v: &mut [f64]) {
        q.fill(0.0);
        v.fill(0.0);
        for Placed { family, even, odd } in &self.families {
            for (j, k) in family.numbers.iter().enumerate() {
                let Some(found) = answer(family, j, *k * speed) else { continue };
                let turned = Complex::from_polar(1.0, k * x);
                for (own, found) in found.iter().enumerate() {
                    let (at, rate) = (found * turned, found * turned * Complex::new(0.0, k * speed));
                    if let Some(first) = even {
                        (q[first + own], v[first + own]) = (q[first + own] + at.re, v[first + own] + rate.re);
                    }
                    if let Some(first) = odd {
                        (q[first + own], v[first + own]) = (q[first + own] + at.im, v[first + own] + rate.im);
                    }
                }
            }
        }
    }

    /// Mean over a bay of the deflection under a harmonic force of 1 N, of the circular frequency `w` [rad/s], that travels with `speed` [m/s], m/N. A wave
    /// `e^(ikx)` of the rail feels `w - k V`.
    pub fn mean_receptance(&self, w: f64, speed: f64) -> Complex<f64> {
        let mut sum = Complex::default();
        for Placed { family, even, odd } in &self.families {
            let both = f64::from(u8::from(even.is_some()) + u8::from(odd.is_some()));
            for (j, k) in family.numbers.iter().enumerate() {
                let share = if *k == 0.0 { 1.0 } else { 0.5 * both };
                for own in [w - k * speed, w + k * speed] {
                    let Some(found) = answer(family, j, own) else { continue };
                    sum += found.iter().zip(&family.waves).map(|(found, wave)| found * wave.amplitudes[j]).sum::<Complex<f64>>()
                        * (0.5 * share);
                }
            }
        }
        sum
    }

    /// Mean over a bay of the deflection at a place by a force of 1 N that travels with `speed` [m/s], `ahead` [m] of it, m/N.
    pub fn mean_compliance(&self, ahead: f64, speed: f64) -> f64 {
        let mut sum = 0.0;
        for Placed { family, even, odd } in &self.families {
            let both = f64::from(u8::from(even.is_some()) + u8::from(odd.is_some()));
            for (j, k) in family.numbers.iter().enumerate() {
                let Some(found) = answer(family, j, k * speed) else { continue };
                let share = if *k == 0.0 { 1.0 } else { 0.5 * both };
                let own: Complex<f64> = found.iter().zip(&family.waves).map(|(found, wave)| found * wave.amplitudes[j]).sum();
                sum += share * (own * Complex::from_polar(1.0, k * ahead)).re;
            }
        }
        sum
    }
}

/// D(w) of a family.
fn dynamic(family: &Family, w: f64) -> DMatrix<Complex<f64>> {
    let count = family.waves.len();
    DMatrix::from_fn(count, count, |i, j| {
        let own = if i == j { family.waves[i].square - w * w } else { 0.0 };
        Complex::new(own, w * family.damping[i * count + j])
    })
}

/// D(w)^-1 c_j.
fn answer(family: &Family, j: usize, w: f64) -> Option<DVector<Complex<f64>>> {
    let force = DVector::from_fn(family.waves.len(), |i, _| Complex::from(family.waves[i].amplitudes[j]));
    dynamic(family, w).lu().solve(&force)
}
