//! Small motions in a constant curve: seen from a frame that turns with the vehicle.
//!
//! On a constant curve, cant and climb, all places are alike: moved along the track by the angle `a` about the vertical through the curve's centre c, a motion is a motion
//! still. In steady running all bodies turn about it with the rate w, so that in axes that do so too
//!
//! ```text
//! p' = v - w Z x (p - c),    v' = a - w Z x v,    yaw' = yaw_rate - w
//! ```
//!
//! vanish (but for a climb), and slopes about that state have constant coefficients as those of straight track have. Only positions and velocities are vectors; all other states are seen from the
//! bodies or the track. In place of the travel along x there is that of the whole about c, on which nothing depends; the imposed speed `v . X = V` fixes a
//! velocity, and no distance: a driven wheelset further out takes longer.

use crate::mbs::body::{COORDINATES, YAW};
use nalgebra::Vector3;

/// Turns slower than this are none, rad/s.
const STRAIGHT: f64 = 1e-9;

/// The turn of a steady motion.
#[derive(Clone, Debug)]
pub(super) struct Turning {
    /// w, rad/s.
    rate: f64,
    bodies: usize,
    /// The steady state.
    y: Vec<f64>,
}

impl Turning {
    /// Of a steady state; `None` where it does not turn.
    pub fn of(bodies: usize, y: &[f64]) -> Option<Turning> {
        let rate = *y.get(COORDINATES * bodies + YAW)?;
        (rate.abs() > STRAIGHT).then(|| Turning { rate, bodies, y: y.to_vec() })
    }

    fn count(&self) -> usize {
        COORDINATES * self.bodies
    }

    /// Takes what the frame does off the rates of a state.
    pub fn take_off(&self, y: &[f64], rates: &mut [f64]) {
        for first in (0..2 * self.count()).step_by(COORDINATES) {
            // Of positions what has changed, which leaves the steady velocities.
            let from = |axis: usize| if first < self.count() { self.y[first + axis] } else { 0.0 };
            let [x, along] = [y[first] - from(0), y[first + 1] - from(1)];
            rates[first] += self.rate * along;
            rates[first + 1] -= self.rate * x;
        }
    }

    /// A body's velocity, m/s.
    fn velocity(&self, body: usize) -> Vector3<f64> {
        let first = self.count() + COORDINATES * body;
        Vector3::from_column_slice(&self.y[first..first + 3])
    }

    /// The velocity along a body's way, as a sum of parts of the state.
    pub fn along(&self, body: usize) -> [(usize, f64); 3] {
        let (first, way) = (self.count() + COORDINATES * body, self.velocity(body).normalize());
        [0, 1, 2].map(|axis| (first + axis, way[axis]))
    }

    /// How all states change while the first body travels one metre.
    pub fn travel(&self) -> Vec<(usize, f64)> {
        let count = self.count();
        let speed = self.y[count].hypot(self.y[count + 1]);
        let mut parts = Vec::new();
        for first in (0..count).step_by(COORDINATES) {
            let [x, y, z] = [0, 1, 2].map(|axis| self.y[count + first + axis]);
            parts.extend([(first, x), (first + 1, y), (first + 2, z), (first + YAW, self.rate)]);
            parts.extend([(count + first, -self.rate * y), (count + first + 1, self.rate * x)]);
        }
        parts.into_iter().map(|(state, part)| (state, part / speed)).collect()
    }

    /// The steady state after the first body has travelled so far, m.
    pub fn travelled(&self, distance: f64) -> Vec<f64> {
        let count = self.count();
        let mut moved = self.y.clone();
        let time = distance / self.y[count].hypot(self.y[count + 1]);
        let (sin, cos) = (self.rate * time).sin_cos();
        for first in (0..count).step_by(COORDINATES) {
            let [x, y, z] = [0, 1, 2].map(|axis| self.y[count + first + axis]);
            // Chord and sagitta: the integral of the turned velocity.
            let half = (0.5 * self.rate * time).sin();
            let [along, aside] = [sin / self.rate, 2.0 * half * half / self.rate];
            moved[first] += x * along - y * aside;
            moved[first + 1] += y * along + x * aside;
            moved[first + 2] += z * time;
            moved[first + YAW] += self.rate * time;
            (moved[count + first], moved[count + first + 1]) = (x * cos - y * sin, y * cos + x * sin);
        }
        moved
    }

    /// Turns vectors of positions and velocities into the bodies' courses: along them, and across.
    pub fn onto_courses<T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>>(&self, states: &mut [T]) {
        for body in 0..self.bodies {
            let course = self.velocity(body).xy().normalize();
            let (cos, sin) = (course.x, course.y);
            for first in [COORDINATES * body, self.count() + COORDINATES * body] {
                let [x, y] = [states[first], states[first + 1]];
                (states[first], states[first + 1]) = (x * cos + y * sin, y * cos + x * -sin);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two bodies on a circle of 100 m at 20 m/s, their rates those of the circle.
    #[test]
    fn analytic_a_circle_is_at_rest_in_its_frame() {
        let (radius, rate) = (100.0, 0.2);
        let state = |angle: f64| {
            let mut y = vec![0.0; 24];
            for (body, own) in [angle, angle - 0.05].into_iter().enumerate() {
                let ((sin, cos), first) = (own.sin_cos(), COORDINATES * body);
                (y[first], y[first + 1], y[first + YAW]) = (radius * sin, radius * (1.0 - cos), own);
                (y[12 + first], y[13 + first], y[12 + first + YAW]) = (radius * rate * cos, radius * rate * sin, rate);
            }
            y
        };
        let rates = |y: &[f64]| {
            let mut rates = y[12..].to_vec();
            rates.extend([12, 18].into_iter().flat_map(|first| [-rate * y[first + 1], rate * y[first], 0.0, 0.0, 0.0, 0.0]));
            rates
        };
        let turning = Turning::of(2, &state(0.3)).unwrap();
        let later = turning.travelled(2.5);
        assert!(later.iter().zip(state(0.3 + 0.025)).all(|(found, expected)| (found - expected).abs() < 1e-12));
        let [mut here, mut there] = [state(0.3), later.clone()].map(|y| rates(&y));
        turning.take_off(&state(0.3), &mut here);
        turning.take_off(&later, &mut there);
        assert!(
            here.iter().zip(&there).all(|(here, there)| (here - there).abs() < 1e-12) && here[12..].iter().all(|rate| rate.abs() < 1e-12)
        );
        let small = turning.travelled(1e-6);
        for (state, part) in turning.travel() {
            assert!(((small[state] - turning.y[state]) / 1e-6 - part).abs() < 1e-6, "{state}");
        }
        let mut velocities = state(0.3);
        turning.onto_courses(&mut velocities);
        assert!((velocities[12] - 20.0).abs() < 1e-12 && velocities[13].abs() < 1e-12 && (velocities[18] - 20.0).abs() < 1e-12);
        assert!(Turning::of(1, &[0.0; 12]).is_none());
    }
}
