//! Patches of one wheel, from its strips: where they are, how large, and how far two of them are one.
//!
//! Load over the arc length has humps. Where the valley between two of them is deeper than 0.8 of the lower hump they begin to be patches of their own,
//! and are so wholly where nothing is pressed between them: `independence` grows smoothly from 0 to 1 on the way. What is made of the parts is mixed from
//! the whole and the parts by it, so that nothing jumps where patches join, part or disappear.
//!
//! A part has the ellipse of its moments, as in Hertz's theory: `b^2 = 5 <(y - <y>)^2>` and `a^2 = 5/4 <a_i^2>`, means by load.

use super::pressed::Pressed;
use super::rail::RailStrips;
use crate::contact::{Material, Patch};
use crate::geometry::profile::{Profile, ProfilePoint};
use crate::math::smooth_step::cubic_step;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::ops::Range;

/// Parts that a wheel may have.
pub const MOST: usize = 4;
/// A valley above this part of the lower hump makes no parts.
const SHALLOW: f64 = 0.8;

/// Humps that are looked at before the shallowest valleys are filled.
const HUMPS: usize = 16;

/// Parts in the order of the strips.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    humps: [Hump; HUMPS],
    count: usize,
}

/// A part, and the valley behind it.
#[derive(Clone, Debug, Default)]
struct Hump {
    strips: Range<usize>,
    /// Largest load over the arc length in it, and least behind it, N/m.
    peak: f64,
    valley: f64,
    /// Share of the lowest strip of the valley that belongs to this part; the rest belongs to the next part, whose range begins with it. `None` where
    /// nothing is pressed in the valley.
    cut: Option<f64>,
}

/// Strips of a part, the first and the last of which may belong to it in parts.
#[derive(Clone, Copy, Debug)]
pub struct Share<'a> {
    strips: &'a [Pressed],
    first: f64,
    last: f64,
}

impl<'a> Share<'a> {
    pub(super) fn loads(self) -> impl Iterator<Item = (f64, &'a Pressed)> + Clone {
        let last = self.strips.len() - 1;
        self.strips.iter().enumerate().map(move |(k, strip)| {
            let share = if k == 0 { self.first } else { 1.0 } * if k == last { self.last } else { 1.0 };
            (share, strip)
        })
    }

    /// Sum of its loads, N.
    pub fn load(self) -> f64 {
        self.loads().map(|(share, strip)| share * strip.load).sum()
    }

    /// The highest pressure, Pa: 2 q / (pi a), a from the load q over the width as in [`Part`], q where it is highest.
    pub fn highest_pressure(self, material: Material) -> f64 {
        let (mut squares, mut work) = (0.0, 0.0);
        for (part, strip) in self.loads() {
            squares += part * strip.load * strip.load / strip.width;
            work += part * strip.load * strip.depth;
        }
        let modulus = material.contact_modulus();
        let length = proportion(squares / (modulus * work)) / modulus;
        // a^2 = length q / kappa.
        let of = |k: usize| (peak(self.strips, k) * self.strips[k].strip.curvature / length).sqrt() * 2.0 / PI;
        (0..self.strips.len()).filter(|k| self.strips[*k].load > 0.0).map(of).fold(0.0, f64::max)
    }
}

/// Load over the width at the highest place in strip `k`, N/m: of the parabola whose means over it and over the strips beside it are theirs, where these are as wide.
/// On a flange that two or three strips carry the means alone were up to 22 % below the highest pressure.
fn peak(strips: &[Pressed], k: usize) -> f64 {
    let own = &strips[k];
    let beside = |other: Option<usize>| {
        other.and_then(|other| strips.get(other)).filter(|other| other.number.abs_diff(own.number) == 1 && other.load > 0.0)
    };
    let near = [beside(k.checked_sub(1)), beside(Some(k + 1))];
    let width = near.iter().flatten().fold(own.width, |width, other| width.max(other.width));
    let mean = own.load / own.width;
    if width > WIDER * own.width {
        return mean;
    }
    let [before, after] = near.map(|other| other.map_or(0.0, |other| other.load / width));
    let (slope, bend) = (0.5 * (after - before), before - 2.0 * mean + after);
    if !(bend < 0.0) {
        return mean;
    }
    let place = (-slope / bend).clamp(-0.5, 0.5);
    mean.max(mean - bend / 24.0 + place * (slope + 0.5 * bend * place))
}

