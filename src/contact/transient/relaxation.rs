//! Tangential stiffness of a resting elliptic contact, and the relaxation lengths of a rolling one.
//!
//! Two like half-spaces pressed together in an ellipse a, b that is pushed sideways without slip carry the traction
//! `q = Q / (2 pi a b) / sqrt(1 - x^2/a^2 - y^2/b^2)`. Cerruti's solution gives the shift of the bodies,
//! `u = Q I / (4 pi G a b)`, with an integral over the directions theta in the patch,
//! `I = int_0^2pi rho (1 - nu + nu cos^2 theta) dtheta`, `1/rho^2 = cos^2 theta/a^2 + sin^2 theta/b^2`
//! (for a push along e1; sin^2 for one along e2). The mean of both pushes needs only `int rho dtheta = 2 pi a b / M(a, b)`
//! with the arithmetic-geometric mean M, so
//!
//! ```text
//! k = 4 G M(a, b) / (2 - nu)                        (a = b: Mindlin's 4 G a / (2 - nu))
//! L_x = G a b c11 / k,   L_y = G a b c22 / k        (Kalker's coefficients; G cancels)
//! ```
//!
//! A contact that rolls from rest follows the spring k at first and Kalker's linear theory in the end: the first-order
//! lag over the relaxation length L is the simplest equation that has both limits. One stiffness for both
//! directions makes the resting contact a conservative spring; the true ones differ from their mean by less than
//! nu/(2 - nu) = 16 % (none for a circle; a/b = 2: 2.8 %, a/b = 5: 6.2 %). The lag is off the exact rolling of
//! half-spaces that stick everywhere by 7 % (e1) and 9 % (e2) of the final force at most (circle; a/b = 2: 8 % and 11 %),
//! late, 2 a after a step: L = 0.85 of this would fit the way best, within 3 %, but make the spring too stiff by 18 %.
//!
//! Source: R. D. Mindlin, Compliance of elastic bodies in contact, J. Appl. Mech. 16 (1949) 259; J. J. Kalker,
//! Three-Dimensional Elastic Bodies in Rolling Contact (1990).

use crate::contact::creep::kalker::{Coefficients, KalkerTable};
use crate::contact::{Material, Patch};

/// Elastic numbers of one patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity {
    /// L along e1 and e2, m.
    pub length: [f64; 2],
    /// k in the contact plane, N/m.
    pub stiffness: f64,
    /// G (a b)^1.5 c23, N m: lateral force per spin creepage of the linear theory.
    pub spin_coupling: f64,
}

/// Makes [`Elasticity`] from patches of one material.
#[derive(Clone, Debug)]
pub struct Relaxation {
    shear_modulus: f64,
    poisson_ratio: f64,
    table: KalkerTable,
    /// Part of spin that counts: 1 or 0.
    spin: f64,
}

/// Arithmetic-geometric mean of two positive numbers; six steps are exact to rounding for ratios up to 1e5.
#[inline]
fn arithmetic_geometric_mean(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

impl Relaxation {
    pub fn new(material: Material) -> Self {
        Relaxation {
            shear_modulus: material.shear_modulus(),
            poisson_ratio: material.poisson_ratio,
            table: KalkerTable::new(material.poisson_ratio),
            spin: 1.0,
        }
    }

    /// From now on `spin_coupling` is zero.
    pub(super) fn leave_out_spin(&mut self) {
        self.spin = 0.0;
    }

    /// `None` for an empty patch.
    #[inline]
    pub fn of(&self, patch: Patch) -> Option<Elasticity> {
        if !(patch.a > 0.0 && patch.b > 0.0) {
            return None;
        }
        let Coefficients { c11, c22, c23, .. } = self.table.at(patch.a / patch.b);
        let area = patch.a * patch.b;
        let stiffness = 4.0 * self.shear_modulus * arithmetic_geometric_mean(patch.a, patch.b) / (2.0 - self.poisson_ratio);
        let length = self.shear_modulus * area / stiffness;
        Some(Elasticity {
            length: [length * c11, length * c22],
            stiffness,
            spin_coupling: self.spin * (self.shear_modulus * area * area.sqrt() * c23),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Material = Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 };

    #[test]
    fn analytic_circle_has_mindlins_stiffness() {
        let found = Relaxation::new(STEEL).of(Patch { a: 5e-3, b: 5e-3 }).unwrap();
        let mindlin = 4.0 * STEEL.shear_modulus() * 5e-3 / 1.72;
        assert!((found.stiffness / mindlin - 1.0).abs() < 1e-14);
        println!("a = b = 5 mm: k {:.4e} N/m, L {:.4?} mm", found.stiffness, found.length.map(|l| 1e3 * l));
    }

    #[test]
    fn analytic_stiffness_is_the_mean_of_both_directions_of_an_ellipse() {
        // The integral I by the trapezoidal rule, which converges geometrically for a periodic function.
        let relaxation = Relaxation::new(STEEL);
        let nu = STEEL.poisson_ratio;
        for (ratio, allowed) in [(0.2, 0.065), (0.5, 0.03), (1.3, 0.012), (2.0, 0.03), (5.0, 0.065)] {
            let (a, b) = (5e-3, 5e-3 / ratio);
            let sum = |weight: fn(f64) -> f64| {
                let each = |i: usize| {
                    let angle = 2.0 * std::f64::consts::PI * i as f64 / 400.0;
                    let rho = 1.0 / ((angle.cos() / a).powi(2) + (angle.sin() / b).powi(2)).sqrt();
                    rho * (1.0 - nu + nu * weight(angle)) * 2.0 * std::f64::consts::PI / 400.0
                };
                (0..400).map(each).sum::<f64>()
            };
            let (along, across) = (sum(|t| t.cos().powi(2)), sum(|t| t.sin().powi(2)));
            let of = |integral: f64| 4.0 * std::f64::consts::PI * STEEL.shear_modulus() * a * b / integral;
            let found = relaxation.of(Patch { a, b }).unwrap();
            assert!((found.stiffness / of(0.5 * (along + across)) - 1.0).abs() < 1e-12);
            let off = (of(along) / found.stiffness - 1.0).abs().max((of(across) / found.stiffness - 1.0).abs());
            println!("a/b {ratio}: the directions' stiffnesses are off their mean by {off:.4}, L/a {:.3?}", found.length.map(|l| l / a));
            assert!(off < allowed, "{ratio} {off}");
        }
        assert_eq!(relaxation.of(Patch::default()), None);
    }
}
