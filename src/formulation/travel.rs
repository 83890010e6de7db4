//! Bodies along a curved track: where they are, and when their wheels come to a place where a rail is not smooth.
//!
//! The memory holds each body's distance at the last evaluation, from which the next projection starts; what is found does not depend on it but
//! for rounding. It is found once per evaluation and kept with the body's motion. On straight track there is nothing of all this.

use super::memory::ModelMemory;
use super::step::Step;
use super::{EvaluationError, LATERAL_FORCE, LONGITUDINAL_FORCE, Model, VERTICAL_FORCE, contact_index};
use crate::contact::search::nodal::arc_rate;
use crate::geometry::Side;
use crate::geometry::track::centre_line::CentreLine;
use crate::geometry::track::station::{Station, Stations};
use crate::mbs::body::BodyMotion;
use crate::mbs::driving::{Course, DrivingConstraint};
use crate::mbs::speed_profile::Over;
use crate::mbs::system::SystemWorkspace;
use nalgebra::{Matrix3, Vector3};

/// A place that is nearer has been reached, m.
const SAME_PLACE: f64 = 1e-6;

impl Model {
    /// Number of bodies that are followed along the track: none where it is straight.
    pub fn followed(&self) -> usize {
        if self.track.line().is_some() { self.system.bodies.len() } else { 0 }
    }

    /// Makes room for the stations.
    pub(super) fn add_stations(&self, system: &mut SystemWorkspace) {
        if self.track.line().is_some() {
            system.stations = Stations::new(self.system.bodies.len());
        }
    }

    /// Tells where along a curved track the bodies are, by body: the projections start from there.
    pub fn set_distances(&self, distances: impl Fn(usize) -> f64, memory: &mut ModelMemory) {
        for (body, slot) in memory.distances.iter_mut().enumerate() {
            *slot = distances(body);
        }
    }

