//! Rails on track that gives way (`travelling_track`; `beam_rails` has the rest of those that are beams): their states, rates, energy, weight in the error control, and where they rest.

use super::flexibility::Flexibility;
use super::rail_scratch::RailScratch;
use super::resting_rails::{ROUNDS, RestingRail, SETTLED};
use super::step::{Step, WheelRef};
use super::travelling_track::{RAIL_STATES, TravellingTrack};
use super::{AssemblyError, Evaluation, EvaluationError, Model, Wheelset, Workspace};
use crate::mbs::system::SystemWorkspace;
use nalgebra::{Matrix2, Vector2, Vector3};
use std::ops::Range;

/// What a lateral deflection counts beside a vertical one.
pub(super) const LATERAL_WEIGHT: f64 = 0.01;
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
    /// The same model on track that gives way, where there is one, with its wheelsets at these places along the track [m] and at this speed [m/s].
    ///
    /// # Errors
    /// [`AssemblyError::TravellingTrack`] where contact is a constraint, [`AssemblyError::TwoMotions`] where rails move from outside too,
    /// [`AssemblyError::TwistedAxle`] where besides axles twist and contacts have tangential states, [`AssemblyError::SoftTrack`] where rails sink further than a start is found,
    /// [`AssemblyError::ShortRing`] where wheels would stand on both ends of a ring.
    pub fn with_flexibility(mut self, track: Option<Flexibility>, places: &[f64], speed: f64) -> Result<Self, AssemblyError> {
        let Some(laid) = track else { return Ok(self) };
        if self.formulation.constrains() {
            return Err(AssemblyError::TravellingTrack);
        }
        if self.rail_motion {
            return Err(AssemblyError::TwoMotions);
        }
        if self.axles_twist() && self.laws.transient.is_some() {
            return Err(AssemblyError::TwistedAxle);
        }
        let vertical = match laid {
            Flexibility::Travelling(track) => {
                self.travelling_track = Some(track);
                track.vertical.stiffness
            }
            Flexibility::Beam(beam) => {
                let rails = beam.lay(places, speed);
                if beam.bays.is_some() && rails.longest >= 0.5 * rails.ring.length() {
                    let least = 2.0 * (rails.longest / beam.bay.spacing).ceil() + 2.0;
                    return Err(AssemblyError::ShortRing { bays: rails.ring.bays(), longest: rails.longest, least: least as usize });
                }
                let stiffness = rails.stand_in.vertical.stiffness;
                self.beam = Some(rails);
                stiffness
            }
        };
        const GRAVITY: f64 = 9.81;
        let carried = self.wheelsets.iter().map(|wheelset| wheelset.static_wheel_load).sum::<f64>() / self.wheelsets.len() as f64;
        let load = carried.max(self.system.bodies.iter().map(|body| body.mass).sum::<f64>() * GRAVITY / self.contacts() as f64);
        let sag = load / vertical;
        // (Also where it is no number.)
        if !(sag <= DEEPEST_SAG) {
            let (stiffness, least) = (1e-6 * vertical, 1e-6 * load / DEEPEST_SAG);
            return Err(AssemblyError::SoftTrack { sag: 1e3 * sag, stiffness, most: 1e3 * DEEPEST_SAG, least });
        }
        self.surfaces_move = true;
        Ok(self)
    }

    /// Does the track give way?
    pub fn gives_way(&self) -> bool {
        self.travelling_track.is_some() || self.beam.is_some()
    }

    /// Is there an axle whose wheels turn against each other?
    pub fn axles_twist(&self) -> bool {
        self.wheelsets.iter().any(|wheelset| wheelset.turning != [wheelset.body; 2])
    }

    /// What travels under each wheel: the track, or what stands on rails that are beams; `None` where rails are rigid.
    fn under_wheels(&self) -> Option<&TravellingTrack> {
        self.travelling_track.as_ref().or(self.beam.as_ref().map(|beam| &beam.under))
    }

    /// The states of what travels under the wheel of a contact in the state vector; empty where rails are rigid.
    pub fn rail_states(&self, contact: usize) -> Range<usize> {
        let count = if self.gives_way() { RAIL_STATES } else { 0 };
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
        if let Some(track) = self.under_wheels() {
            self.rail_rates_on(track, workspace, y, dy);
        }
        if let Some(beam) = &self.beam {
            self.beam_rates(beam, workspace, y, dy);
        }
    }

    #[inline(never)]
    fn rail_rates_on(&self, track: &TravellingTrack, workspace: &Workspace, y: &[f64], dy: &mut [f64]) {
        let [mass, stiffness, damping] = track.pairs();
        for WheelRef { contact, wheelset, .. } in self.wheels() {
            let force = workspace.wheel_force(contact, wheelset.body);
            let (own, states) = (&y[self.rail_states(contact)], self.rail_states(contact));
            let shape = workspace.rails.local.get(contact / 2).map_or(1.0, |local| local[0]);
            for (i, force) in [force.y, shape * force.z].into_iter().enumerate() {
                dy[states.start + i] = own[2 + i];
                dy[states.start + 2 + i] = -(force + stiffness[i] * own[i] + damping[i] * own[2 + i]) / mass[i];
            }
        }
    }

    /// What the linearised system needs of the mass under a wheel; `None` where rails are rigid.
    pub(super) fn under(&self, (system, rails): (&SystemWorkspace, &RailScratch), wheel: &WheelRef) -> Option<Under> {
        let [mass, stiffness, damping] = self.under_wheels()?.pairs();
        let shape = rails.local.get(wheel.contact / 2).map_or(1.0, |local| local[0]);
        let axes = [[1.0, 0.0], [0.0, shape]].map(|parts| Self::across_track(system, wheel.wheelset.body, parts));
        Some(Under { first: self.rail_states(wheel.contact).start, axes, mass, stiffness, damping })
    }

    /// Weight of a rail's state in the error control, in parts of that of a wheelset's height: its deflections press wheels too, velocities
    /// count by the forces that they make. `None`: no state of a rail.
    pub fn weight_of_rail(&self, state: usize) -> Option<f64> {
        let own = state.checked_sub(self.rails_begin()).filter(|own| *own < self.rail_state_count())?;
        if let (Some(beam), Some(own)) = (&self.beam, own.checked_sub(RAIL_STATES * self.contacts())) {
            return Some(self.weight_of_mode(beam, own));
        }
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
        let Some(track) = self.under_wheels() else { return (0.0, 0.0) };
        let [mass, stiffness, damping] = track.pairs();
        let (mut stored, mut heat) = self.beam.as_ref().map_or((0.0, 0.0), |beam| self.beam_energy(beam, y));
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
        let under = |mass: f64| half * mass / (half + mass);
        match (&self.travelling_track, &self.beam) {
            (Some(track), _) => under(track.vertical.mass),
            (None, Some(beam)) => under(beam.ring.struck_mass()),
            (None, None) => half,
        }
    }

    /// Displacement and velocity of a rail in the world from its states in a vector as long as the state vector (velocity and acceleration from their
    /// rates); `None` where rails are rigid.
    #[inline]
    pub fn rail_change(&self, workspace: &Workspace, body: usize, contact: usize, change: &[f64]) -> Option<[Vector3<f64>; 2]> {
        let parts = match (&self.travelling_track, &self.beam) {
            (Some(_), _) => {
                let own = &change[self.rail_states(contact)];
                [[own[0], own[1]], [own[2], own[3]]]
            }
            (None, Some(beam)) => self.beam_change(beam, workspace, contact, change),
            (None, None) => return None,
        };
        Some(parts.map(|parts| Self::across_track(&workspace.system, body, parts)))
    }
}

