//! Lines, marks and words at places in pixels.

use super::{Ink, Mark};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::error::Error;

pub(super) const GREY: RGBColor = RGBColor(120, 120, 120);
/// Where a text's place is.
pub(super) const TOP: Pos = Pos { h_pos: HPos::Center, v_pos: VPos::Top };
pub(super) const START: Pos = Pos { h_pos: HPos::Left, v_pos: VPos::Center };
pub(super) const MIDDLE: Pos = Pos { h_pos: HPos::Center, v_pos: VPos::Center };
pub(super) const END: Pos = Pos { h_pos: HPos::Right, v_pos: VPos::Center };

const FONT: &str = "sans-serif";

pub(super) type Drawn = Result<(), Box<dyn Error>>;
pub(super) type Place = (f64, f64);

/// The drawing library rounds coordinates to whole units: a sheet has so many of them per pixel.
const FINE: f64 = 8.0;

fn units(pixels: f64) -> i32 {
    (FINE * pixels).round() as i32
}

fn at(place: Place) -> (i32, i32) {
    (units(place.0), units(place.1))
}

/// About the width of a text of letters of some height.
pub(super) fn letters(size: f64, count: usize) -> f64 {
    0.56 * size * count as f64
}

/// A height of letters, `size` at most, in which words fit a width.
pub(super) fn fitting(words: &str, size: f64, width: f64) -> f64 {
    size.min(width / letters(1.0, words.chars().count().max(1)))
}

pub(super) struct Pen<'a>(DrawingArea<SVGBackend<'a>, Shift>);

/// Draws a white sheet of a size in pixels.
pub(super) fn svg(size: Place, draw: impl FnOnce(&Pen) -> Drawn) -> Result<String, Box<dyn Error>> {
    let mut svg = String::new();
    let fine = (units(size.0) as u32, units(size.1) as u32);
    let pen = Pen(SVGBackend::with_string(&mut svg, fine).into_drawing_area());
    pen.0.fill(&WHITE)?;
    draw(&pen)?;
    pen.0.present()?;
    drop(pen);
    // Shown in its size in pixels.
    let drawn = |width: f64, height: f64| format!("width=\"{width:.0}\" height=\"{height:.0}\"");
    Ok(svg.replacen(&drawn(f64::from(fine.0), f64::from(fine.1)), &drawn(size.0, size.1), 1))
}

/// First, lowest, highest and last of some places, in their order.
fn ends(places: &[Place]) -> Vec<Place> {
    if places.len() <= 4 {
        return places.to_vec();
    }
    let by = |a: &usize, b: &usize| places[*a].1.total_cmp(&places[*b].1);
    let (low, high) = ((0..places.len()).min_by(by).unwrap_or(0), (0..places.len()).max_by(by).unwrap_or(0));
    let mut kept = vec![0, low, high, places.len() - 1];
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|index| places[index]).collect()
}

impl Pen<'_> {
    /// A line through places; of those in one half of a pixel's column the first, lowest, highest and last are kept: more can't be seen.
    pub(super) fn line(&self, places: &[Place], ink: Ink) -> Drawn {
        const DASH: (f64, f64) = (8.0, 6.0);
        if ink.width == 0.0 {
            return Ok(());
        }
        let kept: Vec<Place> = places.chunk_by(|a, b| (2.0 * a.0).floor() == (2.0 * b.0).floor()).flat_map(ends).collect();
        let style = ink.color.mix(ink.alpha).stroke_width(units(ink.width) as u32);
        let points = kept.into_iter().map(at);
        match ink.dashed {
            true => self.0.draw(&DashedPathElement::new(points, units(DASH.0), units(DASH.1), style))?,
            false => self.0.draw(&PathElement::new(points.collect::<Vec<_>>(), style))?,
        }
        Ok(())
    }

    /// A filled rectangle between two corners.
    pub(super) fn area(&self, from: Place, to: Place, color: RGBColor) -> Drawn {
        Ok(self.0.draw(&Rectangle::new([at(from), at(to)], color.filled()))?)
    }

    /// A mark of the ink's shape and radius.
    pub(super) fn mark(&self, centre: Place, ink: Ink, hollow: bool) -> Drawn {
        const TURN: f64 = std::f64::consts::TAU;
        if ink.radius == 0.0 {
            return Ok(());
        }
        let (count, turn, size) = [(24, 0.0, 1.0), (4, 0.125, 1.25), (3, 0.0, 1.35), (4, 0.0, 1.3), (3, 0.5, 1.35)][ink.mark % 5];
        let corner = |k: usize| {
            let (sin, cos) = (TURN * (k as f64 / f64::from(count) + turn)).sin_cos();
            (centre.0 + size * ink.radius * sin, centre.1 - size * ink.radius * cos)
        };
        let corners: Vec<Place> = (0..=count as usize).map(corner).collect();
        let filling = if hollow { WHITE } else { ink.color };
        self.0.draw(&Polygon::new(corners.iter().copied().map(at).collect::<Vec<_>>(), filling.filled()))?;
        if hollow { self.line(&corners, Ink { width: 1.5, ..Ink::line(ink.color) }) } else { Ok(()) }
    }

    /// A mark with its bar from `low` to `high`; hollow with an arrow down where it is a bound.
    pub(super) fn measured(&self, mark: &Mark, centre: Place, bar: Option<(f64, f64)>, ink: Ink) -> Drawn {
        let own = Ink { width: 1.5, ..Ink::line(ink.color) };
        let reach = ink.radius + 2.0;
        if let Some((low, high)) = bar.filter(|(low, high)| high > low) {
            self.line(&[(low, centre.1), (high, centre.1)], own)?;
            for x in [low, high] {
                self.line(&[(x, centre.1 - reach), (x, centre.1 + reach)], own)?;
            }
        }
        if mark.bound {
            let tip = centre.1 + ink.radius + 13.0;
            self.line(&[centre, (centre.0, tip)], own)?;
            self.line(&[(centre.0 - 3.5, tip - 4.0), (centre.0, tip), (centre.0 + 3.5, tip - 4.0)], own)?;
        }
        self.mark(centre, ink, mark.bound)
    }

    /// Words of letters of a height in pixels.
    pub(super) fn text(&self, words: &str, place: Place, size: f64, anchor: Pos, color: RGBColor) -> Drawn {
        let style = (FONT, units(size)).into_text_style(&self.0).pos(anchor).color(&color);
        Ok(self.0.draw(&Text::new(words.to_string(), at(place), style))?)
    }

    /// Words that run upward.
    pub(super) fn text_upward(&self, words: &str, place: Place, size: f64, color: RGBColor) -> Drawn {
        let font = (FONT, units(size)).into_font().transform(FontTransform::Rotate270);
        let style = font.into_text_style(&self.0).pos(TOP).color(&color);
        Ok(self.0.draw(&Text::new(words.to_string(), at(place), style))?)
    }
}
