//! Weight: `F = -m g Z` at the centre.

use super::ForceElement;
use crate::mbs::body::{BodyMotion, Wrench};

/// Weight of one body.
#[derive(Debug, Clone)]
pub struct Gravity {
    pub body: usize,
    /// kg.
    pub mass: f64,
    /// g, m/s2.
    pub acceleration: f64,
}

impl ForceElement for Gravity {
    fn name(&self) -> &str {
        "gravity"
    }

    #[inline]
    fn apply(&self, _: &[BodyMotion], wrenches: &mut [Wrench]) {
        wrenches[self.body].force.z -= self.mass * self.acceleration;
    }

    fn scalar_force(&self, _: &[BodyMotion]) -> Option<f64> {
        None
    }

    fn clone_box(&self) -> Box<dyn ForceElement> {
        Box::new(self.clone())
    }

    fn potential_energy(&self, bodies: &[BodyMotion]) -> f64 {
        self.mass * self.acceleration * bodies[self.body].position.z
    }

    fn dissipated_power(&self, _: &[BodyMotion]) -> f64 {
        0.0
    }
}
