//! Power spectral densities of irregularities.
//!
//! One form holds for both families, with O = 2 pi / wavelength [rad/m]:
//!
//! - alignment, longitudinal level: `S(O) = A Oc^2 / ((O^2 + Or^2) (O^2 + Oc^2))`
//! - cross level, gauge: `S(O) = A Oc^2 O^2 / ((O^2 + Or^2) (O^2 + Oc^2) (O^2 + Os^2))`
//!
//! S is one-sided [m2/(rad/m)]: the variance of the waves between two wavelengths is the integral of S over O > 0 between
//! them. A in m2 rad/m. Over frequency f = O / 2 pi [1/m] the density is `S_f(f) = 2 pi S(2 pi f)` [m3].
//!
//! FRA classes 1 to 6: Or = 0, A = k Aa for alignment, k Av for level, 4 k Av for cross level and gauge, k = 0.25, Aa and Av
//! in cm2 rad/m. ORE B176 (German spectra): the cross level is given as an angle, with A = Av / b^2 and b = 0.75 m half the
//! distance of the contact points; as the height 2 b times that angle it has A = 4 Av. The gauge coefficients Ag of ORE B176
//! rest on a single source. Sets that double from class to class (0.2095, 0.419, ...) are printed in places: they are wrong.

use super::Quantity;
use crate::settings::Entry;
use std::f64::consts::TAU;

/// Spectra of the four quantities.
#[derive(Clone, Copy, Debug)]
pub struct Spectrum {
    /// A of the four quantities, m2 rad/m.
    roughness: [f64; 4],
    /// Or, Oc, Os, rad/m.
    long_corner: f64,
    corner: f64,
    difference_corner: f64,
    /// Shortest and longest wavelength unless the scene says otherwise, m.
    pub band: [f64; 2],
}

/// FRA spectra describe waves of 5 ft to 1000 ft.
const FRA_BAND: [f64; 2] = [1.524, 304.8];
/// The source of the ORE B176 spectra names no band. Assumed: ranges D1 to D3 of EN 13848-1.
const ORE_BAND: [f64; 2] = [3.0, 150.0];

const fn fra(alignment: f64, vertical: f64, difference_corner: f64) -> Spectrum {
    // k, and square centimetres.
    const FACTOR: f64 = 0.25 * 1e-4;
    let (a, v) = (FACTOR * alignment, FACTOR * vertical);
    Spectrum { roughness: [a, v, 4.0 * v, 4.0 * v], long_corner: 0.0, corner: 0.8245, difference_corner, band: FRA_BAND }
}

const fn ore(alignment: f64, vertical: f64, gauge: f64) -> Spectrum {
    let roughness = [alignment, vertical, 4.0 * vertical, gauge];
    Spectrum { roughness, long_corner: 0.0206, corner: 0.8246, difference_corner: 0.4380, band: ORE_BAND }
}

const FRA_REFERENCE: &str = "FRA/AAR spectra, coefficients as in the open program OpenRailVehicleDynamics and three other public codes";
const ORE_REFERENCE: &str =
    "ORE (ERRI) B176, coefficients as quoted by OpenRailVehicleDynamics and four other public codes; gauge: one source";

const fn entry(name: &'static str, summary: &'static str, reference: &'static str, parse: Spectrum) -> Entry<Spectrum> {
    Entry { name, summary, reference, parse }
}

/// Every spectrum that a scene can name.
pub static REGISTRY: &[Entry<Spectrum>] = &[
    entry("fra1", "FRA track class 1, the roughest", FRA_REFERENCE, fra(3.3634, 1.2107, 0.6046)),
    entry("fra2", "FRA track class 2", FRA_REFERENCE, fra(1.2107, 1.0181, 0.9308)),
    entry("fra3", "FRA track class 3", FRA_REFERENCE, fra(0.4128, 0.6816, 0.8520)),
    entry("fra4", "FRA track class 4", FRA_REFERENCE, fra(0.3027, 0.5376, 1.1312)),
    entry("fra5", "FRA track class 5", FRA_REFERENCE, fra(0.0762, 0.2095, 0.8209)),
    entry("fra6", "FRA track class 6, the smoothest", FRA_REFERENCE, fra(0.0339, 0.0339, 0.4380)),
    entry("ore_b176_low", "ORE B176, low level of irregularity", ORE_REFERENCE, ore(2.119e-7, 4.032e-7, 5.32e-8)),
    entry("ore_b176_high", "ORE B176, high level of irregularity", ORE_REFERENCE, ore(6.125e-7, 1.080e-6, 1.032e-7)),
];

impl Spectrum {
    /// S(O) [m2/(rad/m)], one-sided, at the wave number `omega` > 0 [rad/m].
    pub fn density(&self, quantity: Quantity, omega: f64) -> f64 {
        let square = omega * omega;
        let common =
            self.roughness[quantity.index()] * self.corner.powi(2) / ((square + self.long_corner.powi(2)) * (square + self.corner.powi(2)));
        match quantity {
            Quantity::Alignment | Quantity::LongitudinalLevel => common,
            Quantity::CrossLevel | Quantity::Gauge => common * square / (square + self.difference_corner.powi(2)),
        }
    }

