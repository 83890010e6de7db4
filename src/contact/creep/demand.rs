//! What the linear theory asks for, as a share of what friction can give.
//!
//! ```text
//! x = G a b c11 xi_x / (mu N),   y = G a b c22 xi_y / (mu N),   s = G (a b)^1.5 c23 phi / (mu N)
//! ```
//!
//! Steady laws without memory depend on the creepages, the load and the size of the patch only through these three numbers
//! and the shape of the patch. Near 0 there is hardly any slip; far above 1 the patch slides.

use super::kalker::LinearTheory;
use crate::contact::Patch;
use crate::contact::creepage::Creepage;

/// Linear forces over the friction bound, signs of the creepages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Demand {
    pub longitudinal: f64,
    pub lateral: f64,
    /// Lateral force of spin.
    pub spin: f64,
    /// b / a.
    pub width: f64,
}

/// Below this bound, N, there is no force: it could not be told from zero and its inverse would overflow.
const LEAST_BOUND: f64 = 1e-12;
/// Larger shares are full sliding to all digits; their squares must stay finite.
const MOST: f64 = 1e30;
/// Smaller shares are none: squares of them vanish, and strips would be taken to slide.
const LEAST: f64 = 1e-140;

impl Demand {
    /// `None` where there is no force: empty patch, no load, no friction, no creepage. `bound` is mu N.
    #[inline]
    pub fn new(theory: &LinearTheory, patch: Patch, creepage: Creepage, bound: f64) -> Option<Self> {
        if !(patch.a > 0.0 && patch.b > 0.0 && bound > LEAST_BOUND) {
            return None;
        }
        let c = theory.coefficients(patch);
        let area = patch.a * patch.b;
        let stiffness = theory.shear_modulus() * area / bound;
        let share = |value: f64| (stiffness * value).clamp(-MOST, MOST);
        let demand = Demand {
            longitudinal: share(c.c11 * creepage.longitudinal),
            lateral: share(c.c22 * creepage.lateral),
            spin: share(c.c23 * area.sqrt() * creepage.spin),
            width: patch.b / patch.a,
        };
        let size = demand.longitudinal.abs() + demand.lateral.abs() + demand.spin.abs();
        if size < LEAST { None } else { Some(demand) }
    }
}
