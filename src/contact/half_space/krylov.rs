//! GMRES (Saad and Schultz 1986), preconditioned from the right, without restart.

/// Storage for one solve after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gmres {
    basis: Vec<Vec<f64>>,
    /// Columns of the triangular factor.
    columns: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    rest: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four partial sums: the order of summation is fixed, yet the sums may run side by side.
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let tail: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + tail
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

impl Gmres {
    /// Solves `A M^-1 y = right`, gives `M^-1 y` in `solution` and the number of products with A.
    /// Stops at `tolerance` times the size of `right`, or after `most` products.
    pub(crate) fn solve(
        &mut self,
        right: &[f64],
        solution: &mut [f64],
        (tolerance, most): (f64, usize),
        mut precondition: impl FnMut(&mut [f64]),
        mut product: impl FnMut(&[f64], &mut [f64]),
    ) -> usize {
        let (n, size) = (right.len(), norm(right));
        solution.fill(0.0);
        if size == 0.0 {
            return 0;
        }
        self.columns.clear();
        self.rotations.clear();
        self.rest.clear();
        self.rest.push(size);
        self.vector(0, n).iter_mut().zip(right).for_each(|(v, r)| *v = r / size);
        let mut work = vec![0.0; n];
        let mut used = 0;
        while used < most {
            work.copy_from_slice(&self.basis[used]);
            precondition(&mut work);
            self.vector(used + 1, n);
            let (known, fresh) = self.basis.split_at_mut(used + 1);
            let new = &mut fresh[0];
            product(&work, new);
            let mut column = Vec::with_capacity(used + 2);
            for v in known.iter() {
                let h = dot(v, new);
                new.iter_mut().zip(v).for_each(|(w, v)| *w -= h * v);
                column.push(h);
            }
            let length = norm(new);
            if length > 0.0 {
                new.iter_mut().for_each(|w| *w /= length);
            }
            for (k, (c, s)) in self.rotations.iter().enumerate() {
                (column[k], column[k + 1]) = (c * column[k] + s * column[k + 1], c * column[k + 1] - s * column[k]);
            }
            let radius = column[used].hypot(length);
            if !(radius > 0.0) {
                break;
            }
            let (c, s) = (column[used] / radius, length / radius);
            column[used] = radius;
            self.columns.push(column);
            self.rotations.push((c, s));
            let rest = self.rest[used];
            self.rest[used] = c * rest;
            self.rest.push(-s * rest);
            used += 1;
            if self.rest[used].abs() <= tolerance * size {
                break;
            }
        }
        for k in (0..used).rev() {
            let sum: f64 = (k + 1..used).map(|j| self.columns[j][k] * self.rest[j]).sum();
            self.rest[k] = (self.rest[k] - sum) / self.columns[k][k];
            solution.iter_mut().zip(&self.basis[k]).for_each(|(x, v)| *x += self.rest[k] * v);
        }
        precondition(solution);
        used
    }

    fn vector(&mut self, k: usize, n: usize) -> &mut Vec<f64> {
        while self.basis.len() <= k {
            self.basis.push(Vec::new());
        }
        self.basis[k].resize(n, 0.0);
        &mut self.basis[k]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_small_system() {
        let matrix = [[4.0, 1.0, 0.0], [-1.0, 3.0, 2.0], [0.5, 0.0, 2.0]];
        let exact = [1.0, -2.0, 3.0];
        let product = |v: &[f64], out: &mut [f64]| {
            for (row, out) in matrix.iter().zip(out) {
                *out = dot(row, v);
            }
        };
        let (mut right, mut found) = ([0.0; 3], [0.0; 3]);
        product(&exact, &mut right);
        let halve = |v: &mut [f64]| v.iter_mut().for_each(|v| *v *= 0.5);
        let used = Gmres::default().solve(&right, &mut found, (1e-13, 10), halve, product);
        assert!(used <= 3 && found.iter().zip(exact).all(|(f, e)| (f - e).abs() < 1e-12), "{found:?}");
    }
}
