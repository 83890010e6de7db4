//! Natural cubic spline: C2, with three derivatives, constant-time lookup.

/// Why points cannot carry a spline.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SplineError {
    #[error("a cubic spline needs at least 3 points, found {0}")]
    TooFew(usize),
    #[error("positions must increase: point {index} at {position} follows {previous}")]
    NotIncreasing { index: usize, position: f64, previous: f64 },
    #[error("point {index} is not a finite number")]
    NotFinite { index: usize },
}

/// Three or more finite points with increasing positions?
///
/// # Errors
/// [`SplineError`], the first thing that is wrong.
pub(super) fn check(points: &[(f64, f64)]) -> Result<(), SplineError> {
    if points.len() < 3 {
        return Err(SplineError::TooFew(points.len()));
    }
    for (index, point) in points.iter().enumerate() {
        if !(point.0.is_finite() && point.1.is_finite()) {
            return Err(SplineError::NotFinite { index });
        }
        if index > 0 && point.0 <= points[index - 1].0 {
            return Err(SplineError::NotIncreasing { index, position: point.0, previous: points[index - 1].0 });
        }
    }
    Ok(())
}

/// Interpolates points `(x_i, y_i)` with zero second derivative at both ends; beyond the ends it goes on as
/// the straight line that continues it (value, slope and curvature stay continuous).
#[derive(Clone, Debug)]
pub struct CubicSpline {
    knots: Vec<f64>,
    /// Polynomial of each interval in powers of `x - knot`.
    pieces: Vec<[f64; 4]>,
    last_value: f64,
    last_slope: f64,
    /// For each of equally wide cells, the interval in which the cell begins: lookup needs no search.
    cells: Vec<u32>,
    cells_per_unit: f64,
}

impl CubicSpline {
    /// # Errors
    /// [`SplineError`] unless there are three or more finite points with increasing positions.
    pub fn natural(points: &[(f64, f64)]) -> Result<Self, SplineError> {
        check(points)?;
        let n = points.len();
        let width: Vec<f64> = points.windows(2).map(|p| p[1].0 - p[0].0).collect();
        let slope: Vec<f64> = points.windows(2).map(|p| (p[1].1 - p[0].1) / (p[1].0 - p[0].0)).collect();

        // Second derivatives at the inner knots from a symmetric tridiagonal system (Thomas algorithm).
        let mut curvature = vec![0.0; n];
        let mut diagonal = vec![0.0; n];
        let mut right = vec![0.0; n];
        for i in 1..n - 1 {
            diagonal[i] = 2.0 * (width[i - 1] + width[i]);
            right[i] = 6.0 * (slope[i] - slope[i - 1]);
            if i > 1 {
                let factor = width[i - 1] / diagonal[i - 1];
                diagonal[i] -= factor * width[i - 1];
                right[i] -= factor * right[i - 1];
            }
        }
        for i in (1..n - 1).rev() {
            curvature[i] = (right[i] - width[i] * curvature[i + 1]) / diagonal[i];
        }

        let pieces: Vec<[f64; 4]> = (0..n - 1)
            .map(|i| {
                let linear = slope[i] - width[i] * (2.0 * curvature[i] + curvature[i + 1]) / 6.0;
                [points[i].1, linear, curvature[i] / 2.0, (curvature[i + 1] - curvature[i]) / (6.0 * width[i])]
            })
            .collect();
        let knots: Vec<f64> = points.iter().map(|p| p.0).collect();
        let last = n - 2;
        let last_slope = slope[last] + width[last] * (2.0 * curvature[n - 1] + curvature[last]) / 6.0;

        let count = (n - 1).min(1 << 16);
        let cells_per_unit = count as f64 / (knots[n - 1] - knots[0]);
        let cells = (0..count)
            .map(|cell| {
                let start = knots[0] + cell as f64 / cells_per_unit;
                (knots.partition_point(|&knot| knot <= start).max(1) - 1).min(n - 2) as u32
            })
            .collect();
        Ok(CubicSpline { knots, pieces, last_value: points[n - 1].1, last_slope, cells, cells_per_unit })
    }

