//! Cholesky factorisation `S = L L^T` of a small matrix in place: lower triangle, row by row, with the inverse of
//! L's diagonal in the diagonal's place.

/// Factors; the error is the row whose pivot is below `smallest` times its diagonal element.
#[inline]
pub(super) fn factorise(matrix: &mut [f64], rows: usize, smallest: f64) -> Result<(), usize> {
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
pub(super) fn solve(factor: &[f64], x: &mut [f64]) {
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
