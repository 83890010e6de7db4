//! What a creep law of ellipses does not know of a part of a patch: loads and lengths that are no ellipse's, and slip that is no plane over it.
//!
//! A law sees the ellipse of the part's moments, one creepage and one spin. On S1002 a patch may be a narrow hump with a wide flat shoulder, which has
//! a peak of three times its mean pressure where an ellipse has one and a half. What that does to the force is told by a simple theory twice, of the
//! strips with the slip w_i of each, and of the law's ellipse under the law's slip w = (xi_x - phi y, xi_y):
//!
//! ```text
//! T = T(law) + T(strips) - T(ellipse)
//! T(strips)  = sum T(w_i, phi_i, a_i, Q_i)                  r_i = 2 a_i^2 / (3 L mu q_i)
//! T(ellipse) = integral 3/4 (1 - e^2) T(w, phi, a sqrt(1 - e^2), N) de,   r  = 8 a^2 b / (9 L mu N),    y = e b,   e from -1 to 1
//! ```
//!
//! T(w, phi, a, Q) is Kalker's simplified theory of a strip ([`super::traction`]): of half length a_i under a parabola of pressure (Q_i its load, q_i its load over
//! its width), whose surface yields by `L p` to a traction p, with `L = 8 a / (3 G c11)` as there; each strip slips in its own plane, with the spin about its own normal. What the simple theory gets wrong falls out of the
//! difference but for its own part in it; where the part is an ellipse nothing is left.
//!
//! Against half-space contact the mean error of creep forces near free rolling (125 poses of S1002 and APTA140 on 60E1 and UIC60, and on gauge corners worn to radii of 1 to 4 mm) falls from 0.028 mu N
//! without turn along the strips to 0.020, the largest from 0.31 to 0.12; driven or braked (docs/real_profiles.md) it is 0.009 and 0.06.
//!
//! *Bound.* The sum is not larger than mu N, or than what the law says where that is not bounded. *Left out:* Kalker factors and falling friction of the
//! law, which would change the difference (a tenth of mu N at most on profiles of railways) in proportion.

use super::fifths::{Cells, FIFTHS, OF_ELLIPSE as FIFTHS_OF_ELLIPSE, half_lengths, slopes};
use super::parts::Part;
use super::pressed::Pressed;
use super::traction::{Slipping, Tractions, turn_of_slip};
use crate::contact::creep::RollingContact;
use crate::contact::creep::slopes::{CreepSlopes, loaded};
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage};
use crate::contact::{Material, Patch};
use nalgebra::{Matrix3, Vector2, Vector3};
use std::sync::LazyLock;

/// Kalker's c11 by powers of a/b, for Poisson's ratios about 0.28: 4 % from a/b = 0.1 to 10.
const C11: [f64; 3] = [3.29, 0.975, -0.012];
/// Step of differences over the creepage that asks for all the friction there is.
const STEP: f64 = 1e-4;
/// Strips that the ellipse is cut into.
const OF_ELLIPSE: usize = 8;

/// Their middles over b, the shares of the load that they carry, and their half lengths over a.
static STRETCHES: LazyLock<[[f64; 3]; OF_ELLIPSE]> = LazyLock::new(|| {
    // Their number as it enters: the sum of 1 - e^2 over the middles of equal stretches is by 1 / (2 n^2) too large.
    let count = OF_ELLIPSE as f64;
    std::array::from_fn(|k| {
        let e = (2.0 * k as f64 + 1.0) / count - 1.0;
        [e, 1.5 * (1.0 - e * e) / (count + 0.5 / count), (1.0 - e * e).sqrt()]
    })
});

/// A part that rolls.
pub struct Uneven<'a> {
    pub cells: Cells<'a>,
    pub part: &'a Part,
    /// Along the direction of rolling, and the other two accordingly.
    pub axes: ContactAxes,
    /// The wheel's at its centre, m/s, and its angular velocity, rad/s.
    pub velocity: Vector3<f64>,
    pub rotation: Vector3<f64>,
    pub material: Material,
}

