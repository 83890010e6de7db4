//! Tables of patches, made once for each pair of profiles.
//!
//! A table takes seconds to make. All models of a scene share theirs; a store keeps them from run to run (a user's cache, an FMU's resources).

use super::wheelset::Wheelset;
use crate::contact::search::algebraic::Pair;
use crate::contact::strips::{PatchTable, RailStrips, Section, Standing, ToTabulate};
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Rail, Track};
use crate::math::rotation::AxleFrame;
use nalgebra::Vector3;
use std::fmt::Debug;
use std::sync::{Arc, Mutex, PoisonError};

/// Where tables are kept.
pub trait TableStore: Debug + Send + Sync {
    /// The table of a key, `None` where there is none.
    fn find(&self, key: &str) -> Option<PatchTable>;
    /// A table is about to be made, which takes seconds.
    fn begin(&self, _what: &str) {}
    /// Keeps a new one, if it can.
    fn keep(&self, key: &str, table: &PatchTable);
}

/// With their keys.
type Known = Vec<(String, Arc<PatchTable>)>;

/// The tables of a scene; its clones share them.
#[derive(Clone, Debug, Default)]
pub struct PreparedTables {
    known: Arc<Mutex<Known>>,
    store: Option<Arc<dyn TableStore>>,
}

impl PreparedTables {
    /// Kept in a store.
    pub fn stored(store: Arc<dyn TableStore>) -> PreparedTables {
        PreparedTables { store: Some(store), ..PreparedTables::default() }
    }

    /// All that are in use, with their keys.
    pub fn all(&self) -> Known {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Those of all wheels on their rails.
    pub(super) fn of(&self, wheelsets: &[Wheelset], track: &Track, rails: &[RailStrips; 2]) -> Vec<Arc<PatchTable>> {
        let both = wheelsets.iter().flat_map(|wheelset| Side::BOTH.map(|side| (wheelset, side)));
        let mut found: Vec<(&Wheel, Arc<PatchTable>)> = Vec::new();
        let alike = |a: &Wheel, b: &Wheel| a.side == b.side && a.half_spacing == b.half_spacing && Arc::ptr_eq(&a.profile, &b.profile);
        for (wheelset, side) in both {
            let wheel = wheelset.wheel(side);
            let known = found.iter().find(|(other, _)| alike(other, wheel)).map(|(_, table)| table.clone());
            let table = known.unwrap_or_else(|| self.of_pair(wheel, track.rail(side), &rails[side.index()]));
            found.push((wheel, table));
        }
        found.into_iter().map(|(_, table)| table).collect()
    }

    /// That of a wheel on a rail that is cut into these strips.
    pub fn of_pair(&self, wheel: &Wheel, rail: &Rail, strips: &RailStrips) -> Arc<PatchTable> {
        let undisturbed = rail.undisturbed();
        // In the middle of the track, about as high as it stands: whole nodes of the table take up what is left.
        let (centre, axes) = (Vector3::z() * wheel.profile.at(0.0).value, AxleFrame::new(0.0, 0.0).axes);
        let pair = Pair { wheel, rail: &undisturbed, centre: &centre, axes: &axes, distance: 0.0 };
        let middle = Standing::new(&pair, &Section::new(&pair));
        let pair = ToTabulate { strips, rail: &rail.profile, wheel: &wheel.profile, middle: (middle.across, middle.lean) };
        let key = pair.key();
        // Made under the lock: others that want it wait.
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, table)) = known.iter().find(|(own, _)| *own == key) {
            return table.clone();
        }
        let found = self.store.as_ref().and_then(|store| store.find(&key));
        let table = Arc::new(found.unwrap_or_else(|| {
            if let Some(store) = &self.store {
                store.begin(&format!("{} on {}", wheel.profile.describe(), rail.profile.describe()));
            }
            let made = PatchTable::make(&pair);
            if let Some(store) = &self.store {
                store.keep(&key, &made);
            }
            made
        }));
        known.push((key, table.clone()));
        table
    }
}
