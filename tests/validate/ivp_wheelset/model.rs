//! The rigid wheelset of the IVP Test Set's problem "Wheelset": geometry of contact, creep, and the terms of the equations of motion.
//!
//! Coordinates q = (x, y, z, theta, phi, beta): position of the centre (x lateral, y up, z along the track, relative to V t), yaw
//! about y, roll, spin relative to Omega t with Omega = V / r0. The axle's frame, which yaws and rolls but does not spin:
//!
//! ```text
//! e1 = (cos theta cos phi, sin phi, -sin theta cos phi)      along the axle
//! e2 = (-cos theta sin phi, cos phi, sin theta sin phi)
//! e3 = (sin theta, 0, cos theta)                             ahead
//! ```
//!
//! **Contact.** A point of the wheel's surface of revolution has the arm `xi e1 - R(xi) (cos psi e2 + sin psi e3)` from the centre.
//! The rail is a cylinder `y = G(x)`. The gap at that point is `g(q; psi, xi) = G(x + arm_x) - y - arm_y`. Tangency:
//! `dg/dpsi = dg/dxi = 0`, which says that the rail's normal is normal to the wheel (the test set states the same as parallel
//! normals). The constraint is `g = 0`. At tangency g does not depend on (psi, xi) to first order, so `g' = J q'` with `J = dg/dq` and
//! `J q'' = gamma = -d^2/dt^2 g(q + q' t; psi + psi' t, xi + xi' t)`: exact from second-order dual numbers, with (psi', xi') from the
//! derivative of tangency.
//!
//! **Motion.** Kinetic energy
//! `m/2 (x'^2 + y'^2 + z'^2) + I2/2 (theta'^2 cos^2 phi + phi'^2) + I1/2 (Omega + beta' + theta' sin phi)^2`; gravity, two lateral
//! and two longitudinal springs, and the contacts' forces by virtual work. With `M q'' = Q - J^T lambda` the normal force is
//! `N = lambda sqrt(1 + G'^2)`; the test set's multipliers are `-lambda`. The test set writes moments about e1, e2, e3; there the yaw
//! moment of the constraint lacks a factor `1 / cos phi`, which changes accelerations by parts in 1e9. The springs' moment acts
//! about y on the spinning body, as in the test set, so it has a part `sin phi` about the axle; bearings would not transmit it.
//!
//! **Creep.** Creepages from the velocity of the wheel's material point at the contact, relative to the mean rolling velocity; linear
//! forces after Kalker for an ellipse of fixed shape whose size follows N, each component limited to `mu N tanh(F / (mu N))`, then
//! the pair to mu N. As in the test set, the contact plane (slope angle delta) is yawed by theta / cos delta.
//!
//! Sources: B. Simeon, C. Fuhrer, P. Rentrop, Surv. Math. Ind. 1 (1991) 1-37; the test set's problem "Wheelset".

use nalgebra::{Matrix2, Matrix6, Vector2, Vector3, Vector6};
use num_dual::{Dual2_64, Dual64, DualNum};
use toml_edit::Table;
use wheelrail::math::newton::{self, NewtonFailure, NewtonLimits};

/// Units are given with the data.
#[derive(Clone, Debug)]
pub struct Wheelset {
    mass: f64,
    gravity: f64,
    speed: f64,
    nominal_radius: f64,
    spin_inertia: f64,
    cross_inertia: f64,
    friction: f64,
    half_width: f64,
    lateral_stiffness: f64,
    longitudinal_stiffness: f64,
    cone: f64,
    half_gauge: f64,
    rail_radius: f64,
    rail_centre: Vector2<f64>,
    shear_modulus: f64,
    /// Cube of the ellipse's size over `N / (A + B)`, m2/N.
    ellipse: f64,
    kalker: [f64; 3],
}

/// What a contact depends on: x, theta, phi, psi, xi.
type Place<D> = [D; 5];

/// One contact of a known position.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// g, m.
    pub gap: f64,
    /// dg/dq.
    pub row: Vector6<f64>,
    radius: f64,
    rail_slope: f64,
    rail_curvature: f64,
    /// Velocity of the material point per unit of theta', phi', beta', m.
    levers: [Vector3<f64>; 3],
}

