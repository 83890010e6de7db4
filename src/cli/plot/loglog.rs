//! Panels of points over two logarithmic axes that all panels share: what accuracy costs.
//!
//! A series keeps its colour and its mark in every picture. Colours are those of Okabe and Ito (Color Universal Design, 2008), which
//! people with the common colour deficiencies tell apart, the yellow one darkened; marks tell series apart without colour. The legend
//! stands above the panels, where it covers nothing.

use super::{Area, BLACK_GREY, DrawingError, FINE, GREY, extent, fine_mesh, px, write_sheet};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use std::path::Path;

/// A point; `low` and `high` are the ends of its bar along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cli) struct Mark {
    pub x: f64,
    pub y: f64,
    pub low: f64,
    pub high: f64,
    /// Is y only a bound, below which the point lies?
    pub bound: bool,
}

/// Points joined by a line. `style` numbers colour and mark.
pub(in crate::cli) struct Series {
    pub label: String,
    pub style: usize,
    pub marks: Vec<Mark>,
}

pub(in crate::cli) struct Panel {
    pub title: String,
    pub series: Vec<Series>,
    /// Dashed lines across the panel, and what they are: words beside the title, where they cover nothing.
    pub levels: Vec<f64>,
    pub aside: String,
}

/// What surrounds the panels.
pub(in crate::cli) struct Sheet<'a> {
    pub title: &'a str,
    /// Lines below the title.
    pub subtitles: &'a [String],
    /// Captions of the horizontal and the vertical axis.
    pub axes: [&'a str; 2],
    pub panels: &'a [Panel],
}

const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(178, 160, 0),
];

/// Pixels.
const PANEL: (u32, u32) = (520, 400);
const TITLE: u32 = 40;
const LINE: u32 = 20;
const ENTRY: u32 = 26;
const STRIP: u32 = 28;
const RADIUS: u32 = 5;
const FONT: &str = "sans-serif";

fn color(style: usize) -> RGBColor {
    COLORS[style % COLORS.len()]
}

/// Corners of a mark about a centre.
fn outline(style: usize, centre: (i32, i32), radius: i32) -> Vec<(i32, i32)> {
    let corners = |count: usize, turn: f64, size: f64| -> Vec<(i32, i32)> {
        let corner = |k: usize| {
            let angle = std::f64::consts::TAU * (k as f64 / count as f64 + turn);
            let place = |part: f64| (f64::from(radius) * size * part).round() as i32;
            (centre.0 + place(angle.sin()), centre.1 - place(angle.cos()))
        };
        (0..=count).map(corner).collect()
    };
    match style % 5 {
        0 => corners(24, 0.0, 1.0),
        1 => corners(4, 0.125, 1.25),
        2 => corners(3, 0.0, 1.35),
        3 => corners(4, 0.0, 1.3),
        _ => corners(3, 0.5, 1.35),
    }
}

/// Draws the sheet into `file`.
pub(in crate::cli) fn draw(file: &Path, sheet: &Sheet) -> Result<(), String> {
    let columns = sheet.panels.len().clamp(1, 2);
    let rows = sheet.panels.len().div_ceil(columns).max(1);
    let width = PANEL.0 * columns as u32 + if columns == 1 { 240 } else { 0 };
    let entries = legend(sheet.panels, width);
    let lines = entries.last().map_or(0, |entry| entry.line + 1);
    let head = TITLE + LINE * sheet.subtitles.len() as u32 + ENTRY * lines + 10;
    let marks = || sheet.panels.iter().flat_map(|panel| panel.series.iter().flat_map(|series| series.marks.iter()));
    let levels = sheet.panels.iter().flat_map(|panel| panel.levels.iter().copied());
    let x = axis(marks().flat_map(|mark| [mark.x, mark.low, mark.high]));
    let y = axis(marks().map(|mark| mark.y).chain(levels));
    write_sheet(file, (width, head + PANEL.1 * rows as u32), |root| {
        let (top, below) = root.split_vertically(px(head));
        draw_head(&top, sheet, width, &entries)?;
        for (area, panel) in below.split_evenly((rows, columns)).iter().zip(sheet.panels) {
            draw_panel(area, sheet.axes, panel, [&x, &y])?;
        }
        Ok(())
    })
}

/// A place in the legend.
struct Entry {
    label: String,
    style: usize,
    x: u32,
    line: u32,
}

