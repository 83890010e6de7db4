//! Force and moment from outside at a place of a body: wind, a tilting or guiding actuator of another model, a tow rope.
//!
//! The inputs are force [N] and moment [N m] along the axes of the track beside the body (`axes = "track"`) or of the body itself (`"body"`); the force acts at the place
//! `on`, which moves with the body. The right one of a mirrored pair counts y, and moments about x and z, in the mirrored direction. On a wheelset the place is that of an axle box,
//! which hands on no moment about the axle ([`super::Attachment`]): that is what a `motor_gear` is for.

use super::along_track::read_place_of_body;
use super::attachment::{Attachment, Places};
use super::{ElementInput, ForceElement, Parse, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Unit;
use nalgebra::{Matrix3, Vector3};

/// Force and moment on one body.
#[derive(Clone, Debug)]
pub struct ExternalLoad {
    pub name: String,
    pub body: usize,
    pub place: Attachment,
    /// Are the axes the body's? Otherwise the track's.
    pub own_axes: bool,
    /// -1 in a mirrored copy.
    pub mirror: f64,
}

impl ExternalLoad {
    #[inline]
    fn axes(&self, bodies: &Moving) -> Matrix3<f64> {
        if self.own_axes {
            return self.place.axes(bodies);
        }
        bodies.station(self.body).map_or_else(Matrix3::identity, |station| station.frame.axes)
    }

    /// Force and moment in the world.
    #[inline]
    fn applied(&self, bodies: &Moving) -> [Vector3<f64>; 2] {
        let axes = self.axes(bodies);
        let [x, y, z, a, b, c] = std::array::from_fn(|i| bodies.input(i));
        [axes * Vector3::new(x, self.mirror * y, z), axes * Vector3::new(self.mirror * a, b, self.mirror * c)]
    }
}

macro_rules! input {
    ($number:literal, $name:literal, $unit:ident, $text:literal) => {
        ElementInput { number: $number, name: $name, unit: Unit::$unit, least: None, description: $text }
    };
}

const INPUTS: [ElementInput; 6] = [
    input!(0, "forceX", Newton, "force on the body at the place, forward positive"),
    input!(1, "forceY", Newton, "force on the body at the place, left positive (mirrored copies: right)"),
    input!(2, "forceZ", Newton, "force on the body at the place, up positive"),
    input!(3, "momentX", NewtonMetre, "moment on the body, left side up positive (mirrored copies: the other way)"),
    input!(4, "momentY", NewtonMetre, "moment on the body, nose down positive"),
    input!(5, "momentZ", NewtonMetre, "moment on the body, nose left positive (mirrored copies: nose right)"),
];

const QUANTITIES: [Quantity; 1] =
    [Quantity { number: 0, name: "power", kind: QuantityKind::Power, description: "power of force and moment on the body" }];

impl Numbered for ExternalLoad {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(0, "placeX", Distance, None, "place along the body's x axis, from its centre of mass", place.local.x),
        constant!(1, "placeY", Distance, None, "place along the body's y axis, from its centre of mass", place.local.y),
        constant!(2, "placeZ", Distance, None, "place along the body's z axis, from its centre of mass", place.local.z),
    ];
}

impl ForceElement for ExternalLoad {
    fn name(&self) -> &str {
        &self.name
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

    fn supplied_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let [force, moment] = self.applied(bodies);
        force.dot(&self.place.velocity(bodies, &self.place.point(bodies))) + moment.dot(&self.place.rotation(bodies))
    }

    #[inline]
    fn apply(&self, bodies: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let [force, moment] = self.applied(bodies);
        self.place.load(bodies, wrenches, &force, &self.place.point(bodies), &moment);
    }

    fn bodies(&self) -> Ends {
        [Some(self.body), None]
    }

    /// The track's own turn is left out.
    fn tangent(&self, bodies: &Moving, _: &[f64], _: usize, sum: &mut PairTangent) {
        let ([force, moment], point) = (self.applied(bodies), self.place.point(bodies));
        if self.own_axes {
            sum.add_own_force(&point, &force);
            sum.add_couple(&moment);
        } else {
            sum.add_outer_force(&point, &force);
            sum.add_couple_of_to(&moment);
        }
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        if index == 0 { self.supplied_power(bodies, state) } else { 0.0 }
    }

    fn potential_energy(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }

    fn dissipated_power(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (body, place) = read_place_of_body(section, places)?;
    let own_axes = section.word_or("axes", &["track", "body"], "track")? == "body";
    Ok(Box::new(ExternalLoad { name: places.name(section)?, body, place, own_axes, mirror: places.mirror() }))
}

pub(super) const ENTRY: Entry<Parse> =
    Entry { name: "external_load", summary: "force and moment from outside at a place of a body, as inputs", reference: "", parse };
