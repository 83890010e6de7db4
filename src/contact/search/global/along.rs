//! Minima of the distance on a rail that bends sideways sharply.
//!
//! A search sees the rail from one of its sections along its tangent there. A flange's place lies tens of millimetres ahead; where the rail bends by 0.5 1/m
//! meanwhile the straight view is off by a millimetre, and a place that is pressed is not seen. So the wheel is looked at from sections [`STEP`] apart, and of
//! what each of them shows counts what lies about there and what the four equations make exact. Of places that differ along the track alone the deepest is taken.
//! Ridges are those that are seen from beside the wheel, or from where one of the minima beside them is seen.

use super::view::View;
use super::{GlobalSearch, MOST, Minima, Minimum, Ridge};
use crate::contact::search::algebraic::{ContactLocation, Pair};

/// Distance of the sections along the track, m, and how many of them to each side.
const STEP: f64 = 5e-3;
const SECTIONS: i32 = 24;
/// What a section shows counts so far from it, m: where one place exists, the place that is shown goes with the section by less than that moves.
const COUNTS: f64 = 2.0 * STEP;
/// What the view from a section may be off, m.
const OFF: f64 = 1e-4;
/// Places nearer to each other on the wheel are one, but for where they are along the track, m.
const SAME: f64 = 3e-3;

impl GlobalSearch {
    /// All minima with a distance below `reach` [m], by growing u, with their exact places.
    pub fn find_along(&self, pair: &Pair, reach: f64, found: &mut Minima) {
        self.find(pair, reach + OFF, found);
        // Those that are seen from beside the wheel, and lie there: the others only say which ridges part what is found ahead.
        let mut exact = [false; MOST];
        for (minimum, exact) in found.list[..found.count].iter_mut().zip(&mut exact) {
            if minimum.parameters.lead.abs() <= COUNTS {
                let location = self.solved(pair, minimum).unwrap_or_else(|| self.polish(pair, minimum).location);
                (minimum.parameters, minimum.distance, *exact) = (location.parameters, -location.penetration, true);
            }
        }
        let mut seen = Minima::default();
        for k in (1..=SECTIONS).flat_map(|k| [k, -k]) {
            let station = f64::from(k) * STEP;
            self.find_from(pair, View::new(pair, Some(pair.distance + station)), reach + OFF, &mut seen);
            for (i, minimum) in seen.iter().enumerate().filter(|(_, own)| (own.parameters.lead - station).abs() <= COUNTS) {
                let Some(location) = self.solved(pair, minimum) else { continue };
                let distance = -location.penetration;
                if distance < reach {
                    let before = i.checked_sub(1).and_then(|before| seen[before].ridge_to_next);
                    found.take_in(Minimum { parameters: location.parameters, distance, ..*minimum }, before, &mut exact);
                }
            }
        }
        // One that no section shows where it stands: at a jump of curvature, or nowhere.
        for (minimum, exact) in found.list[..found.count].iter_mut().zip(&mut exact).filter(|(_, exact)| !**exact) {
            if let Some(location) = self.settle(pair, minimum) {
                (minimum.parameters, minimum.distance, *exact) = (location.parameters, -location.penetration, true);
            }
        }
        found.keep(|i, minimum| exact[i] && minimum.distance < reach);
        // Nothing of it holds elsewhere.
        (found.steady, found.apart, found.clearance, found.watch) = (0.0, 0.0, 0.0, Default::default());
    }

    /// A minimum that a section shows, where it solves the four equations about there.
    fn solved(&self, pair: &Pair, minimum: &Minimum) -> Option<ContactLocation> {
        let found = pair.locate(&minimum.parameters).ok()?;
        let (place, from) = (found.parameters, minimum.parameters);
        let near = (place.wheel - from.wheel).abs() < SAME && (place.lead - from.lead).abs() < COUNTS;
        (near && super::is_least(pair, &found)).then_some(found)
    }
}

impl Minima {
    /// Adds one, which is seen with a ridge `before` it, by growing u, or lets it take the place of one that is the same but for where it is along the track.
    fn take_in(&mut self, minimum: Minimum, before: Option<Ridge>, exact: &mut [bool; MOST]) {
        let u = minimum.parameters.wheel;
        let apart = |known: &Minimum| (known.parameters.wheel - u).abs();
        let nearest = (0..self.count).min_by(|a, b| apart(&self.list[*a]).total_cmp(&apart(&self.list[*b])));
        if let Some(i) = nearest.filter(|i| apart(&self.list[*i]) < SAME) {
            if !exact[i] || minimum.distance < self.list[i].distance {
                self.list[i] = Minimum { ridge_to_next: self.list[i].ridge_to_next, ..minimum };
                exact[i] = true;
            }
            return;
        }
        if self.count == MOST {
            return;
        }
        let place = self.list[..self.count].iter().position(|known| known.parameters.wheel > u).unwrap_or(self.count);
        self.list.copy_within(place..self.count, place + 1);
        exact.copy_within(place..self.count, place + 1);
        (self.list[place], exact[place]) = (minimum, true);
        self.count += 1;
        // What is seen between others than these parts them no more.
        let next = self.list[..self.count].get(place + 1).map_or(f64::NEG_INFINITY, |next| next.parameters.wheel);
        self.list[place].ridge_to_next = minimum.ridge_to_next.filter(|ridge| ridge.parameters.wheel < next);
        if let Some(last) = place.checked_sub(1) {
            let from = self.list[last].parameters.wheel;
            self.list[last].ridge_to_next = before.filter(|ridge| ridge.parameters.wheel > from);
        }
    }

    /// Leaves out those that do not count.
    fn keep(&mut self, counts: impl Fn(usize, &Minimum) -> bool) {
        let (count, list) = (self.count, self.list);
        self.count = 0;
        let mut whole = true;
        for (i, minimum) in list[..count].iter().enumerate() {
            if !counts(i, minimum) {
                whole = false;
                continue;
            }
            self.list[self.count] = *minimum;
            if let Some(last) = self.count.checked_sub(1).filter(|_| !std::mem::replace(&mut whole, true)) {
                self.list[last].ridge_to_next = None;
            }
            self.count += 1;
        }
    }
}
