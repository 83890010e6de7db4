//! How a torque about an axle and its reaction act: on the axle, and on what carries motor or brake.
//!
//! A torque T [N m] on the axle, positive forward (about its y axis), goes along with a wrench on the axle and the opposite one on the carrier, so
//! that momentum and angular momentum of the bodies are kept:
//!
//! ```text
//! couple:  T y on the axle, -T y on the carrier, y the carrier's own y axis (a shaft with joints, a disc's caliper)
//! link:    the force T u / l on the axle's body at the place p of the carrier, the opposite one on the carrier there (a nose link, a torque arm)
//! tread:   the force T u / L at the place beside p whose lever is L, the opposite one on the carrier there (a block follows its tread)
//! ```
//!
//! with u a unit vector fixed in the carrier, L the lever of p about the axle in the design configuration and `l = u . (a x (p - c))` that at
//! present, a the axle's direction and c its middle: whatever hands T over sits on the axle's bearings, and has no more or less of it where the axle has moved in
//! its guides. (A force at p of the lever L would have T l / L about the axle, and rho would be off by the axle's whole speed times l / L - 1: 13 mm of 0.7 m are 2 % of the
//! tractive force.) The axle takes the whole moment, about its spinning axis too, unlike what its bearings hold (see [`super::Attachment`]).
//!
//! The rate that goes with T is `rho = sum of (wrench for T = 1) . (twist of its body)`, rad/s: the speed of the axle against the carrier,
//! positive forward. `T rho` is the power of both wrenches at every motion.

use super::attachment::{Attachment, Places};
use crate::geometry::Side;
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, Gradient, PairTangent};
use crate::mbs::twist::Axles;
use crate::settings::{Section, SettingsError};
use nalgebra::{Matrix3, Vector3, Vector6};
use std::ops::AddAssign;

/// An axle, or one of its wheels, and the carrier of what turns it.
#[derive(Clone, Debug)]
pub struct AxlePair {
    pub axle: usize,
    /// The wheel that is turned, of an axle that may twist; `None`: the whole axle.
    pub side: Option<Side>,
    /// Whose motion and wrench that is: the axle's, or those of the wheel ([`crate::mbs::twist`]).
    pub turning: usize,
    pub carrier: usize,
    /// p in the carrier's attachment axes, m.
    place: Vector3<f64>,
    /// How far from the axle's line the place lies that was given for the axle, m.
    off: f64,
    by: By,
}

/// A place so far from its axle is on another one, m: the least wheelbases are three times as long.
const ANOTHER: f64 = 0.6;

/// What hands the torque over.
#[derive(Clone, Copy, Debug)]
enum By {
    Couple,
    /// u / L in the carrier's axes, 1/m.
    Link(Vector3<f64>),
    Tread(Vector3<f64>),
}

/// Least part of its design lever that a link keeps: it is no link any more where the axle has come so far.
const LEAST_LEVER: f64 = 0.1;

/// A torque's force at present.
struct Line {
    /// Force for T = 1, 1/m, world axes, and the place where it acts, m.
    force: Vector3<f64>,
    point: Vector3<f64>,
    /// From the axle's middle to p, m.
    arm: Vector3<f64>,
    /// u / L, and l / L.
    per_torque: Vector3<f64>,
    lever: f64,
}

/// Two bodies and their places from the keys `carrier` and `to` (the axle); the vector is that from the axle to the carrier's place.
pub(super) fn read_pair(section: &Section, places: &dyn Places, carrier: &'static str) -> Result<(AxlePair, Vector3<f64>), SettingsError> {
    let (from, to) = (places.attachment(section, carrier)?, places.attachment(section, "to")?);
    if from.body == to.body {
        return Err(section.error("to", format!("is on the same body as \"{carrier}\", so that the element would do nothing")));
    }
    let body = |key, place: &Attachment| {
        place.body.ok_or_else(|| section.error(key, "is the world; expected a body: what turns an axle must be carried by one"))
    };
    let (carrier, axle) = (body(carrier, &from)?, body("to", &to)?);
    let arm = places.design_vector(&Attachment::on(axle, Vector3::zeros()), &from);
    let off = to.local.x.hypot(to.local.z);
    Ok((AxlePair { axle, side: None, turning: axle, carrier, place: from.local, off, by: By::Couple }, arm))
}

