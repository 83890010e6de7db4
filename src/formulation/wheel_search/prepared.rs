//! Searches prepared once for each pair of profiles.
//!
//! A search depends on the two profiles alone, and to prepare it takes about a millisecond: all wheels and all assemblies of
//! a scene share it (an FMU assembles its model anew when a parameter changes).

use super::WheelSearch;
use crate::geometry::profile::Profile;
use std::sync::{Arc, Mutex, PoisonError};

/// The searches of a scene; its clones share them.
#[derive(Clone, Debug, Default)]
pub struct PreparedSearches(Arc<Mutex<Vec<Prepared>>>);

#[derive(Debug)]
struct Prepared {
    /// They are known by their addresses, which stay theirs while they are held here.
    wheel: Arc<dyn Profile>,
    rail: Arc<dyn Profile>,
    /// `None`: only one place can ever touch.
    search: Option<Arc<WheelSearch>>,
}

impl PreparedSearches {
    /// The search for a pair of profiles; `None` when there is nothing to search for: only one place can ever touch.
    pub(super) fn of(&self, wheel: &Arc<dyn Profile>, rail: &Arc<dyn Profile>) -> Option<Arc<WheelSearch>> {
        // A list that another thread has left in the middle of `push` is whole all the same.
        let mut list = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = list.iter().find(|known| same(&known.wheel, wheel) && same(&known.rail, rail)) {
            return known.search.clone();
        }
        let search = WheelSearch::new(wheel.as_ref(), rail.as_ref()).map(Arc::new);
        list.push(Prepared { wheel: wheel.clone(), rail: rail.clone(), search: search.clone() });
        search
    }
}

/// Are they one object? (Addresses alone: tables of functions may be several.)
fn same(a: &Arc<dyn Profile>, b: &Arc<dyn Profile>) -> bool {
    std::ptr::addr_eq(Arc::as_ptr(a), Arc::as_ptr(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::profile::ProfilePoint;

    /// A parabola: wheels that are hollow by `d2` < 0 against flat rails touch at one place.
    #[derive(Debug)]
    struct Curved(f64);
    impl Profile for Curved {
        fn at(&self, x: f64) -> ProfilePoint {
            ProfilePoint { value: 0.4 + 0.5 * self.0 * x * x, d1: self.0 * x, d2: self.0, d3: 0.0 }
        }
        fn range(&self) -> (f64, f64) {
            (-0.03, 0.03)
        }
        fn describe(&self) -> String {
            "parabola".into()
        }
    }

    #[test]
    fn equiv_a_pair_is_prepared_once_and_only_where_it_is_the_same() {
        let hollow: Arc<dyn Profile> = Arc::new(Curved(3.0));
        let (round, other): (Arc<dyn Profile>, Arc<dyn Profile>) = (Arc::new(Curved(-3.0)), Arc::new(Curved(-3.0)));
        let prepared = PreparedSearches::default();
        let copy = prepared.clone();
        let first = prepared.of(&hollow, &round).unwrap();
        assert!(Arc::ptr_eq(&first, &copy.of(&hollow.clone(), &round.clone()).unwrap()));
        assert!(!Arc::ptr_eq(&first, &copy.of(&hollow, &other).unwrap()));
        // Two that are convex against each other need none, and that is known too.
        assert!(prepared.of(&round, &other).is_none() && prepared.of(&round, &other).is_none());
        assert_eq!(prepared.0.lock().unwrap().len(), 3);
    }
}
