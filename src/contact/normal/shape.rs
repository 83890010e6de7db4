//! What a normal law may ask of the surfaces at a contact: their curvatures there, and how far they part beside it.
//!
//! Both profiles are cut by the plane of the rail's section. Each is read in the frame of its own tangent at the contact, t
//! along the tangent (outward positive), h along the rail's normal; slope p and `c = 1 / sqrt(1 + p^2)` there. At x0 + c t
//! the profile's value has changed by dy, its slope is y', and
//!
//! ```text
//! t' = t + p h',   h' = c (dy - p c t),   dh/dt = (y' - p) / T,   T = 1 + p y'
//! h(t) = h' - (t' - t) dh/dt = (dy - p c t) / (c T)
//! ```
//!
//! with an error of second order in the distance t' - t, (p h')^2 / (2 r): 1e-4 of h' for L = 60 um on r = 13 mm at p = 0.2. At
//! the contact the tangents are parallel, so the frames fall together and the gap of the undeformed profiles along the
//! normal is `g(t) = -h_wheel(t) - h_rail(t)`, with `g(0) = g'(0) = 0` and `g''(0) = 2 B`. The wheel turned by a yaw angle
//! shows the section a profile that is wider by 1 / cos(yaw): 2e-4 of t at 20 mrad, left out. Where tangents are parallel only
//! to a nodal search's spacing, they are taken as parallel.

use crate::geometry::profile::{Piecewise, Profile, ProfilePoint};

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

/// Reads wheel and rail at two coordinates: values [m] and slopes.
trait Read {
    fn both(&self, x: [f64; 2]) -> ([f64; 2], [f64; 2]);
}

impl Read for [&Piecewise; 2] {
    #[inline(always)]
    fn both(&self, x: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        Piecewise::both(*self, x)
    }
}

impl Read for [&dyn Profile; 2] {
    #[inline]
    fn both(&self, x: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let (wheel, rail) = (self[0].value_and_slope(x[0]), self[1].value_and_slope(x[1]));
        ([wheel.0, rail.0], [wheel.1, rail.1])
    }
}

/// Wheel and rail beside a contact, on one side of it, each in the frame of its tangent.
struct Gap<R> {
    profiles: R,
    at: [f64; 2],
    value: [f64; 2],
    /// p, c and 1 / c.
    slope: [f64; 2],
    cos: [f64; 2],
    per_cos: [f64; 2],
    /// -1 or 1.
    side: f64,
}

/// Where wheel and rail are: t and h [m], dt/dx and dh/dt.
struct Off {
    t: [f64; 2],
    h: [f64; 2],
    stretch: [f64; 2],
    slope: [f64; 2],
}

impl Off {
    /// The gap by the tangents at t = 0, exact to first order in the points' distances from t, and how fast it opens; `None`
    /// where a profile has turned by a right angle, beyond any contact.
    #[inline]
    fn opening(&self) -> Option<(f64, f64)> {
        let at_zero = -(self.h[0] + self.h[1]) + self.slope[0] * self.t[0] + self.slope[1] * self.t[1];
        (self.stretch[0] > 0.0 && self.stretch[1] > 0.0).then_some((at_zero, -(self.slope[0] + self.slope[1])))
    }
}

// Both profiles side by side, so that the compiler makes vector instructions of it.
impl<R: Read> Gap<R> {
    #[inline]
    fn new(sections: &[Section; 2], side: f64, profiles: R) -> Self {
        let both = |get: fn(&Section) -> f64| sections.each_ref().map(get);
        let slope = both(|section| section.point.d1);
        let per_cos = slope.map(|p| (1.0 + p * p).sqrt());
        Gap {
            profiles,
            at: both(|section| section.at),
            value: both(|section| section.point.value),
            slope,
            cos: per_cos.map(|per| 1.0 / per),
            per_cos,
            side,
        }
    }

    /// The gap [m] at the distance t > 0; `None` where a profile has turned by a right angle.
    #[inline(always)]
    fn at(&self, t: f64) -> Option<f64> {
        let along = self.cos.map(|cos| cos * (self.side * t));
        let (values, slopes) = self.profiles.both([self.at[0] + along[0], self.at[1] + along[1]]);
        let turn = [1.0 + self.slope[0] * slopes[0], 1.0 + self.slope[1] * slopes[1]];
        let height = |i: usize| (values[i] - self.value[i] - self.slope[i] * along[i]) * self.per_cos[i];
        let sum = height(0) * turn[1] + height(1) * turn[0];
        (turn[0] > 0.0 && turn[1] > 0.0).then(|| -sum / (turn[0] * turn[1]))
    }

