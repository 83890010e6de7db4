//! Which curvature across the rolling direction enters Hertz's theory, and what is done where the surfaces are conformal.
//!
//! *At the point.* B is half the relative curvature at the contact. Where the radii of a profile jump (60E1: 300, 80, 13 mm)
//! B jumps, and with it the normal force.
//!
//! *Over the patch.* Bodies that overlap by delta without deforming cut each other in a region wider than the patch; lowered
//! to `L = 0.55 delta` it has about the patch's size (virtual penetration: Kik and Piotrowski 1996; Piotrowski and Chollet
//! 2005; Piotrowski and Kik 2008, where 0.55 comes from). Its width `t1 + t2`, with the gap g(t) of
//! [`super::shape`], gives the curvature of the parabola with the same width at the same level:
//!
//! ```text
//! g(-t1) = g(t2) = L = 0.55 delta,   b = (t1 + t2) / 2,   B = L / b^2
//! ```
//!
//! For a parabola this is its B; for a circular arc of radius r, `1 / (2 r - L)`. The region's ends are places in
//! space, whatever point between them is called the contact. They move smoothly when contact and curvature jump, because
//! g is C1: so is B, up to the gap's small depth delta by which the frame turns (measured in the tests). No
//! iteration in b is needed, and B delta^0 to delta^1 (b grows with delta) makes N grow with delta at least like delta.
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

/// Share of the penetration at which the virtual penetration's width is taken.
const SHARE: f64 = 0.55;

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
        let start = (level / self.guess(shape)).sqrt();
        let half_width = match (self.conformal, shape.parting(level, start, 1.5 * widest)) {
            (Conformal::Error, [Some(inner), Some(outer)]) => 0.5 * (inner + outer),
            (Conformal::Error, _) => return Err(ConformalContact { rolling: shape.rolling, across: shape.across }),
            (Conformal::Bounded, sides) => 0.5 * sides.iter().map(|t| t.map_or(widest, |t| at_most(t, widest))).sum::<f64>(),
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
