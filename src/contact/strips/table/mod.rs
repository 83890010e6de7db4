//! A table of patches: what the strips ([`super`]) make of a tread on its rail, made once for a pair of profiles and read at the price of a formula.
//!
//! Seen along the rail a wheel is a plane curve (its outline), and on a straight rail its patch depends on how that curve stands against the rail's section
//! ([`standing`]): how far out (v), how it leans (phi), how high (h); of yaw little is left ([`look`]). The table holds, on a grid of v and phi and for
//! [`LEVELS`] loads, the height under which the wheel carries the load, and the patch there: its centre and direction, its ellipse, and how it is spread
//! across ([`super::fifths`]). At given loads all of that is smooth where places of contact jump, because the patch reaches over the jump; read is the load
//! from the height, then the rest at that load. Elastic constants drop out: loads are counted in `E* = G / (1 - nu)`, of which the strips' geometry is free.
//!
//! *Between the nodes*: cubic convolution over four nodes each way (R. G. Keys 1981): continuous slopes, third order. Errors against the strips: tests, and
//! docs/real_profiles.md.
//!
//! *What lies outside is computed*: by the strips themselves. Inside is a tread alone, with loads from [`FEWEST`] to [`MOST_LOAD`] newtons on steel; nothing
//! that is steeper than [`STEEPEST`] (flanges) carries, and the patch is one: where it divides, the ellipse of all its moments would reach over the gap (two
//! lobes on a worn tread: an area of five times theirs, creep forces off by 0.1 mu N). Towards the border the table's weight falls smoothly to nothing, so that nothing jumps there.

mod column;
mod linear;
mod look;
mod make;
mod standing;
#[cfg(test)]
mod tests;
mod trust;

use super::fifths::FIFTHS;
use crate::contact::Material;
pub use linear::{Expanded, LinearPatch, Range};
pub use look::Looked;
pub use make::ToTabulate;
pub use standing::Standing;

/// Loads per place.
pub const LEVELS: usize = 10;
/// Smallest and largest load in the table, N, on steel.
pub const FEWEST: f64 = 500.0;
pub const MOST_LOAD: f64 = 2e5;
/// Of which loads are those.
const STEEL: Material = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };
/// Steepest slope of the rail's section that may carry, -.
pub const STEEPEST: f64 = 0.35;
/// Places of the rail that are steeper than this are a flange's, -.
pub const FLANK: f64 = 0.3;
/// Distance of nodes, m and rad.
const STEP: f64 = 1e-4;
const TURN: f64 = 2.5e-4;
/// Reach of the table to both sides of where the pair stands in the middle of the track, m and rad.
const REACH: f64 = 9e-3;
const LEAN: f64 = 6e-3;

/// Numbers of a patch that are interpolated: its centre on the wheel across and high in the rail's section, m, and the angle of its force there, rad ...
const PLACE: usize = 3;
/// ... and what needs fewer digits: what the force lacks of the load, half axes, overlap, bends of wheel and rail, how little it
/// may be read between nodes ([`trust`]), and the fifths.
const OWN: usize = 7;
const EXCESS: usize = OWN - 1;
const NUMBERS: usize = OWN + 3 * FIFTHS;

/// Equal distances.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
struct Axis {
    first: f64,
    step: f64,
    count: usize,
}

impl Axis {
    /// Around a place; nodes are whole multiples of the step.
    fn around(middle: f64, reach: f64, step: f64) -> Axis {
        let (first, last) = (((middle - reach) / step).floor(), ((middle + reach) / step).ceil());
        Axis { first: first * step, step, count: (last - first) as usize + 1 }
    }

    fn at(&self, k: usize) -> f64 {
        self.first + k as f64 * self.step
    }
}

/// Patches of a pair of profiles.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PatchTable {
    across: Axis,
    lean: Axis,
    /// Heights h by place (lean by lean within each place across) and load, m; not a number where the table knows nothing.
    heights: Vec<[f64; LEVELS]>,
    /// Patches by place and load.
    places: Vec<[f64; PLACE]>,
    fields: Vec<[f32; NUMBERS]>,
    /// The level of load up to which all is known around a place; 0 where nothing is.
    tops: Vec<f32>,
    /// The patch under a middling load: where across the rail's section, m, angle, rad, bend of the wheel, 1/m.
    middles: [Vec<f32>; 3],
    /// Of the tread circle, m.
    radius: f64,
}

impl PatchTable {
    /// Has it all that its axes say? (It may come from a file.)
    pub fn is_whole(&self) -> bool {
        let Axis { count, .. } = self.across;
        let places = count.checked_mul(self.lean.count);
        let (Some(places), true) = (places, count > 3 && self.lean.count > 3) else { return false };
        let steps = [self.across.first, self.across.step, self.lean.first, self.lean.step, self.radius];
        let lengths = [self.heights.len(), self.tops.len(), self.middles[0].len(), self.middles[1].len(), self.middles[2].len()];
        steps.iter().all(|step| step.is_finite())
            && lengths.iter().all(|length| *length == places)
            && [self.places.len(), self.fields.len()].iter().all(|length| Some(*length) == places.checked_mul(LEVELS))
    }
}

/// The load of a level, N on steel: their cube roots are equally far from each other.
fn load_of(level: f64) -> f64 {
    let (first, last) = (FEWEST.cbrt(), MOST_LOAD.cbrt());
    (first + (last - first) * level / (LEVELS - 1) as f64).powi(3)
}
