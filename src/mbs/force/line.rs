//! Elements that act along one line: the kinematics of the line, and what makes an element of a scalar law.
//!
//! Direction, either along the connecting line of the two places, or along an axis that is fixed in the body of
//! `from`. With the point p of `to`, the point a of `from`, and the velocities of the two bodies there, where o is
//! the angular velocity of `from`:
//!
//! ```text
//! line:  L = |p - a|,   e = (p - a) / L
//! axis:  L = e . (p - a),   e fixed in `from`
//! both:  L' = e . (p' - a' - o x (p - a))
//! ```
//!
//! because e' = o x e for the axis, and o x (p - a) stands across the line for the line. The force T e acts on
//! `from` and -T e on `to`, both at p: equal and opposite on one line, and its power is -T L'.
//! Displacement x = L - L0 where L0 is the length in the design configuration, tension positive.

use super::attachment::{Attachment, Places, axes, axis};
use super::curve::Table;
use super::{ForceElement, Quantity, QuantityKind, Strike};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Number, Numbered, Section, SettingsError};
use nalgebra::Vector3;

/// The line that an element acts along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// From place to place.
    Line,
    /// A unit vector in the attachment axes of `from`.
    Axis(Vector3<f64>),
}

/// Two places and the line between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    pub from: Attachment,
    pub to: Attachment,
    pub direction: Direction,
    /// L0, m; signed along an axis.
    pub design_length: f64,
    /// Where `to` lies from `from` along the line or the axis, m: L0, or of their bodies' centres where both places are at the same one.
    pub away: f64,
}

/// A span at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// x, m, and L', m/s.
    pub displacement: f64,
    pub rate: f64,
    /// e, world axes.
    pub unit: Vector3<f64>,
    /// p, world, m.
    pub point: Vector3<f64>,
}

/// Places closer than this have no line between them, m: it would turn with every tremble across.
const SHORTEST: f64 = 1e-3;

impl Span {
    /// From the design configuration's vector between the places, world axes, m.
    pub fn new(from: Attachment, to: Attachment, direction: Direction, design_vector: &Vector3<f64>) -> Self {
        let design_length = match direction {
            Direction::Line => design_vector.norm(),
            Direction::Axis(axis) => axis.dot(design_vector),
        };
        Span { from, to, direction, design_length, away: design_length }
    }

    /// Reads `from`, `to` and the optional `axis`.
    pub(super) fn parse(section: &Section, places: &dyn Places) -> Result<Self, SettingsError> {
        let (from, to) = ends(section, places)?;
        let vector = places.design_vector(&from, &to);
        let direction = if section.has("axis") { Direction::Axis(axis(section, places, "axis")?) } else { Direction::Line };
        let centres = places.design_vector(&Attachment { local: Vector3::zeros(), ..from }, &Attachment { local: Vector3::zeros(), ..to });
        if direction == Direction::Line && vector.norm() < SHORTEST {
            let toward = axes(places).into_iter().map(|(name, axis)| (name, axis.dot(&centres))).max_by(|a, b| a.1.total_cmp(&b.1));
            let toward = toward.map_or("x", |(name, _)| name);
            let problem = format!(
                "both places coincide, so that there is no line between them; move one, or give an axis, which points from \"from\" to \"to\": axis = \"{toward}\" \
                 is about the way from body to body"
            );
            return Err(section.error("to", problem));
        }
        let mut span = Span::new(from, to, direction, &vector);
        if let (Direction::Axis(axis), true) = (direction, span.away.abs() < SHORTEST) {
            span.away = axis.dot(&centres);
        }
        Ok(span)
    }

    /// Refuses a stop that its line can't reach: between places that are so near, nothing is pressed before they have passed each other.
    pub(super) fn reaches(&self, section: &Section, key: &'static str, free: f64) -> Result<(), SettingsError> {
        if self.direction != Direction::Line || free < self.design_length {
            return Ok(());
        }
        let problem = format!(
            "{free} m of free travel where its places are {} m apart: they would meet before it presses, and behind that the line turns round; put them further apart (a coupler's \
             at its pivots, a buffer's behind its face), or give an axis",
            self.design_length
        );
        Err(section.error(key, problem))
    }

    /// Displacement, rate and direction now. Places that meet on a line have no direction: e = 0 and no force.
    #[inline]
    pub fn stretch(&self, bodies: &Moving) -> Stretch {
        let point = self.to.point(bodies);
        let across = point - self.from.point(bodies);
        let (unit, length) = match &self.direction {
            Direction::Line => {
                let length = across.norm();
                (if length > 0.0 { across / length } else { Vector3::zeros() }, length)
            }
            Direction::Axis(axis) => {
                let unit = self.from.axes(bodies) * axis;
                (unit, unit.dot(&across))
            }
        };
        let relative = self.to.velocity(bodies, &point) - self.from.velocity(bodies, &point);
        Stretch { displacement: length - self.design_length, rate: unit.dot(&relative), unit, point }
    }

