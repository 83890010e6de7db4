//! How a patch is spread across, in five cells of equal load: what [`super::uneven`] needs of the strips of a patch that is read from a table.
//!
//! Each has the means by load of where it lies and, for how far it yields, the sum of `a_i^2 w_i` of its strips (half lengths a_i, widths w_i; half
//! lengths with the mean square of the patch's ellipse). Strips that lie across the border of two fifths belong to both in parts.

use super::parts::{Part, Share};
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
        // Half lengths whose mean square is the ellipse's, 4/5 a^2.
        let per_size = 0.8 / (part.mean_square * part.patch.b);
        let mut each = [Fifth::default(); FIFTHS];
        let mut begin = 0.0;
        for (part_of, own) in share.loads().filter(|(part_of, own)| part_of * own.load > 0.0) {
            // In fifths of all load.
            let load = FIFTHS as f64 * part_of * own.load / part.load;
            let end = begin + load;
            let arm = own.strip.point - own.strip.normal * own.strip.overlap - part.arm;
            let size = part_of * per_size * own.half_length * own.half_length * own.width / load;
            for (k, cell) in each.iter_mut().enumerate() {
                let within = end.min((k + 1) as f64) - begin.max(k as f64);
                if within > 0.0 {
                    cell.across += within * arm.dot(&across);
                    cell.above += within * arm.dot(&part.normal);
                    cell.size += within * size;
                }
            }
            begin = end;
        }
        Fifths { each, outward: across }
    }
}
