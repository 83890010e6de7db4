//! Air spring with an orifice to a reservoir: Nishimura's model.
//!
//! A bag of effective area A and volume V_b holds air at the absolute pressure p0 = p_a + load / A, p_a = 101 325 Pa outside; an orifice leads to a reservoir of volume V_r. Small
//! polytropic changes (exponent n) of both volumes make three stiffnesses,
//!
//! ```text
//! k1 = n p0 A^2 / V_b,    k2 = n p0 A^2 / V_r,    k3 = (p0 - p_a) dA/dh
//! T  = preload + k1 (x - s) + k3 x,      c s' + q |s'| s' = k1 (x - s) - k2 s
//! ```
//!
//! x is the elongation, tension positive (so the preload is minus the load), h = -x the compression, and the state s [m] is how far the piston A would have to go for the air that
//! has passed the orifice; c is the orifice's laminar, q its turbulent resistance, both at the piston. Static stiffness `k3 + k1 k2 / (k1 + k2)`, that of fast motion k3 + k1; with q = 0
//! under x = X exp(i w t) `T = (k3 + k1 (k2 + i c w) / (k1 + k2 + i c w)) X`. Stored is `k1 (x - s)^2 / 2 + k2 s^2 / 2 + k3 x^2 / 2 + preload x`; the orifice turns `(c + q |s'|) s'^2` into heat.
//!
//! *Left out:* exchange of heat (n is 1.4 in fast and 1 in very slow motion), inertia of the air in a long pipe (surge), the rubber's own stiffness and hysteresis and all lateral
//! stiffness (a `bushing` beside it), stiffening by large strokes, levelling valves.

use super::line::{LineElement, LineLaw, Slopes, Span};
use super::{ForceElement, POSITIVE, Parse, Places};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Dimension;

/// p_a, Pa.
const OUTSIDE: f64 = 101_325.0;
/// Air in a bag that is pulled on never gets thinner than this part of p_a.
const THINNEST: f64 = 0.01;

/// The law of an air spring.
#[derive(Clone, Debug)]
pub struct AirSpring {
    /// Tension in the design configuration, N: minus the load.
    pub preload: f64,
    /// Is it to be found from balance?
    pub balanced: bool,
    /// A, m2; V_b and V_r, m3.
    pub area: f64,
    pub volume: f64,
    pub reservoir: f64,
    /// dA/dh, m.
    pub area_growth: f64,
    /// n.
    pub polytropic: f64,
    /// c, N s/m, and q, N s2/m2.
    pub damping: f64,
    pub turbulent: f64,
}

impl AirSpring {
    /// k1, k2, k3, N/m.
    pub fn stiffnesses(&self) -> [f64; 3] {
        let above = -self.preload / self.area;
        let pressure = (OUTSIDE + above).max(THINNEST * OUTSIDE);
        let piston = self.polytropic * pressure * self.area * self.area;
        [piston / self.volume, piston / self.reservoir, above * self.area_growth]
    }

    /// What drives air through the orifice, N, and how fast it goes, m/s.
    fn flow(&self, x: f64, s: f64) -> (f64, f64) {
        let [bag, reservoir, _] = self.stiffnesses();
        let head = bag * (x - s) - reservoir * s;
        (head, 2.0 * head / (self.damping + self.resistance(head)))
    }

    /// d head / d s', N s/m.
    fn resistance(&self, head: f64) -> f64 {
        (self.damping * self.damping + 4.0 * self.turbulent * head.abs()).sqrt()
    }
}

impl Numbered for AirSpring {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "orificeDamping", NewtonSecondPerMetre, POSITIVE, "laminar resistance of the orifice at the piston", damping),
        constant!(tunable 1, "preload", Newton, None, "force in the design configuration, tension positive", get: |law| (!law.balanced).then_some(law.preload), set: |law, value| law.preload = value),
    ];
}

