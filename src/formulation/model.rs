//! What stays constant during a simulation.

use super::memory::{Mode, ModelMemory, WheelMemory};
use super::sliding_mean::{MeanMemory, SlidingMean};
use super::step::WheelRef;
use super::wheel_search::WheelSearch;
use super::{Formulation, RAIL_INPUTS, Workspace};
use crate::contact::creep::CreepLaw;
use crate::contact::normal::NormalLaw;
use crate::contact::normal::damping::DampingLaw;
use crate::contact::transient::{self, LoadedPatch, SlipVelocity, TransientContact};
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::Track;
use crate::mbs::body::BodyMotion;
use crate::mbs::system::System;
use std::sync::Arc;

/// Inputs of one wheelset, in the order in which they stand in the input vector.
pub const WHEELSET_INPUTS: usize = 6;
pub const DRIVE_TORQUE: usize = 0;
pub const LATERAL_FORCE: usize = 1;
pub const VERTICAL_FORCE: usize = 2;
pub const LEFT_FRICTION: usize = 3;
pub const RIGHT_FRICTION: usize = 4;
pub const LONGITUDINAL_FORCE: usize = 5;
/// Values of a wheelset's inputs that leave it alone.
pub const NEUTRAL_INPUTS: [f64; WHEELSET_INPUTS] = [0.0, 0.0, 0.0, 1.0, 1.0, 0.0];

/// Of `solver.load_tolerance`, where a scene names none.
pub const LOAD_TOLERANCE: f64 = 0.01;

/// A body with two wheels on the track.
#[derive(Debug)]
pub struct Wheelset {
    pub name: String,
    pub body: usize,
    pub left: Wheel,
    pub right: Wheel,
    /// Imposed travelling speed [m/s], `None` when the wheelset is free along the track.
    pub imposed_speed: Option<f64>,
    /// Vertical force of each wheel on level track at rest, N.
    pub static_wheel_load: f64,
}

impl Wheelset {
    /// Travelling speed that creepages are relative to, m/s; with the sign of the direction.
    #[inline]
    pub fn speed(&self, motion: &BodyMotion) -> f64 {
        self.imposed_speed.unwrap_or(motion.speed)
    }

    pub fn wheel(&self, side: Side) -> &Wheel {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }
}

/// Place of a wheel's contact in [`Workspace::contacts`] and, times the memory per contact, in the state's memory.
pub fn contact_index(wheelset: usize, side: Side) -> usize {
    2 * wheelset + usize::from(side == Side::Right)
}

/// Laws and constants of contact.
#[derive(Debug)]
pub struct ContactLaws {
    pub normal: Box<dyn NormalLaw>,
    pub creep: Box<dyn CreepLaw>,
    pub damping: Box<dyn DampingLaw>,
    /// Tangential contact at low speed; `None` where the scene does not call for it.
    pub transient: Option<TransientContact>,
    /// mu, -.
    pub friction: f64,
    /// G, Pa.
    pub shear_modulus: f64,
}

/// Everything that stays constant during a simulation.
#[derive(Debug)]
pub struct Model {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
    pub formulation: Box<dyn Formulation>,
    /// Contacts that each wheel may have at the same time.
    pub points: usize,
    /// Where the contacts' states begin in the state vector (the system's dimension).
    pub(super) contact_states_begin: usize,
    /// Error of a contact's normal or creep force that a step may make, in parts of the static wheel load or, where it is larger, of the
    /// normal force, -.
    pub load_tolerance: f64,
    /// Means over the last stretch of travel; `None` where the scene does not ask for them.
    pub means: Option<SlidingMean>,
    /// Does the rail under each wheel move as inputs say (see `rail_motion`)?
    pub rail_motion: bool,
    /// Per wheel: the search for all of them; `None` where one place alone can touch.
    pub(super) searches: Vec<Option<Arc<WheelSearch>>>,
}

impl Model {
    pub fn contacts(&self) -> usize {
        2 * self.wheelsets.len()
    }

    /// Are the places of a wheel's contacts searched for? Otherwise only one can touch (or the formulation knows them itself).
    pub fn searches_contacts(&self, contact: usize) -> bool {
        self.searches[contact].is_some()
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        self.mean_states(self.wheelsets.len()).start
    }

