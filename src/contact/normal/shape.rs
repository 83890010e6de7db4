//! What a normal law may ask of the surfaces at a contact: their curvatures there, and how far they part beside it.
//!
//! Both profiles are cut by the plane of the rail's section. Each is read in the frame of its own tangent at the contact, t
//! along the tangent (outward positive), h along the rail's normal; slope p and `c = 1 / sqrt(1 + p^2)` there, and for a
//! coordinate x0 + dx with the change dy of the profile's value
//!
//! ```text
//! t = c (dx + p dy),   h = c (dy - p dx),   dh/dt = (y' - p) / (1 + p y')
//! ```
//!
//! At the contact the tangents are parallel, so the frames fall together and the gap of the undeformed profiles along the
//! normal is `g(t) = -h_wheel(t) - h_rail(t)`, with `g(0) = g'(0) = 0` and `g''(0) = 2 B`. The wheel turned by a yaw angle
//! shows the section a profile that is wider by 1 / cos(yaw): 2e-4 of t at 20 mrad, left out. Where tangents are parallel only
//! to a nodal search's spacing, they are taken as parallel.

use crate::geometry::profile::{Profile, ProfilePoint};

/// A profile and the place of the contact on it.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    pub profile: &'a dyn Profile,
    /// u or eta of the contact, m.
    pub at: f64,
    /// The profile there.
    pub point: ProfilePoint,
}

/// The surfaces at one contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactShape<'a> {
    /// Half the relative principal curvature A along e1 at the contact, 1/m.
    pub rolling: f64,
    /// The same along e2, B, 1/m.
    pub across: f64,
    sections: Option<[Section<'a>; 2]>,
}

/// A profile read in the frame of its tangent.
struct Tangent<'a> {
    section: &'a Section<'a>,
    cos: f64,
    dx: f64,
}

/// Where a profile is: (t, h), dt/dx and dh/dt.
struct Off {
    t: f64,
    h: f64,
    stretch: f64,
    slope: f64,
}

impl<'a> Tangent<'a> {
    #[inline]
    fn new(section: &'a Section<'a>, t: f64) -> Self {
        let slope = section.point.d1;
        let cos = 1.0 / (1.0 + slope * slope).sqrt();
        Tangent { section, cos, dx: cos * t }
    }

    #[inline]
    fn off(&self) -> Off {
        let Section { profile, at, point } = self.section;
        let (there, p, dx) = (profile.at(at + self.dx), point.d1, self.dx);
        let dy = there.value - point.value;
        let turn = 1.0 + p * there.d1;
        Off { t: self.cos * (dx + p * dy), h: self.cos * (dy - p * dx), stretch: self.cos * turn, slope: (there.d1 - p) / turn }
    }
}

/// Relative error of t at which the search ends; the step that follows would be about its square.
const SETTLED: f64 = 1e-8;
const ITERATIONS: usize = 40;

/// Two points whose t differ by less than this share tell on which side of the root they are.
const APART: f64 = 1e-3;

impl<'a> ContactShape<'a> {
    #[inline]
    pub fn new(rolling: f64, across: f64, wheel: Section<'a>, rail: Section<'a>) -> Self {
        ContactShape { rolling, across, sections: Some([wheel, rail]) }
    }

    /// Surfaces whose half relative curvatures A and B are the same all over the patch.
    pub fn of_constant_curvature(rolling: f64, across: f64) -> Self {
        ContactShape { rolling, across, sections: None }
    }

    /// Distances t > 0 [m] to either side, inner side first, at which the profiles have parted by `level` > 0 [m]. `start` [m] is
    /// where the search begins; `None` for a side on which they have not parted by that within `reach` [m].
    #[inline]
    pub fn parting(&self, level: f64, start: f64, reach: f64) -> [Option<f64>; 2] {
        match &self.sections {
            None => {
                let t = (level / self.across).sqrt();
                // NaN of a hollow shape is not within reach.
                [(t <= reach).then_some(t); 2]
            }
            Some(sections) => [-1.0, 1.0].map(|side| part(sections, side, level, start.min(reach), reach)),
        }
    }
}

/// Newton's method for g(t) = level on one side, both profiles at once: each step puts the two points on the t where their
/// tangents have the wanted gap. Steps that leave the interval known to hold a root halve it or, while no end is known, double
/// the distance.
fn part([wheel, rail]: &[Section; 2], side: f64, level: f64, start: f64, reach: f64) -> Option<f64> {
    let (mut wheel, mut rail) = (Tangent::new(wheel, side * start), Tangent::new(rail, side * start));
    let (mut inside, mut outside) = (0.0, f64::INFINITY);
    for _ in 0..ITERATIONS {
        let (w, r) = (wheel.off(), rail.off());
        if !(w.stretch > 0.0 && r.stretch > 0.0) {
            // A profile has turned by a right angle: beyond any contact.
            outside = side * 0.5 * (w.t + r.t);
            let t = 0.5 * (inside + outside);
            (wheel.dx, rail.dx) = (side * t * wheel.cos, side * t * rail.cos);
            continue;
        }
        // Gap by the tangents at t: at_zero + opening t, exact where both points have the same t.
        let opening = -(w.slope + r.slope);
        let at_zero = -(w.h + r.h) + w.slope * w.t + r.slope * r.t;
        let here = 0.5 * (w.t + r.t);
        let far = side * here;
        if (w.t - r.t).abs() < APART * far {
            if at_zero + opening * here < level {
                inside = far.max(inside);
            } else {
                outside = far.min(outside);
            }
        }
        let mut t = (level - at_zero) / opening;
        let slack = APART * far;
        let between = side * t >= inside - slack && side * t <= outside + slack;
        if !between || opening * side <= 0.0 || side * t > 2.0 * far.max(reach) {
            t = side * if outside.is_finite() { 0.5 * (inside + outside) } else { 2.0 * far };
        } else if (w.t - t).abs().max((r.t - t).abs()) <= SETTLED * far {
            return (side * t <= reach).then_some(side * t);
        }
        if inside > reach {
            return None;
        }
        wheel.dx += (t - w.t) / w.stretch;
        rail.dx += (t - r.t) / r.stretch;
    }
    (inside <= reach).then_some(inside)
}