/// The same with the key `from`, and the wheel that is turned.
pub(super) fn read_ends(section: &Section, places: &dyn Places) -> Result<(AxlePair, Vector3<f64>), SettingsError> {
    let (pair, arm) = read_pair(section, places, "from")?;
    let side = match section.word_or("wheel", &["both", "left", "right"], "both")? {
        "both" => None,
        word if (word == "left") == (places.mirror() > 0.0) => Some(Side::Left),
        _ => Some(Side::Right),
    };
    Ok((AxlePair { side, ..pair }, arm))
}

impl AxlePair {
    /// The same by a link along `per_torque` [1/m, the carrier's axes: u / L] at the carrier's place.
    pub fn by_link(self, per_torque: Vector3<f64>) -> AxlePair {
        AxlePair { by: By::Link(per_torque), ..self }
    }

    /// The same by friction on a tread, along `per_torque` as there.
    pub fn on_tread(self, per_torque: Vector3<f64>) -> AxlePair {
        AxlePair { by: By::Tread(per_torque), ..self }
    }

    /// See [`super::ForceElement::doubt`].
    pub fn doubt(&self) -> Option<String> {
        (self.off > ANOTHER).then(|| {
            format!(
                "\"to\" names an axle and a place {:.2} m away from it: it turns the axle that is named, wherever the place is; was the wheelset there meant?",
                self.off
            )
        })
    }

    /// See [`super::ForceElement::holds`]: of a couple the place is of no account.
    pub fn holds(&self) -> [Option<Attachment>; 2] {
        let lever = !matches!(self.by, By::Couple);
        [lever.then(|| Attachment::on(self.carrier, self.place)), None]
    }

    pub fn ends(&self) -> Ends {
        [Some(self.axle), Some(self.carrier)]
    }

    /// Finds the wheel that is turned.
    pub fn fit(&mut self, axles: &Axles) {
        self.turning = self.side.map_or(self.axle, |side| axles.turning(self.axle, side));
    }

    /// The wheel, where it may turn against the axle.
    pub fn wheel(&self) -> Option<usize> {
        (self.turning != self.axle).then_some(self.turning)
    }

    /// p in the world, m.
    #[inline]
    pub fn point(&self, bodies: &Moving) -> Vector3<f64> {
        bodies[self.carrier].attachment_point(&self.place)
    }

    /// Wrenches on axle and carrier of a force on the axle at the carrier's place, world axes.
    #[inline]
    pub fn opposite(&self, bodies: &Moving, force: &Vector3<f64>) -> [Wrench; 2] {
        self.at(bodies, &self.point(bodies), force)
    }

    #[inline]
    fn at(&self, bodies: &Moving, point: &Vector3<f64>, force: &Vector3<f64>) -> [Wrench; 2] {
        let on = |body: usize, sign: f64| {
            let force = force * sign;
            Wrench { force, moment: (point - bodies[body].position).cross(&force) }
        };
        [on(self.turning, 1.0), on(self.carrier, -1.0)]
    }

    /// a.
    #[inline]
    fn direction(&self, bodies: &Moving) -> Vector3<f64> {
        bodies[self.axle].frame.axes.column(1).into_owned()
    }

    /// The force of a torque; `None`: it is a couple.
    #[inline]
    fn line(&self, bodies: &Moving) -> Option<Line> {
        let (local, tread) = match &self.by {
            By::Couple => return None,
            By::Link(local) => (local, false),
            By::Tread(local) => (local, true),
        };
        let per_torque = bodies[self.carrier].frame.axes * local;
        let (point, axle) = (self.point(bodies), self.direction(bodies));
        let arm = point - bodies[self.turning].position;
        let lever = per_torque.dot(&axle.cross(&arm));
        let aside = per_torque.cross(&axle);
        Some(match tread {
            true => Line { force: per_torque, point: point + aside * ((1.0 - lever) / aside.norm_squared()), arm, per_torque, lever },
            false => Line { force: per_torque / lever.max(LEAST_LEVER), point, arm, per_torque, lever },
        })
    }

