//! A coordinate or a speed as a law of time.

use std::sync::Arc;

/// A law of time: value, first and second derivative.
#[derive(Clone)]
pub struct Prescribed(Arc<dyn Fn(f64) -> [f64; 3] + Send + Sync>);

impl Prescribed {
    /// From a function of time [s].
    pub fn new(law: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static) -> Self {
        Prescribed(Arc::new(law))
    }

    /// `start + speed t`.
    pub fn uniform(start: f64, speed: f64) -> Self {
        Self::new(move |t| [start + speed * t, speed, 0.0])
    }

    pub fn at(&self, t: f64) -> [f64; 3] {
        (self.0)(t)
    }
}

impl std::fmt::Debug for Prescribed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Prescribed(t = 0: {:?})", self.at(0.0))
    }
}
