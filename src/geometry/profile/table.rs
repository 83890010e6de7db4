//! Value and slope of a profile from a table, for laws that read it at many places of one contact.
//!
//! The range is cut into equal cells of width h. In a cell, with s from 0 to 1, the profile is the quintic that has the curve's
//! value, slope and curvature at both ends. Its error is `h^6 y'''''' / 46080`; for an arc of radius r
//!
//! ```text
//! y'''''' = -45 (1 + p^2)^3.5 (1 + 14 p^2 + 21 p^4) / r^5,   p = y'
//! ```
//!
//! so with h = 0.05 mm 4e-20 m on the level part of an arc of 13 mm, 1e-13 m where it stands at 70 degrees. Cells in which the
//! quintic leaves the curve by more than [`CLOSE`], or in which a piece ends, are left out: there the curve itself is read.

use super::ProfilePoint;

/// Width of a cell, m, at most.
const WIDTH: f64 = 5e-5;
/// Furthest that a cell may be from the curve, m, and the same in slope.
const CLOSE: f64 = 1e-13;
const PARALLEL: f64 = 1e-8;

/// Coefficients in powers of s; the first is NaN where the curve must be read.
type Cell = [f64; 6];

#[derive(Clone, Debug)]
pub(super) struct Table {
    first: f64,
    cells_per_metre: f64,
    cells: Vec<Cell>,
}

/// The quintic in s of a cell of this width, from a curve's points at both ends.
fn quintic(width: f64, from: &ProfilePoint, to: &ProfilePoint) -> Cell {
    let (rise, slopes, bends) = (to.value - from.value, [from.d1, to.d1].map(|d| d * width), [from.d2, to.d2].map(|d| d * width * width));
    let [a, b, c] = [rise - slopes[0] - 0.5 * bends[0], slopes[1] - slopes[0] - bends[0], bends[1] - bends[0]];
    let (third, fourth, fifth) = (10.0 * a - 4.0 * b + 0.5 * c, -15.0 * a + 7.0 * b - c, 6.0 * a - 3.0 * b + 0.5 * c);
    [from.value, slopes[0], 0.5 * bends[0], third, fourth, fifth]
}

/// Value, and slope per cell.
#[inline]
fn sum(&[c0, c1, c2, c3, c4, c5]: &Cell, s: f64) -> (f64, f64) {
    let value = c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))));
    (value, c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * (5.0 * c5)))))
}

impl Table {
    /// A table over `first` to `last` [m]; `curve` gives the curve over one cell, `None` where a piece ends in it.
    pub(super) fn new<C: Fn(f64) -> ProfilePoint>(first: f64, last: f64, curve: impl Fn(f64, f64) -> Option<C>) -> Self {
        let count = ((last - first) / WIDTH).ceil().max(1.0);
        let width = (last - first) / count;
        let cell = |index: usize| {
            let (from, to) = (first + index as f64 * width, first + (index + 1) as f64 * width);
            let curve = curve(from, to)?;
            let cell = quintic(width, &curve(from), &curve(to));
            let near = |s: f64| {
                let (point, (value, slope)) = (curve(from + s * width), sum(&cell, s));
                (value - point.value).abs() <= CLOSE && (slope / width - point.d1).abs() <= PARALLEL
            };
            [0.25, 0.5, 0.75].into_iter().all(near).then_some(cell)
        };
        let cells = (0..count as usize).map(|index| cell(index).unwrap_or([f64::NAN; 6])).collect();
        Table { first, cells_per_metre: 1.0 / width, cells }
    }

    /// Value and slope at an `x` inside the range; `None` where the curve must be read.
    #[inline]
    pub(super) fn read(&self, x: f64) -> Option<(f64, f64)> {
        let place = (x - self.first) * self.cells_per_metre;
        if !(place >= 0.0) {
            return None;
        }
        // Numbers that are too great for an i32 become the greatest one.
        let index = place as i32;
        let cell = self.cells.get(index as usize)?;
        let (value, slope) = sum(cell, place - f64::from(index));
        (!value.is_nan()).then_some((value, slope * self.cells_per_metre))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Profile;
    use super::super::piecewise::{Curve, Piece, Piecewise};

    #[test]
    fn analytic_arcs_are_met_to_1e_13_and_joints_and_steep_flanks_are_read_exactly() {
        // 80 mm, from 10 mm on 13 mm, as on a rail's head; the second arc ends at a slope of 5.
        let tilt: f64 = 10.0 / 80.0;
        let centre = 67.0 * tilt;
        let end = centre + 13.0 * 5.0 / 26f64.sqrt();
        let height = -80.0 + 67.0 * (1.0 - tilt * tilt).sqrt();
        let pieces = vec![
            Piece { from: -10e-3, to: 10e-3, curve: Curve::arc(0.0, -80e-3, 80e-3, 1.0) },
            Piece { from: 10e-3, to: end * 1e-3, curve: Curve::arc(centre * 1e-3, height * 1e-3, 13e-3, 1.0) },
        ];
        let profile = Piecewise::new(pieces, "two arcs".into()).unwrap();
        let (first, last) = profile.range();
        let (mut value, mut slope, mut exact) = (0.0f64, 0.0f64, 0);
        const COUNT: u32 = 100_003;
        for i in 0..=COUNT {
            let x = first + (last - first) * f64::from(i) / f64::from(COUNT);
            let (point, found) = (profile.at(x), profile.value_and_slope(x));
            value = value.max((found.0 - point.value).abs());
            slope = slope.max((found.1 - point.d1).abs());
            exact += u32::from(found == (point.value, point.d1));
        }
        println!("value within {value:.1e} m, slope within {slope:.1e}, {exact} of {COUNT} read from the curve or equal to it");
        assert!(value < 1.1e-13 && slope < 1e-8);
        for x in [first - 1e-3, last + 1e-3, f64::NAN, 1e30, -1e30, 10e-3] {
            let point = profile.at(x);
            let found = profile.value_and_slope(x);
            assert!(found == (point.value, point.d1) || x.is_nan() && found.0.is_nan(), "{x}");
        }
    }
}
