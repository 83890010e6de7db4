//! Random numbers that are the same for the same seed on every machine (ChaCha8).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

pub(super) struct Dice(ChaCha8Rng);

impl Dice {
    pub fn new(seed: u64) -> Dice {
        Dice(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform. 53 bits: every number is exact.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Uniform in its logarithm, rounded to three digits.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        three(self.between(low.ln(), high.ln()).exp())
    }

    /// Uniform, rounded to three digits.
    pub fn flat(&mut self, low: f64, high: f64) -> f64 {
        three(self.between(low, high))
    }

    pub fn chance(&mut self, share: f64) -> bool {
        self.between(0.0, 1.0) < share
    }

    pub fn pick<T: Copy>(&mut self, among: &[T]) -> T {
        among[((self.between(0.0, 1.0) * among.len() as f64) as usize).min(among.len() - 1)]
    }

    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }
}

/// People can read three digits.
fn three(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
