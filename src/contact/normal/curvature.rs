//! Which curvature across the rolling direction enters Hertz's theory, and what is done where the surfaces are conformal.
//!
//! *At the point.* B is half the relative curvature at the contact. Where the radii of a profile jump (60E1: 300, 80, 13 mm)
//! B jumps, and with it the normal force.
//!
//! *Over the patch.* Bodies that overlap by delta without deforming cut each other in a region that tells how large the patch will be
//! (virtual penetration: Kik and Piotrowski 1996; Piotrowski and Chollet, Vehicle System Dynamics 43 (2005) 455; Piotrowski and
//! Kik, VSD 46 (2008) 27; compared with exact theory by Quost et al., VSD 44 (2006) 789). Those methods keep the region's shape; here
//! it only gives the parabola that replaces the gap g(t) of [`super::shape`], by a mean over its depth below the level L:
//!
//! ```text
//! L = 0.9 delta,   b = 15/16 integral of (1 - G/L)^2 dt where G < L,   B = L / b^2
//! ```
//!
//! with G the largest g between the contact and t. For a parabola this is its B; for a circular arc of radius r, B (1 + 0.21 L/r).
//! The integral is over places in space, whatever point between them is called the contact, and g is C1: so is B, also where
//! contact and curvature jump (what quadrature leaves of a kink is measured in the tests). A second place of contact close
//! by joins gradually: G stays close to L behind the ridge between them. b grows with delta, so B grows at most like
//! delta and N at least like delta. The square is what makes the integrand C1; 0.9 was
//! then fitted to half-space solutions for S1002 on 60E1 (docs/model.md): 0.7 instead lowers the force by 5 % where two places
//! of contact join and by 1 % elsewhere.
//!
//! B grows with delta like `d ln B / d ln delta = 1 - 2 d ln b / d ln L`, from the integral of 1 - G/L ([`super::overlap`]); that the
//! nodes of the quadrature move with L is left out, 1e-3 of dN/d delta at most for S1002 on 60E1.
//!
//! *Conformal contact.* Hertz's theory needs B > 0. `error` refuses others; `bounded` (default) keeps B between A / 117 and 117 A, where the
//! ellipse has axes of about 1:20. Within a factor of 2 of a bound the curvature is bent towards it with a C1 parabola, elsewhere it is
//! kept to the bit.

use super::ConformalContact;
use super::overlap::Depths;
use super::shape::ContactShape;
use crate::settings::{Section, SettingsError};

/// Where the curvature across the rolling direction comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Across {
    Point,
    Patch,
    /// B / A is stated.
    Stated(f64),
}

/// What is done with conformal surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Conformal {
    Error,
    Bounded,
}

/// The rule of one law.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    pub across: Across,
    pub conformal: Conformal,
}

/// B [1/m] and d ln B / d ln delta.
#[derive(Clone, Copy, Debug)]
pub(super) struct AcrossUnder {
    pub across: f64,
    pub exponent: f64,
}

/// L / delta.
const SHARE: f64 = 0.9;

/// Largest ratio of the half curvatures, either way, for which `bounded` lets an ellipse be: axes 1:19.95.
pub(super) const LARGEST_RATIO: f64 = 117.0;

/// Gaps are taken at no less than this level [m]: the profiles' rounding is 1e-16 m. The force is then below 10 mN.
const LEAST_LEVEL: f64 = 1e-9;

/// The larger one of `x` and `least`, bent where x is below 2 least so that it is C1: least at x <= 0. And the derivative of its logarithm
/// by that of x.
#[inline]
fn at_least(x: f64, least: f64) -> (f64, f64) {
    if x >= 2.0 * least {
        (x, 1.0)
    } else if x > 0.0 {
        let bent = least + x * x / (4.0 * least);
        (bent, x * x / (2.0 * least * bent))
    } else {
        (least, 0.0)
    }
}

/// The smaller one of `x` and `most`, bent from most / 2 to 3 / 2 most so that it is C1. And its derivative by x.
#[inline]
fn at_most(x: f64, most: f64) -> (f64, f64) {
    if x <= 0.5 * most {
        (x, 1.0)
    } else if x < 1.5 * most {
        let left = 1.5 * most - x;
        (most - left * left / (2.0 * most), left / most)
    } else {
        (most, 0.0)
    }
}

