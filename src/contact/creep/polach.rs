//! Polach's law for large creepage and falling friction.
//!
//! ```text
//! mu  = mu0 ((1 - A) exp(-B w) + A),  w = V sqrt(xi_x^2 + xi_y^2)
//! y_C = xi_y + phi a  where that is larger than xi_y, else xi_y;      s_C = sqrt(xi_x^2 + y_C^2)
//! eps = G pi a b c_jj s_C / (4 mu N),    c_jj = sqrt((c11 xi_x)^2 + (c22 xi_y)^2) / sqrt(xi_x^2 + xi_y^2)
//! f(k_A, k_S, eps) = k_A eps / (1 + (k_A eps)^2) + atan(k_S eps),    F = (2 mu N / pi) f(1, 1, eps)
//! Fx  = -r F xi_x / s_C,    Fy = -r (F xi_y + S phi) / s_C,    r = f(k_A, k_S, e) / f(1, 1, e)
//! e   = G pi a b sqrt((c11 xi_x)^2 + (c22 y_C)^2) / (4 mu N),  which is eps without spin
//! S   = (3/8) a mu N k e_M / (1 + e_M^2)^2,   e_M = 8 G b sqrt(a b) c23 |y_C| / (3 k mu N),   k = 1 + 6.3 (1 - exp(-a/b))
//! ```
//!
//! Sources: O. Polach, Wear 258 (2005), 992-1000 (k_A, k_S: how much less the areas of adhesion and of slip yield than those of
//! clean smooth surfaces; friction); Vehicle System Dynamics Supplement 33 (1999), 728-739 (spin). S is his K_M simplified:
//! `|e|(d^3/3 - d^2/2 + 1/6) - (1 - d^2)^1.5/3` with d = (e^2 - 1)/(e^2 + 1) equals `-(2/3) e/(1 + e^2)^2`.
//!
//! Without spin that is Polach's formula. With spin r is ours: his papers don't speak of spin on surfaces that yield less. Beside a reduced F a whole S
//! turned lateral forces round, so that wheels in curves drove the train (-2.4 kW of a wheel at R = 300 m and 20 m/s on "wet"). With r the force has the
//! direction that it has on clean smooth surfaces; e, other than eps, has a limit where creepage vanishes beside spin.
//!
//! What the law does not do: the moment about n is zero (Polach neglects it), so that its power can be negative where spin counts for more than creepage. Slopes at zero are
//! Kalker's times (k_A + k_S)/2 for each creepage alone; for several at once the law is not linear even near zero
//! (c11 and c22 are mixed, and the spin force shrinks by |y_C|/s_C), and it has a corner at phi a = -2 xi_y and at
//! phi = 0. With spin the resultant could exceed mu N; it is then shortened.
//!
//! Settings: `surface` = "ideal" (default: k_A = k_S = 1, constant friction), "dry" or "wet" (Polach 2005; he has mu0 = 0.55 dry,
//! 0.30 wet: set `contact.friction` to it) and single numbers that replace the surface's: `adhesion_reduction` (k_A),
//! `slip_reduction` (k_S, not above k_A), `friction_ratio` (A), `friction_decay` (B, s/m).

use super::falling_friction::FallingFriction;
use super::kalker::LinearTheory;
use super::{Build, CreepLaw, RollingContact};
use crate::contact::creepage::CreepForce;
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::f64::consts::PI;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "polach",
    summary: "falling friction, dry and wet rails, large creepage, traction; surface = \"ideal\" | \"dry\" | \"wet\"; no spin moment",
    reference: "Polach, Wear 258 (2005), 992-1000; Vehicle System Dynamics Supplement 33 (1999), 728-739",
    parse,
};

/// Friction at great speed of sliding over that at rest, and decay [s/m], of a `surface`.
pub fn friction_of(surface: &str) -> Option<(f64, f64)> {
    let surface = [("ideal", IDEAL), ("dry", DRY), ("wet", WET)].into_iter().find(|known| known.0 == surface)?.1;
    Some((surface.friction.ratio, surface.friction.decay))
}

/// State of the surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Surface {
    /// k_A, -.
    adhesion: f64,
    /// k_S, -.
    slip: f64,
    friction: FallingFriction,
}

impl Surface {
    /// Are forces less than on clean smooth surfaces?
    fn reduces(&self) -> bool {
        self.adhesion < 1.0 || self.slip < 1.0
    }
}

