//! A force from outside on a place of a body along the track: what resists running without touching other bodies.
//!
//! Along X, the track's direction beside the body, acts F(v) with the place's speed v along it; the rails or the air take the reaction. On a wheelset the place is that of an
//! axle box, which hands on no moment about the axle ([`super::Attachment`]).

use super::attachment::{Attachment, Places};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Section, SettingsError};
use nalgebra::{Vector3, Vector6};

/// A place of a body on its track.
#[derive(Clone, Copy, Debug)]
pub struct AlongTrack {
    body: usize,
    place: Attachment,
}

/// The place at the key `on`.
pub(super) fn read_place(section: &Section, places: &dyn Places) -> Result<AlongTrack, SettingsError> {
    let (body, place) = read_place_of_body(section, places)?;
    Ok(AlongTrack { body, place })
}

/// The body and its place at the key `on`, which is not the world's.
pub(super) fn read_place_of_body(section: &Section, places: &dyn Places) -> Result<(usize, Attachment), SettingsError> {
    let place = places.attachment(section, "on")?;
    let body = place.body.ok_or_else(|| section.error("on", "is the world; expected a body"))?;
    Ok((body, place))
}

impl AlongTrack {
    #[inline]
    fn along(&self, bodies: &Moving) -> Vector3<f64> {
        bodies.stations.along(self.body)
    }

    /// v, m/s.
    #[inline]
    pub fn speed(&self, bodies: &Moving) -> f64 {
        self.place.velocity(bodies, &self.place.point(bodies)).dot(&self.along(bodies))
    }

    /// Loads the body with a force [N] forward.
    #[inline]
    pub fn load(&self, bodies: &Moving, force: f64, wrenches: &mut [Wrench]) {
        let force = self.along(bodies) * force;
        self.place.load(bodies, wrenches, &force, &self.place.point(bodies), &Vector3::zeros());
    }

    pub fn ends(&self) -> Ends {
        [Some(self.body), None]
    }

    /// What [`PairTangent::line`] has for the place along the track.
    pub fn line(&self, bodies: &Moving, sum: &PairTangent) -> Vector6<f64> {
        sum.line(&self.place.point(bodies), &self.along(bodies))
    }

    /// Hands in the changes of a force F with dF/dv = `slope` [N s/m]; the track's own turn is left out.
    pub fn tangent(&self, bodies: &Moving, force: f64, slope: f64, sum: &mut PairTangent) {
        let (along, point) = (self.along(bodies), self.place.point(bodies));
        sum.add_outer_force(&point, &(along * force));
        let line = sum.line(&point, &along);
        // The twist counts from the body to the world: it is minus the body's motion.
        sum.add_damper(&line, &line, -slope);
    }
}
