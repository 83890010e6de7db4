//! Profile made of arcs and polynomials, each exact, joined at given coordinates.
//!
//! Arc: `crest - branch t^2 / (radius + sqrt(radius^2 - t^2))` with t = x - centre, which is `height + branch
//! sqrt(radius^2 - t^2)` without its cancellation near the crest; branch +1 is the upper half of the circle
//! (convex surface), -1 the lower (hollow surface). Polynomial: `sum c_i t^i`, t = x - origin, with the origin
//! near the piece, so that high powers do not cancel. Beyond the range the profile goes on as a straight line
//! (value and slope continuous). SI units.

use super::table::{self, Table, shifted};
use super::{Bend, Profile, ProfilePoint};

/// Most coefficients of a polynomial.
pub(super) const TERMS: usize = 9;

/// A curve y(x).
#[derive(Clone, Debug)]
pub(super) enum Curve {
    Arc {
        centre: f64,
        crest: f64,
        radius: f64,
        branch: f64,
        /// Cubic in t that is added to the arc to close a joint; zero for most arcs.
        correction: [f64; 4],
    },
    Polynomial {
        origin: f64,
        coefficients: [f64; TERMS],
        degree: usize,
    },
}

impl Curve {
    /// Arc around (`centre`, `height`) [m]; `branch` +1 for its upper, -1 for its lower half.
    pub(super) fn arc(centre: f64, height: f64, radius: f64, branch: f64) -> Self {
        Curve::Arc { centre, crest: height + branch * radius, radius, branch, correction: [0.0; 4] }
    }

    /// `sum c_i (x - origin)^i`; more than [`TERMS`] coefficients are not taken.
    pub(super) fn polynomial(origin: f64, terms: &[f64]) -> Self {
        let mut coefficients = [0.0; TERMS];
        let count = terms.len().min(TERMS);
        coefficients[..count].copy_from_slice(&terms[..count]);
        Curve::Polynomial { origin, coefficients, degree: count.saturating_sub(1) }
    }

    /// The straight line through two points.
    pub(super) fn line(from: (f64, f64), to: (f64, f64)) -> Self {
        Curve::polynomial(from.0, &[from.1, (to.1 - from.1) / (to.0 - from.0)])
    }

    /// The cubic with given values and slopes at two coordinates.
    pub(super) fn hermite(from: (f64, f64, f64), to: (f64, f64, f64)) -> Self {
        Curve::polynomial(from.0, &hermite(to.0 - from.0, (from.1, from.2), (to.1, to.2)))
    }

    /// Adds the cubic `sum c_i (x - at)^i`.
    pub(super) fn add(&mut self, at: f64, cubic: [f64; 4]) {
        match self {
            Curve::Arc { centre, correction, .. } => {
                for (sum, term) in correction.iter_mut().zip(shifted(cubic, *centre - at)) {
                    *sum += term;
                }
            }
            Curve::Polynomial { origin, coefficients, degree } => {
                for (sum, term) in coefficients.iter_mut().zip(shifted(cubic, *origin - at)) {
                    *sum += term;
                }
                *degree = (*degree).max(3);
            }
        }
    }

    /// The same curve moved by (`dx`, `dy`).
    pub(super) fn moved(mut self, dx: f64, dy: f64) -> Self {
        match &mut self {
            Curve::Arc { centre, crest, .. } => {
                *centre += dx;
                *crest += dy;
            }
            Curve::Polynomial { origin, coefficients, .. } => {
                *origin += dx;
                coefficients[0] += dy;
            }
        }
        self
    }

