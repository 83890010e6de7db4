//! Wheel and rail in section, with lines between the points that touch at each lateral shift.
//!
//! Seen along the track: left is left. The wheels stand where they touch in the centred position, lifted so that the
//! connecting lines are seen. Both axes have the same scale.

use super::axis::Axis;
use super::{Area, BLACK_GREY, BLUE, DrawingError, FINE, GREY, ORANGE, fine_mesh, px, write_sheet};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// Points that touch at a lateral shift [mm].
pub(in crate::cli) struct Touching {
    pub shift: f64,
    pub wheel: (f64, f64),
    pub rail: (f64, f64),
}

/// One side; all points are (to the right, up) in mm in the track's section.
pub(in crate::cli) struct Section {
    pub title: &'static str,
    pub wheel: Vec<(f64, f64)>,
    pub rail: Vec<(f64, f64)>,
    pub pairs: Vec<Touching>,
    /// Where the picture begins at the left and at the bottom, mm.
    pub corner: (f64, f64),
}

/// Pixels.
const PANEL: (u32, u32) = (600, 370);
const HEAD: u32 = 66;
const FOOT: u32 = 30;
const LEFT: u32 = 52;
const MARGIN: u32 = 12;
const BOTTOM: u32 = 46;
const TOP: u32 = 30;
const RIGHT: u32 = 16;
/// Pixels per mm.
const SCALE: f64 = 4.4;
const FONT: &str = "sans-serif";

/// Width and height [mm] that a section shows.
pub(in crate::cli) fn size() -> (f64, f64) {
    (f64::from(PANEL.0 - MARGIN - LEFT - RIGHT) / SCALE, f64::from(PANEL.1 - TOP - BOTTOM) / SCALE)
}

/// Draws both sides.
pub(in crate::cli) fn draw(file: &Path, title: &str, subtitle: &str, sections: &[Section; 2]) -> Result<(), String> {
    let size = (2 * PANEL.0, HEAD + PANEL.1 + FOOT);
    write_sheet(file, size, |root| {
        let (head, below) = root.split_vertically(px(HEAD));
        let (middle, foot) = below.split_vertically(px(PANEL.1));
        let centred = |size: u32| (FONT, px(size)).into_text_style(&head).pos(Pos::new(HPos::Center, VPos::Top));
        head.draw(&Text::new(title, (px(size.0) / 2, px(12)), centred(20)))?;
        head.draw(&Text::new(subtitle, (px(size.0) / 2, px(40)), centred(14).color(&GREY)))?;
        for (area, section) in middle.split_evenly((1, 2)).iter().zip(sections) {
            draw_section(area, section)?;
        }
        Ok(legend(&foot)?)
    })
}

/// Blue for shifts to the left, orange to the right, grey at the centre.
fn color(y: f64) -> RGBColor {
    if y > 1e-6 {
        BLUE
    } else if y < -1e-6 {
        ORANGE
    } else {
        BLACK_GREY
    }
}

fn draw_section<'a>(area: &Area<'a>, section: &Section) -> Result<(), DrawingError<'a>> {
    let (width, height) = size();
    let (x, z) = section.corner;
    let caption = (FONT, px(16)).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Top));
    area.draw(&Text::new(section.title, (px(MARGIN + LEFT + (PANEL.0 - MARGIN - LEFT - RIGHT) / 2), px(6)), caption))?;
    let mut chart = ChartBuilder::on(area)
        .margin_top(px(TOP))
        .margin_left(px(MARGIN))
        .margin_right(px(RIGHT))
        .x_label_area_size(px(BOTTOM))
        .y_label_area_size(px(LEFT))
        .build_cartesian_2d(Axis { range: (x, x + width), most: 9 }, Axis { range: (z, z + height), most: 8 })?;
    fine_mesh(&mut chart, 13)
        .x_desc("across the track, left positive [mm]")
        .y_desc("height [mm]")
        .x_label_formatter(&|value| super::short(-value))
        .bold_line_style(GREY.mix(0.2).stroke_width(FINE))
        .draw()?;
    let inside = |point: &(f64, f64)| point.0 >= x && point.0 <= x + width && point.1 >= z && point.1 <= z + height;
    for Touching { shift: y, wheel, rail } in section.pairs.iter().filter(|pair| inside(&pair.wheel) && inside(&pair.rail)) {
        let style = color(*y).mix(0.8).stroke_width(FINE + FINE / 4);
        chart.draw_series(LineSeries::new([*wheel, *rail], style))?;
        chart.draw_series([*wheel, *rail].map(|point| Circle::new(point, px(2), color(*y).filled())))?;
    }
    for profile in [&section.wheel, &section.rail] {
        let shown: Vec<(f64, f64)> = profile.iter().filter(|point| inside(point)).copied().collect();
        chart.draw_series(LineSeries::new(shown, BLACK_GREY.stroke_width(FINE * 2)))?;
    }
    // Numbers beyond the wheel's points, as far as they do not touch each other.
    let label = (FONT, px(11)).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Center));
    let mut taken: Vec<(f64, f64)> = Vec::new();
    let mut labelled: Vec<&Touching> = section.pairs.iter().filter(|pair| inside(&pair.wheel)).collect();
    labelled.sort_by(|a, b| a.shift.abs().total_cmp(&b.shift.abs()));
    for Touching { shift: y, wheel, rail } in labelled {
        let (across, up) = (wheel.0 - rail.0, wheel.1 - rail.1);
        let length = across.hypot(up).max(1e-6);
        let beyond = 9.0 / SCALE;
        let place = (wheel.0 + beyond * across / length, wheel.1 + beyond * up / length);
        let free = |other: &(f64, f64)| (other.0 - place.0).abs() > 12.0 / SCALE || (other.1 - place.1).abs() > 11.0 / SCALE;
        if taken.iter().all(free) {
            taken.push(place);
            let ink = color(*y);
            let style = label.clone().color(&ink);
            chart.draw_series([EmptyElement::at(place) + Text::new(super::short(*y), (0, 0), style)])?;
        }
    }
    Ok(())
}

fn legend<'a>(area: &Area<'a>) -> Result<(), DrawingError<'a>> {
    let name = (FONT, px(13)).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
    let words = ["numbers: lateral shift in mm, to the left", "centred", "to the right"];
    let mut x = px(MARGIN + LEFT);
    for (words, color) in words.into_iter().zip([BLUE, BLACK_GREY, ORANGE]) {
        area.draw(&PathElement::new([(x, px(12)), (x + px(26), px(12))], color.stroke_width(FINE * 2)))?;
        area.draw(&Text::new(words, (x + px(32), px(12)), name.clone()))?;
        x += px(60 + 7 * words.len() as u32);
    }
    Ok(())
}
