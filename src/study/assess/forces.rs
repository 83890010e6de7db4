//! Wheel forces: running safety, track loading (EN 14363), derailment (Nadal), wheel unloading, wear.
//!
//! | quantity | filter | then | of a section |
//! |---|---|---|---|
//! | sum of Y | low pass 20 Hz | means over 2 m every 0.5 m | larger size of the 0.15 % and 99.85 % percentile |
//! | Y/Q (outward positive) | the same | the same | 99.85 % percentile |
//! | Q | low pass 20 Hz | | 99.85 % percentile |
//! | Y_qst, Q_qst | low pass 20 Hz | | 50 % percentile, outward positive, in full curves |
//! | instability | band pass f0 - 2 Hz .. f0 + 2 Hz of the sum of Y | rms over 100 m every 10 m | largest of the run; f0: the largest line of its spectrum from 2.4 to 10 Hz, or a larger one from 0.4 Hz on that has half of the signal's power |
//! | Nadal | Y/Q as above | largest of the whole run | over `(tan g - mu) / (1 + mu tan g)` |
//! | dQ/Q0 | low pass 20 Hz of Q | means over 2 m | `1 - smallest / Q0`, whole run |
//!
//! Low pass: Butterworth of fourth order, forward once (`filter.rs`). The quotient is filtered, not its parts. All wheels are looked at, not the leading outer one alone: the
//! row names the wheel that governs. Sources: EN 14363:2005, 5.5, Table 8; UIC 518:2005, Appendix; I. Persson, GENSYS course material on UIC 518 (filters and percentiles).

use super::filter::Filter;
use super::known::Axle;
use super::quantity::{self as q, Quantity};
use super::sections::{Section, Zone};
use super::statistics::{extreme, percentile, sliding_means};
use super::{COARSEST, Estimate, Made, OfSection, Row, Run, Trace, Verdict};
use crate::formulation::derailment_quotient;
use crate::geometry::Side;
use nalgebra::Vector3;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex;

/// EN 14363's low pass, Hz, and its window and step, m.
const CUT_OFF: f64 = 20.0;
const WINDOW: f64 = 2.0;
const STEP: f64 = 0.5;
/// The instability criterion: half width of its band, Hz, window and step, m, and where its frequency is looked for, Hz.
const HALF_BAND: f64 = 2.0;
const RMS_WINDOW: f64 = 100.0;
const RMS_STEP: f64 = 10.0;
const UNSTABLE: [f64; 2] = [2.4, 10.0];
/// Slower hunting (wagons, worn wheels at low speed) is a line from here on, Hz: within so much of its frequency it has a share of the signal's power, and next to nothing is slower. Track that
/// leads wheelsets aside spreads over the band, and a curve has most of its power in what is slowest.
const SLOWEST: f64 = 0.4;
const LINE_WIDTH: f64 = 0.15;
const LINE_SHARE: f64 = 0.5;
const SLOWER_SHARE: f64 = 0.2;

/// Forces of a wheelset, filtered.
struct Wheelset<'a> {
    name: String,
    axle: Option<&'a Axle>,
    distance: &'a [f64],
    /// Guiding forces outward positive, Q, their quotient; left and right, N.
    guiding: [Vec<f64>; 2],
    vertical: [Vec<f64>; 2],
    quotient: [Vec<f64>; 2],
    /// Sum of the guiding forces, left positive, N: filtered and as it came.
    sum: Vec<f64>,
    raw_sum: Vec<f64>,
}

/// A wheelset's name and a side.
fn wheel(name: &str, side: Side) -> String {
    format!("{name}.{}", side.name())
}