    #[inline]
    pub(super) fn at(&self, x: f64) -> ProfilePoint {
        match self {
            Curve::Arc { centre, crest, radius, branch, correction: [c0, c1, c2, c3] } => {
                let t = x - centre;
                let drop = (radius * radius - t * t).sqrt();
                let inverse = branch / drop;
                // drop^2 of 1 / drop^3 and so on; branch^2 = 1.
                let d2 = radius * radius * inverse * inverse * inverse;
                ProfilePoint {
                    value: crest - branch * t * t / (radius + drop) + (c0 + t * (c1 + t * (c2 + t * c3))),
                    d1: -t * inverse + (c1 + t * (2.0 * c2 + 3.0 * t * c3)),
                    d2: -d2 + (2.0 * c2 + 6.0 * t * c3),
                    d3: -3.0 * d2 * t * inverse * inverse + 6.0 * c3,
                }
            }
            Curve::Polynomial { origin, coefficients, degree } => {
                let t = x - origin;
                let (mut value, mut d1, mut d2, mut d3) = (coefficients[*degree], 0.0, 0.0, 0.0);
                for c in coefficients[..*degree].iter().rev() {
                    d3 = d3 * t + d2;
                    d2 = d2 * t + d1;
                    d1 = d1 * t + value;
                    value = value * t + c;
                }
                ProfilePoint { value, d1, d2: 2.0 * d2, d3: 6.0 * d3 }
            }
        }
    }
}

/// Coefficients of the cubic with (value, slope) at 0 and at `length`.
pub(super) fn hermite(length: f64, from: (f64, f64), to: (f64, f64)) -> [f64; 4] {
    let rise = (to.0 - from.0) / length;
    [from.0, from.1, (3.0 * rise - 2.0 * from.1 - to.1) / length, (from.1 + to.1 - 2.0 * rise) / (length * length)]
}

/// A curve between two coordinates [m].
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub from: f64,
    pub to: f64,
    pub curve: Curve,
}

/// A jump of the second derivative below this [1/m] is no joint: it is 1e-6 of a rail head's own curvature.
const JOINT: f64 = 1e-6;
/// One above this [1/m] would be seen in a cubic over some millimetres: a change of height by 1e-7 m within 8 mm.
const BEND: f64 = 0.1;
/// A jump of the slope below this is rounding.
const KINK: f64 = 1e-10;
/// Cells of the lookup table: a cell rarely holds more than one joint.
const CELLS: usize = 128;

/// A profile of consecutive pieces.
#[derive(Clone, Debug)]
pub struct Piecewise {
    pieces: Vec<Piece>,
    begin: ProfilePoint,
    end: ProfilePoint,
    /// The piece in which each of [`CELLS`] equally wide cells begins.
    cells: Vec<u32>,
    cells_per_metre: f64,
    table: Table,
    bends: Vec<Bend>,
    description: String,
}

impl Piecewise {
    /// Joins pieces that follow each other without gap; `None` when there is none, or one is empty.
    pub(super) fn new(pieces: Vec<Piece>, description: String) -> Option<Self> {
        let (first, last) = (pieces.first()?, pieces.last()?);
        if pieces.iter().any(|piece| !(piece.to > piece.from)) || pieces.windows(2).any(|pair| pair[0].to != pair[1].from) {
            return None;
        }
        let cells_per_metre = CELLS as f64 / (last.to - first.from);
        let cells = (0..CELLS)
            .map(|cell| {
                let start = first.from + cell as f64 / cells_per_metre;
                pieces.iter().rposition(|piece| piece.from <= start).unwrap_or(0) as u32
            })
            .collect();
        let (begin, end) = (first.curve.at(first.from), last.curve.at(last.to));
        let curve = |from: f64, to: f64| {
            let piece = pieces.iter().find(|piece| piece.from <= from && to <= piece.to)?;
            Some(|x: f64| piece.curve.at(x))
        };
        let table = Table::new(first.from, last.to, curve);
        let mut profile = Piecewise { begin, end, cells, cells_per_metre, table, bends: Vec::new(), description, pieces };
        let joints = profile.inner_joints(|left, right| (left.d2 - right.d2).abs() > BEND);
        let bend = |at| {
            let point = profile.at(at);
            Bend { at, value: point.value, slope: point.d1 }
        };
        profile.bends = joints.into_iter().map(bend).collect();
        Some(profile)
    }

    /// The piece that holds `x`, which lies in the range.
    #[inline]
    fn piece(&self, x: f64, first: f64) -> &Piece {
        let cell = (((x - first) * self.cells_per_metre) as usize).min(CELLS - 1);
        let mut i = self.cells[cell] as usize;
        // Rounding may put x one cell too far; then step back first.
        while i > 0 && x < self.pieces[i].from {
            i -= 1;
        }
        while i + 1 < self.pieces.len() && x >= self.pieces[i + 1].from {
            i += 1;
        }
        &self.pieces[i]
    }

