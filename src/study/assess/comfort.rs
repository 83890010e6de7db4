//! What passengers feel: mean comfort (EN 12299), weighted rms (ISO 2631-1), Sperling's Wz.
//!
//! ```text
//! N_MV = 6 sqrt(ax95^2 + ay95^2 + az95^2)    a95: 95 % percentile of weighted rms values of 5 s (Wd, Wd, Wb), m/s2
//! a_w  = rms of the weighted acceleration of the whole run (Wd, Wd, Wk);  vector sum sqrt(ax^2 + ay^2 + az^2), k = 1 (comfort)
//! Wz   = (sum a^2 B^2)^(1/6.67)              a: amplitudes, cm/s2; = 4.42 rms^0.3 with the rms in m/s2 (whole run)
//! ```
//!
//! Windows of 5 s follow each other; the standard asks for 60 of them (5 min). Fewer than 12 (1 min) are refused, fewer than 60 are told. Weightings: `weighting.rs`. No
//! limits: N_MV below 1.5 counts as very comfortable, 2.5 comfortable, 3.5 medium, 4.5 uncomfortable; Wz = 2 as just noticeable vibration, 2.5 as pronounced but not
//! unpleasant, 3 as strong, 3.25 as very strong (ride comfort).
//!
//! Sources: EN 12299:2009, 6 (definition of N_MV; the text was not at hand); ISO 2631-1:1997, 6; E. Sperling, C. Betzhold, Glasers Annalen 80 (1956), 314-320.

use super::accelerations::{Point, SHOWN, floor, no_floor};
use super::quantity::{self as q, Quantity};
use super::signals::refined;
use super::statistics::{percentile, rms};
use super::weighting::{RATE, Weighting, ride_index};
use super::{COARSEST, Made, Run};

/// Sampling interval of weighted accelerations, s: the weightings reach to 100 Hz.
pub const FINE: f64 = 2.5e-3;
/// Window of EN 12299, s; how many it asks for, and how few make no percentile.
const WINDOW: f64 = 5.0;
const WANTED: usize = 60;
const FEWEST: usize = 12;
/// Least duration of an rms, s: the lowest weighted wave, 0.4 Hz, four times.
const SHORTEST: f64 = 10.0;

/// Slower than this a vehicle stands, m/s; a run that does so for more than this part of its time is told of.
const STANDS: f64 = 0.05;
const RESTS: f64 = 0.02;

const ALL: [&Quantity; 7] =
    [&q::MEAN_COMFORT, &q::SPERLING_LATERAL, &q::SPERLING_VERTICAL, &q::WEIGHTED[0], &q::WEIGHTED[1], &q::WEIGHTED[2], &q::WEIGHTED_TOTAL];

pub(super) fn assess(made: &mut Made) {
    let (run, first) = (made.run, made.rows.len());
    rows(made);
    let distance = run.signals.owners(".distance").first().and_then(|name| run.signals.column(&format!("{name}.distance")));
    let (rest, duration) = (distance.map_or(0.0, |distance| at_rest(distance, run.signals.interval)), run.signals.duration());
    if rest > RESTS * duration {
        for row in made.rows[first..].iter_mut().filter(|row| row.value.is_some()) {
            let before = if row.note.is_empty() { "" } else { "; " };
            row.note += &format!("{before}{rest:.0} s of {duration:.0} s at rest count");
        }
    }
}

/// How long a vehicle stands, s, from its distances [m] at even intervals [s].
fn at_rest(distance: &[f64], interval: f64) -> f64 {
    interval * distance.windows(2).filter(|pair| (pair[1] - pair[0]).abs() < STANDS * interval).count() as f64
}

