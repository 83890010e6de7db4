//! Cylindrical joint: P2 on the axis Z1, Z2 along it; rotation about and displacement along it are free.

use super::{Joint, Place, on_axis, parallel};
use crate::mbs::kkt::RowBodies;

/// Rows x, y: displacement of P2 along X1, Y1; tilt_x, tilt_y: no component of Z2 along X1, Y1.
pub fn cylindrical(name: &str, bodies: RowBodies, first: &Place, second: &Place) -> Joint {
    let rows = on_axis(first, second).into_iter().chain(parallel(first, second));
    Joint::new(name, bodies, rows.collect())
}