    /// Adds how a tension T [N] of these slopes changes the wrenches, and a state of its own, the only one of `states` from `first` on.
    #[inline]
    pub fn tangent(&self, stretch: &Stretch, tension: f64, slopes: &Slopes, (first, states): (usize, usize), sum: &mut PairTangent) {
        let Stretch { displacement, unit, point, .. } = *stretch;
        let line = sum.line(&point, &unit);
        let mut stiffness = slopes.by_displacement;
        // The line turns with its ends.
        let length = displacement + self.design_length;
        if self.direction == Direction::Line && length > 0.0 {
            stiffness -= tension / length;
            sum.add_uniform_spring(&point, tension / length);
        }
        sum.add_spring(&line, &line, stiffness);
        if slopes.by_rate != 0.0 {
            sum.add_damper(&line, &line, slopes.by_rate);
        }
        sum.add_force(&point, &(unit * tension));
        if states > 0
            && let Some(own) = sum.add_states(first, 1)
        {
            own.rate_by_state[(0, 0)] = slopes.state_by_state;
            own.rate_by_position[0][0] = line * slopes.state_by_displacement;
            own.rate_by_velocity[0][0] = line * slopes.state_by_rate;
            own.load_by_state[0][0] = line * slopes.by_state;
        }
    }

    /// L0 of a line, m; `None` along an axis.
    pub fn drawn_length(&self) -> Option<f64> {
        (self.direction == Direction::Line).then_some(self.design_length)
    }

    /// Pulls both ends together with a tension, N.
    #[inline]
    pub fn pull(&self, bodies: &Moving, stretch: &Stretch, tension: f64, wrenches: &mut [Wrench]) {
        let force = stretch.unit * tension;
        self.from.load(bodies, wrenches, &force, &stretch.point, &Vector3::zeros());
        self.to.load(bodies, wrenches, &-force, &stretch.point, &Vector3::zeros());
    }
}

/// Reads `from` and `to`, which must not be on the same body.
pub(super) fn ends(section: &Section, places: &dyn Places) -> Result<(Attachment, Attachment), SettingsError> {
    let (from, to) = (places.attachment(section, "from")?, places.attachment(section, "to")?);
    if from.body == to.body {
        return Err(section.error("to", "is on the same body as \"from\", so that the element would do nothing"));
    }
    Ok((from, to))
}

/// Derivatives of a law: of its tension T and of the rate of its state z by displacement x, its rate x' and z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slopes {
    /// dT/dx, N/m; dT/dx', N s/m; dT/dz.
    pub by_displacement: f64,
    pub by_rate: f64,
    pub by_state: f64,
    /// dz'/dx, dz'/dx', dz'/dz.
    pub state_by_displacement: f64,
    pub state_by_rate: f64,
    pub state_by_state: f64,
}

/// Tension as a function of displacement x [m], its rate [m/s] and states of its own.
pub trait LineLaw: Numbered + Clone + Send + Sync + std::fmt::Debug + 'static {
    /// Number of states, at most one.
    fn states(&self) -> usize {
        0
    }

    /// Shortest time constant of the states, s.
    fn time_constant(&self) -> Option<f64> {
        None
    }

    /// States at rest.
    fn settle(&self, _x: f64, _state: &mut [f64]) {}

    /// Rates of the states.
    fn rates(&self, _x: f64, _rate: f64, _state: &[f64], _rates: &mut [f64]) {}

    /// Derivatives of tension and state rate.
    fn slopes(&self, x: f64, rate: f64, state: &[f64]) -> Slopes;

    /// T, N, tension positive.
    fn tension(&self, x: f64, rate: f64, state: &[f64]) -> f64;

    /// Stored energy, J, up to a constant.
    fn potential_energy(&self, x: f64, state: &[f64]) -> f64;

    /// W, not negative.
    fn dissipated_power(&self, x: f64, rate: f64, state: &[f64]) -> f64;

    /// Its tables.
    fn tables(&self) -> Vec<Table> {
        Vec::new()
    }

    /// Where it is in one of them.
    fn table_argument(&self, _table: usize, _x: f64, _rate: f64, _state: &[f64]) -> f64 {
        0.0
    }

    /// Displacements between which a stop is free, m.
    fn free_travel(&self) -> Option<[f64; 2]> {
        None
    }

    /// See [`ForceElement::doubt`]; `away` as in [`Span`] where it acts along an axis.
    fn doubt(&self, _away: Option<f64>) -> Option<String> {
        None
    }

    /// Of a stop: its stiffness at the displacement x [m], or where it would touch next, N/m.
    fn striking_stiffness(&self, _x: f64) -> Option<f64> {
        None
    }

    /// See [`ForceElement::static_stiffness`].
    fn static_stiffness(&self) -> Option<f64> {
        None
    }

    fn set_preload(&mut self, _force: f64) {}

    /// See [`ForceElement::pushes_alone`].
    fn pushes_alone(&self) -> bool {
        false
    }
}

