//! Tangential contact at low speed and standstill: an elastic deflection between wheel and rail that relaxes while
//! the patch rolls on.
//!
//! The steady creepage v/V has no meaning at V = 0. Each contact gets four first-order states: the tangential
//! deflection u_x, u_y [m], the rolled-in direction p [-] (1: rolled forward by several patch lengths, -1: backward) and the rolled-in spin phi [1/m].
//! With the slip velocity v [m/s] of the wheel's material point and the signed rolling speed V:
//!
//! ```text
//! zeta_i = s(r) u_i / L_i                              creepage that the deflection amounts to
//! u_i'   = (v_i - V_r zeta_i) / D - (1 - r_2/r)_+ u_i / T
//! V_r    = |V| psi(p sign V) + alpha(r) (v . u)_+ / (s sum(u_i^2 / L_i))
//! p'     = (V - |V| p) / (l D_p),   l = a / 2
//! phi'   = |V| psi (omega_n / V - phi) / (a D_phi)
//! F      = law(w s (u + tau u') / L + (1 - w) v/|V|,  spin w phi + (1 - w) omega_n / V,  speed V_F)
//! V_F    = (w V_r |zeta| + (1 - w) |v|) / (w |zeta| + (1 - w) |v| / |V|)
//! ```
//!
//! * Steady rolling: zeta = v/V, and F is the steady law exactly. V = 0: u' = v, a spring of stiffness F'(0)/L (see
//!   [`relaxation`]). In between the lag over the length L of the tyre models (Pacejka, Tire and Vehicle Dynamics, ch. 7,
//!   with the deflection as the state, so that nothing is divided by V). V_r zeta is the part of v that does not go
//!   into the deflection: creep and sliding. So the law's sliding speed, creepage times speed, is right too: V_F is the mean of V_r and |V| by the creepages that each stands for. (Their
//!   mean by w alone gave a locked wheel between below / 2 and `below` fifty times its sliding speed, and falling friction its least value.)
//! * r = k |u| / (mu N) is the deflection against that of the friction bound. Below r_1 it is purely elastic and the
//!   law's curve is retraced: an oscillating force below the bound makes no drift, unlike in the models of Dahl or LuGre.
//!   Above, alpha rises from 0 to 1 at r_2 and takes away the growth of u: the wheel slides and u stays bounded.
//!   (v . u)_+ vanishes when the slip reverses: unloading starts at once. This is the elasto-plastic idea of Dupont, Hayward,
//!   Armstrong, Altpeter, IEEE Trans. Autom. Control 47 (2002) 787. r_1 is measured from the law when the model is
//!   made: 1.12 times the r from which on the force stays within 0.1 % of its full-slip value; r_2 = 1.25 r_1. The spin's
//!   share of the linear force is added to both, so that spin can't hide the bound.
//! * s is 1 for a law that is at its bound there. One that nears it slowly (Polach on wet rails: 0.8 mu N at r_1) would never get to it: a sliding wheel had 16 % less
//!   than its friction, and a braked one slid down a grade that it can hold. So from 0.3 r_1 on the deflection counts for ever more creepage, up to Sigma times at r_1, where the law is within 0.1 %
//!   of its bound: s goes from 1 to Sigma by a cubic step. As V_r zeta has it too, steady rolling stays exact.
//! * psi is 0 for p sign V < 1/4 and 1 above 3/4: relaxation needs a net way in one direction (1.4 l from p = 0).
//!   A braked wheel that trembles rolls by micrometres to and fro; the material inside its patch is the same all the time,
//!   and |V| alone would let its force leak away. Only ways count here, no speed is "small".
//! * D = sqrt(1 + (T lambda)^2) with lambda = V_r / L bounds the rates of lasting motion whatever v and V: below 8 / T
//!   (measured 6 / T, where alpha is between 0 and 1; 1 / T in rolling and in full sliding). It changes no steady state, and where
//!   L/V is long against T little else ((T V/L)^2 / 2 of the length). D_p likewise.
//! * w is 1 below half the scene's speed `below` and 0 above `below`, twice continuously differentiable:
//!   above, the force is the steady law of v/V and of nothing else.
//! * All rates are multiplied by a factor that is 1 below `below` and 0 above twice that, twice continuously differentiable: above, the states
//!   stand still and cost a step nothing ([`TransientContact::is_idle`]). A vehicle that slows down at 3 m/s2 from twice `below` = 2 m/s rolls 2 m before
//!   w leaves 0: some hundred relaxation lengths, in which u forgets where it stood.
//! * tau: material damping (Kelvin-Voigt) of the deflection, inside the law and so under its bound; it vanishes in steady
//!   states. The ratio of damping at the circular frequency f is tau f / 2.
//! * Spin builds up as the patch rolls on. In a brush whose bristles all stick, of length 2 a, the lateral force a way s after a step of spin is
//!   3/4 (s/a)^2 - 1/4 (s/a)^3 of the steady one up to s = 2 a (that of creepage s/a - (s/a)^2/4): it comes a way of a late, and the lag's length is that.
//!   (Without it a wheelset that trembled in yaw while it rolled at 10 mm/s was pushed sideways by omega_n / V at once, 0.1 1/m and 1.5 kN, and its
//!   lateral swing grew at 112 Hz.) omega_n / V has the sign of V: with it the in-plane law is the same for both rolling directions
//!   (see below) and a wheel on an inclined contact, whose omega_n changes sign with V, passes V = 0 without any jump.
//!   For |V| < v_0 = below/100, 1/V is replaced by an odd polynomial and the moment's sign by another.
//!   What is left out is the twisting spring of a resting patch, of the order G (ab)^1.5, 1e-5 of what the two
//!   wheels' longitudinal springs do to yaw.
//! * Unloaded (N = 0 or an empty patch): u' = -u/T, p' = -p/T, phi' = -phi/T. Below N = 10 N the rates go over to these smoothly: a patch that ends or
//!   begins has an a next to nothing, p and phi would turn within T to what rolling makes of them, and rates that jump at N = 0 stop an integration that
//!   meets N = 0 at a grazing angle.
//! * Without friction (mu N = 0; a law without bound aside) nothing holds a deflection: u' = -u/T, which is where u goes for mu to 0,
//!   and the law sees the slip velocity as it is. p goes on: friction may come back.
//!
//! Rolling backward the law is called in axes turned by 180 degrees (`in_rolling_direction`). All laws are
//! mirror-symmetric: (Fx, Fy, Mz)(-x, y, s) = (-Fx, Fy, Mz) and (x, -y, -s) -> (Fx, -Fy, -Mz). So the turned law is
//! F(x, y, -s) in the plane and -Mz(x, y, -s): one call with the signed spin ratio serves both directions.
//!
//! Limits: with the law as the force-deflection curve, full sliding at rest begins after r = 3 (Shen, Hedrick, Elkins) where
//! the exact theory has 1.5 (Cattaneo, Mindlin); micro-slip makes no hysteresis below r_1; a law that nears its
//!   bound slowly gets there sooner, at r_1, while the wheel stands. At |V| between below/2 and below the force
//! depends on v directly, as that of the steady law does.

