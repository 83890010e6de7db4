//! Revolute joint: `P2 = P1`, Z1 parallel to Z2; one rotation is free.

use super::{Joint, Place, parallel, same_point};
use crate::mbs::kkt::RowBodies;

/// Rows x, y, z along the track's axes; tilt_x, tilt_y: no component of Z2 along X1, Y1.
pub fn revolute(name: &str, bodies: RowBodies, first: &Place, second: &Place) -> Joint {
    let mut rows = same_point(first, second);
    rows.extend(parallel(first, second));
    Joint::new(name, bodies, rows)
}
