//! Value and slope of a profile from a table, for laws that read it at many places of one contact.
//!
//! The range is cut into equal cells of width h. In a cell, with s from -1/2 to 1/2, the profile is the quintic that has the curve's
//! value, slope and curvature at both ends. Its error is `h^6 y'''''' / 46080`; for an arc of radius r
//!
//! ```text
//! y'''''' = -45 (1 + p^2)^3.5 (1 + 14 p^2 + 21 p^4) / r^5,   p = y'
//! ```
//!
//! so with h = 0.05 mm 4e-20 m on the level part of an arc of 13 mm, 1e-13 m where it stands at 70 degrees. Cells in which the
//! quintic leaves the curve by more than [`CLOSE`] or its slope by more than [`PARALLEL`] (beyond 62 degrees of that arc), or in which
//! a piece ends, are left out: there the curve itself is read. Neighbouring cells have one curvature where they meet.

use super::ProfilePoint;

/// Width of a cell, m, at most.
const WIDTH: f64 = 5e-5;
/// Furthest that a cell may be from the curve, m, and the same in slope.
const CLOSE: f64 = 1e-13;
const PARALLEL: f64 = 1e-10;

const TERMS: usize = 6;

/// Coefficients of value [m] and slope [m per cell], next to each other, in powers of s; the first is NaN where the curve must be read.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
struct Cell([[f64; 2]; TERMS]);

#[derive(Clone, Debug)]
pub(super) struct Table {
    cells_per_metre: f64,
    /// Number (with its fraction) of the place x = 0 in the middle of a cell, times -1.
    offset: f64,
    count: f64,
    cells: Vec<Cell>,
}

/// The quintic in s of a cell of this width, from a curve's points at both ends.
fn quintic(width: f64, from: &ProfilePoint, to: &ProfilePoint) -> [f64; TERMS] {
    let (rise, slopes, bends) = (to.value - from.value, [from.d1, to.d1].map(|d| d * width), [from.d2, to.d2].map(|d| d * width * width));
    let [a, b, c] = [rise - slopes[0] - 0.5 * bends[0], slopes[1] - slopes[0] - bends[0], bends[1] - bends[0]];
    let (third, fourth, fifth) = (10.0 * a - 4.0 * b + 0.5 * c, -15.0 * a + 7.0 * b - c, 6.0 * a - 3.0 * b + 0.5 * c);
    shifted([from.value, slopes[0], 0.5 * bends[0], third, fourth, fifth], 0.5)
}

impl Cell {
    fn new(value: [f64; TERMS]) -> Self {
        Cell(std::array::from_fn(|i| [value[i], value.get(i + 1).map_or(0.0, |c| (i + 1) as f64 * c)]))
    }

    /// Value, and slope in metres per cell: side by side, so that the compiler makes vector instructions of it.
    #[inline(always)]
    fn at(&self, s: f64) -> [f64; 2] {
        let mut sum = self.0[TERMS - 1];
        for term in self.0[..TERMS - 1].iter().rev() {
            sum = [sum[0] * s + term[0], sum[1] * s + term[1]];
        }
        sum
    }

    /// Value and three derivatives, per cell.
    #[inline(always)]
    fn derivatives(&self, s: f64) -> [f64; 4] {
        let step = |sum: [f64; 2], add: [f64; 2]| [sum[0] * s + add[0], sum[1] * s + add[1]];
        let (mut sum, mut rate, mut half) = (self.0[TERMS - 1], [0.0; 2], [0.0; 2]);
        for term in self.0[..TERMS - 1].iter().rev() {
            half = step(half, rate);
            rate = step(rate, sum);
            sum = step(sum, *term);
        }
        [sum[0], sum[1], rate[1], 2.0 * half[1]]
    }
}

/// Added to a number below 2^31 it leaves the nearest whole number in the last bits.
const WHOLE: f64 = 4_503_599_627_370_496.0;

impl Table {
    /// A table over `first` to `last` [m]; `curve` gives the curve over one cell, `None` where a piece ends in it.
    pub(super) fn new<C: Fn(f64) -> ProfilePoint>(first: f64, last: f64, curve: impl Fn(f64, f64) -> Option<C>) -> Self {
        let count = ((last - first) / WIDTH).ceil().max(1.0);
        let width = (last - first) / count;
        let cell = |index: usize| {
            let (from, to) = (first + index as f64 * width, first + (index + 1) as f64 * width);
            let curve = curve(from, to)?;
            let cell = Cell::new(quintic(width, &curve(from), &curve(to)));
            let near = |s: f64| {
                let (point, [value, slope]) = (curve(from + (0.5 + s) * width), cell.at(s));
                (value - point.value).abs() <= CLOSE && (slope / width - point.d1).abs() <= PARALLEL
            };
            [-0.25, 0.0, 0.25].into_iter().all(near).then_some(cell)
        };
        let cells = (0..count as usize).map(|index| cell(index).unwrap_or(Cell([[f64::NAN; 2]; TERMS]))).collect();
        Table { cells_per_metre: 1.0 / width, offset: first / width + 0.5, count, cells }
    }

