//! Labelled points over two logarithmic axes.

use super::{BLUE, DrawingError, GREY, extent};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// One point with its name.
pub(in crate::cli) struct Point<'a> {
    pub label: &'a str,
    pub x: f64,
    pub y: f64,
}

const SIZE: (u32, u32) = (860, 560);
const FONT: &str = "sans-serif";
/// Pixels of the diagram's frame: left, right, top, bottom.
const FRAME: (f64, f64, f64, f64) = (84.0, 24.0, 66.0, 54.0);

/// The whole decades around some values, with room for labels.
fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = extent(values);
    if !(low > 0.0 && high.is_finite()) {
        return (0.1, 1.0);
    }
    (10f64.powf((low.log10() - 0.1).floor()), 10f64.powf((high.log10() + 0.1).ceil()))
}

/// 1e-7 -> "1e-7".
fn power(value: &f64) -> String {
    format!("1e{:.0}", value.log10())
}

/// Draws positive points into `file`; `axes`: captions of the horizontal and the vertical axis.
pub(in crate::cli) fn draw(file: &Path, title: &str, subtitle: &str, axes: [&str; 2], points: &[Point]) -> Result<(), String> {
    let mut svg = String::new();
    let (x, y) = (decades(points.iter().map(|p| p.x)), decades(points.iter().map(|p| p.y)));
    let sheet = |svg: &mut String| -> Result<(), DrawingError> {
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let centred = |size: u32| (FONT, size).into_text_style(&root).pos(Pos::new(HPos::Center, VPos::Top));
        let middle = SIZE.0 as i32 / 2;
        root.draw(&Text::new(title.to_string(), (middle, 12), centred(20)))?;
        root.draw(&Text::new(subtitle.to_string(), (middle, 38), centred(14).color(&GREY)))?;
        let mut chart = ChartBuilder::on(&root)
            .margin_left(14)
            .margin_right(FRAME.1 as i32)
            .margin_top(FRAME.2 as i32)
            .margin_bottom(10)
            .x_label_area_size(FRAME.3 as i32 - 10)
            .y_label_area_size(FRAME.0 as i32 - 14)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
        chart
            .configure_mesh()
            .x_desc(axes[0])
            .y_desc(axes[1])
            .x_label_formatter(&power)
            .y_label_formatter(&power)
            .light_line_style(GREY.mix(0.08))
            .bold_line_style(GREY.mix(0.3))
            .axis_style(GREY)
            .label_style((FONT, 14))
            .draw()?;
        chart.draw_series(points.iter().map(|point| Circle::new((point.x, point.y), 5, BLUE.filled())))?;
        for (point, at) in points.iter().zip(labels(points, x, y)) {
            let style = (FONT, 14).into_text_style(&root).pos(Pos::new(at.2, VPos::Center));
            root.draw(&Text::new(point.label.to_string(), (at.0, at.1), style))?;
        }
        root.present()
    };
    sheet(&mut svg).map_err(|error| format!("{}: can't be drawn: {error}", file.display()))?;
    std::fs::write(file, svg).map_err(|error| format!("{}: can't be written: {error}", file.display()))
}

/// Where labels stand, in pixels: beside their points, on the side that has room, moved down until they are clear of others.
fn labels(points: &[Point], x: (f64, f64), y: (f64, f64)) -> Vec<(i32, i32, HPos)> {
    let part = |value: f64, range: (f64, f64)| (value / range.0).ln() / (range.1 / range.0).ln();
    let (width, height) = (f64::from(SIZE.0) - FRAME.0 - FRAME.1, f64::from(SIZE.1) - FRAME.2 - FRAME.3);
    let mut taken: Vec<(f64, f64, f64)> = Vec::new();
    points
        .iter()
        .map(|point| {
            let (px, py) = (FRAME.0 + width * part(point.x, x), FRAME.2 + height * (1.0 - part(point.y, y)));
            let length = 7.5 * point.label.chars().count() as f64;
            let right = px + 12.0 + length < f64::from(SIZE.0) - 4.0;
            let start = if right { px + 12.0 } else { px - 12.0 - length };
            let mut down = py;
            while taken.iter().any(|t| (t.1 - down).abs() < 15.0 && t.0 < start + length && start < t.0 + t.2) {
                down += 3.0;
            }
            taken.push((start, down, length));
            (if right { px + 12.0 } else { px - 12.0 } as i32, down as i32, if right { HPos::Left } else { HPos::Right })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_point_is_named_and_labels_do_not_cover_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.svg");
        let point = |label, x, y| Point { label, x, y };
        let points = [point("one", 1e-7, 0.01), point("two", 1.1e-7, 0.0101), point("three", 5e-4, 0.3)];
        draw(&file, "Title", "Subtitle", ["along", "up"], &points).unwrap();
        let svg = std::fs::read_to_string(&file).unwrap();
        for word in ["Title", "Subtitle", "along", "up", "one", "two", "three", "1e-7", "<circle"] {
            assert!(svg.contains(word), "{word}: {svg}");
        }
        let places = labels(&points, (1e-8, 1e-3), (1e-3, 1.0));
        assert!((places[0].1 - places[1].1).abs() >= 15, "{:?} {:?}", places[0].1, places[1].1);
        // No points at all: an empty diagram.
        draw(&file, "Title", "", ["along", "up"], &[]).unwrap();
    }
}