impl<'a> Wheelset<'a> {
    fn read(run: &Run<'a>, name: &str) -> Option<Wheelset<'a>> {
        let column = |of: &str| run.signals.column(&format!("{name}.{of}"));
        let force = |side: Side, of: &str| column(&format!("{}.{of}", side.name()));
        let low = Filter::low_pass(CUT_OFF, run.signals.rate());
        let [left, right] = Side::BOTH.map(|side| Some((side, force(side, "lateralForce")?, force(side, "verticalForce")?)));
        let sides = [left?, right?];
        let quotient = |side: Side, y: &[f64], z: &[f64]| -> Vec<f64> {
            y.iter().zip(z).map(|(y, z)| derailment_quotient(side, &Vector3::new(0.0, *y, *z))).collect()
        };
        let raw_sum: Vec<f64> = sides[0].1.iter().zip(sides[1].1).map(|(left, right)| -(left + right)).collect();
        Some(Wheelset {
            name: name.into(),
            axle: run.known.vehicle.as_ref().and_then(|vehicle| vehicle.axles.iter().find(|axle| axle.name == name)),
            distance: column("distance")?,
            guiding: sides.map(|(side, y, _)| low.of(&y.iter().map(|y| -side.sign() * y).collect::<Vec<_>>())),
            vertical: sides.map(|(_, _, z)| low.of(z)),
            quotient: sides.map(|(side, y, z)| low.of(&quotient(side, y, z))),
            sum: low.of(&raw_sum),
            raw_sum,
        })
    }

    /// The 2 m means of a signal within a section.
    fn means(&self, run: &Run, values: &[f64], section: &Section) -> Option<Vec<f64>> {
        let range = run.samples(self.distance, section)?;
        let means = sliding_means(&self.distance[range.clone()], &values[range], WINDOW, STEP);
        Some(means.into_iter().map(|mean| mean.1).collect())
    }

    /// The 2 m means of the whole run over distance.
    fn all_means(&self, values: &[f64]) -> Vec<(f64, f64)> {
        sliding_means(self.distance, values, WINDOW, STEP)
    }

    fn sides(&self) -> impl Iterator<Item = (Side, String)> + '_ {
        Side::BOTH.into_iter().map(|side| (side, wheel(&self.name, side)))
    }
}

/// Why there are no forces to look at.
fn missing(run: &Run) -> Option<String> {
    if run.signals.owners(".left.verticalForce").is_empty() || run.signals.owners(".left.lateralForce").is_empty() {
        return Some(
            "no columns W.left.verticalForce, W.left.lateralForce: interface.outputs = [\"motion\", \"wheels\", \"sensors\"]".into(),
        );
    }
    run.too_coarse(COARSEST, "for the low pass of 20 Hz")
}

const FORCES: [&Quantity; 8] = [&q::SUM_Y, &q::QUOTIENT, &q::INSTABILITY, &q::NADAL, &q::UNLOADING, &q::Q_MAX, &q::Y_QST, &q::Q_QST];

/// Rows of EN 14363 that need wheel forces.
pub(super) fn assess(made: &mut Made) {
    if let Some(why) = missing(made.run) {
        FORCES.iter().for_each(|quantity| made.nothing(quantity, &why));
        return;
    }
    let names = made.run.signals.owners(".left.verticalForce");
    let wheelsets: Vec<Wheelset> = names.iter().filter_map(|name| Wheelset::read(made.run, name)).collect();
    if wheelsets.is_empty() {
        let why = "no wheelset has distance, lateralForce and verticalForce of both wheels: interface.outputs = [\"motion\", \"wheels\", \"sensors\"]";
        FORCES.iter().for_each(|quantity| made.nothing(quantity, why));
        return;
    }
    safety(made, &wheelsets);
    instability(made, &wheelsets);
    nadal(made, &wheelsets);
    unloading(made, &wheelsets);
    loading(made, &wheelsets);
    traces(made, &wheelsets);
    // A value alone says that much.
    let by_load = |row: &&mut Row| row.verdict == Verdict::Value && [&q::SUM_Y, &q::INSTABILITY, &q::Q_MAX].contains(&row.quantity);
    for row in made.rows.iter_mut().filter(by_load) {
        row.note += "; its limit needs the axle load: --scene SCENE";
    }
}

fn safety(made: &mut Made, wheelsets: &[Wheelset]) {
    let run = made.run;
    let limit = |wheelset: &Wheelset| wheelset.axle.map(|axle| q::sum_of_guiding_forces(axle.load, run.known.kind));
    let sums: Vec<Box<OfSection>> = wheelsets.iter().map(|w| of(move |s| extreme(&w.means(run, &w.sum, s)?))).collect();
    let places: Vec<(String, Option<f64>, &OfSection)> =
        wheelsets.iter().zip(&sums).map(|(wheelset, of)| (wheelset.name.clone(), limit(wheelset), of.as_ref())).collect();
    made.zones(&q::SUM_Y, Estimate::Safety, &Zone::ALL, &places);
    by_wheel(
        made,
        wheelsets,
        &q::QUOTIENT,
        Estimate::Safety,
        &Zone::ALL,
        |_| Some(0.8),
        |w, side, section| percentile(&w.means(run, &w.quotient[side.index()], section)?, 99.85),
    );
}

fn of<'a>(value: impl Fn(&Section) -> Option<f64> + 'a) -> Box<OfSection<'a>> {
    Box::new(value)
}