    /// Slope of the profile per slope in metres per cell, 1/m.
    #[inline]
    pub(super) fn cells_per_metre(&self) -> f64 {
        self.cells_per_metre
    }

    /// The cell of `x`, and s; `None` where the curve must be read.
    #[inline(always)]
    fn cell(&self, x: f64) -> Option<(&Cell, f64)> {
        let place = x * self.cells_per_metre - self.offset;
        if !(place < self.count) {
            return None;
        }
        let nearest = place + WHOLE;
        // Below the first cell the last 32 bits make a very great number.
        let cell = self.cells.get(nearest.to_bits() as u32 as usize)?;
        (!cell.0[0][0].is_nan()).then_some((cell, place - (nearest - WHOLE)))
    }

    /// Two profiles at one coordinate each; `None` where the curve of one must be read.
    #[inline(always)]
    pub(super) fn near_both(tables: [&Table; 2], x: [f64; 2]) -> Option<[ProfilePoint; 2]> {
        let ((one, s), (other, z)) = (tables[0].cell(x[0])?, tables[1].cell(x[1])?);
        let point =
            |[value, d1, d2, d3]: [f64; 4], per: f64| ProfilePoint { value, d1: d1 * per, d2: d2 * per * per, d3: d3 * per * per * per };
        let [per, other_per] = tables.map(Table::cells_per_metre);
        Some([point(one.derivatives(s), per), point(other.derivatives(z), other_per)])
    }

    /// Value and slope; `None` where the curve must be read.
    #[inline]
    pub(super) fn read(&self, x: f64) -> Option<(f64, f64)> {
        let (cell, s) = self.cell(x)?;
        let [value, slope] = cell.at(s);
        Some((value, slope * self.cells_per_metre))
    }
}

/// Two tables, read at equal distances t from two places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Along<'a> {
    cells: [&'a [Cell]; 2],
    /// Numbers of the places at t = 0, and of cells per metre of t.
    place: [f64; 2],
    step: [f64; 2],
}

impl<'a> Along<'a> {
    /// The tables at `at` [m]; `along` is dx/dt.
    #[inline]
    pub(super) fn new(tables: [&'a Table; 2], at: [f64; 2], along: [f64; 2]) -> Self {
        Along {
            cells: tables.map(|table| table.cells.as_slice()),
            place: [0, 1].map(|i| at[i] * tables[i].cells_per_metre - tables[i].offset),
            step: [0, 1].map(|i| along[i] * tables[i].cells_per_metre),
        }
    }

    /// Values [m] and slopes in metres per cell, at less than 1e5 m; one or all are NaN where a curve must be read.
    #[inline(always)]
    pub(super) fn read(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        let place = [self.place[0] + self.step[0] * t, self.place[1] + self.step[1] * t];
        let nearest = [place[0] + WHOLE, place[1] + WHOLE];
        let index = nearest.map(|number| number.to_bits() as u32 as usize);
        let (Some(one), Some(other)) = (self.cells[0].get(index[0]), self.cells[1].get(index[1])) else {
            return ([f64::NAN; 2], [f64::NAN; 2]);
        };
        let (one, other) = (one.at(place[0] - (nearest[0] - WHOLE)), other.at(place[1] - (nearest[1] - WHOLE)));
        ([one[0], other[0]], [one[1], other[1]])
    }
}

/// Coefficients of p(t + step): a polynomial in powers of a variable that begins `step` later.
pub(super) fn shifted<const N: usize>(mut c: [f64; N], step: f64) -> [f64; N] {
    for first in 0..N {
        for i in (first..N - 1).rev() {
            c[i] += step * c[i + 1];
        }
    }
    c
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
        let (mut bend, mut third) = (0.0f64, 0.0f64);
        const COUNT: u32 = 100_003;
        for i in 0..=COUNT {
            let x = first + (last - first) * f64::from(i) / f64::from(COUNT);
            let (point, found) = (profile.at(x), profile.value_and_slope(x));
            value = value.max((found.0 - point.value).abs());
            slope = slope.max((found.1 - point.d1).abs());
            let [near, other] = Piecewise::near_both([&profile; 2], [x, 1e-3]);
            assert!((near.value, near.d1) == found && (other.value - profile.at(1e-3).value).abs() < 1e-13);
            bend = bend.max((near.d2 - point.d2).abs());
            third = third.max((near.d3 - point.d3).abs());
            exact += u32::from(found == (point.value, point.d1));
        }
        println!("value within {value:.1e} m, slope within {slope:.1e}, {exact} of {COUNT} read from the curve or equal to it");
        println!("second derivative within {bend:.1e} 1/m, third within {third:.1e} 1/m2");
        assert!(value < 1.1e-13 && slope < 1.1e-10 && bend < 2e-5 && third < 5.0);
        for x in [first - 1e-3, last + 1e-3, f64::NAN, 1e30, -1e30, 10e-3] {
            let point = profile.at(x);
            let found = profile.value_and_slope(x);
            assert!(found == (point.value, point.d1) || x.is_nan() && found.0.is_nan(), "{x}");
        }
    }
}
