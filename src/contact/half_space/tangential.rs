//! The tangential problem: tractions p on a grid with Coulomb's law in each cell.
//!
//! Slip of cell I per length rolled, `s_I = w_I + sum_J C(I - J) p_J`; the cell sticks with `s = 0, |p| <= g`, or
//! slips with `p = -g s / |s|`. Both cases are one equation, `F(p) = p - P(p - rho s) = 0` with P the projection
//! onto the disk of radius g and any rho > 0 (here 1 / C_xx(0)). It is solved by a semismooth Newton method: the
//! derivative of P is 1 inside the disk and `T = g/|q| (1 - q q'/|q|^2)`, `q = p - rho s`, outside. The linear
//! systems go to GMRES with products by FFT. As rolling carries the influence from the leading edge backward, the
//! part of the system that couples a cell with itself and the next one ahead is solved exactly, strip by strip, as
//! preconditioner. Newton steps after the first are halved until |F| falls below the largest of the last four values
//! (an active set may have to get worse before it gets better). Where that fails a few cheap steps lead on: in
//! rolling, marches from the leading edge backward that solve each cell exactly, the missing influence frozen
//! (FASTSIM's march); without rolling, where the matrix is symmetric, projected gradient steps.
//!
//! Own arrangement of known methods: the natural map of Alart and Curnier (1991) for Kalker's discrete problem.

use super::cells::Pressure;
use super::influence::{Buffers, Cell, Convolver, Kernel, Pair};
use super::krylov::Gmres;

/// The slip of all cells, as the traction that it asks of a cell alone, in parts of the bound, below which it is small: a creepage of some 1e-6.
const SMALL: f64 = 1e-3;
/// No slip counts by less: rounding.
const LEAST: f64 = 1e-8;

/// Newton steps after which a solution is given up as it is; about six are usual.
pub(crate) const MOST_STEPS: usize = 60;

/// Limits of the iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// |F| over |g|, both as root of the sum of squares.
    pub tolerance: f64,
    pub most_steps: usize,
}

/// How an iteration ended.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    pub iterations: usize,
    /// Products with the full influence matrix.
    pub products: usize,
    pub residual: f64,
}

/// Memory of the solver; holds nothing from one call to the next.
#[derive(Clone, Debug)]
pub(crate) struct Workspace {
    buffers: Buffers,
    gmres: Gmres,
    slip: Vec<Pair>,
    map: Vec<Pair>,
    trial: Vec<Pair>,
    flat: Vec<f64>,
    step: Vec<f64>,
    cells: Vec<Linearised>,
}

/// Newton's matrix of one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Linearised {
    /// T; symmetric: xx, yy, xy.
    t: [f64; 3],
    /// Inverse of `1 - T (1 - rho C(0))`.
    inverse: [Pair; 2],
}

/// The discrete problem of one patch.
#[derive(Debug)]
pub(crate) struct Tangential<'a> {
    pub pressure: &'a Pressure,
    pub convolver: &'a Convolver,
    pub kernel: &'a Kernel,
}

fn pairs(flat: &[f64]) -> &[Pair] {
    flat.as_chunks().0
}

fn pairs_mut(flat: &mut [f64]) -> &mut [Pair] {
    flat.as_chunks_mut().0
}

fn project(q: Pair, g: f64) -> Pair {
    let size = q[0].hypot(q[1]);
    if size <= g { q } else { [q[0] * g / size, q[1] * g / size] }
}

fn size(v: &[Pair]) -> f64 {
    v.iter().map(|v| v[0] * v[0] + v[1] * v[1]).sum::<f64>().sqrt()
}

impl Workspace {
    pub(crate) fn new(convolver: &Convolver) -> Self {
        Workspace {
            buffers: convolver.buffers(),
            gmres: Gmres::default(),
            slip: Vec::new(),
            map: Vec::new(),
            trial: Vec::new(),
            flat: Vec::new(),
            step: Vec::new(),
            cells: Vec::new(),
        }
    }
}

