//! Irregularities: what displaces both rails together, by measurement or at random.
//!
//! Four quantities describe both rails (EN 13848-1 measures them, each as the deviation from the design):
//! alignment a (of the centre line, left positive), longitudinal level l (up positive), cross level c (height of the left rail
//! over the right one), gauge g (widening). With Y to the left and Z up:
//! left rail y = a + g/2, z = l + c/2; right rail y = a - g/2, z = l - c/2.
//!
//! Rails are shifted, not turned: a cross level does not change the sections' inclination (5 mm: it would by 3.4 mrad, against
//! 25 mrad of 1:40). One `[[track.irregularity]]` becomes up to four [`Deviation`]s. They are smooth: no breaks, steps are
//! limited by the integrator's control of its error alone.

mod doubts;
mod overshoot;
mod resolved;
mod series;
pub mod spectrum;
mod synthesis;
mod window;

use super::{Deviation, DeviationShape, Direction};
use crate::geometry::Side;
use crate::geometry::file::SceneFile;
use crate::settings::{Entry, Section, SettingsError, choose};
use std::sync::Arc;

/// What one `[[track.irregularity]]` does to the rails.
#[derive(Clone, Debug)]
pub struct Irregularity {
    pub deviations: Vec<Deviation>,
    /// File that it was read from, which an FMU must carry.
    pub file: Option<SceneFile>,
    /// What is allowed but perhaps not meant.
    pub doubts: Vec<String>,
}

type Parse = fn(&Section) -> Result<Irregularity, SettingsError>;

/// Every kind of irregularity that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[series::ENTRY, synthesis::ENTRY];

/// Reads one `[[track.irregularity]]`.
///
/// # Errors
/// [`SettingsError`] with file and line, of the scene or of the measured file.
pub fn parse(section: Section) -> Result<Irregularity, SettingsError> {
    let irregularity = (choose(REGISTRY, &section, "kind")?.parse)(&section)?;
    section.finish()?;
    Ok(irregularity)
}

/// One of the four quantities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Alignment,
    LongitudinalLevel,
    CrossLevel,
    Gauge,
}

impl Quantity {
    pub const ALL: [Quantity; 4] = [Quantity::Alignment, Quantity::LongitudinalLevel, Quantity::CrossLevel, Quantity::Gauge];

    /// Names in scenes and in the headers of files, in the order of [`Quantity::ALL`].
    pub const NAMES: [&str; 4] = ["alignment", "longitudinal_level", "cross_level", "gauge"];

    /// Place in arrays of all four.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// The quantity of both rails' mean and that of their difference, in one direction.
fn mean_and_difference(direction: Direction) -> (Quantity, Quantity) {
    match direction {
        Direction::Lateral => (Quantity::Alignment, Quantity::Gauge),
        Direction::Vertical => (Quantity::LongitudinalLevel, Quantity::CrossLevel),
    }
}

/// Numbers along the track for each of the four quantities become those of the rails, and those the rails' deviations:
/// mean + difference/2 on the left, mean - difference/2 on the right. `shape` is not called where nothing moves; without a
/// difference both rails share one shape.
fn deviations<E>(
    quantities: &[Option<Vec<f64>>; 4],
    mut shape: impl FnMut(Side, Direction, Vec<f64>) -> Result<Arc<dyn DeviationShape>, E>,
) -> Result<Vec<Deviation>, E> {
    let mut deviations = Vec::new();
    for direction in [Direction::Lateral, Direction::Vertical] {
        let (mean, difference) = mean_and_difference(direction);
        match (&quantities[mean.index()], &quantities[difference.index()]) {
            (None, None) => {}
            (Some(mean), None) => {
                let shared = shape(Side::Left, direction, mean.clone())?;
                deviations.extend(Side::BOTH.map(|side| Deviation { side, direction, shape: shared.clone() }));
            }
            (mean, Some(difference)) => {
                for side in Side::BOTH {
                    let half = 0.5 * side.sign();
                    let own = match mean {
                        Some(mean) => mean.iter().zip(difference).map(|(m, d)| m + half * d).collect(),
                        None => difference.iter().map(|d| half * d).collect(),
                    };
                    deviations.push(Deviation { side, direction, shape: shape(side, direction, own)? });
                }
            }
        }
    }
    Ok(deviations)
}
