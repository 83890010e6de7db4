//! One panel: grid, axes, levels, series, labels.

use super::frame::{BOTTOM, Frame, LEFT, STRIP};
use super::labels;
use super::pen::{Drawn, END, GREY, MIDDLE, Pen, Place, START, TOP, fitting, letters};
use super::{Axis, DARK, Ink, Panel, Series, Tile};
use plotters::style::{RGBColor, WHITE};

pub(super) fn draw(pen: &Pen, panel: &Panel, frame: &Frame) -> Drawn {
    let line = frame.corner.1 - 0.5 * STRIP;
    let size = fitting(&panel.title, 18.0, frame.size.0);
    pen.text(&panel.title, (frame.corner.0, line), size, START, DARK)?;
    let beside = frame.size.0 - letters(size, panel.title.chars().count() + 2);
    pen.text(&panel.aside, (frame.end().0, line), fitting(&panel.aside, 14.0, beside), END, GREY)?;
    axes(pen, [&panel.x, &panel.y], frame)?;
    panel.tiles.iter().try_for_each(|tile| draw_tile(pen, tile, frame))?;
    for level in &panel.levels {
        let y = frame.at((frame.x.low, *level)).1;
        pen.line(&[(frame.corner.0, y), (frame.end().0, y)], Ink { width: 1.0, ..Ink::dashed(DARK) })?;
    }
    panel.series.iter().try_for_each(|series| draw_series(pen, series, frame))?;
    let marks = || panel.series.iter().flat_map(|series| series.marks.iter().map(move |mark| (series.ink, mark)));
    let named: Vec<(Place, &str)> = marks().map(|(_, mark)| (frame.at((mark.x, mark.y)), mark.label.as_str())).collect();
    for ((ink, mark), label) in marks().zip(labels::place(&named, frame, panel.leaders)) {
        let Some(label) = label else { continue };
        if let Some(leader) = label.leader() {
            pen.line(&leader, Ink { width: 1.0, alpha: 0.7, ..Ink::line(GREY) })?;
        }
        pen.text(&mark.label, label.at, labels::SIZE, label.anchor, if panel.leaders { DARK } else { ink.color })?;
    }
    Ok(())
}

/// A tile, its words on it in what can be read there.
fn draw_tile(pen: &Pen, tile: &Tile, frame: &Frame) -> Drawn {
    const SIZE: f64 = 14.0;
    let (from, to) = (frame.at(tile.from), frame.at(tile.to));
    pen.area(from, to, tile.color)?;
    let RGBColor(red, green, blue) = tile.color;
    let bright = 0.3 * f64::from(red) + 0.6 * f64::from(green) + 0.1 * f64::from(blue) > 130.0;
    let room = letters(SIZE, tile.label.chars().count()) + 4.0 < (to.0 - from.0).abs() && SIZE + 4.0 < (to.1 - from.1).abs();
    match room {
        true => pen.text(&tile.label, (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1)), SIZE, MIDDLE, if bright { DARK } else { WHITE }),
        false => Ok(()),
    }
}

/// Grid, ticks, numbers, captions.
fn axes(pen: &Pen, [x, y]: [&Axis; 2], frame: &Frame) -> Drawn {
    const NUMBER: f64 = 16.0;
    const TICK: f64 = 5.0;
    let grid = Ink { width: 1.0, alpha: 0.25, ..Ink::line(GREY) };
    let axis = Ink { width: 1.0, ..Ink::line(GREY) };
    let ((left, top), (right, bottom)) = (frame.corner, frame.end());
    let mut free = f64::NEG_INFINITY;
    let mut ticks = frame.x.ticks((frame.size.0 / 55.0) as usize);
    ticks.sort_by(|a, b| frame.x.part(a.0).total_cmp(&frame.x.part(b.0)));
    for (tick, words) in ticks {
        let place = frame.at((tick, frame.y.low)).0;
        pen.line(&[(place, top), (place, bottom)], grid)?;
        pen.line(&[(place, bottom), (place, bottom + TICK)], axis)?;
        // Long numbers do not touch each other.
        let half = 0.5 * letters(NUMBER, words.len()) + 4.0;
        if place - half > free {
            pen.text(&words, (place, bottom + TICK + 3.0), NUMBER, TOP, DARK)?;
            free = place + half;
        }
    }
    for (tick, words) in frame.y.ticks((frame.size.1 / 30.0) as usize) {
        let place = frame.at((frame.x.low, tick)).1;
        pen.line(&[(left, place), (right, place)], grid)?;
        pen.line(&[(left - TICK, place), (left, place)], axis)?;
        pen.text(&words, (left - TICK - 4.0, place), NUMBER, END, DARK)?;
    }
    pen.line(&[(left, top), (left, bottom), (right, bottom)], axis)?;
    pen.text(&x.label, (0.5 * (left + right), bottom + BOTTOM - 18.0), NUMBER, MIDDLE, DARK)?;
    pen.text_upward(&y.label, (left - LEFT + 6.0, 0.5 * (top + bottom)), NUMBER, DARK)
}

fn draw_series(pen: &Pen, series: &Series, frame: &Frame) -> Drawn {
    let ink = series.ink;
    for branch in &series.branches {
        let places: Vec<Place> = branch.iter().filter(|point| frame.shows(**point)).map(|point| frame.at(*point)).collect();
        pen.line(&places, ink)?;
    }
    // Where branches meet, a curve jumps.
    if series.marks.is_empty() {
        for end in series.branches.windows(2).flat_map(|pair| [pair[0].last(), pair[1].first()]).flatten() {
            pen.mark(frame.at(*end), Ink { radius: 3.0, ..ink }, false)?;
        }
    }
    for mark in series.marks.iter().filter(|mark| frame.shows((mark.x, mark.y))) {
        let across = |x: f64| frame.at((x, mark.y)).0;
        pen.measured(mark, frame.at((mark.x, mark.y)), mark.bar.map(|(low, high)| (across(low), across(high))), ink)?;
    }
    Ok(())
}
