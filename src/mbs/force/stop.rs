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

use super::POSITIVE;
use super::curve::{Curve, Outside, Shape, Table, sided};
use super::line::{LineLaw, Slopes};
use crate::settings::{Constant, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};

/// Stops in one or both directions.
#[derive(Clone, Debug)]
pub struct Stop {
    /// For elongation and for shortening.
    pub extension: Option<Buffer>,
    pub compression: Option<Buffer>,
    /// b, s/m.
    pub damping: f64,
}

/// What one side does behind its clearance.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// N/m; `None` where a table stands in its place.
    stiffness: Option<f64>,
    /// Points [m, N] behind the clearance.
    beyond: Vec<[f64; 2]>,
    /// m.
    clearance: f64,
    /// Half-width of rounded corners, m; no more of it counts than leaves the middle free.
    rounding: f64,
    /// f, N over m.
    curve: Curve,
}

impl Buffer {
    /// `None` unless there are two or more points.
    fn lay(stiffness: Option<f64>, beyond: Vec<[f64; 2]>, clearance: f64, rounding: f64, table: Option<Table>) -> Option<Buffer> {
        // Free from some place on the other side of the middle.
        let free = std::iter::once([-1.0, 0.0]);
        let all: Vec<[f64; 2]> = free.chain(beyond.iter().map(|[u, force]| [u + clearance, *force])).collect();
        let sharp = Curve::new(&all, 0.0)?;
        let curve = Curve::new(&all, rounding.min(sharp.first_corner().unwrap_or(rounding)))?.of(table);
        Some(Buffer { stiffness, beyond, clearance, rounding, curve })
    }

    fn change(&mut self, stiffness: Option<f64>, clearance: f64) {
        let beyond = stiffness.map_or_else(|| self.beyond.clone(), slope);
        let further = clearance - self.clearance;
        let table = self.curve.table.map(|table| Table { to: table.to + further, ..table });
        if let Some(changed) = Buffer::lay(stiffness, beyond, clearance, self.rounding, table) {
            *self = changed;
        }
    }
}

/// Points of a constant stiffness, N/m.
fn slope(stiffness: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [1.0, stiffness]]
}

/// No stop of a vehicle is free so far, m.
const FAR: f64 = 1.0;
/// How far behind the place where it touches a stop's stiffness is looked up, m.
const TOUCH: f64 = 1e-6;

impl Stop {
    fn buffers(&mut self) -> impl Iterator<Item = &mut Buffer> {
        self.extension.iter_mut().chain(&mut self.compression)
    }
}

/// A number of one side.
macro_rules! side_stiffness {
    ($number:literal, $name:literal, $side:ident, $text:literal) => {
        Constant {
            number: $number,
            name: $name,
            unit: Unit::NewtonPerMetre,
            least: POSITIVE,
            tunable: true,
            description: $text,
            get: |law: &Stop| law.$side.as_ref()?.stiffness,
            set: |law, value| law.$side.iter_mut().for_each(|side| side.change(Some(value), side.clearance)),
        }
    };
}

impl Stop {
    /// f, the sign of T, and u' on the side that x is on.
    #[inline]
    fn side(&self, x: f64, rate: f64) -> (f64, f64, f64) {
        let (curve, sign) = if x > 0.0 { (&self.extension, 1.0) } else { (&self.compression, -1.0) };
        (curve.as_ref().map_or(0.0, |side| side.curve.force(sign * x)), sign, sign * rate)
    }
}

