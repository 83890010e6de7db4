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
struct Tangent<'a, P: ?Sized> {
    profile: &'a P,
    at: f64,
    value: f64,
    slope: f64,
    cos: f64,
    per_cos: f64,
}

/// A profile at t: `c T h(t)` over c [m], T, and `T dh/dt`.
struct Off {
    height: f64,
    turn: f64,
    slope: f64,
}

impl<'a, P: Profile + ?Sized> Tangent<'a, P> {
    #[inline]
    fn new(profile: &'a P, section: &Section) -> Self {
        let (value, slope) = (section.point.value, section.point.d1);
        let per_cos = (1.0 + slope * slope).sqrt();
        Tangent { profile, at: section.at, value, slope, cos: 1.0 / per_cos, per_cos }
    }

    #[inline]
    fn off(&self, t: f64) -> Off {
        let (dx, p) = (self.cos * t, self.slope);
        let (value, slope) = self.profile.value_and_slope(self.at + dx);
        Off { height: (value - self.value - p * dx) * self.per_cos, turn: 1.0 + p * slope, slope: slope - p }
    }
}

/// Wheel and rail beside a contact, on one side of it.
struct Gap<'a, P: ?Sized> {
    wheel: &'a Tangent<'a, P>,
    rail: &'a Tangent<'a, P>,
    /// -1 or 1.
    side: f64,
}

impl<P: Profile + ?Sized> Gap<'_, P> {
    /// The gap [m] at the distance t > 0 and how fast it opens there; `None` where a profile has turned by a right angle, beyond
    /// any contact.
    #[inline]
    fn at(&self, t: f64) -> Option<(f64, f64)> {
        let (w, r) = (self.wheel.off(self.side * t), self.rail.off(self.side * t));
        let scale = 1.0 / (w.turn * r.turn);
        let both = |wheel: f64, rail: f64| -(wheel * r.turn + rail * w.turn) * scale;
        (w.turn > 0.0 && r.turn > 0.0).then(|| (both(w.height, r.height), self.side * both(w.slope, r.slope)))
    }
}

/// Relative step of t after which the search ends; the next one would be about its square. The distance scales the panels of
/// an integral, so its rounding must stay far below what the loop between normal and creep forces can see.
const SETTLED: f64 = 3e-5;
const ITERATIONS: usize = 40;

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
            Some([wheel, rail]) => match (wheel.profile.piecewise(), rail.profile.piecewise()) {
                (Some(w), Some(r)) => sides(&Tangent::new(w, wheel), &Tangent::new(r, rail), level, start, reach),
                _ => sides(&Tangent::new(wheel.profile, wheel), &Tangent::new(rail.profile, rail), level, start, reach),
            },
        }
    }
}

/// Both sides of [`ContactShape::overlap`].
fn sides<P: Profile + ?Sized>(wheel: &Tangent<P>, rail: &Tangent<P>, level: f64, start: f64, reach: f64) -> [Option<f64>; 2] {
    [-1.0, 1.0].map(|side| {
        let gap = Gap { wheel, rail, side };
        let half = part(&gap, 0.25 * level, (0.5 * start).min(reach), reach)?;
        Some(integrate(&gap, level, half))
    })
}

/// The integral of [`ContactShape::overlap`] on one side, from panels as wide as `first` (for a parabola half of what is
/// wanted), twice that, and so on. The integrand is C1, so fixed points keep the sum smooth in the pose.
#[inline]
fn integrate<P: Profile + ?Sized>(gap: &Gap<P>, level: f64, first: f64) -> f64 {
    let per_level = 1.0 / level;
    let (mut sum, mut largest, mut from, mut half) = (0.0, 0.0f64, 0.0, 0.5 * first);
    for panel in 0..PANELS {
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
        if panel > 0 {
            half *= 2.0;
        }
    }
    sum
}

/// The distance t > 0 on one side at which the profiles have parted by `level`: Newton's method on the root of the gap, which is
/// straight for a parabola. Steps that leave the interval known to hold a root halve it or, while no end is known, double the
/// distance.
#[inline]
fn part<P: Profile + ?Sized>(gap: &Gap<P>, level: f64, start: f64, reach: f64) -> Option<f64> {
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
