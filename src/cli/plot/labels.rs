//! Words beside marks, each at the first place that is clear of all marks and of the words before it.

use super::frame::Frame;
use super::pen::{END, MIDDLE, Place, START, letters};
use plotters::style::text_anchor::{HPos, Pos};

/// Height of letters, pixels.
pub(super) const SIZE: f64 = 15.0;

/// A rectangle on the sheet, pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Area {
    pub(super) fn overlaps(&self, other: &Area) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    fn within(&self, frame: &Frame) -> bool {
        let ((left, top), (width, height)) = (frame.corner, frame.size);
        self.left > left && self.right < left + width + 20.0 && self.top > top && self.bottom < top + height
    }
}

/// Where words stand.
pub(super) struct Label {
    point: Place,
    pub at: Place,
    pub anchor: Pos,
    pub area: Area,
}

impl Label {
    /// Beside a point, so many lines below it.
    fn new(point: Place, lines: f64, anchor: Pos, count: usize) -> Self {
        let aside = match anchor.h_pos {
            HPos::Left => 1.0,
            HPos::Center => 0.0,
            HPos::Right => -1.0,
        };
        let (at, width) = ((point.0 + 10.0 * aside, point.1 + 1.2 * SIZE * lines), letters(SIZE, count));
        let left = at.0 + 0.5 * (aside - 1.0) * width;
        Label { point, at, anchor, area: Area { left, right: left + width, top: at.1 - 0.55 * SIZE, bottom: at.1 + 0.55 * SIZE } }
    }

    /// A line to words that do not stand next to their point.
    pub(super) fn leader(&self) -> Option<[Place; 2]> {
        let near = self.point.0.clamp(self.area.left - 3.0, self.area.right + 3.0);
        ((self.at.1 - self.point.1).abs() > 1.4 * SIZE).then_some([self.point, (near, self.at.1)])
    }
}

/// Of points with words; `None` where there are none or no place for them. `leaders`: they may stand anywhere, with a line to them,
/// otherwise above alone.
pub(super) fn place(points: &[(Place, &str)], frame: &Frame, leaders: bool) -> Vec<Option<Label>> {
    const LINES: i32 = 9;
    let radius = if leaders { 7.0 } else { 2.0 };
    let around = |(x, y): Place| Area { left: x - radius, right: x + radius, top: y - radius, bottom: y + radius };
    let mut taken: Vec<Area> = points.iter().map(|(point, _)| around(*point)).collect();
    let near = [(0.0, START), (0.0, END), (-1.0, MIDDLE), (1.0, MIDDLE)];
    let farther = (1..LINES).map(f64::from).flat_map(|k| [(-k, START), (k, START), (-k, END), (k, END)]);
    let candidates: Vec<(f64, Pos)> = if leaders { near.into_iter().chain(farther).collect() } else { vec![(-0.75, MIDDLE)] };
    let label = |(point, words): &(Place, &str)| {
        let count = words.chars().count();
        let mut places = candidates.iter().map(|(lines, anchor)| Label::new(*point, *lines, *anchor, count));
        let free = |label: &Label| label.area.within(frame) && !taken.iter().any(|area| area.overlaps(&label.area));
        let label = places.find(free).filter(|_| count > 0)?;
        taken.push(label.area);
        Some(label)
    };
    points.iter().map(label).collect()
}
