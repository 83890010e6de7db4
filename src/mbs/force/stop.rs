//! The law of stops that only press: a free travel either way, then a force that rises with displacement.
//!
//! For extension u = x, u' = x'; for compression u = -x, u' = -x' and T < 0:
//!
//! ```text
//! |T| = f(u) max(0, 1 + b u')
//! ```
//!
//! with a piecewise linear f that vanishes within the clearance. The damping (b, s/m) rises with the force, so that T
//! is continuous where the stop touches, and the stop never pulls. Dissipated: `(|T| - f) u'`, never negative.

use super::curve::{Curve, Outside, Shape, Table, sided};
use super::line::{LineLaw, Slopes};
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// Stops in one or both directions.
#[derive(Clone, Debug)]
pub struct Stop {
    /// f for elongation and for shortening, N over m.
    pub extension: Option<Curve>,
    pub compression: Option<Curve>,
    /// b, s/m.
    pub damping: f64,
}

impl Stop {
    /// f, the sign of T, and u' on the side that x is on.
    #[inline]
    fn side(&self, x: f64, rate: f64) -> (f64, f64, f64) {
        let (curve, sign) = if x > 0.0 { (&self.extension, 1.0) } else { (&self.compression, -1.0) };
        (curve.as_ref().map_or(0.0, |curve| curve.force(sign * x)), sign, sign * rate)
    }
}

impl LineLaw for Stop {
    #[inline]
    fn tension(&self, x: f64, rate: f64, _: &[f64]) -> f64 {
        let (force, sign, rate) = self.side(x, rate);
        sign * force * (1.0 + self.damping * rate).max(0.0)
    }

    fn slopes(&self, x: f64, rate: f64, _: &[f64]) -> Slopes {
        let (force, sign, rate) = self.side(x, rate);
        let damped = (1.0 + self.damping * rate).max(0.0);
        let curve = if x > 0.0 { &self.extension } else { &self.compression };
        let slope = curve.as_ref().map_or(0.0, |curve| curve.slope(sign * x));
        let by_rate = if damped > 0.0 { force * self.damping } else { 0.0 };
        Slopes { by_displacement: slope * damped, by_rate, ..Slopes::default() }
    }

    fn potential_energy(&self, x: f64, _: &[f64]) -> f64 {
        let curve = if x > 0.0 { &self.extension } else { &self.compression };
        curve.as_ref().map_or(0.0, |curve| curve.energy(x.abs()))
    }

    fn tables(&self) -> Vec<Table> {
        [&self.extension, &self.compression].into_iter().filter_map(|curve| curve.as_ref()?.table).collect()
    }

    fn table_argument(&self, table: usize, x: f64, _: f64, _: &[f64]) -> f64 {
        let first = self.extension.as_ref().is_some_and(|curve| curve.table.is_some());
        if table == 0 && first { x } else { -x }
    }

    fn free_travel(&self) -> Option<[f64; 2]> {
        let free = |curve: &Option<Curve>| curve.as_ref().and_then(Curve::first_corner).unwrap_or(f64::INFINITY);
        Some([-free(&self.compression), free(&self.extension)])
    }

    fn dissipated_power(&self, x: f64, rate: f64, _: &[f64]) -> f64 {
        let (force, _, rate) = self.side(x, rate);
        force * ((1.0 + self.damping * rate).max(0.0) - 1.0) * rate
    }
}

/// Reads one side: a table of force over displacement beyond the clearance, or a stiffness.
pub(super) fn side(
    section: &Section,
    (table, stiffness): (&'static str, &'static str),
    clearance: f64,
    rounding: f64,
    outside: &Outside,
) -> Result<Curve, SettingsError> {
    let mut range = None;
    let beyond = match (section.has(table), section.has(stiffness)) {
        (true, true) => return Err(section.error(table, format!("says again what \"{stiffness}\" says; give one of them"))),
        (true, false) => {
            let (points, read) = sided(section, table, Dimension::Length, Shape::Stop, outside)?;
            // On the other side it is free.
            range = Some(Table { from: f64::NEG_INFINITY, to: read.to + clearance, one_sided: false, ..read });
            outside.ends(&points).split_off(usize::from(outside.beyond == super::curve::Beyond::Hold))
        }
        (false, _) => vec![[0.0, 0.0], [1.0, section.positive(stiffness, Dimension::Stiffness)?]],
    };
    // Free from some place on the other side of the middle.
    let free = std::iter::once([-1.0, 0.0]);
    let all: Vec<[f64; 2]> = free.chain(beyond.iter().map(|[u, force]| [u + clearance, *force])).collect();
    let curve = Curve::new(&all, rounding).ok_or_else(|| section.error(table, "expected two or more points"))?;
    if curve.first_corner().is_some_and(|at| at < rounding) {
        let problem = "must not be larger than the free travel, so that the stop is free in the middle";
        return Err(section.error("rounding", problem));
    }
    Ok(curve.of(range))
}

/// Reads `rounding` and `damping`.
pub(super) fn options(section: &Section) -> Result<(f64, f64), SettingsError> {
    let not_negative = |key, dimension| if section.has(key) { section.not_negative(key, dimension) } else { Ok(0.0) };
    Ok((not_negative("rounding", Dimension::Length)?, not_negative("damping", Dimension::PerSpeed)?))
}