/// Every series once, in lines that fit the sheet.
fn legend(panels: &[Panel], width: u32) -> Vec<Entry> {
    let mut all: Vec<(usize, &str)> =
        panels.iter().flat_map(|panel| panel.series.iter().map(|series| (series.style, series.label.as_str()))).collect();
    all.sort_unstable();
    all.dedup();
    let (mut x, mut line) = (20, 0);
    let place = |(style, label): (usize, &str)| {
        // A letter is about 7.5 pixels wide.
        let wide = 54 + label.chars().count() as u32 * 15 / 2;
        if x + wide > width {
            (x, line) = (20, line + 1);
        }
        let entry = Entry { label: label.into(), style, x, line };
        x += wide;
        entry
    };
    all.into_iter().map(place).collect()
}

fn draw_head<'a>(area: &Area<'a>, sheet: &Sheet, width: u32, entries: &[Entry]) -> Result<(), DrawingError<'a>> {
    let centred = |size: u32| (FONT, px(size)).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Top));
    area.draw(&Text::new(sheet.title.to_string(), (px(width) / 2, px(12)), centred(20)))?;
    for (line, words) in sheet.subtitles.iter().enumerate() {
        let at = (px(width) / 2, px(TITLE + LINE * line as u32));
        area.draw(&Text::new(words.clone(), at, centred(14).color(&GREY)))?;
    }
    let name = (FONT, px(14)).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
    let first = TITLE + LINE * sheet.subtitles.len() as u32 + ENTRY / 2;
    for entry in entries {
        let (x, y) = (px(entry.x), px(first + ENTRY * entry.line));
        let style = color(entry.style);
        area.draw(&PathElement::new([(x, y), (x + px(30), y)], style.stroke_width(FINE * 3 / 2)))?;
        area.draw(&Polygon::new(outline(entry.style, (x + px(15), y), px(RADIUS)), style.filled()))?;
        area.draw(&Text::new(entry.label.clone(), (x + px(37), y), name.clone()))?;
    }
    Ok(())
}

/// A logarithmic axis with labels at decades, and at 2 and 5 of each where there are few. (That of the drawing library needs whole
/// decades.)
#[derive(Clone)]
struct LogAxis {
    low: f64,
    high: f64,
}

/// An axis for some values, with air around them.
fn axis(values: impl Iterator<Item = f64>) -> LogAxis {
    const AIR: f64 = 1.6;
    let (low, high) = extent(values.filter(|value| *value > 0.0));
    if low <= high && high.is_finite() { LogAxis { low: low / AIR, high: high * AIR } } else { LogAxis { low: 0.1, high: 1.0 } }
}

impl LogAxis {
    /// Place of a value along the axis, 0 to 1.
    fn part(&self, value: f64) -> f64 {
        (value / self.low).ln() / (self.high / self.low).ln()
    }