    /// Fills the workspace with the bodies' motion and, on a curved track, their stations.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn move_bodies(&self, y: &[f64], memory: &mut ModelMemory, system: &mut SystemWorkspace) {
        self.system.move_bodies(y, system);
        if let Some(line) = self.track.line() {
            self.find_stations(line, memory, system);
        }
    }

    /// Finds the stations of bodies whose motion is known.
    pub(super) fn update_stations(&self, memory: &mut ModelMemory, system: &mut SystemWorkspace) {
        if let Some(line) = self.track.line() {
            self.find_stations(line, memory, system);
        }
    }

    #[inline(never)]
    fn find_stations(&self, line: &CentreLine, memory: &mut ModelMemory, system: &mut SystemWorkspace) {
        let SystemWorkspace { motions, stations, .. } = system;
        for ((slot, motion), kept) in memory.distances.iter_mut().zip(motions).zip(stations.iter_mut()) {
            if line.keeps_to_x(&motion.position, *slot) {
                *slot = motion.distance;
                kept.stay_on_x();
                continue;
            }
            let mut station = Station::new(line, &motion.position, &motion.velocity, *slot);
            if motion.turn.is_none() {
                station.carry_boxes(&motion.frame.axes);
            }
            *slot = station.frame.distance;
            (motion.distance, motion.speed) = (station.frame.distance, station.speed);
            *kept = station;
        }
        system.carry_wheels();
    }

    /// Fills the workspace with the bodies' motion, their stations and the force elements' wrenches.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn apply_forces(&self, y: &[f64], memory: &mut ModelMemory, system: &mut SystemWorkspace) {
        self.move_bodies(y, memory, system);
        self.system.load_bodies(y, system);
    }

    /// Forces of the inputs, which are along the track's axes, in the world, N.
    #[inline]
    pub(super) fn input_force(&self, system: &SystemWorkspace, body: usize, inputs: &[f64]) -> Vector3<f64> {
        let force = Vector3::new(inputs[LONGITUDINAL_FORCE], inputs[LATERAL_FORCE], inputs[VERTICAL_FORCE]);
        system.stations.get(body).map_or(force, |station| station.frame.axes * force)
    }

    /// What rounding leaves of a position in the world, m: on a curved track all three coordinates become large. 0 on straight track.
    pub(super) fn rounding(&self, q: &[f64]) -> f64 {
        if self.track.line().is_none() { 0.0 } else { 8.0 * f64::EPSILON * (q[0].abs() + q[1].abs() + q[2].abs()) }
    }

    /// The track frame's axes beside a body of the state `y`; `None` on straight track.
    pub(super) fn axes_beside(&self, body: usize, y: &[f64], memory: &ModelMemory) -> Option<Matrix3<f64>> {
        let line = self.track.line()?;
        let guess = memory.distances[body];
        let q = &y[self.system.coordinates(body)];
        Some(line.project(&Vector3::new(q[0], q[1], q[2]), guess).axes)
    }

    /// Position of a body's centre relative to the track, m: lateral and vertical, for messages.
    pub(super) fn beside(&self, motion: &BodyMotion) -> (f64, f64) {
        let Some(line) = self.track.line() else { return (motion.position.y, motion.position.z) };
        let frame = line.frame(motion.distance);
        let offset = frame.components(&(motion.position - frame.origin));
        (offset.y, offset.z)
    }

    /// When a wheel's contact next reaches a place where its rail is not smooth, s; infinity for never. The contact moves with the centre and, when the wheelset yaws, with its wheel.
    pub fn next_rough_place(&self, t: f64, y: &[f64], memory: &ModelMemory) -> f64 {
        let mut next = f64::INFINITY;
        for (index, wheelset) in self.wheelsets.iter().enumerate() {
            let q = &y[self.system.coordinates(wheelset.body)];
            let v = &y[self.system.velocities(wheelset.body)];
            for side in Side::BOTH {
                let (rail, wheel) = (self.track.rail(side), wheelset.wheel(side));
                let lead = memory.wheels[contact_index(index, side)].start().lead;
                let (place, speed) = match self.track.line() {
                    None => (q[0], v[0] - side.sign() * wheel.half_spacing * q[3].cos() * v[3]),
                    Some(line) if rail.has_breaks() => {
                        let motion = BodyMotion::new(q, v);
                        let guess = memory.distances[wheelset.body];
                        let distance = line.project(&motion.position, guess).distance;
                        let tread = motion.position + motion.axle() * (side.sign() * wheel.half_spacing);
                        (distance, arc_rate(&rail.section(distance + lead), &tread, &motion.attachment_velocity(&tread)))
                    }
                    Some(_) => continue,
                };
                if let Some(ahead) = rail.next_break(place + lead, speed) {
                    next = next.min(t + (ahead - place - lead) / speed);
                }
            }
        }
        next
    }
}

impl Model {
    /// When an imposed speed that comes from a table bends next, s.
    pub fn next_change_of_speed(&self, t: f64, y: &[f64], memory: &ModelMemory) -> f64 {
        let Some(DrivingConstraint { course: Course::Profile(profile), leader, .. }) = self.system.drives.first() else {
            return f64::INFINITY;
        };
        if profile.over == Over::Time {
            return profile.next_bend(t, 1.0, 0.0);
        }
        let (q, v) = (&y[self.system.coordinates(*leader)], &y[self.system.velocities(*leader)]);
        let (distance, speed) = match self.track.line() {
            None => (q[0], v[0]),
            Some(line) => {
                let motion = BodyMotion::new(q, v);
                let station = Station::new(line, &motion.position, &motion.velocity, memory.distances[*leader]);
                (station.frame.distance, station.travel)
            }
        };
        t + (profile.next_bend(distance, speed.signum(), SAME_PLACE) - distance) / speed
    }
}

impl Step<'_> {
    /// Moves positions and velocities onto the constraints ([`super::Formulation::project`]).
    ///
    /// # Errors
    /// [`EvaluationError`] when there is no such state nearby.
    pub fn project(&mut self) -> Result<bool, EvaluationError> {
        if self.model.track.line().is_some() {
            self.move_bodies();
        }
        let Step { model, workspace, t, y, .. } = self;
        let moved = !model.system.drives.is_empty() && model.system.keep_speeds(*t, y, &workspace.system);
        Ok(self.model.formulation.project(self)? || moved)
    }
}
