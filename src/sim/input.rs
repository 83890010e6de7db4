//! Inputs as polynomials in time.

use serde::{Deserialize, Serialize};

/// `value + first (t - since) + second (t - since)^2 / 2`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputSignal {
    /// s.
    pub since: f64,
    pub value: f64,
    /// First and second derivative, per s and per s2.
    pub first: f64,
    pub second: f64,
}

impl InputSignal {
    pub fn constant(since: f64, value: f64) -> Self {
        InputSignal { since, value, first: 0.0, second: 0.0 }
    }

    /// Value, first and second derivative at time `t`.
    #[inline]
    pub fn at(&self, t: f64) -> [f64; 3] {
        let dt = t - self.since;
        [self.value + dt * (self.first + 0.5 * dt * self.second), self.first + dt * self.second, self.second]
    }
}

/// Values of all inputs at time `t`.
#[inline]
pub fn evaluate(signals: &[InputSignal], t: f64, values: &mut [f64]) {
    for (value, signal) in values.iter_mut().zip(signals) {
        *value = signal.at(t)[0];
    }
}
