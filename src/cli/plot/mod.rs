//! One sheet for every picture: panels in a grid with axes and units, series of lines and marks, one legend above all of them, as SVG.
//!
//! Axes of a sheet that have the same label share their range, so that panels can be compared by eye. Marks and colours tell
//! series apart by themselves; the colours are those of Okabe and Ito (Color Universal Design, 2008), the yellow one darkened.

mod frame;
mod labels;
mod panel;
mod pen;
mod scale;

use crate::cli::output::write_whole;
use frame::Frame;
pub(super) use frame::inside;
use pen::{START, TOP, fitting, letters};
use plotters::style::RGBColor;
use scale::Scale;
use std::path::Path;

pub(super) const BLUE: RGBColor = RGBColor(31, 95, 168);
pub(super) const ORANGE: RGBColor = RGBColor(208, 98, 36);
pub(super) const DARK: RGBColor = RGBColor(50, 50, 50);

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

/// How a series looks; lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ink {
    pub color: RGBColor,
    pub alpha: f64,
    /// Of its line; 0 for none.
    pub width: f64,
    pub dashed: bool,
    /// Shape of its marks, and their radius.
    pub mark: usize,
    pub radius: f64,
}

impl Ink {
    pub(super) const fn line(color: RGBColor) -> Ink {
        Ink { color, alpha: 1.0, width: 2.0, dashed: false, mark: 0, radius: 0.0 }
    }

    pub(super) const fn dashed(color: RGBColor) -> Ink {
        Ink { dashed: true, ..Ink::line(color) }
    }

    /// Of part number `k` of a vehicle: one colour each, dashed where colours begin again.
    pub(super) fn part(k: usize) -> Ink {
        Ink { dashed: k / COLORS.len() % 2 == 1, width: 1.75, ..Ink::line(COLORS[k % COLORS.len()]) }
    }

    /// Under a dashed line that follows it.
    pub(super) const fn broad(color: RGBColor) -> Ink {
        Ink { alpha: 0.5, width: 5.0, ..Ink::line(color) }
    }

    /// Marks joined by a line, number `style` of those that stand on one sheet.
    pub(super) fn marks(style: usize) -> Ink {
        Ink { alpha: 0.6, width: 1.5, mark: style, radius: 5.0, ..Ink::line(COLORS[style % COLORS.len()]) }
    }
}

/// A point that is marked.
#[derive(Clone, Debug, Default)]
pub(super) struct Mark {
    pub x: f64,
    pub y: f64,
    /// Ends of a bar along x.
    pub bar: Option<(f64, f64)>,
    /// Is y only a bound, below which the point lies?
    pub bound: bool,
    /// Words beside it, if there is room.
    pub label: String,
}

/// Curves in branches, across whose jumps nothing is drawn, and marks.
#[derive(Clone, Debug)]
pub(super) struct Series {
    /// In the legend, if not empty.
    pub label: String,
    pub ink: Ink,
    pub branches: Vec<Vec<(f64, f64)>>,
    pub marks: Vec<Mark>,
}

impl Series {
    pub(super) fn line(label: &str, ink: Ink, points: Vec<(f64, f64)>) -> Series {
        Series { label: label.into(), ink, branches: vec![points], marks: vec![] }
    }

    /// Marks, joined in their order.
    pub(super) fn marks(label: &str, ink: Ink, marks: Vec<Mark>) -> Series {
        Series { marks: marks.clone(), ..Series::line(label, ink, marks.iter().map(|mark| (mark.x, mark.y)).collect()) }
    }

    fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let bar = |mark: &Mark| mark.bar.map_or([mark.x; 2], |(low, high)| [low, high]).map(|x| (x, mark.y));
        self.branches.iter().flatten().copied().chain(self.marks.iter().flat_map(bar))
    }
}

/// A rectangle of a map, with its value in it where there is room.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub from: (f64, f64),
    pub to: (f64, f64),
    pub color: RGBColor,
    pub label: String,
}

/// Colour of a part of a range, dark to bright, which stays in order in grey and for every eye (stops of viridis, S. van der Walt and N. Smith 2015);
/// grey without a value.
pub(super) fn shade(part: Option<f64>) -> RGBColor {
    const STOPS: [[f64; 3]; 5] = [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
    let Some(part) = part else { return RGBColor(205, 205, 205) };
    let at = 4.0 * part.clamp(0.0, 1.0);
    let below = (at as usize).min(3);
    let mixed =
        |channel: usize| (STOPS[below][channel] + (at - below as f64) * (STOPS[below + 1][channel] - STOPS[below][channel])).round() as u8;
    RGBColor(mixed(0), mixed(1), mixed(2))
}

/// One axis; with its unit in the label.
#[derive(Clone, Debug, Default)]
pub(super) struct Axis {
    pub label: String,
    pub log: bool,
    /// Must zero be on it?
    pub zero: bool,
    /// From left to right or from below; that of the values where it is not given.
    pub range: Option<(f64, f64)>,
    /// What it spans at least, so that rounding of what does not move is not blown up.
    pub span: f64,
}

/// One diagram.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub title: String,
    /// Words at the other end of the title's line.
    pub aside: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    /// Areas below lines and marks.
    pub tiles: Vec<Tile>,
    /// Dashed lines across it.
    pub levels: Vec<f64>,
    /// May labels stand anywhere beside their marks, with a line to them where they are far? Otherwise they stand above, in the series' colour.
    pub leaders: bool,
    /// With title and axis, pixels.
    pub height: f64,
}