/// Strips up to so many times as wide as one count as wide as it.
const WIDER: f64 = 1.15;

/// Where a range of strips presses.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Sum of all loads, N: what friction is bounded by.
    pub load: f64,
    /// Size of the sum of all strips' forces, N, and its direction out of the rail.
    pub force: f64,
    pub normal: Vector3<f64>,
    /// Moment of all strips' forces about the centre of load, N m: their directions change across. With it the forces of parts have the moment that those of
    /// the whole have. (A table does not know it: 3.5 N m at 55 kN on a tread of S1002.)
    pub couple: Vector3<f64>,
    /// Along the rail, at right angles to that, not unit.
    pub forward: Vector3<f64>,
    /// Centre of load on the undeformed wheel, from the wheelset's centre, m.
    pub arm: Vector3<f64>,
    /// Ahead of it along the track, m.
    pub lead: f64,
    /// Largest overlap, m.
    pub overlap: f64,
    /// Coordinates of wheel and rail at the centre, m; the profiles there, their curvature that of a line of least squares through the slopes.
    pub coordinates: [f64; 2],
    pub profiles: [ProfilePoint; 2],
    pub patch: Patch,
    /// Mean of the squares of its strips' half lengths by load, m^2.
    pub mean_square: f64,
}

impl Parts {
    /// Finds at most `most` parts.
    pub fn new(pressed: &[Pressed], rail: &RailStrips, most: usize) -> Parts {
        let mut parts = Parts::default();
        let density = |k: usize| density(&pressed[k]);
        let joined = |k: usize| k + 1 < pressed.len() && pressed[k + 1].load > 0.0 && pressed[k + 1].number == pressed[k].number + 1;
        let mut k = 0;
        while k < pressed.len() {
            if !(pressed[k].load > 0.0) {
                k += 1;
                continue;
            }
            let begin = k;
            while joined(k) && density(k + 1) >= density(k) {
                k += 1;
            }
            let peak = extreme(pressed, rail, k);
            while joined(k) && density(k + 1) <= density(k) {
                k += 1;
            }
            let (valley, cut) = if joined(k) { (extreme(pressed, rail, k), Some(cut(pressed, rail, k))) } else { (0.0, None) };
            if parts.count == HUMPS {
                parts.fill_shallowest();
            }
            parts.humps[parts.count] = Hump { strips: begin..k + 1, peak, valley, cut };
            parts.count += 1;
            // The lowest strip belongs to both sides.
            k += usize::from(parts.humps[parts.count - 1].cut.is_none());
        }
        while parts.count > 1 && (parts.count > most.min(MOST) || parts.shallowest().1 > SHALLOW) {
            parts.fill_shallowest();
        }
        parts
    }

    /// The part whose valley is the shallowest, and its height over the lower hump beside it.
    fn shallowest(&self) -> (usize, f64) {
        let height = |k: usize| self.humps[k].valley / lower(self.humps[k].peak, self.humps[k + 1].peak);
        let highest = (0..self.count - 1).max_by(|a, b| height(*a).total_cmp(&height(*b))).unwrap_or(0);
        (highest, height(highest))
    }

    /// Joins the parts on both sides of that valley.
    fn fill_shallowest(&mut self) {
        let at = self.shallowest().0;
        let next = self.humps[at + 1].clone();
        let own = &mut self.humps[at];
        *own = Hump { strips: own.strips.start..next.strips.end, peak: own.peak.max(next.peak), ..next };
        self.humps[at + 1..self.count].rotate_left(1);
        self.count -= 1;
    }

