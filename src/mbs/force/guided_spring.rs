//! Springs and dampers between an axle and a frame that travels with it on the track's centre line.
//!
//! Two of them in each direction that is called for, one at either end of the axle: `F = -k d - c d'` along one track axis (X or Y), where d
//! is the displacement of the attachment point from its place in the centred position, so that the force vanishes there. The attachment
//! points sit in the axle frame and do not spin; the force acts on the axle at the point. The element's line does not turn with the axle
//! (the difference is of the order of yaw squared times the force: below 1e-5 of it at 3 mrad).
//!
//! On a curved track the frame is the track frame at the body's distance: with its axis e (X or Y), its travel s' and the point p
//!
//! ```text
//! along X:  d = (p - P) . X - d0,  d' = (p' - P') . X + (p - P) . X_s s'
//! along Y:  d = (p - C) . Y - d0,  d' = p' . Y + (p - C) . Y_s s'
//! ```
//!
//! Such a frame is driven along the track, so that it may do work on the body.

use super::{ForceElement, Parse, Places, Quantity, QuantityKind};
use crate::geometry::track::station::Station;
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError};
use crate::units::{Dimension, Unit};
use nalgebra::{Vector3, vector};

/// Spring and damper of one direction, each of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guide {
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m.
    pub damping: f64,
}

/// Guidance of one body; a direction that the scene does not call for has no springs.
#[derive(Debug, Clone)]
pub struct GuidedSpring {
    pub name: String,
    pub body: usize,
    /// Between the attachment points, m.
    pub distance: f64,
    /// Along X; the frame follows the body's own distance along the track.
    pub longitudinal: Option<Guide>,
    /// Along Y.
    pub lateral: Option<Guide>,
}

/// One spring at one instant.
struct Spring {
    guide: Guide,
    /// d, m, and d', m/s.
    displacement: f64,
    rate: f64,
    /// World, m.
    point: Vector3<f64>,
    axis: Vector3<f64>,
    along: bool,
}

impl Spring {
    #[inline]
    fn force(&self) -> f64 {
        -self.guide.stiffness * self.displacement - self.guide.damping * self.rate
    }
}

impl GuidedSpring {
    /// In axle axes, left and right, m.
    fn attachments(&self) -> [Vector3<f64>; 2] {
        [vector![0.0, 0.5 * self.distance, 0.0], vector![0.0, -0.5 * self.distance, 0.0]]
    }

    fn guide(&self, along: bool) -> Option<Guide> {
        if along { self.longitudinal } else { self.lateral }
    }

    /// The spring of one direction (along X or not) at an attachment point, beside a curved track's station where there is one.
    #[inline]
    fn spring(&self, guide: Guide, along: bool, attachment: &Vector3<f64>, body: &BodyMotion, station: Option<&Station>) -> Spring {
        let point = body.attachment_point(attachment);
        let velocity = body.attachment_velocity(&point);
        let local = if along { Vector3::x() } else { Vector3::y() };
        let Some(station) = station else {
            let (displacement, rate) = match along {
                // The frame's X is the centre's X, its speed the centre's speed.
                true => (point.x - body.position.x - attachment.x, velocity.x - body.velocity.x),
                false => (point.y - attachment.y, velocity.y),
            };
            return Spring { guide, displacement, rate, point, axis: local, along };
        };
        let frame = &station.frame;
        let axis = frame.axes * local;
        let axis_rate = frame.axes * frame.turn.cross(&local) * station.travel;
        let (arm, arm_rate, centred) = match along {
            true => (point - body.position, velocity - body.velocity, attachment.x),
            // The origin moves along X.
            false => (point - frame.origin, velocity, attachment.y),
        };
        let (displacement, rate) = (arm.dot(&axis) - centred, arm_rate.dot(&axis) + arm.dot(&axis_rate));
        Spring { guide, displacement, rate, point, axis, along }
    }

    #[inline]
    fn each(&self, body: &BodyMotion, station: Option<&Station>, mut visit: impl FnMut(&Spring)) {
        let attachments = self.attachments();
        for along in [true, false] {
            let Some(guide) = self.guide(along) else { continue };
            for attachment in &attachments {
                visit(&self.spring(guide, along, attachment, body, station));
            }
        }
    }

    fn sum(&self, bodies: &Moving, of: impl Fn(&Spring) -> f64) -> f64 {
        let mut sum = 0.0;
        self.each(&bodies[self.body], bodies.station(self.body), |spring| sum += of(spring));
        sum
    }
}

fn stored(spring: &Spring) -> f64 {
    0.5 * spring.guide.stiffness * spring.displacement * spring.displacement
}

fn dissipated(spring: &Spring) -> f64 {
    spring.guide.damping * spring.rate * spring.rate
}

