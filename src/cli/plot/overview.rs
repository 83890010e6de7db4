//! One sheet per run: lateral displacement, yaw and wheel loads over distance.

use super::{Area, BLUE, DrawingError, GREY, ORANGE, distance_range, limits, short};
use crate::cli::output::write_whole;
use crate::sim::recording::Recording;
use plotters::prelude::*;
use std::path::{Path, PathBuf};

struct Curve<'a> {
    column: &'a str,
    label: &'a str,
    color: RGBColor,
    factor: f64,
}

struct Panel<'a> {
    title: &'a str,
    axis: &'a str,
    curves: Vec<Curve<'a>>,
}

const NEEDS: &str = "the plot needs the output group \"motion\"; add it to interface.outputs";

/// Can a plot be drawn into `folder`? Asked before the run, so that nothing computed is lost.
pub(in crate::cli) fn prepare(folder: &Path, groups: &[&str]) -> Result<(), String> {
    if !groups.contains(&"motion") {
        return Err(NEEDS.into());
    }
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: can't be made: {error}", folder.display()))
}

/// Lateral displacement, yaw and wheel loads over distance on one sheet, `DIR/NAME.svg`.
pub(in crate::cli) fn overview(folder: &Path, name: &str, title: &str, wheelset: &str, recording: &Recording) -> Result<PathBuf, String> {
    let distance = recording.column(&format!("{wheelset}.distance")).ok_or(NEEDS)?;
    let file = folder.join(format!("{name}.svg"));
    let panels = [
        Panel {
            title: "Lateral displacement",
            axis: "y [mm], left positive",
            curves: vec![Curve { column: "y", label: "", color: BLUE, factor: 1e3 }],
        },
        Panel { title: "Yaw", axis: "yaw [mrad]", curves: vec![Curve { column: "yaw", label: "", color: BLUE, factor: 1e3 }] },
        Panel {
            title: "Wheel loads",
            axis: "Q [kN]",
            curves: vec![
                Curve { column: "left.verticalForce", label: "left", color: BLUE, factor: 1e-3 },
                Curve { column: "right.verticalForce", label: "right", color: ORANGE, factor: 1e-3 },
            ],
        },
    ];
    // A panel whose output group the scene does not show is left out.
    let shown = |panel: &&Panel| panel.curves.iter().any(|curve| recording.column(&format!("{wheelset}.{}", curve.column)).is_some());
    let panels: Vec<&Panel> = panels.iter().filter(shown).collect();
    let height = 40 + 260 * panels.len() as u32;
    let mut svg = String::new();
    let draw = |svg: &mut String| -> Result<(), String> {
        let words = |error: DrawingAreaErrorKind<_>| format!("{}: can't be drawn: {error}", file.display());
        let root = SVGBackend::with_string(svg, (900, height)).into_drawing_area();
        root.fill(&WHITE).map_err(words)?;
        let sheet = root.margin(8, 0, 0, 0).titled(title, ("sans-serif", 20)).map_err(words)?;
        for (area, panel) in sheet.split_evenly((panels.len(), 1)).iter().zip(&panels) {
            draw_panel(area, panel, wheelset, &distance, recording).map_err(words)?;
        }
        root.present().map_err(words)
    };
    draw(&mut svg)?;
    write_whole(&file, svg.as_bytes()).map_err(|error| error.to_string())?;
    Ok(file)
}

fn draw_panel<'a>(area: &Area<'a>, panel: &Panel, wheelset: &str, distance: &[f64], recording: &Recording) -> Result<(), DrawingError<'a>> {
    let curves: Vec<(&Curve, Vec<f64>)> = panel
        .curves
        .iter()
        .filter_map(|curve| {
            let values = recording.column(&format!("{wheelset}.{}", curve.column))?;
            Some((curve, values.iter().map(|value| value * curve.factor).collect()))
        })
        .collect();
    let (low, high) = limits(curves.iter().flat_map(|(_, values)| values.iter().copied()));
    let (first, last) = distance_range(distance.iter().copied());
    let mut chart = ChartBuilder::on(area)
        .caption(panel.title, ("sans-serif", 15))
        .margin(8)
        .margin_right(24)
        .x_label_area_size(36)
        .y_label_area_size(64)
        .build_cartesian_2d(first..last, low..high)?;
    chart
        .configure_mesh()
        .x_desc("distance [m]")
        .y_desc(panel.axis)
        .x_labels(11)
        .y_labels(6)
        .light_line_style(TRANSPARENT)
        .bold_line_style(GREY.mix(0.25))
        .axis_style(GREY)
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| short(*value))
        .label_style(("sans-serif", 13))
        .draw()?;
    for (curve, values) in &curves {
        let color = curve.color;
        let series = LineSeries::new(distance.iter().copied().zip(values.iter().copied()), color.stroke_width(2));
        let drawn = chart.draw_series(series)?;
        if !curve.label.is_empty() {
            drawn.label(curve.label).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        }
    }
    if curves.iter().any(|(curve, _)| !curve.label.is_empty()) {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .label_font(("sans-serif", 13))
            .draw()?;
    }
    Ok(())
}
