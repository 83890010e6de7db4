//! Sparse Cholesky factorisation of S (faer): fill-reducing order and symbolic part once, numbers every time.
//!
//! The elements of S are formed in the factor's order at once, so no permutation of the matrix is left to do.

use super::RowBodies;
use super::pattern::Pattern;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// Symbolic and numeric factor.
pub(super) struct Sparse {
    symbolic: Arc<SymbolicCholesky<u32>>,
    /// Row at each place of the order, and the columns of S's upper triangle in that order.
    order: Vec<u32>,
    columns: Vec<u32>,
    row_indices: Vec<u32>,
    factor: Vec<f64>,
    /// Right-hand side and solution in the factor's order.
    x: Vec<f64>,
    memory: MemBuffer,
}

impl Sparse {
    /// `None`: the symbolic part failed (out of memory, or more elements than a 32-bit index counts).
    pub fn new(bodies: usize, rows: &[RowBodies]) -> Option<(Pattern, Sparse)> {
        let natural: Vec<u32> = (0..u32::try_from(rows.len()).ok()?).collect();
        let (columns, row_indices) = structure(&Pattern::sparse(bodies, rows, &natural, &natural), &natural);
        let (order, position) = fill_reducing_order(rows.len(), &columns, &row_indices)?;
        let pattern = Pattern::sparse(bodies, rows, &position, &order);
        let (columns, row_indices) = structure(&pattern, &position);
        let matrix = SymbolicSparseColMatRef::new_checked(rows.len(), rows.len(), &columns, None, &row_indices);
        // Joints make blocks of a few rows: too small for block algorithms.
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic = factorize_symbolic_cholesky(matrix, Side::Upper, SymmetricOrdering::Identity, params).ok()?;
        let memory = MemBuffer::try_new(scratch(&symbolic)).ok()?;
        let factor = vec![0.0; symbolic.len_val()];
        let x = vec![0.0; rows.len()];
        Some((pattern, Sparse { symbolic: Arc::new(symbolic), order, columns, row_indices, factor, x, memory }))
    }

    /// Numbers in the factor.
    pub fn fill(&self) -> usize {
        self.factor.len()
    }

    /// Factors the matrix given in the pattern's order; the error is the row whose pivot is too small.
    pub fn factorise(&mut self, matrix: &[f64], smallest: f64) -> Result<(), usize> {
        let n = self.x.len();
        let structure = SymbolicSparseColMatRef::new_checked(n, n, &self.columns, None, &self.row_indices);
        let stack = MemStack::new(&mut self.memory);
        let done = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            SparseColMatRef::new(structure, matrix),
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            stack,
            Default::default(),
        );
        if let Err(faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index }) = done {
            // faer counts from one.
            return Err(self.order[index - 1] as usize);
        }
        let SymbolicCholeskyRaw::Simplicial(symbolic) = self.symbolic.raw() else { return Ok(()) };
        for (place, start) in symbolic.col_ptr()[..n].iter().enumerate() {
            // The diagonal stands first in the factor's columns and last in those of the upper triangle.
            let root = self.factor[*start as usize];
            let diagonal = matrix[self.columns[place + 1] as usize - 1];
            if !(root * root > smallest * diagonal) {
                return Err(self.order[place] as usize);
            }
        }
        Ok(())
    }

    /// Solves with the factor, in place.
    pub fn solve(&mut self, x: &mut [f64]) {
        for (own, row) in self.x.iter_mut().zip(&self.order) {
            *own = x[*row as usize];
        }
        let n = self.x.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut self.x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        for (own, row) in self.x.iter().zip(&self.order) {
            x[*row as usize] = *own;
        }
    }
}

/// Memory for the larger of the numeric factorisation and the solution.
fn scratch(symbolic: &SymbolicCholesky<u32>) -> StackReq {
    symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()).or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq))
}

/// Column starts and row indices of the pattern's upper triangle.
fn structure(pattern: &Pattern, position: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut columns = vec![0; position.len() + 1];
    let mut row_indices = Vec::with_capacity(pattern.entries.len());
    for entry in &pattern.entries {
        let [column, row] = entry.rows.map(|row| position[row as usize]);
        columns[column as usize + 1] += 1;
        row_indices.push(row);
    }
    for column in 0..position.len() {
        columns[column + 1] += columns[column];
    }
    (columns, row_indices)
}

/// Approximate minimum degree: the row at each place, and the place of each row.
fn fill_reducing_order(n: usize, columns: &[u32], row_indices: &[u32]) -> Option<(Vec<u32>, Vec<u32>)> {
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, columns, None, row_indices);
    let (mut order, mut position) = (vec![0; n], vec![0; n]);
    let mut memory = MemBuffer::try_new(amd::order_maybe_unsorted_scratch::<u32>(n, row_indices.len())).ok()?;
    amd::order_maybe_unsorted(&mut order, &mut position, matrix, amd::Control::default(), MemStack::new(&mut memory)).ok()?;
    Some((order, position))
}

impl Clone for Sparse {
    fn clone(&self) -> Self {
        Sparse {
            symbolic: Arc::clone(&self.symbolic),
            order: self.order.clone(),
            columns: self.columns.clone(),
            row_indices: self.row_indices.clone(),
            factor: self.factor.clone(),
            x: self.x.clone(),
            memory: MemBuffer::new(scratch(&self.symbolic)),
        }
    }
}

impl std::fmt::Debug for Sparse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Sparse").field("rows", &self.x.len()).field("fill", &self.factor.len()).finish()
    }
}