impl Tangential<'_> {
    fn cells(&self) -> &[Cell] {
        &self.pressure.cells
    }

    fn rho(&self) -> f64 {
        1.0 / self.kernel.own[0]
    }

    /// `slip = rigid + C p`.
    fn slip(&self, rigid: &[Pair], p: &[Pair], slip: &mut [Pair], buffers: &mut Buffers) {
        self.convolver.apply(self.kernel, self.cells(), p, slip, buffers);
        for (s, w) in slip.iter_mut().zip(rigid) {
            *s = [s[0] + w[0], s[1] + w[1]];
        }
    }

    /// `F = p - P(p - rho s)`; gives |F| / |g|.
    fn map(&self, p: &[Pair], slip: &[Pair], map: &mut [Pair]) -> f64 {
        let rho = self.rho();
        for (((f, p), s), g) in map.iter_mut().zip(p).zip(slip).zip(&self.pressure.values) {
            let projected = project([p[0] - rho * s[0], p[1] - rho * s[1]], *g);
            *f = [p[0] - projected[0], p[1] - projected[1]];
        }
        size(map) / self.bound()
    }

    /// |g|.
    fn bound(&self) -> f64 {
        self.pressure.values.iter().map(|g| g * g).sum::<f64>().sqrt()
    }

    /// By what the tolerance counts: 1, less where the slip is so small that it would ask for nearly no traction against the bound. Next to nothing else was
    /// the solution then: c33 of a disk was 0 at a spin of 1e-6 1/m, and 1.18 at 1e-5.
    fn demand(&self, rigid: &[Pair]) -> f64 {
        let asked = self.rho() * size(rigid) / self.bound();
        (asked / SMALL).clamp(LEAST, 1.0)
    }

    /// Solves for the tractions; `p` holds the starting point and then the solution, always within the bound.
    /// `rigid` is the slip that the cells would have without tractions.
    pub(crate) fn solve(&self, rigid: &[Pair], p: &mut [Pair], limits: Limits, workspace: &mut Workspace) -> Outcome {
        let n = p.len();
        let Workspace { buffers, gmres, slip, map, trial, flat, step, cells } = workspace;
        for field in [&mut *slip, &mut *map, &mut *trial] {
            field.resize(n, [0.0; 2]);
        }
        flat.resize(2 * n, 0.0);
        step.resize(2 * n, 0.0);
        cells.resize(n, Linearised::default());
        let mut outcome = Outcome { products: 1, ..Outcome::default() };
        for (p, g) in p.iter_mut().zip(&self.pressure.values) {
            *p = project(*p, *g);
        }
        self.slip(rigid, p, slip, buffers);
        outcome.residual = self.map(p, slip, map);
        let mut recent = [f64::INFINITY; 4];
        let tolerance = limits.tolerance * self.demand(rigid);
        while outcome.residual > tolerance && outcome.iterations < limits.most_steps {
            outcome.iterations += 1;
            self.linearise(p, slip, cells);
            for (flat, f) in pairs_mut(flat).iter_mut().zip(map.iter()) {
                *flat = [-f[0], -f[1]];
            }
            // Loose solves far from the solution, tighter ones close to it.
            let forcing = (0.3 * outcome.residual.sqrt()).clamp(1e-4, 0.05);
            outcome.products += gmres.solve(
                flat,
                step,
                (forcing, 80),
                |v| self.precondition(cells, pairs_mut(v)),
                |v, out| {
                    self.convolver.apply(self.kernel, self.cells(), pairs(v), pairs_mut(out), buffers);
                    self.newton_rows(cells, pairs(v), pairs_mut(out));
                },
            );
            let reference = recent.iter().fold(0.0, |most: f64, r| most.max(*r));
            let mut length = 1.0;
            let accepted = loop {
                for (((t, p), d), g) in trial.iter_mut().zip(p.iter()).zip(pairs(step)).zip(&self.pressure.values) {
                    *t = project([p[0] + length * d[0], p[1] + length * d[1]], *g);
                }
                self.slip(rigid, trial, slip, buffers);
                let residual = self.map(trial, slip, map);
                outcome.products += 1;
                if residual < (1.0 - 0.1 * length) * reference {
                    outcome.residual = residual;
                    p.copy_from_slice(trial);
                    break true;
                }
                if length < 0.2 {
                    break false;
                }
                length *= 0.5;
            };
            if !accepted {
                for _ in 0..4 {
                    self.slip(rigid, p, slip, buffers);
                    if self.kernel.ahead[0] < 0.0 {
                        self.march(slip, p)
                    } else {
                        self.descend(slip, p)
                    }
                    outcome.products += 1;
                }
                self.slip(rigid, p, slip, buffers);
                outcome.residual = self.map(p, slip, map);
                outcome.products += 1;
            }
            recent.rotate_left(1);
            recent[3] = outcome.residual;
            if outcome.iterations == 1 {
                recent = [outcome.residual; 4];
            }
        }
        outcome
    }

    /// Slip of the cells under tractions `p`.
    pub(crate) fn slip_of(&self, rigid: &[Pair], p: &[Pair], workspace: &mut Workspace) -> Vec<Pair> {
        let mut slip = vec![[0.0; 2]; p.len()];
        self.slip(rigid, p, &mut slip, &mut workspace.buffers);
        slip
    }

    fn linearise(&self, p: &[Pair], slip: &[Pair], cells: &mut [Linearised]) {
        let rho = self.rho();
        // 1 - rho C(0)
        let [cxx, cyy, cxy] = self.kernel.own;
        let rest = [1.0 - rho * cxx, 1.0 - rho * cyy, -rho * cxy];
        for (((cell, p), s), g) in cells.iter_mut().zip(p).zip(slip).zip(&self.pressure.values) {
            let q = [p[0] - rho * s[0], p[1] - rho * s[1]];
            let r = q[0].hypot(q[1]);
            cell.t = if r <= *g {
                [1.0, 1.0, 0.0]
            } else {
                let (k, e) = (g / r, [q[0] / r, q[1] / r]);
                [k * e[1] * e[1], k * e[0] * e[0], -k * e[0] * e[1]]
            };
            let [txx, tyy, txy] = cell.t;
            let m = [
                [1.0 - txx * rest[0] - txy * rest[2], -txx * rest[2] - txy * rest[1]],
                [-txy * rest[0] - tyy * rest[2], 1.0 - txy * rest[2] - tyy * rest[1]],
            ];
            let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
            let d = if determinant.abs() > 1e-30 { 1.0 / determinant } else { 1.0 };
            cell.inverse = [[m[1][1] * d, -m[0][1] * d], [-m[1][0] * d, m[0][0] * d]];
        }
    }

    /// `out = v - T (v - rho out)` with `out = C v` on entry.
    fn newton_rows(&self, cells: &[Linearised], v: &[Pair], out: &mut [Pair]) {
        let rho = self.rho();
        for ((cell, v), out) in cells.iter().zip(v).zip(out) {
            let d = [v[0] - rho * out[0], v[1] - rho * out[1]];
            let [txx, tyy, txy] = cell.t;
            *out = [v[0] - txx * d[0] - txy * d[1], v[1] - txy * d[0] - tyy * d[1]];
        }
    }

    /// Solves the rows with the influence of the cell and its neighbour ahead only.
    fn precondition(&self, cells: &[Linearised], v: &mut [Pair]) {
        let rho = self.rho();
        let [axx, ayy, axy] = self.kernel.ahead;
        for k in 0..v.len() {
            let mut right = v[k];
            if self.pressure.has_ahead(k) {
                let ahead = v[k - 1];
                let c = [rho * (axx * ahead[0] + axy * ahead[1]), rho * (axy * ahead[0] + ayy * ahead[1])];
                let [txx, tyy, txy] = cells[k].t;
                right = [right[0] - txx * c[0] - txy * c[1], right[1] - txy * c[0] - tyy * c[1]];
            }
            let m = cells[k].inverse;
            v[k] = [m[0][0] * right[0] + m[0][1] * right[1], m[1][0] * right[0] + m[1][1] * right[1]];
        }
    }

    /// One step down the gradient, short enough for any distribution of tractions.
    fn descend(&self, slip: &[Pair], p: &mut [Pair]) {
        for ((p, s), g) in p.iter_mut().zip(slip).zip(&self.pressure.values) {
            *p = project([p[0] - s[0] / self.kernel.total, p[1] - s[1] / self.kernel.total], *g);
        }
    }

    /// One march backward from the leading edge: each cell is solved exactly with what its own traction and the
    /// change of the one ahead do to its slip; the rest of the influence stays as in `slip`. Half the change is taken.
    fn march(&self, slip: &[Pair], p: &mut [Pair]) {
        let ([dx, dy, _], [axx, ayy, axy]) = (self.kernel.own, self.kernel.ahead);
        let mut change = [0.0; 2];
        for k in 0..p.len() {
            let mut s = [slip[k][0] - dx * p[k][0], slip[k][1] - dy * p[k][1]];
            if self.pressure.has_ahead(k) {
                s = [s[0] + axx * change[0] + axy * change[1], s[1] + axy * change[0] + ayy * change[1]];
            }
            let found = local(s, [dx, dy], self.pressure.values[k]);
            change = [0.5 * (found[0] - p[k][0]), 0.5 * (found[1] - p[k][1])];
            p[k] = [p[k][0] + change[0], p[k][1] + change[1]];
        }
    }
}

