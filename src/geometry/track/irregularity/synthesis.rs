//! Random irregularities with a stated power spectral density.
//!
//! Each quantity is a sum of waves `sqrt(2 v_j) cos(2 pi f_j s + theta_j)` with f_j = j / P, v_j the variance that the
//! spectrum has within half a line spacing of f_j and within the band, and phases theta_j from the seed (ChaCha with 8 rounds,
//! one stream for each quantity: leaving one out changes no other). Over the period P the variance is that of the band exactly;
//! over a shorter length it scatters as that of any random process.
//!
//! The sum is made once, by a fast Fourier transform onto the coefficients of a spline of fifth degree ([`UniformSpline`]) with
//! ten knots in the shortest wave, and evaluated in constant time. The track *is* that spline, derivatives belong to it exactly;
//! from the sum of waves it differs by 4e-6 of the shortest wave's amplitude at most (1e-9 m for class 5), its third derivative by 2e-3.
//!
//! The period is 2^k knots, at least the covered length plus the longest wave and at least ten of the longest waves: no
//! part of the track is repeated, nor is its end related to its begin. Knots count from distance 0, so that a track
//! with other `from` and `to` is the same function of distance as long as the period is the same.
//! The fast Fourier transform uses no vector units, whose kind would change the last digits: the same seed gives the same track
//! on all machines, up to the rounding of their sine (1e-15 of the amplitude).

use super::spectrum::{self, Spectrum};
use super::window::{Window, Windowed};
use super::{Irregularity, Quantity, deviations, mean_and_difference};
use crate::geometry::track::waves::Stretch;
use crate::geometry::track::{DeviationShape, Direction};
use crate::math::uniform_spline::{BEFORE, BEHIND, UniformSpline, response};
use crate::settings::{Entry, Section, SettingsError, choose};
use crate::units::Dimension;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "spectrum",
    summary: "random, with the power spectral density of a track class and a `seed`, between the distances `from` and `to`",
    reference: "sum of waves with random phases: Shinozuka, Jan, J. Sound and Vibration 25 (1972) 111",
    parse,
};

/// Knots in the shortest wave.
const KNOTS_IN_WAVE: f64 = 10.0;
/// Fewest of the longest waves in a period: lines lie so near that spectra are nearly constant between them.
const WAVES_IN_PERIOD: f64 = 10.0;
/// Most knots of a period: at the usual 1.524 m 639 km, with 34 MB for each of four shapes while the sum is made.
const MOST_KNOTS: usize = 1 << 22;
/// Wavelengths that a scene may ask for, m.
const WAVELENGTHS: [f64; 2] = [0.1, 1e4];
/// Length over which irregularities begin and end unless the scene says otherwise, m.
const FADE: f64 = 50.0;

/// A sum of waves of one spectrum.
struct Synthesis<'a> {
    spectrum: &'a Spectrum,
    /// Shortest and longest wave, m.
    band: [f64; 2],
    /// Number of knots in a period, a power of two.
    knots: usize,
    /// Their distance, m.
    spacing: f64,
    seed: u64,
}

impl<'a> Synthesis<'a> {
    fn new(spectrum: &'a Spectrum, band: [f64; 2], length: f64, seed: u64) -> Option<Self> {
        let spacing = band[0] / KNOTS_IN_WAVE;
        let least = (length + band[1]).max(WAVES_IN_PERIOD * band[1]) / spacing;
        if !(least <= MOST_KNOTS as f64) {
            return None;
        }
        Some(Synthesis { spectrum, band, knots: (least.ceil() as usize).next_power_of_two(), spacing, seed })
    }

    /// P, m.
    fn period(&self) -> f64 {
        self.spacing * self.knots as f64
    }

    /// Variance [m2] of each line of a quantity, from f = 0 on.
    fn lines(&self, quantity: Quantity) -> impl Iterator<Item = f64> {
        let period = self.period();
        let (low, high) = (1.0 / self.band[1], 1.0 / self.band[0]);
        let last = (high * period + 0.5) as usize;
        (0..=last).map(move |line| {
            let middle = line as f64;
            let (from, to) = (((middle - 0.5) / period).max(low), ((middle + 0.5) / period).min(high));
            if from < to { self.spectrum.variance(quantity, from, to) } else { 0.0 }
        })
    }

