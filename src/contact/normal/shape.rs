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

use crate::geometry::profile::{Along, Profile, ProfilePoint};

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

/// Wheel and rail at the distance t from a contact, along their tangents.
trait Read {
    /// Slope [-] per slope as it is read.
    fn unit(&self) -> [f64; 2];
    /// Values [m] and slopes; NaN where [`Profile::at`] must be asked.
    fn at(&self, t: f64) -> ([f64; 2], [f64; 2]);
}

impl Read for Along<'_> {
    #[inline(always)]
    fn unit(&self) -> [f64; 2] {
        self.unit
    }
    #[inline(always)]
    fn at(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        self.read(t)
    }
}

/// Profiles of any kind: coordinates of the contact, and dx/dt.
struct Any<'a> {
    profiles: [&'a dyn Profile; 2],
    at: [f64; 2],
    along: [f64; 2],
}

impl Read for Any<'_> {
    #[inline]
    fn unit(&self) -> [f64; 2] {
        [1.0; 2]
    }
    #[inline]
    fn at(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        let [wheel, rail] = [0, 1].map(|i| self.profiles[i].value_and_slope(self.at[i] + self.along[i] * t));
        ([wheel.0, rail.0], [wheel.1, rail.1])
    }
}

/// Wheel and rail beside a contact, on one side of it, each in the frame of its tangent.
struct Gap<'a, R> {
    sections: &'a [Section<'a>; 2],
    read: R,
    value: [f64; 2],
    /// dx/dt and dy/dt on the tangents; t > 0 on either side.
    along: [f64; 2],
    rise: [f64; 2],
    /// -1/c.
    down: [f64; 2],
    /// T - 1 per slope as it is read.
    turn: [f64; 2],
}

// Both profiles side by side, so that the compiler makes vector instructions of it.
impl<'a, R: Read> Gap<'a, R> {
    #[inline(always)]
    fn new(sections: &'a [Section<'a>; 2], per_cos: [f64; 2], along: [f64; 2], read: R) -> Self {
        let slope = sections.each_ref().map(|section| section.point.d1);
        let unit = read.unit();
        Gap {
            sections,
            read,
            value: sections.each_ref().map(|section| section.point.value),
            along,
            rise: [slope[0] * along[0], slope[1] * along[1]],
            down: per_cos.map(|per| -per),
            turn: [slope[0] * unit[0], slope[1] * unit[1]],
        }
    }

    /// Depths of both profiles under their tangents [m] and T, which is zero where a profile has turned by a right angle or more.
    #[inline(always)]
    fn below(&self, t: f64, (values, slopes): ([f64; 2], [f64; 2]), turn: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let turned = [1.0 + turn[0] * slopes[0], 1.0 + turn[1] * slopes[1]].map(|turn| if turn < 0.0 { 0.0 } else { turn });
        let down = [0, 1].map(|i| (values[i] - self.value[i] - self.rise[i] * t) * self.down[i]);
        ([down[0] / turned[0], down[1] / turned[1]], turned)
    }

    /// The gap [m] at the distance t > 0; infinite where a profile has turned by a right angle, NaN where curves must be read.
    #[inline(always)]
    fn at(&self, t: f64) -> f64 {
        let ([wheel, rail], _) = self.below(t, self.read.at(t), self.turn);
        wheel + rail
    }

    /// The gap [m] and its slope dg/dt, also where curves must be read.
    #[inline(always)]
    fn opening(&self, t: f64) -> (f64, f64) {
        let read = self.read.at(t);
        let ([wheel, rail], turned) = self.below(t, read, self.turn);
        if (wheel + rail).is_nan() {
            return self.by_curves(t);
        }
        let unit = self.read.unit();
        let away = [0, 1].map(|i| (read.1[i] * unit[i] - self.sections[i].point.d1) / turned[i] * self.along[i] * self.down[i]);
        (wheel + rail, away[0] + away[1])
    }

    /// The same from the profiles' curves.
    #[cold]
    #[inline(never)]
    fn by_curves(&self, t: f64) -> (f64, f64) {
        let points = [0, 1].map(|i| self.sections[i].profile.at(self.sections[i].at + self.along[i] * t));
        let slope = self.sections.each_ref().map(|section| section.point.d1);
        let ([wheel, rail], turned) = self.below(t, (points.map(|p| p.value), points.map(|p| p.d1)), slope);
        let away = [0, 1].map(|i| (points[i].d1 - slope[i]) / turned[i] * self.along[i] * self.down[i]);
        (wheel + rail, away[0] + away[1])
    }
}

/// Relative step of t after which the search ends; the next one would be about its square. The distance scales the panels of
/// an integral, so its rounding must stay far below what the loop between normal and creep forces can see.
const SETTLED: f64 = 1e-5;
const ITERATIONS: usize = 40;

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
                let start = (0.5 * start).min(reach);
                let per_cos = sections.each_ref().map(|section| (1.0 + section.point.d1 * section.point.d1).sqrt());
                let (cos, at) = (per_cos.map(|per| 1.0 / per), sections.each_ref().map(|section| section.at));
                let profiles = sections.each_ref().map(|section| section.profile);
                let both = (profiles[0].piecewise(), profiles[1].piecewise());
                [-1.0, 1.0].map(|side| {
                    let along = cos.map(|cos| side * cos);
                    match both {
                        (Some(w), Some(r)) => {
                            one_side(&Gap::new(sections, per_cos, along, Along::new([w, r], at, along)), level, start, reach)
                        }
                        _ => one_side(&Gap::new(sections, per_cos, along, Any { profiles, at, along }), level, start, reach),
                    }
                })
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
            let t = from + half * (1.0 + x);
            let mut here = gap.at(t);
            if !(here < level) {
                if here.is_nan() {
                    here = gap.by_curves(t).0;
                }
                if !(here < level) {
                    return sum;
                }
            }
            largest = if here > largest { here } else { largest };
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

/// The distance t > 0 on one side at which the profiles have parted by `level`: Newton's method on the root of the gap, which for a
/// parabola is a straight line. Steps that leave the interval known to hold a root halve it or, while no end is known, double the
/// distance.
#[inline(always)]
fn part<R: Read>(gap: &Gap<R>, level: f64, start: f64, reach: f64) -> Option<f64> {
    let root = level.sqrt();
    let (mut t, mut inside, mut outside) = (start, 0.0f64, f64::INFINITY);
    for _ in 0..ITERATIONS {
        let (here, opening) = gap.opening(t);
        if here < level {
            inside = t;
            if inside > reach {
                return None;
            }
        } else {
            outside = t;
        }
        let root_here = here.sqrt();
        let next = t + 2.0 * root_here * (root - root_here) / opening;
        if (next - t).abs() <= SETTLED * t && opening > 0.0 {
            return (next <= reach).then_some(next);
        }
        // NaN where the gap is negative.
        t = if next > inside && next < outside && next <= 8.0 * t {
            next
        } else if outside.is_finite() {
            0.5 * (inside + outside)
        } else {
            2.0 * t
        };
    }
    (inside <= reach).then_some(inside)
}
