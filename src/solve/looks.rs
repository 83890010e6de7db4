//! Event functions where f was evaluated within a step: does one of them fall below zero between the step's ends?
//!
//! A stage may lie beyond an event that the end of the step does not show. And an event function may dip below zero between two stages: a wheel
//! on a rigid rail feels nothing of a dip but its normal force, and steps are as long as a quarter of the rail's wave. A parabola through each three
//! neighbouring values tells where that may be; the continuous output decides.

use super::Implicit;

/// Looks in a step: its begin, its end and the stages of the longest method.
const MOST: usize = 9;

#[derive(Clone, Debug)]
pub(super) struct Looks {
    /// Event functions at the last look.
    pub values: Vec<f64>,
    /// Times [s] and values of all looks of this attempt, in the order of time.
    times: [f64; MOST],
    seen: [Vec<f64>; MOST],
    count: usize,
    /// The first time at which the system would have changed its form.
    beyond: Option<f64>,
}

impl Looks {
    pub fn new(functions: usize) -> Self {
        let none = || vec![f64::INFINITY; functions];
        Looks { values: none(), times: [0.0; MOST], seen: std::array::from_fn(|_| none()), count: 0, beyond: None }
    }

    /// Does the system have no event functions?
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// A new attempt begins at `t`, in the state that was accepted last.
    pub fn begin(&mut self, dynamics: &dyn Implicit, t: f64) {
        (self.count, self.beyond) = (0, None);
        dynamics.event_values(&mut self.values);
        self.keep(t);
    }

    /// Looks at a stage that was evaluated last, at time `t`.
    #[inline]
    pub fn stage(&mut self, dynamics: &dyn Implicit, t: f64) {
        if self.at(dynamics) {
            self.beyond = Some(self.beyond.map_or(t, |before| before.min(t)));
        }
        self.keep(t);
    }

    /// Looks at the end of the step, which was evaluated last. Does it lie beyond an event?
    pub fn end(&mut self, dynamics: &dyn Implicit, t: f64) -> bool {
        let beyond = self.at(dynamics);
        self.keep(t);
        beyond
    }

    /// Looks at what was evaluated last. Does it lie beyond an event?
    pub fn at(&mut self, dynamics: &dyn Implicit) -> bool {
        dynamics.event_values(&mut self.values);
        self.values.iter().any(|value| *value < 0.0)
    }

    fn keep(&mut self, t: f64) {
        if self.is_empty() || self.count == MOST {
            return;
        }
        let place = self.times[..self.count].partition_point(|before| *before <= t);
        self.times[place..=self.count].rotate_right(1);
        self.seen[place..=self.count].rotate_right(1);
        self.times[place] = t;
        self.seen[place].copy_from_slice(&self.values);
        self.count += 1;
    }

    /// Where a step that ends on this side of all events should be looked at once more, s.
    pub fn doubt(&mut self) -> Option<f64> {
        if let Some(time) = self.beyond.take() {
            return Some(time);
        }
        let (times, seen) = (&self.times[..self.count], &self.seen[..self.count]);
        let mut deepest: Option<(f64, f64)> = None;
        for (times, seen) in times.windows(3).zip(seen.windows(3)) {
            for ((before, here), after) in seen[0].iter().zip(&seen[1]).zip(&seen[2]) {
                let values = [*before, *here, *after];
                let found = dip([times[0], times[1], times[2]], values).map(|(time, depth)| (time, depth / values[1]));
                deepest = match (deepest, found) {
                    (Some(known), Some(found)) if found.1 >= known.1 => Some(known),
                    (known, None) => known,
                    (_, found) => found,
                };
            }
        }
        deepest.map(|(time, _)| time)
    }
}

/// Place and least value of the parabola through three points, where that is below zero between them although they are not.
fn dip(t: [f64; 3], v: [f64; 3]) -> Option<(f64, f64)> {
    let slopes = [(v[1] - v[0]) / (t[1] - t[0]), (v[2] - v[1]) / (t[2] - t[1])];
    let bend = (slopes[1] - slopes[0]) / (t[2] - t[0]);
    // v1 + slope s + bend s^2 with s = t - t1.
    let slope = slopes[0] + bend * (t[1] - t[0]);
    let (ahead, least) = (-0.5 * slope / bend, v[1] - 0.25 * slope * slope / bend);
    let convex = bend > 0.0 && bend.is_finite();
    (convex && v[1] > 0.0 && least < 0.0 && ahead > t[0] - t[1] && ahead < t[2] - t[1]).then_some((t[1] + ahead, least))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_dips_are_found_where_they_are() {
        // (t - 0.4)^2 - 0.01 is below zero from 0.3 to 0.5, between the points.
        let value = |t: f64| (t - 0.4).powi(2) - 0.01;
        let (time, least) = dip([0.0, 0.2, 0.6], [value(0.0), value(0.2), value(0.6)]).unwrap();
        assert!((time - 0.4).abs() < 1e-14 && (least + 0.01).abs() < 1e-14, "{time} {least}");
        // A dip above zero, a bulge, a line, one that lies outside and values that are none say nothing.
        assert!(dip([0.0, 0.2, 0.6], [1.0, 0.9, 1.0]).is_none() && dip([0.0, 0.2, 0.6], [0.1, 1.0, 0.1]).is_none());
        assert!(dip([0.0, 0.2, 0.6], [3.0, 2.0, 0.0]).is_none() && dip([0.0, 0.1, 0.2], [9.0, 4.0, 1.0]).is_none());
        assert!(dip([0.0, 0.2, 0.6], [f64::INFINITY; 3]).is_none() && dip([0.0, 0.0, 0.6], [1.0, 1.0, 1.0]).is_none());
    }
}
