//! Minima of the distance on a rail that bends sideways sharply.
//!
//! A search sees the rail from one of its sections along its tangent there. A flange's place lies tens of millimetres ahead; where the rail bends by 0.5 1/m
//! meanwhile the straight view is off by a millimetre, and a place that is pressed is not seen. So the wheel is looked at from sections [`STEP`] apart, and of
//! what each of them shows counts what lies about there, made exact in three dimensions. Of places that differ along the track alone the deepest is taken.

use super::view::View;
use super::{GlobalSearch, Minima, Minimum};
use crate::contact::search::algebraic::Pair;

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
        let (count, list) = (found.count, found.list);
        found.count = 0;
        let mut before: Option<usize> = None;
        for (i, minimum) in list[..count].iter().enumerate() {
            let Some(exact) = self.exact(pair, minimum, 0.0).filter(|exact| exact.distance < reach) else { continue };
            // A ridge parts two minima that are both kept.
            if before.is_some_and(|before| before + 1 != i) && found.count > 0 {
                found.list[found.count - 1].ridge_to_next = None;
            }
            found.list[found.count] = exact;
            (found.count, before) = (found.count + 1, Some(i));
        }
        let mut seen = Minima::default();
        for k in (1..=SECTIONS).flat_map(|k| [k, -k]) {
            let station = f64::from(k) * STEP;
            self.find_from(pair, View::new(pair, Some(pair.distance + station)), reach + OFF, &mut seen);
            for minimum in seen.iter() {
                if let Some(exact) = self.exact(pair, minimum, station).filter(|exact| exact.distance < reach) {
                    found.take_in(exact);
                }
            }
        }
        // Nothing of it holds elsewhere.
        (found.steady, found.apart, found.clearance, found.watch) = (0.0, 0.0, 0.0, Default::default());
    }

    /// A minimum that a section shows about where it stands, in three dimensions.
    fn exact(&self, pair: &Pair, minimum: &Minimum, station: f64) -> Option<Minimum> {
        if (minimum.parameters.lead - station).abs() > COUNTS {
            return None;
        }
        let location = match pair.locate(&minimum.parameters) {
            Ok(found)
                if (found.parameters.wheel - minimum.parameters.wheel).abs() < SAME
                    && (found.parameters.lead - minimum.parameters.lead).abs() < COUNTS
                    && super::is_least(pair, &found) =>
            {
                found
            }
            _ => self.polish(pair, minimum).location,
        };
        Some(Minimum { parameters: location.parameters, distance: -location.penetration, ..*minimum })
    }
}

impl Minima {
    /// Adds one by growing u, or lets it take the place of one that is the same but for where it is along the track.
    fn take_in(&mut self, minimum: Minimum) {
        let u = minimum.parameters.wheel;
        let list = &mut self.list[..self.count];
        if let Some(known) = list.iter_mut().find(|known| (known.parameters.wheel - u).abs() < SAME) {
            if minimum.distance < known.distance {
                *known = Minimum { ridge_to_next: known.ridge_to_next, ..minimum };
            }
            return;
        }
        self.push(Minimum { ridge_to_next: None, ..minimum });
        let list = &mut self.list[..self.count];
        // There was no room for it.
        if list.last().is_none_or(|last| last.parameters.wheel != u) {
            return;
        }
        // The last one goes to its place; no ridge is known beside it.
        let place = list.iter().position(|known| known.parameters.wheel > u).unwrap_or(list.len() - 1);
        list[place..].rotate_right(1);
        if let Some(before) = place.checked_sub(1) {
            list[before].ridge_to_next = None;
        }
    }
}