    fn inner_joints(&self, jump: impl Fn(ProfilePoint, ProfilePoint) -> bool) -> Vec<f64> {
        let pairs = self.pieces.windows(2).filter(|pair| jump(pair[0].curve.at(pair[0].to), pair[1].curve.at(pair[0].to)));
        pairs.map(|pair| pair[0].to).collect()
    }

    /// Largest jumps of value [m] and slope between neighbouring pieces.
    #[cfg(test)]
    pub(super) fn largest_jumps(&self) -> (f64, f64) {
        self.pieces.windows(2).fold((0.0f64, 0.0f64), |(value, slope), pair| {
            let (left, right) = (pair[0].curve.at(pair[0].to), pair[1].curve.at(pair[0].to));
            (value.max((left.value - right.value).abs()), slope.max((left.d1 - right.d1).abs()))
        })
    }
}

/// Two profiles, read at equal distances t from two places, for laws that read them at many.
#[derive(Clone, Copy, Debug)]
pub struct Along<'a> {
    tables: table::Along<'a>,
    /// Slope [-] of each profile per slope as it is read.
    pub unit: [f64; 2],
}

impl<'a> Along<'a> {
    /// The profiles at `at` [m]; `along` is dx/dt.
    #[inline]
    pub fn new(profiles: [&'a Piecewise; 2], at: [f64; 2], along: [f64; 2]) -> Self {
        let tables = profiles.map(|profile| &profile.table);
        Along { tables: table::Along::new(tables, at, along), unit: tables.map(Table::cells_per_metre) }
    }

    /// Values [m] and slopes in their own units, at less than 1e5 m from the profiles' origins; NaN where [`Profile::at`] must be asked.
    #[inline(always)]
    pub fn read(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        self.tables.read(t)
    }
}

impl Piecewise {
    /// Two profiles at one coordinate each, as [`Profile::at`] gives them to within 1e-13 m, 1e-10, 2e-5 1/m and 5 1/m2.
    #[inline(always)]
    pub fn near_both(profiles: [&Piecewise; 2], x: [f64; 2]) -> [ProfilePoint; 2] {
        Table::near_both(profiles.map(|profile| &profile.table), x).unwrap_or_else(|| Self::at_both(profiles, x))
    }

    #[cold]
    #[inline(never)]
    fn at_both(profiles: [&Piecewise; 2], x: [f64; 2]) -> [ProfilePoint; 2] {
        [0, 1].map(|i| profiles[i].at(x[i]))
    }
}

/// The straight line through `point` at a distance from it.
fn straight_on(point: &ProfilePoint, distance: f64) -> ProfilePoint {
    ProfilePoint { value: point.value + point.d1 * distance, d1: point.d1, d2: 0.0, d3: 0.0 }
}

impl Profile for Piecewise {
    #[inline]
    fn at(&self, x: f64) -> ProfilePoint {
        let (first, last) = self.range();
        if !(x >= first) {
            return straight_on(&self.begin, x - first);
        }
        if x > last {
            return straight_on(&self.end, x - last);
        }
        self.piece(x, first).curve.at(x)
    }

    #[inline]
    fn value_and_slope(&self, x: f64) -> (f64, f64) {
        let read = |x: f64| {
            let p = self.at(x);
            (p.value, p.d1)
        };
        self.table.read(x).unwrap_or_else(|| read(x))
    }

    #[inline]
    fn piecewise(&self) -> Option<&Piecewise> {
        Some(self)
    }

    fn range(&self) -> (f64, f64) {
        (self.pieces[0].from, self.pieces[self.pieces.len() - 1].to)
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn joints(&self) -> Vec<f64> {
        self.inner_joints(|left, right| (left.d2 - right.d2).abs() > JOINT)
    }

    fn bends(&self) -> &[Bend] {
        &self.bends
    }

    fn kinks(&self) -> Vec<f64> {
        self.inner_joints(|left, right| (left.d1 - right.d1).abs() > KINK * (1.0 + left.d1 * left.d1))
    }
}
