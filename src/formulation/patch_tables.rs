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
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Where tables are kept.
pub trait TableStore: Debug + Send + Sync {
    /// The table of a key, `None` where there is none.
    fn find(&self, key: &str) -> Option<PatchTable>;
    /// A table is about to be made, which takes seconds.
    fn begin(&self, _what: &str) {}
    /// Keeps a new one, if it can.
    fn keep(&self, key: &str, table: &PatchTable);
}

/// A table that is in use.
#[derive(Clone, Debug)]
struct Known {
    of: ToTabulate,
    key: String,
    table: Arc<PatchTable>,
}

/// The tables of a scene; its clones share them.
#[derive(Clone, Debug, Default)]
pub struct PreparedTables {
    known: Arc<Mutex<Vec<Known>>>,
    store: Option<Arc<dyn TableStore>>,
}

impl PreparedTables {
    /// Kept in a store.
    pub fn stored(store: Arc<dyn TableStore>) -> PreparedTables {
        PreparedTables { store: Some(store), ..PreparedTables::default() }
    }

    /// All that are in use, with their keys.
    pub fn all(&self) -> BTreeMap<String, Arc<PatchTable>> {
        self.lock().iter().map(|known| (known.key.clone(), known.table.clone())).collect()
    }

    // A list that another thread has left in the middle of `push` is whole all the same.
    fn lock(&self) -> MutexGuard<'_, Vec<Known>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Those of all wheels on their rails.
    pub(super) fn of(&self, wheelsets: &[Wheelset], track: &Track, rails: &[RailStrips; 2]) -> Vec<Arc<PatchTable>> {
        let both = wheelsets.iter().flat_map(|wheelset| Side::BOTH.map(|side| (wheelset.wheel(side), side)));
        both.map(|(wheel, side)| self.of_pair(wheel, track.rail(side), &rails[side.index()])).collect()
    }

    /// That of a wheel on a rail that is cut into these strips.
    pub fn of_pair(&self, wheel: &Wheel, rail: &Rail, strips: &RailStrips) -> Arc<PatchTable> {
        let undisturbed = rail.undisturbed();
        // In the middle of the track, about as high as it stands: whole nodes of the table take up what is left.
        let (centre, axes) = (Vector3::z() * wheel.profile.at(0.0).value, AxleFrame::new(0.0, 0.0).axes);
        let pair = Pair { wheel, rail: &undisturbed, centre: &centre, axes: &axes, distance: 0.0 };
        let middle = Standing::new(&pair, &Section::new(&pair));
        let of = ToTabulate {
            strips: strips.clone(),
            rail: rail.profile.clone(),
            wheel: wheel.profile.clone(),
            middle: (middle.across, middle.lean),
        };
        if let Some(known) = self.lock().iter().find(|known| known.of.is(&of)) {
            return known.table.clone();
        }
        let key = of.key();
        let equal = self.lock().iter().find(|known| known.key == key).map(|known| known.table.clone());
        // Not under the lock: threads that make a table take up other work while they wait for each other, which may want one too.
        let table = equal.unwrap_or_else(|| Arc::new(self.found_or_made(wheel, rail, &of, &key)));
        self.lock().push(Known { of, key, table: table.clone() });
        table
    }

    fn found_or_made(&self, wheel: &Wheel, rail: &Rail, of: &ToTabulate, key: &str) -> PatchTable {
        let Some(store) = &self.store else { return PatchTable::make(of) };
        store.find(key).unwrap_or_else(|| {
            store.begin(&format!("{} on {}", wheel.profile.describe(), rail.profile.describe()));
            let made = PatchTable::make(of);
            store.keep(key, &made);
            made
        })
    }
}
