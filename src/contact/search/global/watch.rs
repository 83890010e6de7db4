//! The part of a wheel where another contact may be born soon, looked at alone.
//!
//! What a search decides holds until the wheel has moved by some length. Where wheel and rail are nearly conformal (S1002 on 60E1: two stretches
//! of 1 and 4 mm) that length may be nothing, all over the rest of the wheel it is 0.2 mm and more. So a search keeps
//! two lengths: how long all of it holds (`steady`), and how long it holds outside the stretches that decide by less than
//! [`WATCHED`] (`apart`). Until the wheel has moved by `apart`, only these stretches are scanned again, each by the same decisions
//! as in a search; as long as they hold as many stationary distances as before, no contact has been born or has gone.

use super::GlobalSearch;
use super::branch::{MOST_STEADY, Scan};
use super::view::View;
use crate::contact::search::algebraic::{Pair, SurfaceParameters};

/// Stretches whose decision holds for less than this motion, m, are watched.
const WATCHED: f64 = 2e-4;
/// Most stretches that are scanned alone: more are not quicker than a search.
const MOST_STRETCHES: usize = 24;

/// Neighbouring stretches of a wheel and what was found there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Watch {
    /// First and last knot of the wheel; equal when there is nothing to watch.
    pub knots: (usize, usize),
    /// Stationary distances, least and greatest, between them.
    pub count: usize,
}

/// Certificates of a scan, collected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Certificates {
    /// The least of all, m.
    pub steady: f64,
    /// The least of those that are not watched, m.
    pub apart: f64,
    /// Knots around those that are.
    pub knots: Option<(usize, usize)>,
}

impl Certificates {
    pub const NONE: Certificates = Certificates { steady: MOST_STEADY, apart: MOST_STEADY, knots: None };

    /// A decision between two knots that holds for a `motion` [m].
    #[inline]
    pub fn add(&mut self, motion: f64, (from, to): (usize, usize)) {
        self.steady = self.steady.min(motion);
        if motion < WATCHED {
            self.knots = Some(self.knots.map_or((from, to), |known| (known.0.min(from), known.1.max(to))));
        } else {
            self.apart = self.apart.min(motion);
        }
    }

    /// The stretches to watch, by their knots, and how long the rest holds, m.
    pub fn split(&self) -> ((usize, usize), f64) {
        match self.knots {
            Some(knots) if knots.1 - knots.0 <= MOST_STRETCHES => (knots, self.apart),
            Some(_) => ((0, 0), self.steady),
            None => ((0, 0), self.apart),
        }
    }
}

impl GlobalSearch {
    /// Scans what is watched: for how much motion [m] it stays as it is; `None` when something has been born or has gone. Any
    /// contact tells where on the rail that is.
    pub fn watched(&self, pair: &Pair, reach: f64, watch: &Watch, contact: &SurfaceParameters) -> Option<f64> {
        let (count, steady) = self.look(pair, reach, watch.knots, contact);
        (count == watch.count).then_some(steady)
    }

    /// Stationary distances between two knots, and for how much motion [m] they stay as they are.
    pub(super) fn look(&self, pair: &Pair, reach: f64, knots: (usize, usize), contact: &SurfaceParameters) -> (usize, f64) {
        let mut scan = Scan::seen(self, pair, View::new(pair, None), reach);
        scan.part(knots, contact.rail - contact.wheel);
        (scan.count, scan.certificates.steady)
    }
}
