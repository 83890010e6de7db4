//! Weight: `F = -m g (sin(grade) X + cos(grade) Z)` at the centre, in a track frame that climbs with `grade`.

use super::ForceElement;
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::Numbered;

/// Weight of one body.
#[derive(Debug, Clone)]
pub struct Gravity {
    pub body: usize,
    /// kg.
    pub mass: f64,
    /// g, m/s2.
    pub acceleration: f64,
    /// Of the track, rad, climbing positive.
    pub grade: f64,
}

impl Numbered for Gravity {}

impl ForceElement for Gravity {
    fn name(&self) -> &str {
        "gravity"
    }

    fn is_dissipative(&self) -> bool {
        false
    }

    #[inline]
    fn apply(&self, _: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let weight = self.mass * self.acceleration;
        wrenches[self.body].force.x -= weight * self.grade.sin();
        wrenches[self.body].force.z -= weight * self.grade.cos();
    }

    fn bodies(&self) -> Ends {
        [Some(self.body), None]
    }

    /// Constant.
    fn tangent(&self, _: &Moving, _: &[f64], _: usize, _: &mut PairTangent) {}

    fn potential_energy(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let position = &bodies[self.body].position;
        self.mass * self.acceleration * (position.x * self.grade.sin() + position.z * self.grade.cos())
    }

    fn dissipated_power(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }
}
