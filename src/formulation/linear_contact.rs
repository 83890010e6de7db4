//! Contact of a wheel that is linear about the middle of its track: the first order of the strips' patch ([`LinearPatch`]), and of its creep force.
//!
//! *Creep.* About steady rolling in the middle of the track, creepages xi0 = (0, 0, phi0) of the spin that the contact angle makes, under the load N0,
//!
//! ```text
//! T = S xi (N / N0)^p + (T0 - S xi0 + T_v dv + T_phi dphi) N / N0,     p of S_ij = p_i + p_j,  p = (1/3, 1/3, 2/3)
//! ```
//!
//! with force and slopes of the scene's own creep law there, and of what the strips add to it. With `kalker_linear` on an ellipse T0 = S xi0, and this is Kalker's linear theory,
//! `T_x = -G a b c11 xi_x`, `T_y = -G a b (c22 xi_y + sqrt(a b) c23 phi)`, whose coefficients grow as its patch does with N (the exponents); another law has the slopes
//! that it has left at the steady spin. T_v and T_phi are how T0 changes as the patch changes its shape with the place.
//! Frame: that of creep laws, e1 along the direction of rolling, e2 = n x e1.

use crate::contact::creepage::{CreepForce, Creepage};
use crate::contact::strips::LinearPatch;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Contact of a wheel, linear about the middle of its track.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearContact {
    pub patch: LinearPatch,
    pub(super) creep: LinearCreep,
}

/// Creep force, linear about steady rolling.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LinearCreep {
    /// N0, N.
    pub normal_force: f64,
    /// S.
    pub slopes: Matrix3<f64>,
    /// T0 - S xi0, and T_v [N/m], T_phi [N/rad].
    pub rest: Vector3<f64>,
    pub by_place: [Vector3<f64>; 2],
}

impl LinearContact {
    /// Equivalent conicity, -: change of the rolling radius by the displacement of a wheelset that rolls over by as much as its wheels, `half` [m] from its middle, climb.
    pub fn conicity(&self, half: f64) -> f64 {
        let ([by_place, by_lean], [climb, climb_by_lean]) = (self.patch.radius().1, self.patch.slopes());
        // Displaced by y this wheel climbs by h_v y in the rail's section, in which the level axle leans by phi0, and the other falls: b phi = (h_v - tan phi0) y + h_phi phi.
        let lean = (climb - self.patch.lean().tan()) / (half - climb_by_lean);
        by_place + by_lean * lean
    }
}

impl LinearContact {
    /// That of the other side of a symmetric pair: the patch counts outward, the creep force to the left.
    pub(super) fn mirrored(&self) -> LinearContact {
        let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
        let LinearCreep { normal_force, slopes, rest, by_place } = &self.creep;
        let creep = LinearCreep {
            normal_force: *normal_force,
            slopes: mirror * slopes * mirror,
            rest: mirror * rest,
            by_place: by_place.map(|by| mirror * by),
        };
        LinearContact { patch: self.patch.clone(), creep }
    }
}

impl LinearCreep {
    /// In axes along the direction of rolling; which is that of the reference, or its mirror image.
    #[inline]
    pub fn force(&self, creepage: &Creepage, sign: f64, normal_force: f64, moved: &Vector2<f64>) -> CreepForce {
        let more = (normal_force / self.normal_force).max(0.0);
        let mirror = Vector3::new(1.0, sign, sign);
        let third = more.cbrt();
        // Powers p of N with which creepages, and forces, count.
        let growth = Vector3::new(third, third, third * third);
        let creepage = vector(creepage).component_mul(&mirror).component_mul(&growth);
        let rest = self.rest + self.by_place[0] * moved.x + self.by_place[1] * moved.y;
        let force = ((self.slopes * creepage).component_mul(&growth) + rest * more).component_mul(&mirror);
        CreepForce { longitudinal: force.x, lateral: force.y, spin_moment: force.z }
    }
}

/// Longitudinal, lateral, spin.
pub(super) fn vector(creepage: &Creepage) -> Vector3<f64> {
    Vector3::new(creepage.longitudinal, creepage.lateral, creepage.spin)
}
