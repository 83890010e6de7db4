//! Bodies, force elements, driving constraints and joints as one system: state layout and accelerations.
//!
//! The state vector holds the coordinates of all bodies (x, y, z, yaw, roll, pitch each), then their velocities in
//! the same order. A driving constraint `x' = V` removes its coordinate's acceleration exactly: the centre of mass
//! is the body's origin, so X is not coupled to other coordinates by inertia, the acceleration is zero and the
//! constraint force is minus the sum of all other longitudinal forces. On a curved track the constraint holds the speed along the
//! track's tangent ([`super::driving`]). Joints and contact constraints are solved
//! for together ([`super::constraints`]); a system that has none pays nothing for them.

use super::body::{Body, BodyMotion, COORDINATES, Wrench};
use super::constraints::Constraints;
use super::force::ForceElement;
use super::joint::Joint;
use crate::geometry::track::station::Station;

/// A body whose centre travels with imposed constant speed.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivingConstraint {
    pub body: usize,
    /// V, m/s.
    pub speed: f64,
}

/// The constant part of a multibody system.
#[derive(Debug)]
pub struct System {
    pub bodies: Vec<Body>,
    pub forces: Vec<Box<dyn ForceElement>>,
    pub drives: Vec<DrivingConstraint>,
    pub joints: Vec<Joint>,
    /// Rows of joints that repeat what others demand ([`System::find_redundant`]); they are left out.
    pub redundant: Vec<usize>,
}

/// What is computed on the way to the accelerations; nothing in here outlives an evaluation.
#[derive(Clone, Debug)]
pub struct SystemWorkspace {
    pub motions: Vec<BodyMotion>,
    pub wrenches: Vec<Wrench>,
    /// Force of each driving constraint, N, forward positive.
    pub drive_forces: Vec<f64>,
    pub constraints: Constraints,
    /// By body, on a curved track for the bodies that are followed along it; empty on straight track.
    pub stations: Vec<Station>,
}

impl System {
    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        2 * COORDINATES * self.bodies.len()
    }

    /// With one more scalar constraint, on one body each, for every element of `contact_bodies`; they follow the rows
    /// of the joints.
    pub fn workspace(&self, contact_bodies: &[usize]) -> SystemWorkspace {
        let zero = BodyMotion::new(&[0.0; COORDINATES], &[0.0; COORDINATES]);
        SystemWorkspace {
            motions: vec![zero; self.bodies.len()],
            wrenches: vec![Wrench::default(); self.bodies.len()],
            drive_forces: vec![0.0; self.drives.len()],
            constraints: Constraints::new(self, contact_bodies),
            stations: Vec::new(),
        }
    }

    /// Coordinates of a body in the state vector.
    pub fn coordinates(&self, body: usize) -> std::ops::Range<usize> {
        body * COORDINATES..(body + 1) * COORDINATES
    }

    /// Velocities of a body in the state vector.
    pub fn velocities(&self, body: usize) -> std::ops::Range<usize> {
        let start = COORDINATES * (self.bodies.len() + body);
        start..start + COORDINATES
    }

    /// Fills the workspace with the bodies' motion.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn move_bodies(&self, y: &[f64], workspace: &mut SystemWorkspace) {
        for body in 0..self.bodies.len() {
            workspace.motions[body].set(&self.bodies[body], &y[self.coordinates(body)], &y[self.velocities(body)]);
        }
    }

    /// Fills the workspace with the bodies' motion and the force elements' wrenches.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn apply_forces(&self, y: &[f64], workspace: &mut SystemWorkspace) {
        self.move_bodies(y, workspace);
        workspace.wrenches.fill(Wrench::default());
        for force in &self.forces {
            force.apply(&workspace.motions, &mut workspace.wrenches);
        }
    }

    /// Fills the workspace with the force elements' wrenches where motions and stations are known.
    pub fn apply_forces_on_track(&self, workspace: &mut SystemWorkspace) {
        workspace.wrenches.fill(Wrench::default());
        for force in &self.forces {
            force.apply_on_track(&workspace.motions, &workspace.stations, &mut workspace.wrenches);
        }
    }

    /// Derivative of the state under the wrenches in the workspace, without joints and contact constraints; fills the
    /// driving constraints' forces.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn derivative(&self, y: &[f64], workspace: &mut SystemWorkspace, dy: &mut [f64]) {
        for (body, data) in self.bodies.iter().enumerate() {
            let accelerations = data.accelerations(&workspace.motions[body], &workspace.wrenches[body]);
            let velocities = self.velocities(body);
            dy[self.coordinates(body)].copy_from_slice(&y[velocities.clone()]);
            dy[velocities].copy_from_slice(&accelerations);
        }
        for (drive, force) in self.drives.iter().zip(&mut workspace.drive_forces) {
            if let Some(station) = workspace.stations.get(drive.body) {
                let linear = &mut dy[self.velocities(drive.body).start..][..3];
                let demand = drive.hold(station, &workspace.motions[drive.body], linear);
                let other = workspace.wrenches[drive.body].force.dot(&station.frame.along());
                *force = self.bodies[drive.body].mass * demand - other;
                continue;
            }
            dy[self.velocities(drive.body).start] = 0.0;
            *force = -workspace.wrenches[drive.body].force.x;
        }
    }

    /// Kinetic energy of all bodies, J.
    pub fn kinetic_energy(&self, motions: &[BodyMotion]) -> f64 {
        self.bodies.iter().zip(motions).map(|(body, motion)| body.kinetic_energy(motion)).sum()
    }

    /// Stored energy of all force elements, J.
    pub fn potential_energy(&self, motions: &[BodyMotion]) -> f64 {
        self.forces.iter().map(|force| force.potential_energy(motions)).sum()
    }

    /// Kinetic and stored energy of the motion in the workspace, J.
    pub fn mechanical_energy(&self, workspace: &SystemWorkspace) -> f64 {
        let SystemWorkspace { motions, stations, .. } = workspace;
        let stored = match stations.is_empty() {
            true => self.potential_energy(motions),
            false => self.forces.iter().map(|force| force.potential_energy_on_track(motions, stations)).sum(),
        };
        self.kinetic_energy(motions) + stored
    }
}