/// What the creep forces of a contact need beside the normal force.
#[derive(Clone, Copy, Debug)]
pub struct Rolling {
    /// Longitudinal and lateral creepage, spin creepage (1/m).
    creepage: Vector3<f64>,
    /// Cube of the ellipse's size over N, m3/N.
    ellipse: f64,
    /// Generalised forces of a unit force along and across.
    along: Vector6<f64>,
    across: Vector6<f64>,
}

impl Wheelset {
    pub fn new(parameters: &Table) -> Self {
        let number = |key: &str| parameters[key].as_float().unwrap_or_else(|| panic!("parameter {key} is missing"));
        let (angle, rail_radius) = (number("cone_angle"), number("rail_radius"));
        Wheelset {
            mass: number("mass"),
            gravity: number("gravity"),
            speed: number("speed"),
            nominal_radius: number("nominal_radius"),
            spin_inertia: number("spin_inertia"),
            cross_inertia: number("cross_inertia"),
            friction: number("friction"),
            half_width: number("half_width"),
            lateral_stiffness: number("lateral_stiffness"),
            longitudinal_stiffness: number("longitudinal_stiffness"),
            cone: angle.tan(),
            half_gauge: number("half_gauge"),
            rail_radius,
            rail_centre: Vector2::new(
                number("half_gauge") + rail_radius * angle.sin(),
                -number("nominal_radius") - rail_radius * angle.cos(),
            ),
            shear_modulus: number("shear_modulus"),
            ellipse: 3.0 * (1.0 - number("poisson")) * number("ellipse_e")
                / (2.0 * number("pi") * number("shear_modulus") * number("ellipse_g").sqrt()),
            kalker: [number("c11"), number("c22"), number("c23")],
        }
    }

    /// Radius of the wheel and its derivative.
    fn wheel<D: DualNum<Primitive = f64> + Copy>(&self, xi: D) -> (D, f64) {
        let slope = if xi > 0.0 { -self.cone } else { self.cone };
        (xi * slope + self.nominal_radius + self.cone * self.half_gauge, slope)
    }

    /// Height of the rail, its slope and second derivative.
    fn rail<D: DualNum<Primitive = f64> + Copy>(&self, x: D) -> (D, D, D) {
        let from_centre = if x > 0.0 { x - self.rail_centre.x } else { x + self.rail_centre.x };
        let height = (-from_centre * from_centre + self.rail_radius * self.rail_radius).sqrt();
        let second = -height.powi(-3) * (self.rail_radius * self.rail_radius);
        (height + self.rail_centre.y, -from_centre / height, second)
    }

    /// The gap without -y.
    fn gap<D: DualNum<Primitive = f64> + Copy>(&self, [x, theta, phi, psi, xi]: Place<D>) -> D {
        let (frame, (radius, _)) = (frame(theta, phi), self.wheel(xi));
        let arm = |i| arm(&frame, radius, psi, xi, i);
        self.rail(x + arm(0)).0 - arm(1)
    }

    /// dg/dpsi, dg/dxi.
    fn tangency<D: DualNum<Primitive = f64> + Copy>(&self, [x, theta, phi, psi, xi]: Place<D>) -> [D; 2] {
        let ([e1, e2, e3], (radius, cone)) = (frame(theta, phi), self.wheel(xi));
        let (sin, cos) = psi.sin_cos();
        let by_psi = |i: usize| radius * (e2[i] * sin - e3[i] * cos);
        let by_xi = |i: usize| e1[i] - (e2[i] * cos + e3[i] * sin) * cone;
        let (_, slope, _) = self.rail(x + arm(&[e1, e2, e3], radius, psi, xi, 0));
        [slope * by_psi(0) - by_psi(1), slope * by_xi(0) - by_xi(1)]
    }

    /// Derivative of tangency in a direction.
    fn tangency_along(&self, place: &Place<f64>, direction: &Place<f64>) -> Vector2<f64> {
        self.tangency(std::array::from_fn(|i| Dual64::new(place[i], direction[i]))).map(|dual| dual.eps).into()
    }

