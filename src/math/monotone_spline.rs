//! A line through points that goes nowhere but from point to point: between two it rises or falls as they do.
//!
//! Slopes at the points are the harmonic means of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984), zero where rise and fall meet, and at most twice the
//! smaller slope beside them. Second derivatives vanish at the points. With `t` from 0 to 1 over an interval whose chord has the slope D, and slopes d, e at its ends,
//!
//! ```text
//! f' = d S(1 - t) + e S(t) + 30 (D - (d + e) / 2) t^2 (1 - t)^2,    S(t) = 3 t^2 - 2 t^3
//! ```
//!
//! a quintic f that is C2 and, with d and e from 0 to 2 D, monotone: `prop_nothing_lies_beyond_the_points`.

use super::spline::{self, SplineError};

/// Beyond both ends it goes on as a straight line.
#[derive(Clone, Debug)]
pub struct MonotoneSpline {
    knots: Vec<f64>,
    /// Polynomial of each interval in powers of `(x - knot) / width`.
    pieces: Vec<[f64; 6]>,
    last: [f64; 2],
}

impl MonotoneSpline {
    /// # Errors
    /// [`SplineError`] unless there are three or more finite points with increasing positions.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, SplineError> {
        spline::check(points)?;
        let chords: Vec<(f64, f64)> = points.windows(2).map(|p| (p[1].0 - p[0].0, (p[1].1 - p[0].1) / (p[1].0 - p[0].0))).collect();
        let ends = [chords[0].1, chords[chords.len() - 1].1];
        let inner = chords.windows(2).map(|pair| slope(pair[0], pair[1]));
        let slopes: Vec<f64> = std::iter::once(ends[0]).chain(inner).chain([ends[1]]).collect();
        let pieces = chords.iter().enumerate().map(|(i, (width, chord))| {
            let [d, e, chord] = [slopes[i], slopes[i + 1], *chord].map(|slope| slope * width);
            let bell = 30.0 * (chord - 0.5 * (d + e));
            [points[i].1, d, 0.0, e - d + bell / 3.0, 0.5 * (d - e) - 0.5 * bell, 0.2 * bell]
        });
        let knots = points.iter().map(|point| point.0).collect();
        Ok(MonotoneSpline { knots, pieces: pieces.collect(), last: [points[points.len() - 1].1, ends[1]] })
    }

    /// Is it zero everywhere?
    pub fn is_zero(&self) -> bool {
        self.pieces.iter().flatten().all(|c| *c == 0.0)
    }

    /// Value and first three derivatives at `x`.
    pub fn at(&self, x: f64) -> [f64; 4] {
        let (first, end) = (self.knots[0], self.knots[self.knots.len() - 1]);
        if !(x > first) {
            let slope = self.pieces[0][1] / (self.knots[1] - first);
            return [self.pieces[0][0] + slope * (x - first), slope, 0.0, 0.0];
        }
        if x >= end {
            return [self.last[0] + self.last[1] * (x - end), self.last[1], 0.0, 0.0];
        }
        let i = self.knots.partition_point(|knot| *knot <= x) - 1;
        let rate = 1.0 / (self.knots[i + 1] - self.knots[i]);
        let t = (x - self.knots[i]) * rate;
        let [c0, c1, _, c3, c4, c5] = self.pieces[i];
        [
            c0 + t * (c1 + t * t * (c3 + t * (c4 + t * c5))),
            rate * (c1 + t * t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5))),
            rate * rate * t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5)),
            rate * rate * rate * (6.0 * c3 + t * (24.0 * c4 + t * 60.0 * c5)),
        ]
    }
}

/// At a point between two chords, each (width, slope).
fn slope((width, chord): (f64, f64), (next_width, next): (f64, f64)) -> f64 {
    if !(chord * next > 0.0) {
        return 0.0;
    }
    let (own, other) = (2.0 * next_width + width, next_width + 2.0 * width);
    let mean = (own + other) / (own / chord + other / next);
    mean.signum() * mean.abs().min(2.0 * chord.abs().min(next.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_nothing_lies_beyond_the_points() {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1u32 << 24)
        };
        for _ in 0..300 {
            let mut x = 0.0;
            let points: Vec<(f64, f64)> = (0..12)
                .map(|_| {
                    x += 10f64.powf(3.0 * next() - 2.0);
                    (x, if next() < 0.3 { 0.0 } else { 10f64.powf(4.0 * next() - 4.0) * (next() - 0.5) })
                })
                .collect();
            let line = MonotoneSpline::new(&points).unwrap();
            for pair in points.windows(2) {
                let [(a, low), (b, high)] = [pair[0], pair[1]];
                let chord = (high - low) / (b - a);
                for k in 0..=40 {
                    let [value, slope, ..] = line.at(a + (b - a) * f64::from(k) / 40.0);
                    assert!(slope * chord.signum() > -1e-9 * chord.abs().max(1e-12), "{points:?} {a} {slope} {chord}");
                    assert!(value > low.min(high) - 1e-12 && value < low.max(high) + 1e-12, "{points:?} {value}");
                }
            }
        }
    }

    #[test]
    fn analytic_two_derivatives_are_continuous_and_straight_lines_stay_straight() {
        let points = [(0.0, 0.0), (30.0, 0.0), (60.0, 2.0), (60.5, 8.0), (70.0, 9.0), (75.0, 3.0), (100.0, 3.0)];
        let line = MonotoneSpline::new(&points).unwrap();
        for (x, y) in points {
            let (before, after) = (line.at(x - 1e-9), line.at(x + 1e-9));
            assert!((0..2).all(|d| (before[d] - after[d]).abs() < 1e-6) && (line.at(x)[0] - y).abs() < 1e-12, "{x} {before:?} {after:?}");
            assert!(line.at(x)[2].abs() < 1e-9);
        }
        let h = 1e-5;
        for x in [31.0, 45.0, 60.1, 60.4, 66.0, 72.0] {
            for d in 0..3 {
                let found = (line.at(x + h)[d] - line.at(x - h)[d]) / (2.0 * h);
                assert!((found - line.at(x)[d + 1]).abs() < 1e-4 * (1.0 + found.abs()), "{x} {d}: {found} {:?}", line.at(x));
            }
        }
        let straight = MonotoneSpline::new(&[(0.0, 1.0), (1.0, 3.0), (5.0, 11.0), (5.5, 12.0)]).unwrap();
        assert!([-1.0, 0.3, 4.0, 5.2, 7.0].iter().all(|x| (straight.at(*x)[0] - 1.0 - 2.0 * x).abs() < 1e-12));
        assert_eq!(straight.at(9.0)[1], 2.0);
    }
}
