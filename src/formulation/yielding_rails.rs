//! Rails on track that gives way (`travelling_track`): their states, rates, energy, weight in the error control, and where they rest.

use super::step::{Step, WheelRef};
use super::travelling_track::{RAIL_STATES, TravellingTrack};
use super::{AssemblyError, Evaluation, EvaluationError, Model, Wheelset, Workspace};
use crate::mbs::system::SystemWorkspace;
use nalgebra::{Matrix2, Vector2, Vector3};
use std::ops::Range;

/// What a lateral deflection counts beside a vertical one.
const LATERAL_WEIGHT: f64 = 0.01;
/// Corrections of rails at rest below this are none, m, and how often they are tried.
const SETTLED: f64 = 1e-13;
const ROUNDS: usize = 100;
/// Farthest that a rail is moved in one of them, m.
const FARTHEST: f64 = 1e-3;

/// A mass under a wheel as the linearised system sees it.
pub(super) struct Under {
    pub first: usize,
    pub axes: [Vector3<f64>; 2],
    pub mass: [f64; 2],
    pub stiffness: [f64; 2],
    pub damping: [f64; 2],
}

/// Under the mean wheel load, m: a start is looked for from rails that carry nothing, and wheels are at most 5 mm deep in them.
const DEEPEST_SAG: f64 = 3e-3;

impl Model {
    /// The same model on track that gives way, where there is one.
    ///
    /// # Errors
    /// [`AssemblyError::TravellingTrack`] where contact is a constraint, [`AssemblyError::TwoMotions`] where rails move from outside too,
    /// [`AssemblyError::TwistedAxle`] beside an axle that twists, [`AssemblyError::SoftTrack`] where rails sink further than a start is found.
    pub fn with_travelling_track(mut self, track: Option<TravellingTrack>) -> Result<Self, AssemblyError> {
        if track.is_some() && self.formulation.constrains() {
            return Err(AssemblyError::TravellingTrack);
        }
        if track.is_some() && self.rail_motion {
            return Err(AssemblyError::TwoMotions);
        }
        let Some(laid) = track else { return Ok(self) };
        if self.axles_twist() {
            return Err(AssemblyError::TwistedAxle);
        }
        const GRAVITY: f64 = 9.81;
        let load = self.system.bodies.iter().map(|body| body.mass).sum::<f64>() * GRAVITY / self.contacts() as f64;
        let sag = load / laid.vertical.stiffness;
        if sag > DEEPEST_SAG {
            let (stiffness, least) = (1e-6 * laid.vertical.stiffness, 1e-6 * load / DEEPEST_SAG);
            return Err(AssemblyError::SoftTrack { sag: 1e3 * sag, stiffness, most: 1e3 * DEEPEST_SAG, least });
        }
        self.travelling_track = track;
        self.surfaces_move = true;
        Ok(self)
    }

    /// Is there an axle whose wheels turn against each other?
    pub fn axles_twist(&self) -> bool {
        self.wheelsets.iter().any(|wheelset| wheelset.turning != [wheelset.body; 2])
    }

    /// The states of the rail under the wheel of a contact in the state vector; empty where rails are rigid.
    pub fn rail_states(&self, contact: usize) -> Range<usize> {
        let count = if self.travelling_track.is_some() { RAIL_STATES } else { 0 };
        let first = self.rails_begin() + contact * count;
        first..first + count
    }

    /// A vector across the track, lateral and vertical part, in the world beside a body.
    pub(super) fn across_track(system: &SystemWorkspace, body: usize, [lateral, vertical]: [f64; 2]) -> Vector3<f64> {
        let vector = Vector3::new(0.0, lateral, vertical);
        system.stations.get(body).map_or(vector, |station| station.frame.axes * vector)
    }

    /// Writes the rates of all rails' states under the forces of the contacts in the workspace.
    #[inline]
    pub(super) fn rail_rates(&self, workspace: &Workspace, y: &[f64], dy: &mut [f64]) {
        if let Some(track) = &self.travelling_track {
            self.rail_rates_on(track, workspace, y, dy);
        }
    }

    #[inline(never)]
    fn rail_rates_on(&self, track: &TravellingTrack, workspace: &Workspace, y: &[f64], dy: &mut [f64]) {
        let [mass, stiffness, damping] = track.pairs();
        for WheelRef { contact, wheelset, .. } in self.wheels() {
            let force = workspace.wheel_force(contact, wheelset.body);
            let (own, states) = (&y[self.rail_states(contact)], self.rail_states(contact));
            for (i, force) in [force.y, force.z].into_iter().enumerate() {
                dy[states.start + i] = own[2 + i];
                dy[states.start + 2 + i] = -(force + stiffness[i] * own[i] + damping[i] * own[2 + i]) / mass[i];
            }
        }
    }

