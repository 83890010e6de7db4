//! Derivatives of creep laws, for implicit integration.
//!
//! By creepage at a constant load, and by the load. There the patch grows with N as Hertz has it, a and b with the cube root
//! (exact for elastic contact of a given shape; damping changes N without changing the patch, which is left out).
//!
//! Laws with a simple formula state theirs. For the others the law itself is differenced (four more calls), one step each in
//! the direction of the creepage, so that corners at zero are kept out. The step is [`STEP`] of the creepage that asks for all the
//! friction there is; the relative error of the slopes is of that order, 1e-3 (strips and tables make small kinks, which shorter
//! steps would see). Methods that use the slopes keep their order whatever they are.

use super::{CreepLaw, RollingContact};
use crate::contact::Patch;
use crate::contact::creepage::{CreepForce, Creepage};
use nalgebra::{Matrix3, Vector3};

/// Derivatives of longitudinal force, lateral force and spin moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CreepSlopes {
    /// By longitudinal, lateral and spin creepage (columns).
    pub by_creepage: Matrix3<f64>,
    /// By the normal force, with a patch that grows with it, -.
    pub by_normal_force: Vector3<f64>,
}

/// Step over the creepage that asks for all the friction there is.
const STEP: f64 = 1e-3;
/// G c11 of steel on round patches, Pa: it only scales the step.
const SHEAR: f64 = 3.5e11;

fn vector(force: &CreepForce) -> Vector3<f64> {
    Vector3::new(force.longitudinal, force.lateral, force.spin_moment)
}

/// The same contact under a normal force that is `1 + change` as great, its patch grown accordingly.
pub fn loaded(contact: &RollingContact, change: f64) -> RollingContact {
    let growth = (1.0 + change).cbrt();
    let patch = Patch { a: growth * contact.patch.a, b: growth * contact.patch.b };
    RollingContact { patch, normal_force: (1.0 + change) * contact.normal_force, ..*contact }
}

/// Slopes from forces at neighbouring creepages and at a slightly greater load.
pub fn differences<L: CreepLaw + ?Sized>(law: &L, contact: &RollingContact, force: &CreepForce) -> CreepSlopes {
    let (Patch { a, b }, bound) = (contact.patch, contact.bound());
    if !(a > 0.0 && b > 0.0 && bound > 0.0) {
        return CreepSlopes::default();
    }
    let here = vector(force);
    let step = STEP * bound / (SHEAR * a * b);
    let Creepage { longitudinal, lateral, spin } = contact.creepage;
    let at = |creepage: Creepage| vector(&law.force(&RollingContact { creepage, ..*contact })) - here;
    let outward = |value: f64, step: f64| step.copysign(value);
    let (dx, dy, ds) = (outward(longitudinal, step), outward(lateral, step), outward(spin, step / (a * b).sqrt()));
    let columns = [
        at(Creepage { longitudinal: longitudinal + dx, ..contact.creepage }) / dx,
        at(Creepage { lateral: lateral + dy, ..contact.creepage }) / dy,
        at(Creepage { spin: spin + ds, ..contact.creepage }) / ds,
    ];
    let heavier = vector(&law.force(&loaded(contact, STEP))) - here;
    CreepSlopes { by_creepage: Matrix3::from_columns(&columns), by_normal_force: heavier / (STEP * contact.normal_force) }
}

#[cfg(test)]
mod tests {
    use super::super::inline;
    use super::*;
    use crate::contact::Material;

    /// Central differences, fourth order in the creepages; the step is a share of the creepage that asks for all the friction.
    fn central(law: &dyn CreepLaw, contact: &RollingContact, step: f64) -> CreepSlopes {
        let scale = step * contact.bound() / (SHEAR * contact.patch.a * contact.patch.b);
        let force = |d: [f64; 3], load: f64| {
            let creepage = contact.creepage;
            let creepage =
                Creepage { longitudinal: creepage.longitudinal + d[0], lateral: creepage.lateral + d[1], spin: creepage.spin + d[2] };
            vector(&law.force(&loaded(&RollingContact { creepage, ..*contact }, load)))
        };
        let columns: [Vector3<f64>; 3] = std::array::from_fn(|j| {
            let h = if j == 2 { scale / (contact.patch.a * contact.patch.b).sqrt() } else { scale };
            let at = |k: f64| {
                let mut d = [0.0; 3];
                d[j] = k * h;
                force(d, 0.0)
            };
            (at(-2.0) - at(2.0) + (at(1.0) - at(-1.0)) * 8.0) / (12.0 * h)
        });
        let by_load = (force([0.0; 3], 1e-4) - force([0.0; 3], -1e-4)) / (2e-4 * contact.normal_force);
        CreepSlopes { by_creepage: Matrix3::from_columns(&columns), by_normal_force: by_load }
    }

    #[test]
    fn analytic_slopes_of_every_law_match_central_differences() {
        let cases = [(1e-4, -2e-4, 0.1), (1.5e-3, 1e-3, -0.3), (-4e-3, 2e-3, 0.5), (0.02, 0.01, 0.2)];
        // Formulas, then laws that are differenced: their strips and tables have kinks.
        for (name, step, allowed) in [
            ("kalker_linear", 1e-2, 1e-7),
            ("shen_hedrick_elkins", 1e-3, 1e-6),
            ("polach", 1e-2, 5e-3),
            ("polach{surface=\"wet\"}", 1e-2, 5e-3),
            ("fastsim", 0.02, 2e-3),
            ("fastrip", 0.02, 2e-3),
            ("usetab", 0.02, 2e-3),
        ] {
            let law = inline::law(name, "test").unwrap()(Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 });
            let mut worst = 0.0f64;
            for (longitudinal, lateral, spin) in cases {
                let creepage = Creepage { longitudinal, lateral, spin };
                let patch = Patch { a: 6e-3, b: 4e-3 };
                let contact = RollingContact { patch, normal_force: 6e4, friction: 0.35, creepage, speed: 20.0 };
                let (found, exact) = (law.slopes(&contact, &law.force(&contact)), central(law.as_ref(), &contact, step));
                // Moments over a length of the patch, spin times it: all entries in newtons.
                let length = (patch.a * patch.b).sqrt();
                let even = |m: &Matrix3<f64>| {
                    Matrix3::from_fn(|i, j| m[(i, j)] / if i == 2 { length } else { 1.0 } / if j == 2 { length } else { 1.0 })
                };
                // At rest every law is about as stiff as the linear theory.
                let (scale, load) = (SHEAR * patch.a * patch.b, Vector3::new(1.0, 1.0, 1.0 / length));
                let off = (even(&found.by_creepage) - even(&exact.by_creepage)).amax() / scale;
                let off_load = (found.by_normal_force - exact.by_normal_force).component_mul(&load).amax();
                worst = worst.max(off).max(off_load);
            }
            println!("{name}: slopes off by {worst:.1e} of the stiffness at rest");
            assert!(worst < allowed, "{name}: {worst}");
        }
    }
}
