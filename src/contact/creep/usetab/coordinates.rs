//! Bounded coordinates of the table.
//!
//! Kalker's linear forces over the friction bound are the natural size of the creepages:
//!
//! ```text
//! X = G a b c11 xi / (mu N),   Y = G a b c22 eta / (mu N),   Z = k G (a b)^1.5 c23 phi / (mu N)
//! ```
//!
//! with `k = 1.2 + 0.7 b/a`, by which Z too reaches full slip at about 1 to 3 for every shape. The whole space of (X, Y, Z)
//! then becomes the unit ball: `u = (X, Y, Z) / (1 + rho)`, `rho = |(X, Y, Z)|`. Its surface is sliding without
//! elasticity, where only the ratios of the creepages matter.

use crate::contact::creep::kalker::Coefficients;
use std::f64::consts::PI;

/// Three coordinates, or a force along e1, e2 in mu N and a moment in mu N sqrt(a b).
pub(crate) type Triple = [f64; 3];

/// Smallest and largest a/b of the table, as in Kalker's own.
pub(crate) const RATIOS: (f64, f64) = (0.1, 10.0);

/// The k above; `a_over_b` within the table.
#[inline]
pub(crate) fn spin_weight(a_over_b: f64) -> f64 {
    1.2 + 0.7 / a_over_b
}

/// (X, Y, Z) over the dimensionless creepages of [`super::super::exact`].
pub(crate) fn scales(c: Coefficients, a_over_b: f64) -> Triple {
    [c.c11, c.c22, spin_weight(a_over_b) * c.c23].map(|c| 1.5 / PI * c)
}

#[inline]
pub(crate) fn size(v: Triple) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// From the whole space into the ball.
#[inline]
pub(crate) fn bounded(v: Triple) -> Triple {
    // Far out nothing changes any more; the limit keeps the square finite.
    let v = v.map(|v| v.clamp(-1e9, 1e9));
    let factor = 1.0 / (1.0 + size(v));
    v.map(|v| v * factor)
}

/// From the ball into the whole space; its surface to a very large radius.
pub(crate) fn unbounded(u: Triple) -> Triple {
    let factor = 1.0 / (1.0 - size(u)).max(1e-5);
    u.map(|u| u * factor)
}