/// A quantity of each wheel, by zone.
fn by_wheel(
    made: &mut Made,
    wheelsets: &[Wheelset],
    quantity: &'static Quantity,
    estimate: Estimate,
    zones: &[Zone],
    limit: impl Fn(&Wheelset) -> Option<f64>,
    value: impl Fn(&Wheelset, Side, &Section) -> Option<f64>,
) {
    let wheels: Vec<(String, Option<f64>, Box<OfSection>)> = wheelsets
        .iter()
        .flat_map(|wheelset| wheelset.sides().map(move |(side, name)| (wheelset, side, name)))
        .map(|(wheelset, side, name)| {
            let value = &value;
            (name, limit(wheelset), of(move |section| value(wheelset, side, section)))
        })
        .collect();
    let places: Vec<(String, Option<f64>, &OfSection)> =
        wheels.iter().map(|(name, limit, of)| (name.clone(), *limit, of.as_ref())).collect();
    made.zones(quantity, estimate, zones, &places);
}

fn loading(made: &mut Made, wheelsets: &[Wheelset]) {
    let run = made.run;
    let vertical = |w: &Wheelset| w.axle.map(|axle| q::vertical_force(0.5 * axle.load, run.admissible));
    by_wheel(made, wheelsets, &q::Q_MAX, Estimate::Loading, &Zone::ALL, vertical, |w, side, section| {
        percentile(&w.vertical[side.index()][run.samples(w.distance, section)?], 99.85)
    });
    let curves: Vec<Zone> = Zone::ALL.into_iter().filter(|zone| zone.is_curve()).collect();
    by_wheel(
        made,
        wheelsets,
        &q::Y_QST,
        Estimate::QuasiStatic,
        &curves,
        |_| Some(q::GUIDING_QST),
        |w, side, section| percentile(&w.guiding[side.index()][run.samples(w.distance, section)?], 50.0),
    );
    let quasi_static = |w: &Wheelset| w.axle.map(|axle| q::vertical_qst(0.5 * axle.load));
    by_wheel(made, wheelsets, &q::Q_QST, Estimate::QuasiStatic, &curves, quasi_static, |w, side, section| {
        percentile(&w.vertical[side.index()][run.samples(w.distance, section)?], 50.0)
    });
}

/// Largest rms of the sum of Y about its own frequency against half the limit of its extremes.
fn instability(made: &mut Made, wheelsets: &[Wheelset]) {
    let run = made.run;
    let found = wheelsets.iter().filter_map(|wheelset| {
        let travelled = wheelset.distance.last()? - wheelset.distance.first()?;
        let (f0, slower) = (travelled >= RMS_WINDOW).then(|| dominant(&wheelset.raw_sum, run.signals.rate()))??;
        let band = [(f0 - HALF_BAND).max(SLOWEST), f0 + HALF_BAND];
        let squares: Vec<f64> = Filter::band_pass(band, run.signals.rate()).of(&wheelset.raw_sum).iter().map(|y| y * y).collect();
        let means = sliding_means(wheelset.distance, &squares, RMS_WINDOW, RMS_STEP);
        let largest = means.iter().map(|mean| mean.1.max(0.0).sqrt()).reduce(f64::max)?;
        let limit = wheelset.axle.map(|axle| 0.5 * q::sum_of_guiding_forces(axle.load, run.known.kind));
        Some((wheelset, largest, limit, (f0, slower)))
    });
    let of_limit = |found: &(&Wheelset, f64, Option<f64>, _)| found.1 / found.2.unwrap_or(1.0);
    match found.max_by(|a, b| of_limit(a).total_cmp(&of_limit(b))) {
        Some((wheelset, value, limit, (f0, slower))) => {
            let beside = slower.map_or(String::new(), |line| format!("; a larger line at {line:.2} Hz is left out: not one motion's own"));
            made.value(&q::INSTABILITY, None, &wheelset.name, value, limit, format!("band about {f0:.2} Hz{beside}"));
        }
        None => made.nothing(&q::INSTABILITY, "rms over 100 m: longer run.stop"),
    }
}