pub mod relaxation;
pub mod slopes;
#[cfg(test)]
mod tests;

use super::creep::{CreepLaw, RollingContact};
use super::creepage::{CreepForce, Creepage, Slip};
use super::{Material, Patch};
use crate::math::smooth_step::cubic_step;
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use relaxation::{Elasticity, Relaxation};

/// States of one contact: deflection along e1 and e2 [m], rolled-in direction [-], rolled-in spin [1/m].
pub const STATES: usize = 4;

impl Slip {
    /// The slip of a wheel that rolls with a signed speed [m/s].
    #[inline]
    pub fn rolling(&self, speed: f64) -> SlipVelocity {
        SlipVelocity { longitudinal: self.longitudinal, lateral: self.lateral, spin: self.spin, rolling: speed }
    }
}

/// What `[contact.transient]` says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransientSettings {
    /// |V| from which on the steady law holds exactly, m/s; pure transient below half of it.
    pub below: f64,
    /// T, s: rates of lasting motion stay below 8 / T.
    pub time_floor: f64,
    /// tau, s.
    pub damping_time: f64,
}

impl TransientSettings {
    /// Reads the table `transient` of `[contact]`; `None` when it is absent.
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub fn parse(contact: &Section) -> Result<Option<Self>, SettingsError> {
        let Some(section) = contact.optional_section("transient")? else { return Ok(None) };
        let below = section.positive("below", Dimension::Speed)?;
        let time_floor = section.number_or("time_floor", Dimension::Time, 2e-3)?;
        if !(1e-6..=0.1).contains(&time_floor) {
            return Err(section.error("time_floor", format!("found {time_floor:?}, expected 1 us to 0.1 s")));
        }
        let damping_time = section.number_or("damping_time", Dimension::Time, 5e-5)?;
        if !(0.0..=1e-3).contains(&damping_time) {
            return Err(section.error("damping_time", format!("found {damping_time:?}, expected 0 to 1 ms")));
        }
        section.finish()?;
        Ok(Some(TransientSettings { below, time_floor, damping_time }))
    }
}