fn rows(made: &mut Made) {
    let run = made.run;
    let points = floor(run);
    if points.is_empty() {
        let why = no_floor(run);
        return ALL.iter().for_each(|quantity| made.nothing(quantity, &why));
    }
    let duration = run.signals.duration();
    if duration < SHORTEST {
        let why = format!("{duration:.1} s are too short for waves of 0.4 Hz: run.stop = {SHORTEST} or more");
        return ALL.iter().for_each(|quantity| made.nothing(quantity, &why));
    }
    let coarse = run.too_coarse(FINE, "for weightings up to 100 Hz");
    match &coarse {
        Some(why) => made.nothing(&q::MEAN_COMFORT, why),
        None => mean_comfort(made, &points),
    }
    match run.too_coarse(COARSEST, "for Sperling's weighting") {
        Some(why) => [&q::SPERLING_LATERAL, &q::SPERLING_VERTICAL].into_iter().for_each(|quantity| made.nothing(quantity, &why)),
        None => {
            whole(made, &points, &q::SPERLING_LATERAL, |point| {
                Some(ride_index(weighted_rms(run, point.along[1]?, Weighting::SperlingLateral)?))
            });
            whole(made, &points, &q::SPERLING_VERTICAL, |point| {
                Some(ride_index(weighted_rms(run, point.along[2]?, Weighting::SperlingVertical)?))
            });
        }
    }
    if let Some(why) = coarse {
        return ALL[3..].iter().for_each(|quantity| made.nothing(quantity, &why));
    }
    const WEIGHTINGS: [Weighting; 3] = [Weighting::Wd, Weighting::Wd, Weighting::Wk];
    let of = |point: &Point, axis: usize| weighted_rms(run, point.along[axis]?, WEIGHTINGS[axis]);
    for (axis, quantity) in q::WEIGHTED.iter().enumerate() {
        whole(made, &points, quantity, |point| of(point, axis));
    }
    whole(made, &points, &q::WEIGHTED_TOTAL, |point| {
        let parts = [of(point, 0).unwrap_or(0.0), of(point, 1)?, of(point, 2)?];
        Some(parts.iter().map(|part| part * part).sum::<f64>().sqrt())
    });
}

fn weighted(run: &Run, values: &[f64], weighting: Weighting) -> (Vec<f64>, f64) {
    let (fine, rate) = refined(values, run.signals.rate(), RATE);
    (weighting.filter(rate).of(&fine), rate)
}

fn weighted_rms(run: &Run, values: &[f64], weighting: Weighting) -> Option<f64> {
    rms(&weighted(run, values, weighting).0)
}

/// The largest value of all points.
fn whole(made: &mut Made, points: &[Point], quantity: &'static Quantity, value: impl Fn(&Point) -> Option<f64>) {
    let found = points.iter().filter_map(|point| Some((point, value(point)?)));
    match found.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((point, value)) => made.value(quantity, None, &point.name, value, None, String::new()),
        None => made.nothing(quantity, SHOWN),
    }
}

fn mean_comfort(made: &mut Made, points: &[Point]) {
    let run = made.run;
    let windows = (run.signals.duration() / WINDOW + 1e-9).floor() as usize;
    if windows < FEWEST {
        let why = format!(
            "{windows} windows of 5 s make no 95 % percentile: run.stop = {} s or more ({} s for the standard's 60)",
            WINDOW * FEWEST as f64,
            WINDOW * WANTED as f64
        );
        return made.nothing(&q::MEAN_COMFORT, &why);
    }
    let part = |values: &[f64], weighting: Weighting| {
        let (signal, rate) = weighted(run, values, weighting);
        let count = (WINDOW * rate).round() as usize;
        let all: Vec<f64> = signal.chunks_exact(count).filter_map(rms).collect();
        percentile(&all, 95.0)
    };
    let found = points.iter().filter_map(|point| {
        let ahead = point.along[0].and_then(|values| part(values, Weighting::Wd)).unwrap_or(0.0);
        let parts = [ahead, part(point.along[1]?, Weighting::Wd)?, part(point.along[2]?, Weighting::Wb)?];
        Some((point, 6.0 * parts.iter().map(|part| part * part).sum::<f64>().sqrt()))
    });
    match found.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((point, value)) => {
            let few = if windows < WANTED { format!("; {windows} of {WANTED} windows") } else { String::new() };
            made.value(&q::MEAN_COMFORT, None, &point.name, value, None, format!("{}{few}", class(value)));
        }
        None => made.nothing(&q::MEAN_COMFORT, SHOWN),
    }
}

/// EN 12299's words.
fn class(value: f64) -> &'static str {
    let classes = [(1.5, "very comfortable"), (2.5, "comfortable"), (3.5, "medium"), (4.5, "uncomfortable")];
    classes.into_iter().find(|class| value < class.0).map_or("very uncomfortable", |class| class.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_time_at_rest_is_counted() {
        // 10 s at 20 m/s, then 5 s at rest with a swing of 1 mm at 1 Hz (6 mm/s).
        let at = |t: f64| if t < 10.0 { 20.0 * t } else { 200.0 + 1e-3 * (std::f64::consts::TAU * t).sin() };
        let distance: Vec<f64> = (0..=1500).map(|k| at(0.01 * f64::from(k))).collect();
        assert!((at_rest(&distance, 0.01) - 5.0).abs() < 0.011, "{}", at_rest(&distance, 0.01));
    }
}
