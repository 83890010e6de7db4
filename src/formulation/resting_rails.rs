//! How far a rail that gives way is moved next while it is looked for where it rests under a wheel.
//!
//! Broyden's method in the two directions across the rail: the first slope is that of the contact's elastic force with what creep forces follow, and each move
//! tells how the rest has really changed. With the first slope alone what is left falls by a tenth to a half in each round where a flange carries, or not at all.

use nalgebra::{Matrix2, Vector2};

/// Corrections of rails at rest below this are none, m, and how often they are tried.
pub(super) const SETTLED: f64 = 1e-13;
pub(super) const ROUNDS: usize = 100;
/// Farthest that a rail is moved in one of them, m.
const FARTHEST: f64 = 1e-3;

/// One rail under its wheel.
#[derive(Clone, Copy, Default)]
pub(super) struct RestingRail {
    /// Change of the rest with the rail's place, N/m.
    slope: Matrix2<f64>,
    /// The least rest so far, N; where the rail is beside the place of that, and how far it may go from there, m.
    best: Option<Vector2<f64>>,
    aside: Vector2<f64>,
    radius: f64,
}

impl RestingRail {
    /// The next move [m] from the force that is left over [N]; `slope` [N/m] is the first one. A move that has left more is taken back, and a shorter one tried.
    pub fn next_move(&mut self, rest: Vector2<f64>, slope: impl FnOnce() -> Matrix2<f64>) -> Vector2<f64> {
        let mut back = Vector2::zeros();
        match self.best {
            None => (self.slope, self.best, self.radius) = (slope(), Some(rest), FARTHEST),
            Some(best) => {
                let (moved, length) = (self.aside, self.aside.norm());
                if length > 0.0 {
                    let missed = rest - best - self.slope * moved;
                    self.slope += missed * moved.transpose() / (length * length);
                }
                if rest.norm() < best.norm() {
                    (self.best, self.radius) = (Some(rest), FARTHEST.min(2.0 * self.radius));
                } else {
                    (back, self.radius) = (-moved, 0.5 * length);
                }
            }
        }
        let best = self.best.unwrap_or(rest);
        let way = self.slope.try_inverse().map_or(Vector2::zeros(), |inverse| -(inverse * best));
        let length = way.norm();
        self.aside = if length > self.radius { way * (self.radius / length) } else { way };
        back + self.aside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_rest_that_a_poor_slope_does_not_know_is_found() {
        // A stiff direction 60 degrees out of the vertical, of which the first slope has half.
        let normal = Vector2::new(0.87, 0.5);
        let force = |place: &Vector2<f64>| -> Vector2<f64> {
            let sunk = (5e-5 - normal.dot(place)).max(0.0);
            Vector2::new(2e7 * place.x, 5e7 * place.y) - normal * (1e11 * sunk.powf(1.5)) + Vector2::new(0.3 * 1e11 * sunk.powf(1.5), 0.0)
        };
        let (mut rail, mut place, mut rounds) = (RestingRail::default(), Vector2::zeros(), 0);
        loop {
            let slope = || Matrix2::new(2e7, 0.0, 0.0, 5e7) + normal * normal.transpose() * (0.5 * 1.5e11 * 5e-5f64.sqrt());
            let moved = rail.next_move(force(&place), slope);
            if moved.amax() < SETTLED {
                break;
            }
            (place, rounds) = (place + moved, rounds + 1);
            assert!(rounds < 20, "{place:?}");
        }
        assert!(force(&place).norm() < 1e-3, "{:?} after {rounds}", force(&place));
    }
}