/// A pressed contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadedPatch {
    pub patch: Patch,
    /// N, N, not negative.
    pub normal_force: f64,
    /// mu, -.
    pub friction: f64,
}

/// Motion of the wheel's material point against the rail, in e1, e2, n.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlipVelocity {
    /// v . e1, m/s.
    pub longitudinal: f64,
    /// v . e2, m/s.
    pub lateral: f64,
    /// omega . n, rad/s.
    pub spin: f64,
    /// V, m/s, positive rolling along +e1. For a wheel that slides much, the mean of its travelling and its circumferential speed.
    pub rolling: f64,
}

/// What [`TransientContact::evaluate`] finds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// On the wheel, along e1, e2, n.
    pub force: CreepForce,
    /// Time derivatives of the states, m/s, m/s, 1/s, 1/(m s).
    pub rates: [f64; STATES],
    /// Effective creepage; v/|V|, omega_n/|V| in steady rolling.
    pub creepage: Creepage,
}

/// The transient model around one creep law and material.
#[derive(Clone, Debug)]
pub struct TransientContact {
    settings: TransientSettings,
    relaxation: Relaxation,
    /// r_1 without spin, -.
    slide_from: f64,
    /// |V| over `below` from which on the states stand still.
    idle: f64,
    /// Sigma, -: 1 for a law that is at its bound where the wheel slides.
    stretch: f64,
}

/// |V| over `below` from which on the states stand still.
const IDLE: f64 = 2.0;
/// Where s begins to rise, in parts of r_1.
const STRETCH_FROM: f64 = 0.3;
/// r_2 / r_1.
const SLIDE_WIDTH: f64 = 1.25;
/// Friction bound, N, below which nothing holds: the deflection under it is smaller than a picometre.
const LEAST_BOUND: f64 = 1e-3;

/// N from which on a contact's states are those of a pressed one, N.
const PRESSED: f64 = 10.0;

/// How far the states are those of a pressed contact, 0 to 1.
#[inline]
fn held(contact: &LoadedPatch) -> f64 {
    cubic_step(contact.normal_force / PRESSED)
}

impl TransientContact {
    /// Do the states stand still and have no part in the force, when a wheel rolls this fast [m/s]?
    #[inline]
    pub fn is_idle(&self, speed: f64) -> bool {
        speed.abs() >= self.idle * self.settings.below
    }

