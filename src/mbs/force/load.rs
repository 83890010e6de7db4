//! A constant vertical load, downward positive, on a body's centre: what the rest of a vehicle weighs.
//! It is a pure force: it adds no mass.

use super::ForceElement;
use crate::geometry::track::station::Station;
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::tangent::{Ends, PairTangent};

/// Constant load on one body's centre.
#[derive(Debug, Clone)]
pub struct VerticalLoad {
    pub body: usize,
    /// N, downward positive.
    pub force: f64,
}

impl ForceElement for VerticalLoad {
    fn name(&self) -> &str {
        "vertical load"
    }

    #[inline]
    fn apply(&self, _: &[BodyMotion], _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        wrenches[self.body].force.z -= self.force;
    }

    fn bodies(&self) -> Ends {
        [Some(self.body), None]
    }

    /// Constant.
    fn tangent(&self, _: &[BodyMotion], _: &[Station], _: &[f64], _: usize, _: &mut PairTangent) {}

    fn scalar_force(&self, _: &[BodyMotion], _: &[f64]) -> Option<f64> {
        None
    }

    fn clone_box(&self) -> Box<dyn ForceElement> {
        Box::new(self.clone())
    }

    fn potential_energy(&self, bodies: &[BodyMotion], _: &[f64]) -> f64 {
        self.force * bodies[self.body].position.z
    }

    fn dissipated_power(&self, _: &[BodyMotion], _: &[f64]) -> f64 {
        0.0
    }
}