    pub fn len(&self) -> usize {
        self.count
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// What belongs to the parts from `first` to `last`.
    pub fn share<'a>(&self, pressed: &'a [Pressed], first: usize, last: usize) -> Share<'a> {
        let before = first.checked_sub(1).and_then(|before| self.humps[before].cut);
        let behind = if last + 1 < self.count { self.humps[last].cut } else { None };
        let strips = &pressed[self.humps[first].strips.start..self.humps[last].strips.end];
        Share { strips, first: before.map_or(1.0, |cut| 1.0 - cut), last: behind.unwrap_or(1.0) }
    }

    /// The part, not the last of them, behind which the parts from `first` to `last` are most independent, and how much: by the height of the valley
    /// over the lower one of the highest humps on both sides.
    pub fn divide(&self, first: usize, last: usize) -> (usize, f64) {
        let highest = |from: usize, to: usize| self.humps[from..=to].iter().map(|hump| hump.peak).fold(0.0, f64::max);
        let height = |k: usize| self.humps[k].valley / lower(highest(first, k), highest(k + 1, last));
        let deepest = (first..last).min_by(|a, b| height(*a).total_cmp(&height(*b))).unwrap_or(first);
        (deepest, cubic_step(1.0 - height(deepest) / SHALLOW))
    }
}

/// Load over the pressed width of a strip, N/m.
fn density(own: &Pressed) -> f64 {
    own.load / own.width
}

/// The lower one of two peaks, without a kink where they are equal: there it is 8 % lower than both, 1 % where one is a third higher.
fn lower(one: f64, other: f64) -> f64 {
    let (low, high) = if one < other { (one, other) } else { (other, one) };
    let eighth = (low / high).powi(8);
    low / (1.0 + eighth).sqrt().sqrt().sqrt()
}

/// The load over the arc length about strip `k` as a quadratic spline whose knots are the edges of the strips and whose coefficients are their densities:
/// slopes at both edges, N/m^2, and what it is at the first, N/m.
///
/// Its slope goes through zero in the strips that are higher, or lower, than their neighbours, and its extremes go with the loads without a kink where
/// the next strip becomes the extreme one.
fn about(pressed: &[Pressed], rail: &RailStrips, k: usize) -> ([f64; 2], f64) {
    let (own, strip) = (density(&pressed[k]), rail.strip(pressed[k].number));
    let beside = |other: Option<usize>| {
        let known = other.and_then(|other| pressed.get(other)).filter(|other| other.number.abs_diff(pressed[k].number) == 1);
        known.map_or((0.0, strip.width), |other| (density(other), rail.strip(other.number).width))
    };
    let ((before, narrow), (after, wide)) = (beside(k.checked_sub(1)), beside(Some(k + 1)));
    let slopes = [(own - before) / (0.5 * (strip.width + narrow)), (after - own) / (0.5 * (strip.width + wide))];
    (slopes, (strip.width * before + narrow * own) / (strip.width + narrow))
}

/// The highest or lowest load over the arc length in a strip that is higher or lower than its neighbours, N/m.
fn extreme(pressed: &[Pressed], rail: &RailStrips, k: usize) -> f64 {
    let ([first, last], edge) = about(pressed, rail, k);
    edge + 0.5 * rail.strip(pressed[k].number).width * first * share_before(first, last)
}

/// Share of the lowest strip `k` of a valley that lies before the valley's middle; it moves on to the next strip where that becomes the lowest.
fn cut(pressed: &[Pressed], rail: &RailStrips, k: usize) -> f64 {
    let ([first, last], _) = about(pressed, rail, k);
    share_before(first, last)
}

/// Where a slope that goes evenly from the first to the last goes through zero.
fn share_before(first: f64, last: f64) -> f64 {
    if first == last { 0.5 } else { (first / (first - last)).clamp(0.0, 1.0) }
}

