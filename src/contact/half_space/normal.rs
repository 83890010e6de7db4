//! The normal problem: where two half-spaces touch, and how hard they press.
//!
//! Known is by how much the undeformed surfaces overlap in each cell, d (negative: a gap). Wanted is the pressure p that holds them apart,
//!
//! ```text
//! w = K p - d,    p >= 0,  w >= 0,  p w = 0    in each cell,
//! ```
//!
//! with K the normal displacement of both bodies (Boussinesq). It is the solution of a quadratic programme with a positive definite
//! matrix: there is one and only one. Conjugate gradients on the cells in contact; cells that would pull leave it, cells that would overlap
//! enter it (Polonsky and Keer, Wear 231 (1999) 206-219).
//!
//! Any surfaces, several patches that feel each other. Lengths in m, pressure in parts of G.

use super::influence::{Cell, Convolver, Kernel, Pair, rectangle};

/// Normal influence for cells of `size` [m]; both components of a field are pressures of their own.
pub(crate) fn kernel(size: Pair, nu: f64, convolver: &Convolver) -> Kernel {
    let (columns, rows) = (convolver.columns as i32, convolver.rows as i32);
    let quadrant: Vec<f64> =
        (0..rows).flat_map(|j| (0..columns).map(move |i| rectangle(f64::from(i) * size[0], f64::from(j) * size[1], size, nu)[3])).collect();
    convolver.kernel(|i, j| {
        let value = quadrant[(j.abs() * columns + i.abs()) as usize];
        [value, value, 0.0]
    })
}

/// Overlap that is left in cells in contact, in parts of the largest one, at which the iteration ends.
const TOLERANCE: f64 = 1e-9;
const MOST: usize = 2000;

