//! Numbers with bounds that need not be given.

use super::{Section, SettingsError};
use crate::units::Dimension;

impl Section<'_> {
    /// A number greater than zero, or `default` where there is none.
    pub fn positive_or(&self, key: &'static str, dimension: Dimension, default: f64) -> Result<f64, SettingsError> {
        if self.has(key) { self.positive(key, dimension) } else { Ok(default) }
    }

    /// A number of zero or more, or `default` where there is none.
    pub fn not_negative_or(&self, key: &'static str, dimension: Dimension, default: f64) -> Result<f64, SettingsError> {
        if self.has(key) { self.not_negative(key, dimension) } else { Ok(default) }
    }
}