    /// Both profiles at their own coordinates, counted from the contact.
    #[inline(always)]
    fn off(&self, dx: [f64; 2]) -> Off {
        let (values, slopes) = self.profiles.both([self.at[0] + dx[0], self.at[1] + dx[1]]);
        let each = |f: &dyn Fn(usize, f64, f64) -> f64| [0, 1].map(|i| f(i, self.slope[i], values[i] - self.value[i]));
        let turn = [1.0 + self.slope[0] * slopes[0], 1.0 + self.slope[1] * slopes[1]];
        Off {
            t: each(&|i, p, dy| self.cos[i] * (dx[i] + p * dy)),
            h: each(&|i, p, dy| self.cos[i] * (dy - p * dx[i])),
            stretch: each(&|i, _, _| self.cos[i] * turn[i]),
            slope: each(&|i, p, _| (slopes[i] - p) / turn[i]),
        }
    }
}

/// Relative step of t after which the search ends; the next one would be about its square. The distance scales the panels of
/// an integral, so its rounding must stay far below what the loop between normal and creep forces can see.
const SETTLED: f64 = 1e-5;
const ITERATIONS: usize = 40;

/// Two points whose t differ by less than this share tell on which side of the root they are.
const APART: f64 = 1e-3;

/// Gauss's three points and weights on [-1, 1]: exact for the parabola's (1 - x^2)^2.
const GAUSS: [(f64, f64); 3] = [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// Panels of the integral, each after the second twice as wide as the one before. For a parabola one panel of twice the width would
/// do; where two places of contact join (S1002 on 60E1), one of four points would be up to 7 % off, two of three are 3 %.
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
            Some(sections) => {
                let [wheel, rail] = sections.each_ref().map(|section| section.profile);
                let (start, sides) = ((0.5 * start).min(reach), [-1.0, 1.0]);
                match (wheel.piecewise(), rail.piecewise()) {
                    (Some(w), Some(r)) => sides.map(|side| one_side(&Gap::new(sections, side, [w, r]), level, start, reach)),
                    _ => sides.map(|side| one_side(&Gap::new(sections, side, [wheel, rail]), level, start, reach)),
                }
            }
        }
    }
}

/// One side of [`ContactShape::overlap`].
#[inline(never)]
fn one_side<R: Read>(gap: &Gap<R>, level: f64, start: f64, reach: f64) -> Option<f64> {
    let half = part(gap, 0.25 * level, start, reach)?;
    Some(integrate(gap, level, half))
}

/// The integral of [`ContactShape::overlap`] on one side, from panels as wide as `first` (for a parabola half of what is
/// wanted), twice that, and so on. The integrand is C1, so fixed points keep the sum smooth in the pose.
#[inline(always)]
fn integrate<R: Read>(gap: &Gap<R>, level: f64, first: f64) -> f64 {
    let per_level = 1.0 / level;
    let (mut sum, mut largest, mut from, mut half) = (0.0, 0.0f64, 0.0, 0.5 * first);
    for panel in 0..PANELS {
        for (x, weight) in GAUSS {
            let Some(here) = gap.at(from + half * (1.0 + x)) else { return sum };
            largest = if here > largest { here } else { largest };
            if largest >= level {
                return sum;
            }
            let depth = 1.0 - largest * per_level;
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
#[inline(always)]
fn part<R: Read>(gap: &Gap<R>, level: f64, start: f64, reach: f64) -> Option<f64> {
    let (side, [cos_w, cos_r]) = (gap.side, gap.cos);
    let (mut u, mut eta) = (side * start * cos_w, side * start * cos_r);
    let (mut inside, mut outside) = (0.0f64, f64::INFINITY);
    for _ in 0..ITERATIONS {
        let at = gap.off([u, eta]);
        let [w, r] = at.t;
        let far = side * 0.5 * (w + r);
        let Some((at_zero, opening)) = at.opening() else {
            outside = outside.min(side * u / cos_w).min(side * eta / cos_r);
            let t = side * 0.5 * (inside + outside);
            (u, eta) = (t * cos_w, t * cos_r);
            continue;
        };
        if (w - r).abs() < APART * far {
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
        } else if (side * w - t).abs().max((side * r - t).abs()) <= SETTLED * far {
            return (t <= reach).then_some(t);
        }
        u += (side * t - w) / at.stretch[0];
        eta += (side * t - r) / at.stretch[1];
    }
    (inside <= reach).then_some(inside)
}
