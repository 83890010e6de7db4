//! Hertzian creep-force table made with the exact theory.
//!
//! The idea is Kalker's USETAB: because force over mu N depends only on a/b, nu and three dimensionless creepages, the
//! exact theory can be solved in advance. Coordinates, lattice and interpolation are our own, see
//! [`coordinates`], [`table`], [`spline`]; [`generate`] makes the table (`wheelrail table`).
//!
//! - Force and moment have continuous first derivatives in all creepages and in a/b.
//! - `|F| <= mu N` always: an interpolated force within 0.4 % of mu N or above it is bent onto mu N by a parabola.
//! - At zero creepage the slopes are the exact theory's own, extrapolated from grids twice as fine as the table's:
//!   within 1 % of Kalker's c11, c22, c23 and c33 (at a/b = 10: c22 1.4 %, most of it the published table's; c33 4.5 %,
//!   most of it the grid's).
//! - The mirror symmetries hold to the last digit.
//! - Against the exact theory on the same grid, 500 random cases (a/b 0.1 to 10, linear forces of 0.05 to 20 mu N, with
//!   spin): force off by 0.1 % of mu N on average, 0.4 % in 95 % of the cases, 2.9 % at worst (nearly pure spin, where
//!   a little lateral creepage changes much); moment by 0.07 % of mu N sqrt(a b) on average, 1.5 % at worst.
//! - The table is made for nu = 0.28. For another nu the creepages are scaled by Kalker's coefficients of that nu, so
//!   the slopes of the force (c11, c22, c23) stay right; the moment and the shape of the curves remain those of 0.28.
//!   Error of the force: 0.2 % of mu N on average, 1.3 % at worst for 0.25 to 0.3; 1.3 % and 8 % for 0 and 0.5.
//! - For a/b outside 0.1 to 10 the shape of the curves stays that of the nearest end while Kalker's coefficients, and
//!   with them the slopes of Fx and Fy, follow a/b.
//!
//! Sources: Kalker, Book of tables for the Hertzian creep-force law, 2nd Mini Conference on Contact Mechanics and Wear
//! of Rail/Wheel Systems, Budapest (1996), for the idea; numbers by [`super::exact`].

pub(crate) mod coordinates;
pub mod generate;
pub mod layout;
mod spline;
pub mod table;
#[cfg(test)]
mod tests;

use super::adapted::Falling;
use super::falling_friction::FallingFriction;
use super::kalker::KalkerTable;
use super::{Build, CreepLaw, RollingContact};
use crate::contact::Material;
use crate::contact::creepage::CreepForce;
use crate::settings::{Entry, Section, SettingsError};
use coordinates::{RATIOS, Triple, bounded, spin_weight};
use std::sync::Arc;
use table::{Table, TableError};

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "usetab",
    summary: "table of the exact theory's forces, interpolated: close to `exact` at the price of a formula",
    reference: "after Kalker, Book of tables for the Hertzian creep-force law (1996)",
    parse,
};

/// The table that comes with the program.
static EMBEDDED: &[u8] = include_bytes!("table.bin");

/// Half of the range of |F| / (mu N) around 1 over which the force is bent onto the bound.
const BEND: f64 = 0.004;

/// The table for one material.
#[derive(Debug, Clone)]
pub struct UseTab {
    shear_modulus: f64,
    kalker: KalkerTable,
    table: Arc<Table>,
}

/// What `size` is multiplied with to stay below 1: the identity below 1 - BEND, then a parabola that arrives at 1
/// level, at 1 + BEND.
#[inline]
fn bend(size: f64) -> f64 {
    if size <= 1.0 - BEND {
        1.0
    } else if size < 1.0 + BEND {
        let over = size - (1.0 - BEND);
        (size - over * over / (4.0 * BEND)) / size
    } else {
        1.0 / size
    }
}

impl UseTab {
    /// With the table that comes with the program.
    ///
    /// # Errors
    /// [`TableError`] if the program was built with a table of another version.
    pub fn new(material: Material) -> Result<Self, TableError> {
        Ok(Self::with_table(material, Arc::new(Table::read(EMBEDDED)?)))
    }

    /// With a table of one's own.
    pub fn with_table(material: Material, table: Arc<Table>) -> Self {
        UseTab { shear_modulus: material.shear_modulus(), kalker: KalkerTable::new(material.poisson_ratio), table }
    }

    /// Force in mu N and moment in mu N sqrt(a b) for `(X, Y, Z)` of [`coordinates`].
    #[inline]
    fn share(&self, a_over_b: f64, v: Triple) -> Triple {
        let [x, y, spin] = self.table.force(a_over_b, bounded(v));
        let factor = bend((x * x + y * y).sqrt());
        [x * factor, y * factor, spin]
    }
}

impl CreepLaw for UseTab {
    #[inline]
    fn force(&self, contact: &RollingContact) -> CreepForce {
        let (a, b, bound) = (contact.patch.a, contact.patch.b, contact.bound());
        if !(a > 0.0 && b > 0.0 && bound > 0.0) {
            return CreepForce::default();
        }
        let c = self.kalker.at(a / b);
        let inside = (a / b).clamp(RATIOS.0, RATIOS.1);
        let (area, length) = (a * b, (a * b).sqrt());
        let unit = self.shear_modulus * area / bound;
        let creepage = contact.creepage;
        let v = [
            unit * c.c11 * creepage.longitudinal,
            unit * c.c22 * creepage.lateral,
            unit * spin_weight(inside) * c.c23 * length * creepage.spin,
        ];
        let [x, y, spin] = self.share(inside, v);
        CreepForce { longitudinal: x * bound, lateral: y * bound, spin_moment: spin * bound * length }
    }
}

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let table = Arc::new(Table::read(EMBEDDED).map_err(|error| section.error("law", error.to_string()))?);
    let friction = FallingFriction::parse(section, FallingFriction::CONSTANT)?;
    Ok(Arc::new(move |material| {
        let law = UseTab::with_table(material, table.clone());
        if friction == FallingFriction::CONSTANT { Box::new(law) } else { Box::new(Falling { law, friction }) }
    }))
}
