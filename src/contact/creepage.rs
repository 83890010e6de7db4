//! Creepages of the wheel's material point at the contact.
//!
//! `xi_x = v . e1 / V`, `xi_y = v . e2 / V` [-], `phi = w . n / V` [1/m] with the wheel's velocity v at the
//! contact point, its angular velocity w, e1 the rail's tangent forward, n the rail's normal (up, out of the
//! rail), e2 = n x e1 (left), and V > 0 the size of the travelling speed. `xi_x > 0`: the wheel slips forward.

use nalgebra::Vector3;

/// Longitudinal, lateral [-] and spin [1/m] creepage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Creepage {
    pub longitudinal: f64,
    pub lateral: f64,
    pub spin: f64,
}

/// Velocity of the wheel's material point at the contact along e1 and e2 [m/s] and angular velocity about n [rad/s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slip {
    pub longitudinal: f64,
    pub lateral: f64,
    pub spin: f64,
}

impl Slip {
    /// Creepages of a wheelset that travels with `speed` [m/s], not zero.
    #[inline]
    pub fn creepage(&self, speed: f64) -> Creepage {
        let per_speed = 1.0 / speed.abs();
        Creepage { longitudinal: self.longitudinal * per_speed, lateral: self.lateral * per_speed, spin: self.spin * per_speed }
    }
}

/// Tangential force on the wheel along e1, e2 [N] and moment about n [N m].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CreepForce {
    pub longitudinal: f64,
    pub lateral: f64,
    pub spin_moment: f64,
}

/// Axes of the contact plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactAxes {
    pub e1: Vector3<f64>,
    pub e2: Vector3<f64>,
    pub normal: Vector3<f64>,
}

impl ContactAxes {
    /// From the rail's unit normal and its forward tangent (any length, perpendicular to the normal).
    pub fn new(normal: Vector3<f64>, forward: Vector3<f64>) -> Self {
        let e1 = forward.normalize();
        ContactAxes { e1, e2: normal.cross(&e1), normal }
    }

    /// Those of a wheel that rolls with this speed, m/s: ahead is where it rolls to.
    pub fn rolling(&self, speed: f64) -> Self {
        let sign = direction(speed);
        ContactAxes { e1: self.e1 * sign, e2: self.e2 * sign, normal: self.normal }
    }

    /// Slip of a point that moves with `velocity` [m/s] on a body that turns with `angular_velocity` [rad/s].
    #[inline]
    pub fn slip(&self, velocity: &Vector3<f64>, angular_velocity: &Vector3<f64>) -> Slip {
        Slip { longitudinal: velocity.dot(&self.e1), lateral: velocity.dot(&self.e2), spin: angular_velocity.dot(&self.normal) }
    }
}

fn direction(speed: f64) -> f64 {
    if speed < 0.0 { -1.0 } else { 1.0 }
}

/// Calls a creep law that is written for rolling along +e1 in the frame of the actual rolling direction.
///
/// Rolling backward the leading edge lies at -e1: the law is called in axes turned by 180 degrees about n, in
/// which in-plane vectors change sign and spin and moment do not.
pub fn in_rolling_direction(speed: f64, creepage: Creepage, law: impl FnOnce(Creepage) -> CreepForce) -> CreepForce {
    let sign = direction(speed);
    let turned = Creepage { longitudinal: sign * creepage.longitudinal, lateral: sign * creepage.lateral, spin: creepage.spin };
    let force = law(turned);
    CreepForce { longitudinal: sign * force.longitudinal, lateral: sign * force.lateral, spin_moment: force.spin_moment }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_rolling_backward_flips_only_the_spin_coupling() {
        let law = |c: Creepage| CreepForce {
            longitudinal: -c.longitudinal,
            lateral: -c.lateral - 0.3 * c.spin,
            spin_moment: 0.3 * c.lateral - c.spin,
        };
        let creepage = Creepage { longitudinal: 1.0, lateral: 2.0, spin: 3.0 };
        let forward = in_rolling_direction(10.0, creepage, law);
        let backward = in_rolling_direction(-10.0, creepage, law);
        assert_eq!(forward.longitudinal, backward.longitudinal);
        assert!((forward.lateral + 2.0 + 0.9).abs() < 1e-15 && (backward.lateral + 2.0 - 0.9).abs() < 1e-15);
        assert!((forward.spin_moment - (0.6 - 3.0)).abs() < 1e-15 && (backward.spin_moment - (-0.6 - 3.0)).abs() < 1e-15);
    }

    #[test]
    fn analytic_axes_are_right_handed_and_point_left() {
        let axes = ContactAxes::new(Vector3::z(), Vector3::new(2.0, 0.0, 0.0));
        assert_eq!(axes.e2, Vector3::y());
        let creepage = axes.slip(&Vector3::new(0.4, -0.2, 0.0), &Vector3::new(0.0, 90.0, 1.0)).creepage(-20.0);
        assert!((creepage.longitudinal - 0.02).abs() < 1e-16 && (creepage.lateral + 0.01).abs() < 1e-16 && creepage.spin == 0.05);
    }
}
