//! A model from its parts, and what its evaluations need.

use super::flank;
use super::frame_motion::MovingFrame;
use super::half_space_settings;
use super::memory::{Mode, ModelMemory, WheelMemory};
use super::model::{ContactLaws, LOAD_TOLERANCE, Model, force_weights};
use super::patch_loads::Loaded;
use super::patch_tables::PreparedTables;
use super::rail_scratch::RailScratch;
use super::rigid_scratch::RigidScratch;
use super::sliding_mean::MeanMemory;
use super::timers::Timers;
use super::wheel_search::{self, FEWEST, PreparedSearches};
use super::wheelset::Wheelset;
use super::work::Work;
use super::{Cached, ContactReport, Formulation, Workspace};
use crate::contact::patch::PatchLaw;
use crate::contact::search::nodes::NodeError;
use crate::contact::strips::{RailStrips, Scratch};
use crate::geometry::Side;
use crate::geometry::track::Track;
use crate::mbs::system::System;
use std::sync::Arc;

/// Everything that stays constant during a simulation, before a formulation is chosen.
#[derive(Debug)]
pub struct Parts {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
    /// Contacts that each wheel may have at the same time, at least 1.
    pub points: usize,
    /// Searches for them that other models of the same scene have prepared.
    pub prepared: PreparedSearches,
    /// Tables of patches that are there already.
    pub prepared_tables: PreparedTables,
}

/// Builds a formulation for the parts of a model.
pub type Build = Arc<dyn Fn(&Parts) -> Result<Box<dyn Formulation>, AssemblyError> + Send + Sync>;

/// A formulation can't treat a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    #[error("contact.node_spacing: {0}")]
    Nodes(NodeError),
    #[error("vehicle.joint: {0}")]
    Joints(crate::mbs::redundancy::AssemblyError),
    #[error(
        "interface.inputs: \"rail_motion\" needs elastic contact (contact.formulation = \"ECF-A\" or \"ECF-N\"): a constraint between wheel and rail would need the rail's acceleration, which is no input"
    )]
    RailMotion,
    #[error(
        "track.flexibility needs elastic contact (contact.formulation = \"ECF-A\" or \"ECF-N\", which know rails that move): a constraint between wheel and rail would make the rail's mass part of the constrained system"
    )]
    TravellingTrack,
    #[error(
        "track.flexibility: {sag:.1} mm is how far the mean wheel load presses a rail on {stiffness:.2} MN/m; starts are found up to {most} mm: expected a track that is stiffer under a wheel, {least:.1} MN/m or more (vertical_stiffness, or ballast_stiffness and pad_stiffness)"
    )]
    SoftTrack { sag: f64, stiffness: f64, most: f64, least: f64 },
    #[error(
        "track.flexibility.bays: a ring of {bays} bays is too short for wheels that stand {longest:.1} m apart on it: expected at least {least}, or none for as many as the vehicle needs"
    )]
    ShortRing { bays: usize, longest: f64, least: usize },
    #[error("effects.symmetry = \"half\", but {0}")]
    Half(#[from] super::failure::Asymmetry),
    #[error(
        "track.flexibility beside [contact.transient] does not know axles that twist (flexible_axle, independent_wheels); expected two of these three in a scene"
    )]
    TwistedAxle,
    #[error(
        "vehicle.wheelset.out_of_round needs elastic contact (contact.formulation = \"ECF-A\" or \"ECF-N\"): a constraint between wheel and rail would need how the radius changes twice over"
    )]
    OutOfRound,
    #[error(
        "track.flexibility stands beside \"rail_motion\" in interface.inputs: either the rails' motion comes from outside or the scene's own track gives way; expected one of them"
    )]
    TwoMotions,
    #[error(
        "contact.patch = \"{0}\" needs elastic contact (contact.formulation = \"ECF-A\" or \"ECF-N\"): a constraint holds the deepest places of rigid surfaces; expected contact.patch = \"ellipse\""
    )]
    RigidPatch(&'static str),
    #[error(
        "contact.patch = \"{0}\" has no tangential states: patches that join and part would have to hand them over; expected no [contact.transient], or contact.patch = \"ellipse\""
    )]
    TransientPatch(&'static str),
    #[error(
        "contact.patch = \"{0}\" needs contact.formulation = \"ECF-A\", which has no nodes and knows every place where a flange comes near; expected contact.patch = \"strips\" with ECF-N"
    )]
    NodesAndPatch(&'static str),
    #[error(
        "contact.patch = \"exact\" solves Kalker's tangential problem on the patch itself, and the creep law of the scene is one of ellipses; expected contact.creep.law = \"exact\" alone (no \
         kalker_factor), or contact.patch = \"strips\""
    )]
    CreepOfEllipses,
    #[error(
        "contact.patch = \"linear\": in the middle of the track the {side} wheel of {wheelset} does not stand on its tread under {:.1} kN: there is nothing to linearise about; expected another \
         contact.patch",
        1e-3 * load
    )]
    NothingLinear { wheelset: String, side: &'static str, load: f64 },
    #[error(
        "vehicle.force: \"{}\" and \"{}\" both let the wheels of {axle} turn against each other; expected one flexible_axle or independent_wheels for each wheelset",
        elements[0],
        elements[1]
    )]
    TwoTwists { axle: String, elements: [String; 2] },
    #[error(
        "preload = \"static\": no preloads hold {body} {direction} in its drawn position ({rest:.3} {unit} are left): an element with preload = \"static\" and a stiffness that way, or a joint, must carry it, and its centre of mass must stand between them; where preloads below are given as forces, they must fit the weight"
    )]
    StaticPreload { body: String, direction: &'static str, rest: f64, unit: &'static str },
    #[error(
        "preload = \"static\": {element} would have to pull with {force:.0} N, and it can only push: its ends (from, to) or its axis are the other way round, or the centre of mass stands outside what carries it"
    )]
    StaticPull { element: String, force: f64 },
}

