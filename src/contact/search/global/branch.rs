//! Branch and bound over the wheel's coordinate: brackets of all stationary distances below the reach.
//!
//! With phi the direction of the wheel's trace minus that of the rail at the foot, kappa their curvatures and s the length
//! along the trace,
//!
//! ```text
//! d' = sin phi,   phi' = kappa_w - cos phi kappa_r / (1 - kappa_r d)
//! ```
//!
//! so minima are where phi grows through 0. A block of stretches whose ends are known is done when
//!
//! 1. phi has one sign all over it (bounds of both directions, the rail's over the feet between those of the ends),
//! 2. phi' has one sign all over it: at most one root, which the ends show,
//! 3. d stays above the reach: `d >= (s2 d_a + s1 d_b - s1 s2 L) / (s1 + s2)`, slopes from -s1 to s2, length L,
//!
//! and is halved otherwise. A stretch that can't be decided so is halved on (`halve`) with its own bound on |phi'| and the rail's
//! curvature between the feet of its ends. The search gives up where a pair of minimum and maximum could differ in depth by no
//! more than `|phi'| L^2 / 8 = 2e-10 m`, or at a 64th of the stretch.
//!
//! *Steadiness.* For each part it is also noted by how much the wheel may move until the decision could be another: 1 holds while
//! phi keeps its margin, 2 while feet move by less than what the rail's bounds were widened by. Where phi' has opposite signs on
//! both sides of a knot, a pair may be born at the knot itself: there phi must keep away from 0; so it must opposite a joint of the
//! rail ([`super::joint`]).

use super::GlobalSearch;
use super::curve::Bounds;
use super::foot::Foot;
use super::motion::{MOST_STEADY, SWAY, less, more};
use super::view::View;
use super::watch::{Certificates, Extreme, WATCHED};
use crate::contact::search::algebraic::Pair;
use nalgebra::Vector2;

/// One place of the wheel seen from the rail.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub u: f64,
    pub distance: f64,
    pub phi: f64,
    pub foot: f64,
}

/// Two neighbouring places between which phi changes its sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bracket {
    pub a: State,
    pub b: State,
    /// Knots of the wheel at or around them; equal at an end of the wheel.
    pub knots: (usize, usize),
    /// Does phi grow?
    pub minimum: bool,
    /// Last place with a distance above the reach before it, and the next one behind it, u.
    pub basin: (f64, f64),
}

/// Most roots that are looked into; no pair of smooth profiles in use has more than nine. Where measured points are noisy there are more: then a crowd is made room for, and
/// the reach is lowered where even that is too little ([`Scan::crowded`]).
pub(super) const MOST: usize = 24;
pub(super) const CROWD: usize = 2048;
/// Halvings of a single stretch at most, and the difference in depth, m, of a pair of minimum and maximum that may be missed.
const DEPTH: usize = 6;
const SHALLOW: f64 = 2e-10;
/// Stretches over which Newton is trusted to find a root that is known to be the only one.
const NARROW: usize = 6;
/// Error of distances from knots, m, with a wide margin.
const ROUGH: f64 = 1e-5;
/// Directions from knots are trusted from here on, rad.
const TRUSTED: f64 = 2e-3;
/// A motion by some length turns the wheel by no more than that length over this arm, m.
pub(super) const ARM: f64 = 0.5;
/// Motions, m, for which a part of a stretch is tried to be certified by the sign of phi' (none: it tells at least how many roots there
/// are now).
const LOCAL: [f64; 5] = [MOST_STEADY, 3e-4, 1e-4, 2e-5, 0.0];
/// Certificates that are better than this, m, are not worth more halvings.
const USEFUL: f64 = 4e-5;

pub(super) struct Scan<'a> {
    pub search: &'a GlobalSearch,
    pub pair: &'a Pair<'a>,
    pub view: View,
    pub reach: f64,
    /// Where brackets are kept, if they are asked for: otherwise they are only counted.
    brackets: Option<&'a mut [Option<Bracket>]>,
    pub count: usize,
    /// Were there more roots than brackets?
    pub overflow: bool,
    /// Last place known to be above the reach, u.
    above: f64,
    pub clearance: f64,
    pub certificates: Certificates,
    /// Sign of phi' in the part that was decided last, if that was what decided it.
    pub bend: Option<bool>,
}