    fn ticks(&self) -> Vec<f64> {
        const FEW: f64 = 2.5;
        let digits: &[f64] = if (self.high / self.low).log10() < FEW { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decades = self.low.log10().floor() as i32..=self.high.log10().floor() as i32;
        let all = decades.flat_map(|decade| digits.iter().map(move |digit| format!("{digit}e{decade}").parse().unwrap_or(f64::NAN)));
        all.filter(|tick| (self.low..=self.high).contains(tick)).collect()
    }
}

impl Ranged for LogAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        limit.0 + (f64::from(limit.1 - limit.0) * self.part(*value)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for LogAxis {
    fn format(value: &f64) -> String {
        if (1e-3..1e5).contains(value) { format!("{value}") } else { format!("{value:e}") }
    }
}

fn draw_panel<'a>(area: &Area<'a>, axes: [&str; 2], panel: &Panel, [x, y]: [&LogAxis; 2]) -> Result<(), DrawingError<'a>> {
    let (strip, below) = area.split_vertically(px(STRIP));
    let title = (FONT, px(16)).into_text_style(&strip).pos(Pos::new(HPos::Left, VPos::Center));
    strip.draw(&Text::new(panel.title.clone(), (px(84), px(STRIP / 2)), title))?;
    let aside = (FONT, px(12)).into_text_style(&strip).color(&BLACK_GREY).pos(Pos::new(HPos::Right, VPos::Center));
    strip.draw(&Text::new(panel.aside.clone(), (strip.dim_in_pixel().0 as i32 - px(22), px(STRIP / 2)), aside))?;
    let mut chart = ChartBuilder::on(&below)
        .margin_left(px(10))
        .margin_right(px(22))
        .margin_bottom(px(10))
        .x_label_area_size(px(44))
        .y_label_area_size(px(74))
        .build_cartesian_2d(x.clone(), y.clone())?;
    fine_mesh(&mut chart, 13).x_desc(axes[0]).y_desc(axes[1]).draw()?;
    for level in &panel.levels {
        let line = DashedPathElement::new([(x.low, *level), (x.high, *level)], px(6), px(4), BLACK_GREY.stroke_width(FINE));
        chart.draw_series([line])?;
    }
    for series in &panel.series {
        let own = color(series.style);
        chart.draw_series(LineSeries::new(series.marks.iter().map(|mark| (mark.x, mark.y)), own.mix(0.6).stroke_width(FINE * 3 / 2)))?;
        for mark in &series.marks {
            let bar = [(mark.low, mark.y), (mark.high, mark.y)];
            chart.draw_series([PathElement::new(bar, own.stroke_width(FINE * 3 / 2))])?;
            let cap = [(0, -px(RADIUS + 2)), (0, px(RADIUS + 2))];
            let caps = bar.map(|end| EmptyElement::at(end) + PathElement::new(cap, own.stroke_width(FINE)));
            if mark.high > mark.low {
                chart.draw_series(caps)?;
            }
            let shape = outline(series.style, (0, 0), px(RADIUS));
            if mark.bound {
                // Hollow, with an arrow down: better than this.
                let (tip, wing) = (px(RADIUS + 13), px(3));
                let arrow = vec![(0, px(RADIUS)), (0, tip), (-wing, tip - wing), (0, tip), (wing, tip - wing)];
                let at = || EmptyElement::at((mark.x, mark.y));
                chart.draw_series([at() + Polygon::new(shape.clone(), WHITE.filled())])?;
                chart.draw_series([at() + PathElement::new(shape, own.stroke_width(FINE * 3 / 2))])?;
                chart.draw_series([at() + PathElement::new(arrow, own.stroke_width(FINE * 5 / 4))])?;
            } else {
                chart.draw_series([EmptyElement::at((mark.x, mark.y)) + Polygon::new(shape, own.filled())])?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_panels_name_every_series_once_and_legends_fit_the_sheet() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.svg");
        let mark = |x: f64, y: f64, bound| Mark { x, y, low: 0.9 * x, high: 1.2 * x, bound };
        let series = |style: usize| Series {
            label: format!("method number {style}"),
            style,
            marks: vec![mark(1.0 + style as f64, 1e-6, false), mark(3.0, 1e-9, true)],
        };
        let panel = |title: &str, count: usize| Panel {
            title: title.into(),
            series: (0..count).map(series).collect(),
            levels: vec![1e-5],
            aside: "a level".into(),
        };
        let panels = [panel("First", 9), panel("Second", 3), panel("Third", 0)];
        let subtitles = ["one line".to_string(), "another".to_string()];
        draw(&file, &Sheet { title: "Title", subtitles: &subtitles, axes: ["along", "up"], panels: &panels }).unwrap();
        let svg = std::fs::read_to_string(&file).unwrap();
        for word in ["Title", "one line", "another", "First", "Third", "along", "up", "a level", "1e-6", "<polygon"] {
            assert!(svg.contains(word), "{word}");
        }
        assert_eq!(svg.matches("method number 0\n").count(), 1, "each series stands in the legend once");
        let entries = legend(&panels, 1040);
        assert!(entries.len() == 9 && entries.iter().all(|entry| entry.x + 150 < 1040) && entries[8].line == 1);
        let near = |axis: LogAxis, wanted: &[f64]| assert_eq!(axis.ticks(), wanted);
        near(LogAxis { low: 1.5, high: 60.0 }, &[2.0, 5.0, 10.0, 20.0, 50.0]);
        near(LogAxis { low: 5e-4, high: 2.0 }, &[1e-3, 0.01, 0.1, 1.0]);
        assert_eq!([1e-7, 0.01, 5.0, 1e5].map(|value| LogAxis::format(&value)), ["1e-7", "0.01", "5", "1e5"]);
        // Nothing at all: an empty diagram.
        draw(&file, &Sheet { title: "Title", subtitles: &[], axes: ["along", "up"], panels: &[] }).unwrap();
    }
}
