//! Diagrams as SVG: colours, ranges and labels that they share.

mod axis;
pub(super) mod contact_points;
pub(super) mod curves;
pub(super) mod loglog;
mod overview;
pub(super) mod pair;
pub(super) mod scatter;
mod section;

pub(super) use overview::{overview, prepare};
pub(super) use section::section;

use crate::cli::output::write_whole;
use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use std::path::Path;

pub(super) const BLUE: RGBColor = RGBColor(31, 95, 168);
pub(super) const ORANGE: RGBColor = RGBColor(208, 98, 36);
const GREY: RGBColor = RGBColor(120, 120, 120);
const BLACK_GREY: RGBColor = RGBColor(50, 50, 50);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type DrawingError<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

/// Units of a fine sheet per pixel: the drawing library rounds coordinates to whole units.
const FINE: u32 = 8;

/// Units of a fine sheet for a length in pixels.
const fn px(pixels: u32) -> i32 {
    (FINE * pixels) as i32
}

/// Axes and grid of a diagram on a fine sheet, with labels of a height in pixels; words along the axes are the caller's.
fn fine_mesh<'a, 'b, 's, X, Y>(
    chart: &'b mut ChartContext<'a, SVGBackend<'s>, Cartesian2d<X, Y>>,
    label: u32,
) -> MeshStyle<'a, 'b, X, Y, SVGBackend<'s>>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(GREY.mix(0.25).stroke_width(FINE))
        .axis_style(GREY.stroke_width(FINE))
        .set_all_tick_mark_size(px(5))
        .label_style(("sans-serif", px(label)));
    mesh
}

/// Draws a sheet of a size in pixels [`FINE`] times larger and writes it so that it is shown in that size.
fn write_sheet(file: &Path, size: (u32, u32), draw: impl Fn(&Area) -> Result<(), Box<dyn std::error::Error>>) -> Result<(), String> {
    let mut svg = String::new();
    let words = |error: &dyn std::fmt::Display| format!("{}: can't be drawn: {error}", file.display());
    {
        let root = SVGBackend::with_string(&mut svg, (FINE * size.0, FINE * size.1)).into_drawing_area();
        root.fill(&WHITE).map_err(|error| words(&error))?;
        draw(&root).map_err(|error| words(&error))?;
        root.present().map_err(|error| words(&error))?;
    }
    let drawn = format!("width=\"{}\" height=\"{}\"", FINE * size.0, FINE * size.1);
    let svg = svg.replacen(&drawn, &format!("width=\"{}\" height=\"{}\"", size.0, size.1), 1);
    write_whole(file, svg.as_bytes()).map_err(|error| error.to_string())
}

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
