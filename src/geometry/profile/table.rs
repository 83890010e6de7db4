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
use super::piecewise::shifted;

/// Width of a cell, m, at most.
const WIDTH: f64 = 5e-5;
/// Furthest that a cell may be from the curve, m, and the same in slope.
const CLOSE: f64 = 1e-13;
const PARALLEL: f64 = 1e-10;

/// Coefficients in powers of s; the first is NaN where the curve must be read.
type Cell = [f64; 6];

#[derive(Clone, Debug)]
pub(super) struct Table {
    cells_per_metre: f64,
    /// Number (with its fraction) of the place x = 0 in the middle of a cell, times -1.
    offset: f64,
    count: f64,
    cells: Vec<Cell>,
}

/// The quintic in s of a cell of this width, from a curve's points at both ends.
fn quintic(width: f64, from: &ProfilePoint, to: &ProfilePoint) -> Cell {
    let (rise, slopes, bends) = (to.value - from.value, [from.d1, to.d1].map(|d| d * width), [from.d2, to.d2].map(|d| d * width * width));
    let [a, b, c] = [rise - slopes[0] - 0.5 * bends[0], slopes[1] - slopes[0] - bends[0], bends[1] - bends[0]];
    let (third, fourth, fifth) = (10.0 * a - 4.0 * b + 0.5 * c, -15.0 * a + 7.0 * b - c, 6.0 * a - 3.0 * b + 0.5 * c);
    shifted([from.value, slopes[0], 0.5 * bends[0], third, fourth, fifth], 0.5)
}

/// Values and slopes per cell of several cells at once, which the compiler turns into vector instructions.
#[inline(always)]
fn sums<const N: usize>(cells: [&Cell; N], s: [f64; N]) -> ([f64; N], [f64; N]) {
    let step = |sum: [f64; N], add: [f64; N]| -> [f64; N] { std::array::from_fn(|i| sum[i] * s[i] + add[i]) };
    let terms = |power: usize| -> [f64; N] { std::array::from_fn(|i| cells[i][power]) };
    let (mut value, mut slope) = (terms(5), [0.0; N]);
    for power in (0..5).rev() {
        slope = if power == 4 { value } else { step(slope, value) };
        value = step(value, terms(power));
    }
    (value, slope)
}

/// Values and their derivatives per cell, the last of them halved and by 6, of several cells at once.
#[inline(always)]
fn derivatives<const N: usize>(cells: [&Cell; N], s: [f64; N]) -> [[f64; N]; 4] {
    let step = |sum: [f64; N], add: [f64; N]| -> [f64; N] { std::array::from_fn(|i| sum[i] * s[i] + add[i]) };
    let terms = |power: usize| -> [f64; N] { std::array::from_fn(|i| cells[i][power]) };
    let top = terms(5);
    let mut sums = [step(top, terms(4)), top, [0.0; N], [0.0; N]];
    for power in (0..4).rev() {
        sums[3] = if power == 3 { [0.0; N] } else { step(sums[3], sums[2]) };
        sums[2] = if power == 3 { top } else { step(sums[2], sums[1]) };
        sums[1] = step(sums[1], sums[0]);
        sums[0] = step(sums[0], terms(power));
    }
    sums
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
            let cell = quintic(width, &curve(from), &curve(to));
            let near = |s: f64| {
                let (point, ([value], [slope])) = (curve(from + (0.5 + s) * width), sums([&cell], [s]));
                (value - point.value).abs() <= CLOSE && (slope / width - point.d1).abs() <= PARALLEL
            };
            [-0.25, 0.0, 0.25].into_iter().all(near).then_some(cell)
        };
        let cells = (0..count as usize).map(|index| cell(index).unwrap_or([f64::NAN; 6])).collect();
        Table { cells_per_metre: 1.0 / width, offset: first / width + 0.5, count, cells }
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
        (!cell[0].is_nan()).then_some((cell, place - (nearest - WHOLE)))
    }

    /// Two profiles at one coordinate each; `None` where the curve of one must be read.
    #[inline(always)]
    pub(super) fn near_both(tables: [&Table; 2], x: [f64; 2]) -> Option<[ProfilePoint; 2]> {
        let ((one, s), (other, z)) = (tables[0].cell(x[0])?, tables[1].cell(x[1])?);
        let [value, d1, d2, d3] = derivatives([one, other], [s, z]);
        Some([0, 1].map(|i| {
            let per = tables[i].cells_per_metre;
            ProfilePoint { value: value[i], d1: d1[i] * per, d2: 2.0 * d2[i] * per * per, d3: 6.0 * d3[i] * per * per * per }
        }))
    }

    /// Value and slope; `None` where the curve must be read.
    #[inline]
    pub(super) fn read(&self, x: f64) -> Option<(f64, f64)> {
        let (cell, s) = self.cell(x)?;
        let ([value], [slope]) = sums([cell], [s]);
        Some((value, slope * self.cells_per_metre))
    }

    /// Values and slopes of two profiles at once.
    #[inline(always)]
    pub(super) fn read_both(tables: [&Table; 2], x: [f64; 2]) -> Option<([f64; 2], [f64; 2])> {
        let ((one, s), (other, z)) = (tables[0].cell(x[0])?, tables[1].cell(x[1])?);
        let (values, slopes) = sums([one, other], [s, z]);
        Some((values, [slopes[0] * tables[0].cells_per_metre, slopes[1] * tables[1].cells_per_metre]))
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