    fn tangency_jacobian(&self, place: &Place<f64>) -> Matrix2<f64> {
        let column = |direction| self.tangency_along(place, &direction);
        Matrix2::from_columns(&[column([0.0, 0.0, 0.0, 1.0, 0.0]), column([0.0, 0.0, 0.0, 0.0, 1.0])])
    }

    /// Moves (psi, xi) to the point of tangency.
    ///
    /// # Errors
    /// [`NewtonFailure`] when there is none near the start.
    pub fn find_contact(&self, q: &Vector6<f64>, contact: &mut Vector2<f64>) -> Result<(), NewtonFailure> {
        let limits = NewtonLimits { next_step: 1e-14, iterations: 20, rounding: 0.0 };
        let evaluate = |contact: &Vector2<f64>| (self.tangency(place(q, contact)).into(), ());
        newton::solve(contact, limits, evaluate, |contact, ()| self.tangency_jacobian(&place(q, contact)))?;
        Ok(())
    }

    pub fn touch(&self, q: &Vector6<f64>, contact: &Vector2<f64>) -> Touch {
        let [x, theta, phi, psi, xi] = place(q, contact);
        let ([e1, e2, e3], (radius, _)) = (frame(theta, phi), self.wheel(xi));
        let arm = Vector3::from_fn(|i, _| arm(&[e1, e2, e3], radius, psi, xi, i));
        let (height, rail_slope, rail_curvature) = self.rail(x + arm.x);
        let levers = levers(&[e1, e2, e3], &arm);
        let by = |direction: &Vector3<f64>| rail_slope * direction.x - direction.y;
        Touch {
            gap: height - q[1] - arm.y,
            // Spin moves the wheel's surface along itself.
            row: Vector6::new(rail_slope, -1.0, 0.0, by(&levers[0]), by(&levers[1]), 0.0),
            radius,
            rail_slope,
            rail_curvature,
            levers,
        }
    }

    /// Right-hand side of the constraint on accelerations, m/s2. `None` where the contact point is not unique.
    pub fn gamma(&self, q: &Vector6<f64>, v: &Vector6<f64>, contact: &Vector2<f64>) -> Option<f64> {
        let place = place(q, contact);
        let body = [v[0], v[3], v[4], 0.0, 0.0];
        let speed = -self.tangency_jacobian(&place).try_inverse()? * self.tangency_along(&place, &body);
        let direction = [v[0], v[3], v[4], speed.x, speed.y];
        Some(-self.gap(std::array::from_fn(|i| Dual2_64::new(place[i], direction[i], 0.0))).v2)
    }

    /// Inverse of the mass matrix.
    pub fn mobility(&self, phi: f64) -> Matrix6<f64> {
        let (sin, cos) = phi.sin_cos();
        let yaw = 1.0 / (self.cross_inertia * cos * cos);
        let mut mobility = Matrix6::from_diagonal(&Vector6::new(
            1.0 / self.mass,
            1.0 / self.mass,
            1.0 / self.mass,
            yaw,
            1.0 / self.cross_inertia,
            1.0 / self.spin_inertia + sin * sin * yaw,
        ));
        (mobility[(3, 5)], mobility[(5, 3)]) = (-sin * yaw, -sin * yaw);
        mobility
    }

    /// Generalised forces without contacts, gyroscopic terms included.
    pub fn applied(&self, q: &Vector6<f64>, v: &Vector6<f64>) -> Vector6<f64> {
        let (sin, cos) = q[4].sin_cos();
        let spin = self.spin(v);
        let axial = self.spin_inertia * (spin + v[3] * sin);
        let change = self.cross_inertia * v[3] * cos * sin;
        let springs = -2.0 * self.half_width.powi(2) * self.longitudinal_stiffness * q[3];
        Vector6::new(
            -2.0 * self.lateral_stiffness * q[0],
            -self.mass * self.gravity,
            -2.0 * self.longitudinal_stiffness * q[2],
            springs + 2.0 * change * v[4] - axial * v[4] * cos - self.spin_inertia * v[3] * v[4] * cos * sin,
            axial * v[3] * cos - change * v[3],
            springs * sin - self.spin_inertia * v[3] * v[4] * cos,
        )
    }

