//! What strips of a rolling patch transmit where slip turns along them: Kalker's simplified theory, strip by strip.
//!
//! A strip of half length a carries Q under a parabola of pressure, and its surface yields by L p to a traction p. At the place x = a xi ahead of its middle it slips with
//! `w = (w_x, w_y + phi' x)`; in parts of the largest bound `3 mu q / (4 a)` (q its load over its width) its traction tau begins with 0 at the leading edge xi = 1 and follows
//!
//! ```text
//! d tau / d(-xi) = -2 r w,   |tau| <= 1 - xi^2,   r = 2 a^2 / (3 L mu q)
//! T = mu Q 3/4 integral tau d xi,   M = a mu Q 3/4 integral xi tau_y d xi
//! ```
//!
//! Without phi' this is `T = -mu Q s(k) w / |w|`, `s(k) = 1 - (1 - k)^3` up to k = r |w| = 1, then 1. Source: J. J. Kalker, Vehicle System Dynamics 11 (1982) 1-13. L gives the
//! longitudinal stiffness of the linear theory; to lateral traction by spin the surface yields otherwise, by L3, so that `phi' = phi L / L3`, which depends on the ellipse's a/b alone.

//!
//! *Numerically*: tau at [`PLACES`] places, each from the last one; what is beyond the bound is scaled to it smoothly (implicit steps need slopes that do not jump), by up to 5 % less where it is just
//! reached. Where slip turns around while all slides, tau follows a place late. Both fall out of the difference that is taken ([`super::uneven`]) but for how strips differ from the ellipse.

use nalgebra::{Vector2, Vector3};

/// Places along a strip. With twice as many, creep forces of real profiles stand as far from half-spaces' (means equal to 0.0001 mu N).
const PLACES: usize = 8;
/// How round the corner between sticking and sliding is: square of the distance from the squared bound, in parts of that.
const ROUND: f64 = 0.05;
/// Strips that are taken together: roots and quotients of several vectors overlap in time (of 4 strips they take three times as long).
const LANES: usize = 10;

/// The change of slip that gives the lateral force of spin as the linear theory has it, over spin: `L / L3 = 32 c23 sqrt(b/a) / (3 pi c11)`, in powers of ln(a/b), for Poisson's ratios about 0.28
/// and a/b from 0.1 to 10.
const PER_SPIN: [f64; 4] = [1.196, 0.0150, 0.0486, -0.0107];

/// phi' / phi.
pub(super) fn turn_of_slip(a_over_b: f64) -> f64 {
    let x = a_over_b.clamp(0.1, 10.0).ln();
    PER_SPIN[0] + x * (PER_SPIN[1] + x * (PER_SPIN[2] + x * PER_SPIN[3]))
}

/// A strip that slips.
pub(super) struct Slipping {
    /// At its middle, -.
    pub slip: Vector2<f64>,
    /// phi', 1/m.
    pub turn: f64,
    pub half_length: f64,
    /// r, -.
    pub reach: f64,
    /// mu Q, N; less than 0 where what the strip transmits is taken off.
    pub bound: f64,
    /// Its place across, m.
    pub across: f64,
}

/// Sums what strips transmit: forces along and across, moment about the normal.
#[derive(Default)]
pub(super) struct Tractions {
    slip: [[f64; LANES]; 2],
    turn: [f64; LANES],
    reach: [f64; LANES],
    bound: [f64; LANES],
    place: [[f64; LANES]; 2],
    filled: usize,
    sum: Vector3<f64>,
}

impl Tractions {
    #[inline]
    pub fn add(&mut self, strip: &Slipping) {
        let k = self.filled;
        (self.slip[0][k], self.slip[1][k]) = (strip.slip.x, strip.slip.y);
        self.turn[k] = strip.turn * strip.half_length;
        (self.reach[k], self.bound[k]) = (strip.reach, strip.bound);
        (self.place[0][k], self.place[1][k]) = (strip.half_length, strip.across);
        self.filled += 1;
        if self.filled == LANES {
            self.transmit();
        }
    }

