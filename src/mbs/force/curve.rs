//! A force that is piecewise linear in a displacement or a speed.
//!
//! With the points x_0 .. x_n, the slopes s_i between them and r the half-width of rounded corners:
//!
//! ```text
//! F(x) = F_0 + s_0 (x - x_0) + sum_i (s_i - s_{i-1}) ramp(x - x_i)
//! ramp(u) = 0 below -r,  (u + r)^2 / 4 r within,  u above r
//! ```
//!
//! Outside of the points the first and last slope go on, or (`beyond = "hold"`) the first and last force hold. A table that is given `odd = true`
//! has its points at x >= 0 alone and F(-x) = -F(x). A rounded corner is the mean of the sharp one over x - r .. x + r, so F
//! stays monotone if the table is; it is shifted by a constant so that F(0) is the table's. Without rounding F has
//! corners (and an integrator with error control steps shorter there).

use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// A piecewise linear function with its integral from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// F = force_at_zero + slope x + the corners' ramps, less the ramps at zero.
    force_at_zero: f64,
    slope: f64,
    ramps_at_zero: f64,
    corners: Vec<Corner>,
    rounding: f64,
    /// What it was read from; `None` where nothing was.
    pub table: Option<Table>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    at: f64,
    change: f64,
    /// Integral of the ramp at zero.
    integral_at_zero: f64,
}

fn ramp(u: f64, r: f64) -> f64 {
    if u <= -r {
        0.0
    } else if u >= r {
        u
    } else {
        (u + r) * (u + r) / (4.0 * r)
    }
}

fn ramp_integral(u: f64, r: f64) -> f64 {
    if u <= -r {
        0.0
    } else if u >= r {
        0.5 * u * u + r * r / 6.0
    } else {
        (u + r).powi(3) / (12.0 * r)
    }
}

impl Curve {
    /// `F = slope x`.
    pub fn linear(slope: f64) -> Self {
        Curve { force_at_zero: 0.0, slope, ramps_at_zero: 0.0, corners: Vec::new(), rounding: 0.0, table: None }
    }

    /// The slope where it is the same everywhere and no table says it.
    pub fn linear_slope(&self) -> Option<f64> {
        (self.corners.is_empty() && self.table.is_none()).then_some(self.slope)
    }

    /// Through points [x, F] with x increasing; `None` unless there are two or more of them.
    pub fn new(points: &[[f64; 2]], rounding: f64) -> Option<Self> {
        let slopes: Vec<f64> = points.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).collect();
        if slopes.is_empty() || points.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
            return None;
        }
        let corner = |(slopes, point): (&[f64], &[f64; 2])| {
            let (at, change) = (point[0], slopes[1] - slopes[0]);
            Corner { at, change, integral_at_zero: ramp_integral(-at, rounding) }
        };
        let corners: Vec<Corner> = slopes.windows(2).zip(&points[1..]).map(corner).filter(|corner| corner.change != 0.0).collect();
        let sharp_at_zero: f64 = corners.iter().map(|corner| corner.change * ramp(-corner.at, 0.0)).sum();
        let ramps_at_zero = corners.iter().map(|corner| corner.change * ramp(-corner.at, rounding)).sum();
        let force_at_zero = points[0][1] - slopes[0] * points[0][0] + sharp_at_zero;
        Some(Curve { force_at_zero, slope: slopes[0], ramps_at_zero, corners, rounding, table: None })
    }

    /// The same, read from a table.
    pub(super) fn of(self, table: Option<Table>) -> Self {
        Curve { table, ..self }
    }

    /// The first place where the slope changes.
    pub fn first_corner(&self) -> Option<f64> {
        self.corners.first().map(|corner| corner.at)
    }

    /// The steepest slope, N/m or N s/m.
    pub fn steepest(&self) -> f64 {
        let mut slope = self.slope;
        let changed = self.corners.iter().map(|corner| {
            slope += corner.change;
            slope
        });
        changed.fold(self.slope, f64::max)
    }

    /// F(x), N.
    #[inline]
    pub fn force(&self, x: f64) -> f64 {
        let mut force = self.force_at_zero - self.ramps_at_zero + self.slope * x;
        for corner in &self.corners {
            if x <= corner.at - self.rounding {
                break;
            }
            force += corner.change * ramp(x - corner.at, self.rounding);
        }
        force
    }

    /// dF/dx, N/m; beyond a sharp corner that of the side that x is on.
    #[inline]
    pub fn slope(&self, x: f64) -> f64 {
        let mut slope = self.slope;
        for corner in &self.corners {
            let u = x - corner.at;
            if u <= -self.rounding {
                break;
            }
            slope += corner.change * if u >= self.rounding { 1.0 } else { (u + self.rounding) / (2.0 * self.rounding) };
        }
        slope
    }

    /// Integral of F from 0 to x, J.
    pub fn energy(&self, x: f64) -> f64 {
        let ramps = self.corners.iter().map(|corner| {
            let integral = ramp_integral(x - corner.at, self.rounding);
            corner.change * (integral - corner.integral_at_zero)
        });
        (self.force_at_zero - self.ramps_at_zero + 0.5 * self.slope * x) * x + ramps.sum::<f64>()
    }
}

/// What a table must be, beyond increasing in its first column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Any,
    /// F(0) = 0 and F not falling: what a damper must be so as not to feed energy in.
    Passive,
    /// The same, but rising without rests, so that speed is a function of force.
    Invertible,
    /// From x = 0 on, F(0) = 0 and F not falling: a stop.
    Stop,
}

