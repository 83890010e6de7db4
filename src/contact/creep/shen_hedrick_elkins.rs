//! Shen, Hedrick and Elkins: Kalker's linear forces brought under Coulomb's bound.
//!
//! With the linear resultant `F_lin = sqrt(Fx^2 + Fy^2)` (spin included) and `r = F_lin / (mu N)`:
//! `F / (mu N) = r - r^2/3 + r^3/27` for r < 3, else 1. The factor `F / F_lin` multiplies Fx, Fy and Mz, so the
//! resultant never exceeds mu N. Close to the exact theory for small spin; for pure spin and flange contact it is
//! an approximation (the moment has no bound of its own in theory, and pure spin's force is overestimated).

use super::kalker::LinearTheory;
use super::slopes::CreepSlopes;
use super::{Build, CreepLaw, RollingContact};
use crate::contact::Material;
use crate::contact::creepage::CreepForce;
use crate::settings::{Entry, Section, SettingsError};
use nalgebra::{RowVector3, Vector3};
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "shen_hedrick_elkins",
    summary: "Kalker's linear theory with a cubic saturation, spin included; for small spin",
    reference: "Shen, Hedrick, Elkins, 8th IAVSD Symposium (1983), 591-605",
    parse,
};

/// The saturated linear law.
#[derive(Debug, Clone)]
pub struct ShenHedrickElkins {
    linear: LinearTheory,
}

impl ShenHedrickElkins {
    pub fn new(material: Material) -> Self {
        ShenHedrickElkins { linear: LinearTheory::new(material) }
    }
}

/// `F / F_lin` as a function of `r = F_lin / bound`.
#[inline]
fn saturation(linear: f64, bound: f64) -> f64 {
    if bound <= 0.0 {
        return 0.0;
    }
    let r = linear / bound;
    if r < 3.0 { 1.0 - r / 3.0 + r * r / 27.0 } else { 1.0 / r }
}

impl CreepLaw for ShenHedrickElkins {
    #[inline]
    fn force(&self, contact: &RollingContact) -> CreepForce {
        let linear = self.linear.force(contact.patch, contact.creepage);
        let resultant = (linear.longitudinal * linear.longitudinal + linear.lateral * linear.lateral).sqrt();
        let factor = saturation(resultant, contact.bound());
        CreepForce {
            longitudinal: factor * linear.longitudinal,
            lateral: factor * linear.lateral,
            spin_moment: factor * linear.spin_moment,
        }
    }

    /// With the factor f(r): `d(f F) = f dF + F f' dr`, `dr = (Fx dFx + Fy dFy) / (F_lin mu N) - r dN/N`.
    fn slopes(&self, contact: &RollingContact, _: &CreepForce) -> CreepSlopes {
        let bound = contact.bound();
        if !(bound > 0.0) {
            return CreepSlopes::default();
        }
        let force = self.linear.force(contact.patch, contact.creepage);
        let mut slopes = self.linear.slopes(contact.patch, contact.creepage, contact.normal_force);
        let resultant = force.longitudinal.hypot(force.lateral);
        if !(resultant > 0.0) {
            return slopes;
        }
        let (r, per_resultant) = (resultant / bound, 1.0 / (resultant * bound));
        let by_r = if r < 3.0 { -1.0 / 3.0 + 2.0 * r / 27.0 } else { -1.0 / (r * r) };
        let along = RowVector3::new(force.longitudinal * per_resultant, force.lateral * per_resultant, 0.0);
        let force = Vector3::new(force.longitudinal, force.lateral, force.spin_moment) * by_r;
        let factor = saturation(resultant, bound);
        let r_by_creepage = along * slopes.by_creepage;
        let r_by_normal_force = (along * slopes.by_normal_force)[0] - r / contact.normal_force;
        slopes.by_creepage = slopes.by_creepage * factor + force * r_by_creepage;
        slopes.by_normal_force = slopes.by_normal_force * factor + force * r_by_normal_force;
        slopes
    }
}

fn parse(_: &Section) -> Result<Build, SettingsError> {
    Ok(Arc::new(|material| Box::new(ShenHedrickElkins::new(material))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::creepage::Creepage;
    use crate::contact::{Material, Patch};
    use proptest::prelude::*;

    fn law() -> ShenHedrickElkins {
        ShenHedrickElkins { linear: LinearTheory::new(Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 }) }
    }
    const PATCH: Patch = Patch { a: 6e-3, b: 4.5e-3 };

    fn loaded(normal_force: f64, friction: f64, creepage: Creepage) -> RollingContact {
        RollingContact { patch: PATCH, normal_force, friction, creepage, speed: 20.0 }
    }

    #[test]
    fn analytic_saturation_is_smooth_at_full_slip() {
        // r - r^2/3 + r^3/27 has value 1 and slopes 0, 0 at r = 3.
        let force = |r: f64| r * saturation(r, 1.0);
        assert!((force(3.0) - 1.0).abs() < 1e-15);
        assert!((force(3.0 - 1e-4) - 1.0).abs() < 1e-12, "third-order contact with the bound");
        assert_eq!(saturation(1.0, 0.0), 0.0);
        assert_eq!(saturation(0.0, 0.0), 0.0);
    }

    #[test]
    fn analytic_slope_at_zero_is_kalkers() {
        let small = Creepage { longitudinal: 1e-9, lateral: -2e-9, spin: 1e-8 };
        let (linear, found) = (law().linear.force(PATCH, small), law().force(&loaded(6e4, 0.5, small)));
        assert!((found.longitudinal / linear.longitudinal - 1.0).abs() < 1e-6);
        assert!((found.spin_moment / linear.spin_moment - 1.0).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn prop_bounded_and_mirror_symmetric(x in -0.02..0.02f64, y in -0.02..0.02f64, spin in -3.0..3.0f64, mu in 0.0..0.8f64) {
            let at = |x, y, spin| law().force(&loaded(5.5e4, mu, Creepage { longitudinal: x, lateral: y, spin }));
            let f = at(x, y, spin);
            prop_assert!(f.longitudinal.hypot(f.lateral) <= mu * 5.5e4 * (1.0 + 1e-12));
            // Longitudinal creepage alone mirrored: only Fx changes sign. Lateral and spin mirrored: Fy and Mz do.
            let g = at(-x, y, spin);
            prop_assert!(g.longitudinal == -f.longitudinal && g.lateral == f.lateral && g.spin_moment == f.spin_moment);
            let h = at(x, -y, -spin);
            prop_assert!(h.longitudinal == f.longitudinal && h.lateral == -f.lateral && h.spin_moment == -f.spin_moment);
        }
    }
}
