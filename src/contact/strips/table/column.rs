//! The nodes over one place across and one lean.

use super::{LEVELS, NUMBERS, PLACE};

/// A patch: its place, and its other numbers.
pub(super) type Node = ([f64; PLACE], [f32; NUMBERS]);

/// By load: heights, not a number where nothing is known, and patches.
#[derive(Clone)]
pub(super) struct Column {
    pub heights: [f64; LEVELS],
    pub nodes: [Node; LEVELS],
}