/// Both rails in strips for patches with these wheelsets' wheels.
pub(super) fn rail_strips(track: &Track, wheelsets: &[Wheelset]) -> [RailStrips; 2] {
    Side::BOTH.map(|side| RailStrips::new(track.rail(side), wheelsets.iter().map(|wheelset| wheelset.wheel(side))))
}

impl Model {
    /// Completes the parts with a formulation.
    ///
    /// # Errors
    /// [`AssemblyError`] when the formulation can't treat the parts.
    pub fn new(parts: Parts, build: &Build) -> Result<Model, AssemblyError> {
        let formulation = build(&parts)?;
        let Parts { system, track, wheelsets, mut laws, points, prepared, prepared_tables } = parts;
        let strips = match laws.patch {
            PatchLaw::Ellipse => None,
            law if formulation.constrains() => return Err(AssemblyError::RigidPatch(law.name())),
            law if laws.transient.is_some() => return Err(AssemblyError::TransientPatch(law.name())),
            law if law.needs_all_places() && formulation.points_per_wheel() != 1 => return Err(AssemblyError::NodesAndPatch(law.name())),
            PatchLaw::Linear => None,
            PatchLaw::Strips | PatchLaw::Table | PatchLaw::Exact => Some(rail_strips(&track, &wheelsets)),
        };
        let half_spaces = match laws.patch {
            PatchLaw::Exact => {
                let (settings, quick) =
                    half_space_settings::settings(laws.creep.as_ref(), laws.material).ok_or(AssemblyError::CreepOfEllipses)?;
                laws.creep = quick;
                Some(settings)
            }
            _ => None,
        };
        let tables = match (&strips, laws.patch) {
            (Some(rails), PatchLaw::Table) => prepared_tables.of(&wheelsets, &track, rails),
            _ => Vec::new(),
        };
        let own = formulation.points_per_wheel();
        let mut searches = wheel_search::searches(&wheelsets, &track, laws.patch != PatchLaw::Linear, &prepared);
        let several = searches.iter().any(Option::is_some);
        // As many as the profiles can need; parts of a patch are found by the strips, whoever looks for places.
        let points = match own {
            1 if several => points,
            1 => 1,
            most if several => points.clamp(FEWEST, most),
            _ => FEWEST,
        };
        if own > 1 {
            searches.fill_with(|| None);
        }
        let contact_states_begin = system.dimension();
        let force_weights = force_weights(&system);
        let flanks = flank::flanks(&wheelsets, &track);
        Model {
            system,
            track,
            wheelsets,
            laws,
            formulation,
            points,
            contact_states_begin,
            searches,
            flanks,
            load_tolerance: LOAD_TOLERANCE,
            force_weights,
            body_modes: Vec::new(),
            design: Vec::new(),
            half: None,
            search_always: false,
            means: None,
            books: None,
            rail_motion: false,
            travelling_track: None,
            beam: None,
            out_of_round: Vec::new(),
            surfaces_move: false,
            strips,
            half_spaces,
            tables,
            linear: Vec::new(),
        }
        .linear()
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

    /// Strips of the rail that has more; 0 where patches are not made of strips.
    fn most_strips(&self) -> usize {
        self.strips.as_ref().map_or(0, |rails| rails.iter().map(RailStrips::len).max().unwrap_or(0))
    }

    /// What its evaluations work in.
    pub fn workspace(&self) -> Workspace {
        let constrained = self.constrained_bodies();
        let further = (self.points - 1) * self.contacts();
        let mut system = self.system.workspace(&constrained);
        self.add_stations(&mut system);
        let loaded = system.wrenches.len();
        Workspace {
            system,
            contacts: vec![ContactReport::default(); self.contacts()],
            further_contacts: vec![ContactReport::default(); further],
            rigid: if self.formulation.constrains() {
                RigidScratch::new(self.wheelsets.len(), loaded, self.dimension())
            } else {
                RigidScratch::default()
            },
            work: Work::default(),
            timers: Timers::default(),
            events: Vec::new(),
            cached: Cached::No,
            linearised: None,
            // Not copies of one: a copy has no room in front.
            strips: (0..self.contacts()).map(|_| Scratch::new(self.most_strips())).collect(),
            deeper: Scratch::new(self.most_strips()),
            loaded: Loaded::default(),
            tangent: None,
            frame: MovingFrame::default(),
            rails: RailScratch::new(self.beam.as_ref()),
        }
    }
}
