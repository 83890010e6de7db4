//! Damper with a spring in series (Maxwell): the mounts of a hydraulic damper, and its oil, give way.
//!
//! The state z [m] is the displacement of the piston, x - z that of the series spring:
//!
//! ```text
//! T = k (x - z),    z' = v(T)       v(T) = T / c, or the inverse of a table of force over speed
//! ```
//!
//! Under x = X exp(i w t) the linear law gives `T = k c i w / (k + c i w) X`: a damper c below k/c [rad/s], a spring k
//! above. An explicit integrator's step is bound by c/k (4 to 7 ms for the vertical dampers of a passenger coach).

use super::curve::{Beyond, Curve, Outside, Shape, Table, sided};
use super::line::{LineElement, LineLaw, Slopes, Span};
use super::{ForceElement, POSITIVE, Parse, Places};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Dimension;

/// The law of a spring and a damper in series.
#[derive(Clone, Debug)]
pub struct MaxwellDamper {
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m; `None` where a table stands in its place.
    pub damping: Option<f64>,
    /// v(T): m/s over N.
    pub speed: Curve,
}

impl Numbered for MaxwellDamper {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "stiffness", NewtonPerMetre, POSITIVE, "stiffness of the series spring", stiffness),
        constant!(tunable 1, "damping", NewtonSecondPerMetre, POSITIVE, "damping of the damper", get: |law| law.damping, set: |law, value| (law.damping, law.speed) = (Some(value), Curve::linear(1.0 / value))),
    ];
}

impl LineLaw for MaxwellDamper {
    fn states(&self) -> usize {
        1
    }

    fn time_constant(&self) -> Option<f64> {
        Some(1.0 / (self.stiffness * self.speed.steepest()))
    }

    fn settle(&self, x: f64, state: &mut [f64]) {
        state.fill(x);
    }

    #[inline]
    fn rates(&self, x: f64, _: f64, state: &[f64], rates: &mut [f64]) {
        rates[0] = self.speed.force(self.tension(x, 0.0, state));
    }

    #[inline]
    fn tension(&self, x: f64, _: f64, state: &[f64]) -> f64 {
        self.stiffness * (x - state[0])
    }

    fn slopes(&self, x: f64, _: f64, state: &[f64]) -> Slopes {
        let k = self.stiffness;
        let relaxation = k * self.speed.slope(self.tension(x, 0.0, state));
        let (by_displacement, by_state) = (k, -k);
        Slopes { by_displacement, by_state, state_by_displacement: relaxation, state_by_state: -relaxation, ..Slopes::default() }
    }

    fn potential_energy(&self, x: f64, state: &[f64]) -> f64 {
        0.5 * self.stiffness * (x - state[0]) * (x - state[0])
    }

    fn tables(&self) -> Vec<Table> {
        self.speed.table.into_iter().collect()
    }

    fn table_argument(&self, _: usize, x: f64, _: f64, state: &[f64]) -> f64 {
        self.speed.force(self.tension(x, 0.0, state))
    }

    fn dissipated_power(&self, x: f64, _: f64, state: &[f64]) -> f64 {
        let tension = self.tension(x, 0.0, state);
        tension * self.speed.force(tension)
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let span = Span::parse(section, places)?;
    let outside = Outside::parse(section, &["force_over_speed"])?;
    let mut damping = None;
    let speed = if section.has("force_over_speed") {
        if section.has("damping") {
            return Err(section.error("force_over_speed", "says again what \"damping\" says; give one of them"));
        }
        if outside.beyond == Beyond::Hold {
            let problem = "\"hold\" leaves the speed open at the last force (the damper's speed follows from its force); expected \"slope\", with a last stretch that rises little";
            return Err(section.error("beyond", problem));
        }
        let (points, table) = sided(section, "force_over_speed", Dimension::Speed, Shape::Invertible, &outside)?;
        let inverse: Vec<[f64; 2]> = points.iter().map(|[speed, force]| [*force, *speed]).collect();
        let curve = Curve::new(&inverse, 0.0).ok_or_else(|| section.error("force_over_speed", "expected two or more points"))?;
        curve.of(Some(table))
    } else {
        Curve::linear(1.0 / *damping.insert(section.positive("damping", Dimension::Damping)?))
    };
    let law = MaxwellDamper { stiffness: section.positive("stiffness", Dimension::Stiffness)?, damping, speed };
    Ok(Box::new(LineElement { name: places.name(section)?, span, law }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "maxwell_damper",
    summary: "damper with a spring in series, between two places or along an axis of \"from\"; linear or piecewise linear",
    reference: "J. C. Maxwell, Phil. Trans. R. Soc. 157 (1867) 49-88",
    parse,
};
