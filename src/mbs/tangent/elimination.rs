//! LU factorisation of a matrix of 6 x 6 blocks with a fixed symmetric pattern.
//!
//! ```text
//! for each node k in order:  D_k^-1,  L_ik = A_ik D_k^-1,  A_ij -= L_ik A_kj   for all neighbours i, j still to come
//! ```
//!
//! Pivots are whole blocks, inverted with row pivoting inside them. That is stable here: blocks of bodies are near the identity or
//! dominated by damping and stiffness, and constraint rows come after all of their bodies. (faer's sparse LU pivots everywhere, but
//! allocates in each factorisation and does not know the blocks.) Nodes of fewer than six unknowns are filled up with ones.

use super::pattern::{Elimination, Graph};
use nalgebra::{Matrix6, Vector6};
use std::collections::BTreeMap;

#[derive(Clone, Debug)]
struct Step {
    node: u32,
    diagonal: u32,
    /// End of its neighbours.
    end: u32,
}

#[derive(Clone, Debug)]
struct Neighbour {
    node: u32,
    /// Blocks (neighbour, node) and (node, neighbour).
    lower: u32,
    upper: u32,
}

/// Blocks, their places and their factors.
#[derive(Clone, Debug)]
pub(super) struct BlockLu {
    steps: Vec<Step>,
    neighbours: Vec<Neighbour>,
    /// Block (i, j) for the neighbours i, j of each step, one after the other.
    targets: Vec<u32>,
    places: BTreeMap<(usize, usize), usize>,
    blocks: Vec<Matrix6<f64>>,
    /// Those that must be cleared.
    filling: Vec<usize>,
}

impl BlockLu {
    pub fn new(graph: &Graph) -> BlockLu {
        let order = graph.order();
        let mut places = BTreeMap::new();
        let mut place = |row: usize, column: usize| {
            let next = places.len();
            *places.entry((row, column)).or_insert(next) as u32
        };
        let mut lu =
            BlockLu { steps: vec![], neighbours: vec![], targets: vec![], places: BTreeMap::new(), blocks: vec![], filling: vec![] };
        for Elimination { node, neighbours } in &order {
            let diagonal = place(*node, *node);
            for other in neighbours {
                let (lower, upper) = (place(*other, *node), place(*node, *other));
                lu.neighbours.push(Neighbour { node: *other as u32, lower, upper });
            }
            lu.steps.push(Step { node: *node as u32, diagonal, end: lu.neighbours.len() as u32 });
        }
        for Elimination { neighbours, .. } in &order {
            for i in neighbours {
                lu.targets.extend(neighbours.iter().map(|j| place(*i, *j)));
            }
        }
        lu.blocks = vec![Matrix6::zeros(); places.len()];
        lu.filling = (0..places.len()).collect();
        lu.places = places;
        lu
    }

    /// Where the block (row node, column node) is kept; it must be an edge of the graph. Not for the stepping path.
    pub fn place(&self, row: usize, column: usize) -> usize {
        self.places.get(&(row, column)).copied().unwrap_or_default()
    }

    /// Blocks kept, and products of blocks in a factorisation.
    pub fn cost(&self) -> (usize, usize) {
        (self.blocks.len(), self.neighbours.len() + self.targets.len())
    }

    /// Sets to zero what fills up while others are eliminated and nobody overwrites.
    pub fn clear(&mut self) {
        for place in &self.filling {
            self.blocks[*place] = Matrix6::zeros();
        }
    }

    /// The blocks at these places are overwritten before each factorisation.
    pub fn overwritten(&mut self, places: &[usize]) {
        self.filling.retain(|place| !places.contains(place));
    }

    pub fn block_mut(&mut self, place: usize) -> &mut Matrix6<f64> {
        &mut self.blocks[place]
    }