impl LineLaw for AirSpring {
    fn states(&self) -> usize {
        1
    }

    fn time_constant(&self) -> Option<f64> {
        let [bag, reservoir, _] = self.stiffnesses();
        Some(self.damping / (bag + reservoir))
    }

    fn settle(&self, x: f64, state: &mut [f64]) {
        let [bag, reservoir, _] = self.stiffnesses();
        state.fill(x * bag / (bag + reservoir));
    }

    #[inline]
    fn rates(&self, x: f64, _: f64, state: &[f64], rates: &mut [f64]) {
        rates[0] = self.flow(x, state[0]).1;
    }

    #[inline]
    fn tension(&self, x: f64, _: f64, state: &[f64]) -> f64 {
        let [bag, _, area] = self.stiffnesses();
        self.preload + bag * (x - state[0]) + area * x
    }

    fn slopes(&self, x: f64, _: f64, state: &[f64]) -> Slopes {
        let [bag, reservoir, area] = self.stiffnesses();
        let per_head = 1.0 / self.resistance(self.flow(x, state[0]).0);
        Slopes {
            by_displacement: bag + area,
            by_state: -bag,
            state_by_displacement: bag * per_head,
            state_by_state: -(bag + reservoir) * per_head,
            ..Slopes::default()
        }
    }

    fn potential_energy(&self, x: f64, state: &[f64]) -> f64 {
        let ([bag, reservoir, area], s) = (self.stiffnesses(), state[0]);
        self.preload * x + 0.5 * (bag * (x - s) * (x - s) + reservoir * s * s + area * x * x)
    }

    fn dissipated_power(&self, x: f64, _: f64, state: &[f64]) -> f64 {
        let (head, speed) = self.flow(x, state[0]);
        head * speed
    }

    fn static_stiffness(&self) -> Option<f64> {
        let [bag, reservoir, area] = self.stiffnesses();
        self.balanced.then(|| area + bag * reservoir / (bag + reservoir))
    }

    fn set_preload(&mut self, force: f64) {
        self.preload = force;
    }

    /// A bag.
    fn pushes_alone(&self) -> bool {
        true
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let span = Span::parse(section, places)?;
    let balanced = super::static_preload(section)?;
    let preload = if balanced { 0.0 } else { section.number("preload", Dimension::Force)? };
    if preload > 0.0 {
        return Err(section.error(
            "preload",
            format!("found {preload:?} N, which pulls; expected a negative tension (the load pressing on the bag) or \"static\""),
        ));
    }
    let polytropic = section.number_or("polytropic", Dimension::None, 1.4)?;
    if !(1.0..=1.67).contains(&polytropic) {
        return Err(section.error("polytropic", format!("found {polytropic:?}, expected 1 (slow, isothermal) to 1.67")));
    }
    let law = AirSpring {
        preload,
        balanced,
        area: section.positive("area", Dimension::None)?,
        volume: section.positive("volume", Dimension::None)?,
        reservoir: section.positive("reservoir_volume", Dimension::None)?,
        area_growth: section.number_or("area_growth", Dimension::Length, 0.0)?,
        polytropic,
        damping: section.positive("orifice_damping", Dimension::Damping)?,
        turbulent: section.not_negative_or("orifice_turbulence", Dimension::None, 0.0)?,
    };
    let [bag, reservoir, area] = law.stiffnesses();
    let least = area + bag * reservoir / (bag + reservoir);
    if !(least > 0.0) {
        let problem = format!("leaves a static stiffness of {least:.3e} N/m, with which the spring does not carry; expected a larger one");
        return Err(section.error("area_growth", problem));
    }
    Ok(Box::new(LineElement { name: places.name(section)?, span, law }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "air_spring",
    summary: "air spring with an orifice to a reservoir, between two places or along an axis of \"from\"",
    reference: "model of Nishimura as given by Quaglia and Sorli, Vehicle System Dynamics 35 (2001) 443-475",
    parse,
};