const IDEAL: Surface = Surface { adhesion: 1.0, slip: 1.0, friction: FallingFriction::CONSTANT };
const DRY: Surface = Surface { adhesion: 1.0, slip: 0.4, friction: FallingFriction { ratio: 0.4, decay: 0.6 } };
const WET: Surface = Surface { adhesion: 0.3, slip: 0.1, friction: FallingFriction { ratio: 0.4, decay: 0.2 } };

/// Polach's law.
#[derive(Debug, Clone)]
pub struct Polach {
    linear: LinearTheory,
    surface: Surface,
}

impl CreepLaw for Polach {
    #[inline]
    fn force(&self, contact: &RollingContact) -> CreepForce {
        let (patch, creepage) = (contact.patch, contact.creepage);
        let bound = self.surface.friction.at(contact.friction, contact.sliding_speed()) * contact.normal_force;
        if !(patch.a > 0.0 && patch.b > 0.0 && bound > 0.0) {
            return CreepForce::default();
        }
        let c = self.linear.coefficients(patch);
        let shear = self.linear.shear_modulus();
        let (x, y) = (creepage.longitudinal, creepage.lateral);
        let turned = y + creepage.spin * patch.a;
        let larger = if turned.abs() > y.abs() { turned } else { y };
        let total = (x * x + larger * larger).sqrt();
        if total < f64::MIN_POSITIVE {
            return CreepForce::default();
        }
        let plain = (x * x + y * y).sqrt().max(f64::MIN_POSITIVE);
        let (cx, cy) = (c.c11 * (x / plain), c.c22 * (y / plain));
        let area = patch.a * patch.b;
        let per_bound = shear / bound;
        let epsilon = 0.25 * PI * area * per_bound * (cx * cx + cy * cy).sqrt() * total;
        let share = |k_a: f64, k_s: f64, epsilon: f64| {
            let adhering = k_a * epsilon;
            2.0 / PI * (adhering / (1.0 + adhering * adhering) + (k_s * epsilon).atan())
        };
        let slip = share(1.0, 1.0, epsilon);
        let reduction = match self.surface.reduces() {
            false => 1.0,
            true => {
                let demand = 0.25 * PI * area * per_bound * (c.c11 * x).hypot(c.c22 * larger);
                let whole = share(1.0, 1.0, demand);
                let Surface { adhesion, slip, .. } = self.surface;
                if whole > 0.0 { share(adhesion, slip, demand) / whole } else { 0.5 * (adhesion + slip) }
            }
        };
        let k = 1.0 + 6.3 * (1.0 - (-patch.a / patch.b).exp());
        let spin_epsilon = 8.0 / 3.0 * per_bound * patch.b * area.sqrt() * c.c23 * larger.abs() / k;
        let one = 1.0 + spin_epsilon * spin_epsilon;
        let spin_share = 0.375 * patch.a * k * (spin_epsilon / one / one);
        let fx = slip * (x / total);
        let fy = slip * (y / total) + spin_share * (creepage.spin / total);
        let unit = -bound * reduction / (fx * fx + fy * fy).sqrt().max(1.0);
        CreepForce { longitudinal: unit * fx, lateral: unit * fy, spin_moment: 0.0 }
    }
}

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let preset = match section.word_or("surface", &["ideal", "dry", "wet"], "ideal")? {
        "dry" => DRY,
        "wet" => WET,
        _ => IDEAL,
    };
    let reduction = |key, default, most: f64| {
        let value = section.number_or(key, Dimension::None, default)?;
        if value > 0.0 && value <= most {
            return Ok(value);
        }
        Err(section.error(key, format!("found {value:?}, expected a number above 0, at most {most:?}")))
    };
    let adhesion = reduction("adhesion_reduction", preset.adhesion, 1.0)?;
    let slip = reduction("slip_reduction", preset.slip.min(adhesion), adhesion)?;
    let surface = Surface { adhesion, slip, friction: FallingFriction::parse(section, preset.friction)? };
    Ok(Arc::new(move |material| Box::new(Polach { linear: LinearTheory::new(material), surface })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::creepage::Creepage;
    use crate::contact::{Material, Patch};

    fn law(surface: Surface) -> Polach {
        Polach { linear: LinearTheory::new(Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 }), surface }
    }

    fn contact(x: f64, y: f64, spin: f64) -> RollingContact {
        let creepage = Creepage { longitudinal: x, lateral: y, spin };
        RollingContact { patch: Patch { a: 6e-3, b: 4e-3 }, normal_force: 8e4, friction: 0.3, creepage, speed: 20.0 }
    }

    /// Published form of the spin term against the simplified one.
    #[test]
    fn analytic_spin_term_is_polachs() {
        for e in [1e-3, 0.2, 0.9, 1.0, 3.0, 20.0] {
            let e: f64 = e;
            let d = (e * e - 1.0) / (e * e + 1.0);
            let published = e * (d.powi(3) / 3.0 - d * d / 2.0 + 1.0 / 6.0) - (1.0 - d * d).powf(1.5) / 3.0;
            let ours = -2.0 / 3.0 * e / (1.0 + e * e).powi(2);
            assert!((published - ours).abs() < 1e-13 * (1.0 + e), "{e}: {published} {ours}");
        }
    }

    /// The formula of Polach (2005), written again for longitudinal creepage alone, with his wet parameters: mu0 = 0.30,
    /// A = 0.40, B = 0.20 s/m, k_A = 0.30, k_S = 0.10.
    #[test]
    fn analytic_wet_rail() {
        let wet = law(WET);
        let mut peak = (0.0f64, 0.0f64);
        for i in 1..=200 {
            let x = 0.001 * f64::from(i);
            let found = -wet.force(&contact(x, 0.0, 0.0)).longitudinal;
            let mu = 0.3 * (0.6 * (-0.2 * 20.0 * x).exp() + 0.4);
            let c11 = wet.linear.coefficients(Patch { a: 6e-3, b: 4e-3 }).c11;
            let eps = 0.25 * wet.linear.shear_modulus() * PI * 24e-6 * c11 * x / (8e4 * mu);
            let expected = 2.0 * 8e4 * mu / PI * (0.3 * eps / (1.0 + (0.3 * eps).powi(2)) + (0.1 * eps).atan());
            assert!((found / expected - 1.0).abs() < 1e-12, "{x}");
            if found > peak.1 {
                peak = (x, found);
            }
        }
        println!("wet rail, 20 m/s: best adhesion {:.3} of N at creepage {:.3}", peak.1 / 8e4, peak.0);
        assert!(peak.0 > 0.01 && peak.0 < 0.1 && peak.1 < 0.3 * 8e4, "{peak:?}");
    }

    /// A real pose of a leading wheel in a curve: friction takes power on every surface. With whole spin beside reduced slip it gave 24 J/m (dry) and 73 J/m (wet).
    #[test]
    fn analytic_spin_does_not_turn_reduced_forces_round() {
        let creepage = Creepage { longitudinal: -0.87e-3, lateral: -5.3e-3, spin: 0.75 };
        let contact = RollingContact { patch: Patch { a: 9.2e-3, b: 1.6e-3 }, normal_force: 8.8e4, friction: 0.35, creepage, speed: 20.0 };
        let ideal = law(Surface { friction: FallingFriction::CONSTANT, ..IDEAL }).force(&contact);
        for surface in [DRY, WET] {
            let force = law(Surface { friction: FallingFriction::CONSTANT, ..surface }).force(&contact);
            let power = -(force.longitudinal * creepage.longitudinal + force.lateral * creepage.lateral);
            assert!(power > 0.0, "{force:?}");
            let across = force.longitudinal * ideal.lateral - force.lateral * ideal.longitudinal;
            let size = |force: &CreepForce| force.longitudinal.hypot(force.lateral);
            assert!(across.abs() < 1e-12 * size(&force) * size(&ideal) && size(&force) < size(&ideal), "{force:?} {ideal:?}");
        }
        // The limit of no creepage beside spin is one, from wherever it comes.
        let spinning = |longitudinal: f64, lateral: f64| {
            law(WET).force(&RollingContact { creepage: Creepage { longitudinal, lateral, spin: 1.0 }, ..contact }).lateral
        };
        let still = spinning(0.0, 0.0);
        assert!(still < 0.0);
        for beside in [spinning(1e-9, 0.0), spinning(0.0, 1e-9), spinning(-1e-9, -1e-9)] {
            assert!((beside / still - 1.0).abs() < 1e-5, "{beside} {still}");
        }
        // Not reduced at all: to the bit what it is without r.
        assert_eq!(
            law(Surface { adhesion: 1.0, slip: 1.0, ..DRY }).force(&contact),
            law(Surface { friction: DRY.friction, ..IDEAL }).force(&contact)
        );
    }

    #[test]
    fn analytic_initial_slope_is_reduced_by_the_mean_of_both_factors() {
        let small = contact(1e-9, 0.0, 0.0);
        let ratio = law(WET).force(&small).longitudinal / law(IDEAL).force(&small).longitudinal;
        assert!((ratio - 0.2).abs() < 1e-6, "{ratio}");
    }
}
