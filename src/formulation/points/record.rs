//! What a wheel with several contacts remembers: where they were, and how long no search is needed.
//!
//! Part of the contact's memory behind that of its formulation: budget [m] and the pose it counts from (6 numbers), the same for the
//! part of the wheel that is watched, its first knot, its stretches and what was found there, three points that are watched (kind and sign;
//! number of the knot or coordinate), one mark per contact (1: followed), then for each contact but the first (whose place stands where that of a single contact does) u,
//! angle, lead, eta, penetration and a mark (1: it was pressed at the last event), then for as many ridges u, angle, lead, eta
//! and the numbers, from 1, of the contacts on both sides (0: no ridge). At the end what the next location begins with ([`super::reply`]): the pose of
//! the last one, and the replies of all contacts and ridges.

use super::super::loading::keep;
use super::reply::{POSE, REPLY, Reply, after, pose_of};
use super::share::{Saddle, Saddles};
use super::{MOST_POINTS, warm_start};
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::global::{Extreme, GlobalSearch, MOST, Minimum, POINTS, Point, Standing, Watch};

/// A budget and its pose.
const ALLOWANCE: usize = 7;
const WATCHED: usize = ALLOWANCE;
const FIRST: usize = WATCHED + ALLOWANCE;
const STRETCHES: usize = FIRST + 1;
const SIGNATURE: usize = STRETCHES + 1;
const WATCHED_POINTS: usize = SIGNATURE + 1;
const MARKS: usize = WATCHED_POINTS + 2 * POINTS;
const PER_CONTACT: usize = 6;
const DEPTH: usize = 4;
const PRESSED: usize = 5;
const PER_RIDGE: usize = 6;
const BETWEEN: usize = 4;

/// Length of the record for `points` contacts per wheel.
pub(in super::super) fn record_length(points: usize) -> usize {
    located(points) + POSE + REPLY * (2 * points - 1)
}

/// Where the pose stands at which all was located last, and behind it the replies of contacts and ridges.
fn located(points: usize) -> usize {
    MARKS + points + (PER_CONTACT + PER_RIDGE) * (points - 1)
}

/// A view of the memory.
pub(in super::super) struct Record<'a> {
    values: &'a mut [f64],
    points: usize,
}

fn ridge_place(points: usize, ridge: usize) -> usize {
    MARKS + points + PER_CONTACT * (points - 1) + PER_RIDGE * ridge
}

const JOINT: f64 = 1.0;
const WHEEL: f64 = 2.0;

fn point(values: &[f64]) -> Option<Point> {
    let place = match values[0].abs() {
        JOINT => Extreme::Joint(values[1] as usize),
        WHEEL => Extreme::Wheel(values[1]),
        _ => return None,
    };
    Some(Point { place, above: values[0] > 0.0 })
}

fn keep_point(point: Option<&Point>, values: &mut [f64]) {
    let (kind, number) = match point.map(|point| point.place) {
        Some(Extreme::Joint(knot)) => (JOINT, knot as f64),
        Some(Extreme::Wheel(u)) => (WHEEL, u),
        None => (0.0, 0.0),
    };
    values[0] = if point.is_some_and(|point| point.above) { kind } else { -kind };
    values[1] = number;
}

/// [`Record::ridge`] of a record with so many contacts.
#[inline]
pub(super) fn ridge(values: &[f64], points: usize, ridge: usize) -> Option<([usize; 2], SurfaceParameters)> {
    let place = ridge_place(points, ridge);
    let number = |i: usize| (values[place + BETWEEN + i] as usize).checked_sub(1).filter(|slot| *slot < points);
    Some(([number(0)?, number(1)?], warm_start(&values[place..])))
}

impl<'a> Record<'a> {
    pub fn new(values: &'a mut [f64], points: usize) -> Self {
        Record { values, points }
    }

    fn place(&self, slot: usize) -> usize {
        MARKS + self.points + PER_CONTACT * (slot - 1)
    }

    /// The pose at which all has been located.
    #[inline]
    pub fn located(&mut self, now: &Standing) {
        let place = located(self.points);
        self.values[place..place + POSE].copy_from_slice(&pose_of(now));
    }

    /// The motion since then.
    #[inline]
    pub fn moved(&self, now: &Standing) -> [f64; POSE] {
        let (place, now) = (located(self.points), pose_of(now));
        std::array::from_fn(|i| now[i] - self.values[place + i])
    }

