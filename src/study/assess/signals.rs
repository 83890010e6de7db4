//! Results as signals of one even interval: from a recording or from a CSV as `wheelrail run` writes it.
//!
//! Samples at uneven times are resampled at their mean distance by a natural cubic spline; even ones are taken as they are.

use crate::math::spline::CubicSpline;
use crate::settings::title;
use crate::sim::recording::Recording;
use crate::units::Dimension;
use std::io::Read;

/// Why results can't be assessed at all.
#[derive(Debug, thiserror::Error)]
pub enum SignalsError {
    #[error("no column time [s]; expected a CSV as `wheelrail run -o` writes it: time [s],NAME [UNIT],...")]
    NoTime,
    #[error("row {row}: {found:?} in column {column} is not a finite number")]
    NoNumber { row: usize, column: String, found: String },
    #[error("row {row}: time {time} s does not follow {before} s; expected growing times")]
    Backward { row: usize, time: f64, before: f64 },
    #[error("{rows} rows: that is no run to assess")]
    TooFew { rows: usize },
    #[error("can't be read as CSV, which `wheelrail run -o FILE.csv` writes: {0}")]
    Csv(#[from] csv::Error),
    #[error("a gap of {gap} s at {time} s, {times:.0} times the usual interval; expected samples of one run at nearly equal intervals")]
    Gap { gap: f64, time: f64, times: f64 },
}

/// A gap in the samples that a spline would fill with fiction, in intervals.
const LARGEST_GAP: f64 = 20.0;
/// Intervals that differ by less than this part are equal.
const EVEN: f64 = 1e-6;

/// Columns over time.
#[derive(Clone, Debug)]
pub struct Signals {
    /// Sampling interval, s.
    pub interval: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// Largest interval of the samples as they came, s.
    pub coarsest: f64,
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Signals {
    /// From a recorded run.
    ///
    /// # Errors
    /// [`SignalsError`].
    pub fn of(recording: &Recording) -> Result<Signals, SignalsError> {
        let names: Vec<String> = recording.columns[1..].iter().map(|column| column.0.clone()).collect();
        let column = |index: usize| recording.rows.iter().map(|row| row[index]).collect();
        Signals::even(column(0), names, (1..recording.columns.len()).map(column).collect())
    }

    /// From CSV: `time [s]` and `NAME [UNIT]`; units of forces, lengths, speeds, accelerations and angles become SI.
    ///
    /// # Errors
    /// [`SignalsError`] with the row.
    pub fn read(text: impl Read) -> Result<Signals, SignalsError> {
        let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text);
        let heads: Vec<(String, f64)> = csv.headers()?.iter().map(head).collect();
        // Not in front where distance is the index.
        let time = heads.iter().position(|head| head.0 == "time").ok_or(SignalsError::NoTime)?;
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); heads.len()];
        for (row, record) in csv.records().enumerate() {
            for ((column, (name, factor)), found) in columns.iter_mut().zip(&heads).zip(record?.iter()) {
                let value = found.parse::<f64>().ok().filter(|value| value.is_finite());
                let wrong = || SignalsError::NoNumber { row: row + 2, column: name.clone(), found: found.into() };
                column.push(factor * value.ok_or_else(wrong)?);
            }
        }
        let times = columns.remove(time);
        let names = heads.into_iter().map(|head| head.0).enumerate().filter(|(index, _)| *index != time);
        Signals::even(times, names.map(|(_, name)| name).collect(), columns)
    }

    fn even(times: Vec<f64>, names: Vec<String>, columns: Vec<Vec<f64>>) -> Result<Signals, SignalsError> {
        let rows = times.len();
        if rows < 4 {
            return Err(SignalsError::TooFew { rows });
        }
        for (index, column) in columns.iter().enumerate() {
            if let Some(row) = column.iter().position(|value| !value.is_finite()) {
                return Err(SignalsError::NoNumber { row: row + 2, column: names[index].clone(), found: column[row].to_string() });
            }
        }
        if let Some(row) = times.windows(2).position(|pair| !(pair[1] > pair[0])) {
            return Err(SignalsError::Backward { row: row + 3, time: times[row + 1], before: times[row] });
        }
        let (start, interval) = (times[0], (times[rows - 1] - times[0]) / (rows - 1) as f64);
        let (widest, coarsest) = times
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .enumerate()
            .fold((0, 0.0), |most, (k, width)| if width > most.1 { (k, width) } else { most });
        if coarsest > LARGEST_GAP * interval {
            return Err(SignalsError::Gap { gap: coarsest, time: times[widest], times: coarsest / interval });
        }
        let even = times.iter().enumerate().all(|(k, t)| (t - start - interval * k as f64).abs() < EVEN * interval.max(1e-3 * t.abs()));
        let mut columns: Vec<Vec<f64>> =
            if even { columns } else { columns.iter().map(|column| resampled(&times, column, start, interval)).collect() };
        let distances = columns.iter_mut().zip(&names).filter(|(_, name)| name.ends_with(DISTANCE));
        distances.for_each(|(column, _)| hold(column));
        Ok(Signals { interval, start, coarsest: if even { interval } else { coarsest }, names, columns })
    }

    /// Every other row; `None` where that leaves too few. [`Signals::coarsest`] stays that of all rows.
    pub fn every_other(&self) -> Option<Signals> {
        let columns: Vec<Vec<f64>> = self.columns.iter().map(|column| column.iter().step_by(2).copied().collect()).collect();
        let half = Signals { interval: 2.0 * self.interval, columns, names: self.names.clone(), ..*self };
        (half.len() >= 4).then_some(half)
    }

    /// Sampling rate, Hz.
    pub fn rate(&self) -> f64 {
        1.0 / self.interval
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.interval * (self.len().saturating_sub(1)) as f64
    }

    /// Samples.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Is there nothing?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// One column, SI.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[index])
    }

    /// Names in front of an ending: `truck[1].frame` of `truck[1].frame.ay` for ".ay".
    pub fn owners(&self, ending: &str) -> Vec<&str> {
        self.names.iter().filter_map(|name| name.strip_suffix(ending)).collect()
    }
}

