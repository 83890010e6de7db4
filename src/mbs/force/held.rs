//! A force element one of whose bodies is not modelled: what is cut away stands still beside the track and goes along with what is kept.
//!
//! A scene that is computed in less detail than it describes (`vehicle.detail`) has elements between bodies that are there and others that are not. Each of the latter
//! becomes a *guide*: it keeps height, lateral place and angles of the whole vehicle's steady running on straight track, and travels along X with one body
//! of the element, at that body's own speed,
//!
//! ```text
//! x_guide = x_followed + const,   x_guide' = x_followed',   all other coordinates constant
//! ```
//!
//! so that the element does on what is kept what it does in steady running, static load included, and resists every motion across, up, and about all axes.
//! What it does on the guide is held from outside, but along X: there the guide gives no hold (as the frame of a [`super::GuidedSpring`]), so that the force R on it acts on
//! the followed body's centre. Only R_s of steady running, a part of what was cut away that gravity pulls downhill, or what wheels there roll with, is from outside:
//!
//! ```text
//! F_x on the followed body: + R - R_s
//! ```
//!
//! Straight track alone: a curve turns and loads bodies that are not there.
//!
//! The element itself is any other: it sees its bodies in an order of their own ([`Held::new`]).

use super::{ElementInput, ForceElement, Part, Quantity, Rub, Strike, Table};
use crate::geometry::Side;
use crate::geometry::track::station::Stations;
use crate::mbs::body::{Body, BodyMotion, COORDINATES, Wrench};
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::pair::PairSum;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::mbs::twist::{Axles, Twist};
use crate::settings::Number;
use nalgebra::Vector3;

/// Bodies that an element may reach, and beside them both wheels of its axle.
const BODIES: usize = 3;
const MOTIONS: usize = BODIES + 2;

/// What stands for a body in a held element.
#[derive(Clone, Debug)]
pub enum Holder {
    /// One that is modelled, by its number.
    Body(usize),
    /// One that is not.
    Guide(Box<Guide>),
}

/// Where a body that is cut away stays.
#[derive(Clone, Copy, Debug)]
pub struct Guide {
    /// At rest; its x counts from the followed body's, m.
    still: BodyMotion,
}

impl Guide {
    /// From the coordinates of a body in steady running, and x of the body that is followed [m]; `revolution`: attachments do not follow the pitch.
    pub fn new(coordinates: &[f64], followed: f64, revolution: bool) -> Guide {
        let mut q = [0.0; COORDINATES];
        q.copy_from_slice(&coordinates[..COORDINATES]);
        q[0] -= followed;
        let still = [0.0; COORDINATES];
        Guide { still: if revolution { BodyMotion::new(&q, &still) } else { BodyMotion::general(&q, &still) } }
    }

    /// Beside the followed body.
    #[inline]
    fn beside(&self, followed: &BodyMotion) -> BodyMotion {
        let mut motion = self.still;
        motion.position.x += followed.position.x;
        motion.velocity.x = followed.velocity.x;
        (motion.distance, motion.speed) = (motion.position.x, motion.velocity.x);
        motion
    }

    /// Its motion at rest.
    pub fn motion(&self) -> &BodyMotion {
        &self.still
    }
}

/// An element between bodies and guides.
#[derive(Debug)]
pub struct Held {
    element: Box<dyn ForceElement>,
    /// Of the element's bodies, by the numbers that it knows them by.
    holders: Vec<Holder>,
    followed: usize,
    /// R_s, N.
    steady: f64,
    /// Motions of both wheels of its axle, where that twists.
    wheels: Option<[usize; 2]>,
}

impl Clone for Held {
    fn clone(&self) -> Self {
        Held { element: self.element.clone_box(), holders: self.holders.clone(), ..*self }
    }
}

impl Held {
    /// An element that numbers its bodies as `holders` does, at most three; `followed` is the number in the model of the body that guides go along with.
    /// `at_rest` has the motions of all these bodies where they are in steady running, without velocities.
    pub fn new(element: Box<dyn ForceElement>, holders: Vec<Holder>, followed: usize, at_rest: &[BodyMotion]) -> Held {
        debug_assert!(holders.len() <= BODIES && at_rest.len() == holders.len());
        let moving = Moving::from(at_rest);
        let (mut state, mut rates) = (vec![0.0; element.states()], vec![0.0; element.states()]);
        let mut wrenches = vec![Wrench::default(); at_rest.len()];
        element.settle(&moving, &mut state);
        element.apply(&moving, &state, &mut rates, &mut wrenches);
        let held = Held { element, holders, followed, steady: 0.0, wheels: None };
        Held { steady: held.reaction(&wrenches), ..held }
    }

