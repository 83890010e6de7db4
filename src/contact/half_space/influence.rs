//! Influence coefficients: surface displacements of a loaded rectangle, and sums over a grid of them by FFT.
//!
//! Two half-spaces of the same material, loaded by opposite tangential tractions p (on the wheel), move apart by
//!
//! ```text
//! u_i(x) = 1/(pi G) sum_j int [ (1 - nu) delta_ij / R + nu X_i X_j / R^3 ] p_j dA,     X = x - x', R = |X|
//! ```
//!
//! (Cerruti). Over a rectangle of constant traction the integrals are sums over its four corners of
//! `J1 = X asinh(Y/|X|)` = int Y^2/R^3, `J2 = Y asinh(X/|Y|)` = int X^2/R^3 and `-R` = int X Y / R^3, so that
//! `u_xx: (1 - nu) J1 + J2`, `u_yy: J1 + (1 - nu) J2`, `u_xy: -nu R`. The normal displacement under a pressure is
//! `(1 - nu) (J1 + J2) / (pi G)` (Boussinesq), uncoupled from the tangential one because both bodies are alike.
//!
//! All lengths here are divided by sqrt(a b), tractions by a reference stress and displacements by that stress
//! times sqrt(a b) / G: nothing but a/b and nu remains.
//! Source of the integrals: Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), chapter 4; derived
//! anew (they are checked against numerical integration below).

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlannerScalar};
use std::f64::consts::PI;
use std::sync::Arc;

/// Two tangential components, along e1 and e2.
pub(crate) type Pair = [f64; 2];
/// Influence xx, yy, xy.
pub(crate) type Influence = [f64; 3];

/// `X asinh(Y / |X|)`, zero on the axis.
fn corner_term(x: f64, y: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x * (y / x.abs()).asinh() }
}

fn corner(x: f64, y: f64, nu: f64) -> [f64; 4] {
    let (j1, j2) = (corner_term(x, y), corner_term(y, x));
    [((1.0 - nu) * j1 + j2) / PI, (j1 + (1.0 - nu) * j2) / PI, -nu * x.hypot(y) / PI, (1.0 - nu) * (j1 + j2) / PI]
}

/// Displacements xx, yy, xy and zz at (x, y) from the middle of a rectangle `size` under unit traction.
pub(crate) fn rectangle(x: f64, y: f64, size: Pair, nu: f64) -> [f64; 4] {
    let [hx, hy] = [0.5 * size[0], 0.5 * size[1]];
    let c = [corner(x + hx, y + hy, nu), corner(x - hx, y + hy, nu), corner(x + hx, y - hy, nu), corner(x - hx, y - hy, nu)];
    std::array::from_fn(|k| c[0][k] - c[1][k] - c[2][k] + c[3][k])
}

/// Where a grid cell stands: column along e1, row along e2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cell {
    pub column: usize,
    pub row: usize,
}

/// Sums over a grid by FFT on one of twice the size, on which they do not wrap around.
#[derive(Clone)]
pub(crate) struct Convolver {
    /// Cells along e1 and e2.
    pub columns: usize,
    pub rows: usize,
    along: Transform,
    across: Transform,
}

/// Transforms of one length.
#[derive(Clone)]
struct Transform {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl std::fmt::Debug for Convolver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Convolver({} x {})", self.columns, self.rows)
    }
}

/// Influence of one cell on all others, transformed.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    /// Transforms of xx, yy, xy; e2 runs fastest.
    spectrum: Vec<[Complex<f64>; 3]>,
    /// Influence of a cell on itself.
    pub own: Influence,
    /// Influence of the next cell ahead (towards +e1).
    pub ahead: Influence,
    /// Largest sum over all cells that one cell can feel, a bound of the matrix.
    pub total: f64,
}

