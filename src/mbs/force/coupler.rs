//! Coupler between two vehicles: draw gear and buffers with slack, along the line between its ends.
//!
//! `slack` [m] is the whole free travel, half of it either way from the design configuration; beyond it the draw gear
//! (tension) and the buffers (compression) each have a stiffness or a table of force over displacement, with the law of
//! [`super::stop`]. The loss of a friction draft gear, whose force at return is a fixed part of that at loading, is
//! only met on average by that law's damping, which grows with speed.

use super::curve::Outside;
use super::line::{LineElement, Span};
use super::stop::{Stop, options, side};
use super::{ForceElement, Parse, Places};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let span = Span::parse(section, places)?;
    let (rounding, damping) = options(section)?;
    let free = 0.5 * section.not_negative_or("slack", Dimension::Length, 0.0)?;
    let outside = Outside::stop(section, &["draw_force_over_displacement", "buffer_force_over_displacement"])?;
    span.reaches(section, "slack", free)?;
    if span.away < 0.0 {
        let problem = "points from \"to\" to \"from\", so that draw gear and buffers would act for each other; take the opposite one, exchange \"from\" and \"to\", or leave it out";
        return Err(section.error("axis", problem));
    }
    let law = Stop {
        extension: Some(side(section, ("draw_force_over_displacement", "draw_stiffness"), free, rounding, &outside)?),
        compression: Some(side(section, ("buffer_force_over_displacement", "buffer_stiffness"), free, rounding, &outside)?),
        damping,
    };
    Ok(Box::new(LineElement { name: places.name(section)?, span, law }))
}

pub(super) const ENTRY: Entry<Parse> =
    Entry { name: "coupler", summary: "draw gear and buffers with slack between two vehicles", reference: "", parse };
