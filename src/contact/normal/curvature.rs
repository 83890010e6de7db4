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
//! *Conformal contact.* Hertz's theory needs B > 0. `error` refuses others; `bounded` keeps B between A / 117 and 117 A, where the
//! ellipse has axes of about 1:20. Within a factor of 2 of a bound the curvature is bent towards it with a C1 parabola, elsewhere it is
//! kept to the bit.

use super::ConformalContact;
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

/// L / delta.
const SHARE: f64 = 0.9;

/// Largest ratio of the half curvatures, either way, for which `bounded` lets an ellipse be: axes 1:19.95.
pub(super) const LARGEST_RATIO: f64 = 117.0;

/// Gaps are taken at no less than this level [m]: the profiles' rounding is 1e-16 m. The force is then below 10 mN.
const LEAST_LEVEL: f64 = 1e-9;

/// The larger one of `x` and `least`, bent where x is below 2 least so that it is C1: least at x <= 0.
#[inline]
fn at_least(x: f64, least: f64) -> f64 {
    if x >= 2.0 * least {
        x
    } else if x > 0.0 {
        least + x * x / (4.0 * least)
    } else {
        least
    }
}

/// The smaller one of `x` and `most`, bent from most / 2 to 3 / 2 most so that it is C1.
#[inline]
fn at_most(x: f64, most: f64) -> f64 {
    if x <= 0.5 * most {
        x
    } else if x < 1.5 * most {
        most - (1.5 * most - x) * (1.5 * most - x) / (2.0 * most)
    } else {
        most
    }
}

impl Rule {
    /// Does B depend on the penetration?
    #[inline]
    pub fn needs_penetration(&self) -> bool {
        self.across == Across::Patch
    }

    /// B that enters the theory [1/m] under `penetration` [m].
    #[inline]
    pub fn across(&self, shape: &ContactShape, penetration: f64) -> Result<f64, ConformalContact> {
        let across = match self.across {
            Across::Point => shape.across,
            Across::Stated(ratio) => return Ok(ratio * shape.rolling),
            Across::Patch => self.over_patch(shape, penetration)?,
        };
        Ok(self.bound(shape.rolling, across))
    }

    /// A guess of [`Rule::across`] without penetration.
    #[inline]
    pub fn guess(&self, shape: &ContactShape) -> f64 {
        let (least, most) = (shape.rolling / LARGEST_RATIO, shape.rolling * LARGEST_RATIO);
        // A spline's curvature at a point may be anything.
        if shape.across > least && shape.across < most { shape.across } else { shape.rolling }
    }

    #[inline]
    fn bound(&self, rolling: f64, across: f64) -> f64 {
        if self.conformal == Conformal::Error {
            return across;
        }
        let (least, most) = (rolling / LARGEST_RATIO, rolling * LARGEST_RATIO);
        // From above it is 1 / B, the scale of lengths, that is bent.
        if across > 0.5 * most { 1.0 / at_least(1.0 / across, 1.0 / most) } else { at_least(across, least) }
    }

    fn over_patch(&self, shape: &ContactShape, penetration: f64) -> Result<f64, ConformalContact> {
        let level = (SHARE * penetration).max(LEAST_LEVEL);
        let widest = (level * LARGEST_RATIO / shape.rolling).sqrt();
        let half_width = match (self.conformal, shape.overlap(level, 1.5 * widest)) {
            (Conformal::Error, [Some(one), Some(other)]) => 0.5 * (15.0 / 8.0 * one + 15.0 / 8.0 * other),
            (Conformal::Error, _) => return Err(ConformalContact { rolling: shape.rolling, across: shape.across }),
            (Conformal::Bounded, [one, other]) => {
                let bounded = |side: Option<f64>| side.map_or(widest, |integral| at_most(15.0 / 8.0 * integral, widest));
                0.5 * (bounded(one) + bounded(other))
            }
        };
        Ok(level / (half_width * half_width))
    }

    /// For `wheelrail plan`; empty for the default.
    pub fn describe(&self) -> String {
        let across = match self.across {
            Across::Point => "",
            Across::Patch => ", curvature over the patch",
            Across::Stated(_) => ", stated ratio of the semi-axes",
        };
        let conformal = if self.conformal == Conformal::Bounded { ", conformal contact bounded" } else { "" };
        format!("{across}{conformal}")
    }
}

/// Reads `curvature` and `conformal`.
pub(super) fn parse(section: &Section) -> Result<Rule, SettingsError> {
    let across = match section.word_or("curvature", &["point", "patch"], "point")? {
        "patch" => Across::Patch,
        _ => Across::Point,
    };
    let conformal = match section.word_or("conformal", &["error", "bounded"], "error")? {
        "bounded" => Conformal::Bounded,
        _ => Conformal::Error,
    };
    Ok(Rule { across, conformal })
}
