//! The part of a wheel where another contact may be born soon, looked at alone.
//!
//! What a search decides holds until the wheel has moved by some length. Where wheel and rail are nearly conformal (S1002 on 60E1: two
//! places) that length may be nothing, all over the rest of the wheel it is 0.5 mm and more. So a search keeps two lengths: how
//! long all of it holds (`steady`), and how long it holds but for what decides by less than [`WATCHED`] (`apart`). Until the
//! wheel has moved by `apart`, only that is looked at again:
//!
//! *Points* where phi is extreme, between parts in which phi' keeps its sign: a joint of the rail ([`super::joint`]) or a place of the
//! wheel where its own curvature jumps. As long as phi keeps its sign there, nothing has been born or has gone.
//!
//! *Stretches* that bounds don't decide, each scanned by the same decisions as in a search. As long as a run of them holds as
//! many stationary distances as before, and phi at both ends has the sign that it had, so that none has come in or has gone out, no
//! contact has been born or has gone.

use super::motion::{MOST_STEADY, less};

/// What holds for less than this motion, m, is watched.
pub(super) const WATCHED: f64 = 2.0 / 3.0 * MOST_STEADY;
/// Most stretches that are scanned alone, most runs of them and the longest way from the first to the last: more are not quicker than a
/// search.
const MOST_STRETCHES: u32 = 24;
const MOST_RUNS: usize = 8;
const LONGEST: usize = 48;
/// Bits of a run in the signature, the two signs among them.
pub(super) const BITS: u32 = 6;
/// Most points that are watched.
pub const POINTS: usize = 3;

/// A place where phi is extreme.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Extreme {
    /// Opposite this knot of the rail.
    Joint(usize),
    /// At this coordinate of the wheel, m.
    Wheel(f64),
}

/// Such a place, and the sign of phi there.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Point {
    pub place: Extreme,
    pub above: bool,
}

/// What is watched, and what was found there.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Watch {
    /// A knot of the wheel, and the stretches from there on: the lowest bit is the first.
    pub first: usize,
    pub stretches: u64,
    /// For each run of neighbours among them the number of stationary distances, least and greatest, and the signs of phi at
    /// both ends; below 2^48.
    pub signature: u64,
    pub points: [Option<Point>; POINTS],
}

impl Watch {
    pub fn is_empty(&self) -> bool {
        self.stretches == 0 && self.points[0].is_none()
    }

    /// First and last knot of each run.
    pub(super) fn runs(&self) -> impl Iterator<Item = (usize, usize)> {
        let (mut at, mut rest) = (self.first, self.stretches);
        std::iter::from_fn(move || {
            let gap = rest.trailing_zeros();
            rest = rest.checked_shr(gap)?;
            let length = rest.trailing_ones();
            let from = at.saturating_add(gap as usize);
            at = from.saturating_add(length as usize);
            rest = rest.checked_shr(length).unwrap_or(0);
            Some((from, at))
        })
    }
}

/// Certificates of a scan, collected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Certificates {
    /// The least of all, m.
    pub steady: f64,
    /// The least of those that are not watched, m.
    apart: f64,
    watch: Watch,
    /// Are they too far apart?
    wide: bool,
}

impl Certificates {
    pub const NONE: Certificates = Certificates {
        steady: MOST_STEADY,
        apart: MOST_STEADY,
        watch: Watch { first: 0, stretches: 0, signature: 0, points: [None; POINTS] },
        wide: false,
    };

    /// A decision between two knots that holds for a `motion` [m].
    #[inline]
    pub fn add(&mut self, motion: f64, (from, to): (usize, usize)) {
        self.steady = less(motion, self.steady);
        if motion >= WATCHED {
            self.apart = less(motion, self.apart);
        } else {
            self.watch(from, to);
        }
    }

    fn watch(&mut self, from: usize, to: usize) {
        let watch = &mut self.watch;
        let first = if watch.stretches == 0 { from } else { watch.first.min(from) };
        let last = first.max(watch.first + (u64::BITS - watch.stretches.leading_zeros()) as usize).max(to);
        if last - first > LONGEST {
            self.wide = true;
            return;
        }
        let known = if watch.stretches == 0 { 0 } else { watch.stretches << (watch.first - first) };
        watch.stretches = known | ((1 << (to - from)) - 1) << (from - first);
        watch.first = first;
    }

    /// Nothing is born at a place where phi is extreme before a `motion` [m].
    #[inline]
    pub fn point(&mut self, motion: f64, place: Extreme, phi: f64) {
        self.steady = less(motion, self.steady);
        let motion =
            if motion >= WATCHED { motion } else { self.keep(Point { place, above: phi >= 0.0 }).map_or(motion, |()| MOST_STEADY) };
        self.apart = less(motion, self.apart);
    }

    /// `None` when there is no room for it.
    fn keep(&mut self, point: Point) -> Option<()> {
        let room = self.watch.points.iter_mut().find(|known| known.is_none_or(|known| known.place == point.place))?;
        *room = Some(point);
        Some(())
    }

    /// What to watch, and how long the rest holds, m.
    pub fn split(&self) -> (Watch, f64) {
        let many = self.watch.stretches.count_ones() > MOST_STRETCHES || self.watch.runs().count() > MOST_RUNS;
        if self.wide || many { (Watch::default(), self.steady) } else { (self.watch, self.apart) }
    }
}
