//! Floor 1: profiles, track and the surfaces that they make.
//!
//! Frames (SI units, rad): X forward along the track, Y left, Z up. A side's *outward* direction points away
//! from the track centre, so left and right wheels and rails mirror each other.

pub mod file;
pub mod out_of_round;
pub mod profile;
pub mod surface;
pub mod track;

use serde::{Deserialize, Serialize};

/// Left (+Y) or right (-Y).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    Left,
    Right,
}

impl Side {
    pub const BOTH: [Side; 2] = [Side::Left, Side::Right];

    /// +1 on the left, -1 on the right: the Y component of the outward direction.
    pub fn sign(self) -> f64 {
        match self {
            Side::Left => 1.0,
            Side::Right => -1.0,
        }
    }

    /// The other side.
    pub fn other(self) -> Side {
        match self {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        }
    }

    /// Place in arrays that hold left and right.
    pub fn index(self) -> usize {
        usize::from(self == Side::Right)
    }

    pub fn name(self) -> &'static str {
        match self {
            Side::Left => "left",
            Side::Right => "right",
        }
    }
}