    fn spin(&self, v: &Vector6<f64>) -> f64 {
        self.speed / self.nominal_radius + v[5]
    }

    /// Creepages and directions of a contact.
    pub fn rolling(&self, q: &Vector6<f64>, v: &Vector6<f64>, contact: &Vector2<f64>, touch: &Touch) -> Rolling {
        let delta = touch.rail_slope.atan();
        let (sin, cos) = delta.sin_cos();
        let [psi, xi] = [contact.x, contact.y];
        // The contact plane's own yaw.
        let frame = frame(q[3] / cos, q[4]);
        let arm = Vector3::from_fn(|i, _| arm(&frame, touch.radius, psi, xi, i));
        let [by_yaw, by_roll, by_spin] = levers(&frame, &arm);
        let centre = Vector3::new(v[0], v[1], self.speed + v[2]);
        let turning = by_yaw * v[3] + by_roll * v[4] + by_spin * self.spin(v);
        let sliding = centre + turning;
        let rolling = 0.5 * (centre - turning).norm();

        let along = Vector3::from(frame[2]);
        let across = Vector3::new(cos * along.z, sin, -cos * along.x);
        let spin = cos * v[3] - sin * self.spin(v);
        let force = |direction: &Vector3<f64>| {
            let moment = touch.levers.map(|lever| lever.dot(direction));
            Vector6::new(direction.x, direction.y, direction.z, moment[0], moment[1], moment[2])
        };
        // Sum of half the curvatures of wheel (a cone) and rail, each normal to its surface.
        let wheel = 0.5 / (touch.radius * (1.0 + self.cone * self.cone).sqrt());
        let rail = -0.5 * touch.rail_curvature * cos.powi(3);
        Rolling {
            creepage: Vector3::new(along.dot(&sliding), across.dot(&sliding), spin) / rolling,
            ellipse: self.ellipse / (wheel + rail),
            along: force(&along),
            across: force(&across),
        }
    }

    /// Generalised creep force at the normal force that belongs to the multiplier.
    pub fn creep(&self, rolling: &Rolling, touch: &Touch, multiplier: f64) -> Vector6<f64> {
        let normal = multiplier * (1.0 + touch.rail_slope * touch.rail_slope).sqrt();
        let size = (rolling.ellipse * normal.abs()).cbrt();
        let [c11, c22, c23] = self.kalker;
        let stiffness = self.shear_modulus * size * size;
        let limit = self.friction * normal;
        let along = -limit * (stiffness * c11 * rolling.creepage.x / limit).tanh();
        let across = -limit * (stiffness * (c22 * rolling.creepage.y + size * c23 * rolling.creepage.z) / limit).tanh();
        let scale = (limit.abs() / along.hypot(across)).min(1.0);
        (rolling.along * along + rolling.across * across) * scale
    }
}

fn place(q: &Vector6<f64>, contact: &Vector2<f64>) -> Place<f64> {
    [q[0], q[3], q[4], contact.x, contact.y]
}

/// e1, e2, e3.
fn frame<D: DualNum + Copy>(theta: D, phi: D) -> [[D; 3]; 3] {
    let ((sin, cos), (rise, level)) = (theta.sin_cos(), phi.sin_cos());
    [[cos * level, rise, -sin * level], [-cos * rise, level, sin * rise], [sin, D::zero(), cos]]
}

/// Component of the arm from the centre to a point of the wheel.
fn arm<D: DualNum + Copy>([e1, e2, e3]: &[[D; 3]; 3], radius: D, psi: D, xi: D, i: usize) -> D {
    xi * e1[i] - radius * (e2[i] * psi.cos() + e3[i] * psi.sin())
}

/// Velocity at an arm per unit of theta', phi', beta'.
fn levers([e1, _, e3]: &[[f64; 3]; 3], arm: &Vector3<f64>) -> [Vector3<f64>; 3] {
    [Vector3::y().cross(arm), Vector3::from(*e3).cross(arm), Vector3::from(*e1).cross(arm)]
}