    /// Coefficients of the spline over one period, m.
    fn coefficients(&self, quantity: Quantity) -> Vec<f64> {
        let mut seed = [0; 32];
        seed[..8].copy_from_slice(&self.seed.to_le_bytes());
        let mut random = ChaCha8Rng::from_seed(seed);
        random.set_stream(quantity.index() as u64);
        let mut waves = vec![Complex::new(0.0, 0.0); self.knots];
        for (line, variance) in self.lines(quantity).enumerate() {
            let phase = TAU * ((random.next_u64() >> 11) as f64 / (1u64 << 53) as f64);
            let amplitude = (2.0 * variance).sqrt() / response(TAU * line as f64 / self.knots as f64);
            waves[line] = Complex::from_polar(amplitude, phase);
        }
        FftPlannerScalar::new().plan_fft_inverse(self.knots).process(&mut waves);
        waves.into_iter().map(|wave| wave.re).collect()
    }
}

fn parse(section: &Section) -> Result<Irregularity, SettingsError> {
    let chosen = choose(spectrum::REGISTRY, section, "spectrum")?;
    let seed = read_seed(section)?;
    let (from, to) = (section.number("from", Dimension::Length)?, section.number("to", Dimension::Length)?);
    let window = Window::read(section, from, to, FADE)?;
    let band = read_band(section, &chosen.parse)?;
    let scale = section.number_or("scale", Dimension::None, 1.0)?;
    let names = section.words_or_all("quantities", &Quantity::NAMES)?;
    if names.is_empty() {
        return Err(section.error("quantities", "names nothing; expected one quantity or more"));
    }
    let Some(synthesis) = Synthesis::new(&chosen.parse, band, to - from, seed) else {
        return Err(
            section.error("to", format!("waves of {} m over {} m need too many knots; take a greater `shortest`", band[0], to - from))
        );
    };

    let first = (from / synthesis.spacing).floor() as i64 - BEFORE;
    let last = (to / synthesis.spacing).floor() as i64 + BEHIND;
    let wanted = Quantity::ALL.map(|quantity| names.contains(&Quantity::NAMES[quantity.index()]));
    let part = |quantity: Quantity| {
        wanted[quantity.index()].then(|| {
            let period = synthesis.coefficients(quantity);
            (first..=last).map(|knot| scale * period[knot.rem_euclid(synthesis.knots as i64) as usize]).collect::<Vec<f64>>()
        })
    };
    let variance = |quantity: Quantity| if wanted[quantity.index()] { synthesis.lines(quantity).sum() } else { 0.0f64 };
    let describe = |direction: Direction| {
        let (mean, difference) = mean_and_difference(direction);
        let rms = scale.abs() * (variance(mean) + 0.25 * variance(difference)).sqrt();
        format!(
            "spectrum {} with seed {seed}, waves of {} m to {} m, {:.3} mm rms, {}, repeats after {:.0} m",
            chosen.name,
            band[0],
            band[1],
            1e3 * rms,
            window.describe(),
            synthesis.period()
        )
    };
    let deviations = deviations(&Quantity::ALL.map(part), |_, direction, coefficients| {
        let spline = UniformSpline::new(synthesis.spacing, first, coefficients)
            .ok_or_else(|| section.error("to", "the irregularity covers less than a wave"))?;
        let waves = vec![Stretch { from: window.from, to: window.to, wave: band[0].min(2.0 * window.fade) }];
        Ok(Arc::new(Windowed { spline, window, description: describe(direction), waves }) as Arc<dyn DeviationShape>)
    })?;
    Ok(Irregularity { deviations, file: None, doubts: Vec::new() })
}

fn read_seed(section: &Section) -> Result<u64, SettingsError> {
    // Numbers of a scene are read as f64: whole up to 2^53.
    const MOST: f64 = 9_007_199_254_740_992.0;
    let seed = section.not_negative("seed", Dimension::None)?;
    if seed.fract() != 0.0 || seed > MOST {
        return Err(section.error("seed", format!("found {seed:?}, expected a whole number from 0 to 2^53")));
    }
    Ok(seed as u64)
}

