//! What changes of the system within a step that is already made add to its solution.
//!
//! A master changes an input at a communication point, and the integrator's step reaches far beyond it. Where the change is small, the solution beyond the
//! point is that of the step plus a response d, which is small too:
//!
//! ```text
//! y = y_step + d,   d' = J d + g,   d = 0 at the point;   g: change of f at the point, J: of the step's begin
//! ```
//!
//! d is found with the step's own Jacobian by the step's own method, without an evaluation of f. What it is off by is judged twice, in parts of what a step's error may be:
//! by the method's estimates, whose sum over all changes within the step is at most [`MOST_ERROR`]; and, for what J does not know (it is that of the begin, and f is not
//! linear), by d itself, which stays below [`MOST`]: a response that is wrong altogether is then still an error that a step may have. The error that is
//! held against a swing's own size does not count here: it is there for swings that nothing drives.
//!
//! d is added to the step's end when the next step begins, which evaluates f there. Until then all that belongs to the step stays as it was made.

use serde::{Deserialize, Serialize};

/// Vectors that a response needs: coefficients of a cubic polynomial.
pub(super) const VECTORS: usize = 4;
/// Largest response, and sum of the errors of all of a step, in parts of what a step's error may be.
pub(super) const MOST: f64 = 0.5;
pub(super) const MOST_ERROR: f64 = 0.25;

/// Sum of the responses to all changes within the last step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Response {
    /// From when on it is known, s; `None` where there is none.
    since: Option<f64>,
    /// Coefficients in `(time - since) / (end - since)`, one vector after the other, lowest power first.
    powers: Vec<f64>,
    /// Sum of error estimates, in parts of what is allowed.
    pub error: f64,
}

impl Response {
    pub fn new(length: usize) -> Self {
        Response { since: None, powers: vec![0.0; length], error: 0.0 }
    }

    pub fn fits(&self, other: &Response) -> bool {
        self.powers.len() == other.powers.len()
    }

    /// Does the method have responses at all?
    pub fn has_room(&self) -> bool {
        !self.powers.is_empty()
    }

    pub fn is_there(&self) -> bool {
        self.since.is_some()
    }

    pub fn clear(&mut self) {
        (self.since, self.error) = (None, 0.0);
    }

    /// Adds the response at `time` in a step that ends at `end`.
    #[inline]
    pub fn add(&self, time: f64, end: f64, y: &mut [f64]) {
        let Some(since) = self.since else { return };
        let theta = ((time - since) / (end - since)).clamp(0.0, 1.0);
        let [c0, c1, c2, c3] = parts(&self.powers);
        for (i, y) in y.iter_mut().enumerate() {
            *y += c0[i] + theta * (c1[i] + theta * (c2[i] + theta * c3[i]));
        }
    }

    /// Counts the response from `time` on, in a step that ends at `end`: the same polynomial over a shorter time.
    pub fn begin_at(&mut self, time: f64, end: f64) {
        match self.since.replace(time) {
            None => self.powers.fill(0.0),
            Some(since) => {
                let a = (time - since) / (end - since);
                let b = 1.0 - a;
                let [c0, c1, c2, c3] = parts_mut(&mut self.powers);
                for i in 0..c0.len() {
                    let [p, q, r, s] = [c0[i], c1[i], c2[i], c3[i]];
                    c0[i] = p + a * (q + a * (r + a * s));
                    c1[i] = b * (q + a * (2.0 * r + 3.0 * a * s));
                    c2[i] = b * b * (r + 3.0 * a * s);
                    c3[i] = b * b * b * s;
                }
            }
        }
    }

    /// Coefficients beyond the constant one, by power from the first.
    pub fn rising(&mut self) -> std::slice::ChunksExactMut<'_, f64> {
        let count = self.powers.len() / VECTORS;
        self.powers[count..].chunks_exact_mut(count)
    }
}

fn parts(powers: &[f64]) -> [&[f64]; VECTORS] {
    let count = powers.len() / VECTORS;
    std::array::from_fn(|power| &powers[power * count..(power + 1) * count])
}

fn parts_mut(powers: &mut [f64]) -> [&mut [f64]; VECTORS] {
    let count = powers.len() / VECTORS;
    let (low, high) = powers.split_at_mut(2 * count);
    let ((c0, c1), (c2, c3)) = (low.split_at_mut(count), high.split_at_mut(count));
    [c0, c1, c2, c3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_response_goes_on_as_the_same_polynomial() {
        let mut response = Response::new(VECTORS);
        response.begin_at(0.0, 2.0);
        response.rising().zip([0.3, -0.7, 0.2]).for_each(|(power, value)| power[0] = value);
        let at = |response: &Response, time: f64| {
            let mut y = [1.0];
            response.add(time, 2.0, &mut y);
            y[0] - 1.0
        };
        let expected = |time: f64| {
            let theta = 0.5 * time;
            theta * (0.3 + theta * (-0.7 + theta * 0.2))
        };
        for begin in [0.5, 0.6, 1.7] {
            response.begin_at(begin, 2.0);
            for time in [begin, 1.8, 2.0] {
                assert!((at(&response, time) - expected(time)).abs() < 1e-15, "{begin} {time}");
            }
        }
    }
}
