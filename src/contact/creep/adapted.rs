//! Laws adapted to what is measured on real rails: smaller slopes at small creepage (Kalker factors), friction that falls with sliding.
//!
//! *Kalker factors* k_x, k_y from 0 to 1 multiply the linear coefficients: k_x c11, and k_y c22, c23 and c33. Contaminated rails have
//! 0.6 or less of the theory's slopes. The linear law `F_x = -G a b c11 xi_x`, `F_y = -G a b (c22 xi_y + sqrt(a b) c23 phi)` is then that of the
//! creepages `k_x xi_x`, `k_y xi_y`, `k_y phi`, and so is every law here whose force depends on them by G alone: the bound mu N stays. Where k_x and k_y
//! differ, a contact that slides altogether is pushed against (k_x xi_x, k_y xi_y) instead of (xi_x, xi_y): by up to
//! `atan((k_x - k_y) / (2 sqrt(k_x k_y)))` aside, 10 degrees for 0.5 and 0.7.
//!
//! *Falling friction*: see [`super::falling_friction`]; the speed of sliding is the real one, whatever the factors.

use super::falling_friction::FallingFriction;
use super::slopes::CreepSlopes;
use super::{CreepLaw, RollingContact};
use crate::contact::creepage::{CreepForce, Creepage};
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// Kalker factors, -.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KalkerFactors {
    /// k_x, and k_y of lateral creepage and spin.
    pub longitudinal: f64,
    pub lateral: f64,
}

impl KalkerFactors {
    /// Reads `kalker_factor`, `longitudinal_factor` and `lateral_factor`; `None` where the theory's slopes hold.
    pub fn parse(section: &Section) -> Result<Option<Self>, SettingsError> {
        let factor = |key: &'static str, default: f64| {
            let value = section.number_or(key, Dimension::None, default)?;
            let allowed = value > 0.0 && value <= 1.0;
            if allowed { Ok(value) } else { Err(section.error(key, format!("found {value:?}, expected a number above 0, at most 1"))) }
        };
        let both = factor("kalker_factor", 1.0)?;
        let found = KalkerFactors { longitudinal: factor("longitudinal_factor", both)?, lateral: factor("lateral_factor", both)? };
        Ok((found.longitudinal < 1.0 || found.lateral < 1.0).then_some(found))
    }
}

/// A law with other slopes.
#[derive(Debug)]
pub(super) struct Reduced {
    pub law: Box<dyn CreepLaw>,
    pub factors: KalkerFactors,
}

impl Reduced {
    fn inside(&self, contact: &RollingContact) -> RollingContact {
        let (KalkerFactors { longitudinal, lateral }, creepage) = (self.factors, contact.creepage);
        let creepage = Creepage {
            longitudinal: longitudinal * creepage.longitudinal,
            lateral: lateral * creepage.lateral,
            spin: lateral * creepage.spin,
        };
        let inside = RollingContact { creepage, ..*contact };
        // Sliding is what it was.
        let (was, is) = (contact.sliding_speed(), inside.sliding_speed());
        RollingContact { speed: if is > 0.0 { contact.speed * (was / is) } else { contact.speed }, ..inside }
    }
}

impl CreepLaw for Reduced {
    fn force(&self, contact: &RollingContact) -> CreepForce {
        self.law.force(&self.inside(contact))
    }

    fn slopes(&self, contact: &RollingContact, force: &CreepForce) -> CreepSlopes {
        let mut slopes = self.law.slopes(&self.inside(contact), force);
        for (column, factor) in [self.factors.longitudinal, self.factors.lateral, self.factors.lateral].into_iter().enumerate() {
            slopes.by_creepage.column_mut(column).scale_mut(factor);
        }
        slopes
    }

    fn is_bounded(&self) -> bool {
        self.law.is_bounded()
    }

    fn describe(&self) -> String {
        let KalkerFactors { longitudinal, lateral } = self.factors;
        format!("{}, Kalker factors {longitudinal} along and {lateral} across", self.law.describe())
    }
}

/// A law that is not told of spin, and whose moment is left out (lateral creepage makes one too, by c23).
#[derive(Debug)]
pub(super) struct WithoutSpin {
    pub law: Box<dyn CreepLaw>,
}

/// The contact as if it did not turn about its normal.
fn not_spinning(contact: &RollingContact) -> RollingContact {
    RollingContact { creepage: Creepage { spin: 0.0, ..contact.creepage }, ..*contact }
}

impl CreepLaw for WithoutSpin {
    fn force(&self, contact: &RollingContact) -> CreepForce {
        CreepForce { spin_moment: 0.0, ..self.law.force(&not_spinning(contact)) }
    }

