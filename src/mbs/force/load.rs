//! A vertical load on a body's centre: the weight of what rests on it, with the inertia of that.
//!
//! *Meaning.* A load F0 [N, downward positive] stands for a mass `M = F0 / g` that is not among the bodies, above all the car body on a
//! wheelset that runs alone. M goes along the track with the body and is held above the centre line by what is not modelled, so
//! that its acceleration is that of the moving track frame there. With the unit tangent X of the centre line, `X_s = dX/ds` (its
//! curvature vector, 1/m: of curves and of changes of grade), the body's velocity v, `S = v . X` and the travel s' of the frame [m/s],
//!
//! ```text
//! F = M (g_vec - a_L),   a_L = S_dot X + S s' X_s,   |g_vec| = g, plumb
//! ```
//!
//! acts at the body's centre of mass. `M g_vec` is F0, plumb: on a grade it pulls downhill, on canted track toward the low rail.
//! `-M S s' X_s` is the centrifugal force (F0 V^2 / (g R) outward in a curve; on a crest it unloads). `-M S_dot X` is the inertia along the track: it
//! is not applied here but in the equations of motion ([`crate::mbs::supported`]), because the acceleration is not yet known; it is zero where
//! the speed is imposed. Left out: what M's own motion across the track makes (its sway, and its height over the centre line where
//! the cant changes), its moment of inertia and its height (couples); a vehicle with bodies has all of that.
//!
//! A load that pulls upward, or without gravity (g below 0.1 m/s2), is no weight: it is a force without mass, plumb.

use super::ForceElement;
use crate::geometry::track::station::Station;
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::Numbered;
use nalgebra::{Vector3, Vector6};

/// g below which a load is no weight, m/s2.
const LEAST_GRAVITY: f64 = 0.1;

/// Constant load on one body's centre.
#[derive(Debug, Clone)]
pub struct VerticalLoad {
    pub body: usize,
    /// F0, N, downward positive.
    pub force: f64,
    /// Its parts against X and against Z, N: plumb on a straight track that climbs; where the track has a centre line the world is level.
    weight: [f64; 2],
    /// M, kg.
    pub mass: f64,
}

impl VerticalLoad {
    /// A load [N] under the gravity g [m/s2] on a track that climbs with `grade` [rad].
    pub fn new(body: usize, force: f64, gravity: f64, grade: f64) -> Self {
        let mass = if force > 0.0 && gravity >= LEAST_GRAVITY { force / gravity } else { 0.0 };
        VerticalLoad { body, force, weight: [force * grade.sin(), force * grade.cos()], mass }
    }

    /// Centrifugal force, N, in the world.
    #[inline]
    pub fn centrifugal(&self, station: &Station) -> Vector3<f64> {
        station.frame.bend() * (-self.mass * station.speed * station.travel)
    }
}

impl Numbered for VerticalLoad {}

impl ForceElement for VerticalLoad {
    fn name(&self) -> &str {
        "vertical load"
    }

    fn is_dissipative(&self) -> bool {
        false
    }

    #[inline]
    fn apply(&self, bodies: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let [back, down] = self.weight;
        wrenches[self.body].force.x -= back;
        wrenches[self.body].force.z -= down;
        if let Some(station) = bodies.station(self.body) {
            wrenches[self.body].force += self.centrifugal(station);
        }
    }

    fn bodies(&self) -> Ends {
        [Some(self.body), None]
    }

    /// Of the centrifugal force, with the speed and with the place along the track; the share curvature x offset of the travel s' (1e-5)
    /// counts as constant.
    fn tangent(&self, bodies: &Moving, _: &[f64], _: usize, sum: &mut PairTangent) {
        let Some(station) = bodies.station(self.body).filter(|_| self.mass != 0.0) else { return };
        let (frame, turn) = (&station.frame, &station.frame.turn);
        let centre = &bodies[self.body].position;
        let along = frame.along();
        let bending = frame.axes * (frame.turn1.cross(&Vector3::x()) + turn.cross(&turn.cross(&Vector3::x())));
        // The twist counts from the body to the world: it is minus the body's motion.
        let measured = sum.line(centre, &along);
        let load = |vector: &Vector3<f64>| Vector6::new(vector.x, vector.y, vector.z, 0.0, 0.0, 0.0);
        sum.add_damper(&load(&frame.bend()), &measured, 2.0 * self.mass * station.travel);
        sum.add_spring(&load(&bending), &measured, self.mass * station.travel * station.travel);
    }

    /// Of the weight; what the curve's guidance of M does is power from outside.
    fn potential_energy(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let position = &bodies[self.body].position;
        let [back, down] = self.weight;
        position.x * back + position.z * down
    }

    fn dissipated_power(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }
}