    /// Force along X on all guides, N.
    fn reaction(&self, wrenches: &[Wrench]) -> f64 {
        let guides = self.holders.iter().zip(wrenches).filter(|(holder, _)| matches!(holder, Holder::Guide(_)));
        guides.map(|(_, wrench)| wrench.force.x).sum()
    }

    /// A body of the element as the model knows it; `None`: it is not there.
    fn outside(&self, body: Option<usize>) -> Option<usize> {
        match self.holders.get(body?) {
            Some(Holder::Body(body)) => Some(*body),
            Some(Holder::Guide(_)) => None,
            None => self.wheels?.get(body? - self.holders.len()).copied(),
        }
    }

    /// What the element sees of its bodies.
    #[inline]
    fn gather(&self, bodies: &Moving) -> [BodyMotion; MOTIONS] {
        let followed = &bodies[self.followed];
        let mut motions = [*followed; MOTIONS];
        for (motion, holder) in motions.iter_mut().zip(&self.holders) {
            match holder {
                Holder::Body(body) => *motion = bodies[*body],
                Holder::Guide(guide) => *motion = guide.beside(followed),
            }
        }
        if let Some(wheels) = self.wheels {
            for (motion, wheel) in motions.iter_mut().skip(self.holders.len()).zip(wheels) {
                *motion = bodies[wheel];
            }
        }
        motions
    }

    /// Lets the element look.
    #[inline]
    fn seen<T>(&self, bodies: &Moving, look: impl FnOnce(&dyn ForceElement, &Moving) -> T) -> T {
        let motions = self.gather(bodies);
        look(self.element.as_ref(), &Moving { motions: &motions, stations: Stations::NONE, inputs: bodies.inputs })
    }
}

impl Part for Held {
    /// All but preloads, and lengths that make them: the whole vehicle would settle anew, and the guides do not.
    fn constants(&self) -> Vec<Number> {
        let mut all = self.element.constants();
        all.retain(|number| !(number.name.starts_with("preload") || number.name == "naturalLength"));
        all
    }

    fn set_constant(&mut self, number: u32, value: f64) {
        self.element.set_constant(number, value);
    }

    fn clone_box(&self) -> Box<dyn ForceElement> {
        Box::new(self.clone())
    }
}

impl ForceElement for Held {
    fn name(&self) -> &str {
        self.element.name()
    }

    fn states(&self) -> usize {
        self.element.states()
    }

    fn time_constant(&self) -> Option<f64> {
        self.element.time_constant()
    }

    fn state_weight(&self) -> f64 {
        self.element.state_weight()
    }

