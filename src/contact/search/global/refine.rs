//! From a bracket of the scan to the stationary pair itself.
//!
//! In the section, with the trace C(u), its tangent T_w, the rail's point P(eta) and tangent T_r, a stationary pair solves
//!
//! ```text
//! (C - P) . T_r = 0,   T_r x T_w = 0
//! ```
//!
//! by Newton inside the bracket. Where that fails (a jump of curvature that throws it to and fro, a kink) the bracket is
//! narrowed on phi(u) with the exact foot, which never fails. At a kink of the wheel the trace stands still and its direction
//! turns from one side's to the other's (at yaw it runs along the kink's circle): phi is narrowed over the slope. At a kink
//! of the rail the wheel's normal counts: `(C - V) . T_w = 0` with the vertex V, also where the vertex has entered the wheel.

use super::branch::{Bracket, Scan, State};
use crate::geometry::profile::ProfilePoint;
use nalgebra::Vector2;

/// What stands at its kink, if any.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kink {
    #[default]
    None,
    Wheel,
    Rail,
}

/// A stationary pair in the section.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub u: f64,
    /// R' with which the wheel stands on the rail.
    pub slope: f64,
    pub eta: f64,
    pub distance: f64,
    pub kink: Kink,
    pub edge: bool,
}

/// Place to which Newton is driven, m.
const STEP: f64 = 1e-12;
/// phi that a jump leaves at least, rad; what is less is rounding.
const JUMP: f64 = 1e-7;