/// Distances along the track.
const DISTANCE: &str = ".distance";
/// A vehicle that is braked to rest swings back on its brakes and springs, or rolls back a little until they hold, m.
const SWINGS_BACK: f64 = 0.05;

/// Where a distance falls by [`SWINGS_BACK`] or less below what has been reached, it stays there: quantities over distance count it once. What falls further runs backward.
fn hold(distance: &mut [f64]) {
    let mut reached = f64::NEG_INFINITY;
    for value in distance {
        reached = reached.max(*value);
        if reached - *value <= SWINGS_BACK {
            *value = reached;
        }
    }
}

/// Quantities whose units are known.
const KNOWN: [Dimension; 6] =
    [Dimension::Force, Dimension::Length, Dimension::Speed, Dimension::Acceleration, Dimension::Angle, Dimension::Time];

/// The unit of a column's title, where it is none of the quantity that has the unit `expected`.
pub fn foreign_unit<'a>(text: &'a str, expected: &str) -> Option<&'a str> {
    let unit = title(text).1?;
    let of = |dimension: &Dimension, unit: &str| dimension.parse(&format!("1 {unit}")).is_some();
    (unit != expected && !KNOWN.iter().any(|dimension| of(dimension, unit) && of(dimension, expected))).then_some(unit)
}

/// Name of a column, and what makes SI of its unit (1 where the unit is unknown or one of SI).
fn head(text: &str) -> (String, f64) {
    let (name, Some(unit)) = title(text) else { return (text.into(), 1.0) };
    let factor = KNOWN.into_iter().find_map(|dimension| dimension.parse(&format!("1 {unit}")));
    (name.into(), factor.unwrap_or(1.0))
}

fn resampled(times: &[f64], values: &[f64], start: f64, interval: f64) -> Vec<f64> {
    let points: Vec<(f64, f64)> = times.iter().copied().zip(values.iter().copied()).collect();
    match CubicSpline::natural(&points) {
        Ok(spline) => (0..times.len()).map(|k| spline.at(start + interval * k as f64)[0]).collect(),
        // Times grow and values are finite: not reached.
        Err(_) => values.to_vec(),
    }
}

