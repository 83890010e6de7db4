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

/// Wheel and rail beside a contact, each read in the frame of its tangent. `Read` gives both values [m] and slopes at two
/// coordinates.
struct Gap<Read> {
    read: Read,
    at: [f64; 2],
    value: [f64; 2],
    /// p, c and 1 / c.
    slope: [f64; 2],
    cos: [f64; 2],
    per_cos: [f64; 2],
    /// -1 or 1.
    side: f64,
}

impl<Read: Fn([f64; 2]) -> ([f64; 2], [f64; 2])> Gap<Read> {
    #[inline]
    fn new(sections: &[Section; 2], side: f64, read: Read) -> Self {
        let both = |get: fn(&Section) -> f64| sections.each_ref().map(get);
        let slope = both(|section| section.point.d1);
        let per_cos = slope.map(|p| (1.0 + p * p).sqrt());
        Gap {
            read,
            at: both(|section| section.at),
            value: both(|section| section.point.value),
            slope,
            cos: per_cos.map(|per| 1.0 / per),
            per_cos,
            side,
        }
    }

    /// The gap [m] at the distance t > 0 and how fast it opens there; `None` where a profile has turned by a right angle, beyond
    /// any contact.
    #[inline(always)]
    fn at(&self, t: f64) -> Option<(f64, f64)> {
        // Pair by pair, so that the compiler makes vector instructions of it.
        let along = self.cos.map(|cos| cos * (self.side * t));
        let (values, slopes) = (self.read)([self.at[0] + along[0], self.at[1] + along[1]]);
        let turn = [1.0 + self.slope[0] * slopes[0], 1.0 + self.slope[1] * slopes[1]];
        if !(turn[0] > 0.0 && turn[1] > 0.0) {
            return None;
        }
        let height = |i: usize| (values[i] - self.value[i] - self.slope[i] * along[i]) * self.per_cos[i];
        let (height, bend) = ([height(0), height(1)], [slopes[0] - self.slope[0], slopes[1] - self.slope[1]]);
        let scale = 1.0 / (turn[0] * turn[1]);
        let both = |part: [f64; 2]| -(part[0] * turn[1] + part[1] * turn[0]) * scale;
        Some((both(height), self.side * both(bend)))
    }
}

/// Relative step of t after which the search ends; the next one would be about its square. The distance scales the panels of
/// an integral, so its rounding must stay far below what the loop between normal and creep forces can see.
const SETTLED: f64 = 3e-4;
const ITERATIONS: usize = 40;

/// Gauss's four points and weights on [-1, 1]: exact for the parabola's (1 - x^2)^2. Against the whole integral over S1002 on
/// 60E1 from -6 to 6 mm, under 70 um, the sum is at most 4e-4 off; so it is with more points.
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];
/// Panels of the integral, each twice as wide as the one before.
const PANELS: usize = 7;

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
                    (Some(w), Some(r)) => {
                        sides.map(|side| one_side(&Gap::new(sections, side, |x| Piecewise::both([w, r], x)), level, start, reach))
                    }
                    _ => {
                        let read = |[u, eta]: [f64; 2]| {
                            let (w, r) = (wheel.value_and_slope(u), rail.value_and_slope(eta));
                            ([w.0, r.0], [w.1, r.1])
                        };
                        sides.map(|side| one_side(&Gap::new(sections, side, read), level, start, reach))
                    }
                }
            }
        }
    }
}

/// One side of [`ContactShape::overlap`].
#[inline(never)]
fn one_side<Read: Fn([f64; 2]) -> ([f64; 2], [f64; 2])>(gap: &Gap<Read>, level: f64, start: f64, reach: f64) -> Option<f64> {
    let half = part(gap, 0.25 * level, start, reach)?;
    Some(integrate(gap, level, 2.0 * half))
}

/// The integral of [`ContactShape::overlap`] on one side, from panels as wide as `first` (what is wanted, for a parabola),
/// twice that, and so on. The integrand is C1, so fixed points keep the sum smooth in the pose.
#[inline(always)]
fn integrate<Read: Fn([f64; 2]) -> ([f64; 2], [f64; 2])>(gap: &Gap<Read>, level: f64, first: f64) -> f64 {
    let per_level = 1.0 / level;
    let (mut sum, mut largest, mut from, mut half) = (0.0, 0.0f64, 0.0, 0.5 * first);
    for _ in 0..PANELS {
        for (x, weight) in GAUSS {
            let Some((here, _)) = gap.at(from + half * (1.0 + x)) else { return sum };
            largest = if here > largest { here } else { largest };
            if largest >= level {
                return sum;
            }
            let depth = 1.0 - largest * per_level;
            sum += weight * half * depth * depth;
        }
        from += 2.0 * half;
        half *= 2.0;
    }
    sum
}

/// The distance t > 0 on one side at which the profiles have parted by `level`: Newton's method on the root of the gap, which is
/// straight for a parabola. Steps that leave the interval known to hold a root halve it or, while no end is known, double the
/// distance.
#[inline(always)]
fn part<Read: Fn([f64; 2]) -> ([f64; 2], [f64; 2])>(gap: &Gap<Read>, level: f64, start: f64, reach: f64) -> Option<f64> {
    let (mut inside, mut outside) = (0.0f64, f64::INFINITY);
    let mut t = start;
    for _ in 0..ITERATIONS {
        let found = gap.at(t);
        if found.is_some_and(|(here, _)| here < level) {
            inside = t;
        } else {
            outside = t;
        }
        if inside > reach {
            return None;
        }
        let next = match found {
            Some((here, opening)) if here > 0.0 && opening > 0.0 => t + 2.0 * ((level * here).sqrt() - here) / opening,
            _ => f64::NAN,
        };
        if next >= inside && next <= outside && next <= 8.0 * t {
            if (next - t).abs() <= SETTLED * t {
                return (next <= reach).then_some(next);
            }
            t = next;
        } else {
            t = if outside.is_finite() { 0.5 * (inside + outside) } else { 2.0 * t };
        }
    }
    (inside <= reach).then_some(inside)
}
