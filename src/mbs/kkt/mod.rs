//! Equations of motion with constraints, for bodies of six coordinates each.
//!
//! ```text
//! M q'' + J^T lambda = Q,   J q'' = gamma
//! q'' = free - M^-1 J^T lambda,   S lambda = J free - gamma,   S = J M^-1 J^T,   free = M^-1 Q
//! ```
//!
//! M is block-diagonal (one 6 x 6 block per body), each row of J touches one or two bodies, so `S_rs` is not zero
//! only where rows r and s share a body. The blocks `M^-1` ("mobility") and the rows are set before each
//! [`Kkt::factorise`]; the pattern of S is found once in [`Kkt::new`]. Rows that share no body with others, directly or by other
//! rows, are factored for themselves; dense where such an island has few rows, all of S sparse where one has many.
//! S depends on the scale of the rows, but whether a pivot counts as zero does not: it is compared with its own
//! diagonal element of S. Units: those of the coordinates (m, rad), the rows' residuals and N, N m.

mod dense;
mod pattern;
mod sparse;
#[cfg(test)]
mod tests;

use dense::Islands;
use pattern::Pattern;
use sparse::Sparse;

/// Inverse mass matrix of a body's six coordinates; the row and column of an imposed coordinate are zero.
pub type Mobility = nalgebra::Matrix6<f64>;

/// What a scalar constraint's row of J has on one body's six velocities.
pub type Coefficients = nalgebra::Vector6<f64>;

/// Coordinates of a body.
const SIX: usize = 6;

/// Up to this number of rows an island is stored dense: below it the sparse code's bookkeeping costs more than its zeros save.
const DENSE_ROWS: usize = 24;

/// A pivot smaller than this part of its diagonal element of S is rounding: the row depends on those before it.
const SMALLEST_PIVOT: f64 = 1e-13;

/// Bodies that a scalar constraint touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowBodies {
    pub first: usize,
    pub second: Option<usize>,
}

/// The active rows do not determine the multipliers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "constraint row {row} repeats what other active rows demand, or touches only imposed coordinates: \
     deactivate it or remove the joint that is too much"
)]
pub struct SingularConstraints {
    pub row: usize,
}

#[derive(Clone, Debug)]
enum Storage {
    /// Lower triangles, row by row, in `Kkt::matrix` itself.
    Dense(Islands),
    Sparse(Box<Sparse>),
}

/// Mobilities, rows and the factored matrix S; nothing but `new` allocates.
#[derive(Clone, Debug)]
pub struct Kkt {
    rows: Vec<RowBodies>,
    active: Vec<bool>,
    mobility: Vec<Mobility>,
    /// J: slot 2 r is row r on its first body, slot 2 r + 1 on its second.
    coefficients: Vec<Coefficients>,
    /// M^-1 J^T in the same slots.
    weighted: Vec<Coefficients>,
    pattern: Pattern,
    /// S in the pattern's order (when dense: overwritten by its factor).
    matrix: Vec<f64>,
    /// Multipliers of [`Kkt::correction`].
    scratch: Vec<f64>,
    storage: Storage,
}

impl Kkt {
    /// Finds the pattern; all rows start active, all mobilities and coefficients zero.
    pub fn new(bodies: usize, rows: &[RowBodies]) -> Kkt {
        Self::with_dense_limit(bodies, rows, DENSE_ROWS)
    }

    fn with_dense_limit(bodies: usize, rows: &[RowBodies], limit: usize) -> Kkt {
        let islands = Islands::new(bodies, rows);
        let sparse = if islands.largest() > limit { Sparse::new(bodies, rows) } else { None };
        // Without memory for the sparse symbolic part the dense one is no better off, but it is not wrong.
        let (pattern, storage) = match sparse {
            Some((pattern, sparse)) => (pattern, Storage::Sparse(Box::new(sparse))),
            None => (islands.pattern(bodies, rows), Storage::Dense(islands)),
        };
        Kkt {
            rows: rows.to_vec(),
            active: vec![true; rows.len()],
            mobility: vec![Mobility::zeros(); bodies],
            coefficients: vec![Coefficients::zeros(); 2 * rows.len()],
            weighted: vec![Coefficients::zeros(); 2 * rows.len()],
            matrix: vec![0.0; pattern.entries.len()],
            pattern,
            scratch: vec![0.0; rows.len()],
            storage,
        }
    }

    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    pub fn bodies(&self) -> usize {
        self.mobility.len()
    }

    /// Numbers kept of S and of its factor: a measure of the cost of a factorisation and of a solution.
    pub fn stored(&self) -> (usize, usize) {
        match &self.storage {
            Storage::Dense(_) => (self.matrix.len(), self.matrix.len()),
            Storage::Sparse(sparse) => (self.matrix.len(), sparse.fill()),
        }
    }

    pub fn set_mobility(&mut self, body: usize, mobility: &Mobility) {
        self.mobility[body] = *mobility;
    }

    pub fn mobility(&self, body: usize) -> &Mobility {
        &self.mobility[body]
    }

    /// Coefficients on the first and (if any) second body; without a second body `second` is not used.
    #[inline]
    pub fn set_row(&mut self, row: usize, first: &Coefficients, second: &Coefficients) {
        self.coefficients[2 * row] = *first;
        self.coefficients[2 * row + 1] = *second;
    }

    /// An inactive row is left out: its multiplier is zero. Counts from the next [`Kkt::factorise`] on.
    pub fn set_active(&mut self, row: usize, active: bool) {
        self.active[row] = active;
    }

    pub fn is_active(&self, row: usize) -> bool {
        self.active[row]
    }