/// Traction of one cell with slip `s + D p`, D diagonal and positive: zero slip, or `|p| = g` against the slip.
fn local(s: Pair, d: Pair, g: f64) -> Pair {
    let at = |lambda: f64| [-s[0] / (d[0] + lambda), -s[1] / (d[1] + lambda)];
    let stuck = at(0.0);
    if stuck[0].hypot(stuck[1]) <= g {
        return stuck;
    }
    // |p(lambda)| = g: Newton on 1/|p|, which is nearly straight in lambda; it starts on the safe side.
    let mut lambda = 0.0;
    for _ in 0..30 {
        let p = at(lambda);
        let squared = p[0] * p[0] + p[1] * p[1];
        let slope = p[0] * p[0] / (d[0] + lambda) + p[1] * p[1] / (d[1] + lambda);
        let step = (squared.sqrt() / g - 1.0) * squared / slope;
        lambda += step;
        if step.abs() <= 1e-12 * (lambda + d[0]) {
            break;
        }
    }
    project(at(lambda), g)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_one_cell_slips_against_its_slip() {
        let (s, d, g) = ([2.0, -3.0], [1.5, 0.7], 0.8);
        let p = local(s, d, g);
        assert!((p[0].hypot(p[1]) - g).abs() < 1e-12);
        let slip = [s[0] + d[0] * p[0], s[1] + d[1] * p[1]];
        assert!((slip[0] * p[1] - slip[1] * p[0]).abs() < 1e-12 && slip[0] * p[0] + slip[1] * p[1] < 0.0);
        assert_eq!(local([0.3, 0.0], [1.0, 1.0], 1.0), [-0.3, 0.0]);
    }
}
