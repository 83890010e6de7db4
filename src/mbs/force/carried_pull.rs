//! A constant force along the track on a body's centre, from outside: what goes along with the mass that a body carries of parts that are cut away (`vehicle.detail`).
//!
//! Parts that are gone push and pull what stays by the forces of the whole vehicle's steady motion ([`super::Held`]), in which their own mass M has the acceleration a. M goes along
//! the track with what stays, and would take M a from it once more: `F = M a X`.

use super::ForceElement;
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::Numbered;

/// A force along X on one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarriedPull {
    pub body: usize,
    /// N.
    pub force: f64,
}

impl Numbered for CarriedPull {}

impl ForceElement for CarriedPull {
    fn name(&self) -> &str {
        "along track"
    }

    fn supplied_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        self.force * bodies[self.body].velocity.x
    }

    fn is_supplied(&self) -> bool {
        true
    }

    fn is_dissipative(&self) -> bool {
        false
    }

    #[inline]
    fn apply(&self, _: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        wrenches[self.body].force.x += self.force;
    }

    fn bodies(&self) -> Ends {
        [Some(self.body), None]
    }

    /// Constant.
    fn tangent(&self, _: &Moving, _: &[f64], _: usize, _: &mut PairTangent) {}

    /// It comes from outside.
    fn potential_energy(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }

    fn dissipated_power(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }
}
