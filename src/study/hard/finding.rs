//! One number with the bound that it must keep.

use serde::Serialize;

/// How a number is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Unit {
    Metre,
    Radian,
    Newton,
    MetrePerSecond,
    MetrePerSecond2,
    RadianPerSecond2,
    Second,
    /// Written in per cent.
    Share,
    /// A plain number or a count.
    One,
}

/// What was found, and what it may be at most.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    pub what: String,
    pub measured: f64,
    pub bound: f64,
    pub unit: Unit,
}

impl Finding {
    /// `measured` must not exceed `bound`.
    pub fn new(what: impl Into<String>, measured: f64, bound: f64, unit: Unit) -> Finding {
        Finding { what: what.into(), measured, bound, unit }
    }

    /// Distance of a number from what a formula or a publication says, over that.
    pub fn relative(what: impl Into<String>, found: f64, expected: f64, bound: f64) -> Finding {
        Finding::new(what, (found / expected - 1.0).abs(), bound, Unit::Share)
    }

    /// A number that is no number does not hold.
    pub fn holds(&self) -> bool {
        self.measured <= self.bound
    }

    /// How near to its bound it is: 1 at the bound.
    pub fn strain(&self) -> f64 {
        if self.measured.is_nan() {
            return f64::INFINITY;
        }
        if self.measured == self.bound { 1.0 } else { self.measured / self.bound }
    }

    /// "error of Q 3.1 % (at most 2 %)".
    pub fn words(&self) -> String {
        format!("{} {} (at most {})", self.what, self.unit.write(self.measured), self.unit.write(self.bound))
    }
}

impl Unit {
    /// With two digits and the unit that people use.
    pub fn write(self, value: f64) -> String {
        let digits = |value: f64| {
            let size = value.abs();
            if size == 0.0 {
                "0".to_string()
            } else if (0.01..1e5).contains(&size) {
                let decimals = (1 - size.log10().floor() as i32).clamp(0, 4) as usize;
                format!("{value:.decimals$}")
            } else {
                format!("{value:.1e}")
            }
        };
        match self {
            Unit::Metre if value.abs() < 1e-6 => format!("{value:.1e} m"),
            Unit::Metre if value.abs() < 1.0 => format!("{} mm", digits(1e3 * value)),
            Unit::Metre => format!("{} m", digits(value)),
            Unit::Radian => format!("{} mrad", digits(1e3 * value)),
            Unit::Newton if value.abs() >= 1e3 => format!("{} kN", digits(1e-3 * value)),
            Unit::Newton => format!("{} N", digits(value)),
            Unit::MetrePerSecond => format!("{} m/s", digits(value)),
            Unit::MetrePerSecond2 => format!("{} m/s2", digits(value)),
            Unit::RadianPerSecond2 => format!("{} rad/s2", digits(value)),
            Unit::Second => format!("{} s", digits(value)),
            Unit::Share => format!("{} %", digits(100.0 * value)),
            Unit::One => digits(value),
        }
    }
}
