//! The scene as data: what a TOML file says, in SI units, checked piece by piece.
//!
//! FMU parameters are fields of this data; a model is assembled from it anew when they are set.

use super::effects::Effects;
pub use super::limits::{MOST_STEPS, SMALLEST, SMALLEST_MODULUS};
pub use super::vehicle::VehicleSpec;
pub use super::vehicle::wheelset::{INITIAL, Initial, WheelsetSpec};
use crate::contact::friction::FrictionMap;
use crate::contact::patch::PatchLaw;
use crate::contact::transient::TransientSettings;
use crate::contact::{Material, creep, normal};
use crate::formulation::{self, flexibility::Flexibility, patch_tables::PreparedTables, wheel_search::PreparedSearches};
use crate::geometry::file::SceneFile;
use crate::geometry::profile::ProfileChoice;
use crate::geometry::track::centre_line::{Alignment, CentreLine};
use crate::geometry::track::{Deviation, gauge};
use crate::settings::Source;
use crate::solve::Integrator;
use std::sync::Arc;

/// A scene file, read and checked.
#[derive(Clone)]
pub struct Scene {
    /// Key `name`, else the name of the embedded scene or of the file without extension: the FMU's model identifier.
    pub name: String,
    /// The text that this scene was read from, with `--set` applied.
    pub source: Source,
    pub title: String,
    pub vehicle: VehicleSpec,
    pub track: TrackSpec,
    pub contact: ContactSpec,
    /// What of all that is left out.
    pub effects: Effects,
    pub solver: SolverSpec,
    pub interface: InterfaceSpec,
    pub run: RunSpec,
    /// What the models that are assembled from it share.
    pub prepared: PreparedSearches,
    /// Tables of its patches, where it reads them from tables.
    pub tables: PreparedTables,
    /// Contacts that a wheel may have at once: `contact.points`, or as many as its profiles can need.
    pub points: usize,
}

/// `[track]`.
#[derive(Clone, Debug)]
pub struct TrackSpec {
    /// Half the distance between the rail sections' origins, m.
    pub half_rail_distance: f64,
    /// Of the rail sections toward the track centre, rad.
    pub inclination: f64,
    /// Of a straight track, rad, climbing positive.
    pub grade: f64,
    /// `[[track.node]]`, and the centre line that they make (`None`: straight and level).
    pub alignment: Option<Alignment>,
    pub line: Option<Arc<CentreLine>>,
    /// Left and right.
    pub rails: [ProfileChoice; 2],
    /// Of single rails, and those that irregularities make of both.
    pub deviations: Vec<Deviation>,
    /// Length in front of the starting vehicle over which they grow from nothing, m; `None`: they are what they are.
    pub start_fade: Option<f64>,
    /// Track that gives way; `None`: rigid.
    pub flexibility: Option<Flexibility>,
    /// That irregularities were read from.
    pub files: Vec<SceneFile>,
    /// What of these is perhaps not meant.
    pub doubts: Vec<String>,
}

impl TrackSpec {
    /// How far the rails' inner faces stand toward the centre from their sections' origins, m, left and right ([`gauge::reach`]); `None` where a profile ends too early to tell.
    pub fn reaches(&self) -> [Option<f64>; 2] {
        self.rails.each_ref().map(|choice| gauge::reach(choice.profile.as_ref(), self.inclination, gauge::DEPTH).ok())
    }

    /// Distance between the rails' inner faces where nothing displaces them, m.
    pub fn gauge(&self) -> Option<f64> {
        let [left, right] = self.reaches();
        Some(2.0 * self.half_rail_distance - left? - right?)
    }
}

/// `[contact]`.
#[derive(Clone)]
pub struct ContactSpec {
    pub formulation_name: &'static str,
    pub formulation: formulation::Build,
    /// mu, -.
    pub friction: f64,
    /// Factors of it by place.
    pub friction_map: Option<FrictionMap>,
    /// C of Eq. 28, N s/m2; 0 with another law.
    pub damping: f64,
    /// Contacts that each wheel may have at the same time; `None`: as many as it can need.
    pub points: Option<usize>,
    pub damping_law: normal::damping::Choice,
    pub material: Material,
    pub normal_name: String,
    pub normal: normal::Build,
    pub creep_name: String,
    pub creep: creep::Build,
    pub transient: Option<TransientSettings>,
    pub patch: PatchSpec,
}