/// Reads the points at `key`, `[[x, F], ...]`.
pub(super) fn points(section: &Section, key: &'static str, x: Dimension, shape: Shape) -> Result<Vec<[f64; 2]>, SettingsError> {
    let points = section.pairs(key, x, Dimension::Force)?;
    let wrong = |problem: &str| Err(section.error(key, problem));
    if points.len() < 2 || points.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
        return wrong("expected two or more points [x, force] with x increasing");
    }
    if shape == Shape::Any {
        return Ok(points);
    }
    if points.windows(2).any(|pair| pair[1][1] < pair[0][1]) {
        return wrong("the force must not fall from point to point");
    }
    if shape == Shape::Invertible && points.windows(2).any(|pair| pair[1][1] == pair[0][1]) {
        return wrong("the force must rise from point to point, so that the speed is known from it");
    }
    if shape == Shape::Stop && points[0] != [0.0, 0.0] {
        return wrong("the first point must be [0, 0]; displacements count from zero away from the middle");
    }
    match Curve::new(&points, 0.0) {
        Some(curve) if curve.force(0.0).abs() <= 1e-12 * points.iter().fold(1.0, |most: f64, point| most.max(point[1].abs())) => Ok(points),
        _ => wrong("the force must vanish at zero"),
    }
}

/// What a table says beyond its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// The last force.
    Hold,
    /// The last slope.
    Slope,
}

/// Range of a table of forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    pub key: &'static str,
    /// m or m/s.
    pub unit: &'static str,
    /// First and last x.
    pub from: f64,
    pub to: f64,
    pub beyond: Beyond,
    /// Its points are on one side of zero alone, and nothing says how it goes on on the other one.
    pub one_sided: bool,
}

/// How a section's tables go on: `odd` and `beyond`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outside {
    odd: bool,
    pub beyond: Beyond,
}

impl Outside {
    /// Reads `odd` and `beyond`, which serve all tables of the section.
    pub fn parse(section: &Section, tables: &[&'static str]) -> Result<Outside, SettingsError> {
        let lonely = ["odd", "beyond"].into_iter().find(|key| section.has(key) && !tables.iter().any(|table| section.has(table)));
        if let Some(key) = lonely {
            return Err(section.error(key, format!("serves nothing without a table ({})", tables.join(", "))));
        }
        let beyond = match section.word_or("beyond", &["hold", "slope"], "slope")? {
            "hold" => Beyond::Hold,
            _ => Beyond::Slope,
        };
        Ok(Outside { odd: section.flag_or("odd", false)?, beyond })
    }

    /// Reads `beyond` of a stop, which has its sides by itself: `odd` is not one of its keys.
    pub fn stop(section: &Section, tables: &[&'static str]) -> Result<Outside, SettingsError> {
        if section.has("odd") {
            return Err(section.error("odd", "serves nothing here: a stop's table holds on every side that it stops"));
        }
        Outside::parse(section, tables)
    }

    /// The points with their mirror image, where the section says so.
    fn complete(&self, section: &Section, key: &'static str, points: Vec<[f64; 2]>) -> Result<Vec<[f64; 2]>, SettingsError> {
        if !self.odd {
            return Ok(points);
        }
        if points.first() != Some(&[0.0, 0.0]) {
            return Err(section
                .error(key, "with odd = true the table is given from [0, 0] on, for x > 0 alone; the other side is its mirror image"));
        }
        let mirrored = points[1..].iter().rev().map(|[x, force]| [-x, -force]);
        Ok(mirrored.chain(points.iter().copied()).collect())
    }

    /// Points that make the ends hold: one more on each side, at the same force.
    pub fn ends(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let (Beyond::Hold, Some(first), Some(last)) = (self.beyond, points.first(), points.last()) else { return points.to_vec() };
        let (before, after) = ([first[0] - 1.0, first[1]], [last[0] + 1.0, last[1]]);
        std::iter::once(before).chain(points.iter().copied()).chain([after]).collect()
    }
}

/// Reads a whole table with its sides: the points [`points`] returns, mirrored where they are to be, and their range.
pub(super) fn sided(
    section: &Section,
    key: &'static str,
    x: Dimension,
    shape: Shape,
    outside: &Outside,
) -> Result<(Vec<[f64; 2]>, Table), SettingsError> {
    let points = outside.complete(section, key, points(section, key, x, shape)?)?;
    let (from, to) = (points[0][0], points[points.len() - 1][0]);
    let unit = if x == Dimension::Speed { "m/s" } else { "m" };
    Ok((points, Table { key, unit, from, to, beyond: outside.beyond, one_sided: from >= 0.0 || to <= 0.0 }))
}

/// Reads the table at `table`, or the slope at `slope`; `None` when neither is given.
pub(super) fn parse(
    section: &Section,
    (table, x): (&'static str, Dimension),
    (slope, unit): (&'static str, Dimension),
    (shape, outside): (Shape, &Outside),
    rounding: f64,
) -> Result<Option<Curve>, SettingsError> {
    match (section.has(table), section.has(slope)) {
        (true, true) => Err(section.error(table, format!("says again what \"{slope}\" says; give one of them"))),
        (true, false) => {
            let (points, range) = sided(section, table, x, shape, outside)?;
            let curve = Curve::new(&outside.ends(&points), rounding).ok_or_else(|| section.error(table, "expected two or more points"))?;
            Ok(Some(curve.of(Some(range))))
        }
        (false, true) => Ok(Some(Curve::linear(section.not_negative(slope, unit)?))),
        (false, false) => Ok(None),
    }
}
