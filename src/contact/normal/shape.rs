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
    fn new(section: &'a Section<'a>) -> Self {
        Tangent { section, cos: 1.0 / (1.0 + section.point.d1 * section.point.d1).sqrt() }
    }

    #[inline]
    fn off(&self, dx: f64) -> Off {
        let Section { profile, at, point } = self.section;
        let ((value, slope), p) = (profile.value_and_slope(at + dx), point.d1);
        let dy = value - point.value;
        let turn = 1.0 + p * slope;
        Off { t: self.cos * (dx + p * dy), h: self.cos * (dy - p * dx), stretch: self.cos * turn, slope: (slope - p) / turn }
    }
}

/// The gap by the tangents of a point on either profile: `at_zero + opening t`, exact to first order in the points' distances
/// from t; `None` where a profile has turned by a right angle, beyond any contact.
#[inline]
fn opening(w: &Off, r: &Off) -> Option<(f64, f64)> {
    let at_zero = -(w.h + r.h) + w.slope * w.t + r.slope * r.t;
    (w.stretch > 0.0 && r.stretch > 0.0).then_some((at_zero, -(w.slope + r.slope)))
}

/// Relative step of t after which the search ends; the next one would be about its square. The distance scales the panels of
/// an integral, so its rounding must stay far below what the loop between normal and creep forces can see.
const SETTLED: f64 = 1e-5;
const ITERATIONS: usize = 40;

/// Two points whose t differ by less than this share tell on which side of the root they are.
const APART: f64 = 1e-3;

/// Gauss's three points and weights on [-1, 1]: exact for the parabola's (1 - x^2)^2.
const GAUSS: [(f64, f64); 3] = [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// Panels of the integral, each after the second twice as wide as the one before.
const PANELS: usize = 8;

impl<'a> ContactShape<'a> {
    #[inline]
    pub fn new(rolling: f64, across: f64, wheel: Section<'a>, rail: Section<'a>) -> Self {
        ContactShape { rolling, across, sections: Some([wheel, rail]) }
    }

    /// Surfaces whose half relative curvatures A and B are the same all over the patch.
    pub fn of_constant_curvature(rolling: f64, across: f64) -> Self {
        ContactShape { rolling, across, sections: None }
    }

    /// For the side of t < 0 and that of t > 0 the mean depth of the overlap, in the form
    ///
    /// ```text
    /// integral over |t| of (1 - G / L)^2 where G < L,   G(t) = the largest g between the contact and t [m]
    /// ```
    ///
    /// with L = `level` > 0 [m]. `None` for a side on which the profiles have not parted by L / 4 within `reach` [m]. `start` [m] is
    /// where L is expected to be reached. G instead of g lets a second place of contact beyond a ridge count as little as the
    /// ridge is low under L.
    #[inline]
    pub fn overlap(&self, level: f64, start: f64, reach: f64) -> [Option<f64>; 2] {
        match &self.sections {
            None => {
                let t = (level / self.across).sqrt();
                // NaN of a hollow shape is not within reach.
                [(0.5 * t <= reach).then_some(8.0 / 15.0 * t); 2]
            }
            Some([wheel, rail]) => {
                let (wheel, rail) = (Tangent::new(wheel), Tangent::new(rail));
                [-1.0, 1.0].map(|side| {
                    let half = part(&wheel, &rail, side, 0.25 * level, (0.5 * start).min(reach), reach)?;
                    Some(integrate(&wheel, &rail, side, level, half))
                })
            }
        }
    }
}

/// The integral of [`ContactShape::overlap`] on one side, from panels as wide as `first` (for a parabola half of what is
/// wanted), twice that, and so on. The integrand is C1, so fixed points keep the sum smooth in the pose.
#[inline]
fn integrate(wheel: &Tangent, rail: &Tangent, side: f64, level: f64, first: f64) -> f64 {
    let (mut sum, mut largest, mut from, mut half) = (0.0, 0.0f64, 0.0, 0.5 * first);
    for panel in 0..PANELS {
        for (x, weight) in GAUSS {
            let t = side * (from + half * (1.0 + x));
            let Some((at_zero, opening)) = opening(&wheel.off(wheel.cos * t), &rail.off(rail.cos * t)) else { return sum };
            largest = largest.max(at_zero + opening * t);
            if largest >= level {
                return sum;
            }
            let depth = 1.0 - largest / level;
            sum += weight * half * depth * depth;
        }
        from += 2.0 * half;
        if panel > 0 {
            half *= 2.0;
        }
    }
    sum
}

/// The distance t > 0 on one side at which the profiles have parted by `level`: Newton's method on both profiles at once, each
/// step putting the two points on the t where their tangents have the wanted gap. Steps that leave the interval known to hold a
/// root halve it or, while no end is known, double the distance.
#[inline]
fn part(wheel: &Tangent, rail: &Tangent, side: f64, level: f64, start: f64, reach: f64) -> Option<f64> {
    let (mut u, mut eta) = (side * start * wheel.cos, side * start * rail.cos);
    let (mut inside, mut outside) = (0.0f64, f64::INFINITY);
    for _ in 0..ITERATIONS {
        let (w, r) = (wheel.off(u), rail.off(eta));
        let far = side * 0.5 * (w.t + r.t);
        let Some((at_zero, opening)) = opening(&w, &r) else {
            outside = outside.min(side * u / wheel.cos).min(side * eta / rail.cos);
            let t = side * 0.5 * (inside + outside);
            (u, eta) = (t * wheel.cos, t * rail.cos);
            continue;
        };
        if (w.t - r.t).abs() < APART * far {
            if at_zero + opening * side * far < level {
                inside = far.max(inside);
            } else {
                outside = far.min(outside);
            }
        }
        if inside > reach {
            return None;
        }
        let mut t = side * (level - at_zero) / opening;
        let slack = APART * far;
        if !(opening * side > 0.0 && t >= inside - slack && t <= outside + slack && t <= 8.0 * far) {
            t = if outside.is_finite() { 0.5 * (inside + outside) } else { 2.0 * far };
        } else if (side * w.t - t).abs().max((side * r.t - t).abs()) <= SETTLED * far {
            return (t <= reach).then_some(t);
        }
        u += (side * t - w.t) / w.stretch;
        eta += (side * t - r.t) / r.stretch;
    }
    (inside <= reach).then_some(inside)
}