    /// What the linearised system needs of the mass under a wheel; `None` where rails are rigid.
    pub(super) fn under(&self, system: &SystemWorkspace, wheel: &WheelRef) -> Option<Under> {
        let [mass, stiffness, damping] = self.travelling_track.as_ref()?.pairs();
        let axes = [[1.0, 0.0], [0.0, 1.0]].map(|parts| Self::across_track(system, wheel.wheelset.body, parts));
        Some(Under { first: self.rail_states(wheel.contact).start, axes, mass, stiffness, damping })
    }

    /// Weight of a rail's state in the error control, in parts of that of a wheelset's height: its deflections press wheels too, velocities
    /// count by the forces that they make. `None`: no state of a rail.
    pub fn weight_of_rail(&self, state: usize) -> Option<f64> {
        self.travelling_track.as_ref()?;
        let own = state.checked_sub(self.rails_begin()).filter(|own| *own < RAIL_STATES * self.contacts())?;
        Some(if own % RAIL_STATES == 1 {
            1.0
        } else if own % RAIL_STATES == 0 {
            LATERAL_WEIGHT
        } else {
            0.0
        })
    }

    /// Stored energy of all rails, J, and the power that their dampers turn into heat, W.
    pub fn rail_energy(&self, y: &[f64]) -> (f64, f64) {
        let Some(track) = &self.travelling_track else { return (0.0, 0.0) };
        let [mass, stiffness, damping] = track.pairs();
        let (mut stored, mut heat) = (0.0, 0.0);
        for contact in 0..self.contacts() {
            let own = &y[self.rail_states(contact)];
            for i in 0..2 {
                stored += 0.5 * (stiffness[i] * own[i] * own[i] + mass[i] * own[2 + i] * own[2 + i]);
                heat += damping[i] * own[2 + i] * own[2 + i];
            }
        }
        (stored, heat)
    }

    /// The mass that bounces with a wheel of `wheelset` on its contact, kg: half the wheelset, against that of the rail where it gives way.
    #[inline]
    pub(super) fn bouncing_mass(&self, wheelset: &Wheelset) -> f64 {
        let half = 0.5 * self.system.bodies[wheelset.body].mass;
        self.travelling_track.as_ref().map_or(half, |track| half * track.vertical.mass / (half + track.vertical.mass))
    }

    /// Displacement and velocity of a rail in the world from its states in a vector as long as the state vector (velocity and acceleration from their
    /// rates); `None` where rails are rigid.
    #[inline]
    pub fn rail_change(&self, system: &SystemWorkspace, body: usize, contact: usize, change: &[f64]) -> Option<[Vector3<f64>; 2]> {
        self.travelling_track.as_ref()?;
        let own = &change[self.rail_states(contact)];
        Some([[own[0], own[1]], [own[2], own[3]]].map(|parts| Self::across_track(system, body, parts)))
    }
}

impl Step<'_> {
    /// Puts the rails where they rest under the wheels as they stand.
    ///
    /// Newton's method wheel by wheel, with the slope of the elastic force, which creep forces follow, in place of all of the contact's.
    ///
    /// # Errors
    /// [`EvaluationError`] where contacts can't be evaluated on the way.
    pub fn settle_rails(&mut self, inputs: &[f64]) -> Result<(), EvaluationError> {
        let model = self.model;
        let Some(track) = &model.travelling_track else { return Ok(()) };
        let [_, stiffness, _] = track.pairs();
        let mut dy = vec![0.0; self.y.len()];
        for contact in 0..model.contacts() {
            self.y[model.rail_states(contact)][2..].fill(0.0);
        }
        for _ in 0..ROUNDS {
            let at = Evaluation { t: self.t, inputs, y: self.y, memory: self.memory };
            model.derivative(self.workspace, at, &mut dy)?;
            let mut moved: f64 = 0.0;
            for WheelRef { contact, wheelset, .. } in model.wheels() {
                let force = self.workspace.wheel_force(contact, wheelset.body);
                let own = &mut self.y[model.rail_states(contact)];
                let mut slope = Matrix2::from_diagonal(&Vector2::from(stiffness));
                for report in self.workspace.reports(contact).filter(|report| report.normal_force > 0.0) {
                    // Creep forces go with the normal force: left out, they would push rails far aside, where those are soft.
                    let [normal, force] = [report.axes.normal, report.force / report.normal_force]
                        .map(|vector| self.workspace.in_track(wheelset.body, vector));
                    slope += Vector2::new(force.y, force.z)
                        * Vector2::new(normal.y, normal.z).transpose()
                        * (report.share * report.elastic_slope);
                }
                let rest = Vector2::new(stiffness[0] * own[0] + force.y, stiffness[1] * own[1] + force.z);
                let change = slope.try_inverse().map_or(Vector2::zeros(), |inverse| inverse * rest);
                let change = change * (FARTHEST / change.norm()).min(1.0);
                (own[0], own[1]) = (own[0] - change.x, own[1] - change.y);
                moved = moved.max(change.amax());
            }
            if moved < SETTLED {
                break;
            }
        }
        Ok(())
    }
}