#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub phi: (f64, f64),
    pub rail: (f64, f64),
    pub distance: (f64, f64),
}

/// A stretch that bounds don't decide, with its greatest |phi'|, 1/m.
pub(super) struct Part<'a> {
    pub stretch: usize,
    pub most: f64,
    /// For what motion, m, bounds tell that phi has no root there.
    pub free: f64,
    pub limits: &'a Limits,
}

impl<'a> Scan<'a> {
    /// A scan that has not begun.
    pub fn seen(search: &'a GlobalSearch, pair: &'a Pair<'a>, view: View, reach: f64) -> Self {
        Scan {
            search,
            pair,
            view,
            reach,
            brackets: None,
            count: 0,
            overflow: false,
            above: search.wheel.knots[0].x,
            clearance: f64::INFINITY,
            certificates: Certificates::NONE,
            bend: None,
        }
    }

    pub fn run(search: &'a GlobalSearch, pair: &'a Pair<'a>, view: View, reach: f64, brackets: &'a mut [Option<Bracket>]) -> Self {
        let knots = &search.wheel.knots;
        let mut scan = Scan { brackets: Some(brackets), ..Scan::seen(search, pair, view, reach) };
        let last = knots.len() - 1;
        let a = scan.at_knot(0, 0.0);
        let b = scan.at_knot(last, search.rail.curve.stretches.len() as f64);
        // An end of the profile is a minimum when the distance grows from it inward.
        if a.phi >= 0.0 && a.distance < reach {
            scan.found(a, a, (0, 0), true);
        }
        scan.block(1, 0, search.leaves, &a, &b);
        if b.phi < 0.0 && b.distance < reach {
            scan.found(b, b, (last, last), true);
        }
        for bracket in scan.kept() {
            if bracket.basin.1.is_infinite() {
                bracket.basin.1 = b.u;
            }
        }
        scan
    }

    /// Scans the stretches between two knots alone; the rail lies opposite the wheel about where eta - u is `offset` [m]. Returns
    /// what is at both ends.
    pub fn part(&mut self, (from, to): (usize, usize), offset: f64) -> (State, State) {
        self.bend = None;
        let first = self.at_knot(from, self.search.rail.place(self.search.wheel.knots[from].x + offset));
        let mut a = first;
        for stretch in from..to {
            let b = self.at_knot(stretch + 1, a.foot);
            self.block(self.search.leaves + stretch, stretch, 1, &a, &b);
            a = b;
        }
        (first, a)
    }

    #[inline]
    fn at_knot(&self, knot: usize, guess: f64) -> State {
        let knot = &self.search.wheel.knots[knot];
        let trace = self.view.trace(knot.x, knot.y, knot.slope);
        let foot = self.search.rail.foot(&trace.point, guess);
        let phi = self.view.turn + knot.angle - self.view.yaw_turn(knot.slope) - foot.angle;
        if phi.abs() < TRUSTED { self.precise(knot.x, &trace.point, &trace.tangent, &foot) } else { state(knot.x, &foot, phi) }
    }

    /// Any place on a stretch of wheel, from the profiles themselves.
    pub fn at(&self, u: f64, guess: f64) -> State {
        let wheel = self.pair.wheel.profile.at(u);
        let trace = self.view.trace(u, wheel.value, wheel.d1);
        let foot = self.search.rail.foot(&trace.point, guess);
        self.precise(u, &trace.point, &trace.tangent, &foot)
    }

    pub fn precise(&self, u: f64, point: &Vector2<f64>, tangent: &Vector2<f64>, foot: &Foot) -> State {
        let exact = self.search.rail.exact(self.pair.rail.profile.as_ref(), point, foot);
        let (sin, cos) = (exact.tangent.perp(tangent), exact.tangent.dot(tangent));
        // Only the sign and the size near 0 matter.
        let phi = if sin.abs() < cos { sin / cos } else { sin.atan2(cos) };
        State { u, distance: exact.distance, phi, foot: foot.place }
    }

    pub fn bracket(&self, i: usize) -> Option<&Bracket> {
        self.brackets.as_ref()?[i].as_ref()
    }

    fn kept(&mut self) -> impl DoubleEndedIterator<Item = &mut Bracket> {
        let count = self.count;
        self.brackets.iter_mut().flat_map(move |brackets| brackets[..count].iter_mut().flatten())
    }

