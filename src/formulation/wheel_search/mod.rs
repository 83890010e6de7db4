//! The searches for all places where a wheel may touch its rail, prepared once for each pair of profiles.

mod count;
mod prepared;

use super::Wheelset;
use crate::contact::search::global::GlobalSearch;
use crate::geometry::Side;
use crate::geometry::profile::Profile;
use crate::geometry::track::Track;
pub use count::{FEWEST, needed};
pub use prepared::PreparedSearches;
use std::sync::Arc;

/// Most contacts of one wheel that a scene can ask for.
pub const MOST_POINTS: usize = 4;

/// A wheel that is further away from its rail has left it, m.
pub(super) const FAR: f64 = 0.15;
/// A wheel whose contact lies this much higher than the tread has a flange, m.
const FLANGE: f64 = 10e-3;

/// All contacts of one wheel.
#[derive(Debug)]
pub struct WheelSearch {
    pub(super) search: GlobalSearch,
    /// Wheel coordinate of the flange's tip, m; minus infinity without a flange.
    pub(super) tip: f64,
}

impl WheelSearch {
    /// `None` when there is nothing to search for: only one place can ever touch.
    pub fn new(wheel: &dyn Profile, rail: &dyn Profile) -> Option<Self> {
        let search = GlobalSearch::new(wheel, rail);
        (!search.strictly_convex()).then(|| WheelSearch { search, tip: flange_tip(wheel) })
    }
}

/// Where a wheel's radius is greatest, if that is on a flange.
pub(super) fn flange_tip(profile: &dyn Profile) -> f64 {
    const STEPS: usize = 2000;
    let (first, last) = profile.range();
    let at = |index: usize| first + (last - first) * index as f64 / STEPS as f64;
    let radius = |index: usize| profile.at(at(index)).value;
    let tip = (0..=STEPS).max_by(|a, b| radius(*a).total_cmp(&radius(*b))).unwrap_or(0);
    let tread = profile.at(0.0f64.clamp(first, last)).value;
    if radius(tip) > tread + FLANGE && at(tip) < 0.0 { at(tip) } else { f64::NEG_INFINITY }
}

/// Searches for all wheels whose profiles can touch at more than one place, where they are wanted. With one contact per wheel it is the deepest place.
pub(super) fn searches(wheelsets: &[Wheelset], track: &Track, wanted: bool, prepared: &PreparedSearches) -> Vec<Option<Arc<WheelSearch>>> {
    let both = wheelsets.iter().flat_map(|wheelset| Side::BOTH.map(|side| (&wheelset.wheel(side).profile, &track.rail(side).profile)));
    both.map(|(wheel, rail)| if wanted { prepared.of(wheel, rail) } else { None }).collect()
}
