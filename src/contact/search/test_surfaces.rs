//! Surfaces for tests of the searches: parabolas as profiles on rails that swing sideways and up.

use super::algebraic::{ContactLocation, Pair, SurfaceParameters};
use crate::geometry::Side;
use crate::geometry::profile::{Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Deviation, DeviationShape, Direction, Rail};
use crate::math::newton::NewtonFailure;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

#[derive(Debug)]
pub struct Parabola {
    pub value: f64,
    pub slope: f64,
    pub curvature: f64,
}
impl Profile for Parabola {
    fn at(&self, x: f64) -> ProfilePoint {
        ProfilePoint {
            value: self.value + x * (self.slope + 0.5 * self.curvature * x),
            d1: self.slope + self.curvature * x,
            d2: self.curvature,
            d3: 0.0,
        }
    }
    fn range(&self) -> (f64, f64) {
        (-1.0, 1.0)
    }
    fn describe(&self) -> String {
        "parabola".into()
    }
}

#[derive(Debug)]
pub struct Wave;
impl DeviationShape for Wave {
    fn at(&self, s: f64) -> [f64; 4] {
        [0.004 * s.sin(), 0.004 * s.cos(), -0.004 * s.sin(), -0.004 * s.cos()]
    }
    fn waves(&self) -> Vec<crate::geometry::track::waves::Stretch> {
        Vec::new()
    }

    fn breaks(&self) -> Vec<f64> {
        vec![]
    }
    fn describe(&self) -> String {
        "wave".into()
    }
}

/// Wheel and rail of one side; the wheel's slope, and whether the rail swings.
pub fn pair(side: Side, slope: f64, wavy: bool) -> (Wheel, Rail) {
    let wheel = Wheel { side, profile: Arc::new(Parabola { value: 0.457, slope: -slope, curvature: -0.3 }), half_spacing: 0.716 };
    let deviation = |direction| Deviation { side, direction, shape: Arc::new(Wave) };
    let deviations = if wavy { vec![deviation(Direction::Lateral), deviation(Direction::Vertical)] } else { vec![] };
    let head = Arc::new(Parabola { value: 0.0, slope: 0.0, curvature: -1.0 / 0.3 });
    (wheel, Rail::new(side, head, 0.716, slope.atan(), &deviations))
}

/// The contact found from the pieces that tests have at hand.
pub fn locate(
    wheel: &Wheel,
    rail: &Rail,
    centre: &Vector3<f64>,
    axes: &Matrix3<f64>,
    distance: f64,
    start: &SurfaceParameters,
) -> Result<ContactLocation, NewtonFailure> {
    Pair { wheel, rail, centre, axes, distance }.locate(start)
}
