//! One variable of an FMU.

use super::real_parameter::RealParameter;
use crate::sim::SimulationState;
use crate::units::Unit;

/// References of parameters that belong to no wheelset stay below this; wheelset k (from 1) has k * 1000 to k * 1000 + 999.
pub(super) const WHEELSET: u32 = 1000;
/// FMI's variability of a parameter that may be set during the run.
pub(super) const TUNABLE: &str = "tunable";

/// What a variable stands for.
pub enum Role {
    /// Index in the model's input vector.
    Input(usize),
    /// Index in the table of outputs.
    Output(usize),
    /// A field of the scene.
    RealParameter(RealParameter),
    /// `initial.fromEquilibrium`.
    FromEquilibrium,
    /// A work counter.
    Counter(fn(&SimulationState) -> u64),
    /// The scene's title.
    Title,
    /// The simulated time.
    Time,
    /// How many contacts of a wheel carry load, by the wheel's first contact.
    Contacts(usize),
}

/// FMI's basic types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    String,
}

/// One scalar variable.
pub struct Variable {
    pub reference: u32,
    pub name: String,
    pub description: String,
    pub kind: Kind,
    pub causality: &'static str,
    pub variability: &'static str,
    /// FMI's attribute `initial`; `None` where it may not be given.
    pub initial: Option<&'static str>,
    /// Of Real variables.
    pub unit: Unit,
    pub start: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub role: Role,
}

impl Variable {
    pub fn is_tunable(&self) -> bool {
        self.variability == TUNABLE
    }

    /// May a Real have that value?
    ///
    /// # Errors
    /// Why not.
    pub fn check(&self, value: f64) -> Result<(), String> {
        if !value.is_finite() {
            Err("it must be a finite number".into())
        } else if let Some(min) = self.min.filter(|min| value < *min) {
            Err(format!("the smallest value is {min}"))
        } else if let Some(max) = self.max.filter(|max| value > *max) {
            Err(format!("the largest value is {max}"))
        } else {
            Ok(())
        }
    }

    /// The bound that a value misses by a rounding, as that of a controller; else the value.
    pub fn rounded_in(&self, value: f64) -> f64 {
        const ROUNDING: f64 = 1e-9;
        let missed = |bound: &f64| (value - bound).abs() <= ROUNDING * bound.abs().max(1.0);
        let [below, above] = [self.min.filter(|min| value < *min), self.max.filter(|max| value > *max)];
        below.or(above).filter(missed).unwrap_or(value)
    }

    /// As force element, number and `value` of a constant where it is one.
    pub fn constant_of_force(&self, value: f64) -> Option<(usize, u32, f64)> {
        match self.role {
            Role::RealParameter(RealParameter::Force(place, number)) => Some((place, number, value)),
            _ => None,
        }
    }

    /// Is it a parameter that saved states hold?
    pub fn is_parameter(&self) -> bool {
        matches!(self.role, Role::RealParameter(_) | Role::FromEquilibrium)
    }
}
