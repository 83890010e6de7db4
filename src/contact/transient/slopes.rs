//! Derivatives of the transient contact, for implicit integration.
//!
//! With `g(v, lambda, u) = (v - lambda u) / D(lambda)` and `P = v . u`, `S = sum(u_i^2 / L_i)`, `sliding = alpha P / S` of the parent
//! module, all in closed form:
//!
//! ```text
//! dg/dlambda  = -u / D - (v - lambda u) T^2 lambda / D^3,            d lambda_i = d sliding / L_i
//! d sliding   = alpha (u . dv) / S + (alpha v . du + P d alpha) / S - alpha P dS / S^2      where P > 0, else 0
//! d zeta_i    = w s (du_i + tau du_i') / L_i + w ds (u_i + tau u_i') / L_i + (1 - w) dv_i / |V|,   ds by k |u| and by N (k |u| over mu N falls by two thirds as N grows)
//! d phi'      = lag (d omega_n / V - d phi)
//! d F         = dF/d zeta . d zeta + dF/d spin (w d phi + (1 - w) d omega_n / V) + (dF/dN along a growing patch) dN
//! ```
//!
//! The rolling speed, the direction p and the patch are held in the rates; left out is what is of the order of the creepage
//! (1e-3 to 1e-2) against d v. With N the lengths L grow with the patch, like its cube root.

use super::{Elasticity, LoadedPatch, SLIDE_WIDTH, STATES, SlipVelocity, TransientContact, ahead, held, law_speed};
use crate::contact::creep::slopes::CreepSlopes;
use crate::contact::creep::{CreepLaw, RollingContact};
use crate::contact::creepage::Creepage;
use crate::math::smooth_step::cubic_step;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Derivatives of force and rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransientSlopes {
    /// Force along e1, e2 and moment about n by slip velocities along e1, e2 [m/s] and spin [rad/s].
    pub force_by_slip: Matrix3<f64>,
    /// The same by the deflections, 1/m, and by the rolled-in spin, m.
    pub force_by_state: Matrix3<f64>,
    /// The same by the normal force, -.
    pub force_by_normal_force: Vector3<f64>,
    /// u' by slip velocity, -.
    pub rate_by_slip: Matrix2<f64>,
    /// u' by u, 1/s.
    pub rate_by_deflection: Matrix2<f64>,
    /// p' by p, 1/s.
    pub direction_rate: f64,
    /// phi' by phi, 1/s, and by the spin velocity, 1/m.
    pub spin_rate: f64,
    pub spin_rate_by_spin: f64,
}

/// Rates of the deflection with their derivatives.
struct Deflection {
    rates: Vector2<f64>,
    by_slip: Matrix2<f64>,
    by_deflection: Matrix2<f64>,
    /// V_r of the parent module: |V| psi + sliding, m/s.
    relaxing: f64,
    /// Over s, as its slopes.
    sliding: f64,
    /// s, its slopes by u, 1/m, and that by k |u| over the load at which sliding begins, with that ratio.
    stretch: f64,
    stretch_by_deflection: Vector2<f64>,
    stretch_by_share: [f64; 2],
    sliding_by_slip: Vector2<f64>,
    sliding_by_deflection: Vector2<f64>,
}

/// How far a contact has gone towards sliding: thresholds of k |u|, N.
struct Range {
    from: f64,
    full: f64,
}

impl TransientContact {
    /// Derivatives at the same place as [`TransientContact::evaluate`].
    pub fn slopes(&self, law: &dyn CreepLaw, contact: &LoadedPatch, slip: &SlipVelocity, state: &[f64; STATES]) -> TransientSlopes {
        let mut found = self.pressed_slopes(law, contact, slip, state);
        let held = held(contact);
        if held < 1.0 {
            let fading = (1.0 - held) * self.fading(slip.rolling);
            found.rate_by_slip *= held;
            found.rate_by_deflection = found.rate_by_deflection * held - Matrix2::identity() * fading;
            found.direction_rate = held * found.direction_rate - fading;
            found.spin_rate = held * found.spin_rate - fading;
            found.spin_rate_by_spin *= held;
        }
        found
    }

