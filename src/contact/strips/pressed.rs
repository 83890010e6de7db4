//! What one strip carries.

use super::strip::Strip;

/// A strip over which the wheel overlaps.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pressed {
    /// Number of the rail's strip.
    pub number: usize,
    pub strip: Strip,
    /// Along the rail's section, m: of what is in contact, and its middle from that of the rail's strip.
    pub width: f64,
    pub offset: f64,
    /// Overlap of its middle or the mean of what is in contact, whichever is more, m; above 0 where it carries.
    pub depth: f64,
    /// Q, N.
    pub load: f64,
    /// a, m.
    pub half_length: f64,
}
