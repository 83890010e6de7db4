//! How a patch is spread across, in five cells of equal load: what [`super::uneven`] needs of the strips of a patch that is read from a table.
//!
//! Each has the means by load of where it lies and, for how far it yields, the sum of `a_i^2 w_i` of its strips (half lengths a_i, widths w_i; half
//! lengths with the mean square of the patch's ellipse). Strips that lie across the border of two fifths belong to both in parts.

use super::parts::{Part, Share};
use nalgebra::Vector3;

/// Cells of equal load.
pub const FIFTHS: usize = 5;

/// Where those of an ellipse lie, over b, their shares of the load, and their half lengths over a: means of e over fifths of the density 3/4 (1 - e^2), and [`half_lengths`].
pub(super) const OF_ELLIPSE: [[f64; 3]; FIFTHS] = [
    [-0.628_475_648, 0.2, 0.681_431],
    [-0.275_591_062, 0.2, 0.956_324],
    [0.0, 0.2, 0.996_997],
    [0.275_591_062, 0.2, 0.956_324],
    [0.628_475_648, 0.2, 0.681_431],
];
/// Widths of an ellipse's fifths at the edge, beside it and in the middle over the distance of their neighbours, or from the only one.
const WIDTHS: [f64; 3] = [1.627_392, 0.463_949, 0.486_728];
/// Least width of a fifth over b, and its largest half length over a.
const NARROWEST: f64 = 0.02;
const LONGEST: f64 = 1.5;

/// Half lengths over a of fifths from where they lie over b and their sizes: `a_k^2 = size / width`, with widths by the distances of neighbours as in an ellipse.
pub(super) fn half_lengths(across: &[f64; FIFTHS], sizes: &[f64; FIFTHS]) -> [f64; FIFTHS] {
    std::array::from_fn(|k| {
        let (before, after) = (across[k.saturating_sub(1)], across[(k + 1).min(FIFTHS - 1)]);
        let width = WIDTHS[k.min(FIFTHS - 1 - k)] * (after - before).abs();
        (sizes[k].max(0.0) / width.max(NARROWEST)).sqrt().min(LONGEST)
    })
}

/// How the surface rises across at each fifth, beside the patch's own plane, -: by its neighbours, at the edges as on a parabola.
pub(super) fn slopes(fifths: &Fifths) -> [f64; FIFTHS] {
    let each = &fifths.each;
    let between: [f64; FIFTHS - 1] = std::array::from_fn(|k| {
        let apart = each[k + 1].across - each[k].across;
        if apart > 0.0 { (each[k + 1].above - each[k].above) / apart } else { 0.0 }
    });
    let last = FIFTHS - 2;
    std::array::from_fn(|k| match k {
        0 => 1.5 * between[0] - 0.5 * between[1],
        k if k > last => 1.5 * between[last] - 0.5 * between[last - 1],
        k => 0.5 * (between[k - 1] + between[k]),
    })
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_half_lengths_of_an_ellipse() {
        let found = half_lengths(&OF_ELLIPSE.map(|place| place[0]), &[4.0 / 15.0; FIFTHS]);
        for (found, place) in found.iter().zip(OF_ELLIPSE) {
            assert!((found - place[2]).abs() < 1e-5, "{found} {place:?}");
        }
    }
}
