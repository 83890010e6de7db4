//! Cells in contact and the pressure that bounds their traction.

use super::influence::{Cell, Pair};

/// Cells in contact, strip by strip along e1, in each strip from the leading edge backward.
#[derive(Clone, Debug)]
pub(crate) struct Pressure {
    /// Cell size along e1, e2.
    pub size: Pair,
    pub cells: Vec<Cell>,
    /// Middles of the cells.
    pub places: Vec<Pair>,
    /// Pressure of each cell, or what bounds its traction.
    pub values: Vec<f64>,
}

impl Pressure {
    /// Does cell `k` have its neighbour ahead in contact? That one is cell `k - 1`.
    pub(crate) fn has_ahead(&self, k: usize) -> bool {
        k > 0 && self.cells[k - 1].row == self.cells[k].row && self.cells[k].column + 1 == self.cells[k - 1].column
    }
}
