//! The extremes of coordinates between two passages.

/// Halvings of a step in which a time is found.
const HALVINGS: usize = 50;

/// Those of some coordinates; their velocities stand `ahead` states later.
pub(super) struct Extremes<'a> {
    states: &'a [usize],
    ahead: usize,
    least: Vec<f64>,
    most: Vec<f64>,
}

impl<'a> Extremes<'a> {
    pub fn new(states: &'a [usize], ahead: usize) -> Self {
        Extremes { states, ahead, least: vec![0.0; states.len()], most: vec![0.0; states.len()] }
    }

    /// Begins anew at a solution.
    pub fn begin(&mut self, y: &[f64]) {
        self.states.iter().enumerate().for_each(|(k, state)| (self.least[k], self.most[k]) = (y[*state], y[*state]));
    }

    fn note(&mut self, k: usize, value: f64) {
        self.least[k] = self.least[k].min(value);
        self.most[k] = self.most[k].max(value);
    }

    /// A step between two solutions: its end, and where a velocity changes its sign within it.
    pub fn see(&mut self, last: &[f64], y: &[f64], (begin, end): (f64, f64), solution: impl Fn(f64, &mut [f64])) {
        for (k, state) in self.states.iter().enumerate() {
            self.note(k, y[*state]);
            let velocity = state + self.ahead;
            if last[velocity] * y[velocity] < 0.0 {
                let mut at = vec![0.0; y.len()];
                let time = bisect(begin, end, |time| {
                    solution(time, &mut at);
                    at[velocity] * last[velocity] > 0.0
                });
                solution(time, &mut at);
                self.note(k, at[*state]);
            }
        }
    }

    /// Half the way between them.
    pub fn take(&self) -> Vec<f64> {
        self.least.iter().zip(&self.most).map(|(least, most)| 0.5 * (most - least)).collect()
    }
}

/// The time from which on `before` no longer holds.
pub(super) fn bisect(mut from: f64, mut to: f64, mut before: impl FnMut(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if before(middle) {
            from = middle;
        } else {
            to = middle;
        }
    }
    0.5 * (from + to)
}
