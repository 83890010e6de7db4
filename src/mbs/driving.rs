//! Imposed speed: `v . X = V` with X the track's tangent beside the body's centre (the world's x axis on straight level track).
//!
//! Differentiated, with the frame's travel s' and `X_s` its derivative along the track:
//!
//! ```text
//! a . X = V' - v . X_s s' - (v . X - V) / T
//! ```
//!
//! V is constant, or comes from a table over time or over the distance s of the leading driven body ([`SpeedProfile`]; V' is then `dV/ds s'`), or is the
//! speed of that body, which follows an input ([`SpeedInput`]). The last term (in curves alone) is zero where the constraint holds; it takes back within T what integration leaves of it (1e-9 m/s or
//! less, so that its force is below 1e-3 N). A speed that changes is also put right at the end of each step (`System::keep_speeds`).
//!
//! The constraint's force acts along X and is what the mass m of the body, and M of what it supports (it goes along the track alone), leave of all other
//! forces F: `m a . X + M V' - F . X`. Where V is constant M takes nothing.

use super::body::{Body, BodyMotion};
use super::kkt::Mobility;
use super::speed_input::{SpeedInput, Wanted};
use super::speed_profile::{Over, SpeedProfile};
use crate::geometry::track::station::{Station, Stations};
use nalgebra::Matrix3;
use std::sync::Arc;

/// T, s.
const RETURN: f64 = 0.1;

/// How the imposed speed goes on.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Course {
    #[default]
    Constant,
    Profile(Arc<SpeedProfile>),
    /// Of the master.
    Input(SpeedInput),
}

/// What imposed speeds that change go by.
#[derive(Clone, Copy, Debug, Default)]
pub struct Orders {
    /// s.
    pub time: f64,
    /// By inputs.
    pub wanted: Wanted,
}

/// A body whose centre travels with imposed speed.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivingConstraint {
    pub body: usize,
    /// V, m/s; that of the start where it changes.
    pub speed: f64,
    pub course: Course,
    /// By whose distance a table over distance goes, and whose speed follows an input: all that are driven have one speed.
    pub leader: usize,
}

impl DrivingConstraint {
    /// Of a body with constant speed [m/s].
    pub fn constant(body: usize, speed: f64) -> DrivingConstraint {
        DrivingConstraint { body, speed, course: Course::Constant, leader: body }
    }

    pub(super) fn is_constant(&self) -> bool {
        matches!(self.course, Course::Constant)
    }

    /// V and V', m/s and m/s2.
    #[inline(never)]
    fn pace(&self, orders: &Orders, motions: &[BodyMotion], stations: &Stations) -> [f64; 2] {
        match &self.course {
            Course::Constant => [self.speed, 0.0],
            Course::Profile(profile) if profile.over == Over::Time => profile.at(orders.time),
            Course::Profile(profile) => {
                let (leader, station) = (&motions[self.leader], stations.get(self.leader));
                let (distance, travel) = station.map_or((leader.distance, leader.speed), |at| (at.frame.distance, at.travel));
                let [speed, slope] = profile.at(distance);
                [speed, slope * travel]
            }
            Course::Input(input) => {
                let speed = stations.get(self.leader).map_or(motions[self.leader].speed, |at| at.speed);
                [speed, input.acceleration(&orders.wanted, speed)]
            }
        }
    }

    /// How a . X changes with the velocity where the speed follows an input: `dV'/dV X X^T`, 1/s. All that are driven have the leader's speed, each counts its
    /// own.
    #[inline]
    pub(super) fn follow(&self, motions: &[BodyMotion], stations: &Stations, orders: &Orders) -> Option<Matrix3<f64>> {
        let Course::Input(input) = &self.course else { return None };
        let [speed, _] = self.pace(orders, motions, stations);
        let along = stations.along(self.body);
        Some(along * along.transpose() * input.slope(&orders.wanted, speed))
    }

    /// a . X on a curved track, m/s2.
    #[inline]
    pub(super) fn demand(&self, station: &Station, motions: &[BodyMotion], stations: &Stations, orders: &Orders) -> f64 {
        let motion = &motions[self.body];
        if self.is_constant() {
            return -station.swing_of_speed(&motion.velocity) - (station.speed - self.speed) / RETURN;
        }
        let [speed, rate] = self.pace(orders, motions, stations);
        rate - station.swing_of_speed(&motion.velocity) - (station.speed - speed) / RETURN
    }

    /// a . X on straight track, m/s2.
    #[inline]
    pub(super) fn straight_demand(&self, motions: &[BodyMotion], stations: &Stations, orders: &Orders) -> f64 {
        if self.is_constant() { 0.0 } else { self.pace(orders, motions, stations)[1] }
    }

    /// Gives a linear acceleration [m/s2] the part along X that the constraint demands.
    #[inline]
    pub(super) fn hold(&self, station: &Station, demand: f64, linear: &mut [f64]) {
        let along = station.frame.along();
        let change = demand - linear.iter().zip(along.iter()).map(|(a, x)| a * x).sum::<f64>();
        for (a, x) in linear.iter_mut().zip(along.iter()) {
            *a += change * x;
        }
    }

    /// Takes the held direction out of the body's mobility; no stations: straight track.
    #[inline]
    pub(super) fn immobilise(&self, body: &Body, motions: &[BodyMotion], mobility: &mut Mobility, stations: &Stations) {
        // What is supported moves along the track alone.
        if !self.is_constant() {
            *mobility = body.mobility(&motions[self.body]);
        }
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
