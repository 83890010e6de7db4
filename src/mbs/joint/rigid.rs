//! Rigid joint: P2 = P1 and parallel axes; nothing is free.

use super::{Joint, Place, parallel, right_angle, same_point};
use crate::mbs::kkt::RowBodies;

/// Rows x, y, z along the track's axes; tilt_x, tilt_y, turn: no component of Z2 along X1, Y1, of Y2 along X1.
pub fn rigid(name: &str, bodies: RowBodies, first: &Place, second: &Place) -> Joint {
    let mut rows = same_point(first, second);
    rows.extend(parallel(first, second));
    rows.push(("turn", right_angle(first, 0, second, 1)));
    Joint::new(name, bodies, rows)
}