/// Pressures over G in all cells, given their overlaps [m].
///
/// Returns `None` where the iteration does not converge (it does; a bound on the effort).
pub(crate) fn pressures(cells: &[Cell], overlaps: &[f64], kernel: &Kernel, convolver: &Convolver) -> Option<Vec<f64>> {
    let deepest = overlaps.iter().copied().fold(0.0, f64::max);
    if !(deepest > 0.0) {
        return Some(vec![0.0; cells.len()]);
    }
    let mut buffers = convolver.buffers();
    let mut field: Vec<Pair> = vec![[0.0; 2]; cells.len()];
    let mut moved: Vec<Pair> = vec![[0.0; 2]; cells.len()];
    let mut displaced = |values: &[f64], out: &mut Vec<Pair>| {
        field.iter_mut().zip(values).for_each(|(field, value)| field[0] = *value);
        convolver.apply(kernel, cells, &field, out, &mut buffers);
    };
    let mut p: Vec<f64> = overlaps.iter().map(|d| d.max(0.0) / kernel.total).collect();
    let (mut direction, mut gap) = (vec![0.0; cells.len()], vec![0.0; cells.len()]);
    let (mut before, mut conjugate) = (1.0, false);
    for _ in 0..MOST {
        displaced(&p, &mut moved);
        gap.iter_mut().zip(&moved).zip(overlaps).for_each(|((gap, u), d)| *gap = u[0] - d);
        let worst = p.iter().zip(&gap).map(|(p, w)| if *p > 0.0 { w.abs() } else { (-w).max(0.0) }).fold(0.0, f64::max);
        if worst <= TOLERANCE * deepest {
            return Some(p);
        }
        let square: f64 = p.iter().zip(&gap).filter(|(p, _)| **p > 0.0).map(|(_, w)| w * w).sum();
        let kept = if conjugate { square / before } else { 0.0 };
        before = square;
        for ((t, w), p) in direction.iter_mut().zip(&gap).zip(&p) {
            *t = if *p > 0.0 { w + kept * *t } else { 0.0 };
        }
        displaced(&direction, &mut moved);
        let (mut work, mut stiffness) = (0.0, 0.0);
        for ((t, u), w) in direction.iter().zip(&moved).zip(&gap) {
            (work, stiffness) = (work + w * t, stiffness + u[0] * t);
        }
        // No cell in contact at all: those that overlap enter with a step of the matrix's own size.
        let step = if stiffness > 0.0 { work / stiffness } else { 1.0 / kernel.own[0] };
        conjugate = true;
        for ((p, t), w) in p.iter_mut().zip(&direction).zip(&gap) {
            *p = (*p - step * t).max(0.0);
            if *p == 0.0 && *w < 0.0 {
                *p = -step * w;
                conjugate = false;
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use ellip::legendre::{ellipe, ellipk};

    fn grid(columns: usize, rows: usize) -> Vec<Cell> {
        (0..rows).flat_map(|row| (0..columns).rev().map(move |column| Cell { column, row })).collect()
    }

    #[test]
    fn analytic_paraboloids_press_as_hertz_says() {
        // Semi-axes 2 and 1 and the highest pressure p0 = 1: approach and curvatures from complete elliptic integrals.
        let (nu, a, b) = (0.28, 2.0, 1.0);
        let m: f64 = 1.0 - (b * b) / (a * a);
        let (k, e) = (ellipk(m).unwrap(), ellipe(m).unwrap());
        let scale = (1.0 - nu) * b;
        let (approach, along, across) = (scale * k, scale * (k - e) / m / (a * a), scale * (e / (1.0 - m) - k) * (1.0 - m) / m / (b * b));
        let mut errors = Vec::new();
        for n in [16, 32, 64] {
            // The box within which the surfaces overlap.
            let half = [(approach / along).sqrt(), (approach / across).sqrt()];
            let size = half.map(|half| 2.0 * half / n as f64);
            let (convolver, cells) = (Convolver::square(n), grid(n, n));
            let middle = |k: usize, axis: usize| size[axis] * (k as f64 + 0.5) - half[axis];
            let overlap = |cell: &Cell| approach - along * middle(cell.column, 0).powi(2) - across * middle(cell.row, 1).powi(2);
            let overlaps: Vec<f64> = cells.iter().map(overlap).collect();
            let p = pressures(&cells, &overlaps, &kernel(size, nu, &convolver), &convolver).unwrap();
            let load: f64 = p.iter().sum::<f64>() * size[0] * size[1];
            let peak = p.iter().copied().fold(0.0, f64::max);
            let expected = 2.0 / 3.0 * std::f64::consts::PI * a * b;
            errors.push(((load / expected - 1.0).abs(), (peak - 1.0).abs()));
        }
        println!("load and highest pressure on 16, 32, 64 cells: {errors:?}");
        assert!(errors[0].0 < 2e-2 && errors[1].0 < 5e-3 && errors[2].0 < 2e-3 && errors[2].1 < 5e-3, "{errors:?}");
    }

    #[test]
    fn prop_pressure_and_gap_exclude_each_other() {
        // Two bumps that feel each other, one of them beyond a valley.
        let (convolver, cells, size, nu) = (Convolver::new(12, 30), grid(12, 30), [1.0, 0.8], 0.3);
        let place = |cell: &Cell| (cell.column as f64 - 5.5, 0.8 * cell.row as f64 - 11.6);
        let overlaps: Vec<f64> = cells
            .iter()
            .map(place)
            .map(|(x, y)| {
                let bump = |height: f64, at: f64| height - 0.05 * x * x - 0.08 * (y - at).powi(2);
                bump(1.0, -6.0).max(bump(0.4, 6.0))
            })
            .collect();
        let kernel = kernel(size, nu, &convolver);
        let p = pressures(&cells, &overlaps, &kernel, &convolver).unwrap();
        let mut moved = vec![[0.0; 2]; cells.len()];
        convolver.apply(&kernel, &cells, &p.iter().map(|p| [*p, 0.0]).collect::<Vec<_>>(), &mut moved, &mut convolver.buffers());
        for ((p, u), d) in p.iter().zip(&moved).zip(&overlaps) {
            let gap = u[0] - d;
            assert!(*p >= 0.0 && gap > -2e-9 && (p * gap).abs() < 1e-9, "{p} {gap}");
        }
        let sums = [-6.0, 6.0]
            .map(|at: f64| cells.iter().zip(&p).filter(|(cell, _)| (place(cell).1 - at).abs() < 5.0).map(|(_, p)| p).sum::<f64>());
        assert!(sums[0] > 2.0 * sums[1] && sums[1] > 0.0, "{sums:?}");
    }
}