/// Frequency of an unstable motion, Hz: that of the largest line of the spectrum from 2.4 to 10 Hz (Hann's window over the whole signal), or of a larger and slower one that
/// is the motion's own; and that of a larger and slower one that is not. `None` without a line in the band.
fn dominant(values: &[f64], rate: f64) -> Option<(f64, Option<f64>)> {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let hann = |k: usize| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / count as f64).cos();
    let mut line: Vec<Complex<f64>> = values.iter().enumerate().map(|(k, y)| Complex::new((y - mean) * hann(k), 0.0)).collect();
    FftPlannerScalar::new().plan_fft_forward(count).process(&mut line);
    let frequency = |k: usize| k as f64 * rate / count as f64;
    let power = |k: usize| line[k].norm_sqr();
    let within = |[from, to]: [f64; 2]| (0..count / 2).filter(move |k| (from..=to).contains(&frequency(*k)));
    let largest = |band: [f64; 2]| within(band).max_by(|a, b| power(*a).total_cmp(&power(*b)));
    let fast = largest(UNSTABLE)?;
    let Some(slow) = largest([SLOWEST, UNSTABLE[0]]).filter(|slow| power(*slow) > power(fast)) else {
        return Some((frequency(fast), None));
    };
    let own = frequency(slow);
    let sum = |band: [f64; 2]| within(band).map(power).sum::<f64>();
    let line = sum([(1.0 - LINE_WIDTH) * own, (1.0 + LINE_WIDTH) * own]);
    match line > LINE_SHARE * sum([SLOWEST, CUT_OFF]) && sum([0.5 * own, (1.0 - LINE_WIDTH) * own]) < SLOWER_SHARE * line {
        true => Some((own, None)),
        false => Some((frequency(fast), Some(own))),
    }
}

/// Y/Q against Nadal's limit of each wheel's own flange.
fn nadal(made: &mut Made, wheelsets: &[Wheelset]) {
    let Some(vehicle) = &made.run.known.vehicle else {
        return made.nothing(&q::NADAL, "needs the profile's angle and the friction: --scene SCENE");
    };
    let mut worst: Option<(String, f64, String)> = None;
    let mut why = "the run is shorter than 2 m".to_string();
    for wheelset in wheelsets {
        for (side, name) in wheelset.sides() {
            let Some(axle) = wheelset.axle else { continue };
            let [Some(first), Some(last)] = [wheelset.distance.first(), wheelset.distance.last()] else { continue };
            let (flange, friction) = (axle.flange[side.index()], vehicle.friction.largest(side, [*first, *last]));
            let degrees = flange.angle.to_degrees();
            let Some(limit) = q::nadal(flange.angle, friction) else {
                why = format!("{name} has no flange that guides: {degrees:.1} deg at most, friction {friction}");
                continue;
            };
            let means = wheelset.all_means(&wheelset.quotient[side.index()]);
            let Some(largest) = means.iter().map(|mean| mean.1).reduce(f64::max) else { continue };
            if worst.as_ref().is_none_or(|worst| largest / limit > worst.1) {
                let by_rail = match flange.limited_by_rail() {
                    true => format!(": the rail's face is less steep than the flange's {:.1}", flange.flank.to_degrees()),
                    false => String::new(),
                };
                worst = Some((
                    name,
                    largest / limit,
                    format!("limit {limit:.3} ({degrees:.1} deg{by_rail}, friction {friction}), largest Y/Q {largest:.3}"),
                ));
            }
        }
    }
    match worst {
        Some((name, value, note)) => made.value(&q::NADAL, None, &name, value, Some(1.0), note),
        None => made.nothing(&q::NADAL, &why),
    }
}

fn unloading(made: &mut Made, wheelsets: &[Wheelset]) {
    if made.run.known.vehicle.is_none() {
        return made.nothing(&q::UNLOADING, "needs the static wheel load: --scene SCENE");
    }
    let found = wheelsets.iter().flat_map(|wheelset| wheelset.sides().map(move |(side, name)| (wheelset, side, name))).filter_map(
        |(wheelset, side, name)| {
            let load = 0.5 * wheelset.axle?.load;
            let smallest = wheelset.all_means(&wheelset.vertical[side.index()]).iter().map(|mean| mean.1).reduce(f64::min)?;
            Some((name, 1.0 - smallest / load, format!("smallest Q {:.2} kN of {:.2} kN", 1e-3 * smallest, 1e-3 * load)))
        },
    );
    match found.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((name, value, note)) => made.value(&q::UNLOADING, None, &name, value, Some(0.6), note),
        None => made.nothing(&q::UNLOADING, "the run is shorter than 2 m"),
    }
}

