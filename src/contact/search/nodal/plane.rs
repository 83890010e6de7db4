//! The rail's section as one wheel's nodes come into it.

use crate::contact::search::nodes::Bounds;
use crate::geometry::profile::ProfilePoint;

/// Largest `(k R')^2` with which nodes are passed over: beyond, a yawed steep flank moves too fast along u.
const TURNED: f64 = 0.5;

/// How the wheel's nodes come into the rail's section in one pose.
#[derive(Clone, Copy)]
pub struct Section {
    /// k and k^2.
    pub turn: f64,
    pub turn2: f64,
    /// (eta, h) of Q, of the axle's outward direction, of the direction of angle b.
    pub base: (f64, f64),
    pub axle: (f64, f64),
    pub down: (f64, f64),
    /// b, rad.
    pub angle: f64,
    /// Part of the rail's normal along the section's normal, when its part along p is 1: `lean.0 + lean.1 f'`.
    pub lean: (f64, f64),
}

/// `factor * x` for x between two bounds.
#[inline]
fn interval(factor: f64, x: (f64, f64)) -> (f64, f64) {
    let (a, b) = (factor * x.0, factor * x.1);
    if a < b { (a, b) } else { (b, a) }
}

impl Section {
    /// N^2.
    #[inline]
    pub fn norm2(&self, slope: f64) -> f64 {
        let lean = self.lean.0 + self.lean.1 * slope;
        1.0 + slope * slope + lean * lean
    }

    /// (eta, h) of a point `R(u)` with slope `R'`; `None` where no point of the circle has its normal in the section.
    #[inline]
    pub fn place(&self, u: f64, radius: f64, slope: f64) -> Option<(f64, f64)> {
        let lever = radius * slope;
        let across = u - self.turn2 * lever;
        let under = radius * radius - self.turn2 * lever * lever;
        let down = under.sqrt();
        let (base, axle, inward) = (self.base, self.axle, self.down);
        (under > 0.0).then_some((base.0 + axle.0 * across + inward.0 * down, base.1 + axle.1 * across + inward.1 * down))
    }

    /// Derivatives of (eta, h) of [`Section::place`] by u.
    #[inline]
    pub fn moves(&self, wheel: &ProfilePoint) -> (f64, f64) {
        let ProfilePoint { value: radius, d1: slope, d2: bend, .. } = *wheel;
        let (lever, by) = (radius * slope, slope * slope + radius * bend);
        let across = 1.0 - self.turn2 * by;
        let down = (lever - self.turn2 * lever * by) / (radius * radius - self.turn2 * lever * lever).sqrt();
        (self.axle.0 * across + self.down.0 * down, self.axle.1 * across + self.down.1 * down)
    }

    /// Least and greatest changes of `u - k^2 R R'` and of `sqrt(R^2 - (k R R')^2)` per spacing, -; `None` when the
    /// wheel is too steep for its yaw.
    ///
    /// The second is `(R + R_next) / (sum of roots) * slope - k^2 (sum of R R') / (sum of roots) * bend`, and each root
    /// is at least `R sqrt(1 - (k R')^2)`.
    #[inline]
    pub fn steps(&self, wheel: &Bounds) -> Option<Steps> {
        let turned = self.turn2 * wheel.steepest * wheel.steepest;
        if !(turned < TURNED) {
            return None;
        }
        let stretched = 1.0 / (1.0 - turned).sqrt();
        let bend = self.turn2 * wheel.bend;
        let slack = bend * wheel.steepest * stretched;
        Some(Steps {
            across: (1.0 - bend, 1.0 + bend),
            down: (wheel.lowest.min(wheel.lowest * stretched) - slack, wheel.highest.max(wheel.highest * stretched) + slack),
        })
    }

    /// Least and greatest change of eta per spacing, -.
    #[inline]
    pub fn drift(&self, steps: &Steps) -> (f64, f64) {
        let (across, down) = (interval(self.axle.0, steps.across), interval(self.down.0, steps.down));
        (across.0 + down.0, across.1 + down.1)
    }

    /// D: the most by which G falls per spacing, -, apart from the misfit of the tangents. The rail's height changes by
    /// slope times the change of eta, so what is left is linear in that slope and in both steps: the least is at a
    /// corner.
    #[inline]
    pub fn fall(&self, steps: &Steps, rail: &Bounds) -> f64 {
        let rise = |slope: f64| {
            interval(self.axle.1 - slope * self.axle.0, steps.across).0 + interval(self.down.1 - slope * self.down.0, steps.down).0
        };
        -rise(rail.lowest).min(rise(rail.highest))
    }
}

/// Changes from a wheel node to the next, per spacing, -.
#[derive(Clone, Copy)]
pub struct Steps {
    across: (f64, f64),
    down: (f64, f64),
}