impl Rule {
    /// Does B depend on the penetration?
    #[inline]
    pub fn needs_penetration(&self) -> bool {
        self.across == Across::Patch
    }

    /// B that enters the theory under `penetration` [m].
    #[inline]
    pub fn across(&self, shape: &ContactShape, penetration: f64) -> Result<AcrossUnder, ConformalContact> {
        let found = match self.across {
            Across::Point => AcrossUnder { across: shape.across, exponent: 0.0 },
            Across::Stated(ratio) => return Ok(AcrossUnder { across: ratio * shape.rolling, exponent: 0.0 }),
            Across::Patch => self.over_patch(shape, penetration)?,
        };
        Ok(self.bound(shape.rolling, found))
    }

    /// A guess of [`Rule::across`] without penetration.
    #[inline]
    pub fn guess(&self, shape: &ContactShape) -> f64 {
        let (least, most) = (shape.rolling / LARGEST_RATIO, shape.rolling * LARGEST_RATIO);
        // A spline's curvature at a point may be anything.
        if shape.across > least && shape.across < most { shape.across } else { shape.rolling }
    }

    #[inline]
    fn bound(&self, rolling: f64, found: AcrossUnder) -> AcrossUnder {
        if self.conformal == Conformal::Error {
            return found;
        }
        let (AcrossUnder { across, exponent }, least, most) = (found, rolling / LARGEST_RATIO, rolling * LARGEST_RATIO);
        // From above it is 1 / B, the scale of lengths, that is bent.
        if across > 0.5 * most {
            let (bent, part) = at_least(1.0 / across, 1.0 / most);
            AcrossUnder { across: 1.0 / bent, exponent: exponent * part }
        } else {
            let (bent, part) = at_least(across, least);
            AcrossUnder { across: bent, exponent: exponent * part }
        }
    }

    fn over_patch(&self, shape: &ContactShape, penetration: f64) -> Result<AcrossUnder, ConformalContact> {
        let level = (SHARE * penetration).max(LEAST_LEVEL);
        let widest = (level * LARGEST_RATIO / shape.rolling).sqrt();
        // Half widths of both sides with L times their derivatives.
        let wide = |depths: Depths| (15.0 / 8.0 * depths.x, 15.0 / 4.0 * (depths.y - depths.x));
        let [one, other] = match (self.conformal, shape.overlap(level, 1.5 * widest)) {
            (Conformal::Error, [Some(one), Some(other)]) => [wide(one), wide(other)],
            (Conformal::Error, _) => return Err(ConformalContact { rolling: shape.rolling, across: shape.across }),
            (Conformal::Bounded, sides) => sides.map(|side| {
                let Some(depths) = side else { return (widest, 0.5 * widest) };
                let (width, growth) = wide(depths);
                let (bent, slope) = at_most(width, widest);
                // Twice as large for twice both of its arguments, and the bound grows like the root of L.
                (bent, slope * growth + 0.5 * (bent - slope * width))
            }),
        };
        let half_width = 0.5 * (one.0 + other.0);
        let exponent = if level > LEAST_LEVEL { 1.0 - (one.1 + other.1) / half_width } else { 0.0 };
        Ok(AcrossUnder { across: level / (half_width * half_width), exponent })
    }

    /// For `wheelrail plan`; empty for the default.
    pub fn describe(&self) -> String {
        let across = match self.across {
            Across::Point => "",
            Across::Patch => ", curvature over the patch",
            Across::Stated(_) => ", stated ratio of the semi-axes",
        };
        let conformal = if self.conformal == Conformal::Error { ", conformal contact refused" } else { "" };
        format!("{across}{conformal}")
    }
}

/// Reads `curvature` and `conformal`.
pub(super) fn parse(section: &Section) -> Result<Rule, SettingsError> {
    let across = match section.word_or("curvature", &["point", "patch"], "point")? {
        "patch" => Across::Patch,
        _ => Across::Point,
    };
    let conformal = match section.word_or("conformal", &["error", "bounded"], "bounded")? {
        "error" => Conformal::Error,
        _ => Conformal::Bounded,
    };
    Ok(Rule { across, conformal })
}