    pub fn total(mut self) -> Vector3<f64> {
        // Places that are not taken transmit nothing.
        self.bound[self.filled..].fill(0.0);
        self.transmit();
        self.sum
    }

    #[inline]
    fn transmit(&mut self) {
        const STEP: f64 = 2.0 / PLACES as f64;
        let sticking = 1.0 + (1.0 + ROUND).sqrt();
        let [mut along, mut across, mut ahead] = [[0.0; LANES]; 3];
        let mut forces = [[0.0; LANES]; 2];
        for place in 0..PLACES {
            let xi = 1.0 - (place as f64 + 0.5) * STEP;
            // From the leading edge half a step.
            let (step, middle) = if place == 0 { (0.5 * STEP, 1.0 - 0.25 * STEP) } else { (STEP, xi + 0.5 * STEP) };
            let per_bound = (1.0 - xi * xi).powi(-2);
            for k in 0..LANES {
                let grown = 2.0 * step * self.reach[k];
                let x = along[k] - grown * self.slip[0][k];
                let y = across[k] - grown * (self.slip[1][k] + middle * self.turn[k]);
                let asked = (x * x + y * y) * per_bound;
                let within = (sticking / (1.0 + asked + ((1.0 - asked) * (1.0 - asked) + ROUND).sqrt())).sqrt();
                (along[k], across[k]) = (within * x, within * y);
                forces[0][k] += along[k];
                forces[1][k] += across[k];
                ahead[k] += xi * across[k];
            }
        }
        for k in 0..LANES {
            let own = 0.75 * STEP * self.bound[k];
            let [x, y] = forces.map(|force| own * force[k]);
            self.sum += Vector3::new(x, y, own * self.place[0][k] * ahead[k] - self.place[1][k] * x);
        }
        self.filled = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::creep::kalker::KalkerTable;
    use std::f64::consts::PI;

    fn one(slip: Vector2<f64>, turn: f64, reach: f64) -> Vector3<f64> {
        let mut sum = Tractions::default();
        sum.add(&Slipping { slip, turn, half_length: 1.0, reach, bound: 1.0, across: 0.0 });
        sum.total()
    }

    #[test]
    fn analytic_spin_yields_as_the_linear_theory_says() {
        let table = KalkerTable::new(0.28);
        for ratio in [0.1f64, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0] {
            let c = table.at(ratio);
            let wanted = 32.0 * c.c23 / (3.0 * PI * c.c11 * ratio.sqrt());
            assert!((turn_of_slip(ratio) / wanted - 1.0).abs() < 0.01, "{ratio}: {} {wanted}", turn_of_slip(ratio));
        }
    }

    /// `s(k)` of slip that does not turn, and full sliding across behind the middle and back before it.
    #[test]
    fn analytic_strips_without_turn_and_in_pure_spin() {
        for k in [0.01f64, 0.2, 0.5, 0.8, 1.0, 3.0] {
            let found = one(Vector2::new(0.6, -0.8) * k, 0.0, 1.0);
            let wanted = if k < 1.0 { 1.0 - (1.0 - k).powi(3) } else { 1.0 };
            assert!((found.xy().norm() - wanted).abs() < 0.03 && found.x < 0.0 && found.y > 0.0, "{k}: {found} {wanted}");
        }
        // Little spin: tau = -r phi' (1 - xi^2), all of it within the bound.
        let little = one(Vector2::zeros(), 0.1, 1.0);
        assert!((little.y + 0.1).abs() < 2e-3 && little.x == 0.0, "{little}");
        // Great spin: the traction turns around in the middle, a place late, and the rest of the halves cancels.
        assert!((one(Vector2::zeros(), 1e4, 1.0).y + 0.37).abs() < 0.03);
    }
}