impl Scan<'_> {
    /// The rail's profile with its straight continuations.
    fn rail(&self, eta: f64) -> ProfilePoint {
        let knots = &self.search.rail.curve.knots;
        let (first, last) = self.search.rail.ends();
        if eta >= first && eta <= last {
            return self.pair.rail.profile.at(eta);
        }
        let k = if eta < first { &knots[0] } else { &knots[knots.len() - 1] };
        ProfilePoint { value: k.y + k.slope * (eta - k.x), d1: k.slope, d2: 0.0, d3: 0.0 }
    }

    fn off_rail(&self, eta: f64) -> bool {
        let (first, last) = self.search.rail.ends();
        eta <= first || eta >= last
    }

    /// `None` when the line along the rail enters the wheel there, so that nothing touches.
    pub fn refine(&self, bracket: &Bracket) -> Option<Spot> {
        let (a, b) = (bracket.a, bracket.b);
        let (low, high) = bracket.knots;
        if low == high {
            // The end of the wheel's profile.
            let wheel = self.pair.wheel.profile.at(a.u);
            let (eta, distance) = self.foot(a.u, &wheel, a.foot);
            return Some(Spot { u: a.u, slope: wheel.d1, eta, distance, kink: Kink::None, edge: true });
        }
        let spot = match if a.u < b.u { self.newton(&a, &b) } else { None } {
            Some(spot) => spot,
            None => self.careful(low, high, a, b)?,
        };
        let wheel = self.pair.wheel.profile.at(spot.u);
        (spot.kink == Kink::Wheel || self.view.speed(&wheel) > 0.0).then_some(spot)
    }

    #[cold]
    fn careful(&self, low: usize, high: usize, a: State, b: State) -> Option<Spot> {
        let (low, high, a, b) = if high - low > 1 { self.enclose(low, high, a, b, 1) } else { (low, high, a, b) };
        debug_assert!(high == low + 1);
        if self.search.wheel.stretches[low].length == 0.0 {
            return Some(self.wheel_kink(low, a, b));
        }
        self.newton(&a, &b).or_else(|| self.narrowed(a, b))
    }

    fn foot(&self, u: f64, wheel: &ProfilePoint, guess: f64) -> (f64, f64) {
        let trace = self.view.trace(u, wheel.value, wheel.d1);
        let near = self.search.rail.foot(&trace.point, guess);
        let exact = self.search.rail.exact(self.pair.rail.profile.as_ref(), &trace.point, &near);
        (exact.eta, exact.distance)
    }

    fn eta_at(&self, place: f64) -> f64 {
        let knots = &self.search.rail.curve.knots;
        let j = (place.max(0.0) as usize).min(knots.len() - 2);
        let share = (place - j as f64).clamp(0.0, 1.0);
        knots[j].x + share * (knots[j + 1].x - knots[j].x)
    }

    #[inline]
    fn newton(&self, a: &State, b: &State) -> Option<Spot> {
        let share = (a.phi / (a.phi - b.phi)).clamp(0.0, 1.0);
        let mut u = a.u + share * (b.u - a.u);
        let mut eta = self.eta_at(a.foot + share * (b.foot - a.foot));
        let slip = 0.01 * (b.u - a.u);
        let mut last = f64::INFINITY;
        for _ in 0..8 {
            let (wheel, rail) = (self.pair.wheel.profile.at(u), self.rail(eta));
            let trace = self.view.trace(u, wheel.value, wheel.d1);
            let gap = trace.point - Vector2::new(eta, rail.value);
            let tangent = Vector2::new(1.0, rail.d1);
            let (point_rate, tangent_rate) = self.view.rates(&wheel, &trace);
            let normal_row = (tangent.dot(&point_rate), -tangent.norm_squared() + gap.y * rail.d2);
            let parallel_row = (tangent.perp(&tangent_rate), -rail.d2 * trace.tangent.x);
            let (f, g) = (gap.dot(&tangent), tangent.perp(&trace.tangent));
            let determinant = normal_row.0 * parallel_row.1 - normal_row.1 * parallel_row.0;
            let du = (normal_row.1 * g - parallel_row.1 * f) / determinant;
            let deta = (parallel_row.0 * f - normal_row.0 * g) / determinant;
            let length = du.abs() + deta.abs();
            if !(length < 0.9 * last) && !(length < STEP) {
                return None;
            }
            u += du;
            eta += deta;
            if !(u >= a.u - slip && u <= b.u + slip) {
                return None;
            }
            // The next step is of the order of this one's square over the radius of curvature.
            if length < STEP || length * length < 1e-3 * STEP && last < 1e-3 {
                let distance = gap.dot(&Vector2::new(-rail.d1, 1.0)) / tangent.norm();
                let edge = self.off_rail(eta);
                return Some(Spot { u, slope: wheel.d1 + wheel.d2 * du, eta, distance, kink: Kink::None, edge });
            }
            last = length;
        }
        None
    }

    /// Narrows a change of sign over some parameter that runs from `a.u` to `b.u`.
    fn close(&self, mut a: State, mut b: State, at: impl Fn(f64, f64) -> State) -> (State, State) {
        for i in 0..120 {
            let share = if i % 3 == 2 { 0.5 } else { (a.phi / (a.phi - b.phi)).clamp(0.01, 0.99) };
            let m = at(a.u + share * (b.u - a.u), a.foot + share * (b.foot - a.foot));
            if (m.phi < 0.0) == (a.phi < 0.0) {
                a = m
            } else {
                b = m
            }
            if m.phi.abs() < 1e-15 || (b.u - a.u).abs() < 1e-14 {
                if m.phi.abs() < 1e-15 {
                    return (m, m);
                }
                break;
            }
        }
        (a, b)
    }

    pub fn narrowed(&self, a: State, b: State) -> Option<Spot> {
        let (a, b) = self.close(a, b, |u, guess| self.at(u, guess));
        let u = if a.phi.abs() < b.phi.abs() { a.u } else { b.u };
        let wheel = self.pair.wheel.profile.at(u);
        let rail = &self.search.rail;
        let kinked = |place: f64| place >= 0.0 && rail.curve.stretches.get(place as usize).is_some_and(|s| s.length == 0.0);
        let (from, to) = (a.foot.min(b.foot).max(0.0) as usize, a.foot.max(b.foot).max(0.0) as usize);
        let between = (from..=to.min(rail.curve.stretches.len() - 1)).find(|i| kinked(*i as f64));
        let jump = a.phi.abs().max(b.phi.abs()) > JUMP;
        if let Some(vertex) = between
            && (jump || from == to)
        {
            return self.rail_kink(u, vertex).or_else(|| self.plain(u, &wheel, a.foot, Kink::Rail));
        }
        self.plain(u, &wheel, a.foot, if jump { Kink::Wheel } else { Kink::None })
    }

    fn plain(&self, u: f64, wheel: &ProfilePoint, guess: f64, kink: Kink) -> Option<Spot> {
        let (eta, distance) = self.foot(u, wheel, guess);
        Some(Spot { u, slope: wheel.d1, eta, distance, kink, edge: self.off_rail(eta) })
    }

    fn wheel_kink(&self, stretch: usize, a: State, b: State) -> Spot {
        let (from, to) = (&self.search.wheel.knots[stretch], &self.search.wheel.knots[stretch + 1]);
        let at = |slope: f64, guess: f64| {
            let trace = self.view.trace(from.x, from.y, slope);
            let foot = self.search.rail.foot(&trace.point, guess);
            self.precise(slope, &trace.point, &trace.tangent, &foot)
        };
        let (a, b) = (State { u: from.slope, ..a }, State { u: to.slope, ..b });
        let found = self.close(a, b, at).0;
        let trace = self.view.trace(from.x, from.y, found.u);
        let near = self.search.rail.foot(&trace.point, found.foot);
        let exact = self.search.rail.exact(self.pair.rail.profile.as_ref(), &trace.point, &near);
        Spot { u: from.x, slope: found.u, eta: exact.eta, distance: exact.distance, kink: Kink::Wheel, edge: self.off_rail(exact.eta) }
    }

    /// The rail's vertex against the wheel's surface near `u`.
    fn rail_kink(&self, start: f64, vertex: usize) -> Option<Spot> {
        let (before, behind) = (&self.search.rail.curve.knots[vertex], &self.search.rail.curve.knots[vertex + 1]);
        let place = Vector2::new(before.x, before.y);
        let mut u = start;
        for _ in 0..20 {
            let wheel = self.pair.wheel.profile.at(u);
            let trace = self.view.trace(u, wheel.value, wheel.d1);
            let (point_rate, tangent_rate) = self.view.rates(&wheel, &trace);
            let gap = trace.point - place;
            let step = gap.dot(&trace.tangent) / (point_rate.dot(&trace.tangent) + gap.dot(&tangent_rate));
            u -= step.clamp(-1e-3, 1e-3);
            if step.abs() < STEP {
                let direction = trace.tangent.y.atan2(trace.tangent.x);
                let within = direction >= before.angle.min(behind.angle) && direction <= before.angle.max(behind.angle);
                let distance = trace.tangent.perp(&gap) / trace.tangent.norm();
                let spot = Spot { u, slope: wheel.d1, eta: before.x, distance, kink: Kink::Rail, edge: false };
                return (within && (u - start).abs() < 5e-3).then_some(spot);
            }
        }
        None
    }
}
