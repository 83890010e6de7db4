//! Fewer rows without aliases: every m-th row after a low-pass filter without delay.
//!
//! The filter is symmetric (its phase is zero: nothing is delayed) with the taps of a windowed sinc, Kaiser's window for 80 dB (J. F. Kaiser, "Nonrecursive digital filter design using
//! the I0-sinh window function", ISCAS 1974). It passes what is slower than 0.4 of the new rate and holds back by 80 dB what is faster than half of it, which would fold.
//! Beyond the ends of the run it sees the signal turned about its end value, so that straight lines, time and distance stay what they are.

use std::collections::VecDeque;
use std::f64::consts::PI;

/// Suppression, dB.
const SUPPRESSION: f64 = 80.0;
/// Width from what passes to what is held back, and its middle, in parts of the new rate.
const WIDTH: f64 = 0.1;
const MIDDLE: f64 = 0.45;

/// Rows on their way through the filter.
pub(in crate::cli) struct Thinned {
    factor: usize,
    /// The middle tap, and those to one side of it.
    taps: Vec<f64>,
    /// Rows from number `first` on that are still needed.
    rows: VecDeque<Vec<f64>>,
    first: usize,
    /// Row about which the next one out is.
    next: usize,
    /// Columns that are taken as they are (time).
    kept: Vec<usize>,
    /// Rows at equal distances; one behind them is left out.
    even: usize,
}

/// Modified Bessel function I0 by its series.
fn bessel(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (0.5 * x / k) * (0.5 * x / k);
        sum += term;
        k += 1.0;
    }
    sum
}

/// The middle tap and those to one side of it, for one row out of `factor`.
fn taps(factor: usize) -> Vec<f64> {
    // Kaiser's formulas for the shape of the window and the number of taps.
    let shape = 0.1102 * (SUPPRESSION - 8.7);
    let half = ((SUPPRESSION - 7.95) / (2.285 * 2.0 * PI * WIDTH) * factor as f64 / 2.0).ceil() as usize;
    let cut = MIDDLE / factor as f64;
    let tap = |place: usize| {
        let at = place as f64;
        let sinc = if place == 0 { 2.0 * cut } else { (2.0 * PI * cut * at).sin() / (PI * at) };
        sinc * bessel(shape * (1.0 - (at / half as f64).powi(2)).max(0.0).sqrt()) / bessel(shape)
    };
    let mut taps: Vec<f64> = (0..=half).map(tap).collect();
    let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
    taps.iter_mut().for_each(|tap| *tap /= sum);
    taps
}

impl Thinned {
    /// One row out of `factor`; columns of `kept` (by place in a row) are not filtered. The first `even` rows stand at equal distances.
    pub fn new(factor: usize, kept: Vec<usize>, even: usize) -> Thinned {
        let taps = if factor > 1 { taps(factor) } else { vec![1.0] };
        Thinned { factor, taps, rows: VecDeque::new(), first: 0, next: 0, kept, even }
    }

    /// Takes the next row.
    pub fn take(&mut self, row: &[f64]) {
        if self.known() < self.even {
            self.rows.push_back(row.to_vec());
        }
    }

    fn known(&self) -> usize {
        self.first + self.rows.len()
    }

    /// A row that no later one changes.
    pub fn next_row(&mut self) -> Option<Vec<f64>> {
        let half = self.taps.len() - 1;
        (self.next + half < self.known()).then(|| self.filtered())
    }

    /// The rows that are left at the end of the run.
    pub fn rest(mut self) -> Vec<Vec<f64>> {
        let mut rest = Vec::new();
        while self.next < self.known() {
            rest.push(self.filtered());
        }
        rest
    }

    /// Value of a column at any row, beyond the ends turned about the end's value.
    fn value(&self, column: usize, row: i64) -> f64 {
        let (mut at, mut sign, mut offset) = (row, 1.0, 0.0);
        let last = self.known() as i64 - 1;
        let inside = |at: i64| self.rows[(at as usize).saturating_sub(self.first)][column];
        // A run shorter than the filter is turned more than once.
        while last > 0 && !(0..=last).contains(&at) {
            let end = if at < 0 { 0 } else { last };
            offset += sign * 2.0 * inside(end);
            (sign, at) = (-sign, 2 * end - at);
        }
        offset + sign * inside(at.clamp(0, last))
    }

    fn filtered(&mut self) -> Vec<f64> {
        let middle = self.next as i64;
        let width = self.rows.front().map_or(0, Vec::len);
        let filter = |column: usize| {
            let sides = self.taps.iter().enumerate().skip(1);
            let sum: f64 =
                sides.map(|(k, tap)| tap * (self.value(column, middle - k as i64) + self.value(column, middle + k as i64))).sum();
            self.taps[0] * self.value(column, middle) + sum
        };
        let row = (0..width).map(|column| if self.kept.contains(&column) { self.value(column, middle) } else { filter(column) }).collect();
        self.next += self.factor;
        while self.first + self.taps.len() <= self.next && self.rows.len() > 1 {
            self.rows.pop_front();
            self.first += 1;
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thin(factor: usize, rows: usize, signal: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
        let mut thinned = Thinned::new(factor, vec![0], rows);
        let mut found = Vec::new();
        for row in 0..rows {
            thinned.take(&[row as f64, signal(row as f64)]);
            found.extend(std::iter::from_fn(|| thinned.next_row()));
        }
        found.extend(thinned.rest());
        found
    }

    /// What is slower than 0.4 of the new rate passes without delay, what would fold does not; straight lines stay to the ends, in runs shorter than the filter too.
    #[test]
    fn analytic_slow_waves_pass_and_fast_ones_do_not_fold() {
        for factor in [2, 4, 10] {
            let rate = 1.0 / factor as f64;
            let wave = |frequency: f64| move |at: f64| (2.0 * PI * frequency * at + 0.3).sin();
            for (part, passes) in [(0.1, true), (0.3, true), (0.4, true), (0.5, false), (0.7, false), (0.95, false)] {
                let found = thin(factor, 400 * factor, wave(part * rate));
                assert_eq!(found.len(), 400);
                // Away from the ends, which see what is beyond them.
                for row in &found[40..360] {
                    let expected = if passes { wave(part * rate)(row[0]) } else { 0.0 };
                    assert!((row[1] - expected).abs() < 2e-4, "{factor} {part}: {row:?} {expected}");
                }
            }
            for rows in [1, 2, 7, 20 * factor + 1, 200 * factor] {
                let found = thin(factor, rows, |at| 3.0 - 0.25 * at);
                assert_eq!(found.len(), rows.div_ceil(factor));
                for (k, row) in found.iter().enumerate() {
                    assert!(row[0] == (k * factor) as f64 && (row[1] - 3.0 + 0.25 * row[0]).abs() < 1e-9 * rows as f64, "{rows}: {row:?}");
                }
            }
        }
    }

    /// scipy 1.17: firwin(2 * 101 + 1, 0.45 / 4, window=("kaiser", 7.85726), fs=1.0), its middle and some taps to the side.
    #[test]
    fn validate_taps_are_those_of_scipy() {
        let found = taps(4);
        assert_eq!(found.len(), 102);
        let expected = [
            (0, 0.22499740818685188),
            (1, 0.20664900477134612),
            (4, 0.024449336884070957),
            (9, 0.0026950623534861573),
            (37, 0.004410018643976099),
            (100, 1.1297716435302165e-05),
            (101, 6.404815344243882e-06),
        ];
        for (place, tap) in expected {
            assert!((found[place] - tap).abs() < 1e-14, "{place}: {}", found[place]);
        }
    }
}
