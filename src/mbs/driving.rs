//! The driving constraint on a curved track: `v . X = V` with X the track's tangent beside the body's centre.
//!
//! Differentiated, with the frame's travel s' and `X_s` its derivative along the track:
//!
//! ```text
//! a . X = -(v . X_s) s' - (v . X - V) / T
//! ```
//!
//! The last term is zero where the constraint holds; it takes back within T what integration leaves of it (1e-9 m/s or less, so that
//! its force is below 1e-3 N). The constraint's force acts along X and is what `m a . X` leaves after all other forces.

use super::body::BodyMotion;
use super::kkt::Mobility;
use super::system::DrivingConstraint;
use crate::geometry::track::station::{Station, Stations};
use nalgebra::Matrix3;

/// T, s.
const RETURN: f64 = 0.1;

impl DrivingConstraint {
    /// a . X, m/s2.
    #[inline]
    pub(super) fn demand(&self, station: &Station, motion: &BodyMotion) -> f64 {
        -station.swing_of_speed(&motion.velocity) - (station.speed - self.speed) / RETURN
    }

    /// Gives a linear acceleration [m/s2] the part along X that the constraint demands, which is returned.
    #[inline]
    pub(super) fn hold(&self, station: &Station, motion: &BodyMotion, linear: &mut [f64]) -> f64 {
        let (along, demand) = (station.frame.along(), self.demand(station, motion));
        let change = demand - linear.iter().zip(along.iter()).map(|(a, x)| a * x).sum::<f64>();
        for (a, x) in linear.iter_mut().zip(along.iter()) {
            *a += change * x;
        }
        demand
    }
}

impl DrivingConstraint {
    /// Takes the held direction out of the body's mobility; no stations: straight track.
    #[inline]
    pub(super) fn immobilise(&self, mobility: &mut Mobility, stations: &Stations) {
        match stations.get(self.body) {
            Some(station) => without_travel(mobility, station),
            // The centre of mass is the origin: X is coupled to no other coordinate.
            None => mobility[(0, 0)] = 0.0,
        }
    }
}

/// Takes the direction of travel out of a mobility whose linear part is 1 / mass in all directions.
#[inline]
fn without_travel(mobility: &mut Mobility, station: &Station) {
    let along = station.frame.along();
    let free = (Matrix3::identity() - along * along.transpose()) * mobility[(0, 0)];
    mobility.fixed_view_mut::<3, 3>(0, 0).copy_from(&free);
}
