//! Two runs in one diagram over distance, and their difference below it.
//!
//! The first curve is a broad pale line, the second a thin dashed one on top, so that both are seen where they coincide. The
//! difference has a scale and a unit of its own: the picture says how small it is.
//!
//! The drawing library rounds coordinates to whole units. The sheet is therefore drawn [`FINE`] times larger than it is shown,
//! so that curves stay smooth.

use super::axis::Axis;
use super::{Area, BLUE, DrawingError, FINE, GREY, ORANGE, distance_range, fine_mesh, limits, px, write_sheet};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// A curve in SI units over distance in m.
pub(in crate::cli) struct Curve<'a> {
    pub label: &'a str,
    pub points: Vec<(f64, f64)>,
}

/// What is drawn.
pub(in crate::cli) struct PairDiagram<'a> {
    pub title: String,
    pub subtitle: &'a str,
    /// Of the upper diagram's vertical axis, with the unit that `factor` makes of SI.
    pub axis: &'a str,
    pub factor: f64,
    /// SI unit of the curves; the difference's axis puts a prefix before it.
    pub unit: &'a str,
    pub curves: [Curve<'a>; 2],
    /// First minus second over distance in m, SI.
    pub difference: Vec<(f64, f64)>,
}

/// Pixels.
const WIDTH: u32 = 900;
const HEIGHT: u32 = 580;
/// Title, subtitle and legend.
const HEAD: u32 = 88;
/// Caption of the difference, its diagram and the distance axis.
const FOOT: u32 = 196;
/// Where the diagrams begin at the left, beyond the margin.
const LEFT: u32 = 72;
const MARGIN: u32 = 14;
const FONT: &str = "sans-serif";

/// Draws the diagram into `file`.
pub(in crate::cli) fn draw(file: &Path, diagram: &PairDiagram) -> Result<(), String> {
    write_sheet(file, (WIDTH, HEIGHT), |root| {
        let (head, below) = root.split_vertically(px(HEAD));
        let (upper, lower) = below.split_vertically(px(HEIGHT - HEAD - FOOT));
        let distances = diagram.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.0));
        let range = distance_range(distances);
        draw_head(&head, diagram)?;
        draw_curves(&upper, diagram, range)?;
        draw_difference(&lower, diagram, range)?;
        Ok(())
    })
}

fn first_style() -> ShapeStyle {
    BLUE.mix(0.5).stroke_width(FINE * 5)
}

fn second_style() -> ShapeStyle {
    ORANGE.stroke_width(FINE * 2)
}

fn draw_head<'a>(area: &Area<'a>, diagram: &PairDiagram) -> Result<(), DrawingError<'a>> {
    let centred = |size: u32| (FONT, px(size)).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Top));
    let middle = px(WIDTH) / 2;
    area.draw(&Text::new(diagram.title.as_str(), (middle, px(10)), centred(20)))?;
    area.draw(&Text::new(diagram.subtitle, (middle, px(36)), centred(14).color(&GREY)))?;
    // The legend stands outside the diagram, where no curve can pass behind it.
    let name = (FONT, px(14)).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
    let height = px(70);
    for (index, curve) in diagram.curves.iter().enumerate() {
        let x = px(MARGIN + LEFT + 130 * index as u32);
        let line = [(x, height), (x + px(36), height)];
        if index == 0 {
            area.draw(&PathElement::new(line, first_style()))?;
        } else {
            area.draw(&DashedPathElement::new(line, DASH, GAP, second_style()))?;
        }
        area.draw(&Text::new(curve.label, (x + px(44), height), name.clone()))?;
    }
    Ok(())
}

const DASH: i32 = px(8);
const GAP: i32 = px(6);

fn draw_curves<'a>(area: &Area<'a>, diagram: &PairDiagram, range: (f64, f64)) -> Result<(), DrawingError<'a>> {
    let scaled = |curve: &Curve| -> Vec<(f64, f64)> { curve.points.iter().map(|(x, value)| (*x, value * diagram.factor)).collect() };
    let [first, second] = [scaled(&diagram.curves[0]), scaled(&diagram.curves[1])];
    let (low, high) = limits(first.iter().chain(&second).map(|point| point.1));
    let (along, up) = (Axis { range, most: 11 }, Axis { range: (low, high), most: 7 });
    let mut chart = ChartBuilder::on(area)
        .margin_left(px(MARGIN))
        .margin_right(px(24))
        .margin_top(px(4))
        .x_label_area_size(px(10))
        .y_label_area_size(px(LEFT))
        .build_cartesian_2d(along, up)?;
    fine_mesh(&mut chart, 14).y_desc(diagram.axis).x_label_formatter(&|_| String::new()).draw()?;
    chart.draw_series(LineSeries::new(first, first_style()))?;
    chart.draw_series(DashedLineSeries::new(second, DASH, GAP, second_style()))?;
    Ok(())
}