impl Panel {
    pub(super) fn new(title: &str, [x, y]: [&str; 2], series: Vec<Series>) -> Panel {
        let axis = |label: &str| Axis { label: label.into(), ..Axis::default() };
        let (title, aside) = (title.into(), String::new());
        Panel { title, aside, x: axis(x), y: axis(y), series, tiles: vec![], levels: vec![], leaders: true, height: 360.0 }
    }

    /// With logarithmic axes.
    pub(super) fn log(mut self) -> Panel {
        (self.x.log, self.y.log) = (true, true);
        self
    }
}

/// A picture.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub title: String,
    /// Lines below the title.
    pub subtitles: Vec<String>,
    pub columns: usize,
    pub panels: Vec<Panel>,
}

/// Pixels. Letters stay readable where a page shows a sheet at half its width.
const WIDTHS: [f64; 2] = [900.0, 580.0];
const MARGIN: f64 = 18.0;
const TITLE: f64 = 44.0;
const LINE: f64 = 24.0;

/// Width of a panel on a sheet of so many columns.
pub(super) fn width(columns: usize) -> f64 {
    WIDTHS[usize::from(columns > 1)]
}

/// An entry of the legend: series, place from the left and line.
type Entry<'a> = (&'a Series, f64, usize);

impl Sheet {
    /// Draws it into a file.
    ///
    /// # Errors
    /// In words.
    pub(super) fn draw(&self, file: &Path) -> Result<(), String> {
        let svg = self.svg().map_err(|error| format!("{}: can't be drawn: {error}", file.display()))?;
        write_whole(file, svg.as_bytes()).map_err(|error| error.to_string())
    }

    /// The drawing.
    ///
    /// # Errors
    /// In words.
    pub(super) fn svg(&self) -> Result<String, String> {
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let wide = width(columns);
        let subtitles: Vec<String> =
            self.subtitles.iter().flat_map(|words| wrapped(words, (wide * columns as f64 / letters(16.0, 1)) as usize)).collect();
        let legend = self.legend(wide * columns as f64);
        let lines = subtitles.len() + legend.last().map_or(0, |entry| entry.2 + 1);
        let rows: Vec<f64> = self.panels.chunks(columns).map(|row| row.iter().map(|panel| panel.height).fold(0.0, f64::max)).collect();
        let head = TITLE + LINE * lines as f64 + 8.0;
        let size = (wide * columns as f64, head + rows.iter().sum::<f64>());
        let svg = pen::svg(size, |pen| {
            let middle = 0.5 * size.0;
            pen.text(&self.title, (middle, 10.0), fitting(&self.title, 24.0, size.0), TOP, DARK)?;
            for (line, words) in subtitles.iter().enumerate() {
                pen.text(words, (middle, TITLE + LINE * line as f64), 16.0, TOP, pen::GREY)?;
            }
            for (series, x, line) in &legend {
                let y = TITLE + LINE * ((subtitles.len() + line) as f64 + 0.5);
                pen.line(&[(*x, y), (x + 34.0, y)], series.ink)?;
                pen.mark((x + 17.0, y), series.ink, false)?;
                pen.text(&series.label, (x + 42.0, y), 16.0, START, DARK)?;
            }
            for (index, panel) in self.panels.iter().enumerate() {
                let (row, column) = (index / columns, index % columns);
                let corner = (wide * column as f64, head + rows[..row].iter().sum::<f64>());
                let scale =
                    |axis: fn(&Panel) -> &Axis, value: fn((f64, f64)) -> f64, along: bool| self.scale(axis(panel), axis, value, along);
                let scales = (scale(|panel| &panel.x, |point| point.0, true), scale(|panel| &panel.y, |point| point.1, false));
                panel::draw(pen, panel, &Frame::new(corner, (wide, panel.height), scales))?;
            }
            Ok(())
        });
        svg.map_err(|error| error.to_string())
    }

    /// The range of all axes with this one's label; `along`: of those along x.
    fn scale(&self, own: &Axis, axis: fn(&Panel) -> &Axis, value: fn((f64, f64)) -> f64, along: bool) -> Scale {
        let same = || self.panels.iter().filter(|panel| axis(panel).label == own.label);
        let points = same().flat_map(|panel| panel.series.iter().flat_map(Series::points)).map(value);
        let levels = same().flat_map(|panel| panel.levels.iter().copied()).filter(|_| !along);
        let zero = own.zero.then_some(0.0);
        let values = points.chain(levels).chain(zero);
        match own.range {
            Some((low, high)) => Scale { low, high, log: own.log },
            None if own.log => Scale::decades(values),
            None if along => Scale::tight(values),
            None => Scale::airy(values).spanning(own.span),
        }
    }

    /// Every label once, in lines that fit the sheet.
    fn legend(&self, width: f64) -> Vec<Entry<'_>> {
        let mut all: Vec<Entry> = Vec::new();
        let (mut x, mut line) = (MARGIN, 0);
        for series in self.panels.iter().flat_map(|panel| &panel.series) {
            if series.label.is_empty() || all.iter().any(|known| known.0.label == series.label) {
                continue;
            }
            let wide = 66.0 + letters(16.0, series.label.chars().count());
            if x + wide > width && x > MARGIN {
                (x, line) = (MARGIN, line + 1);
            }
            all.push((series, x, line));
            x += wide;
        }
        all
    }
}

/// Words in lines of at most so many letters, where words are not longer.
pub(super) fn wrapped(words: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= most => *line += &format!(" {word}"),
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests;
