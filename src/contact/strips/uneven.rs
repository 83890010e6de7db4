//! What a creep law of ellipses does not know of a part of a patch: loads and lengths that are no ellipse's, and slip that is no plane over it.
//!
//! A law sees the ellipse of the part's moments, one creepage and one spin. On S1002 a patch may be a narrow hump with a wide flat shoulder, which has
//! a peak of three times its mean pressure where an ellipse has one and a half. What that does to the force is told by a simple theory twice, of the
//! strips with the slip w_i of each, and of the law's ellipse under the law's slip w = (xi_x - phi y, xi_y):
//!
//! ```text
//! T = T(law) + T(strips) - T(ellipse)
//! T(strips)  = -sum mu Q_i s(k_i) w_i / |w_i|,             k_i = 2 |w_i| a_i^2 / (3 L mu q_i)
//! T(ellipse) = -mu N integral 3/4 (1 - e^2) s(k) w / |w| de,   k  = 8 |w| a^2 b / (9 L mu N),    y = e b,   e from -1 to 1
//! s(k) = 1 - (1 - k)^3 up to k = 1, then 1
//! ```
//!
//! That is Kalker's simplified theory without spin in the strip: a strip of half length a_i under a parabola of pressure (Q_i its load, q_i its load over
//! its width), whose surface yields by `L p` to a traction p, with `L = 8 a / (3 G c11)` as there. What the simple theory gets wrong falls out of the
//! difference but for its own part in it; where the part is an ellipse nothing is left.
//!
//! Against half-space contact (docs/real_profiles.md) the largest error of creep forces falls by it from 0.15 to 0.06 mu N, their mean error by a
//! quarter.
//!
//! *Bound.* The sum is not larger than mu N, or than what the law says where that is not bounded. *Left out:* Kalker factors and falling friction of the
//! law, which would change the difference (a tenth of mu N at most on profiles of railways) in proportion.

use super::mixed::Creep;
use super::parts::{Part, Share};
use super::pressed::Pressed;
use crate::contact::Material;
use crate::contact::creep::RollingContact;
use crate::contact::creepage::ContactAxes;
use nalgebra::{Vector2, Vector3};

/// Kalker's c11 by powers of a/b, for Poisson's ratios about 0.28: 4 % from a/b = 0.1 to 10.
const C11: [f64; 3] = [3.29, 0.975, -0.012];
/// Strips that the ellipse is cut into.
const OF_ELLIPSE: usize = 8;

/// A creep force on a part with what the law does not know of it. `velocity` is that of the wheel's material at a place from the wheelset's centre, m/s;
/// `contact` is what the law was asked.
pub fn with_uneven_slip(
    law: Creep,
    (share, part): (Share, &Part),
    axes: &ContactAxes,
    velocity: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    contact: &RollingContact,
    material: Material,
) -> Creep {
    let bound = contact.bound();
    if !(bound > 0.0 && contact.speed > 0.0) {
        return law;
    }
    let (patch, creepage) = (part.patch, contact.creepage);
    let ratio = (patch.a / patch.b).min(20.0);
    let flexibility = 8.0 * patch.a / (3.0 * material.shear_modulus() * (C11[0] + ratio * (C11[1] + ratio * C11[2])));
    // Loads with damping; squares of half lengths that have the ellipse's mean, 4/5 a^2.
    let strength = contact.friction * contact.normal_force / part.load;
    let lengthening = 0.8 * patch.a * patch.a / part.mean_square;
    let mut added = Vector2::zeros();
    let mut moment = 0.0;
    for (part_of, Pressed { strip, width, load, half_length, .. }) in share.loads().filter(|(_, own)| own.load > 0.0) {
        let arm = strip.point - strip.normal * strip.overlap;
        let y = (arm - part.arm).dot(&axes.e2);
        let velocity = velocity(&arm) / contact.speed;
        let own = strength * load;
        let reach = 2.0 * lengthening * half_length * half_length * width / (3.0 * flexibility * own);
        let force = yielding(&Vector2::new(velocity.dot(&axes.e1), velocity.dot(&axes.e2)), reach) * (own * part_of);
        added += force;
        moment -= y * force.x;
    }
    let reach = 8.0 * patch.b * patch.a * patch.a / (9.0 * flexibility * bound);
    for k in 0..OF_ELLIPSE {
        // Middles of equal stretches; their sum of 1 - e^2 is by 1 / (2 n^2) too large.
        const MANY: f64 = OF_ELLIPSE as f64;
        let e = (2.0 * k as f64 + 1.0) / MANY - 1.0;
        let weight = 1.5 * (1.0 - e * e) / (MANY + 0.5 / MANY);
        let y = e * patch.b;
        let force = yielding(&Vector2::new(creepage.longitudinal - creepage.spin * y, creepage.lateral), reach) * (bound * weight);
        added -= force;
        moment += y * force.x;
    }
    let force = law.force + axes.e1 * added.x + axes.e2 * added.y;
    let (size, most) = (force.norm(), bound.max(law.force.norm()));
    let within = if size > most { most / size } else { 1.0 };
    Creep { force: force * within, moment: law.moment + moment }
}

/// `-s(k) w / |w|`, k = reach |w|.
#[inline]
fn yielding(slip: &Vector2<f64>, reach: f64) -> Vector2<f64> {
    let k = reach * slip.norm();
    let per_k = if k < 1.0 { 3.0 - k * (3.0 - k) } else { 1.0 / k };
    slip * (-reach * per_k)
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

    #[test]
    fn analytic_strips_slide_wholly_at_great_slip_and_yield_as_the_linear_theory_says_at_small() {
        let slip = Vector2::new(3e-4, -4e-4);
        assert!((yielding(&(slip * 100.0), 1e3).norm() - 1.0).abs() < 1e-12);
        let (force, reach) = (yielding(&(slip * 1e-4), 1e3), 1e3);
        assert!((force + slip * 1e-4 * (3.0 * reach)).norm() < 1e-3 * force.norm());
    }
}
