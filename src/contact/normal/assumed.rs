//! Stated contact stiffness: the paper's alternative to Hertz's.
//!
//! `N = K_h delta^1.5` with K_h a number of the scene. Creep laws need a patch, which a stiffness does not give: it is
//! Hertz's ellipse under the same force, from the curvatures (by the same rules as in law `hertz`) or, with
//! `axis_ratio = a/b`, the ellipse of that shape which a wheel with the curvature A of the contact would have.
//! The stiffness and the patch then belong to different bodies; that is the price of stating one of them.

use super::curvature::{self, Across, Conformal, Rule};
use super::hertz::Hertz;
use super::hertz_integrals;
use super::{Build, ConformalContact, ContactShape, ElasticContact, NormalLaw};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "assumed",
    summary: "stated contact stiffness K_h, patch by Hertz's theory under the same force",
    reference: "paper, Eq. 28 with K_h as a constant",
    parse,
};

/// See the module's text.
#[derive(Debug)]
pub struct Assumed {
    /// K_h, N/m^1.5.
    stiffness: f64,
    patch: Hertz,
}

impl Assumed {
    #[inline]
    fn loaded(&self, shape: &ContactShape, force: f64) -> Result<ElasticContact, ConformalContact> {
        let (_, contact) = self.patch.contact_under(shape, force)?;
        let root = (force / self.stiffness).cbrt();
        Ok(ElasticContact { stiffness: self.stiffness, force, slope: 1.5 * self.stiffness * root, patch: contact.patch })
    }
}

impl NormalLaw for Assumed {
    fn contact(&self, shape: &ContactShape, penetration: f64) -> Result<ElasticContact, ConformalContact> {
        self.loaded(shape, self.stiffness * penetration * penetration.sqrt())
    }

    fn contact_under(&self, shape: &ContactShape, force: f64) -> Result<(f64, ElasticContact), ConformalContact> {
        let root = (force / self.stiffness).cbrt();
        Ok((root * root, self.loaded(shape, force)?))
    }

    fn describe(&self) -> String {
        format!(", {:?} N/m^1.5{}", self.stiffness, self.patch.describe())
    }
}

/// Ellipses up to the slenderness that the tables of creep laws were made for, and some more.
const SLENDEREST: f64 = 20.0;

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let stiffness = section.positive("stiffness", Dimension::ContactStiffness)?;
    let rule = match section.optional("axis_ratio", Dimension::None)? {
        None => curvature::parse(section)?,
        Some(ratio) if (1.0 / SLENDEREST..=SLENDEREST).contains(&ratio) => {
            Rule { across: Across::Stated(hertz_integrals::curvature_ratio_of_axes(ratio)), conformal: Conformal::Error }
        }
        Some(ratio) => return Err(section.error("axis_ratio", format!("found {ratio:?}, expected a/b from 0.05 to 20"))),
    };
    Ok(Arc::new(move |material| Box::new(Assumed { stiffness, patch: Hertz::with(material, rule) })))
}
