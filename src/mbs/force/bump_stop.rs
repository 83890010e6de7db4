//! Bump stop: no force within a clearance, then a stiffness or a table of force over displacement; one- or two-sided.
//!
//! The law is that of [`super::stop`], the same on both sides. A table may hold the clearance itself (as that of the
//! Manchester vehicle's lateral stop does: no force up to 25 mm), or count from where the stop touches.

use super::curve::Outside;
use super::line::{LineElement, Span};
use super::stop::{Stop, options, side};
use super::{ForceElement, Parse, Places};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let span = Span::parse(section, places)?;
    let sides = section.word_or("sides", &["both", "extension", "compression"], "both")?;
    let (rounding, damping) = options(section)?;
    let clearance = section.not_negative_or("clearance", Dimension::Length, 0.0)?;
    let outside = Outside::stop(section, &["force_over_displacement"])?;
    let side = side(section, ("force_over_displacement", "stiffness"), clearance, rounding, &outside)?;
    if sides != "extension" {
        span.reaches(section, "clearance", clearance)?;
    }
    let on = |other: &str| (sides != other).then(|| side.clone());
    let law = Stop { extension: on("compression"), compression: on("extension"), damping };
    Ok(Box::new(LineElement { name: places.name(section)?, span, law }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "bump_stop",
    summary: "stop beyond a clearance, one- or two-sided, between two places or along an axis of \"from\"",
    reference: "damping: K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445",
    parse,
};