    /// Rates of the states of a contact without load, whose wheel rolls with this speed [m/s].
    #[inline]
    pub fn unloaded_rates(&self, speed: f64, state: &[f64; STATES]) -> [f64; STATES] {
        let rate = self.fading(speed);
        state.map(|x| -x * rate)
    }

    /// How fast states fade that nothing holds, 1/s.
    fn fading(&self, speed: f64) -> f64 {
        self.liveliness(speed.abs()) / self.settings.time_floor
    }

    /// Measures the law's saturation (a few hundred calls); not for the stepping path.
    pub fn new(settings: TransientSettings, material: Material, law: &dyn CreepLaw) -> Self {
        let relaxation = Relaxation::new(material);
        let slide_from = 1.12 * saturation_ratio(&relaxation, law);
        let stretch = stretch(&relaxation, law, slide_from);
        TransientContact { settings, relaxation, slide_from, idle: IDLE, stretch }
    }

    /// The same where spin has no part in the forces, and so none in what is needed to slide.
    pub fn without_spin(mut self) -> Self {
        self.relaxation.leave_out_spin();
        self
    }

    /// The same with states that live at any speed, although they have no part in the force from `below` on.
    pub fn always(mut self) -> Self {
        self.idle = f64::INFINITY;
        self
    }

    pub fn settings(&self) -> &TransientSettings {
        &self.settings
    }

    /// s at k |u| = `load` [N] where sliding begins at `from` [N], and its slope by `load` over `from`.
    #[inline]
    fn stretched(&self, load: f64, from: f64) -> (f64, f64) {
        let x = (load / from - STRETCH_FROM) / (1.0 - STRETCH_FROM);
        if self.stretch == 1.0 || !(x > 0.0) {
            return (1.0, 0.0);
        }
        if x >= 1.0 {
            return (self.stretch, 0.0);
        }
        let most = self.stretch - 1.0;
        (1.0 + most * cubic_step(x), most * 6.0 * x * (1.0 - x) / (1.0 - STRETCH_FROM))
    }

    /// r_1 and r_2 without spin, -: deflection over mu N / k at which sliding begins and is complete.
    pub fn sliding_range(&self) -> [f64; 2] {
        [self.slide_from, SLIDE_WIDTH * self.slide_from]
    }

    /// L along e1 and e2 [m] and k [N/m]; `None` for an empty patch.
    pub fn elasticity(&self, patch: Patch) -> Option<Elasticity> {
        self.relaxation.of(patch)
    }

    /// v/|V| and omega_n/|V|, where V goes through 0 with 1/V as it is replaced there: 0 at rest.
    pub fn creepage(&self, slip: &SlipVelocity) -> Creepage {
        let per_speed = self.inverse_speed(slip.rolling.abs());
        Creepage { longitudinal: slip.longitudinal * per_speed, lateral: slip.lateral * per_speed, spin: slip.spin * per_speed }
    }

    /// What an error of the deflection [m] is in force at the speed |V| [m/s], N, where the contact holds: w k |e|.
    pub fn force_of(&self, patch: Patch, speed: f64, [along, across]: [f64; 2]) -> f64 {
        let weight = self.transient_weight(speed);
        let elastic = if weight > 0.0 { self.elasticity(patch) } else { None };
        elastic.map_or(0.0, |elastic| weight * elastic.stiffness * along.hypot(across))
    }

    /// States of steady rolling with `slip`, V not zero: to start a run without a transient.
    pub fn steady_state(&self, contact: &LoadedPatch, slip: &SlipVelocity) -> [f64; STATES] {
        let Some(elastic) = self.relaxation.of(contact.patch) else { return [0.0; STATES] };
        let speed = slip.rolling.abs();
        if !(speed > 0.0 && contact.normal_force > 0.0) {
            return [0.0; STATES];
        }
        let u = [slip.longitudinal / speed * elastic.length[0], slip.lateral / speed * elastic.length[1]];
        let bound = contact.friction * contact.normal_force;
        let ratio = elastic.stiffness * u[0].hypot(u[1]);
        let scale = (SLIDE_WIDTH * self.slide_from * bound / ratio).min(1.0);
        let scale = if scale.is_finite() { self.steady_scale(scale, ratio, self.slide_from * bound) } else { 0.0 };
        [scale * u[0], scale * u[1], slip.rolling.signum(), slip.spin * self.inverse_speed(slip.rolling)]
    }

