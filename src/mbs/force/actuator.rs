//! Actuator between two places: an active suspension, a tilting jack, a steering cylinder, whose force a controller asks for.
//!
//! ```text
//! T = u, bounded to -largest_force ... largest_force        without `lag`
//! T' = (u - T) / lag,  u bounded likewise                   with it
//! ```
//!
//! u is the input. The force T acts along the line between the places, tension positive, or along an axis, with the signs of [`super::line`]; its reaction is on the other body.
//! The actuator is nothing but this force: stiffness and damping in parallel are elements of their own, and so is what it holds when it is off. Power that it puts in: `-T L'`.

use super::line::{QUANTITIES as OF_LINES, Slopes, Span, Stretch};
use super::{ElementInput, ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::force::Attachment;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Number, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};

/// Force of one metre of the state, which the error control takes for a position, N/m.
const PER_STATE: f64 = 1e5;

/// A force that is asked for between two bodies.
#[derive(Clone, Debug)]
pub struct Actuator {
    pub name: String,
    pub span: Span,
    /// N.
    pub largest_force: f64,
    /// s; none: the force is there at once.
    pub lag: f64,
}

impl Actuator {
    fn lags(&self) -> bool {
        self.lag > 0.0
    }

    /// u within its bounds, N.
    #[inline]
    fn asked(&self, bodies: &Moving) -> f64 {
        bodies.input(0).clamp(-self.largest_force, self.largest_force)
    }

    /// T, N.
    #[inline]
    fn tension(&self, bodies: &Moving, state: &[f64]) -> f64 {
        state.first().map_or_else(|| self.asked(bodies), |state| PER_STATE * state)
    }
}

const INPUTS: [ElementInput; 1] = [ElementInput {
    number: 0,
    name: "demand",
    unit: Unit::Newton,
    least: None,
    description: "force that is asked for, tension positive; along an axis that on \"from\"",
}];

const QUANTITIES: [Quantity; 4] = [
    OF_LINES[0],
    OF_LINES[1],
    Quantity { number: 2, name: "speed", kind: QuantityKind::Speed, description: "rate of the displacement" },
    Quantity { number: 3, name: "power", kind: QuantityKind::Power, description: "power that the actuator puts into the vehicle" },
];

impl Numbered for Actuator {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "largestForce", Newton, POSITIVE, "bound of the force either way", largest_force),
        constant!(1, "lag", Second, POSITIVE, "time constant with which the force follows", lag),
    ];

    /// The second where it lags.
    fn numbers(&self) -> Vec<Number> {
        Constant::read(&Self::CONSTANTS[..1 + usize::from(self.lags())], self)
    }
}

impl ForceElement for Actuator {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        usize::from(self.lags())
    }

    fn time_constant(&self) -> Option<f64> {
        self.lags().then_some(self.lag)
    }

    fn inputs(&self) -> &'static [ElementInput] {
        &INPUTS
    }

    fn is_supplied(&self) -> bool {
        true
    }

    fn is_dissipative(&self) -> bool {
        false
    }

    fn supplied_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        -self.tension(bodies, state) * self.span.stretch(bodies).rate
    }

    fn settle(&self, bodies: &Moving, state: &mut [f64]) {
        if let [state] = state {
            *state = self.asked(bodies) / PER_STATE;
        }
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        if let ([state], [rate]) = (state, rates) {
            *rate = (self.asked(bodies) / PER_STATE - state) / self.lag;
        }
        self.span.pull(bodies, &self.span.stretch(bodies), self.tension(bodies, state), wrenches);
    }

    fn bodies(&self) -> Ends {
        [self.span.from.body, self.span.to.body]
    }

    fn holds(&self) -> [Option<Attachment>; 2] {
        [Some(self.span.from), Some(self.span.to)]
    }

    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let slopes = match self.lags() {
            true => Slopes { by_state: PER_STATE, state_by_state: -1.0 / self.lag, ..Slopes::default() },
            false => Slopes::default(),
        };
        self.span.tangent(&self.span.stretch(bodies), self.tension(bodies, state), &slopes, (first_state, self.states()), sum);
    }

    fn drawn_length(&self) -> Option<f64> {
        self.span.drawn_length()
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        let Stretch { displacement, rate, .. } = self.span.stretch(bodies);
        match index {
            0 => self.tension(bodies, state),
            1 => displacement,
            2 => rate,
            3 => self.supplied_power(bodies, state),
            _ => 0.0,
        }
    }

    fn potential_energy(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }

    fn dissipated_power(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let span = Span::parse(section, places)?;
    let largest_force = section.positive("largest_force", Dimension::Force)?;
    let lag = section.not_negative_or("lag", Dimension::Time, 0.0)?;
    Ok(Box::new(Actuator { name: places.name(section)?, span, largest_force, lag }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "actuator",
    summary: "force between two places that an input asks for: active suspension, tilting, steering",
    reference: "",
    parse,
};
