//! A sheet of diagrams in a grid: curves over one quantity, each in branches. Nothing is drawn across a jump between branches;
//! their ends have dots.
//!
//! Like the pair diagram the sheet is drawn larger than it is shown, because the drawing library rounds coordinates.

use super::axis::Axis;
use super::{Area, BLACK_GREY, DrawingError, FINE, GREY, extent, fine_mesh, limits, px, write_sheet};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// One curve; a dashed one is drawn on top of others.
pub(in crate::cli) struct Curve<'a> {
    pub label: &'a str,
    pub color: RGBColor,
    pub dashed: bool,
    pub branches: Vec<Vec<(f64, f64)>>,
}

/// One diagram.
pub(in crate::cli) struct Panel<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub curves: Vec<Curve<'a>>,
    /// Points to point out, with a label each.
    pub marks: Vec<((f64, f64), String)>,
    /// Must the vertical axis show zero?
    pub from_zero: bool,
}

/// Pixels.
const PANEL: (u32, u32) = (560, 330);
const HEAD: u32 = 66;
/// Title and legend of a panel; labels of its vertical axis.
const STRIP: u32 = 30;
const LABELS: u32 = 62;
const FONT: &str = "sans-serif";

/// Draws panels in rows of `columns`.
pub(in crate::cli) fn draw(file: &Path, title: &str, subtitle: &str, columns: usize, panels: &[Panel]) -> Result<(), String> {
    let rows = panels.len().div_ceil(columns);
    let size = (PANEL.0 * columns as u32, HEAD + PANEL.1 * rows as u32);
    write_sheet(file, size, |root| {
        let (head, below) = root.split_vertically(px(HEAD));
        let centred = |size: u32| (FONT, px(size)).into_text_style(&head).pos(Pos::new(HPos::Center, VPos::Top));
        head.draw(&Text::new(title, (px(size.0) / 2, px(12)), centred(20)))?;
        head.draw(&Text::new(subtitle, (px(size.0) / 2, px(40)), centred(14).color(&GREY)))?;
        for (area, panel) in below.split_evenly((rows, columns)).iter().zip(panels) {
            draw_panel(area, panel)?;
        }
        Ok(())
    })
}

fn draw_panel<'a>(area: &Area<'a>, panel: &Panel) -> Result<(), DrawingError<'a>> {
    let points = || panel.curves.iter().flat_map(|curve| curve.branches.iter().flatten());
    let zero = panel.from_zero.then_some(0.0);
    let (low, high) = limits(points().map(|point| point.1).chain(zero));
    let (first, last) = extent(points().map(|point| point.0));
    let range = if last > first { (first, last) } else { (first - 1.0, first + 1.0) };
    let (strip, below) = area.split_vertically(px(STRIP));
    let title = (FONT, px(16)).into_text_style(&strip).pos(Pos::new(HPos::Left, VPos::Center));
    strip.draw(&Text::new(panel.title, (px(10 + LABELS), px(STRIP / 2)), title))?;
    legend(&strip, panel)?;
    let mut chart = ChartBuilder::on(&below)
        .margin_left(px(10))
        .margin_right(px(18))
        .margin_bottom(px(10))
        .x_label_area_size(px(42))
        .y_label_area_size(px(LABELS))
        .build_cartesian_2d(Axis { range, most: 9 }, Axis { range: (low, high), most: 7 })?;
    fine_mesh(&mut chart, 13).x_desc(panel.x).y_desc(panel.y).draw()?;
    for curve in &panel.curves {
        let style = curve.color.stroke_width(FINE * 2);
        for branch in &curve.branches {
            let points = thinned(branch, (range.1 - range.0, high - low));
            if curve.dashed {
                chart.draw_series(DashedLineSeries::new(points, px(7), px(5), style))?;
            } else {
                chart.draw_series(LineSeries::new(points, style))?;
            }
        }
        // Where branches meet, the contact jumps.
        let ends = curve.branches.windows(2).flat_map(|pair| [pair[0].last(), pair[1].first()]).flatten();
        chart.draw_series(ends.map(|point| Circle::new(*point, px(3), curve.color.filled())))?;
    }
    for (point, words) in &panel.marks {
        let label = (FONT, px(14)).into_text_style(area).color(&BLACK_GREY);
        chart.draw_series([Circle::new(*point, px(4), BLACK_GREY.filled())])?;
        let text = EmptyElement::at(*point) + Text::new(words.clone(), (px(8), -px(20)), label);
        chart.draw_series([text])?;
    }
    Ok(())
}

/// A branch without points that are less than half a pixel beside the one before; `size` is that of the diagram.
fn thinned(branch: &[(f64, f64)], size: (f64, f64)) -> Vec<(f64, f64)> {
    let (width, height) = (size.0 / f64::from(2 * PANEL.0), size.1 / f64::from(2 * PANEL.1));
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for (index, point) in branch.iter().enumerate() {
        let far = |last: &(f64, f64)| (point.0 - last.0).abs() > width || (point.1 - last.1).abs() > height;
        if index + 1 == branch.len() || kept.last().is_none_or(far) {
            kept.push(*point);
        }
    }
    kept
}

/// Names beside short lines, at the right end of the strip that holds the title.
fn legend<'a>(area: &Area<'a>, panel: &Panel) -> Result<(), DrawingError<'a>> {
    let name = (FONT, px(13)).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
    let names: Vec<&Curve> = panel.curves.iter().filter(|curve| !curve.label.is_empty()).collect();
    // A letter is about 7 pixels wide.
    let width = |curve: &Curve| px(44 + 7 * curve.label.chars().count() as u32);
    let mut x = px(PANEL.0 - 18) - names.iter().map(|curve| width(curve)).sum::<i32>();
    let y = px(STRIP / 2);
    for curve in names {
        let (line, style) = ([(x, y), (x + px(26), y)], curve.color.stroke_width(FINE * 2));
        if curve.dashed {
            area.draw(&DashedPathElement::new(line, px(7), px(5), style))?;
        } else {
            area.draw(&PathElement::new(line, style))?;
        }
        area.draw(&Text::new(curve.label.to_string(), (x + px(31), y), name.clone()))?;
        x += width(curve);
    }
    Ok(())
}