    /// The part of u = L v/|V|, with k |u| = `load`, that amounts to the creepage v/|V|; at most `most`.
    fn steady_scale(&self, most: f64, load: f64, from: f64) -> f64 {
        const HALVINGS: usize = 60;
        let enough = |scale: f64| scale * self.stretched(scale * load, from).0 >= 1.0;
        if self.stretch == 1.0 || !enough(most) {
            return most;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            (low, high) = if enough(middle) { (low, middle) } else { (middle, high) };
        }
        high
    }

    /// Force and rates. Finite for every finite input; allocates nothing.
    pub fn evaluate(&self, law: &dyn CreepLaw, contact: &LoadedPatch, slip: &SlipVelocity, state: &[f64; STATES]) -> Evaluation {
        let mut found = self.pressed(law, contact, slip, state);
        let held = held(contact);
        if held < 1.0 {
            let unloaded = self.unloaded_rates(slip.rolling, state);
            found.rates = std::array::from_fn(|i| held * found.rates[i] + (1.0 - held) * unloaded[i]);
        }
        found
    }

    /// The same of a contact that is pressed in earnest.
    fn pressed(&self, law: &dyn CreepLaw, contact: &LoadedPatch, slip: &SlipVelocity, state: &[f64; STATES]) -> Evaluation {
        let floor = self.settings.time_floor;
        let [ux, uy, p, phi] = *state;
        let speed = slip.rolling.abs();
        let elastic = match self.relaxation.of(contact.patch) {
            Some(elastic) if contact.normal_force > 0.0 => elastic,
            _ => return Evaluation { rates: self.unloaded_rates(speed, state), ..Evaluation::default() },
        };
        let lively = self.liveliness(speed);
        let spin_ratio = slip.spin * self.inverse_speed(slip.rolling);
        let rate_phi = self.spin_lag(contact, slip, p) * (spin_ratio - phi);
        let way = 0.5 * contact.patch.a;
        let rate_p = (slip.rolling - speed * p) / way / (1.0 + (floor * speed / way).powi(2)).sqrt();
        if !self.holds(contact) {
            return Evaluation { rates: [-ux / floor, -uy / floor, rate_p, rate_phi].map(|rate| lively * rate), ..Evaluation::default() };
        }

        // How far the deflection has gone towards sliding.
        let weight = self.transient_weight(speed);
        let rolled_spin = weight * phi;
        let direct_spin = (1.0 - weight) * spin_ratio;
        let slide_from = self.sliding_load(contact, &elastic, rolled_spin + direct_spin);
        let load = elastic.stiffness * ux.hypot(uy);
        let slide_full = SLIDE_WIDTH * slide_from;
        let alpha = if load > slide_from { cubic_step((load - slide_from) / (slide_full - slide_from)) } else { 0.0 };
        let sliding = if alpha > 0.0 {
            let power = slip.longitudinal * ux + slip.lateral * uy;
            alpha * power.max(0.0) / (ux * ux / elastic.length[0] + uy * uy / elastic.length[1]).max(1e-60)
        } else {
            0.0
        };
        let excess = if load > slide_full { 1.0 - slide_full / load } else { 0.0 };

        // Deflection: what the slip brings less what rolling on, sliding and lost load take away.
        let (stretch, _) = self.stretched(load, slide_from);
        let sliding = sliding / stretch;
        let relaxing = ahead(slip, p) + sliding;
        let rate = |u: f64, v: f64, length: f64| {
            let lambda = stretch * relaxing / length;
            (v - lambda * u) / (1.0 + (floor * lambda).powi(2)).sqrt() - excess * u / floor
        };
        let rates_xy = [rate(ux, slip.longitudinal, elastic.length[0]), rate(uy, slip.lateral, elastic.length[1])];

        // Creepage for the law: the deflection's below, v/V above.
        let deflected = |u: f64, u_rate: f64, length: f64| stretch * (u + self.settings.damping_time * u_rate) / length;
        let zeta = [deflected(ux, rates_xy[0], elastic.length[0]), deflected(uy, rates_xy[1], elastic.length[1])];
        let blend = |zeta: f64, v: f64| if weight == 1.0 { zeta } else { weight * zeta + (1.0 - weight) * v / speed };
        let (longitudinal, lateral) = (blend(zeta[0], slip.longitudinal), blend(zeta[1], slip.lateral));
        let [left, _] = self.spin_left(speed, sliding);
        let spin = direct_spin + left * rolled_spin;
        let law_speed = law_speed(weight, zeta[0].hypot(zeta[1]), slip, relaxing);
        let found = law.force(&RollingContact {
            patch: contact.patch,
            normal_force: contact.normal_force,
            friction: contact.friction,
            creepage: Creepage { longitudinal, lateral, spin },
            speed: law_speed,
        });
        let turn = self.smooth_sign(slip.rolling);
        Evaluation {
            force: CreepForce { spin_moment: turn * found.spin_moment, ..found },
            rates: [rates_xy[0], rates_xy[1], rate_p, rate_phi].map(|rate| lively * rate),
            creepage: Creepage { longitudinal, lateral, spin: turn * spin },
        }
    }

