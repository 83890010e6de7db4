//! Spring and damper in parallel along a line: `T = preload + F_k(x) + F_c(x')`.
//!
//! F_k and F_c are linear (k x, c x') or piecewise linear. x counts from the design configuration, or from the
//! natural length where that is given (then without preload): `T = F_k(L - natural length)`. A traction rod is such an
//! element, between places on two bodies. `preload = "static"`: the preload that balance asks for in the design configuration.

use super::curve::{Curve, Outside, Shape, Table, parse as parse_curve};
use super::line::{LineElement, LineLaw, Slopes, Span};
use super::{ForceElement, Parse, Places};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};

/// The law of a spring and a damper in parallel.
#[derive(Clone, Debug)]
pub struct SpringDamper {
    /// N at zero displacement, tension positive.
    pub preload: f64,
    /// Is the preload to be found from balance?
    pub balanced: bool,
    /// Length in the design configuration and natural length, m; `None` where a preload is stated.
    pub lengths: Option<[f64; 2]>,
    /// Their difference: the displacement from the natural length in the design configuration, m.
    pub offset: f64,
    /// N over m.
    pub spring: Curve,
    /// N over m/s.
    pub damper: Curve,
}

impl Numbered for SpringDamper {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "stiffness", NewtonPerMetre, Some(0.0), "stiffness of the spring", get: |law| law.spring.linear_slope(), set: |law, value| law.spring = Curve::linear(value)),
        constant!(tunable 1, "damping", NewtonSecondPerMetre, Some(0.0), "damping of the damper", get: |law| law.damper.linear_slope(), set: |law, value| law.damper = Curve::linear(value)),
        constant!(tunable 2, "preload", Newton, None, "force in the design configuration, tension positive", get: |law| (!law.balanced && law.lengths.is_none()).then_some(law.preload), set: |law, value| law.preload = value),
        Constant {
            number: 3,
            name: "naturalLength",
            unit: Unit::Metre,
            least: None,
            tunable: true,
            description: "length without force",
            get: |law| law.lengths.map(|lengths| lengths[1]),
            set: |law, value| {
                if let Some([design, natural]) = &mut law.lengths {
                    *natural = value;
                    law.offset = *design - value;
                }
            },
        },
    ];
}

impl LineLaw for SpringDamper {
    #[inline]
    fn tension(&self, x: f64, rate: f64, _: &[f64]) -> f64 {
        self.preload + self.spring.force(x + self.offset) + self.damper.force(rate)
    }

    fn slopes(&self, x: f64, rate: f64, _: &[f64]) -> Slopes {
        Slopes { by_displacement: self.spring.slope(x + self.offset), by_rate: self.damper.slope(rate), ..Slopes::default() }
    }

    fn potential_energy(&self, x: f64, _: &[f64]) -> f64 {
        self.preload * x + self.spring.energy(x + self.offset)
    }

    fn dissipated_power(&self, _: f64, rate: f64, _: &[f64]) -> f64 {
        self.damper.force(rate) * rate
    }

    fn tables(&self) -> Vec<Table> {
        [&self.spring, &self.damper].into_iter().filter_map(|curve| curve.table).collect()
    }

    fn table_argument(&self, table: usize, x: f64, rate: f64, _: &[f64]) -> f64 {
        if table == 0 && self.spring.table.is_some() { x + self.offset } else { rate }
    }

    fn static_stiffness(&self) -> Option<f64> {
        self.balanced.then(|| self.spring.slope(self.offset))
    }

    fn set_preload(&mut self, force: f64) {
        self.preload = force;
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let span = Span::parse(section, places)?;
    let rounding = section.optional("rounding", Dimension::Length)?.unwrap_or(0.0);
    let speed_rounding = section.optional("speed_rounding", Dimension::Speed)?.unwrap_or(0.0);
    if rounding < 0.0 || speed_rounding < 0.0 {
        return Err(section.error("rounding", "must not be negative"));
    }
    let outside = Outside::parse(section, &["force_over_length", "force_over_speed"])?;
    let (lengths, speeds) = (("force_over_length", Dimension::Length), ("force_over_speed", Dimension::Speed));
    let spring = parse_curve(section, lengths, ("stiffness", Dimension::Stiffness), (Shape::Any, &outside), rounding)?;
    let damper = parse_curve(section, speeds, ("damping", Dimension::Damping), (Shape::Passive, &outside), speed_rounding)?;
    if spring.is_none() && damper.is_none() {
        return Err(section.error("stiffness", "an element needs a stiffness or damping (or a table of force over length or speed)"));
    }
    let balanced = super::static_preload(section)?;
    let preload = if balanced { Some(0.0) } else { section.optional("preload", Dimension::Force)? };
    let natural = section.optional("natural_length", Dimension::Length)?;
    if preload.is_some() && natural.is_some() {
        return Err(section.error("natural_length", "says again what \"preload\" says; give one of them"));
    }
    let law = SpringDamper {
        preload: preload.unwrap_or(0.0),
        balanced,
        lengths: natural.map(|natural| [span.design_length, natural]),
        offset: natural.map_or(0.0, |natural| span.design_length - natural),
        spring: spring.unwrap_or_else(|| Curve::linear(0.0)),
        damper: damper.unwrap_or_else(|| Curve::linear(0.0)),
    };
    if balanced && !(law.spring.slope(0.0) > 0.0) {
        return Err(section.error("preload", "\"static\" needs a spring that carries: a stiffness, or a table that rises at zero"));
    }
    Ok(Box::new(LineElement { name: places.name(section)?, span, law }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "spring_damper",
    summary: "spring and damper in parallel between two places or along an axis of \"from\"; linear or piecewise linear",
    reference: "",
    parse,
};
