//! Spherical joint: `P2 = P1`; three rotations are free.

use super::{Joint, Place, same_point};
use crate::mbs::kkt::RowBodies;

/// Rows x, y, z along the track's axes.
pub fn spherical(name: &str, bodies: RowBodies, first: &Place, second: &Place) -> Joint {
    Joint::new(name, bodies, same_point(first, second))
}
