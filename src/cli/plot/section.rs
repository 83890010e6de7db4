//! Section of a profile and its curvature, one above the other.

use super::{Area, BLUE, DrawingError, GREY, limits, short};
use crate::cli::output::write_whole;
use crate::cli::profile::{curvature, names};
use crate::geometry::profile::{Part, ProfilePoint};
use plotters::prelude::*;
use std::path::Path;

/// Draws points of a profile into the file `path`.
pub(in crate::cli) fn section(path: &Path, title: &str, part: Part, samples: &[(f64, ProfilePoint)]) -> Result<(), String> {
    let (coordinate, value) = names(part);
    let mut svg = String::new();
    let draw = |svg: &mut String| -> Result<(), String> {
        let words = |error: DrawingAreaErrorKind<_>| format!("{}: can't be drawn: {error}", path.display());
        let root = SVGBackend::with_string(svg, (900, 700)).into_drawing_area();
        root.fill(&WHITE).map_err(words)?;
        let sheet = root.margin(8, 0, 0, 0).titled(title, ("sans-serif", 20)).map_err(words)?;
        let (above, below) = sheet.split_vertically(330);
        let label = format!("{coordinate} [mm], outward");
        panel(&above, &label, &format!("{value} [mm]"), samples.iter().map(|(x, p)| (1e3 * x, 1e3 * p.value)).collect()).map_err(words)?;
        panel(&below, &label, "curvature [1/m]", samples.iter().map(|(x, p)| (1e3 * x, curvature(p))).collect()).map_err(words)?;
        root.present().map_err(words)
    };
    draw(&mut svg)?;
    write_whole(path, svg.as_bytes()).map_err(|error| error.to_string())
}

fn panel<'a>(area: &Area<'a>, x_label: &str, y_label: &str, points: Vec<(f64, f64)>) -> Result<(), DrawingError<'a>> {
    let (first, last) = limits(points.iter().map(|point| point.0));
    let (low, high) = limits(points.iter().map(|point| point.1));
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(24)
        .x_label_area_size(36)
        .y_label_area_size(64)
        .build_cartesian_2d(first..last, low..high)?;
    chart
        .configure_mesh()
        .x_desc(x_label)
        .y_desc(y_label)
        .x_labels(11)
        .y_labels(7)
        .light_line_style(TRANSPARENT)
        .bold_line_style(GREY.mix(0.25))
        .axis_style(GREY)
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| short(*value))
        .label_style(("sans-serif", 13))
        .draw()?;
    chart.draw_series(LineSeries::new(points, BLUE.stroke_width(2)))?;
    Ok(())
}
