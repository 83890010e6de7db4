//! How a patch is spread across, in five cells of equal load: what [`super::uneven`] needs of the strips of a patch that is read from a table.
//!
//! Each has the means by load of where it lies and, for how far it yields, the sum of `a_i^2 w_i` of its strips (half lengths a_i, widths w_i; half
//! lengths with the mean square of the patch's ellipse). Strips that lie across the border of two fifths belong to both in parts.

use super::parts::{Part, Share};
use super::pressed::Pressed;
use nalgebra::Vector3;

/// Cells of equal load.
pub const FIFTHS: usize = 5;

/// Where those of an ellipse lie, over b, and their shares of the load: means of e over fifths of the density 3/4 (1 - e^2).
pub(super) const OF_ELLIPSE: [(f64, f64); FIFTHS] =
    [(-0.628_475_648, 0.2), (-0.275_591_062, 0.2), (0.0, 0.2), (0.275_591_062, 0.2), (0.628_475_648, 0.2)];

/// What a part of a patch is made of.
#[derive(Clone, Copy, Debug)]
pub enum Cells<'a> {
    Strips(Share<'a>),
    Fifths(&'a Fifths),
}

/// From the inner to the outer side of the rail.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fifths {
    pub each: [Fifth; FIFTHS],
    /// Which way that is.
    pub outward: Vector3<f64>,
}

/// A fifth of the load.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fifth {
    /// From the centre of all load, along the surface and out of the rail, m.
    pub across: f64,
    pub above: f64,
    /// Sum of a_i^2 w_i over a^2 b, -.
    pub size: f64,
}

impl Fifths {
    /// Of a part of a patch.
    pub fn new(share: Share, part: &Part, outward: Vector3<f64>) -> Fifths {
        let forward = part.forward.normalize();
        let across = part.normal.cross(&forward);
        let across = across * across.dot(&outward).signum();
        let (a, b) = (part.patch.a, part.patch.b);
        let per_size = 0.8 / (part.mean_square * b);
        let mut each = [Fifth::default(); FIFTHS];
        let (full, mut done) = (part.load / FIFTHS as f64, 0.0);
        let reach = |own: &Pressed| per_size * own.half_length * own.half_length * own.width;
        for (part_of, own) in share.loads().filter(|(part_of, own)| part_of * own.load > 0.0) {
            let (load, arm) = (part_of * own.load, own.strip.point - own.strip.normal * own.strip.overlap - part.arm);
            let (mut left, mut at) = (load, done / full);
            while left > 0.0 {
                let k = (at as usize).min(FIFTHS - 1);
                let room = if k + 1 < FIFTHS { (k + 1) as f64 * full - at * full } else { f64::INFINITY };
                let taken = left.min(room);
                let cell = &mut each[k];
                cell.across += taken / full * arm.dot(&across);
                cell.above += taken / full * arm.dot(&part.normal);
                cell.size += reach(own) * part_of * taken / load;
                left -= taken;
                at = if taken < left + taken { (k + 1) as f64 } else { at + taken / full };
            }
            done += load;
        }
        debug_assert!(a > 0.0);
        Fifths { each, outward: across }
    }
}
