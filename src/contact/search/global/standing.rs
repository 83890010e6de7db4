//! How a wheel stands against its rail, and by how much it has moved there between two poses.
//!
//! What a search certifies holds until a point of the wheel's trace C(u) ([`super::view`]) has moved by some length or the trace has turned
//! by that length over half a metre. With the tread's point `T = C0 + B R0`, k = a . t and h the roll of the axle in the section
//!
//! ```text
//! C(u) = T + A (u - k^2 R R') + B (R cos c - R0),   cos^2 c = 1 - k^2 R'^2
//! |dC| <= |dT| + |(u, R - R0)| |dh| + R (2 |R'| + R'^2) |k dk|
//! |d phi| <= |dh| + |R'| |k dk|
//! ```
//!
//! to first order in k^2, taken for slopes R' up to 4 (76 degrees), |u| < 80 mm and |R - R0| < 40 mm. The section is
//! that beside the wheelset's centre; the contact's lies up to [`LEAD`] ahead of it, so much a change of the rail's
//! direction counts.

use super::GlobalSearch;
use super::branch::ARM;
use crate::contact::search::algebraic::Pair;

/// Greatest slope R' of a flank that touches.
const STEEPEST_TOUCHING: f64 = 4.0;
/// Furthest from the tread's point to one that touches, m.
const REACH: f64 = 0.09;
/// Certificates and this measure are of first order, for instance in how the gap changes a foot's curvature.
const SAFETY: f64 = 2.0;
/// Furthest lead of a contact, m.
const LEAD: f64 = 0.05;

/// Place of the tread's point in the section, outward and up [m], roll of the axle and k [rad], direction of the rail in the
/// section's axes [-].
pub type WheelPose = [f64; 6];

impl GlobalSearch {
    /// How the wheel stands.
    #[inline]
    pub fn standing(&self, pair: &Pair) -> WheelPose {
        let section = pair.rail.section(pair.distance);
        let (outward, up, t) = (section.outward, section.up, section.d1);
        let axle = pair.axes.column(1) * pair.wheel.side.sign();
        let tread = pair.centre + axle * pair.wheel.half_spacing - pair.axes.column(2) * self.radius;
        let (offset, normal) = (tread - section.origin, outward.cross(&up));
        let lean = 1.0 / normal.dot(&t);
        let (slope_out, slope_up) = (t.dot(&outward) * lean, t.dot(&up) * lean);
        let ahead = normal.dot(&offset);
        let along = normal.dot(&axle);
        [
            offset.dot(&outward) - slope_out * ahead,
            offset.dot(&up) - slope_up * ahead,
            axle.dot(&up) - slope_up * along,
            along + slope_out * axle.dot(&outward) + slope_up * axle.dot(&up),
            slope_out,
            slope_up,
        ]
    }

    /// The motion between two poses that a certificate allows or not, m.
    #[inline]
    pub fn motion(&self, from: &WheelPose, to: &WheelPose) -> f64 {
        let change = |i: usize| (to[i] - from[i]).abs();
        let yawing = change(3) * from[3].abs().max(to[3].abs());
        let direction = change(4) + change(5);
        let shift = change(0)
            + change(1)
            + REACH * change(2)
            + self.radius * (2.0 + STEEPEST_TOUCHING) * STEEPEST_TOUCHING * yawing
            + LEAD * direction;
        let turn = change(2) + STEEPEST_TOUCHING * yawing;
        SAFETY * shift.max(ARM * turn)
    }
}
