//! What a wheel with several contacts remembers, read and written: where they were, and how long no search is needed.

use super::share::{Saddle, Saddles};
use super::stand::Stand;
use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters};
use crate::contact::search::global::{GlobalSearch, MOST, Minimum, Watch, WheelPose};
use crate::formulation::memory::{Allowance, PlaceMemory, RidgeMemory, WheelMemory};
use crate::formulation::prediction::{POSE, after, pose_of, prediction};
use crate::formulation::wheel_search::MOST_POINTS;

impl Allowance {
    /// Has the wheel moved by less than the budget from the pose that belongs to it?
    #[inline]
    fn holds(&self, search: &GlobalSearch, now: &WheelPose) -> bool {
        self.budget > 0.0 && search.motion(&self.from, now) < self.budget
    }
}

impl WheelMemory {
    /// The motion since all places were located.
    #[inline]
    pub(super) fn moved(&self, now: &WheelPose) -> [f64; POSE] {
        let now = pose_of(now);
        std::array::from_fn(|i| now[i] - self.located[i])
    }

    /// Where a contact that is followed is expected after a motion.
    #[inline]
    pub(super) fn expected(&self, slot: usize, moved: &[f64; POSE]) -> Option<SurfaceParameters> {
        let PlaceMemory { followed, parameters, prediction, .. } = &self.places[slot];
        followed.then(|| after(*parameters, prediction, moved))
    }

    /// A ridge between the first `points` contacts, if it is followed.
    #[inline]
    pub(in crate::formulation) fn ridge(&self, number: usize, points: usize) -> Option<&RidgeMemory> {
        self.ridges[number].as_ref().filter(|ridge| ridge.between.iter().all(|slot| *slot < points))
    }

    /// Keeps where a contact was found.
    #[inline]
    pub(super) fn keep_place(&mut self, stand: &Stand, slot: usize, found: &ContactLocation) {
        let place = &mut self.places[slot];
        (place.followed, place.parameters, place.penetration) = (true, found.parameters, found.penetration);
        place.prediction = prediction(&stand.pair, &stand.pose, stand.radius, found);
    }

    #[inline]
    pub(super) fn keep_ridge(&mut self, number: usize, found: &Saddle) {
        let Saddle { between, parameters, prediction, .. } = *found;
        self.ridges[number] = Some(RidgeMemory { between, parameters, prediction });
    }

    /// Has the wheel moved less than the budget against its rail since the last search?
    #[inline]
    pub(super) fn needs_no_search(&self, search: &GlobalSearch, now: &WheelPose) -> bool {
        self.searched.holds(search, now)
    }

    /// What must be looked at because the wheel has moved by more than that allows; `None` where there is nothing.
    #[inline]
    pub(super) fn due_watch(&self, search: &GlobalSearch, now: &WheelPose) -> Option<&Watch> {
        (!self.watch.is_empty() && !self.watched.holds(search, now)).then_some(&self.watch)
    }

    /// A search has been made here, which holds for a motion by `budget` [m] but for what is watched, and there by `watched` [m].
    pub(super) fn renew(&mut self, now: &WheelPose, budget: f64, (watch, watched): (&Watch, f64), saddles: &Saddles) {
        self.searched = Allowance { budget, from: *now };
        self.watched = Allowance { budget: watched, from: *now };
        self.watch = *watch;
        self.located = pose_of(now);
        self.ridges = [None; MOST_POINTS - 1];
        for (i, saddle) in saddles.iter().enumerate().filter_map(|(i, saddle)| Some((i, saddle.as_ref()?))) {
            self.keep_ridge(i, saddle);
        }
    }

    /// Gives each chosen minimum the number of the contact that was in its basin, of the deepest one where two have merged (it has the patch's load, and its
    /// tangential states), or else the lowest that is free, the deepest first. With `constrained` the first number is taken.
    pub(super) fn assign(&mut self, minima: &[Minimum], chosen: &[bool], constrained: bool, points: usize) -> [Option<usize>; MOST] {
        let mut numbers = [None; MOST];
        let mut taken = [false; MOST_POINTS];
        taken[0] = constrained;
        let free = usize::from(constrained)..points;
        let mut known: [usize; MOST_POINTS] = std::array::from_fn(|slot| slot);
        let known = &mut known[free.clone()];
        known.sort_unstable_by(|a, b| self.places[*b].penetration.total_cmp(&self.places[*a].penetration).then(a.cmp(b)));
        for slot in known.iter().copied() {
            let place = &self.places[slot];
            let here = |i: &usize| {
                let within = (minima[*i].basin.0..=minima[*i].basin.1).contains(&place.parameters.wheel);
                chosen[*i] && numbers[*i].is_none() && within
            };
            if let Some(i) = (0..minima.len()).find(|i| place.followed && here(i)) {
                numbers[i] = Some(slot);
                taken[slot] = true;
            }
        }
        loop {
            let new = (0..minima.len()).filter(|i| chosen[*i] && numbers[*i].is_none());
            let deepest = new.min_by(|a, b| minima[*a].distance.total_cmp(&minima[*b].distance));
            let untaken = (0..points).find(|slot| !taken[*slot]);
            let (Some(i), Some(slot)) = (deepest, untaken) else { break };
            numbers[i] = Some(slot);
            taken[slot] = true;
        }
        for slot in free {
            let place = &mut self.places[slot];
            place.followed = taken[slot];
            if slot > 0 && !taken[slot] {
                // What was pressed stays so: a contact that is lost in the middle of a step and found again has not begun anew.
                *place = PlaceMemory { pressed: place.pressed, ..PlaceMemory::default() };
            }
        }
        numbers
    }

    /// Makes a contact the first one.
    pub(super) fn promote(&mut self, slot: usize) {
        self.places.swap(0, slot);
        self.forget();
    }
}
