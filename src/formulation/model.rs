//! What stays constant during a simulation.

use super::ContactReport;
use super::Formulation;
use super::body_modes::{self, BodyMode};
use super::energy_books::EnergyBooks;
use super::flank::Flank;
use super::linear_contact::LinearContact;
use super::rail_beam::LaidRails;
use super::sliding_mean::SlidingMean;
use super::travelling_track::TravellingTrack;
use super::wheel_search::WheelSearch;
use super::wheelset::Wheelset;
use crate::contact::Material;
use crate::contact::creep::CreepLaw;
use crate::contact::friction::{FrictionFactor, FrictionMap};
use crate::contact::normal::NormalLaw;
use crate::contact::normal::damping::DampingLaw;
use crate::contact::patch::{self, PatchLaw};
use crate::contact::strips::{PatchTable, RailStrips};
use crate::contact::transient::{self, TransientContact};
use crate::geometry::Side;
use crate::geometry::out_of_round::OutOfRound;
use crate::geometry::track::Track;
use crate::mbs::body::{BodyMotion, COORDINATES};
use crate::mbs::system::System;
use std::ops::Range;
use std::sync::Arc;

/// Of `solver.load_tolerance`, where a scene names none.
pub const LOAD_TOLERANCE: f64 = 0.01;

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
    /// Factors of it by place; `None` where it is the same everywhere.
    pub friction_map: Option<FrictionMap>,
    pub material: Material,
    pub patch: PatchLaw,
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
    /// Weights of the local errors of the force elements' states.
    pub(super) force_weights: Vec<f64>,
    /// How its bodies swing on their springs; empty where nobody asked.
    pub(super) body_modes: Vec<BodyMode>,
    /// The configuration about which they do: a state vector of the system; empty where nobody asked.
    pub(super) design: Vec<f64>,
    /// Where contacts of right wheels are those of left ones in a mirror (see `half`): of each body the one that is its mirror image.
    pub(super) half: Option<Vec<usize>>,
    /// Are places searched for also where certificates hold?
    pub(super) search_always: bool,
    /// Means over the last stretch of travel; `None` where the scene does not ask for them.
    pub means: Option<SlidingMean>,
    /// Books of its energy; `None` where the scene does not ask for them.
    pub books: Option<EnergyBooks>,
    /// Does the rail under each wheel move as inputs say (see `rail_motion`)?
    pub rail_motion: bool,
    /// Track that gives way under each wheel; `None`: rigid.
    pub travelling_track: Option<TravellingTrack>,
    /// Track that gives way as beams on sleepers; `None`: not so.
    pub beam: Option<LaidRails>,
    /// By contact; empty where all wheels are round.
    pub out_of_round: Vec<Option<OutOfRound>>,
    /// Do rails, or surfaces of wheels, move by anything of this (see `rail_motion`)?
    pub(super) surfaces_move: bool,
    /// Per wheel: the search for all of them; `None` where one place alone can touch.
    pub(super) searches: Vec<Option<Arc<WheelSearch>>>,
    /// By wheel.
    pub(super) flanks: Vec<Flank>,
    /// The left and the right rail in strips, where patches are made of them.
    pub(super) strips: Option<[RailStrips; 2]>,
    /// How the patches of half-spaces are solved, where those press; strips are then for slopes alone.
    pub(super) half_spaces: Option<patch::Settings>,
    /// Their patches by wheel, where they are read from tables; else empty.
    pub(super) tables: Vec<Arc<PatchTable>>,
    /// By wheel, where contact is linear; else empty.
    pub(super) linear: Vec<Arc<LinearContact>>,
}

/// Weights of the local errors of the force elements' states.
pub(super) fn force_weights(system: &System) -> Vec<f64> {
    system.forces.iter().flat_map(|force| std::iter::repeat_n(force.state_weight(), force.states())).collect()
}

impl Model {
    pub fn contacts(&self) -> usize {
        2 * self.wheelsets.len()
    }

    /// What its patches are where half-spaces on a grid press, in words.
    pub fn half_spaces(&self) -> Option<String> {
        let patch::Settings { columns, rows, extrapolate, .. } = self.half_spaces?;
        let halved = if extrapolate { ", creep forces extrapolated from half as many each way" } else { "" };
        Some(format!(
            "half-spaces and Kalker's tangential problem on {columns} x {rows} cells or more{halved}; slopes for implicit methods from strips and FASTSIM"
        ))
    }

    /// mu at a contact of a wheel, -.
    #[inline]
    pub fn friction_at(&self, side: Side, motion: &BodyMotion, report: &ContactReport) -> f64 {
        match &self.laws.friction_map {
            None => self.laws.friction,
            Some(map) => self.laws.friction * factor_at(map, side, motion, report).value,
        }
    }

    /// With another share of the static wheel load that a step's error of contact forces may reach, -.
    pub fn with_load_tolerance(mut self, tolerance: f64) -> Self {
        self.load_tolerance = tolerance;
        self
    }

