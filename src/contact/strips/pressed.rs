//! What one strip carries.

use super::strip::Strip;

/// A strip over which the wheel overlaps.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pressed {
    /// Number of the rail's strip.
    pub number: usize,
    pub strip: Strip,
    /// Along the rail's section, m.
    pub width: f64,
    /// Q, N.
    pub load: f64,
    /// a, m.
    pub half_length: f64,
}