    fn reply_place(&self, slot: usize) -> usize {
        located(self.points) + POSE + REPLY * slot
    }

    /// Keeps the reply of a contact; those of the ridges stand behind.
    #[inline]
    pub fn keep_reply(&mut self, slot: usize, reply: &Reply) {
        let place = self.reply_place(slot);
        self.values[place..place + REPLY].copy_from_slice(reply);
    }

    #[inline]
    pub fn keep_ridge_reply(&mut self, ridge: usize, reply: &Reply) {
        self.keep_reply(self.points + ridge, reply);
    }

    /// Where a contact that was at `start` will be after a motion.
    #[inline]
    pub fn after(&self, slot: usize, start: SurfaceParameters, moved: &[f64; POSE]) -> SurfaceParameters {
        after(start, &self.values[self.reply_place(slot)..], moved)
    }

    /// The same for a ridge.
    #[inline]
    pub fn ridge_after(&self, ridge: usize, start: SurfaceParameters, moved: &[f64; POSE]) -> SurfaceParameters {
        self.after(self.points + ridge, start, moved)
    }

    pub fn is_tracked(&self, slot: usize) -> bool {
        self.values[MARKS + slot] != 0.0
    }

    pub fn parameters(&self, slot: usize) -> SurfaceParameters {
        warm_start(&self.values[self.place(slot)..])
    }

    fn ridge_place(&self, ridge: usize) -> usize {
        ridge_place(self.points, ridge)
    }

    /// The contacts on both sides of a ridge that is followed, and where it was.
    #[inline]
    pub fn ridge(&self, ridge: usize) -> Option<([usize; 2], SurfaceParameters)> {
        self::ridge(self.values, self.points, ridge)
    }

    #[inline]
    pub(super) fn keep_ridge(&mut self, ridge: usize, found: &Saddle) {
        let place = self.ridge_place(ridge);
        keep(&found.parameters, &mut self.values[place..]);
        self.keep_ridge_reply(ridge, &found.reply);
    }

    /// Keeps where a contact was found; that of the first stands in `own`.
    pub fn keep(&mut self, slot: usize, found: &SurfaceParameters, penetration: f64, own: &mut [f64]) {
        self.values[MARKS + slot] = 1.0;
        if slot == 0 {
            return keep(found, own);
        }
        let place = self.place(slot);
        keep(found, &mut self.values[place..]);
        self.values[place + DEPTH] = penetration;
    }

    /// Has the wheel moved less than the budget against its rail since the last search?
    #[inline]
    pub fn holds(&self, search: &GlobalSearch, now: &Standing) -> bool {
        allows(search, &self.values[..ALLOWANCE], now)
    }

    /// What must be looked at because the wheel has moved by more than that allows; `None` where there is nothing.
    #[inline]
    pub fn watch(&self, search: &GlobalSearch, now: &Standing) -> Option<Watch> {
        let nothing = self.values[STRETCHES] == 0.0 && self.values[WATCHED_POINTS] == 0.0;
        if nothing || allows(search, &self.values[WATCHED..WATCHED + ALLOWANCE], now) {
            return None;
        }
        let [first, stretches, signature] = [FIRST, STRETCHES, SIGNATURE].map(|place| self.values[place]);
        let points = std::array::from_fn(|i| point(&self.values[WATCHED_POINTS + 2 * i..]));
        Some(Watch { first: first as usize, stretches: stretches as u64, signature: signature as u64, points })
    }

    /// It has been looked at, and stays as it is for a motion of `budget` [m].
    #[inline]
    pub fn watched(&mut self, now: &Standing, budget: f64) {
        self.values[WATCHED] = budget;
        self.values[WATCHED + 1..WATCHED + ALLOWANCE].copy_from_slice(now);
    }