    fn inputs(&self) -> &'static [ElementInput] {
        self.element.inputs()
    }

    fn start_input(&self, index: usize) -> f64 {
        self.element.start_input(index)
    }

    fn turns_axle(&self) -> bool {
        self.element.turns_axle()
    }

    fn torsion(&self) -> Option<usize> {
        self.element.torsion()
    }

    fn swings_when_locked(&self) -> bool {
        self.element.swings_when_locked()
    }

    fn own_inertia(&self) -> Option<(usize, &'static str, f64)> {
        self.element.own_inertia()
    }

    fn rotor_on_axle(&self) -> Option<(usize, f64)> {
        let (axle, inertia) = self.element.rotor_on_axle()?;
        Some((self.outside(Some(axle))?, inertia))
    }

    fn rotor_carrier(&self) -> Option<usize> {
        self.outside(self.element.rotor_carrier())
    }

    fn wheel(&self) -> Option<usize> {
        self.outside(self.element.wheel())
    }

    fn twist(&self) -> Option<Twist> {
        None
    }

    fn fit(&mut self, axles: &Axles) {
        let axle = self.element.reach()[0];
        let global = self.outside(axle).filter(|global| axles.twisted.contains(global));
        self.wheels = global.map(|global| Side::BOTH.map(|side| axles.turning(global, side)));
        // As many bodies as the element knows of; which ones does not matter.
        let known: Vec<Body> = axles.bodies.iter().cycle().take(self.holders.len()).cloned().collect();
        let twisted: Vec<usize> = axle.filter(|_| global.is_some()).into_iter().collect();
        self.element.fit(&Axles { bodies: &known, twisted: &twisted });
    }

    fn angular_momentum(&self, bodies: &Moving, state: &[f64]) -> Vector3<f64> {
        self.seen(bodies, |element, moving| element.angular_momentum(moving, state))
    }

    /// With that of R_s.
    fn supplied_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let inside = self.seen(bodies, |element, moving| element.supplied_power(moving, state));
        inside - self.steady * bodies[self.followed].velocity.x
    }

    fn is_supplied(&self) -> bool {
        true
    }

    fn is_dissipative(&self) -> bool {
        self.element.is_dissipative()
    }

    fn settle(&self, bodies: &Moving, state: &mut [f64]) {
        self.seen(bodies, |element, moving| element.settle(moving, state));
    }

    fn rub(&self, bodies: &Moving) -> Option<Rub> {
        self.seen(bodies, |element, moving| element.rub(moving))
    }

    fn drag(&self, from: &Rub, bodies: &Moving, state: &mut [f64]) {
        self.seen(bodies, |element, moving| element.drag(from, moving, state));
    }

    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let mut own = [Wrench::default(); MOTIONS];
        self.seen(bodies, |element, moving| element.apply(moving, state, rates, &mut own));
        wrenches[self.followed].force.x += self.reaction(&own) - self.steady;
        for (wrench, body) in own.iter().zip(0..) {
            if let Some(outside) = self.outside(Some(body)) {
                wrenches[outside] += *wrench;
            }
        }
    }

    fn bodies(&self) -> Ends {
        self.element.bodies().map(|body| self.outside(body))
    }

    /// A guide goes along with the followed body: where that is the element's only one, nothing changes with its place and speed along X, nor does the force along X. Of
    /// an element with two bodies and a guide this is left out.
    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let before = sum.states.len();
        let alone = self.bodies().iter().flatten().count() == 1;
        let mut own = PairSum::new(sum.sum.ends, sum.sum.spinning);
        {
            let mut part = PairTangent {
                sum: if alone { &mut own } else { sum.sum },
                carrier: sum.carrier.as_deref_mut(),
                far: sum.far.as_deref_mut(),
                across: sum.across,
                pair: sum.pair,
                reference: sum.reference,
                states: sum.states,
            };
            self.seen(bodies, |element, moving| element.tangent(moving, state, first_state, &mut part));
        }
        for state in &mut sum.states[before..] {
            state.far = state.far.and_then(|(body, load)| Some((self.outside(Some(body))?, load)));
            if alone {
                let gradients = state.rate_by_position.iter_mut().chain(&mut state.rate_by_velocity).chain(&mut state.load_by_state);
                gradients.flatten().for_each(|gradient| gradient.x = 0.0);
            }
        }
        if alone {
            for matrix in [&mut own.stiffness, &mut own.damping] {
                matrix.column_mut(0).fill(0.0);
                matrix.row_mut(0).fill(0.0);
            }
            sum.sum.add(&own);
        }
    }

    fn quantities(&self) -> &'static [Quantity] {
        self.element.quantities()
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        self.seen(bodies, |element, moving| element.quantity(index, moving, state))
    }

    fn tables(&self) -> Vec<Table> {
        self.element.tables()
    }

    fn table_argument(&self, table: usize, bodies: &Moving, state: &[f64]) -> f64 {
        self.seen(bodies, |element, moving| element.table_argument(table, moving, state))
    }

    fn free_travel(&self) -> Option<[f64; 2]> {
        self.element.free_travel()
    }

    fn doubt(&self) -> Option<String> {
        self.element.doubt()
    }

    fn drawn_length(&self) -> Option<f64> {
        self.element.drawn_length()
    }

    fn strike(&self, bodies: &Moving) -> Option<Strike> {
        self.seen(bodies, |element, moving| element.strike(moving))
    }

    fn presses(&self) -> Option<Vector3<f64>> {
        self.element.presses()
    }

    fn pushes_alone(&self) -> bool {
        self.element.pushes_alone()
    }

    /// Preloads are those of the whole vehicle.
    fn set_preload(&mut self, index: usize, force: f64) {
        self.element.set_preload(index, force);
    }

    fn potential_energy(&self, bodies: &Moving, state: &[f64]) -> f64 {
        self.seen(bodies, |element, moving| element.potential_energy(moving, state))
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        self.seen(bodies, |element, moving| element.dissipated_power(moving, state))
    }
}