    /// Bodies and coefficients of a row.
    pub fn row(&self, row: usize) -> (RowBodies, &Coefficients, &Coefficients) {
        (self.rows[row], &self.coefficients[2 * row], &self.coefficients[2 * row + 1])
    }

    /// J times the velocities (or accelerations, 6 per body) in one row.
    #[inline]
    pub fn row_times(&self, row: usize, velocities: &[f64]) -> f64 {
        let bodies = self.rows[row];
        let first = dot(&self.coefficients[2 * row], block(velocities, bodies.first));
        match bodies.second {
            Some(second) => first + dot(&self.coefficients[2 * row + 1], block(velocities, second)),
            None => first,
        }
    }

    /// Forms and factors S.
    pub fn factorise(&mut self) -> Result<(), SingularConstraints> {
        for (row, bodies) in self.rows.iter().enumerate() {
            self.weighted[2 * row] = product(&self.mobility[bodies.first], &self.coefficients[2 * row]);
            if let Some(second) = bodies.second {
                self.weighted[2 * row + 1] = product(&self.mobility[second], &self.coefficients[2 * row + 1]);
            }
        }
        for (entry, value) in self.pattern.entries.iter().zip(&mut self.matrix) {
            let [row, column] = entry.rows.map(|row| row as usize);
            *value = if self.active[row] && self.active[column] {
                let pairs = &self.pattern.pairs[entry.pairs.start as usize..entry.pairs.end as usize];
                pairs.iter().map(|pair| inner(&self.weighted[pair.0 as usize], &self.coefficients[pair.1 as usize])).sum()
            } else {
                f64::from(row == column)
            };
        }
        match &mut self.storage {
            Storage::Dense(islands) => islands.factorise(&mut self.matrix, SMALLEST_PIVOT),
            Storage::Sparse(sparse) => sparse.factorise(&self.matrix, SMALLEST_PIVOT),
        }
        .map_err(|row| SingularConstraints { row })
    }

    /// From free accelerations (6 per body) and gamma (1 per row) to accelerations and multipliers.
    /// Needs [`Kkt::factorise`].
    #[inline]
    pub fn solve(&mut self, free: &[f64], gamma: &[f64], accelerations: &mut [f64], multipliers: &mut [f64]) {
        for (row, multiplier) in multipliers.iter_mut().enumerate() {
            *multiplier = if self.active[row] { self.row_times(row, free) - gamma[row] } else { 0.0 };
        }
        accelerations.copy_from_slice(free);
        self.apply(multipliers, accelerations);
    }

    /// Mass-weighted smallest change: `J change = -residual`, `change = -M^-1 J^T S^-1 residual`.
    /// Needs [`Kkt::factorise`].
    pub fn correction(&mut self, residual: &[f64], change: &mut [f64]) {
        let mut multipliers = std::mem::take(&mut self.scratch);
        for ((multiplier, residual), active) in multipliers.iter_mut().zip(residual).zip(&self.active) {
            *multiplier = if *active { *residual } else { 0.0 };
        }
        change.fill(0.0);
        self.apply(&mut multipliers, change);
        self.scratch = multipliers;
    }

    /// Solves `S x = x` in place and subtracts `M^-1 J^T x` from `motion`.
    #[inline]
    fn apply(&mut self, x: &mut [f64], motion: &mut [f64]) {
        match &mut self.storage {
            Storage::Dense(islands) => islands.solve(&self.matrix, x),
            Storage::Sparse(sparse) => sparse.solve(x),
        }
        for (row, (bodies, x)) in self.rows.iter().zip(x.iter()).enumerate() {
            subtract(block_mut(motion, bodies.first), &self.weighted[2 * row], *x);
            if let Some(second) = bodies.second {
                subtract(block_mut(motion, second), &self.weighted[2 * row + 1], *x);
            }
        }
    }

    /// Generalised constraint force `-J^T lambda` on one coordinate (0 to 5) of a body, N or N m.
    pub fn constraint_force(&self, body: usize, coordinate: usize, multipliers: &[f64]) -> f64 {
        let slots = self.pattern.slots_of(body).iter();
        -slots.map(|slot| self.coefficients[*slot as usize][coordinate] * multipliers[*slot as usize / 2]).sum::<f64>()
    }
}

#[inline]
fn block(values: &[f64], body: usize) -> &[f64] {
    &values[SIX * body..SIX * (body + 1)]
}

#[inline]
fn block_mut(values: &mut [f64], body: usize) -> &mut [f64] {
    &mut values[SIX * body..SIX * (body + 1)]
}

#[inline]
fn dot(coefficients: &Coefficients, values: &[f64]) -> f64 {
    coefficients.iter().zip(values).map(|(c, v)| c * v).sum()
}

#[inline]
fn subtract(values: &mut [f64], direction: &Coefficients, factor: f64) {
    for (value, direction) in values.iter_mut().zip(direction.iter()) {
        *value -= factor * direction;
    }
}

/// In two sums side by side, which the compiler turns into vector instructions.
#[inline]
fn inner(a: &Coefficients, b: &Coefficients) -> f64 {
    let mut sums = [0.0; 2];
    for (a, b) in a.as_slice().chunks_exact(2).zip(b.as_slice().chunks_exact(2)) {
        sums[0] += a[0] * b[0];
        sums[1] += a[1] * b[1];
    }
    sums[0] + sums[1]
}

/// Column by column, which the compiler turns into vector instructions.
#[inline]
fn product(matrix: &Mobility, vector: &Coefficients) -> Coefficients {
    let mut result = [0.0; SIX];
    for (column, factor) in matrix.as_slice().chunks_exact(SIX).zip(vector.iter()) {
        for (result, value) in result.iter_mut().zip(column) {
            *result += value * factor;
        }
    }
    Coefficients::from(result)
}