    /// Notes a change of sign.
    fn found(&mut self, a: State, b: State, knots: (usize, usize), minimum: bool) {
        let basin = (self.above, f64::INFINITY);
        match &mut self.brackets {
            Some(brackets) if self.count < brackets.len() => brackets[self.count] = Some(Bracket { a, b, knots, minimum, basin }),
            Some(_) => {
                self.overflow = true;
                return;
            }
            None => {}
        }
        self.count += 1;
    }

    /// A lower reach, where there was no room for all roots below this one: the middle one of the least distances that were seen. The deepest of all lie below it.
    #[cold]
    pub fn crowded(&self) -> Option<f64> {
        if !self.overflow {
            return None;
        }
        let brackets = self.brackets.as_ref()?.iter().flatten().filter(|bracket| bracket.minimum);
        let mut depths: Vec<f64> = brackets.map(|bracket| bracket.a.distance.min(bracket.b.distance)).collect();
        depths.sort_unstable_by(f64::total_cmp);
        let middle = depths.get(depths.len() / 2)?;
        (*middle < self.reach).then_some(*middle)
    }

    /// The search has come to `u`, where the distance is above the reach.
    #[inline]
    fn leave(&mut self, u: f64) {
        self.above = u;
        for bracket in self.kept().rev() {
            if bracket.basin.1.is_finite() {
                break;
            }
            bracket.basin.1 = u;
        }
    }

    /// Bounds over a block of the wheel.
    #[inline]
    fn limits(&self, wheel: &Bounds, a: &State, b: &State) -> Limits {
        let view = &self.view;
        let curl = view.most_yaw_turn(wheel.steepest);
        let length = self.trace_length(wheel);
        // Feet run forward all the way while the trace does and faces the rail.
        let backward = more(a.phi.abs(), b.phi.abs()) > 1.3 || view.k2 * wheel.swell * wheel.curvature.0 < -0.9;
        let rail = self.search.rail.facing(a.foot, b.foot, if backward { 1.5 * length } else { 0.0 });
        let phi = (view.turn + wheel.angle.0 - curl - rail.angle.1, view.turn + wheel.angle.1 + curl - rail.angle.0);
        let (down, up) = (less(more(-phi.0, 0.0), 1.0), less(more(phi.1, 0.0), 1.0));
        let (lower, upper) = if a.distance < b.distance { (a.distance, b.distance) } else { (b.distance, a.distance) };
        let low = if down > 0.0 && up > 0.0 {
            less((up * a.distance + down * b.distance - down * up * length) / (down + up), lower)
        } else {
            lower
        };
        let high = upper + 0.5 * length * more(up, down);
        Limits { phi, rail: rail.curvature, distance: (low - ROUGH, high + ROUGH) }
    }

