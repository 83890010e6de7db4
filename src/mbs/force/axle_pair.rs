//! How a torque about an axle and its reaction act: on the axle, and on what carries motor or brake.
//!
//! A torque T [N m] on the axle, positive forward (about its y axis), goes along with a wrench on the axle and the opposite one on the carrier, so
//! that momentum and angular momentum of the bodies are kept:
//!
//! ```text
//! couple:  T y on the axle, -T y on the carrier, y the carrier's own y axis (a shaft with joints, a disc's caliper)
//! line:    the force T u / L on the axle's body at the place p of the carrier, the opposite one on the carrier there (a nose link, a tread)
//! ```
//!
//! with u a unit vector fixed in the carrier and the lever L such that in the design configuration the force at p has the moment T about the axle. The axle takes
//! the whole moment, about its spinning axis too, unlike what its bearings hold (see [`super::Attachment`]).
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
use nalgebra::{Vector3, Vector6};

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
    /// u / L in these axes, 1/m; `None`: a couple.
    line: Option<Vector3<f64>>,
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
    Ok((AxlePair { axle, side: None, turning: axle, carrier, place: from.local, line: None }, arm))
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
    /// The same by a force along `per_torque` [1/m, the carrier's axes] at the carrier's place.
    pub fn along(self, per_torque: Vector3<f64>) -> AxlePair {
        AxlePair { line: Some(per_torque), ..self }
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

    /// Wrenches on axle and carrier of a force on the axle at the carrier's place and a couple on it, world axes.
    #[inline]
    pub fn opposite(&self, bodies: &Moving, force: &Vector3<f64>, couple: &Vector3<f64>) -> [Wrench; 2] {
        let point = self.point(bodies);
        let at = |body: usize, sign: f64| {
            let force = force * sign;
            Wrench { force, moment: (point - bodies[body].position).cross(&force) + couple * sign }
        };
        [at(self.turning, 1.0), at(self.carrier, -1.0)]
    }

    /// Force and couple on the axle for T = 1, world axes.
    #[inline]
    fn unit(&self, bodies: &Moving) -> [Vector3<f64>; 2] {
        let axes = &bodies[self.carrier].frame.axes;
        match &self.line {
            Some(per_torque) => [axes * per_torque, Vector3::zeros()],
            None => [Vector3::zeros(), axes.column(1).into_owned()],
        }
    }

    /// Wrenches on axle and carrier for T = 1.
    #[inline]
    pub fn wrenches(&self, bodies: &Moving) -> [Wrench; 2] {
        let [force, couple] = self.unit(bodies);
        self.opposite(bodies, &force, &couple)
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

    /// Hands in how wrenches of a constant torque change as the bodies turn.
    pub fn turning(&self, bodies: &Moving, torque: f64, sum: &mut PairTangent) {
        let [force, couple] = self.unit(bodies);
        sum.add_force_of_to(&self.point(bodies), &(force * torque));
        sum.add_couple_of_to(&(couple * torque));
    }
}
