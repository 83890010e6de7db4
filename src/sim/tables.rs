//! Which tables of forces a run has left, which lines between places have become short and which bags have pulled: what holds there is an assumption, and a reader should know.

use super::Snapshot;
use crate::formulation::Model;
use crate::mbs::force::{Beyond, ForceElement, Table};
use std::ops::Range;

/// A range of one element, and how far beyond it the run has been.
#[derive(Debug)]
struct Watched {
    element: Box<dyn ForceElement>,
    states: Range<usize>,
    range: Watch,
    /// Largest way beyond an end, its place and time.
    worst: Option<(f64, f64, f64)>,
}

#[derive(Debug)]
enum Watch {
    /// A table by its index.
    Table(usize, Table),
    /// The length of a line, drawn so long, m.
    Length(f64),
    /// The tension of what can't pull, N.
    Pull,
}

/// A line is short below this share of the length that was drawn: its direction is no longer that of the element.
const SHORT: f64 = 0.2;
/// What [`ForceElement::quantity`] gives as the elongation.
const ELONGATION: usize = 1;
/// ... and as the tension; what pulls less is a rounding, N.
const TENSION: usize = 0;
const PULLS: f64 = 1.0;

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
            let tables = element.tables().into_iter().enumerate().map(|(index, table)| Watch::Table(index, table));
            let watch = move |range| Watched { element: element.clone_box(), states: states.clone(), range, worst: None };
            let pull = element.pushes_alone().then_some(Watch::Pull);
            tables.chain(element.drawn_length().map(Watch::Length)).chain(pull).map(watch)
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
            let (bodies, states) = (snapshot.workspace.system.moving(), &snapshot.y[watched.states.clone()]);
            let (at, [from, to]) = match watched.range {
                Watch::Table(index, Table { from, to, .. }) => (watched.element.table_argument(index, &bodies, states), [from, to]),
                Watch::Pull => (watched.element.quantity(TENSION, &bodies, states), [f64::NEG_INFINITY, PULLS]),
                Watch::Length(drawn) => (drawn + watched.element.quantity(ELONGATION, &bodies, states), [SHORT * drawn, f64::INFINITY]),
            };
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
            let Table { key, unit, from, to, beyond, .. } = match watched.range {
                Watch::Table(_, table) => table,
                Watch::Pull => {
                    return Some(format!(
                        "{}: it pulled with up to {:.1} kN (t = {time:.3} s), which a bag can do by the area times the pressure outside at most (10 kN for 0.1 m2), and less where it lifts off: what \
                         goes on there is linear theory about its preload; a bump_stop holds what lifts off",
                        watched.element.name(),
                        1e-3 * at
                    ));
                }
                Watch::Length(drawn) => {
                    return Some(format!(
                        "{}: its places came within {at:.4} m of each other (t = {time:.3} s), where they were drawn {drawn:.4} m apart: the line between them turns with what they move across, \
                         and round where they pass each other; put them further apart, or give an axis",
                        watched.element.name()
                    ));
                }
            };
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