    /// Least and greatest phi' over a block, 1/m; infinite where unknown. Where the foot jumps across a convex place of the rail
    /// phi jumps upward, so that the lower bound holds there too.
    #[inline]
    pub fn bending(&self, wheel: &Bounds, limits: &Limits) -> (f64, f64) {
        let most = more(limits.phi.0.abs(), limits.phi.1.abs());
        let cos = 1.0 - 0.5 * most * most;
        let own = trace_curvature(wheel, self.view.k2);
        if cos <= 0.0 {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        // kappa / (1 - kappa d) grows with both; the factor lies between cos and 1. The motion changes d too.
        let (near, far) = (limits.distance.0 - MOST_STEADY, limits.distance.1 + MOST_STEADY);
        let open = 1.0 - limits.rail.1 * far;
        let high = if open < 0.05 {
            f64::INFINITY
        } else if limits.rail.1 < 0.0 {
            limits.rail.1 * cos / open
        } else {
            limits.rail.1 / open
        };
        let open = 1.0 - limits.rail.0 * near;
        let low = if open < 0.05 {
            f64::NEG_INFINITY
        } else if limits.rail.0 < 0.0 {
            limits.rail.0 / open
        } else {
            limits.rail.0 * cos / open
        };
        (own.0 - high, own.1 - low)
    }

    /// How much phi changes at most for a motion by one metre, 1/m: the foot moves along a curved rail, and the wheel turns.
    pub fn turning(rail: (f64, f64), distance: f64) -> f64 {
        let swing = |c: f64| (c / more(1.0 - c * distance, 0.1)).abs();
        1.2 * more(swing(rail.0), swing(rail.1)) + 1.0 / ARM
    }

    fn block(&mut self, block: usize, first: usize, size: usize, a: &State, b: &State) {
        if size > self.search.coarse {
            return self.split(block, first, size, a, b);
        }
        let wheel = &self.search.tree[block];
        let limits = self.limits(wheel, a, b);
        if limits.distance.0 > self.reach + MOST_STEADY {
            return self.beyond(limits.distance.0, a, b);
        }
        // Feet that move by the slack are within the bounds already; directions turn with the wheel.
        let margin = more(limits.phi.0, -limits.phi.1);
        if margin > MOST_STEADY / ARM {
            return self.pass(b);
        }
        let bending = self.bending(wheel, &limits);
        if bending.0 > 0.0 || bending.1 < 0.0 {
            let minimum = bending.0 > 0.0;
            self.bent(minimum, &limits, a);
            if (a.phi < 0.0) == minimum && (b.phi < 0.0) != minimum {
                self.descend(first, (first + size).min(self.search.wheel.stretches.len()), a, b, minimum);
            }
            return self.leave_if_far(b);
        }
        if limits.distance.0 > self.reach {
            return self.beyond(limits.distance.0, a, b);
        }
        let free = margin * ARM;
        if free >= WATCHED {
            self.certificates.add(free, (first, (first + size).min(self.search.wheel.stretches.len())));
            return self.pass(b);
        }
        if size == 1 {
            return self.stretch(first, free, &bending, &limits, a, b);
        }
        self.split(block, first, size, a, b);
    }

    fn split(&mut self, block: usize, first: usize, size: usize, a: &State, b: &State) {
        let half = size / 2;
        let middle = first + half;
        let last = self.search.wheel.stretches.len();
        if middle >= last {
            return self.block(2 * block, first, half, a, b);
        }
        let m = self.at_knot(middle, 0.5 * (a.foot + b.foot));
        self.block(2 * block, first, half, a, &m);
        self.block(2 * block + 1, middle, half, &m, b);
    }

    /// A block that stays above the reach.
    #[inline]
    fn beyond(&mut self, least: f64, a: &State, b: &State) {
        self.bend = None;
        self.clearance = self.clearance.min(least);
        self.leave(a.u);
        self.above = b.u;
    }

    #[inline]
    fn pass(&mut self, b: &State) {
        self.bend = None;
        self.leave_if_far(b);
    }

    #[inline]
    fn leave_if_far(&mut self, b: &State) {
        if b.distance > self.reach {
            self.leave(b.u);
        }
    }

    /// From `a` on phi' has one sign. If it had the other one before, a pair may be born at `a`.
    #[inline]
    pub fn bent(&mut self, grows: bool, limits: &Limits, a: &State) {
        if self.bend.replace(grows) == Some(!grows) {
            let motion = a.phi.abs() / Self::turning(limits.rail, limits.distance.0);
            self.certificates.point(motion, Extreme::Wheel(a.u), a.phi);
        }
    }

    /// The one root in a block, enclosed between knots not far apart.
    fn descend(&mut self, first: usize, last: usize, a: &State, b: &State, minimum: bool) {
        let (low, high, a, b) = self.enclose(first, last, *a, *b, NARROW);
        self.found(a, b, (low, high), minimum);
    }

    /// Knots at most `width` apart between which phi changes its sign.
    pub fn enclose(&self, mut low: usize, mut high: usize, mut a: State, mut b: State, width: usize) -> (usize, usize, State, State) {
        while high - low > width {
            // The chord, pulled to the middle.
            let share = (0.2 + 0.6 * a.phi / (a.phi - b.phi)).clamp(0.0, 1.0);
            let middle = (low + (share * (high - low) as f64) as usize).clamp(low + 1, high - 1);
            let m = self.at_knot(middle, a.foot + share * (b.foot - a.foot));
            if (m.phi < 0.0) == (a.phi < 0.0) { (low, a) = (middle, m) } else { (high, b) = (middle, m) }
        }
        (low, high, a, b)
    }

    /// A stretch that bounds don't decide.
    fn stretch(&mut self, stretch: usize, free: f64, bending: &(f64, f64), limits: &Limits, a: &State, b: &State) {
        let wheel = &self.search.wheel.stretches[stretch];
        if wheel.length == 0.0 {
            self.certificates.add(0.0, (stretch, stretch + 1));
            self.bend = None;
            self.ends(stretch, a, b);
        } else {
            let most = bending.1.max(-bending.0);
            self.halve(&Part { stretch, most, free, limits }, self.trace_length(wheel), DEPTH, a, b);
        }
        self.leave_if_far(b);
    }

    #[inline]
    fn trace_length(&self, wheel: &Bounds) -> f64 {
        wheel.length * (1.0 + self.view.k2 * wheel.steepest * wheel.steepest) + self.view.k2 * wheel.swing
    }

    /// Looks at a part of a stretch, `length` long.
    fn halve(&mut self, whole: &Part, length: f64, depth: usize, a: &State, b: &State) {
        let same = (a.phi < 0.0) == (b.phi < 0.0);
        let knots = (whole.stretch, whole.stretch + 1);
        let wheel = &self.search.wheel.stretches[whole.stretch];
        let most = more(a.phi.abs(), b.phi.abs()) + whole.most * length;
        // For what motion phi stays away from 0.
        let mut free = whole.free;
        for motion in LOCAL {
            if free > 0.0 && free >= less(less(self.certificates.steady, USEFUL), motion) {
                self.certificates.add(free, knots);
                self.bend = None;
                return;
            }
            let (from, to) = self.search.rail.within(a.foot, b.foot, SWAY * motion);
            let rail = self.search.rail.over(from, to).curvature;
            let bending = self.bending(wheel, &Limits { phi: (-most, most), rail, ..*whole.limits });
            if bending.0 > 0.0 || bending.1 < 0.0 {
                self.certificates.add(motion, knots);
                self.bent(bending.0 > 0.0, whole.limits, a);
                return self.ends(whole.stretch, a, b);
            }
            if self.beside_joint(whole, (motion, from, to), most, a, b) {
                return;
            }
            if same {
                let margin = 0.5 * ((a.phi + b.phi).abs() - more(bending.1, -bending.0) * length);
                free = more(free, less(motion, margin / Self::turning(rail, whole.limits.distance.0)));
            }
        }
        if depth == 0 || whole.most * length * length < 8.0 * SHALLOW {
            self.certificates.add(more(free, 0.0), knots);
            self.bend = None;
            return self.ends(whole.stretch, a, b);
        }
        let m = self.at(0.5 * (a.u + b.u), 0.5 * (a.foot + b.foot));
        self.halve(whole, 0.5 * length, depth - 1, a, &m);
        self.halve(whole, 0.5 * length, depth - 1, &m, b);
    }

    pub fn ends(&mut self, stretch: usize, a: &State, b: &State) {
        if (a.phi < 0.0) != (b.phi < 0.0) && a.distance.min(b.distance) < self.reach + 1e-3 {
            self.found(*a, *b, (stretch, stretch + 1), a.phi < 0.0);
        }
    }
}

#[inline]
fn state(u: f64, foot: &Foot, phi: f64) -> State {
    State { u, distance: foot.distance, phi, foot: foot.place }
}

/// Bounds on the trace's curvature, `kappa / ((1 + ..k^2) (1 + k^2 swell kappa))` in sense; infinite where the trace may turn
/// back.
#[inline]
pub(super) fn trace_curvature(wheel: &Bounds, k2: f64) -> (f64, f64) {
    let slope = 2.0 * k2 * (1.0 + wheel.steepest * wheel.steepest);
    if slope > 0.9 {
        return (f64::NEG_INFINITY, f64::INFINITY);
    }
    let (low, high) = wheel.curvature;
    let swell = k2 * wheel.swell;
    let low = if low >= 0.0 {
        low / ((1.0 + slope) * (1.0 + swell * low))
    } else {
        let speed = (1.0 - slope) + swell * low;
        if speed < 0.1 { f64::NEG_INFINITY } else { low / ((1.0 - slope) * speed) }
    };
    let high = if high >= 0.0 { high / (1.0 - slope) } else { high / (1.0 + slope) };
    (low, high)
}