    /// A search has been made here, which holds for a motion by `budget` [m] but for what is watched, and there by `watched` [m].
    pub(super) fn renew(&mut self, now: &Standing, budget: f64, (watch, watched): (&Watch, f64), saddles: &Saddles) {
        self.values[0] = budget;
        self.values[1..ALLOWANCE].copy_from_slice(now);
        self.watched(now, watched);
        self.located(now);
        self.values[FIRST] = watch.first as f64;
        // Both are below 2^53.
        (self.values[STRETCHES], self.values[SIGNATURE]) = (watch.stretches as f64, watch.signature as f64);
        for (i, point) in watch.points.iter().enumerate() {
            keep_point(point.as_ref(), &mut self.values[WATCHED_POINTS + 2 * i..]);
        }
        for (i, saddle) in saddles.iter().enumerate().take(self.points - 1) {
            let sides = self.ridge_place(i) + BETWEEN;
            self.values[sides..sides + 2].copy_from_slice(&saddle.map_or([0.0; 2], |saddle| saddle.between.map(|slot| (slot + 1) as f64)));
            if let Some(saddle) = saddle {
                self.keep_ridge(i, saddle);
            }
        }
    }

    /// No search has been made yet.
    pub fn forget(&mut self) {
        self.values[0] = 0.0;
    }

    /// Gives each chosen minimum the number of the contact that was in its basin, or else the lowest that is free, the deepest
    /// first. With `constrained` the first number is taken.
    pub fn assign(&mut self, minima: &[Minimum], chosen: &[bool], constrained: bool, own: &[f64]) -> [Option<usize>; MOST] {
        let mut numbers = [None; MOST];
        let mut taken = [false; MOST_POINTS];
        taken[0] = constrained;
        for (slot, taken) in taken.iter_mut().enumerate().take(self.points).skip(usize::from(constrained)) {
            if !self.is_tracked(slot) {
                continue;
            }
            let u = if slot == 0 { own[0] } else { self.parameters(slot).wheel };
            let here = |i: &usize| chosen[*i] && numbers[*i].is_none() && (minima[*i].basin.0..=minima[*i].basin.1).contains(&u);
            if let Some(i) = (0..minima.len()).find(here) {
                numbers[i] = Some(slot);
                *taken = true;
            }
        }
        loop {
            let new = (0..minima.len()).filter(|i| chosen[*i] && numbers[*i].is_none());
            let deepest = new.min_by(|a, b| minima[*a].distance.total_cmp(&minima[*b].distance));
            let free = (0..self.points).find(|slot| !taken[*slot]);
            let (Some(i), Some(slot)) = (deepest, free) else { break };
            numbers[i] = Some(slot);
            taken[slot] = true;
        }
        for (slot, taken) in taken.into_iter().enumerate().take(self.points).skip(usize::from(constrained)) {
            self.values[MARKS + slot] = if taken { 1.0 } else { 0.0 };
            if slot > 0 && !taken {
                let place = self.place(slot);
                // The mark stays: a contact that is lost in the middle of a step and found again has not begun anew.
                self.values[place..place + PRESSED].fill(0.0);
            }
        }
        numbers
    }

    /// Penetration [m] of a contact beside the first, and whether it was pressed at the last event; `None` when there is none.
    pub fn other(&self, slot: usize) -> Option<(f64, bool)> {
        let place = self.place(slot);
        self.is_tracked(slot).then(|| (self.values[place + DEPTH], self.values[place + PRESSED] != 0.0))
    }

    /// The same for all of them, with their numbers, from the bare memory.
    pub fn others(values: &[f64], points: usize) -> impl Iterator<Item = (usize, f64, bool)> + '_ {
        (1..points).filter(move |slot| values[MARKS + slot] != 0.0).map(move |slot| {
            let place = MARKS + points + PER_CONTACT * (slot - 1);
            (slot, values[place + DEPTH], values[place + PRESSED] != 0.0)
        })
    }

    /// Makes a contact the first one.
    pub fn promote(&mut self, slot: usize, own: &mut [f64]) {
        let place = self.place(slot);
        own[..4].swap_with_slice(&mut self.values[place..place + 4]);
        self.values.swap(MARKS, MARKS + slot);
        self.forget();
    }

    pub fn set_pressed(&mut self, slot: usize, pressed: bool) {
        let place = self.place(slot);
        self.values[place + PRESSED] = f64::from(u8::from(pressed));
    }
}

/// Has the wheel moved by less than the budget from the pose that belongs to it?
#[inline]
fn allows(search: &GlobalSearch, allowance: &[f64], now: &Standing) -> bool {
    let Some((budget, then)) = allowance.split_first().and_then(|(budget, then)| Some((*budget, then.try_into().ok()?))) else {
        return false;
    };
    budget > 0.0 && search.motion(then, now) < budget
}