/// Shortest and longest wave, m.
fn read_band(section: &Section, spectrum: &Spectrum) -> Result<[f64; 2], SettingsError> {
    let mut band = spectrum.band;
    for (value, key) in band.iter_mut().zip(["shortest", "longest"]) {
        *value = section.number_or(key, Dimension::Length, *value)?;
        if !(WAVELENGTHS[0]..=WAVELENGTHS[1]).contains(value) {
            return Err(section.error(key, format!("found {value} m, expected {} m to {} m", WAVELENGTHS[0], WAVELENGTHS[1])));
        }
    }
    if band[0] >= band[1] {
        return Err(section.error("longest", format!("found {} m, expected more than shortest = {} m", band[1], band[0])));
    }
    Ok(band)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Side;
    use crate::settings::Source;

    fn spectrum(name: &str) -> &'static Spectrum {
        &spectrum::REGISTRY.iter().find(|entry| entry.name == name).unwrap().parse
    }

    fn read(text: &str) -> Result<Irregularity, SettingsError> {
        let source = Source { file: "a.toml".into(), text: text.into(), overridden: vec![], folder: None };
        let document = toml_edit::Document::parse(text.to_string()).unwrap();
        super::super::parse(Section::root(document.as_table(), &source))
    }

    /// The rail's displacement.
    fn at(irregularity: &Irregularity, side: Side, direction: Direction, s: f64) -> [f64; 4] {
        irregularity.deviations.iter().find(|d| d.side == side && d.direction == direction).unwrap().shape.at(s)
    }

    const FRA5: &str = "kind = \"spectrum\"\nspectrum = \"fra5\"\nseed = 7\nfrom = 100\nto = 900\n";

    /// Root-mean-square irregularities that the open program OpenRailVehicleDynamics states for waves of 0.024 to 0.333
    /// cycles per metre, mm: here realised by the spline over a whole period.
    #[test]
    fn validate_realised_rms_of_fra_classes_5_and_6() {
        for (name, quantity, published) in
            [("fra5", Quantity::Alignment, 3.06242), ("fra5", Quantity::LongitudinalLevel, 5.07784), ("fra6", Quantity::Alignment, 2.04262)]
        {
            let synthesis = Synthesis::new(spectrum(name), [1.0 / 0.333, 1.0 / 0.024], 3000.0, 1).unwrap();
            let mut coefficients = synthesis.coefficients(quantity);
            coefficients.extend_from_within(..6);
            let spline = UniformSpline::new(synthesis.spacing, 0, coefficients).unwrap();
            let points = 4 * synthesis.knots;
            let squares = (0..points).map(|i| spline.at(synthesis.spacing * (2.0 + (i as f64 + 0.3) / 4.0))[0].powi(2)).sum::<f64>();
            let rms = 1e3 * (squares / points as f64).sqrt();
            println!("{name} {quantity:?}: {rms:.5} mm realised, {published} mm published, period {:.0} m", synthesis.period());
            assert!((rms / published - 1.0).abs() < 1e-5, "{name} {quantity:?}: {rms}");
        }
    }

    /// Power spectral density of the rails by Welch's method (Hann windows, half overlapping) against the formula. Octave by octave the
    /// estimate scatters by 1/sqrt(windows x lines); five times that is allowed, and 2 % for what the windows leak.
    #[test]
    fn validate_realised_spectrum_by_welchs_method() {
        const WINDOW: usize = 4096;
        const STEP: f64 = 0.3;
        for (name, band) in [("fra3", [1.524, 304.8]), ("ore_b176_high", [3.0, 150.0])] {
            let text = FRA5.replace("fra5", name).replace("900", "\"60 km\"");
            let track = read(&text).unwrap();
            let windows = 2 * ((59.7e3 / STEP) as usize / WINDOW) - 2;
            for quantity in Quantity::ALL {
                let value = |s: f64| {
                    let rail = |side, direction| at(&track, side, direction, s)[0];
                    let (y, z) = (
                        (rail(Side::Left, Direction::Lateral), rail(Side::Right, Direction::Lateral)),
                        (rail(Side::Left, Direction::Vertical), rail(Side::Right, Direction::Vertical)),
                    );
                    match quantity {
                        Quantity::Alignment => 0.5 * (y.0 + y.1),
                        Quantity::LongitudinalLevel => 0.5 * (z.0 + z.1),
                        Quantity::CrossLevel => z.0 - z.1,
                        Quantity::Gauge => y.0 - y.1,
                    }
                };
                let mut density = vec![0.0; WINDOW / 2];
                let transform = FftPlannerScalar::new().plan_fft_forward(WINDOW);
                for window in 0..windows {
                    let begin = 150.0 + STEP * (window * WINDOW / 2) as f64;
                    let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / WINDOW as f64).cos();
                    let mut samples: Vec<_> = (0..WINDOW).map(|i| Complex::new(hann(i) * value(begin + STEP * i as f64), 0.0)).collect();
                    transform.process(&mut samples);
                    // One-sided; the squares of the window have the mean 3/8.
                    for (sum, line) in density.iter_mut().zip(&samples) {
                        *sum += line.norm_sqr() * 2.0 * STEP / (0.375 * WINDOW as f64 * windows as f64);
                    }
                }
                let width = 1.0 / (STEP * WINDOW as f64);
                // Four lines from the edges of the band.
                let (mut low, edge) = (1.0 / band[1] + 4.0 * width, 1.0 / band[0] - 4.0 * width);
                while low < edge {
                    let high = (2.0 * low).min(edge);
                    let lines = (low / width).ceil() as usize..(high / width).floor() as usize;
                    let count = lines.len();
                    if count >= 3 {
                        let found: f64 = lines.clone().map(|line| density[line] * width).sum();
                        let wanted: f64 = lines
                            .map(|line| {
                                let middle = line as f64 * width;
                                spectrum(name).variance(quantity, middle - 0.5 * width, middle + 0.5 * width)
                            })
                            .sum();
                        let scatter = 1.0 / (windows as f64 * count as f64).sqrt();
                        println!("{name} {quantity:?} {:.1} m to {:.1} m: {:.4} +- {scatter:.4}", 1.0 / low, 1.0 / high, found / wanted);
                        assert!((found / wanted - 1.0).abs() < 5.0 * scatter + 0.02, "{name} {quantity:?} {low}: {}", found / wanted);
                    }
                    low = high;
                }
            }
        }
    }

    #[test]
    fn prop_derivatives_match_differences_and_ends_are_smooth() {
        let track = read(FRA5).unwrap();
        let h = 1e-4;
        for deviation in &track.deviations {
            let shape = &deviation.shape;
            for s in [100.4, 120.0, 149.99, 333.3, 500.123, 850.01, 899.0] {
                for d in 0..3 {
                    let slope = (shape.at(s + h)[d] - shape.at(s - h)[d]) / (2.0 * h);
                    let scale = [2e-3, 3e-3, 8e-3][d];
                    assert!(
                        (slope - shape.at(s)[d + 1]).abs() < 1e-6 * scale + 1e-7 * [0.0, 0.0, 1.0][d],
                        "{s} {d}: {slope} {:?}",
                        shape.at(s)
                    );
                }
            }
            for s in [100.0, 900.0, 0.0, -1e6, 1e9] {
                assert_eq!(shape.at(s), [0.0; 4]);
            }
            assert!(shape.breaks().is_empty());
            assert!(shape.at(100.01).iter().chain(&shape.at(899.99)).all(|value| value.abs() < 1e-7));
        }
    }

    #[test]
    fn prop_rails_are_made_of_the_four_quantities() {
        let all = read(FRA5).unwrap();
        let only = |names: &str| read(&format!("{FRA5}quantities = [{names}]\n")).unwrap();
        let (alignment, gauge) = (only("\"alignment\""), only("\"gauge\""));
        let (level, cross) = (only("\"longitudinal_level\""), only("\"cross_level\""));
        assert_eq!([&all, &alignment, &cross].map(|track| track.deviations.len()), [4, 2, 2]);
        for s in [130.0, 400.0, 777.7] {
            for side in Side::BOTH {
                let (y, z) = (at(&all, side, Direction::Lateral, s), at(&all, side, Direction::Vertical, s));
                let sum = |mean: &Irregularity, half: &Irregularity, direction| {
                    let (mean, half) = (at(mean, side, direction, s), at(half, side, direction, s));
                    [mean[0] + half[0], mean[1] + half[1]]
                };
                let (lateral, vertical) = (sum(&alignment, &gauge, Direction::Lateral), sum(&level, &cross, Direction::Vertical));
                for d in 0..2 {
                    assert!((y[d] - lateral[d]).abs() < 1e-15 && (z[d] - vertical[d]).abs() < 1e-15);
                }
            }
            // A wider gauge moves the left rail to the left; left and right mirror.
            let halves = Side::BOTH.map(|side| at(&gauge, side, Direction::Lateral, s)[0]);
            assert_eq!(halves[0], -halves[1]);
            let same = Side::BOTH.map(|side| at(&alignment, side, Direction::Lateral, s)[0]);
            assert_eq!(same[0], same[1]);
        }
    }

    #[test]
    fn regress_a_seed_gives_one_track() {
        let value = |text: &str| at(&read(text).unwrap(), Side::Left, Direction::Vertical, 456.7)[0];
        let here = value(FRA5);
        println!("{here:.17e}");
        // The sum of waves in Python, with a ChaCha of its own; the spline differs by 4e-6 of the shortest waves.
        assert!((here - BY_PYTHON).abs() < 1e-9, "{here:e}");
        // Computed by this program when it was written: phases and spectra must never change unnoticed.
        assert!((here - PINNED).abs() < 1e-14, "{here:e}");
        assert_eq!(here, value(FRA5));
        // The same function of distance with other ends, as long as the period is the same; its negative with scale -1.
        assert!((here - value(&FRA5.replace("from = 100", "from = -300").replace("to = 900", "to = 2000"))).abs() < 1e-16);
        assert_eq!(-here, value(&format!("{FRA5}scale = -1.0\n")));
        assert!((here - value(&FRA5.replace("seed = 7", "seed = 8"))).abs() > 1e-5);
    }

    #[test]
    fn hard_wrong_settings_are_named() {
        let problem = |text: &str| read(text).unwrap_err().to_string();
        for (from, to, message) in [
            ("fra5", "fra7", "a.toml:2: spectrum: found \"fra7\" (did you mean"),
            ("seed = 7", "seed = 7.5", "a.toml:3: seed: found 7.5, expected a whole number"),
            ("seed = 7\n", "", "seed: is missing"),
            ("to = 900", "to = 50", "a.toml:5: to: found 50 m, expected more than 100 m"),
            ("to = 900", "to = 1e7", "need too many knots"),
            ("to = 900", "to = 1e30", "of at most 1e7 m either way"),
            ("to = 900", "to = 900\nshortest = 400", "longest: found 304.8 m, expected more than shortest = 400 m"),
            ("to = 900", "to = 900\nshortest = \"1 mm\"", "a.toml:6: shortest: found 0.001 m"),
            ("to = 900", "to = 900\nfade = 500", "a.toml:6: fade: found 500 m, expected at most half"),
            ("to = 900", "to = 900\nquantities = []", "a.toml:6: quantities: names nothing"),
            ("to = 900", "to = 900\nclass = 5", "a.toml:6: class: unknown key"),
        ] {
            let found = problem(&FRA5.replace(from, to));
            assert!(found.contains(message), "{found}");
        }
    }

    /// What a long track costs; printed, the memory asserted: 8 bytes for each knot and shape.
    #[test]
    fn regress_memory_of_50_km() {
        let begin = std::time::Instant::now();
        let track = read(&FRA5.replace("to = 900", "to = \"50.1 km\"")).unwrap();
        let made = begin.elapsed();
        let synthesis = Synthesis::new(spectrum("fra5"), [1.524, 304.8], 50e3, 7).unwrap();
        let knots = (50e3 / synthesis.spacing) as usize;
        println!("50 km: {made:?}, {:.1} MB, period {:.1} km", 32e-6 * knots as f64, 1e-3 * synthesis.period());
        assert_eq!((knots, synthesis.knots), (328_083, 1 << 19));
        let begin = std::time::Instant::now();
        let calls = 200_000;
        let sum: f64 = (0..calls).map(|i| track.deviations[i % 4].shape.at(200.0 + 0.2 * i as f64)[2]).sum();
        println!("one evaluation: {:.1} ns ({sum:.3e})", begin.elapsed().as_nanos() as f64 / calls as f64);
    }

    const PINNED: f64 = -5.490_629_713_720_412e-3;
    const BY_PYTHON: f64 = -5.490_629_463_239_563e-3;
}
