//! What dry friction holds after its places were moved slowly from one configuration to another, in one go.
//!
//! The law of [`DryFriction`](super::DryFriction) without its memory of time, along a straight way of the places from where no friction acts, while the load that sets
//! the limit changes with the way (`w` from 0 to 1, `d` the way as a vector in the slip axes):
//!
//! ```text
//! dz/dw = d - min(1, |z|/z_c)^p max(0, d . e) e,   |z| <= z_c(w, z)
//! ```
//!
//! With a constant limit and p = 2 this is `z = z_c tanh(|d|/z_c) d/|d|`. A way much longer than z_c is forgotten but for its end: only that is followed.

use nalgebra::Vector2;

/// Where the places of a pair are, as far as its friction is concerned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rub {
    /// From place to place along the slip axes, less what it is in the design configuration, m.
    pub place: Vector2<f64>,
    /// What the limit follows from beside friction itself, N: the normal force, or a wedge's spring force.
    pub load: f64,
}

/// The deflection z [m] at the end of the way; `most(load, z)` is z_c [m], and p the `exponent`.
pub(super) fn dragged(from: &Rub, to: &Rub, exponent: i32, most: impl Fn(f64, &Vector2<f64>) -> f64) -> Vector2<f64> {
    let way = to.place - from.place;
    let power = f64::from(exponent);
    // In parts of z_c: what is followed, where the loss per z_c is exp(-p) and z_c is reached after one or two; and the step.
    let (reach, step) = (2.0 + 16.0 / power, f64::min(0.25, 1.0 / power));
    let first = if way.norm() > 0.0 { f64::max(0.0, 1.0 - reach * most(to.load, &Vector2::zeros()) / way.norm()) } else { 0.0 };
    let steps = (reach / step).ceil();
    let width = (1.0 - first) / steps;
    let bounded = |w: f64, z: Vector2<f64>| {
        let limit = most(from.load + w * (to.load - from.load), &z);
        if z.norm() > limit { z * (limit / z.norm()) } else { z }
    };
    let rate = |w: f64, z: &Vector2<f64>| {
        let (length, limit) = (z.norm(), most(from.load + w * (to.load - from.load), z));
        if length == 0.0 {
            return way;
        }
        let along = z / length;
        let nearness = if length < limit { (length / limit).powi(exponent) } else { 1.0 };
        way - along * (nearness * way.dot(&along).max(0.0))
    };
    let mut z = Vector2::zeros();
    for count in 0..steps as u32 {
        let w = first + f64::from(count) * width;
        let k1 = rate(w, &z);
        let k2 = rate(w + 0.5 * width, &(z + 0.5 * width * k1));
        let k3 = rate(w + 0.5 * width, &(z + 0.5 * width * k2));
        let k4 = rate(w + width, &(z + width * k3));
        z = bounded(w + width, z + width / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4));
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constant limit: z_c tanh(x/z_c) for p = 2 and z_c (1 - exp(-x/z_c)) for p = 1, along the way; far beyond z_c the limit, whatever p is.
    #[test]
    fn analytic_friction_after_one_way_follows_its_closed_form() {
        let limit = 1e-3;
        let direction = Vector2::new(0.6, -0.8);
        let from = Rub { place: Vector2::new(0.2, 0.1), load: 1.0 };
        for parts in [0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 30.0, 1e4] {
            let to = Rub { place: from.place + direction * (parts * limit), ..from };
            for (exponent, wanted) in [(1, 1.0 - f64::exp(-parts)), (2, f64::tanh(parts))] {
                let z = dragged(&from, &to, exponent, |_, _| limit);
                assert!((z - direction * (limit * wanted)).norm() < 2e-5 * limit, "p {exponent}, {parts} z_c: {z:?}");
            }
            for exponent in [4, 16, 64] {
                let z = dragged(&from, &to, exponent, |_, _| limit).norm() / limit;
                let least = f64::min(parts, 1.0) * 0.75;
                assert!(z <= 1.0 + 1e-12 && z >= least && (parts < 5.0 || z > 1.0 - 1e-5), "p {exponent}, {parts} z_c: {z}");
            }
        }
    }

    /// A limit that falls on the way leaves no more than itself; without a limit there is no friction.
    #[test]
    fn analytic_friction_after_one_way_is_never_above_its_limit() {
        let from = Rub { place: Vector2::zeros(), load: 1.0 };
        let to = Rub { place: Vector2::new(4e-3, 0.0), load: 0.25 };
        let z = dragged(&from, &to, 2, |load, _| 1e-3 * load);
        assert!((z.x - 0.25e-3).abs() < 1e-8 && z.y == 0.0, "{z:?}");
        assert_eq!(dragged(&from, &Rub { load: 0.0, ..to }, 2, |load, _| 1e-3 * load), Vector2::zeros());
    }
}