    /// Overwrites the blocks with their factors; the error is the node whose pivot is singular.
    pub fn factorise(&mut self) -> Result<(), usize> {
        let (mut start, mut target) = (0, 0);
        for step in &self.steps {
            let inverse = invert(&self.blocks[step.diagonal as usize]).ok_or(step.node as usize)?;
            self.blocks[step.diagonal as usize] = inverse;
            let neighbours = &self.neighbours[start..step.end as usize];
            for row in neighbours {
                let mut lower = Matrix6::zeros();
                add_product(&mut lower, &self.blocks[row.lower as usize], &inverse, 1.0);
                self.blocks[row.lower as usize] = lower;
                for column in neighbours {
                    let places = [self.targets[target] as usize, column.upper as usize];
                    // They are different blocks: the target is not of this step.
                    if let Ok([own, upper]) = self.blocks.get_disjoint_mut(places) {
                        add_product(own, &lower, upper, -1.0);
                    }
                    target += 1;
                }
            }
            start = step.end as usize;
        }
        Ok(())
    }

    /// Solves in place, six numbers per node.
    pub fn solve(&self, x: &mut [Vector6<f64>]) {
        let mut start = 0;
        for step in &self.steps {
            let own = x[step.node as usize];
            for neighbour in &self.neighbours[start..step.end as usize] {
                subtract_product(&mut x[neighbour.node as usize], &self.blocks[neighbour.lower as usize], &own);
            }
            start = step.end as usize;
        }
        for (index, step) in self.steps.iter().enumerate().rev() {
            let start = index.checked_sub(1).map_or(0, |before| self.steps[before].end);
            let mut rest = x[step.node as usize];
            for neighbour in &self.neighbours[start as usize..step.end as usize] {
                subtract_product(&mut rest, &self.blocks[neighbour.upper as usize], &x[neighbour.node as usize]);
            }
            let mut own = Vector6::zeros();
            subtract_product(&mut own, &self.blocks[step.diagonal as usize], &rest);
            x[step.node as usize] = -own;
        }
    }
}

/// `target += factor left right`.
#[inline]
pub(super) fn add_product(target: &mut Matrix6<f64>, left: &Matrix6<f64>, right: &Matrix6<f64>, factor: f64) {
    for (target, right) in target.data.0.iter_mut().zip(&right.data.0) {
        for (left, right) in left.data.0.iter().zip(right) {
            let scaled = factor * right;
            for (target, left) in target.iter_mut().zip(left) {
                *target += left * scaled;
            }
        }
    }
}

/// `target -= left x`.
#[inline]
pub(super) fn subtract_product(target: &mut Vector6<f64>, left: &Matrix6<f64>, x: &Vector6<f64>) {
    let target = &mut target.data.0[0];
    for (left, x) in left.data.0.iter().zip(&x.data.0[0]) {
        for (target, left) in target.iter_mut().zip(left) {
            *target -= left * x;
        }
    }
}

/// Inverse by Gauss-Jordan elimination in place, always with the largest pivot of the column; `None` when one is zero or not a number.
///
/// The columns of the storage are treated as rows: that inverts the transpose, which the storage then holds as the inverse.
fn invert(matrix: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    let mut rows = matrix.data.0;
    let mut pivots = [0; 6];
    for k in 0..6 {
        let mut pivot = k;
        for i in k + 1..6 {
            if rows[i][k].abs() > rows[pivot][k].abs() {
                pivot = i;
            }
        }
        pivots[k] = pivot;
        rows.swap(k, pivot);
        if !(rows[k][k].abs() > 0.0) {
            return None;
        }
        let factor = 1.0 / rows[k][k];
        rows[k][k] = 1.0;
        let own = rows[k].map(|value| value * factor);
        for (i, row) in rows.iter_mut().enumerate() {
            if i == k {
                *row = own;
                continue;
            }
            let factor = row[k];
            row[k] = 0.0;
            for (value, own) in row.iter_mut().zip(&own) {
                *value -= factor * own;
            }
        }
    }
    // Exchanged rows are exchanged columns of the inverse, last first.
    for k in (0..6).rev().filter(|k| pivots[*k] != *k) {
        for row in &mut rows {
            row.swap(k, pivots[k]);
        }
    }
    let finite = rows.iter().fold(0.0, |sum: f64, row| sum + row.iter().map(|value| value * 0.0).sum::<f64>());
    (finite == 0.0).then(|| Matrix6::from_array_storage(nalgebra::ArrayStorage(rows)))
}
