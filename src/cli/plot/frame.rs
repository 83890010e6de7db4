//! Where a panel's diagram stands, and its scales.

use super::pen::Place;
use super::scale::Scale;

/// Pixels: title, labels at the left and below, and what is free at the right.
pub(super) const STRIP: f64 = 34.0;
pub(super) const LEFT: f64 = 92.0;
pub(super) const BOTTOM: f64 = 58.0;
const RIGHT: f64 = 24.0;

/// Width and height of the diagram in a panel of a size, pixels.
pub(in crate::cli) fn inside(size: Place) -> Place {
    (size.0 - LEFT - RIGHT, size.1 - STRIP - BOTTOM)
}

/// Where a diagram stands on the sheet, and its scales.
pub(super) struct Frame {
    pub corner: Place,
    pub size: Place,
    pub x: Scale,
    pub y: Scale,
}

impl Frame {
    /// Of a panel with a corner and a size.
    pub(super) fn new(corner: Place, size: Place, (x, y): (Scale, Scale)) -> Frame {
        Frame { corner: (corner.0 + LEFT, corner.1 + STRIP), size: inside(size), x, y }
    }

    pub(super) fn at(&self, (x, y): (f64, f64)) -> Place {
        (self.corner.0 + self.size.0 * self.x.part(x), self.corner.1 + self.size.1 * (1.0 - self.y.part(y)))
    }

    /// Does the frame show a point? (Its own ends by rounding, too.)
    pub(super) fn shows(&self, (x, y): (f64, f64)) -> bool {
        const ENDS: std::ops::RangeInclusive<f64> = -1e-9..=1.0 + 1e-9;
        ENDS.contains(&self.x.part(x)) && ENDS.contains(&self.y.part(y))
    }

    pub(super) fn end(&self) -> Place {
        (self.corner.0 + self.size.0, self.corner.1 + self.size.1)
    }
}
