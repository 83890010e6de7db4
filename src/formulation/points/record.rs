//! What a wheel with several contacts remembers: where they were, and how long no search is needed.
//!
//! Part of the contact's memory behind that of its formulation: budget [m] and the pose it counts from (6 numbers), the same for the
//! part of the wheel that is watched, its first and last knot and the number of stationary distances there, one mark per contact (1: followed), then for each contact but the first (whose place stands where that of a single contact does) u,
//! angle, lead, eta, penetration and a mark (1: it was pressed at the last event), then for as many ridges u, angle, lead, eta
//! and the numbers, from 1, of the contacts on both sides (0: no ridge).

use super::super::loading::keep;
use super::share::{Saddle, Saddles};
use super::{MOST_POINTS, warm_start};
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::global::{GlobalSearch, MOST, Minimum, Standing, Watch};

/// A budget and its pose.
const ALLOWANCE: usize = 7;
const WATCHED: usize = ALLOWANCE;
const KNOTS: usize = WATCHED + ALLOWANCE;
const COUNT: usize = KNOTS + 2;
const MARKS: usize = COUNT + 1;
const PER_CONTACT: usize = 6;
const DEPTH: usize = 4;
const PRESSED: usize = 5;
const PER_RIDGE: usize = 6;
const BETWEEN: usize = 4;

/// Length of the record for `points` contacts per wheel.
pub(in super::super) fn record_length(points: usize) -> usize {
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

/// [`Record::ridge`] of a record with so many contacts.
#[inline]
pub(super) fn ridge(values: &[f64], points: usize, ridge: usize) -> Option<([usize; 2], SurfaceParameters)> {
    let place = ridge_place(points, ridge);
    let number = |i: usize| (values[place + BETWEEN + i] as usize).checked_sub(1);
    Some(([number(0)?, number(1)?], warm_start(&values[place..])))
}

impl<'a> Record<'a> {
    pub fn new(values: &'a mut [f64], points: usize) -> Self {
        Record { values, points }
    }

    fn place(&self, slot: usize) -> usize {
        MARKS + self.points + PER_CONTACT * (slot - 1)
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
        let knots = [0, 1].map(|i| self.values[KNOTS + i] as usize);
        let due = knots[0] < knots[1] && !allows(search, &self.values[WATCHED..WATCHED + ALLOWANCE], now);
        due.then(|| Watch { knots: (knots[0], knots[1]), count: self.values[COUNT] as usize })
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
        (self.values[KNOTS], self.values[KNOTS + 1], self.values[COUNT]) = (watch.knots.0 as f64, watch.knots.1 as f64, watch.count as f64);
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
