//! Cholesky factorisation `S = L L^T` in place of small matrices, one per island of rows: lower triangles, row by row, with the inverse
//! of L's diagonal in the diagonal's place.

use super::RowBodies;
use super::pattern::Pattern;

/// Rows in the order of their islands: those that hang together by shared bodies. S has nothing between islands.
#[derive(Clone, Debug, Default)]
pub(super) struct Islands {
    /// Row at each place, and the place behind each island's last.
    order: Vec<u32>,
    ends: Vec<usize>,
    /// Right-hand side and solution in that order.
    x: Vec<f64>,
}

impl Islands {
    pub fn new(bodies: usize, rows: &[RowBodies]) -> Islands {
        // Each body and, by it, each row points to an earlier one of its island, the first one to itself.
        let mut parents: Vec<usize> = (0..bodies).collect();
        fn root(parents: &[usize], mut body: usize) -> usize {
            while parents[body] != body {
                body = parents[body];
            }
            body
        }
        for row in rows {
            let (first, second) = (root(&parents, row.first), root(&parents, row.second.unwrap_or(row.first)));
            parents[first.max(second)] = first.min(second);
        }
        let mut order: Vec<u32> = (0..rows.len() as u32).collect();
        // Stable: rows of an island keep their order, so that the later one of two that say the same is found to be too much.
        order.sort_by_key(|row| root(&parents, rows[*row as usize].first));
        let island = |place: usize| root(&parents, rows[order[place] as usize].first);
        let ends: Vec<usize> = (1..=rows.len()).filter(|end| *end == rows.len() || island(*end) != island(end - 1)).collect();
        Islands { x: vec![0.0; rows.len()], order, ends }
    }

    /// Rows of the largest.
    pub fn largest(&self) -> usize {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(start, end)| end - start).max().unwrap_or(0)
    }

    pub fn pattern(&self, bodies: usize, rows: &[RowBodies]) -> Pattern {
        Pattern::dense(bodies, rows, &self.order, &self.ends)
    }

    /// Factors the matrices, one after the other; the error is the row whose pivot is below `smallest` times its diagonal element.
    #[inline]
    pub fn factorise(&self, mut matrices: &mut [f64], smallest: f64) -> Result<(), usize> {
        let mut start = 0;
        for end in &self.ends {
            let rows = end - start;
            let (matrix, rest) = matrices.split_at_mut(rows * (rows + 1) / 2);
            factorise(matrix, rows, smallest).map_err(|row| self.order[start + row] as usize)?;
            (matrices, start) = (rest, *end);
        }
        Ok(())
    }

    /// Solves with the factors, in place.
    #[inline]
    pub fn solve(&mut self, mut factors: &[f64], x: &mut [f64]) {
        for (own, row) in self.x.iter_mut().zip(&self.order) {
            *own = x[*row as usize];
        }
        let mut start = 0;
        for end in &self.ends {
            let rows = end - start;
            let (factor, rest) = factors.split_at(rows * (rows + 1) / 2);
            solve(factor, &mut self.x[start..*end]);
            (factors, start) = (rest, *end);
        }
        for (own, row) in self.x.iter().zip(&self.order) {
            x[*row as usize] = *own;
        }
    }
}

/// Factors; the error is the row whose pivot is below `smallest` times its diagonal element.
#[inline]
fn factorise(matrix: &mut [f64], rows: usize, smallest: f64) -> Result<(), usize> {
    let mut start = 0;
    for row in 0..rows {
        let (above, rest) = matrix.split_at_mut(start);
        let own = &mut rest[..=row];
        let diagonal = own[row];
        let mut pivot = diagonal;
        let mut at = 0;
        for column in 0..row {
            let other = &above[at..=at + column];
            let value = (own[column] - dot(&own[..column], &other[..column])) * other[column];
            own[column] = value;
            pivot -= value * value;
            at += column + 1;
        }
        if !(pivot > smallest * diagonal) {
            return Err(row);
        }
        own[row] = 1.0 / pivot.sqrt();
        start += row + 1;
    }
    Ok(())
}

/// Solves with the factor, in place.
#[inline]
fn solve(factor: &[f64], x: &mut [f64]) {
    let mut start = 0;
    for row in 0..x.len() {
        let own = &factor[start..=start + row];
        x[row] = (x[row] - dot(&own[..row], &x[..row])) * own[row];
        start += row + 1;
    }
    for row in (0..x.len()).rev() {
        start -= row + 1;
        let own = &factor[start..=start + row];
        let (before, rest) = x.split_at_mut(row);
        rest[0] *= own[row];
        for (value, coefficient) in before.iter_mut().zip(own) {
            *value -= coefficient * rest[0];
        }
    }
}

#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