impl ContactSpec {
    /// Are contacts elastic, and does nothing damp them?
    pub fn rings(&self) -> bool {
        !self.damping_law.damps(self.damping) && !formulation::CONSTRAINTS.contains(&self.formulation_name)
    }
}

/// `contact.patch`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchSpec {
    pub law: PatchLaw,
    /// Why "auto" is this law; `None` where the scene names it.
    pub why: Option<&'static str>,
}

/// `[solver]`.
#[derive(Clone, Debug)]
pub struct SolverSpec {
    /// Of the method; where the scene says "auto", of the one that this is.
    pub name: &'static str,
    pub integrator: Arc<dyn Integrator>,
    /// Error of contact forces that a step may make, in parts of the static wheel load, -.
    pub load_tolerance: f64,
    /// Why "auto" is this method.
    pub why: Option<&'static str>,
    /// Is the tolerance the default one?
    pub assumed: bool,
}

/// Groups of outputs and parameters that an FMU may show; those of inputs are in `formulation::inputs`.
pub const OUTPUT_GROUPS: &[&str] = &[
    "motion",
    "wheels",
    "contacts",
    "suspension",
    "axles",
    "bodies",
    "sensors",
    "forces",
    SLIDING_MEANS,
    RAIL_FORCES,
    ADHESION,
    POWER,
    ENERGY,
];
/// The group that costs states: shown only where a scene names it.
pub const SLIDING_MEANS: &str = "sliding_means";
/// Slip and adhesion of wheelsets: shown only where a scene names it.
pub const ADHESION: &str = "adhesion";
/// Power of friction, inputs and elements: shown only where a scene names it.
pub const POWER: &str = "power";
/// Stored energy and what has gone in and out since the start: costs states, and is shown only where a scene names it.
pub const ENERGY: &str = "energy";
/// Groups that are shown only where a scene names them.
pub const ON_REQUEST: [&str; 4] = [SLIDING_MEANS, ADHESION, POWER, ENERGY];
/// Shown where rails move from outside.
pub const RAIL_FORCES: &str = "rail_forces";
pub const PARAMETER_GROUPS: &[&str] = &["vehicle", "suspension", "contact", "track", "solver", "initial"];

/// `[interface]`: names of groups; all when absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceSpec {
    pub inputs: Vec<&'static str>,
    pub outputs: Vec<&'static str>,
    pub parameters: Vec<&'static str>,
    /// Parts of the vehicle whose variables are shown; `None`: all.
    pub only: Option<Vec<String>>,
}

impl InterfaceSpec {
    /// Are variables of that name, or of the part of that name, shown?
    pub fn shows(&self, name: &str) -> bool {
        let within = |part: &String| name.strip_prefix(part.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        self.only.as_ref().is_none_or(|only| only.iter().any(within))
    }
}

/// `[run]`: the FMU's default experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunSpec {
    /// s.
    pub stop: f64,
    /// Communication and output step, s.
    pub step: f64,
}

impl Scene {
    /// Files that the scene refers to.
    pub fn files(&self) -> impl Iterator<Item = &SceneFile> {
        let [left_rail, right_rail] = &self.track.rails;
        let choices = [(left_rail, None), (right_rail, Some(left_rail))];
        // Both sides may share one table.
        let key = |choice: &ProfileChoice| choice.file.as_ref().map(|file| file.key.clone());
        let own = choices.into_iter().filter(move |(choice, other)| other.is_none_or(|other| key(other) != key(choice)));
        self.vehicle.files().into_iter().chain(own.filter_map(|(choice, _)| choice.file.as_ref())).chain(&self.track.files)
    }
}
