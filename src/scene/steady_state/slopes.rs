//! The linear equations of a Newton step, sparse where they determine the step and dense where they do not.
//!
//! Accelerations off the pattern lie along the motions that constraints allow, moves onto the constraints across them
//! (`M^-1 J^T lambda`): their sum, coordinate by coordinate, vanishes only where both do, and is a square system. It is factored sparse
//! (LU). Its smallest singular value is estimated by inverse iteration; where it is next to zero the whole, taller system is solved
//! for the shortest least-squares step (singular value decomposition), which leaves what nothing determines where it is.

use faer::Mat;
use faer::linalg::solvers::{Solve, Svd};
use faer::sparse::linalg::solvers::Lu;
use faer::sparse::{SparseColMat, Triplet};

/// An element: row, column and value.
pub(super) type Entry = (usize, usize, f64);

/// Jacobian of the equations: `square` says which of the first rows (one per coordinate) belong to the square system.
pub(super) struct Slopes<'a> {
    pub entries: &'a [Entry],
    pub rows: usize,
    pub columns: usize,
    pub square: &'a [Option<usize>],
}

/// A factorisation.
pub(super) enum Factors {
    Square(Lu<usize, f64>),
    Whole(Svd<f64>),
}

/// Smallest singular value (accelerations in g per m or rad) with which differences still determine a step.
const DETERMINED: f64 = 1e-3;
/// Singular values below this part of the largest are noise.
const NOISE: f64 = 1e-12;
/// Each round of inverse iteration multiplies the share of the smallest singular value's direction by its distance from the others.
const ROUNDS: usize = 4;

impl Slopes<'_> {
    /// `None` where the system does not determine a step, or not reliably.
    pub fn square(&self) -> Option<Factors> {
        let lu = self.lu(0.0)?;
        (smallest(&lu, self.columns) > DETERMINED).then_some(Factors::Square(lu))
    }

    /// The square system less a multiple of the identity: its step is one of implicit Euler's method, of length 1 / shift, on
    /// `x' = accelerations`.
    pub fn damped(&self, shift: f64) -> Option<Factors> {
        self.lu(shift).map(Factors::Square)
    }

    fn lu(&self, shift: f64) -> Option<Lu<usize, f64>> {
        let coordinates = self.square.len();
        let entry = |&(row, column, value): &Entry| Some(Triplet::new(self.square[row % coordinates]?, column, value));
        let size = self.columns;
        let diagonal = (0..size).map(|i| Triplet::new(i, i, -shift));
        let entries: Vec<Triplet<usize, usize, f64>> = self.entries.iter().filter_map(entry).chain(diagonal).collect();
        SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &entries).ok()?.sp_lu().ok()
    }

    /// The singular value decomposition of the whole.
    pub fn whole(&self) -> Option<Svd<f64>> {
        let mut dense = Mat::<f64>::zeros(self.rows, self.columns);
        for &(row, column, value) in self.entries {
            dense[(row, column)] += value;
        }
        dense.thin_svd().ok()
    }
}

/// Estimate (from above) of the smallest singular value; not a number where there is no factorisation.
fn smallest(lu: &Lu<usize, f64>, size: usize) -> f64 {
    let mut x = Mat::from_fn(size, 1, |i, _| if i % 3 == 1 { -1.0 } else { 1.0 + 0.1 * (i % 7) as f64 });
    let mut growth = f64::NAN;
    for round in 0..2 * ROUNDS {
        let norm = x.norm_l2();
        x.col_iter_mut().for_each(|column| column.iter_mut().for_each(|value| *value /= norm));
        if round % 2 == 0 {
            lu.solve_in_place(&mut x);
        } else {
            lu.solve_transpose_in_place(&mut x);
        }
        growth = x.norm_l2();
    }
    1.0 / growth
}

impl Factors {
    /// The step x that makes `J x + rest` vanish, or least.
    pub fn step(&self, square: &[Option<usize>], rest: &[f64]) -> Vec<f64> {
        match self {
            Factors::Square(lu) => {
                let mut x = Mat::<f64>::zeros(square.iter().flatten().count(), 1);
                for (row, value) in rest.iter().enumerate() {
                    if let Some(place) = square[row % square.len()] {
                        x[(place, 0)] -= value;
                    }
                }
                lu.solve_in_place(&mut x);
                (0..x.nrows()).map(|i| x[(i, 0)]).collect()
            }
            Factors::Whole(svd) => shortest(svd, rest),
        }
    }
}

/// The shortest x that makes `|J x + rest|` least.
fn shortest(jacobian: &Svd<f64>, rest: &[f64]) -> Vec<f64> {
    let (left, values, right) = (jacobian.U(), jacobian.S().column_vector(), jacobian.V());
    let mut solution = vec![0.0; right.nrows()];
    for k in (0..right.ncols()).take_while(|k| values[*k] > NOISE * values[0]) {
        let part: f64 = rest.iter().enumerate().map(|(row, rest)| left[(row, k)] * rest).sum::<f64>() / values[k];
        for (row, x) in solution.iter_mut().enumerate() {
            *x -= part * right[(row, k)];
        }
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both ways solve a full system alike; a system that leaves a direction open is not taken as square.
    #[test]
    fn equiv_sparse_and_dense_steps() {
        let entry = |i: usize, j: usize| if i == j { 4.0 + i as f64 } else { 1.0 / (1.0 + i as f64 + 2.0 * j as f64) };
        let size = 9;
        let mut entries: Vec<Entry> = (0..size).flat_map(|i| (0..size).map(move |j| (i, j, entry(i, j)))).collect();
        let square: Vec<Option<usize>> = (0..size).map(Some).collect();
        let rest: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
        let slopes = Slopes { entries: &entries, rows: size, columns: size, square: &square };
        let sparse = slopes.square().unwrap().step(&square, &rest);
        let dense = Factors::Whole(slopes.whole().unwrap()).step(&square, &rest);
        let difference = sparse.iter().zip(&dense).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-14, "{difference:e}");
        // The last column again in place of the first.
        for i in 0..size {
            entries[i * size].2 = entry(i, size - 1);
        }
        assert!(Slopes { entries: &entries, rows: size, columns: size, square: &square }.square().is_none());
    }
}