    /// The same of a contact that is pressed in earnest.
    fn pressed_slopes(&self, law: &dyn CreepLaw, contact: &LoadedPatch, slip: &SlipVelocity, state: &[f64; STATES]) -> TransientSlopes {
        let (lively, fading) = (self.liveliness(slip.rolling.abs()), self.fading(slip.rolling));
        let Some(elastic) = self.relaxation.of(contact.patch).filter(|_| contact.normal_force > 0.0) else {
            let by_deflection = Matrix2::identity() * -fading;
            let (direction_rate, spin_rate) = (-fading, -fading);
            return TransientSlopes { rate_by_deflection: by_deflection, direction_rate, spin_rate, ..TransientSlopes::default() };
        };
        let (speed, inverse, turn) = (slip.rolling.abs(), self.inverse_speed(slip.rolling), self.smooth_sign(slip.rolling));
        let spin_ratio = slip.spin * inverse;
        let way = 0.5 * contact.patch.a;
        let direction_rate = -lively * speed / way / (1.0 + (self.settings.time_floor * speed / way).powi(2)).sqrt();
        let spin_lag = lively * self.spin_lag(contact, slip, state[2]);
        let rolled =
            TransientSlopes { direction_rate, spin_rate: -spin_lag, spin_rate_by_spin: spin_lag * inverse, ..TransientSlopes::default() };
        if !self.holds(contact) {
            return TransientSlopes { rate_by_deflection: Matrix2::identity() * -fading, ..rolled };
        }
        let weight = self.transient_weight(speed);
        let (rolled_spin, direct_spin) = (weight * state[3], (1.0 - weight) * spin_ratio);
        let from = self.sliding_load(contact, &elastic, rolled_spin + direct_spin);
        let deflection = self.deflection(&elastic, &Range { from, full: SLIDE_WIDTH * from }, slip, state);
        let Deflection { rates, by_slip, by_deflection, relaxing, sliding, stretch, stretch_by_deflection, stretch_by_share, .. } =
            deflection;

        let tau = self.settings.damping_time;
        let per_length = Vector2::from(elastic.length).map(|length| weight / length);
        let (u, v) = (Vector2::new(state[0], state[1]), Vector2::new(slip.longitudinal, slip.lateral));
        let direct = if weight == 1.0 { 0.0 } else { (1.0 - weight) / speed };
        let plain = (u + rates * tau).component_div(&Vector2::from(elastic.length));
        let zeta = plain * stretch;
        let deflected = zeta * weight;
        let [left, left_by_sliding] = self.spin_left(speed, sliding);
        let creepage = deflected + v * direct;
        let loaded = RollingContact {
            patch: contact.patch,
            normal_force: contact.normal_force,
            friction: contact.friction,
            creepage: Creepage { longitudinal: creepage.x, lateral: creepage.y, spin: direct_spin + left * rolled_spin },
            speed: law_speed(weight, zeta.norm(), slip, relaxing),
        };
        let CreepSlopes { by_creepage, by_normal_force } = law.slopes(&loaded, &law.force(&loaded));
        let turned = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, turn));
        let by_creepage = turned * by_creepage;
        let scaled = Matrix2::from_diagonal(&per_length) * stretch;
        let mut creepage_by_slip = Matrix3::zeros();
        let in_plane = scaled * by_slip * tau + Matrix2::identity() * direct;
        creepage_by_slip.fixed_view_mut::<2, 2>(0, 0).copy_from(&in_plane);
        creepage_by_slip[(2, 2)] = inverse * (1.0 - weight);
        let mut creepage_by_state = Matrix3::zeros();
        let in_plane = scaled * (Matrix2::identity() + by_deflection * tau) + plain * stretch_by_deflection.transpose() * weight;
        creepage_by_state.fixed_view_mut::<2, 2>(0, 0).copy_from(&in_plane);
        creepage_by_state[(2, 2)] = weight * left;
        if sliding > 0.0 {
            let by_sliding = rolled_spin * left_by_sliding;
            for j in 0..2 {
                creepage_by_slip[(2, j)] = by_sliding * deflection.sliding_by_slip[j];
                creepage_by_state[(2, j)] = by_sliding * deflection.sliding_by_deflection[j];
            }
        }
        let in_plane = by_creepage.fixed_columns::<2>(0).into_owned();
        let [by_share, share] = stretch_by_share;
        TransientSlopes {
            force_by_slip: by_creepage * creepage_by_slip,
            force_by_state: by_creepage * creepage_by_state,
            force_by_normal_force: turned * by_normal_force
                - in_plane * (deflected / 3.0 + plain * (weight * share * by_share / 1.5)) / contact.normal_force,
            rate_by_slip: by_slip * lively,
            rate_by_deflection: by_deflection * lively,
            ..rolled
        }
    }

    fn deflection(&self, elastic: &Elasticity, range: &Range, slip: &SlipVelocity, state: &[f64; STATES]) -> Deflection {
        let floor = self.settings.time_floor;
        let (u, v) = (Vector2::new(state[0], state[1]), Vector2::new(slip.longitudinal, slip.lateral));
        let lengths = Vector2::from(elastic.length);
        let size = u.norm();
        let load = elastic.stiffness * size;
        // d(k |u|) / du.
        let load_by_u = if size > 0.0 { u * (elastic.stiffness / size) } else { Vector2::zeros() };
        let (alpha, by_load) = if load > range.from {
            let x = ((load - range.from) / (range.full - range.from)).min(1.0);
            (cubic_step(x), 6.0 * x * (1.0 - x) / (range.full - range.from))
        } else {
            (0.0, 0.0)
        };
        let power = v.dot(&u);
        let stored = u.component_mul(&u).component_div(&lengths).sum().max(1e-60);
        let (mut sliding, mut by_v, mut by_u) = (0.0, Vector2::zeros(), Vector2::zeros());
        if alpha > 0.0 && power > 0.0 {
            sliding = alpha * power / stored;
            by_v = u * (alpha / stored);
            by_u = v * (alpha / stored) + load_by_u * (by_load * power / stored) - u.component_div(&lengths) * (2.0 * sliding / stored);
        }
        let (excess, excess_by_u) =
            if load > range.full { (1.0 - range.full / load, load_by_u * (range.full / (load * load))) } else { (0.0, Vector2::zeros()) };
        let share = load / range.from;
        let (stretch, by_share) = self.stretched(load, range.from);
        let stretch_by_u = load_by_u * (by_share / range.from);
        let (ahead, whole) = (ahead(slip, state[2]), sliding);
        sliding = whole / stretch;
        let relaxing = ahead + sliding;
        let mut found = Deflection {
            rates: Vector2::zeros(),
            by_slip: Matrix2::zeros(),
            by_deflection: Matrix2::zeros(),
            relaxing,
            sliding,
            sliding_by_slip: by_v / stretch,
            sliding_by_deflection: by_u / stretch - stretch_by_u * (sliding / stretch),
            stretch,
            stretch_by_deflection: stretch_by_u,
            stretch_by_share: [by_share, share],
        };
        for i in 0..2 {
            let lambda = stretch * relaxing / lengths[i];
            let d = (1.0 + (floor * lambda).powi(2)).sqrt();
            let own = v[i] - lambda * u[i];
            let by_lambda = -u[i] / d - own * floor * floor * lambda / (d * d * d);
            found.rates[i] = own / d - excess * u[i] / floor;
            for j in 0..2 {
                found.by_slip[(i, j)] = by_lambda * by_v[j] / lengths[i];
                found.by_deflection[(i, j)] = by_lambda * (by_u[j] + ahead * stretch_by_u[j]) / lengths[i] - excess_by_u[j] * u[i] / floor;
            }
            found.by_slip[(i, i)] += 1.0 / d;
            found.by_deflection[(i, i)] -= lambda / d + excess / floor;
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::{STRETCH_FROM, TransientSettings};
    use super::*;
    use crate::contact::creep::inline;
    use crate::contact::{Material, Patch};

    #[test]
    fn analytic_slopes_match_differences_in_stick_slip_rolling_and_blending() {
        slopes_match("shen_hedrick_elkins");
        // From 0.3 of its range on a deflection counts for more.
        slopes_match("polach{surface=\"wet\", friction_ratio=1.0}");
    }

    fn slopes_match(name: &str) {
        let material = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };
        let law = inline::law(name, "test").unwrap()(material);
        // Polach's own slopes are differences.
        let near = if name.starts_with("polach") { 3e-3 } else { 1e-4 };
        let settings = TransientSettings { below: 2.0, time_floor: 2e-3, damping_time: 5e-5 };
        let transient = TransientContact::new(settings, material, law.as_ref());
        let loaded = LoadedPatch { patch: Patch { a: 6e-3, b: 4e-3 }, normal_force: 6e4, friction: 0.3 };
        let elastic = transient.elasticity(loaded.patch).unwrap();
        let [from, full] = transient.sliding_range().map(|r| r * 0.3 * 6e4 / elastic.stiffness);
        // Speed, slip velocities, deflection over the one at which sliding begins; between beginning and full sliding; beyond.
        let cases = [
            (0.0, [1e-4, -2e-4, 0.01], [0.3, 0.2]),
            (0.3, [1e-3, -2e-3, 0.02], [0.3, -0.4]),
            (0.4, [2e-3, 1e-3, 0.02], [0.5, 0.4]),
            (1.4, [1e-3, 2e-3, 0.02], [0.1, 0.2]),
            (0.2, [3e-3, 2e-3, 0.01], [0.8, 0.75]),
            (0.0, [3e-3, 2e-3, 0.0], [1.1, 0.9]),
            (3.0, [3e-3, 2e-3, 0.1], [0.2, -0.1]),
        ];
        assert!(full > from);
        for (rolling, v, u) in cases {
            let slip = |d: [f64; 3]| SlipVelocity { longitudinal: v[0] + d[0], lateral: v[1] + d[1], spin: v[2] + d[2], rolling };
            let state = |d: [f64; 3]| [from * u[0] + d[0], from * u[1] + d[1], 0.6, 0.05 + d[2]];
            let evaluate = |dv: [f64; 3], du: [f64; 3], dn: f64| {
                let growth = (1.0 + dn / loaded.normal_force).cbrt();
                let patch = Patch { a: growth * loaded.patch.a, b: growth * loaded.patch.b };
                let loaded = LoadedPatch { patch, normal_force: loaded.normal_force + dn, ..loaded };
                let found = transient.evaluate(law.as_ref(), &loaded, &slip(dv), &state(du));
                (Vector3::new(found.force.longitudinal, found.force.lateral, found.force.spin_moment), found.rates)
            };
            let slopes = transient.slopes(law.as_ref(), &loaded, &slip([0.0; 3]), &state([0.0; 3]));
            let sliding = u[0].hypot(u[1]) > 1.0;
            for j in 0..3 {
                let h = 1e-6;
                let d = |sign: f64| std::array::from_fn(|i| if i == j { sign * h } else { 0.0 });
                let (ahead, behind) = (evaluate(d(1.0), [0.0; 3], 0.0), evaluate(d(-1.0), [0.0; 3], 0.0));
                let (found, exact) = ((ahead.0 - behind.0) / (2.0 * h), slopes.force_by_slip.column(j).into_owned());
                // Spin also moves the bound of sliding, which is left out.
                if !(sliding && j == 2) {
                    let allowed = if sliding { 0.02 } else { near };
                    assert!((found - exact).norm() <= allowed * exact.norm() + 1e-3, "{u:?}: force by slip {j}: {found} {exact}");
                }
                let rate = |i: usize| (ahead.1[i] - behind.1[i]) / (2.0 * h);
                if j < 2 {
                    for i in 0..2 {
                        assert!((rate(i) - slopes.rate_by_slip[(i, j)]).abs() < 1e-6, "{} {}", rate(i), slopes.rate_by_slip);
                    }
                } else {
                    assert!((rate(3) - slopes.spin_rate_by_spin).abs() < 1e-6 * (1.0 + slopes.spin_rate_by_spin.abs()), "{}", rate(3));
                }
            }
            for j in 0..3 {
                let h = if j < 2 { 1e-6 * from } else { 1e-6 };
                let d = |sign: f64| std::array::from_fn(|i| if i == j { sign * h } else { 0.0 });
                let (ahead, behind) = (evaluate([0.0; 3], d(1.0), 0.0), evaluate([0.0; 3], d(-1.0), 0.0));
                let (found, exact) = ((ahead.0 - behind.0) / (2.0 * h), slopes.force_by_state.column(j).into_owned());
                if j == 2 {
                    let rate = (ahead.1[3] - behind.1[3]) / (2.0 * h);
                    assert!((rate - slopes.spin_rate).abs() < 1e-6 * (1.0 + slopes.spin_rate.abs()), "{rate} {}", slopes.spin_rate);
                    // While it slides, or counts for more, spin also moves the bound of sliding, which is left out.
                    let bent = sliding || transient.stretch > 1.0 && u[0].hypot(u[1]) > STRETCH_FROM;
                    assert!(bent || (found - exact).norm() <= near * exact.norm() + 1e-3, "force by spin: {found} {exact}");
                    continue;
                }
                let allowed = if sliding { 0.05 } else { near };
                let scale = slopes.force_by_state.fixed_columns::<2>(0).norm();
                assert!((found - exact).norm() <= allowed * scale + 1.0, "force by deflection {j}: {found} {exact}");
                for i in 0..2 {
                    let found = (ahead.1[i] - behind.1[i]) / (2.0 * h);
                    let exact = slopes.rate_by_deflection[(i, j)];
                    assert!((found - exact).abs() < 1e-5 * slopes.rate_by_deflection.norm() + 1e-6, "{found} {exact}");
                }
            }
            if !sliding {
                let h = 1.0;
                let (ahead, behind) = (evaluate([0.0; 3], [0.0; 3], h), evaluate([0.0; 3], [0.0; 3], -h));
                let (found, exact) = ((ahead.0 - behind.0) / (2.0 * h), slopes.force_by_normal_force);
                // The rates' own change with the load is left out: it comes in by the damping time.
                assert!((found - exact).norm() < 1e-2 * exact.norm() + 1e-4, "force by load: {found} {exact}");
            }
        }
    }

    /// Without friction nothing presses sideways and nothing is held, at rest and rolling; the slopes are those of that.
    #[test]
    fn hard_without_friction_no_force_and_finite_slopes() {
        let material = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };
        for law in ["polach", "shen_hedrick_elkins", "fastsim"] {
            let law = inline::law(law, "test").unwrap()(material);
            let settings = TransientSettings { below: 2.0, time_floor: 2e-3, damping_time: 5e-5 };
            let transient = TransientContact::new(settings, material, law.as_ref());
            for friction in [0.0, 1e-320, 1e-15, 1e-8, 1e-7, 1e-4] {
                let loaded = LoadedPatch { patch: Patch { a: 6e-3, b: 4e-3 }, normal_force: 6e4, friction };
                for rolling in [0.0, 0.01, -1.5, 30.0] {
                    for u in [0.0, 1e-300, 1e-12, 1e-5] {
                        let slip = SlipVelocity { longitudinal: 1e-3, lateral: -2e-3, spin: 0.1 * rolling, rolling };
                        let state = [u, -0.5 * u, 0.3, 0.02];
                        let found = transient.evaluate(law.as_ref(), &loaded, &slip, &state);
                        let slopes = transient.slopes(law.as_ref(), &loaded, &slip, &state);
                        let numbers = slopes.rate_by_deflection.iter().chain(&slopes.rate_by_slip).chain(&slopes.force_by_state);
                        let numbers = numbers.chain(&slopes.force_by_slip).chain(&slopes.force_by_normal_force).chain(&found.rates);
                        assert!(numbers.copied().all(f64::is_finite), "{friction} {rolling} {u}: {slopes:?}");
                        assert!(found.force.longitudinal.hypot(found.force.lateral) <= 1.001 * friction * 6e4 + 1e-300);
                        if friction == 0.0 && !transient.is_idle(rolling) {
                            assert_eq!(found.rates[..2], [-u / 2e-3, 0.5 * u / 2e-3]);
                            assert_eq!(slopes.rate_by_deflection, Matrix2::identity() * (-1.0 / 2e-3));
                        }
                    }
                }
            }
        }
    }
}
