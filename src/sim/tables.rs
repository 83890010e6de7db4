//! Which tables of forces a run has left: what holds beyond their points is an assumption, and a reader should know.

use super::Snapshot;
use crate::formulation::Model;
use crate::mbs::force::{Beyond, ForceElement, Table};
use std::ops::Range;

/// A table of one element, and how far beyond its points the run has been.
#[derive(Debug)]
struct Watched {
    element: Box<dyn ForceElement>,
    states: Range<usize>,
    index: usize,
    table: Table,
    /// Largest way beyond an end, its place and time.
    worst: Option<(f64, f64, f64)>,
}

/// All tables of a model's force elements.
#[derive(Debug, Default)]
pub struct LeftTables {
    watched: Vec<Watched>,
}

/// A place beyond an end by less than this share of it is rounding.
const BESIDE: f64 = 1e-9;

impl LeftTables {
    pub fn new(model: &Model) -> LeftTables {
        let elements = model.system.forces.iter().enumerate();
        let watched = elements.flat_map(|(number, element)| {
            let states = model.system.states_of_force(number);
            let watch = move |(index, table)| Watched { element: element.clone_box(), states: states.clone(), index, table, worst: None };
            element.tables().into_iter().enumerate().map(watch)
        });
        LeftTables { watched: watched.collect() }
    }

    /// Is there nothing to look at? Then nothing need be evaluated for it.
    pub fn is_empty(&self) -> bool {
        self.watched.is_empty()
    }

    /// Looks where the elements are in their tables now.
    pub fn look(&mut self, snapshot: &Snapshot) {
        for watched in &mut self.watched {
            let at =
                watched.element.table_argument(watched.index, &snapshot.workspace.system.moving(), &snapshot.y[watched.states.clone()]);
            let Table { from, to, .. } = watched.table;
            let beyond = (from - at).max(at - to);
            if beyond > BESIDE * at.abs() && watched.worst.is_none_or(|(worst, ..)| beyond > worst) {
                watched.worst = Some((beyond, at, snapshot.time));
            }
        }
    }

    /// Largest way beyond an end of each table, its place and time, s: to be saved with a run.
    pub fn noted(&self) -> Vec<Option<(f64, f64, f64)>> {
        self.watched.iter().map(|watched| watched.worst).collect()
    }

    /// Goes on with what was noted before. Returns false and changes nothing when it is not of the same tables.
    pub fn go_on(&mut self, noted: &[Option<(f64, f64, f64)>]) -> bool {
        let own = noted.len() == self.watched.len();
        if own {
            self.watched.iter_mut().zip(noted).for_each(|(watched, worst)| watched.worst = *worst);
        }
        own
    }

    /// One line for each table that was left.
    pub fn notes(&self) -> Vec<String> {
        let line = |watched: &Watched| {
            let (_, at, time) = watched.worst?;
            let Table { key, unit, from, to, beyond, .. } = watched.table;
            let (end, next) = if at > to { (to, "last") } else { (from, "first") };
            let held = match beyond {
                Beyond::Hold => format!("its {next} force held"),
                Beyond::Slope => format!("its {next} slope went on"),
            };
            let name = watched.element.name();
            Some(format!("{name}: {key} ends at {end} {unit} and was left by up to {at:.4} {unit} (t = {time:.3} s); {held} there"))
        };
        self.watched.iter().filter_map(line).collect()
    }
}
