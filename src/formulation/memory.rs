//! What a model remembers of its past beside the state vector: where contacts were found last and how long no search is needed, which
//! form they have, the past of sliding means, where bodies are along a curved track.
//!
//! It belongs to the state: what an evaluation does depends on it (by rounding, but for the contacts' mode), so it is saved and restored
//! with it. Copying it onto another of the same model allocates nothing.

use super::partition::Partition;
use super::prediction::{POSE, Prediction};
use super::sliding_mean::MeanMemory;
use super::wheel_search::MOST_POINTS;
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::global::{Watch, WheelPose};
use serde::{Deserialize, Serialize};

/// All of it.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelMemory {
    /// By contact index.
    pub wheels: Vec<WheelMemory>,
    /// By wheelset: which variables ACCF integrates; `None` before it has chosen, and in other formulations.
    pub partitions: Vec<Option<ChosenPartition>>,
    /// By wheelset, where the scene asks for sliding means.
    pub means: Vec<MeanMemory>,
    /// By body, on a curved track: its distance at the last evaluation, m, from which the next projection starts.
    pub distances: Vec<f64>,
}

impl Clone for ModelMemory {
    fn clone(&self) -> Self {
        let ModelMemory { wheels, partitions, means, distances } = self;
        ModelMemory { wheels: wheels.clone(), partitions: partitions.clone(), means: means.clone(), distances: distances.clone() }
    }

    fn clone_from(&mut self, other: &Self) {
        self.wheels.clone_from(&other.wheels);
        self.partitions.clone_from(&other.partitions);
        self.means.clone_from(&other.means);
        self.distances.clone_from(&other.distances);
    }
}

impl ModelMemory {
    /// Takes over what motion along the track is found and averaged with, and leaves what is known of contacts.
    pub fn take_paths(&mut self, other: &ModelMemory) {
        self.means.clone_from(&other.means);
        self.distances.clone_from(&other.distances);
    }

    /// Could it be of the same model as `other`?
    pub fn fits(&self, other: &ModelMemory) -> bool {
        self.wheels.len() == other.wheels.len()
            && self.partitions.len() == other.partitions.len()
            && self.means.len() == other.means.len()
            && self.means.iter().zip(&other.means).all(|(own, other)| own.fits(other))
            && self.distances.len() == other.distances.len()
    }
}

/// That of one wheel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WheelMemory {
    pub mode: Mode,
    /// How many of the wheel's places have ceased to exist under load.
    pub vanished: u32,
    /// By number of the contact; a wheel without a search has the first alone.
    pub places: [PlaceMemory; MOST_POINTS],
    /// Ridges between contacts that are followed.
    pub ridges: [Option<RidgeMemory>; MOST_POINTS - 1],
    /// Until when no search is needed.
    pub searched: Allowance,
    /// Until when nothing that is watched needs a look.
    pub watched: Allowance,
    pub watch: Watch,
    /// The pose at which all places were located last.
    pub located: [f64; POSE],
}

/// What a contact is at present.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// A constraint.
    Rigid {
        /// N, N, from which the next balance starts; below zero where it would pull.
        normal_force: f64,
        /// Penetration at which the normal law gives it, m.
        approach: f64,
        /// How far its place is from being left (see `rigid::lasting`), 1/m; infinity where there is no other.
        lasting: f64,
    },
    /// Elastic.
    Elastic {
        /// When it tries next to become a constraint again, s; infinity where it never does.
        next_try: f64,
        /// How often it has tried.
        tries: u32,
    },
}

impl Mode {
    /// Elastic for good.
    pub const ELASTIC: Mode = Mode::Elastic { next_try: f64::INFINITY, tries: 0 };

    /// A constraint that carries so much [N] under a penetration of `approach` [m].
    pub fn rigid(normal_force: f64, approach: f64) -> Mode {
        Mode::Rigid { normal_force, approach, lasting: f64::INFINITY }
    }

    #[inline]
    pub fn is_elastic(&self) -> bool {
        matches!(self, Mode::Elastic { .. })
    }
}

/// Where a contact was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlaceMemory {
    /// Is it followed?
    pub followed: bool,
    pub parameters: SurfaceParameters,
    /// m.
    pub penetration: f64,
    /// Was it pressed at the last event?
    pub pressed: bool,
    pub prediction: Prediction,
}

/// Where a ridge between two contacts was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RidgeMemory {
    /// Numbers of the contacts on both sides.
    pub between: [usize; 2],
    pub parameters: SurfaceParameters,
    pub prediction: Prediction,
}

/// A distance [m] by which the wheel may move against its rail from a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Allowance {
    pub budget: f64,
    pub from: WheelPose,
}

/// ACCF's choice for one wheelset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChosenPartition {
    pub partition: Partition,
    /// How well conditioned the dependent variables' block was then; `None` for a choice that crosses a break.
    pub conditioning: Option<f64>,
}

impl WheelMemory {
    /// A wheel of which nothing is known yet.
    pub fn new(mode: Mode) -> Self {
        WheelMemory {
            mode,
            vanished: 0,
            places: Default::default(),
            ridges: Default::default(),
            searched: Allowance::default(),
            watched: Allowance::default(),
            watch: Watch::default(),
            located: [0.0; POSE],
        }
    }

    /// Where the first contact was.
    #[inline]
    pub fn start(&self) -> &SurfaceParameters {
        &self.places[0].parameters
    }

    #[inline]
    pub fn set_start(&mut self, found: SurfaceParameters) {
        self.places[0].parameters = found;
    }

    /// The next evaluation must search for contacts.
    pub fn forget(&mut self) {
        self.searched.budget = 0.0;
    }
}