impl Uneven<'_> {
    /// Creep force of the part from that which the law gives for the `contact`.
    pub fn force(&self, law: &CreepForce, contact: &RollingContact) -> CreepForce {
        let [longitudinal, lateral, spin_moment] = self.total(vector(law), contact, &Creepage::default()).into();
        CreepForce { longitudinal, lateral, spin_moment }
    }

    /// Its slopes from the force and the slopes of the law.
    pub fn slopes(&self, law: &CreepForce, slopes: &CreepSlopes, contact: &RollingContact) -> CreepSlopes {
        let bound = contact.bound();
        if !(bound > 0.0 && contact.speed > 0.0) {
            return *slopes;
        }
        let law = vector(law);
        let here = self.total(law, contact, &Creepage::default());
        let Patch { a, b } = contact.patch;
        let step = STEP * bound / (self.material.shear_modulus() * C11[0] * a * b);
        let steps = [step, step, step / (a * b).sqrt()];
        let columns: [Vector3<f64>; 3] = std::array::from_fn(|k| {
            let mut by = [0.0; 3];
            by[k] = steps[k];
            let change = Creepage { longitudinal: by[0], lateral: by[1], spin: by[2] };
            (self.total(law + slopes.by_creepage.column(k) * steps[k], contact, &change) - here) / steps[k]
        });
        let heavier = loaded(contact, STEP);
        let more = heavier.normal_force - contact.normal_force;
        let by_load = self.total(law + slopes.by_normal_force * more, &heavier, &Creepage::default()) - here;
        CreepSlopes { by_creepage: Matrix3::from_columns(&columns), by_normal_force: by_load / more }
    }

    /// Forces and moment from those of the law, for slip that is by `change` more.
    fn total(&self, law: Vector3<f64>, contact: &RollingContact, change: &Creepage) -> Vector3<f64> {
        let bound = contact.bound();
        if !(bound > 0.0 && contact.speed > 0.0) {
            return law;
        }
        let Patch { a, b } = contact.patch;
        let ratio = (a / b).min(20.0);
        let flexibility = 8.0 * a / (3.0 * self.material.shear_modulus() * (C11[0] + ratio * (C11[1] + ratio * C11[2])));
        // L, and how much slip turns per spin.
        let yielding = (flexibility, turn_of_slip(a / b));
        // All of them together: they run in vectors.
        let mut sum = Tractions::default();
        self.of_strips(&mut sum, contact, yielding, change);
        match self.cells {
            Cells::Strips(_) => less_ellipse(&mut sum, contact, yielding, change, &*STRETCHES),
            Cells::Fifths(_) => less_ellipse(&mut sum, contact, yielding, change, &FIFTHS_OF_ELLIPSE),
        }
        let total = law + sum.total();
        let (size, most) = (total.xy().norm(), bound.max(law.xy().norm()));
        let within = if size > most { most / size } else { 1.0 };
        Vector3::new(within * total.x, within * total.y, total.z)
    }

    fn of_strips(&self, sum: &mut Tractions, contact: &RollingContact, (flexibility, per_spin): (f64, f64), change: &Creepage) {
        let ContactAxes { e1, e2, .. } = self.axes;
        let Patch { a, b } = contact.patch;
        // Loads with damping; squares of half lengths that have the ellipse's mean, 4/5 a^2.
        let strength = contact.friction * contact.normal_force / self.part.load;
        let lengthening = 0.8 * a * a / self.part.mean_square;
        // Each on its own plane: across a curved patch spin changes with the normal.
        let mut add = |(arm, normal): (&Vector3<f64>, &Vector3<f64>), across: f64, half_length: f64, reach: f64, bound: f64| {
            let velocity = (self.velocity + self.rotation.cross(arm)) / contact.speed;
            let (lateral, spin) = (velocity.dot(&normal.cross(&e1)), self.rotation.dot(normal) / contact.speed);
            let slip = Vector2::new(velocity.dot(&e1) + change.longitudinal - change.spin * across, lateral + change.lateral);
            sum.add(&Slipping { slip, turn: per_spin * (spin + change.spin), half_length, reach, bound, across });
        };
        match self.cells {
            Cells::Strips(share) => {
                let longer = lengthening.sqrt();
                for (part_of, Pressed { strip, width, load, half_length, .. }) in share.loads().filter(|(_, own)| own.load > 0.0) {
                    let arm = strip.point - strip.normal * strip.overlap;
                    let y = (arm - self.part.arm).dot(&e2);
                    let own = strength * load;
                    let reach = 2.0 * lengthening * half_length * half_length * width / (3.0 * flexibility * own);
                    add((&arm, &(0.5 * (strip.normal + strip.against))), y, longer * half_length, reach, own * part_of);
                }
            }
            Cells::Fifths(fifths) => {
                let outward = e2.dot(&fifths.outward).signum();
                let own = contact.bound() / FIFTHS as f64;
                let half_lengths = half_lengths(&fifths.each.map(|cell| cell.across / b), &fifths.each.map(|cell| cell.size));
                let slopes = slopes(fifths);
                for ((cell, half_length), slope) in fifths.each.iter().zip(half_lengths).zip(slopes) {
                    let y = outward * cell.across;
                    let arm = self.part.arm + e2 * y + self.axes.normal * cell.above;
                    let normal = (self.axes.normal - e2 * (outward * slope)) / slope.hypot(1.0);
                    add((&arm, &normal), y, a * half_length, 2.0 * a * a * b * cell.size / (3.0 * flexibility * own), own);
                }
            }
        }
    }
}

fn vector(force: &CreepForce) -> Vector3<f64> {
    Vector3::new(force.longitudinal, force.lateral, force.spin_moment)
}

/// Takes what the ellipse transmits off, with how the surface yields (L, and phi' per phi), by places over the half width b, shares of the load there, and half lengths over a.
fn less_ellipse(
    sum: &mut Tractions,
    contact: &RollingContact,
    (flexibility, per_spin): (f64, f64),
    change: &Creepage,
    places: &[[f64; 3]],
) {
    let (Patch { a, b }, bound) = (contact.patch, contact.bound());
    let reach = 8.0 * b * a * a / (9.0 * flexibility * bound);
    let spin = contact.creepage.spin + change.spin;
    let (longitudinal, lateral) = (contact.creepage.longitudinal + change.longitudinal, contact.creepage.lateral + change.lateral);
    let turn = per_spin * spin;
    for [e, weight, half_length] in places {
        let across = e * b;
        let slip = Vector2::new(longitudinal - spin * across, lateral);
        sum.add(&Slipping { slip, turn, half_length: a * half_length, reach, bound: -bound * weight, across });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::creep::kalker::KalkerTable;

    #[test]
    fn analytic_c11_is_kalkers() {
        let table = KalkerTable::new(0.28);
        for ratio in [0.1f64, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0] {
            let fitted = C11[0] + ratio * (C11[1] + ratio * C11[2]);
            println!("a/b {ratio}: {fitted:.3} for {:.3}", table.at(ratio).c11);
            assert!((fitted / table.at(ratio).c11 - 1.0).abs() < 0.04, "{ratio}");
        }
    }
}