    /// Variance [m2] of the waves with frequencies between `low` and `high` [1/m], which lie near each other: three points
    /// of Gauss and Legendre. A bin as wide as a tenth of its frequency is off by 2e-7 of itself.
    pub fn variance(&self, quantity: Quantity, low: f64, high: f64) -> f64 {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let at = |x: f64| TAU * self.density(quantity, TAU * (middle + half * x));
        let outer = 0.6f64.sqrt();
        half / 9.0 * (5.0 * at(-outer) + 8.0 * at(0.0) + 5.0 * at(outer))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectrum(name: &str) -> Spectrum {
        REGISTRY.iter().find(|entry| entry.name == name).unwrap().parse
    }

    /// Variance of a whole band.
    fn band_variance(spectrum: &Spectrum, quantity: Quantity, low: f64, high: f64) -> f64 {
        let edge = |i: u32| low * (high / low).powf(f64::from(i) / 400.0);
        (0..400).map(|i| spectrum.variance(quantity, edge(i), edge(i + 1))).sum()
    }

    /// Root-mean-square irregularities that the open program OpenRailVehicleDynamics states for waves of 0.024 to 0.333
    /// cycles per metre, mm.
    #[test]
    fn validate_rms_of_fra_classes_5_and_6() {
        for (name, quantity, published) in [
            ("fra5", Quantity::Alignment, 3.06242),
            ("fra5", Quantity::LongitudinalLevel, 5.07784),
            ("fra6", Quantity::Alignment, 2.04262),
            ("fra6", Quantity::LongitudinalLevel, 2.04262),
        ] {
            let rms = 1e3 * band_variance(&spectrum(name), quantity, 0.024, 0.333).sqrt();
            println!("{name} {quantity:?}: {rms:.6} mm, published {published}");
            assert!((rms - published).abs() < 6e-6, "{name} {quantity:?}: {rms}");
        }
    }

    #[test]
    fn analytic_variance_in_closed_form() {
        // Partial fractions: 1/((x + r^2)(x + c^2)) and x/((x + r^2)(x + c^2)(x + s^2)), x = O^2, integrated over O.
        let atan = |omega: f64, corner: f64| (omega / corner).atan() / corner;
        for name in ["ore_b176_low", "ore_b176_high"] {
            let found = spectrum(name);
            let (r, c, s) = (0.0206f64, 0.8246f64, 0.4380f64);
            let (low, high) = (1.0 / 150.0, 1.0 / 3.0);
            for quantity in Quantity::ALL {
                let a = found.roughness[quantity.index()] * c * c;
                let primitive = |omega: f64| match quantity {
                    Quantity::Alignment | Quantity::LongitudinalLevel => a * (atan(omega, r) - atan(omega, c)) / (c * c - r * r),
                    _ => {
                        let share = |own: f64, other: f64, third: f64| {
                            -own * own / ((other * other - own * own) * (third * third - own * own)) * atan(omega, own)
                        };
                        a * (share(r, c, s) + share(c, r, s) + share(s, r, c))
                    }
                };
                let exact = primitive(TAU * high) - primitive(TAU * low);
                let sum = band_variance(&found, quantity, low, high);
                assert!((sum / exact - 1.0).abs() < 1e-9, "{name} {quantity:?}: {sum} {exact}");
            }
        }
    }

    /// The polynomial b0 / (a0 + a2 O^2 + a4 O^4) in which SIMPACK states the same spectra, as quoted by OpenRailVehicleDynamics.
    #[test]
    fn validate_ore_spectra_against_the_polynomial_form() {
        for (name, quantity, b0) in [
            ("ore_b176_low", Quantity::Alignment, 1.440846e-7),
            ("ore_b176_low", Quantity::LongitudinalLevel, 2.741619e-7),
            ("ore_b176_high", Quantity::Alignment, 4.164787e-7),
            ("ore_b176_high", Quantity::LongitudinalLevel, 7.343623e-7),
        ] {
            for omega in [0.02f64, 0.1, 1.0, 4.0] {
                let square = omega * omega;
                let published = b0 / (0.00028855 + 0.6803895 * square + square * square);
                // a0 and b0 are printed with five to seven digits.
                assert!((spectrum(name).density(quantity, omega) / published - 1.0).abs() < 2e-5, "{name} {quantity:?} {omega}");
            }
        }
    }

    #[test]
    fn analytic_cross_level_and_gauge_of_fra_have_four_times_the_vertical_coefficient() {
        for (class, corner) in [0.6046, 0.9308, 0.8520, 1.1312, 0.8209, 0.4380].into_iter().enumerate() {
            let found = spectrum(&format!("fra{}", class + 1));
            for omega in [0.05f64, 0.6, 3.0] {
                // S_c / S_v = 4 O^2 / (O^2 + Os^2).
                let ratio = 4.0 * omega * omega / (omega * omega + corner * corner);
                for quantity in [Quantity::CrossLevel, Quantity::Gauge] {
                    let measured = found.density(quantity, omega) / found.density(Quantity::LongitudinalLevel, omega);
                    assert!((measured / ratio - 1.0).abs() < 1e-12);
                }
            }
        }
    }
}
