//! Labelled points over two logarithmic axes.

use super::{BLUE, DrawingError, GREY, extent};
use crate::cli::output::write_whole;
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
    // A little more: rounding must not take the labels of the ends.
    const MORE: f64 = 1.0 + 1e-9;
    (10f64.powf((low.log10() - 0.1).floor()) / MORE, 10f64.powf((high.log10() + 0.1).ceil()) * MORE)
}

/// Decades: 1e-7 -> "1e-7", 0.01 -> "0.01", 10 -> "10".
fn power(value: &f64) -> String {
    let exponent = value.log10().round() as i32;
    match exponent {
        -3..0 => format!("{value:.0$}", exponent.unsigned_abs() as usize),
        0..=4 => format!("{value:.0}"),
        _ => format!("1e{exponent}"),
    }
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
        for (point, label) in points.iter().zip(labels(points, x, y)).filter_map(|(point, label)| Some((point, label?))) {
            if let Some((from, to)) = label.leader() {
                let pixels = |(x, y): (f64, f64)| (x as i32, y as i32);
                root.draw(&PathElement::new([pixels(from), pixels(to)], GREY.mix(0.7)))?;
            }
            let style = (FONT, 14).into_text_style(&root).pos(Pos::new(label.anchor, VPos::Center));
            root.draw(&Text::new(point.label.to_string(), (label.at.0 as i32, label.at.1 as i32), style))?;
        }
        root.present()
    };
    sheet(&mut svg).map_err(|error| format!("{}: can't be drawn: {error}", file.display()))?;
    write_whole(file, svg.as_bytes()).map_err(|error| error.to_string())
}

/// A rectangle on the sheet, in pixels.
#[derive(Clone, Copy, Debug)]
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Area {
    fn overlaps(&self, other: &Area) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    fn on_sheet(&self) -> bool {
        let (width, height) = (f64::from(SIZE.0), f64::from(SIZE.1));
        self.left > FRAME.0 && self.right < width - 4.0 && self.top > FRAME.2 && self.bottom < height - FRAME.3
    }
}

/// Where a label stands, in pixels.
struct Label {
    point: (f64, f64),
    at: (f64, f64),
    anchor: HPos,
    area: Area,
}

impl Label {
    fn new(point: (f64, f64), at: (f64, f64), anchor: HPos, letters: usize) -> Self {
        const LETTER: f64 = 6.8;
        let width = LETTER * letters as f64;
        let left = match anchor {
            HPos::Left => at.0,
            HPos::Center => at.0 - 0.5 * width,
            HPos::Right => at.0 - width,
        };
        Label { point, at, anchor, area: Area { left, right: left + width, top: at.1 - 8.0, bottom: at.1 + 8.0 } }
    }

    /// A line from the point to a label that does not stand next to it.
    fn leader(&self) -> Option<((f64, f64), (f64, f64))> {
        const NEXT_TO: f64 = 20.0;
        let near = self.point.0.clamp(self.area.left - 3.0, self.area.right + 3.0);
        ((self.at.1 - self.point.1).abs() > NEXT_TO).then_some((self.point, (near, self.at.1)))
    }
}

/// Labels beside their points, each at the first place that is clear of all points and of the labels before it; `None` where there is no
/// such place.
fn labels(points: &[Point], x: (f64, f64), y: (f64, f64)) -> Vec<Option<Label>> {
    const RADIUS: f64 = 7.0;
    const BESIDE: f64 = 12.0;
    const LINE: f64 = 17.0;
    const LINES: usize = 8;
    let part = |value: f64, range: (f64, f64)| (value / range.0).ln() / (range.1 / range.0).ln();
    let (width, height) = (f64::from(SIZE.0) - FRAME.0 - FRAME.1, f64::from(SIZE.1) - FRAME.2 - FRAME.3);
    let place = |point: &Point| (FRAME.0 + width * part(point.x, x), FRAME.2 + height * (1.0 - part(point.y, y)));
    let mut taken: Vec<Area> = points
        .iter()
        .map(place)
        .map(|(px, py)| Area { left: px - RADIUS, right: px + RADIUS, top: py - RADIUS, bottom: py + RADIUS })
        .collect();
    let label = |point: &Point| {
        let ((px, py), letters) = (place(point), point.label.chars().count());
        let beside = |line: f64, anchor: HPos| {
            let aside = match anchor {
                HPos::Left => BESIDE,
                HPos::Center => 0.0,
                HPos::Right => -BESIDE,
            };
            Label::new((px, py), (px + aside, py + line * LINE), anchor, letters)
        };
        let near = [(0.0, HPos::Left), (0.0, HPos::Right), (-1.0, HPos::Center), (1.0, HPos::Center)];
        let around = |k: f64| [(-k, HPos::Left), (k, HPos::Left), (-k, HPos::Right), (k, HPos::Right)];
        let further = (1..LINES).flat_map(|k| around(k as f64));
        let mut places = near.into_iter().chain(further).map(|(line, anchor)| beside(line, anchor));
        let label = places.find(|label| label.area.on_sheet() && !taken.iter().any(|area| area.overlaps(&label.area)))?;
        taken.push(label.area);
        Some(label)
    };
    points.iter().map(label).collect()
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
        let named = |points: &[Point]| -> Vec<Label> { labels(points, (1e-8, 1e-3), (1e-3, 1.0)).into_iter().flatten().collect() };
        let places = named(&points);
        assert!(places.len() == 3 && places.iter().all(|label| label.leader().is_none()));
        assert!(!places[0].area.overlaps(&places[1].area), "{:?} {:?}", places[0].area, places[1].area);
        let crowd: Vec<Point> = (0..9).map(|i| point("a long name", 1e-6 * 1.02f64.powi(i), 0.01 * 1.1f64.powi(i))).collect();
        let places = named(&crowd);
        assert!(places.len() == 9 && places.iter().any(|label| label.leader().is_some()));
        for (i, first) in places.iter().enumerate() {
            assert!(first.area.on_sheet() && places[..i].iter().all(|other| !other.area.overlaps(&first.area)), "{:?}", first.area);
        }
        assert_eq!([1e-7, 0.01, 1.0, 10.0].map(|value| power(&value)), ["1e-7", "0.01", "1", "10"]);
        // No points at all: an empty diagram.
        draw(&file, "Title", "", ["along", "up"], &[]).unwrap();
    }
}
