//! Prismatic joint: P2 on the axis Z1, axes 2 parallel to axes 1; displacement along Z1 is free.

use super::{Joint, Place, on_axis, parallel, right_angle};
use crate::mbs::kkt::RowBodies;

/// Rows x, y, tilt_x, tilt_y as a cylindrical joint; turn: X1 . Y2 = 0.
pub fn prismatic(name: &str, bodies: RowBodies, first: &Place, second: &Place) -> Joint {
    let turn = ("turn", right_angle(first, 0, second, 1));
    let rows = on_axis(first, second).into_iter().chain(parallel(first, second)).chain([turn]);
    Joint::new(name, bodies, rows.collect())
}