/// Mean of a coordinate by load, and the slope of `value` over it.
fn line(share: Share, load: f64, value: impl Fn(&Pressed) -> f64, coordinate: impl Fn(&Pressed) -> f64) -> (f64, f64, f64) {
    let (mut x, mut y) = (0.0, 0.0);
    for (share, strip) in share.loads() {
        let own = share * strip.load;
        x += own * coordinate(strip);
        y += own * value(strip);
    }
    (x, y) = (x / load, y / load);
    let (mut square, mut both) = (0.0, 0.0);
    for (share, strip) in share.loads() {
        let (own, apart) = (share * strip.load, coordinate(strip) - x);
        square += own * (apart * apart);
        both += own * (apart * (value(strip) - y));
    }
    (square, both) = (square / load, both / load);
    (x, y, if square > 0.0 { both / square } else { f64::NAN })
}

/// lambda of the patch's proportions g (see [`super`]).
fn proportion(g: f64) -> f64 {
    4.0 / PI * (1.0 + 1.960_923_4 * g.powf(3.293_396)).powf(-0.269_668)
}

impl Part {
    /// Sums over strips, of which one at least carries load.
    pub fn new(share: Share, rail: &RailStrips, wheel: &dyn Profile, material: Material) -> Part {
        let (mut load, mut lead, mut overlap) = (0.0, 0.0, 0.0f64);
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let (mut arm, mut forward) = (Vector3::zeros(), Vector3::zeros());
        let (mut arc, mut lengths, mut squares, mut mean_square) = (0.0, 0.0, 0.0, 0.0);
        let (mut work, mut height, mut radius) = (0.0, 0.0, 0.0);
        for (part, Pressed { number, strip, load: own, width, offset, depth, half_length }) in share.loads() {
            let at = rail.strip(*number);
            let density = own / width;
            let own = &(part * own);
            load += own;
            // The pressed surface lies half way between both: alike bodies yield alike.
            let (pressed, place) = ((strip.normal + strip.against) * (0.5 * own), strip.point - strip.normal * strip.overlap);
            force += pressed;
            moment += place.cross(&pressed);
            forward += strip.forward * *own;
            arm += place * *own;
            lead += own * strip.lead;
            arc += own * (at.arc + offset);
            lengths += own * density / strip.curvature;
            squares += own * density;
            work += own * depth;
            mean_square += own * half_length * half_length;
            height += own * at.profile.value;
            radius += own * strip.radius;
            overlap = overlap.max(if *own > 0.0 { part * depth } else { 0.0 });
        }
        let per_load = 1.0 / load;
        let modulus = material.contact_modulus();
        lengths *= proportion(squares / (modulus * work)) / modulus;
        arc *= per_load;
        let apart = |own: &Pressed| (rail.strip(own.number).arc + own.offset - arc).powi(2) + own.width * own.width / 12.0;
        let spread: f64 = share.loads().map(|(part, own)| part * own.load * apart(own)).sum();
        let size = force.norm();
        let (u, wheel_slope, wheel_bend) = line(share, load, |own| own.strip.slope, |own| own.strip.wheel);
        let (eta, rail_slope, rail_bend) = line(share, load, |own| rail.strip(own.number).profile.d1, |own| rail.strip(own.number).eta);
        let wheel_bend = if wheel_bend.is_finite() { wheel_bend } else { wheel.at(u).d2 };
        let rail_bend = if rail_bend.is_finite() { rail_bend } else { rail.strip(share.strips[0].number).profile.d2 };
        Part {
            load,
            force: size,
            normal: force / size,
            couple: moment - (arm * per_load).cross(&force),
            forward: (forward - force * (force.dot(&forward) / (size * size))) * per_load,
            arm: arm * per_load,
            lead: lead * per_load,
            overlap,
            coordinates: [u, eta],
            profiles: [
                ProfilePoint { value: radius * per_load, d1: wheel_slope, d2: wheel_bend, d3: 0.0 },
                ProfilePoint { value: height * per_load, d1: rail_slope, d2: rail_bend, d3: 0.0 },
            ],
            patch: Patch { a: (1.25 * lengths * per_load).sqrt(), b: (5.0 * spread * per_load).sqrt() },
            mean_square: mean_square * per_load,
        }
    }
}