/// Scratch of the transforms.
#[derive(Clone, Debug)]
pub(crate) struct Buffers {
    field: Vec<Complex<f64>>,
    turned: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Convolver {
    /// For as many cells along both axes.
    pub(crate) fn square(n: usize) -> Self {
        Self::new(n, n)
    }

    pub(crate) fn new(columns: usize, rows: usize) -> Self {
        // Scalar: the same bits whatever the processor can do.
        let mut planner = FftPlannerScalar::new();
        let mut transform =
            |cells: usize| Transform { forward: planner.plan_fft_forward(2 * cells), inverse: planner.plan_fft_inverse(2 * cells) };
        Convolver { columns, rows, along: transform(columns), across: transform(rows) }
    }

    pub(crate) fn buffers(&self) -> Buffers {
        let zeros = |length| vec![Complex::new(0.0, 0.0); length];
        let needed = |transform: &Transform| transform.forward.get_inplace_scratch_len().max(transform.inverse.get_inplace_scratch_len());
        let count = 4 * self.columns * self.rows;
        Buffers { field: zeros(count), turned: zeros(count), scratch: zeros(needed(&self.along).max(needed(&self.across))) }
    }

    /// `influence(i, j)`: what a cell does at the cell i columns and j rows further on.
    pub(crate) fn kernel(&self, influence: impl Fn(i32, i32) -> Influence) -> Kernel {
        let (columns, rows) = (self.columns as i32, self.rows as i32);
        let (long, wide) = (2 * self.columns, 2 * self.rows);
        let mut spectrum = vec![[Complex::new(0.0, 0.0); 3]; long * wide];
        let mut fields = vec![[0.0; 3]; long * wide];
        for j in 1 - rows..rows {
            for i in 1 - columns..columns {
                fields[j.rem_euclid(2 * rows) as usize * long + i.rem_euclid(2 * columns) as usize] = influence(i, j);
            }
        }
        let sum = |k: usize| fields.iter().map(|field| field[k].abs() + field[2].abs()).sum::<f64>();
        let total = f64::max(sum(0), sum(1));
        let mut buffers = self.buffers();
        for component in 0..3 {
            for (value, field) in buffers.field.iter_mut().zip(&fields) {
                *value = Complex::new(field[component], 0.0);
            }
            self.along.forward.process_with_scratch(&mut buffers.field, &mut buffers.scratch);
            transpose(&buffers.field, &mut buffers.turned, [wide, long]);
            self.across.forward.process_with_scratch(&mut buffers.turned, &mut buffers.scratch);
            for (value, transformed) in spectrum.iter_mut().zip(&buffers.turned) {
                value[component] = transformed / (long * wide) as f64;
            }
        }
        Kernel { spectrum, own: influence(0, 0), ahead: influence(-1, 0), total }
    }

    /// `out = kernel * tractions` on `cells`. Both components travel in one complex transform.
    pub(crate) fn apply(&self, kernel: &Kernel, cells: &[Cell], tractions: &[Pair], out: &mut [Pair], buffers: &mut Buffers) {
        let (long, wide) = (2 * self.columns, 2 * self.rows);
        let loaded = self.rows * long;
        let Buffers { field, turned, scratch } = buffers;
        field.fill(Complex::new(0.0, 0.0));
        for (cell, p) in cells.iter().zip(tractions) {
            field[cell.row * long + cell.column] = Complex::new(p[0], p[1]);
        }
        self.along.forward.process_with_scratch(&mut field[..loaded], scratch);
        transpose(field, turned, [wide, long]);
        self.across.forward.process_with_scratch(turned, scratch);
        for column in 0..=self.columns {
            let mirrored = (long - column) % long;
            for row in 0..wide {
                let (here, there) = (column * wide + row, mirrored * wide + (wide - row) % wide);
                if here > there {
                    continue;
                }
                let (z, w) = (turned[here], turned[there].conj());
                // Transforms of the two real fields, and of their images.
                let px = (z + w) * 0.5;
                let py = (z - w) * Complex::new(0.0, -0.5);
                let [xx, yy, xy] = kernel.spectrum[here];
                let (ux, uy) = (xx * px + xy * py, xy * px + yy * py);
                let i = Complex::new(0.0, 1.0);
                turned[here] = ux + i * uy;
                turned[there] = ux.conj() + i * uy.conj();
            }
        }
        self.across.inverse.process_with_scratch(turned, scratch);
        transpose(turned, field, [long, wide]);
        self.along.inverse.process_with_scratch(&mut field[..loaded], scratch);
        for (cell, u) in cells.iter().zip(out) {
            let value = field[cell.row * long + cell.column];
            *u = [value.re, value.im];
        }
    }
}

/// Rows become columns.
fn transpose(from: &[Complex<f64>], to: &mut [Complex<f64>], [rows, columns]: [usize; 2]) {
    const TILE: usize = 8;
    for i0 in (0..rows).step_by(TILE) {
        for j0 in (0..columns).step_by(TILE) {
            for i in i0..(i0 + TILE).min(rows) {
                for j in j0..(j0 + TILE).min(columns) {
                    to[j * rows + i] = from[i * columns + j];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_rectangle_agrees_with_numerical_integration() {
        let (nu, size, at) = (0.28, [0.7, 0.3], [0.9, -0.5]);
        let mut sums = [0.0; 4];
        let n = 200;
        for i in 0..n {
            for j in 0..n {
                let x = at[0] - size[0] * ((i as f64 + 0.5) / n as f64 - 0.5);
                let y = at[1] - size[1] * ((j as f64 + 0.5) / n as f64 - 0.5);
                let (r, area) = (x.hypot(y), size[0] * size[1] / (n * n) as f64);
                let terms = [
                    (1.0 - nu) / r + nu * x * x / r.powi(3),
                    (1.0 - nu) / r + nu * y * y / r.powi(3),
                    nu * x * y / r.powi(3),
                    (1.0 - nu) / r,
                ];
                for (sum, term) in sums.iter_mut().zip(terms) {
                    *sum += term * area / PI;
                }
            }
        }
        let found = rectangle(at[0], at[1], size, nu);
        for (found, sum) in found.iter().zip(sums) {
            assert!((found / sum - 1.0).abs() < 1e-5, "{found} {sum}");
        }
    }

    #[test]
    fn equiv_transformed_sum_is_the_direct_sum() {
        let (columns, rows, size, nu) = (6, 9, [0.3, 0.2], 0.28);
        let influence = |i: i32, j: i32| {
            let [xx, yy, xy, _] = rectangle(i as f64 * size[0] + 0.07, j as f64 * size[1], size, nu);
            [xx, yy, xy]
        };
        let convolver = Convolver::new(columns, rows);
        let kernel = convolver.kernel(influence);
        let cells: Vec<Cell> = (0..columns * rows).filter(|k| k % 5 != 1).map(|k| Cell { column: k % columns, row: k / columns }).collect();
        let tractions: Vec<Pair> = (0..cells.len()).map(|k| [(k as f64).sin(), (1.7 * k as f64).cos()]).collect();
        let mut out = vec![[0.0; 2]; cells.len()];
        convolver.apply(&kernel, &cells, &tractions, &mut out, &mut convolver.buffers());
        for (to, u) in cells.iter().zip(&out) {
            let mut sum = [0.0; 2];
            for (from, p) in cells.iter().zip(&tractions) {
                let [xx, yy, xy] = influence(to.column as i32 - from.column as i32, to.row as i32 - from.row as i32);
                sum = [sum[0] + xx * p[0] + xy * p[1], sum[1] + xy * p[0] + yy * p[1]];
            }
            assert!((sum[0] - u[0]).abs() < 1e-12 && (sum[1] - u[1]).abs() < 1e-12, "{sum:?} {u:?}");
        }
    }
}
