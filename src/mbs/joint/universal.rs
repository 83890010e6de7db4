//! Universal joint (Hooke, Cardan): `P2 = P1`, Z1 across Z2; rotations about both are free.

use super::{Joint, Place, right_angle, same_point};
use crate::mbs::kkt::RowBodies;

/// The pins of the cross lie along Z of each place. Rows x, y, z along the track's axes; cross: Z1 . Z2 = 0.
pub fn universal(name: &str, bodies: RowBodies, first: &Place, second: &Place) -> Joint {
    let mut rows = same_point(first, second);
    rows.push(("cross", right_angle(first, 2, second, 2)));
    Joint::new(name, bodies, rows)
}