/// Curves for the picture, of all wheelsets.
fn traces(made: &mut Made, wheelsets: &[Wheelset]) {
    for wheelset in wheelsets {
        let scaled = |quantity: &'static Quantity, place: String, points: Vec<(f64, f64)>| Trace {
            quantity,
            place,
            points: points.into_iter().map(|(s, value)| (s, quantity.factor * value)).collect(),
        };
        made.traces.push(scaled(&q::SUM_Y, wheelset.name.clone(), wheelset.all_means(&wheelset.sum)));
        for (side, name) in wheelset.sides() {
            let over = |values: &[f64]| wheelset.distance.iter().copied().zip(values.iter().copied()).collect();
            made.traces.push(scaled(&q::QUOTIENT, name.clone(), wheelset.all_means(&wheelset.quotient[side.index()])));
            made.traces.push(scaled(&q::Q_MAX, name, over(&wheelset.vertical[side.index()])));
        }
    }
}

/// T gamma (without spin) per metre: its integral over distance by the distance, of the wheel with the largest and of all wheels.
pub(super) fn wear(made: &mut Made) {
    let run = made.run;
    let names: Vec<&str> = run.signals.owners(".wearNumber");
    let mean_of = |name: &str, quantity: &str| {
        let owner = name.rsplit_once('.')?.0;
        let distance = run.signals.column(&format!("{owner}.distance"))?;
        let values = run.signals.column(&format!("{name}.{quantity}"))?;
        let travelled = distance.last()? - distance.first()?;
        let mean = sliding_means(distance, values, travelled, travelled).first()?.1;
        Some((name.to_string(), mean))
    };
    let means: Vec<(String, f64)> = names.iter().filter_map(|name| mean_of(name, "wearNumber")).collect();
    let Some((name, largest)) = means.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
        let why = "no columns W.left.wearNumber with W.distance: interface.outputs = [\"motion\", \"wheels\", \"sensors\"]";
        [&q::WEAR_WHEEL, &q::WEAR_ALL].into_iter().for_each(|quantity| made.nothing(quantity, why));
        return;
    };
    made.value(&q::WEAR_WHEEL, None, name, *largest, None, String::new());
    let all: f64 = means.iter().map(|mean| mean.1).sum();
    // Of spin, and of parts of one patch that slip against each other.
    let with_spin: Option<f64> = names.iter().map(|name| mean_of(name, "frictionWork").map(|mean| mean.1)).sum();
    let rest = with_spin.map_or(String::new(), |work| format!("; friction takes {work:.2} with spin"));
    made.value(&q::WEAR_ALL, None, "", all, None, format!("{} wheels{rest}", means.len()));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of 60 s at 200 Hz.
    fn signal(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..12_000).map(|k| of(f64::from(k) / 200.0)).collect()
    }

    fn wave(amplitude: f64, frequency: f64, t: f64) -> f64 {
        amplitude * (std::f64::consts::TAU * frequency * t + frequency).sin()
    }

    #[test]
    fn analytic_a_wagon_that_hunts_slowly_is_judged_at_its_own_frequency() {
        // A harmonic of a twelfth alone lies in the band of the fast ones.
        let (f0, slower) = dominant(&signal(|t| wave(52e3, 1.42, t) + wave(4.3e3, 7.1, t)), 200.0).unwrap();
        assert!((f0 - 1.42).abs() < 0.02 && slower.is_none(), "{f0} {slower:?}");
        let (f0, slower) = dominant(&signal(|t| wave(1e3, 1.42, t) + wave(4e3, 5.0, t)), 200.0).unwrap();
        assert!((f0 - 5.0).abs() < 0.02 && slower.is_none(), "{f0} {slower:?}");
    }

    #[test]
    fn analytic_what_track_does_over_a_band_is_no_slow_hunting() {
        let rough = |t: f64| (0..30).map(|k| wave(4e3, 0.45 + 0.061 * f64::from(k), t)).sum::<f64>();
        let (f0, slower) = dominant(&signal(|t| rough(t) + wave(3e3, 5.0, t)), 200.0).unwrap();
        assert!((f0 - 5.0).abs() < 0.02 && slower.is_some_and(|line| line < 2.4), "{f0} {slower:?}");
        // One curve of 12 s between transitions of 3 s.
        let curve = |t: f64| 20e3 * (((t - 20.0) / 3.0).clamp(0.0, 1.0) - ((t - 35.0) / 3.0).clamp(0.0, 1.0));
        let (f0, slower) = dominant(&signal(|t| curve(t) + wave(300.0, 2.56, t)), 200.0).unwrap();
        assert!((f0 - 2.56).abs() < 0.02, "{f0} {slower:?}");
    }
}