    /// With the configuration in which its bodies hang on their elements, a state vector of its system.
    pub fn with_design(mut self, design: Vec<f64>) -> Self {
        self.design = design;
        self
    }

    /// Finds the modes of its bodies for runs at a tolerance [m and rad]: before a run, and after elements or the tolerance have changed.
    pub fn find_body_modes(&mut self, tolerance: f64) {
        if !self.design.is_empty() {
            self.body_modes = body_modes::body_modes(&self.system, self.wheelsets.len(), &self.design, tolerance);
        }
    }

    /// With the static wheel loads [N] of a balance, one per wheelset. A lone wheelset carries what it weighs, which is known.
    pub fn with_static_wheel_loads(mut self, loads: &[f64]) -> Self {
        if let [_, _, ..] = loads {
            self.wheelsets.iter_mut().zip(loads).for_each(|(wheelset, load)| wheelset.static_wheel_load = *load);
        }
        self
    }

    /// In steady rolling on ideal track: nothing displaces the rails, sleepers are not felt one by one, and the transient model of contact says what the creep law says.
    pub fn ideal(mut self) -> Self {
        self.track = self.track.ideal();
        self.laws.transient = None;
        // Rails on sleepers are what they are on the mean.
        if let Some(beam) = self.beam.take() {
            self.travelling_track = Some(beam.stand_in);
        }
        self
    }

    /// Lays another track under the wheels, as the search for a steady state does. Workspaces of before do not fit any more.
    pub fn lay(&mut self, track: Track) {
        self.track = track;
    }

    /// Searching for all places of all wheels at each evaluation, also where it is certain that they are the known ones.
    pub fn searching_always(mut self, always: bool) -> Self {
        self.search_always = always;
        self
    }

    /// Are the places of a wheel's contacts searched for? Otherwise only one can touch (or the formulation knows them itself).
    pub fn searches_contacts(&self, contact: usize) -> bool {
        self.searches[contact].is_some()
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        self.books_begin() + self.books.as_ref().map_or(0, EnergyBooks::states)
    }

    /// Do bodies and force elements alone have states, whole bodies? All of them are then in the Jacobian ([`Model::linearise`]).
    pub fn is_bodies_alone(&self) -> bool {
        self.contact_states_begin == self.dimension() && self.half.is_none()
    }

    /// Finds those weights from the elements' numbers as they are now.
    pub fn weigh_forces(&mut self) {
        self.force_weights = force_weights(&self.system);
    }

    /// Weight of the local error of a force element's state; `None` of other states.
    pub fn weight_of_force(&self, i: usize) -> Option<f64> {
        self.force_weights.get(i.checked_sub(2 * COORDINATES * self.system.bodies.len())?).copied()
    }

    /// Where the books of energy begin; they stand at the end of the state vector.
    pub fn books_begin(&self) -> usize {
        self.mean_states(self.wheelsets.len()).start
    }

    fn means_begin(&self) -> usize {
        self.rails_begin() + self.rail_state_count()
    }

    pub(super) fn rails_begin(&self) -> usize {
        self.deflections_begin() + self.contacts() * self.points * self.deflection_states()
    }

    fn deflections_begin(&self) -> usize {
        self.contact_states_begin + self.contacts() * self.formulation.states_per_contact()
    }

    /// States of a wheelset's means; nothing but the books of energy stands behind them.
    pub fn mean_states(&self, wheelset: usize) -> Range<usize> {
        let count = self.means.map_or(0, |_| SlidingMean::STATES);
        let first = self.means_begin() + wheelset * count;
        first..first + count
    }

    /// States of the tangential deflection of one contact: none without `contact.transient`.
    pub fn deflection_states(&self) -> usize {
        if self.laws.transient.is_some() { transient::STATES } else { 0 }
    }

    /// The tangential states of a wheel's contact `slot` (from 0) in the state vector; they stand at its end.
    pub fn deflection(&self, contact: usize, slot: usize) -> Range<usize> {
        let start = self.deflections_begin() + (contact * self.points + slot) * self.deflection_states();
        start..start + self.deflection_states()
    }

    /// Is a state one of those?
    pub fn is_deflection(&self, i: usize) -> bool {
        (self.deflections_begin()..self.rails_begin()).contains(&i)
    }

    /// A contact's own states in the state vector.
    pub fn contact_states(&self, contact: usize) -> Range<usize> {
        let count = self.formulation.states_per_contact();
        let start = self.contact_states_begin + contact * count;
        start..start + count
    }

    /// The bodies of the contacts that are constraints, contact by contact.
    pub(super) fn constrained_bodies(&self) -> Vec<usize> {
        let both = |wheelset: &Wheelset| [wheelset.body; 2];
        if self.formulation.constrains() { self.wheelsets.iter().flat_map(both).collect() } else { Vec::new() }
    }
}

/// The factor of friction at a contact.
#[inline(never)]
pub fn factor_at(map: &FrictionMap, side: Side, motion: &BodyMotion, report: &ContactReport) -> FrictionFactor {
    map.at(side, motion.distance + report.parameters.lead, report.profiles[1].d1)
}
