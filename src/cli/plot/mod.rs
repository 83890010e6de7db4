//! Diagrams as SVG: colours, ranges and labels that they share.

mod axis;
mod overview;
pub(super) mod pair;
pub(super) mod scatter;
mod section;

pub(super) use overview::{overview, prepare};
pub(super) use section::section;

use plotters::coord::Shift;
use plotters::prelude::*;

const BLUE: RGBColor = RGBColor(31, 95, 168);
const ORANGE: RGBColor = RGBColor(208, 98, 36);
const GREY: RGBColor = RGBColor(120, 120, 120);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type DrawingError<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

/// A range with some air around the values.
fn limits(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = extent(values);
    if !(low.is_finite() && high.is_finite()) {
        return (-1.0, 1.0);
    }
    let air = (0.08 * (high - low)).max(1e-6 * high.abs()).max(1e-9);
    (low - air, high + air)
}

/// Smallest and largest value.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// The range of a distance axis: that of the values, never empty.
fn distance_range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (first, last) = extent(values);
    if last > first { (first, last) } else { (first, first + 1.0) }
}

/// A label without needless zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}