    /// Wrenches on axle and carrier for T = 1.
    #[inline]
    pub fn wrenches(&self, bodies: &Moving) -> [Wrench; 2] {
        match self.line(bodies) {
            Some(line) => self.at(bodies, &line.point, &line.force),
            None => {
                let couple = bodies[self.carrier].frame.axes.column(1);
                [1.0, -1.0].map(|sign| Wrench { force: Vector3::zeros(), moment: couple * sign })
            }
        }
    }

    /// Power of two wrenches on axle and carrier, W; with those for T = 1 it is rho, rad/s.
    #[inline]
    pub fn power(&self, bodies: &Moving, wrenches: &[Wrench; 2]) -> f64 {
        let of = |body: usize, wrench: &Wrench| wrench.force.dot(&bodies[body].velocity) + wrench.moment.dot(&bodies[body].rotation);
        of(self.turning, &wrenches[0]) + of(self.carrier, &wrenches[1])
    }

    /// Adds both wrenches times `torque` to those of the bodies.
    #[inline]
    pub fn load(&self, unit: &[Wrench; 2], torque: f64, wrenches: &mut [Wrench]) {
        for (body, unit) in [self.turning, self.carrier].into_iter().zip(unit) {
            wrenches[body] += Wrench { force: unit.force * torque, moment: unit.moment * torque };
        }
    }

    /// Generalised forces of two wrenches on the coordinates of axle and carrier: also how rho changes with their velocities.
    pub fn gradient(&self, bodies: &Moving, wrenches: &[Wrench; 2]) -> Gradient {
        [(self.turning, &wrenches[0]), (self.carrier, &wrenches[1])]
            .map(|(body, wrench)| Vector6::from_iterator(bodies[body].generalised_force(wrench).iter().copied()))
    }

    /// Hands in how wrenches of a constant torque change as the bodies move: with the carrier, in which place and direction are fixed, and as the lever
    /// changes by `-e . c + (a x (r x u / L)) . turn`, e = u / L x a, r = p - c, of the axle against the carrier.
    pub fn turning(&self, bodies: &Moving, torque: f64, sum: &mut PairTangent) {
        let Some(Line { force, point, arm, per_torque, lever }) = self.line(bodies) else {
            return sum.add_couple_of_to(&(bodies[self.carrier].frame.axes.column(1) * torque));
        };
        sum.add_force_of_to(&point, &(force * torque));
        let axle = self.direction(bodies);
        let aside = per_torque.cross(&axle);
        let mut measured = -sum.line(&bodies[self.turning].position, &aside);
        let turned = axle.cross(&arm.cross(&per_torque));
        measured.fixed_rows_mut::<3>(3).add_assign(&turned);
        if matches!(self.by, By::Tread(_)) {
            // The place moves by g e along the carrier, so that its lever stays: g = (1 - l / L) / e^2, and e turns with the axle.
            let (square, leant) = (aside.norm_squared(), force.dot(&axle));
            let moved = (1.0 - lever) / square;
            measured.fixed_rows_mut::<3>(3).add_assign(&(aside * (2.0 * moved * leant)));
            let couple = aside.cross(&force) * torque;
            let load = Vector6::new(0.0, 0.0, 0.0, couple.x, couple.y, couple.z);
            sum.add_spring(&load, &measured, 1.0 / square);
            let turned = force.cross_matrix() * leant + axle.cross(&force) * force.transpose();
            sum.add_turning(&(turned * (torque * moved)), &Matrix3::zeros());
        } else if lever > LEAST_LEVER {
            let load = sum.line(&point, &(force * torque));
            sum.add_spring(&load, &measured, 1.0 / lever);
        }
    }
}