    pub(super) fn means_begin(&self) -> usize {
        self.deflections_begin() + self.contacts() * self.points * self.deflection_states()
    }

    fn deflections_begin(&self) -> usize {
        self.contact_states_begin + self.contacts() * self.formulation.states_per_contact()
    }

    /// States of the tangential deflection of one contact: none without `contact.transient`.
    pub fn deflection_states(&self) -> usize {
        if self.laws.transient.is_some() { transient::STATES } else { 0 }
    }

    /// The tangential states of a wheel's contact `slot` (from 0) in the state vector; they stand at its end.
    pub fn deflection(&self, contact: usize, slot: usize) -> std::ops::Range<usize> {
        let start = self.deflections_begin() + (contact * self.points + slot) * self.deflection_states();
        start..start + self.deflection_states()
    }

    /// Writes the rates of all tangential states, which the contacts' reports hold.
    #[inline]
    pub(super) fn deflection_rates(&self, workspace: &Workspace, y: &[f64], dy: &mut [f64]) {
        let Some(transient) = &self.laws.transient else { return };
        for contact in 0..self.contacts() {
            for slot in 0..self.points {
                let report = workspace.report(contact, slot);
                let range = self.deflection(contact, slot);
                let unloaded = || {
                    let mut state = [0.0; transient::STATES];
                    state.copy_from_slice(&y[range.clone()]);
                    let (patch, slip) = (LoadedPatch::default(), SlipVelocity::default());
                    transient.evaluate(self.laws.creep.as_ref(), &patch, &slip, &state).rates
                };
                let rates = if report.normal_force > 0.0 { report.deflection_rates } else { unloaded() };
                dy[range].copy_from_slice(&rates);
            }
        }
    }

    /// Puts the tangential states where they are in steady rolling with the contacts as they were found last.
    pub fn settle_deflections(&self, workspace: &Workspace, y: &mut [f64]) {
        let Some(transient) = &self.laws.transient else { return };
        for WheelRef { contact, wheelset, .. } in self.wheels() {
            for slot in 0..self.points {
                let report = workspace.report(contact, slot);
                let speed = wheelset.speed(&workspace.system.motions[wheelset.body]);
                let patch = LoadedPatch { patch: report.patch, normal_force: report.normal_force, friction: self.laws.friction };
                let state = transient.steady_state(&patch, &report.slip.rolling(speed));
                y[self.deflection(contact, slot)].copy_from_slice(&state);
            }
        }
    }

    /// What is remembered of a state before anything has been evaluated.
    pub fn blank_memory(&self) -> ModelMemory {
        let mode = if self.formulation.constrains() { Mode::rigid(0.0, 0.0) } else { Mode::ELASTIC };
        ModelMemory {
            wheels: vec![WheelMemory::new(mode); self.contacts()],
            partitions: vec![None; if self.formulation.constrains() { self.wheelsets.len() } else { 0 }],
            means: self.means.iter().flat_map(|_| &self.wheelsets).map(|_| MeanMemory::default()).collect(),
            distances: vec![0.0; self.followed()],
        }
    }

    /// A contact's own states in the state vector.
    pub fn contact_states(&self, contact: usize) -> std::ops::Range<usize> {
        let count = self.formulation.states_per_contact();
        let start = self.contact_states_begin + contact * count;
        start..start + count
    }

    /// The bodies of the contacts that are constraints, contact by contact.
    pub(super) fn constrained_bodies(&self) -> Vec<usize> {
        let both = |wheelset: &Wheelset| [wheelset.body; 2];
        if self.formulation.constrains() { self.wheelsets.iter().flat_map(both).collect() } else { Vec::new() }
    }

    /// Values of all inputs that leave the model alone.
    pub fn neutral_inputs(&self) -> Vec<f64> {
        let own = NEUTRAL_INPUTS.iter().copied().cycle().take(WHEELSET_INPUTS * self.wheelsets.len());
        own.chain(std::iter::repeat_n(0.0, if self.rail_motion { RAIL_INPUTS * self.contacts() } else { 0 })).collect()
    }
}