    /// Is there friction that can hold a deflection?
    fn holds(&self, contact: &LoadedPatch) -> bool {
        self.slide_from.is_infinite() || contact.friction * contact.normal_force > LEAST_BOUND
    }

    /// k |u| from which on the contact slides, N.
    fn sliding_load(&self, contact: &LoadedPatch, elastic: &Elasticity, spin: f64) -> f64 {
        // Without bound and without friction the product would be none.
        let bound = (contact.friction * contact.normal_force).max(LEAST_BOUND);
        self.slide_from * bound + elastic.spin_coupling * spin.abs()
    }

    /// How fast phi goes to omega_n / V, 1/s.
    fn spin_lag(&self, contact: &LoadedPatch, slip: &SlipVelocity, direction: f64) -> f64 {
        let lambda = ahead(slip, direction) / contact.patch.a;
        lambda / (1.0 + (self.settings.time_floor * lambda).powi(2)).sqrt()
    }

    /// What sliding leaves of the spin that was rolled in, `V_1 / (V_1 + sliding)`, and its slope by sliding: it shrinks the whole creepage vector, so that its direction is kept. V_1 is |V|,
    /// below v_0 at least v_0 / 10: with |V| the force turned within nanometres per second where a wheel comes to rest, and no step was short enough. (So a wheel that slides at v_0 / 10
    /// without rolling keeps half of its spin.)
    fn spin_left(&self, speed: f64, sliding: f64) -> [f64; 2] {
        let small = 0.01 * self.settings.below;
        let rolling = speed + 0.1 * small * fall(speed / small);
        let sum = rolling + sliding;
        [rolling / sum, -rolling / (sum * sum)]
    }

    /// w(|V|).
    fn transient_weight(&self, speed: f64) -> f64 {
        fall(2.0 * speed / self.settings.below - 1.0)
    }

    /// What all rates are multiplied by at the speed |V|.
    fn liveliness(&self, speed: f64) -> f64 {
        fall((speed / self.settings.below - 1.0) / (self.idle - 1.0))
    }

