//! Deviations: displacements of a rail along Y (left positive) or Z (up positive) as functions of distance.

mod cosine;
mod ramp;

use super::waves::Stretch;
use crate::geometry::Side;
use crate::settings::{Entry, Section, SettingsError, choose};
use crate::units::Dimension;
use std::sync::Arc;

/// A displacement of a rail as a function of distance along the track.
pub trait DeviationShape: Send + Sync + std::fmt::Debug {
    /// Displacement [m] and its first three derivatives with respect to distance, at distance `s` [m].
    fn at(&self, s: f64) -> [f64; 4];

    /// Distances [m] outside which it is exactly zero; `None`: it is so everywhere.
    fn acts(&self) -> Option<(f64, f64)> {
        Some((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// Distances [m] where a derivative that the equations use jumps: steps end there.
    fn breaks(&self) -> Vec<f64>;

    /// Where it does anything, and how short its waves are there: steps look at each of them.
    fn waves(&self) -> Vec<Stretch>;

    fn describe(&self) -> String;
}

type Parse = fn(&Section) -> Result<Arc<dyn DeviationShape>, SettingsError>;

/// Every deviation shape that a scene can name.
pub static REGISTRY: &[Entry<Parse>] = &[cosine::ENTRY, cosine::HAVERSINE, ramp::ENTRY];

/// In which direction a deviation moves the rail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Along Y, to the left.
    Lateral,
    /// Along Z, up.
    Vertical,
}

/// What moves one rail in one direction.
#[derive(Clone, Debug)]
pub struct Deviation {
    pub side: Side,
    pub direction: Direction,
    pub shape: Arc<dyn DeviationShape>,
}

/// Slope of a rail, -, beyond which one point of contact per wheel makes no sense.
pub(super) const STEEPEST_RAIL: f64 = 0.5;

/// Reads one `[[track.deviation]]`: a shape on one rail, or the same shape on both.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse_deviation(section: Section) -> Result<Vec<Deviation>, SettingsError> {
    let sides: &[Side] = match section.word("rail", &["left", "right", "both"])? {
        "left" => &[Side::Left],
        "right" => &[Side::Right],
        _ => &Side::BOTH,
    };
    let direction = match section.word("direction", &["lateral", "vertical"])? {
        "lateral" => Direction::Lateral,
        _ => Direction::Vertical,
    };
    let shape = (choose(REGISTRY, &section, "shape")?.parse)(&section)?;
    section.finish()?;
    Ok(sides.iter().map(|&side| Deviation { side, direction, shape: shape.clone() }).collect())
}

/// A shape that does all that it does once between two distances; nothing without an amplitude.
fn one_wave(amplitude: f64, from: f64, to: f64) -> Vec<Stretch> {
    if amplitude == 0.0 { Vec::new() } else { vec![Stretch { from, to, wave: to - from }] }
}

/// `amplitude`, `from`, `to` [m] of a shape whose steepest slope is `steepness` times amplitude over length.
fn read_extent(section: &Section, steepness: f64) -> Result<[f64; 3], SettingsError> {
    let amplitude = section.number("amplitude", Dimension::Length)?;
    let from = section.number("from", Dimension::Length)?;
    let to = section.number("to", Dimension::Length)?;
    if to <= from {
        return Err(section.error("to", format!("found {to}, expected more than from = {from}")));
    }
    let steepest = steepness * amplitude.abs() / (to - from);
    if steepest > STEEPEST_RAIL {
        return Err(
            section.error("to", format!("the rail would run {steepest:.2} m up or aside per metre; expected at most {STEEPEST_RAIL}"))
        );
    }
    Ok([amplitude, from, to])
}