    fn slopes(&self, contact: &RollingContact, _: &CreepForce) -> CreepSlopes {
        let inside = not_spinning(contact);
        let mut slopes = self.law.slopes(&inside, &self.law.force(&inside));
        slopes.by_creepage.column_mut(2).fill(0.0);
        slopes.by_creepage.row_mut(2).fill(0.0);
        slopes.by_normal_force.z = 0.0;
        slopes
    }

    fn is_bounded(&self) -> bool {
        self.law.is_bounded()
    }

    fn describe(&self) -> String {
        format!("{}, without spin", self.law.describe())
    }
}

/// A law of constant friction with friction that falls.
#[derive(Debug)]
pub(super) struct Falling<L> {
    pub law: L,
    pub friction: FallingFriction,
}

impl<L: CreepLaw> CreepLaw for Falling<L> {
    fn force(&self, contact: &RollingContact) -> CreepForce {
        self.law.force(&RollingContact { friction: self.friction.at(contact.friction, contact.sliding_speed()), ..*contact })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{REGISTRY, parse, slopes};
    use super::*;
    use crate::contact::{Material, Patch};
    use crate::settings::{Section, Source};

    const STEEL: Material = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };

    fn law(settings: &str) -> Box<dyn CreepLaw> {
        let source = Source { file: "law.toml".into(), text: settings.into(), overridden: vec![], folder: None };
        let table: toml_edit::Document<String> = settings.parse::<toml_edit::Document<String>>().unwrap();
        let build = parse(&Section::root(table.as_table(), &source)).unwrap_or_else(|error| panic!("{settings}: {error}"));
        build(STEEL)
    }

    fn contact(longitudinal: f64, lateral: f64, spin: f64) -> RollingContact {
        let creepage = Creepage { longitudinal, lateral, spin };
        RollingContact { patch: Patch { a: 6e-3, b: 4e-3 }, normal_force: 8e4, friction: 0.35, creepage, speed: 20.0 }
    }

    #[test]
    fn analytic_factors_multiply_the_slopes_and_leave_the_bound() {
        for entry in REGISTRY.iter().filter(|entry| entry.name != "exact") {
            let [plain, reduced] =
                ["", "\nlongitudinal_factor = 0.5\nlateral_factor = 0.7"].map(|more| law(&format!("law = \"{}\"{more}", entry.name)));
            let small = [contact(1e-9, 0.0, 0.0), contact(0.0, 1e-9, 0.0), contact(0.0, 0.0, 1e-7)];
            for (case, factor) in small.iter().zip([0.5, 0.7, 0.7]) {
                let (a, b) = (plain.force(case), reduced.force(case));
                assert!((b.longitudinal - factor * a.longitudinal).abs() <= 1e-6 * a.longitudinal.abs() + 1e-12, "{}", entry.name);
                assert!((b.lateral - factor * a.lateral).abs() <= 2e-3 * a.lateral.abs() + 1e-12, "{} {a:?} {b:?}", entry.name);
            }
            if entry.name != "kalker_linear" {
                let force = reduced.force(&contact(0.05, -0.03, 0.0));
                assert!((force.longitudinal.hypot(force.lateral) / (0.35 * 8e4) - 1.0).abs() < 0.02, "{} {force:?}", entry.name);
            }
        }
    }

    #[test]
    fn analytic_slopes_of_a_reduced_law_are_its_own() {
        for settings in ["law = \"shen_hedrick_elkins\"\nkalker_factor = 0.6", "law = \"usetab\"\nlateral_factor = 0.4"] {
            let (law, case) = (law(settings), contact(4e-4, 7e-4, 0.1));
            let force = law.force(&case);
            let [stated, found] = [law.slopes(&case, &force), slopes::differences(law.as_ref(), &case, &force)];
            let off = (stated.by_creepage - found.by_creepage).norm() / found.by_creepage.norm();
            assert!(off < 5e-3, "{settings}: {off}");
        }
    }

    #[test]
    fn analytic_friction_falls_with_the_real_speed_of_sliding() {
        for reduction in ["", "\nkalker_factor = 0.5"] {
            let law = law(&format!("law = \"usetab\"\nfriction_ratio = 0.4\nfriction_decay = 0.6{reduction}"));
            // Full sliding at 0.1 of 20 m/s.
            let force = law.force(&contact(0.1, 0.0, 0.0)).longitudinal.abs();
            let expected = 0.35 * 8e4 * (0.6 * (-0.6f64 * 2.0).exp() + 0.4);
            assert!((force / expected - 1.0).abs() < 5e-3, "{reduction} {force} {expected}");
        }
    }
}