fn draw_difference<'a>(area: &Area<'a>, diagram: &PairDiagram, range: (f64, f64)) -> Result<(), DrawingError<'a>> {
    let largest = diagram.difference.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or_default();
    let (prefix, size) = prefix(largest.1.abs());
    let unit = format!("{prefix}{}", diagram.unit);
    let values: Vec<(f64, f64)> = diagram.difference.iter().map(|(x, value)| (*x, value / size)).collect();
    let (low, high) = limits(values.iter().map(|point| point.1));
    let (along, up) = (Axis { range, most: 11 }, Axis { range: (low, high), most: 5 });
    let [first, second] = [diagram.curves[0].label, diagram.curves[1].label];
    let caption = if largest.1 == 0.0 {
        format!("{first} minus {second}: no difference")
    } else {
        format!("{first} minus {second}: at most {} {unit}, at {:.1} m", three_digits(largest.1.abs() / size), largest.0)
    };
    let mut chart = ChartBuilder::on(area)
        .caption(caption, (FONT, px(15)))
        .margin_left(px(MARGIN))
        .margin_right(px(24))
        .margin_bottom(px(8))
        .x_label_area_size(px(40))
        .y_label_area_size(px(LEFT))
        .build_cartesian_2d(along, up)?;
    fine_mesh(&mut chart, 14).x_desc("distance [m]").y_desc(format!("difference [{unit}]")).draw()?;
    chart.draw_series(LineSeries::new(values, BLACK.mix(0.75).stroke_width(FINE + FINE / 4)))?;
    Ok(())
}

/// Decimal prefix that brings a value between 1 and 1000, and its size.
fn prefix(value: f64) -> (&'static str, f64) {
    const PREFIXES: [(&str, f64); 7] = [("k", 1e3), ("", 1.0), ("m", 1e-3), ("\u{b5}", 1e-6), ("n", 1e-9), ("p", 1e-12), ("f", 1e-15)];
    PREFIXES.into_iter().find(|prefix| value >= prefix.1).unwrap_or(("", 1.0))
}

/// Three significant digits of a value between 1 and 1000.
fn three_digits(value: f64) -> String {
    let decimals = if value < 9.995 { 2 } else { usize::from(value < 99.95) };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_prefixes_bring_values_between_1_and_1000() {
        for exponent in -15..6 {
            for digit in [1.0, 3.7, 9.99] {
                let value = digit * 10f64.powi(exponent) * (1.0 + 1e-9);
                let scaled = value / prefix(value).1;
                assert!((1.0..1000.0).contains(&scaled), "{value} -> {scaled}");
                assert!((4..=5).contains(&(three_digits(scaled).len() + usize::from(scaled >= 99.95))), "{}", three_digits(scaled));
            }
        }
        assert_eq!(prefix(0.0), ("", 1.0));
    }

    /// A crossing of curves, one of them constant, and a single point: nothing panics, both curves and the words are there.
    #[test]
    fn prop_a_pair_of_curves_is_drawn_with_both_names_and_the_largest_difference() {
        let folder = tempfile::tempdir().unwrap();
        let curve =
            |label, slope: f64, count: u32| Curve { label, points: (0..count).map(|i| (f64::from(i), slope * f64::from(i))).collect() };
        for (count, words) in [(101, "at most 200 \u{b5}m, at 100.0 m"), (1, "no difference")] {
            let curves = [curve("one", 2e-6, count), curve("two", 0.0, count)];
            let difference = curves[0].points.clone();
            let (file, title) = (folder.path().join("pair.svg"), "Title".to_string());
            let diagram = PairDiagram { title, subtitle: "Scene", axis: "y [mm]", factor: 1e3, unit: "m", curves, difference };
            draw(&file, &diagram).unwrap();
            let svg = std::fs::read_to_string(&file).unwrap();
            for word in ["Title", "Scene", "y [mm]", "distance [m]", "one", "two", words] {
                assert!(svg.contains(word), "{word}: {svg}");
            }
        }
    }
}