    /// 1/V, below v_0 an odd polynomial through 0 with equal value, slope and curvature at v_0.
    fn inverse_speed(&self, v: f64) -> f64 {
        let small = 0.01 * self.settings.below;
        let x = v / small;
        if x.abs() >= 1.0 { 1.0 / v } else { x * (3.0 - x * x * (3.0 - x * x)) / small }
    }

    /// sign V, below v_0 an odd polynomial likewise.
    fn smooth_sign(&self, v: f64) -> f64 {
        let x = v / (0.01 * self.settings.below);
        if x.abs() >= 1.0 { x.signum() } else { x * (15.0 - x * x * (10.0 - 3.0 * x * x)) / 8.0 }
    }
}

/// |V| psi, m/s: how fast the patch rolls on over material that is new to it.
#[inline]
fn ahead(slip: &SlipVelocity, direction: f64) -> f64 {
    slip.rolling.abs() * cubic_step(2.0 * (direction * slip.rolling.signum() - 0.25))
}

/// From 1 at 0 to 0 at 1, held outside, twice continuously differentiable.
#[inline]
fn fall(x: f64) -> f64 {
    if x <= 0.0 {
        1.0
    } else if x >= 1.0 {
        0.0
    } else {
        1.0 - x * x * x * (10.0 - x * (15.0 - 6.0 * x))
    }
}

/// The r = (linear force) / (mu N) from which on the law's force stays within 0.1 % of its value at r = 100; at most 20. Infinite
/// for a law without bound: its contact never slides.
fn saturation_ratio(relaxation: &Relaxation, law: &dyn CreepLaw) -> f64 {
    let force = |r: f64| force_at(relaxation, law, r);
    let full = force(100.0);
    if force(50.0) < 0.8 * full {
        return f64::INFINITY;
    }
    let mut r = 20.0;
    while r > 0.5 && (force(0.99 * r) / full - 1.0).abs() <= 1e-3 {
        r *= 0.99;
    }
    r
}

/// An r at which every law slides.
const ENDLESS: f64 = 1e6;

/// Force of the law at r = (linear force) / (mu N) in a patch of usual size, N.
fn force_at(relaxation: &Relaxation, law: &dyn CreepLaw, r: f64) -> f64 {
    const PATCH: Patch = Patch { a: 5e-3, b: 5e-3 };
    const BOUND: f64 = 2e4;
    let Some(elastic) = relaxation.of(PATCH) else { return 0.0 };
    let longitudinal = r * BOUND / (elastic.stiffness * elastic.length[0]);
    let creepage = Creepage { longitudinal, ..Creepage::default() };
    law.force(&RollingContact { patch: PATCH, normal_force: BOUND / 0.3, friction: 0.3, creepage, speed: 0.0 }).longitudinal.abs()
}

/// Sigma: how many times r_1 has to be taken for the law to be within 0.1 % of its bound.
fn stretch(relaxation: &Relaxation, law: &dyn CreepLaw, slide_from: f64) -> f64 {
    const STEP: f64 = 1.05;
    const MOST: f64 = 1e3;
    if !slide_from.is_finite() {
        return 1.0;
    }
    let full = force_at(relaxation, law, ENDLESS);
    let reaches = |times: f64| (force_at(relaxation, law, times * slide_from) / full - 1.0).abs() <= 1e-3;
    let mut times = 1.0;
    while times < MOST && !reaches(times) {
        times *= STEP;
    }
    times
}

/// V_F, m/s, from w, the size of zeta and V_r.
fn law_speed(weight: f64, zeta: f64, slip: &SlipVelocity, relaxing: f64) -> f64 {
    /// Where nothing slips V_F is |V|, which then matters to nothing.
    const LEAST: f64 = 1e-12;
    let speed = slip.rolling.abs();
    if weight == 1.0 {
        return relaxing;
    }
    let (deflected, direct) = (weight * zeta, (1.0 - weight) * slip.longitudinal.hypot(slip.lateral) / speed + LEAST);
    (deflected * relaxing + direct * speed) / (deflected + direct)
}