impl Numbered for Stop {
    const CONSTANTS: &'static [Constant<Self>] = &[
        side_stiffness!(0, "extensionStiffness", extension, "stiffness of the stop in tension, beyond the free travel"),
        side_stiffness!(1, "compressionStiffness", compression, "stiffness of the stop in compression, beyond the free travel"),
        constant!(tunable 2, "clearance", Metre, Some(0.0), "free travel of each side before the stop's stiffness or table", get: |law| law.extension.as_ref().or(law.compression.as_ref()).map(|side| side.clearance), set: |law, value| law.buffers().for_each(|side| side.change(side.stiffness, value))),
        constant!(tunable 3, "damping", SecondPerMetre, Some(0.0), "growth of the stop's force with the speed of pressing", damping),
    ];
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
        let slope = curve.as_ref().map_or(0.0, |side| side.curve.slope(sign * x));
        let by_rate = if damped > 0.0 { force * self.damping } else { 0.0 };
        Slopes { by_displacement: slope * damped, by_rate, ..Slopes::default() }
    }

    fn potential_energy(&self, x: f64, _: &[f64]) -> f64 {
        let curve = if x > 0.0 { &self.extension } else { &self.compression };
        curve.as_ref().map_or(0.0, |side| side.curve.energy(x.abs()))
    }

    fn tables(&self) -> Vec<Table> {
        [&self.extension, &self.compression].into_iter().filter_map(|side| side.as_ref()?.curve.table).collect()
    }

    fn table_argument(&self, table: usize, x: f64, _: f64, _: &[f64]) -> f64 {
        let first = self.extension.as_ref().is_some_and(|side| side.curve.table.is_some());
        if table == 0 && first { x } else { -x }
    }

    fn free_travel(&self) -> Option<[f64; 2]> {
        let free = |side: &Option<Buffer>| side.as_ref().and_then(|side| side.curve.first_corner()).unwrap_or(f64::INFINITY);
        Some([-free(&self.compression), free(&self.extension)])
    }

    fn doubt(&self, away: Option<f64>) -> Option<String> {
        let free = self.free_travel()?.map(f64::abs).into_iter().filter(|free| free.is_finite()).fold(0.0, f64::max);
        if free > FAR {
            return Some(format!("a free travel of {free} m: was another unit meant (\"{free} mm\")?"));
        }
        (self.extension.is_none() && away.is_some_and(|away| away < 0.0)).then(|| {
            "sides = \"compression\" presses where \"to\" moves against the axis, and \"to\" lies on that side of \"from\": it acts where the two part. The opposite axis (\"-x\" for \"x\") \
             makes it act where they come together"
                .into()
        })
    }

    fn striking_stiffness(&self, x: f64) -> Option<f64> {
        let behind = |side: &Option<Buffer>, u: f64| {
            let corner = |side: &Buffer| side.curve.first_corner().unwrap_or(0.0) + side.rounding + TOUCH;
            side.as_ref().map_or(0.0, |side| side.curve.slope(u.max(corner(side))))
        };
        let (longer, shorter) = (behind(&self.extension, x), behind(&self.compression, -x));
        let (free, pressed) = (longer.max(shorter), self.side(x, 0.0).0 > 0.0);
        Some(if !pressed {
            free
        } else if x > 0.0 {
            longer
        } else {
            shorter
        })
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
) -> Result<Buffer, SettingsError> {
    let (mut range, mut own) = (None, None);
    let beyond = match (section.has(table), section.has(stiffness)) {
        (true, true) => return Err(section.error(table, format!("says again what \"{stiffness}\" says; give one of them"))),
        (true, false) => {
            let (points, read) = sided(section, table, Dimension::Length, Shape::Stop, outside)?;
            // On the other side it is free.
            range = Some(Table { from: f64::NEG_INFINITY, to: read.to + clearance, one_sided: false, ..read });
            outside.ends(&points).split_off(usize::from(outside.beyond == super::curve::Beyond::Hold))
        }
        (false, _) => slope(*own.insert(section.positive(stiffness, Dimension::Stiffness)?)),
    };
    let side = Buffer::lay(own, beyond, clearance, rounding, range).ok_or_else(|| section.error(table, "expected two or more points"))?;
    if side.curve.first_corner().is_some_and(|at| at < rounding) {
        let problem = "must not be larger than the free travel, so that the stop is free in the middle";
        return Err(section.error("rounding", problem));
    }
    Ok(side)
}

/// Reads `rounding` and `damping`.
pub(super) fn options(section: &Section) -> Result<(f64, f64), SettingsError> {
    Ok((section.not_negative_or("rounding", Dimension::Length, 0.0)?, section.not_negative_or("damping", Dimension::PerSpeed, 0.0)?))
}
