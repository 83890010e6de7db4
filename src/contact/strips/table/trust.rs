//! Where a table may be read between its nodes.
//!
//! Cubic convolution is exact where numbers go as a square over the nodes, and its error is 0.016 of their third difference. Where a small load passes from one hump of a worn tread to
//! another within a tenth of a millimetre, they jump: read between such nodes a half axis became negative (-0.4 mm for 1.8, no creep force at all). So each node says by how much of
//! themselves the half axes, and by how much of b its place across, differ from that over the nodes around it,
//!
//! ```text
//! D = 1/4 max over the three directions of ( |v(k+2) - 3 v(k+1) + 3 v(k) - v(k-1)| / b,  v the place across and b;  the same of a over a )
//! ```
//!
//! and the larger of D (also of the neighbours') and of how far the ellipse of the moments goes beyond the patch decides how much the strips are asked: from an error of 2 % of b on.

use super::column::Column;
use super::{Axis, EXCESS, LEVELS};

/// Half axes a and b among a node's fields.
const A: usize = 1;
const B: usize = 2;
/// D in parts of the third difference.
const PART: f64 = 0.25;

/// Puts into each node's excess what it must be read with.
pub(super) fn note(columns: &mut [Column], across: &Axis, lean: &Axis, known: &[usize]) {
    let index = |i: usize, j: usize, level: usize| (i * lean.count + j) * LEVELS + level;
    let bounds = [across.count, lean.count, LEVELS];
    let mut doubts = vec![0.0f32; columns.len() * LEVELS];
    for_each(bounds, |at| doubts[index(at[0], at[1], at[2])] = bending(columns, lean, known, bounds, at));
    // A reading between k and k + 1 takes the nodes from k - 1 to k + 2.
    for axis in 0..bounds.len() {
        let before = doubts.clone();
        for_each(bounds, |at| {
            let beside = at[axis].saturating_sub(1)..=(at[axis] + 1).min(bounds[axis] - 1);
            let of = |k: usize| {
                let mut other = at;
                other[axis] = k;
                before[index(other[0], other[1], other[2])]
            };
            doubts[index(at[0], at[1], at[2])] = beside.map(of).fold(0.0, f32::max);
        });
    }
    for (k, column) in columns.iter_mut().enumerate() {
        for (level, node) in column.nodes.iter_mut().enumerate() {
            node.1[EXCESS] = node.1[EXCESS].max(doubts[k * LEVELS + level]);
        }
    }
}

/// D of the nodes around a node and the next one; where one of them is not known it says nothing.
fn bending(columns: &[Column], lean: &Axis, known: &[usize], bounds: [usize; 3], at: [usize; 3]) -> f32 {
    let node = |[i, j, level]: [usize; 3]| {
        let column = i * lean.count + j;
        let (place, fields) = &columns[column].nodes[level];
        (level < known[column]).then(|| [place[0], f64::from(fields[A]), f64::from(fields[B])])
    };
    let along = |axis: usize| {
        let place = |k: usize| {
            let mut other = at;
            other[axis] = (at[axis] + k).checked_sub(1).filter(|place| *place < bounds[axis])?;
            node(other)
        };
        let [a, b, c, d] = [place(0)?, place(1)?, place(2)?, place(3)?];
        let differs = |k: usize, size: usize| PART * (d[k] - 3.0 * (c[k] - b[k]) - a[k]).abs() / b[size].min(c[size]);
        Some(differs(0, 2).max(differs(1, 1)).max(differs(2, 2)))
    };
    (0..bounds.len()).filter_map(along).fold(0.0, f64::max) as f32
}

fn for_each([across, lean, levels]: [usize; 3], mut visit: impl FnMut([usize; 3])) {
    for i in 0..across {
        for j in 0..lean {
            for level in 0..levels {
                visit([i, j, level]);
            }
        }
    }
}