const fn force(number: u32, name: &'static str) -> Quantity {
    let description = "force of the suspension element on the wheelset along its track axis (X forward, Y left positive)";
    Quantity { number, name, kind: QuantityKind::Force, description }
}

const QUANTITIES: [Quantity; 4] = [
    force(0, "left.longitudinalForce"),
    force(1, "right.longitudinalForce"),
    force(2, "left.lateralForce"),
    force(3, "right.lateralForce"),
];

/// A number of one direction's springs.
macro_rules! guide {
    ($number:literal, $name:literal, $direction:ident, $field:ident, $unit:ident, $text:literal) => {
        Constant {
            number: $number,
            name: $name,
            unit: Unit::$unit,
            least: Some(0.0),
            tunable: true,
            description: $text,
            get: |element: &GuidedSpring| element.$direction.map(|guide| guide.$field),
            set: |element, value| element.$direction.iter_mut().for_each(|guide| guide.$field = value),
        }
    };
}

impl Numbered for GuidedSpring {
    const CONSTANTS: &'static [Constant<Self>] = &[
        guide!(0, "longitudinalStiffness", longitudinal, stiffness, NewtonPerMetre, "stiffness of each longitudinal element"),
        guide!(1, "longitudinalDamping", longitudinal, damping, NewtonSecondPerMetre, "damping of each longitudinal element"),
        guide!(2, "lateralStiffness", lateral, stiffness, NewtonPerMetre, "stiffness of each lateral element"),
        guide!(3, "lateralDamping", lateral, damping, NewtonSecondPerMetre, "damping of each lateral element"),
    ];
}

impl ForceElement for GuidedSpring {
    fn name(&self) -> &str {
        &self.name
    }

    #[inline]
    fn apply(&self, bodies: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let body = &bodies[self.body];
        self.each(body, bodies.station(self.body), |spring| {
            wrenches[self.body].add_at(spring.axis * spring.force(), &spring.point, &body.position)
        });
    }

    /// From the frame on the track to the body.
    fn bodies(&self) -> Ends {
        [None, Some(self.body)]
    }

    /// The frame's turning along a curved track is left out (curvature times displacement beside one, 1e-4), and the moment about the
    /// axle of a place off the axle's line.
    fn tangent(&self, bodies: &Moving, _: &[f64], _: usize, sum: &mut PairTangent) {
        self.each(&bodies[self.body], bodies.station(self.body), |spring| {
            let load = sum.line(&spring.point, &spring.axis);
            let mut measured = load;
            if spring.along {
                measured.fixed_rows_mut::<3>(0).fill(0.0);
            }
            sum.add_spring(&load, &measured, spring.guide.stiffness);
            sum.add_damper(&load, &measured, spring.guide.damping);
            sum.add_force(&spring.point, &(spring.axis * -spring.force()));
        });
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES[if self.longitudinal.is_some() { 0 } else { 2 }..if self.lateral.is_some() { 4 } else { 2 }]
    }

    fn quantity(&self, index: usize, bodies: &Moving, _: &[f64]) -> f64 {
        let Some(quantity) = self.quantities().get(index) else { return 0.0 };
        let (along, side) = (quantity.number < 2, quantity.number as usize % 2);
        let spring = |guide| self.spring(guide, along, &self.attachments()[side], &bodies[self.body], bodies.station(self.body));
        self.guide(along).map_or(0.0, |guide| spring(guide).force())
    }

    fn potential_energy(&self, bodies: &Moving, _: &[f64]) -> f64 {
        self.sum(bodies, stored)
    }

    fn dissipated_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        self.sum(bodies, dissipated)
    }
}

/// Most distance between the springs, m: further apart, no step would be short enough for their yaw stiffness.
const WIDEST: f64 = 10.0;

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let guide = |stiffness, damping| -> Result<Option<Guide>, SettingsError> {
        let stiffness = section.not_negative(stiffness, Dimension::Stiffness)?;
        let damping = section.not_negative(damping, Dimension::Damping)?;
        Ok((stiffness != 0.0 || damping != 0.0).then_some(Guide { stiffness, damping }))
    };
    Ok(Box::new(GuidedSpring {
        name: places.name(section)?,
        body: places.body(section, "body")?,
        distance: section.within("distance", Dimension::Length, (0.0, WIDEST))?,
        longitudinal: guide("longitudinal_stiffness", "longitudinal_damping")?,
        lateral: guide("lateral_stiffness", "lateral_damping")?,
    }))
}

pub const ENTRY: Entry<Parse> = Entry {
    name: "guided_spring",
    summary: "springs and dampers along the track's axes between both ends of an axle and a frame that travels with it on the centre line",
    reference: "paper, section 3.4",
    parse,
};