/// A signal at a finer interval, a whole part of its own, so that its rate is at least `rate` [Hz]; and that rate.
pub fn refined(values: &[f64], own: f64, rate: f64) -> (Vec<f64>, f64) {
    let parts = (rate / own - 1e-9).ceil().max(1.0) as usize;
    if parts == 1 || values.len() < 3 {
        return (values.to_vec(), own);
    }
    let points: Vec<(f64, f64)> = values.iter().enumerate().map(|(k, value)| (k as f64, *value)).collect();
    let Ok(spline) = CubicSpline::natural(&points) else { return (values.to_vec(), own) };
    let fine = (0..=(values.len() - 1) * parts).map(|k| spline.at(k as f64 / parts as f64)[0]);
    (fine.collect(), own * parts as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_distance_that_swings_back_at_the_stop_stays_and_one_that_runs_backward_does_not() {
        let mut stops = [0.0, 1.0, 1.5, 1.49, 1.48, 1.495];
        hold(&mut stops);
        assert_eq!(stops, [0.0, 1.0, 1.5, 1.5, 1.5, 1.5]);
        let mut back = [0.0, -0.2, -0.4];
        hold(&mut back);
        assert_eq!(back, [0.0, -0.2, -0.4]);
    }

    #[test]
    fn prop_units_of_a_foreign_file_become_si() {
        let text = "time [s],a.left.verticalForce [kN],a.distance [m],a.n [1]\n0,1,0,3\n0.1,2,1,3\n0.2,3,2,3\n0.3,4,3,3\n";
        let signals = Signals::read(text.as_bytes()).unwrap();
        assert_eq!(signals.column("a.left.verticalForce").unwrap(), [1e3, 2e3, 3e3, 4e3]);
        assert_eq!((signals.owners(".left.verticalForce"), signals.column("a.n").unwrap()[1], signals.len()), (vec!["a"], 3.0, 4));
        // Of `run --index distance`.
        let by_distance = "a.distance [m],time [s],a.n [1]\n0,0,3\n1,0.1,3\n2,0.2,3\n3,0.3,4\n";
        let signals = Signals::read(by_distance.as_bytes()).unwrap();
        assert_eq!((signals.column("a.distance").unwrap()[3], signals.column("time")), (3.0, None));
        assert!((signals.interval - 0.1).abs() < 1e-15);
    }

    #[test]
    fn analytic_uneven_samples_are_resampled_by_time() {
        let times = (0..400).map(|k| 0.01 * f64::from(k) + 0.002 * f64::from(k % 2));
        let rows: String = times.map(|t| format!("{t},{}\n", (3.0 * t).sin())).collect();
        let signals = Signals::read(format!("time [s],x [m]\n{rows}").as_bytes()).unwrap();
        let worst = (5..390).map(|k| signals.column("x").unwrap()[k] - (3.0 * signals.interval * k as f64).sin());
        assert!(worst.map(f64::abs).fold(0.0, f64::max) < 1e-7 && signals.coarsest > 0.0119);
    }

    #[test]
    fn hard_files_that_are_no_run_are_refused_with_the_row() {
        let refused = |text: &str| Signals::read(text.as_bytes()).unwrap_err().to_string();
        assert!(refused("a,b\n1,2\n").contains("no column time"));
        assert!(refused("time [s],x [m]\n0,1\n").contains("1 rows"));
        assert!(refused("time [s],x [m]\n0,1\n1,nan\n2,1\n3,1\n").contains("row 3: \"nan\" in column x"));
        assert!(refused("time [s],x [m]\n0,1\n1,1\n1,1\n3,1\n").contains("row 4: time 1 s does not follow 1 s"));
        assert!(refused("time [s],x [m]\n0,1\n1,1,5\n1,1\n3,1\n").contains("can't be read"));
        let gap: String = (0..100).map(|k| format!("{},1\n", if k < 50 { k } else { k + 500 })).collect();
        assert!(refused(&format!("time [s],x [m]\n{gap}")).contains("a gap of 501 s at 49 s"));
    }

    #[test]
    fn analytic_a_refined_sine_is_the_sine() {
        let coarse: Vec<f64> = (0..500).map(|k| (0.3 * f64::from(k)).sin()).collect();
        let (fine, rate) = refined(&coarse, 400.0, 1000.0);
        assert_eq!((rate, fine.len()), (1200.0, 499 * 3 + 1));
        let worst = (30..1400).map(|k| (fine[k] - (0.1 * k as f64).sin()).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-4, "{worst}");
    }
}