/// A force element of one scalar law.
#[derive(Clone, Debug)]
pub struct LineElement<L> {
    pub name: String,
    pub span: Span,
    pub law: L,
}

/// Force and displacement.
pub(super) const QUANTITIES: [Quantity; 2] = [
    Quantity {
        number: 0,
        name: "force",
        kind: QuantityKind::Force,
        description: "force of the element, tension positive; along an axis that on \"from\"",
    },
    Quantity {
        number: 1,
        name: "displacement",
        kind: QuantityKind::Displacement,
        description: "elongation of the element from the design configuration; along an axis how far \"to\" has moved against \"from\"",
    },
];

impl<L: LineLaw> LineElement<L> {
    fn tension(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let stretch = self.span.stretch(bodies);
        self.law.tension(stretch.displacement, stretch.rate, state)
    }
}

/// An element's numbers are those of its law.
impl<L: LineLaw> Numbered for LineElement<L> {
    fn numbers(&self) -> Vec<Number> {
        self.law.numbers()
    }

    fn set_number(&mut self, number: u32, value: f64) {
        self.law.set_number(number, value);
    }
}

impl<L: LineLaw> ForceElement for LineElement<L> {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        self.law.states()
    }

    fn time_constant(&self) -> Option<f64> {
        self.law.time_constant()
    }

    fn settle(&self, bodies: &Moving, state: &mut [f64]) {
        self.law.settle(self.span.stretch(bodies).displacement, state);
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let stretch = self.span.stretch(bodies);
        self.law.rates(stretch.displacement, stretch.rate, state, rates);
        let tension = self.law.tension(stretch.displacement, stretch.rate, state);
        self.span.pull(bodies, &stretch, tension, wrenches);
    }

    fn bodies(&self) -> Ends {
        [self.span.from.body, self.span.to.body]
    }

    fn holds(&self) -> [Option<Attachment>; 2] {
        [Some(self.span.from), Some(self.span.to)]
    }

    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let stretch = self.span.stretch(bodies);
        let (x, rate) = (stretch.displacement, stretch.rate);
        let tension = self.law.tension(x, rate, state);
        self.span.tangent(&stretch, tension, &self.law.slopes(x, rate, state), (first_state, self.law.states()), sum);
    }

    fn tables(&self) -> Vec<Table> {
        self.law.tables()
    }

    fn table_argument(&self, table: usize, bodies: &Moving, state: &[f64]) -> f64 {
        let stretch = self.span.stretch(bodies);
        self.law.table_argument(table, stretch.displacement, stretch.rate, state)
    }

    fn free_travel(&self) -> Option<[f64; 2]> {
        self.law.free_travel()
    }

    fn doubt(&self) -> Option<String> {
        self.law.doubt((self.span.direction != Direction::Line).then_some(self.span.away))
    }

    fn drawn_length(&self) -> Option<f64> {
        self.span.drawn_length()
    }

    fn strike(&self, bodies: &Moving) -> Option<Strike> {
        let Stretch { displacement, unit, point, .. } = self.span.stretch(bodies);
        let stiffness = self.law.striking_stiffness(displacement)?;
        Some(Strike { stiffness, unit, point, ends: self.bodies() })
    }

    fn static_stiffness(&self) -> Vec<f64> {
        self.law.static_stiffness().into_iter().collect()
    }

    fn set_preload(&mut self, _: usize, force: f64) {
        self.law.set_preload(force);
    }

    fn pushes_alone(&self) -> bool {
        self.law.pushes_alone()
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        match index {
            0 => self.tension(bodies, state),
            1 => self.span.stretch(bodies).displacement,
            _ => 0.0,
        }
    }

    fn potential_energy(&self, bodies: &Moving, state: &[f64]) -> f64 {
        self.law.potential_energy(self.span.stretch(bodies).displacement, state)
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let stretch = self.span.stretch(bodies);
        self.law.dissipated_power(stretch.displacement, stretch.rate, state)
    }
}
