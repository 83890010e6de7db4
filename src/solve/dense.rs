//! Cubic continuous output of a step: the Hermite polynomial through both its ends.
//!
//! With theta from 0 to 1 over the step, d = y1 - y0 and p0, p1 the slopes at the ends times the step,
//! y = y0 + p0 theta + (3 d - 2 p0 - p1) theta^2 + (p0 + p1 - 2 d) theta^3. Its error is of order 4 in the step where the slopes are
//! exact, and of order k + 1 where theirs is of order k < 3.

/// Number of vectors that it takes: powers 0 to 3 of theta.
pub(super) const CUBIC: usize = 4;

/// Writes the coefficients to `dense`, power by power. `slopes(i)`: both slopes of component i times the step.
pub(super) fn write_cubic(dense: &mut [f64], begin: &[f64], end: &[f64], slopes: impl Fn(usize) -> [f64; 2]) {
    let n = begin.len();
    for i in 0..n {
        write_one(dense, (i, n), [begin[i], end[i]], slopes(i));
    }
}

/// The same of component `i` out of `n` alone.
pub(super) fn write_one(dense: &mut [f64], (i, n): (usize, usize), [begin, end]: [f64; 2], [first, last]: [f64; 2]) {
    let difference = end - begin;
    let coefficients = [begin, first, 3.0 * difference - 2.0 * first - last, first + last - 2.0 * difference];
    for (power, coefficient) in coefficients.into_iter().enumerate() {
        dense[power * n + i] = coefficient;
    }
}
