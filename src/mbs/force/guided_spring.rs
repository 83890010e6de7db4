//! Linear spring and damper between an axle and a frame that travels with it on the track's centre line.
//!
//! `F = -k d - c d'` along one track axis (X or Y), where d is the displacement of the attachment point from its
//! place in the centred position, so that the force vanishes there. The attachment point sits in the axle frame
//! and does not spin; the force acts on the axle at that point. The element's line does not turn with the axle
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

use super::ForceElement;
use crate::geometry::track::station::Station;
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::pair_tangent::{Ends, PairTangent};
use nalgebra::Vector3;

/// Track axis along which an element acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackAxis {
    /// X; the frame follows the body's own distance along the track.
    Longitudinal,
    /// Y.
    Lateral,
}

/// One spring and damper in parallel.
#[derive(Debug, Clone)]
pub struct GuidedSpring {
    pub name: String,
    /// See [`ForceElement::output_number`].
    pub output_number: u32,
    pub body: usize,
    pub axis: TrackAxis,
    /// Attachment in axle axes, m.
    pub attachment: Vector3<f64>,
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m.
    pub damping: f64,
}

impl GuidedSpring {
    /// d [m], d' [m/s] and the attachment point [m].
    #[inline]
    fn displacement(&self, body: &BodyMotion) -> (f64, f64, Vector3<f64>) {
        let point = body.attachment_point(&self.attachment);
        let velocity = body.attachment_velocity(&point);
        match self.axis {
            // The frame's X is the centre's X, its speed the centre's speed.
            TrackAxis::Longitudinal => (point.x - body.position.x - self.attachment.x, velocity.x - body.velocity.x, point),
            TrackAxis::Lateral => (point.y - self.attachment.y, velocity.y, point),
        }
    }

    /// The same where the frame is at `station`, and the axis.
    fn displacement_on_track(&self, body: &BodyMotion, station: &Station) -> (f64, f64, Vector3<f64>, Vector3<f64>) {
        let point = body.attachment_point(&self.attachment);
        let velocity = body.attachment_velocity(&point);
        let frame = &station.frame;
        let local = self.axis();
        let axis = frame.axes * local;
        let axis_rate = frame.axes * frame.turn.cross(&local) * station.travel;
        let (arm, arm_rate, centred) = match self.axis {
            TrackAxis::Longitudinal => (point - body.position, velocity - body.velocity, self.attachment.x),
            // The origin moves along X.
            TrackAxis::Lateral => (point - frame.origin, velocity, self.attachment.y),
        };
        (arm.dot(&axis) - centred, arm_rate.dot(&axis) + arm.dot(&axis_rate), point, axis)
    }

    fn axis(&self) -> Vector3<f64> {
        match self.axis {
            TrackAxis::Longitudinal => Vector3::x(),
            TrackAxis::Lateral => Vector3::y(),
        }
    }
}

impl ForceElement for GuidedSpring {
    fn name(&self) -> &str {
        &self.name
    }

    #[inline]
    fn apply(&self, bodies: &[BodyMotion], _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let body = &bodies[self.body];
        let (d, rate, point) = self.displacement(body);
        let force = -self.stiffness * d - self.damping * rate;
        wrenches[self.body].add_at(self.axis() * force, &point, &body.position);
    }

    /// From the frame on the track to the body.
    fn bodies(&self) -> Ends {
        [None, Some(self.body)]
    }

    /// The frame's turning along a curved track is left out (curvature times displacement beside one, 1e-4), and the moment about the
    /// axle of a place off the axle's line.
    fn tangent(&self, bodies: &[BodyMotion], stations: &[Station], _: &[f64], _: usize, sum: &mut PairTangent) {
        let body = &bodies[self.body];
        let (d, rate, point, axis) = match stations.get(self.body) {
            Some(station) => self.displacement_on_track(body, station),
            None => {
                let (d, rate, point) = self.displacement(body);
                (d, rate, point, self.axis())
            }
        };
        let load = sum.line(&point, &axis);
        let mut measured = load;
        if self.axis == TrackAxis::Longitudinal {
            measured.fixed_rows_mut::<3>(0).fill(0.0);
        }
        sum.add_spring(&load, &measured, self.stiffness);
        sum.add_damper(&load, &measured, self.damping);
        sum.add_force(&point, &(axis * (self.stiffness * d + self.damping * rate)));
    }

    fn output_number(&self) -> Option<u32> {
        Some(self.output_number)
    }

    fn scalar_force(&self, bodies: &[BodyMotion], _: &[f64]) -> Option<f64> {
        let (d, rate, _) = self.displacement(&bodies[self.body]);
        Some(-self.stiffness * d - self.damping * rate)
    }

    fn apply_on_track(&self, bodies: &[BodyMotion], stations: &[Station], _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let body = &bodies[self.body];
        let (d, rate, point, axis) = self.displacement_on_track(body, &stations[self.body]);
        wrenches[self.body].add_at(axis * (-self.stiffness * d - self.damping * rate), &point, &body.position);
    }

    fn scalar_force_on_track(&self, bodies: &[BodyMotion], stations: &[Station], _: &[f64]) -> Option<f64> {
        let (d, rate, ..) = self.displacement_on_track(&bodies[self.body], &stations[self.body]);
        Some(-self.stiffness * d - self.damping * rate)
    }

    fn potential_energy_on_track(&self, bodies: &[BodyMotion], stations: &[Station], _: &[f64]) -> f64 {
        let (d, ..) = self.displacement_on_track(&bodies[self.body], &stations[self.body]);
        0.5 * self.stiffness * d * d
    }

    fn dissipated_power_on_track(&self, bodies: &[BodyMotion], stations: &[Station], _: &[f64]) -> f64 {
        let (_, rate, ..) = self.displacement_on_track(&bodies[self.body], &stations[self.body]);
        self.damping * rate * rate
    }

    fn clone_box(&self) -> Box<dyn ForceElement> {
        Box::new(self.clone())
    }

    fn potential_energy(&self, bodies: &[BodyMotion], _: &[f64]) -> f64 {
        let (d, ..) = self.displacement(&bodies[self.body]);
        0.5 * self.stiffness * d * d
    }

    fn dissipated_power(&self, bodies: &[BodyMotion], _: &[f64]) -> f64 {
        let (_, rate, _) = self.displacement(&bodies[self.body]);
        self.damping * rate * rate
    }
}
