//! How far a quantity swings about its slow mean at present.

use serde::{Deserialize, Serialize};

/// Mean and envelope of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    pub mean: f64,
    pub amplitude: f64,
}

impl Envelope {
    /// Takes the next value; `fading` is the part of itself by which mean and envelope go to it, `first` where there was none before.
    pub fn note(&mut self, now: f64, fading: f64, first: bool) {
        if first {
            *self = Envelope { mean: now, amplitude: 0.0 };
        }
        self.mean += fading * (now - self.mean);
        self.amplitude = ((1.0 - fading) * self.amplitude).max((now - self.mean).abs());
    }
}
