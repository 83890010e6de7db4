//! Inputs as polynomials in time.

use super::{Simulation, SimulationState};
use crate::formulation::inputs::{WANTED_RATE, WANTED_SPEED};
use crate::formulation::{Cached, Model};
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

    /// Is `other`, set at time `t`, what this polynomial comes to there? Whoever sets the points of a polynomial has other rounding; a constant is the same or
    /// another one.
    pub fn goes_on_as(&self, other: &InputSignal, t: f64) -> bool {
        let ([value, first, second], [wanted, slope, bend]) = (self.at(t), other.at(t));
        if slope == 0.0 && bend == 0.0 {
            return [value, first, second] == [wanted, slope, bend];
        }
        let sizes = [wanted.abs() + t.abs() * (slope.abs() + t.abs() * bend.abs()), slope.abs() + t.abs() * bend.abs(), bend.abs()];
        let apart = [value - wanted, first - slope, second - bend];
        apart.iter().zip(sizes).all(|(apart, size)| apart.abs() <= ROUNDING * size)
    }

    /// Value, first and second derivative at time `t`.
    #[inline]
    pub fn at(&self, t: f64) -> [f64; 3] {
        let dt = t - self.since;
        [self.value + dt * (self.first + 0.5 * dt * self.second), self.first + dt * self.second, self.second]
    }
}

/// By how much of its size a number that is set may be off.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Values of all inputs of the model at time `t`. The acceleration that a wanted speed goes with has the slope of that speed in it.
#[inline]
pub fn evaluate(model: &Model, signals: &[InputSignal], t: f64, values: &mut [f64]) {
    for (value, signal) in values.iter_mut().zip(signals) {
        *value = signal.at(t)[0];
    }
    if let Some(first) = model.first_travel_input(signals.len()) {
        values[first + WANTED_RATE] += signals[first + WANTED_SPEED].at(t)[1];
    }
}

impl Simulation {
    /// Sets an input from now on to `value + first (t - now) + second (t - now)^2 / 2`. When that is a change, the integration restarts here as it goes on, or its
    /// step in hand takes the change up (`taking_up`); a polynomial that comes to just that, to rounding, is followed further.
    pub fn set_input(&mut self, index: usize, value: f64, first: f64, second: f64) {
        let signal = InputSignal { since: self.state.time, value, first, second };
        if self.state.inputs[index].at(self.state.time) != signal.at(self.state.time) {
            self.state.inputs[index] = signal;
            self.known = None;
        }
    }

    /// Has an input been set to what the integration does not come to by itself?
    pub(super) fn turns(&self) -> bool {
        let SimulationState { time, inputs, followed, .. } = &self.state;
        followed.iter().zip(inputs).any(|(followed, set)| !followed.goes_on_as(set, *time))
    }

    /// Lets the integration follow the inputs that were set.
    pub(super) fn follow_inputs(&mut self) {
        let turns = self.turns();
        let taken_up = turns && self.take_up();
        let SimulationState { time, inputs, followed, .. } = &mut self.state;
        for (followed, set) in followed.iter_mut().zip(inputs) {
            if followed.goes_on_as(set, *time) {
                *set = *followed;
            } else {
                *followed = *set;
            }
        }
        if turns && !taken_up {
            self.restart();
            self.workspace.cached = Cached::No;
        }
    }

    /// The integration starts anew from the present time. What means noted at the end of the step in hand, beyond it, does not take place.
    pub(super) fn restart(&mut self) {
        let SimulationState { time, integration, frame, memories, .. } = &mut self.state;
        integration.restart_at(*time, |ahead, y| self.model.add_frame_motion(frame, ahead, y));
        self.model.note_means(*time, &integration.y, &mut memories.accepted);
    }

    /// Value and derivatives of an input now.
    pub fn input(&self, index: usize) -> [f64; 3] {
        self.state.inputs[index].at(self.state.time)
    }
}