    /// First and last position.
    pub fn range(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// The interval that holds `x` and the distance from its begin; `x` must lie inside the range.
    #[inline]
    fn interval(&self, x: f64) -> (usize, f64) {
        let cell = (((x - self.knots[0]) * self.cells_per_unit) as usize).min(self.cells.len() - 1);
        let mut i = self.cells[cell] as usize;
        // Rounding may put x one cell too far; then step back first.
        while i > 0 && x < self.knots[i] {
            i -= 1;
        }
        while i + 2 < self.knots.len() && x >= self.knots[i + 1] {
            i += 1;
        }
        (i, x - self.knots[i])
    }

    /// Is it zero everywhere?
    pub fn is_zero(&self) -> bool {
        self.pieces.iter().flatten().all(|c| *c == 0.0)
    }

    /// Value and first three derivatives at `x`.
    #[inline]
    pub fn at(&self, x: f64) -> [f64; 4] {
        let (first, last) = self.range();
        if !(x > first) {
            let [value, slope, ..] = self.pieces[0];
            return [value + slope * (x - first), slope, 0.0, 0.0];
        }
        if x >= last {
            return [self.last_value + self.last_slope * (x - last), self.last_slope, 0.0, 0.0];
        }
        let (i, t) = self.interval(x);
        let [c0, c1, c2, c3] = self.pieces[i];
        [c0 + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + 3.0 * t * c3), 2.0 * c2 + 6.0 * t * c3, 6.0 * c3]
    }

    /// Values of several splines over the same positions, at an `x` inside their range.
    #[inline]
    pub fn values<const N: usize>(splines: &[CubicSpline; N], x: f64) -> [f64; N] {
        let (i, t) = splines[0].interval(x);
        std::array::from_fn(|k| {
            let [c0, c1, c2, c3] = splines[k].pieces[i];
            c0 + t * (c1 + t * (c2 + t * c3))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(n: usize) -> CubicSpline {
        // Uneven positions; the sine's second derivative vanishes at both ends, as a natural spline wants.
        let points: Vec<_> = (0..=n)
            .map(|i| {
                let t = i as f64 / n as f64;
                let x = std::f64::consts::PI * (t + 0.15 * (2.0 * std::f64::consts::PI * t).sin() / (2.0 * std::f64::consts::PI));
                (x, x.sin())
            })
            .collect();
        CubicSpline::natural(&points).unwrap()
    }

    #[test]
    fn order_value_and_derivatives_converge() {
        let error = |n: usize, derivative: usize| {
            let spline = sine(n);
            (0..1000)
                .map(|i| {
                    let x = std::f64::consts::PI * (i as f64 + 0.5) / 1000.0;
                    let exact = [x.sin(), x.cos(), -x.sin(), -x.cos()][derivative];
                    (spline.at(x)[derivative] - exact).abs()
                })
                .fold(0.0, f64::max)
        };
        for (derivative, order) in [(0, 4.0), (1, 3.0), (2, 2.0), (3, 1.0)] {
            let measured = (error(20, derivative) / error(80, derivative)).log2() / 2.0;
            assert!((measured - order).abs() < 0.25, "derivative {derivative}: order {measured}");
        }
    }

    #[test]
    fn prop_c2_at_knots_and_beyond_the_ends() {
        let spline = sine(12);
        for &knot in &spline.knots {
            let (before, after) = (spline.at(knot - 1e-9), spline.at(knot + 1e-9));
            for derivative in 0..3 {
                assert!((before[derivative] - after[derivative]).abs() < 1e-7, "{knot} {derivative}");
            }
        }
    }

    #[test]
    fn analytic_natural_end_condition_moves_a_parabola() {
        // x^2 on 0, 1, 2: the only inner second derivative solves 4 M = 6 (3 - 1), M = 3.
        let spline = CubicSpline::natural(&[(0.0, 0.0), (1.0, 1.0), (2.0, 4.0)]).unwrap();
        assert!((spline.at(1.0)[2] - 3.0).abs() < 1e-14);
        assert!((spline.at(0.5)[0] - (0.5 * 0.5 + 0.5 * 0.125)).abs() < 1e-14);
    }

    #[test]
    fn hard_bad_points_are_named() {
        assert_eq!(CubicSpline::natural(&[(0.0, 0.0), (1.0, 1.0)]).unwrap_err(), SplineError::TooFew(2));
        let error = CubicSpline::natural(&[(0.0, 0.0), (1.0, 1.0), (1.0, 2.0)]).unwrap_err();
        assert_eq!(error, SplineError::NotIncreasing { index: 2, position: 1.0, previous: 1.0 });
        assert_eq!(CubicSpline::natural(&[(0.0, 0.0), (1.0, f64::NAN), (2.0, 2.0)]).unwrap_err(), SplineError::NotFinite { index: 1 });
    }
}