impl Step<'_> {
    /// Puts the rails where they rest under the wheels as they stand, wheel by wheel ([`RestingRail`]); returns how many evaluations that took.
    ///
    /// # Errors
    /// [`EvaluationError`] where contacts can't be evaluated on the way.
    pub fn settle_rails(&mut self, inputs: &[f64]) -> Result<usize, EvaluationError> {
        let model = self.model;
        if let Some(beam) = &model.beam {
            return self.settle_beams(beam, inputs);
        }
        let Some(track) = &model.travelling_track else { return Ok(0) };
        let [_, stiffness, _] = track.pairs();
        let mut dy = vec![0.0; self.y.len()];
        for contact in 0..model.contacts() {
            self.y[model.rail_states(contact)][2..].fill(0.0);
        }
        let mut rails = vec![RestingRail::default(); model.contacts()];
        for round in 1..=ROUNDS {
            let at = Evaluation { t: self.t, inputs, y: self.y, memory: self.memory };
            model.derivative(self.workspace, at, &mut dy)?;
            let mut moved: f64 = 0.0;
            for WheelRef { contact, wheelset, .. } in model.wheels() {
                let force = self.workspace.wheel_force(contact, wheelset.body);
                let own = &mut self.y[model.rail_states(contact)];
                let rest = Vector2::new(stiffness[0] * own[0] + force.y, stiffness[1] * own[1] + force.z);
                let slope = || self.workspace.pressed_slope(contact, wheelset.body, &Vector2::from(stiffness));
                let change = rails[contact].next_move(rest, slope);
                (own[0], own[1]) = (own[0] + change.x, own[1] + change.y);
                moved = moved.max(change.amax());
            }
            if moved < SETTLED {
                return Ok(round);
            }
        }
        Ok(ROUNDS)
    }
}

impl Workspace {
    /// How the force of a wheel's contacts on its rail, and what holds the rail, change with the rail's place across the track, N/m. Creep forces go with the
    /// normal force: left out, they would push rails far aside, where those are soft.
    pub(super) fn pressed_slope(&self, contact: usize, body: usize, stiffness: &Vector2<f64>) -> Matrix2<f64> {
        let mut slope = Matrix2::from_diagonal(stiffness);
        for report in self.reports(contact).filter(|report| report.normal_force > 0.0) {
            let [normal, force] = [report.axes.normal, report.force / report.normal_force].map(|vector| self.in_track(body, vector));
            slope += Vector2::new(force.y, force.z) * Vector2::new(normal.y, normal.z).transpose() * (report.share * report.elastic_slope);
        }
        slope
    }
}
