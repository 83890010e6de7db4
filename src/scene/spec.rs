//! The scene as data: what a TOML file says, in SI units, checked piece by piece.
//!
//! FMU parameters are fields of this data; a model is assembled from it anew when they are set.

use super::solver_choice;
pub use super::vehicle::suspended::{INITIAL, Initial, SuspensionSpec, WheelsetSpec};
pub use super::vehicle::{TEMPLATES, VehicleSpec};
use crate::contact::transient::TransientSettings;
use crate::contact::{Material, creep, normal};
use crate::formulation::LOAD_TOLERANCE;
use crate::formulation::{
    self,
    points::{MOST_POINTS, PreparedSearches},
};
use crate::geometry::file::SceneFile;
use crate::geometry::profile::{self, Part, ProfileChoice};
use crate::geometry::track::centre_line::{Alignment, CentreLine};
use crate::geometry::track::{self, Deviation, gauge, node};
use crate::settings::{Section, SettingsError, Source, did_you_mean};
use crate::solve::{self, Integrator};
use crate::units::Dimension;
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
    pub solver: SolverSpec,
    pub interface: InterfaceSpec,
    pub run: RunSpec,
    /// What the models that are assembled from it share.
    pub prepared: PreparedSearches,
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
    /// That irregularities were read from.
    pub files: Vec<SceneFile>,
}

/// `[contact]`.
#[derive(Clone)]
pub struct ContactSpec {
    pub formulation_name: &'static str,
    pub formulation: formulation::Build,
    /// mu, -.
    pub friction: f64,
    /// C of Eq. 28, N s/m2; 0 with another law.
    pub damping: f64,
    /// Contacts that each wheel may have at the same time.
    pub points: usize,
    pub damping_law: normal::damping::Choice,
    pub material: Material,
    pub normal_name: String,
    pub normal: normal::Build,
    pub creep_name: String,
    pub creep: creep::Build,
    pub transient: Option<TransientSettings>,
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
}

/// Groups of inputs, outputs and parameters that an FMU may show.
pub const INPUT_GROUPS: &[&str] = &["drive_torque", "centre_forces", "friction", RAIL_MOTION];
pub const OUTPUT_GROUPS: &[&str] =
    &["motion", "wheels", "contacts", "suspension", "axles", "bodies", "sensors", "forces", SLIDING_MEANS, RAIL_FORCES];
/// The group that costs states: shown only where a scene names it.
pub const SLIDING_MEANS: &str = "sliding_means";
/// Motion of the rails from outside: only where a scene names it; with it, the forces on the rails are shown.
pub const RAIL_MOTION: &str = "rail_motion";
pub const RAIL_FORCES: &str = "rail_forces";
pub const PARAMETER_GROUPS: &[&str] = &["vehicle", "suspension", "contact", "solver", "initial"];

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

/// Smallest mass [kg] and inertia [kg m2] that a scene or a master may set.
pub const SMALLEST: f64 = 1e-6;
/// Smallest Young's modulus, Pa.
pub const SMALLEST_MODULUS: f64 = 1e6;
/// Largest number of output steps in a run.
pub const MOST_STEPS: f64 = 1e8;

/// `[run]`: the FMU's default experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunSpec {
    /// s.
    pub stop: f64,
    /// Communication and output step, s.
    pub step: f64,
}

impl Scene {
    /// Reads all tables.
    ///
    /// # Errors
    /// The first [`SettingsError`].
    pub fn read(name: &str, root: Section, source: Source) -> Result<Scene, SettingsError> {
        let name = &root.text_or("name", name)?;
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(root.error("name", format!("found \"{name}\", expected letters, digits and _, a letter first")));
        }
        let title = root.text_or("title", name)?;
        if title.chars().any(char::is_control) {
            return Err(root.error("title", "a control character can't stand in a title"));
        }
        let vehicle = super::vehicle::read(root.section("vehicle")?)?;
        let track = read_track(root.section("track")?)?;
        let contact = read_contact(root.section("contact")?)?;
        let solver = root.section("solver")?;
        let (automatic, why) = solver_choice::choose(&solver_choice::facts(&solver, &contact)?);
        let (solver_name, integrator) = solve::parse(&solver, automatic)?;
        let why = solver.word("integrator", &[solve::AUTO.name]).is_ok().then_some(why);
        let load_tolerance = read_load_tolerance(&solver)?;
        solver.finish()?;
        let interface = match root.optional_section("interface")? {
            Some(section) => read_interface(section, &vehicle)?,
            None => {
                InterfaceSpec { inputs: default_inputs(), outputs: default_outputs(&[]), parameters: PARAMETER_GROUPS.to_vec(), only: None }
            }
        };
        let run = root.section("run")?;
        let spec = RunSpec { stop: run.not_negative("stop", Dimension::Time)?, step: run.positive("step", Dimension::Time)? };
        if spec.stop / spec.step > MOST_STEPS {
            return Err(run.error("step", format!("found {:?} s, which makes more than {MOST_STEPS:?} steps until run.stop", spec.step)));
        }
        run.finish()?;
        root.finish()?;
        Ok(Scene {
            name: name.into(),
            source,
            title,
            vehicle,
            track,
            contact,
            solver: SolverSpec { name: solver_name, integrator, load_tolerance, why },
            interface,
            run: spec,
            prepared: PreparedSearches::default(),
        })
    }

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

/// One table for both sides, or one for each.
pub(super) fn read_profiles(
    section: &Section,
    [both, left, right]: [&'static str; 3],
    part: Part,
) -> Result<[ProfileChoice; 2], SettingsError> {
    let (own_left, own_right) = (section.optional_section(left)?, section.optional_section(right)?);
    if let (Some(left), Some(right)) = (own_left, own_right) {
        if section.has(both) {
            return Err(section.error(both, "each side has its own table: this one serves nothing"));
        }
        return Ok([profile::parse(left, part)?, profile::parse(right, part)?]);
    }
    let shared = profile::parse(section.section(both)?, part)?;
    let own = |key| section.optional_section(key)?.map(|own| profile::parse(own, part)).transpose();
    Ok([own(left)?.unwrap_or(shared.clone()), own(right)?.unwrap_or(shared)])
}

fn read_track(section: Section) -> Result<TrackSpec, SettingsError> {
    let inclination = read_inclination(&section)?;
    let grade = node::grade(&section)?;
    let rails = read_profiles(&section, ["rail", "left_rail", "right_rail"], Part::Rail)?;
    let half_rail_distance = read_half_distance(&section, &rails, inclination)?;
    let alignment = node::parse(&section, 2.0 * half_rail_distance)?;
    if alignment.is_some() && section.has("grade") {
        return Err(section.error("grade", "stands beside [[track.node]]; expected the nodes' own grade"));
    }
    let line = alignment.as_ref().and_then(|alignment| CentreLine::new(alignment, nalgebra::Vector3::zeros(), 0.0)).map(Arc::new);
    let (mut deviations, mut files) = (Vec::new(), Vec::new());
    for deviation in section.sections("deviation")? {
        deviations.extend(track::parse_deviation(deviation)?);
    }
    for irregularity in section.sections("irregularity")? {
        let irregularity = track::irregularity::parse(irregularity)?;
        deviations.extend(irregularity.deviations);
        files.extend(irregularity.file);
    }
    let start_fade = if section.has("start_fade") { Some(section.positive("start_fade", Dimension::Length)?) } else { None };
    section.finish()?;
    Ok(TrackSpec { half_rail_distance, inclination, grade, alignment, line, rails, deviations, start_fade, files })
}

/// Half of `rail_distance`, or what `gauge` makes of it.
fn read_half_distance(section: &Section, rails: &[ProfileChoice; 2], inclination: f64) -> Result<f64, SettingsError> {
    if !section.has("gauge") {
        return Ok(0.5 * section.positive("rail_distance", Dimension::Length)?);
    }
    if section.has("rail_distance") {
        return Err(section.error("gauge", "stands beside rail_distance; expected one of them"));
    }
    const DEPTH: f64 = 14e-3;
    let depth = section.number_or("gauge_depth", Dimension::Length, DEPTH)?;
    let reach = |choice: &ProfileChoice| gauge::reach(choice.profile.as_ref(), inclination, depth);
    Ok(0.5 * (section.positive("gauge", Dimension::Length)? + reach(&rails[0]) + reach(&rails[1])))
}

/// `"1:40"` is atan(1/40); otherwise an angle.
fn read_inclination(section: &Section) -> Result<f64, SettingsError> {
    const STEEPEST: f64 = 0.5;
    let text = section.text("inclination").unwrap_or_default();
    let angle = match text.split_once(':').map(|(one, run)| (one.trim().parse::<f64>(), run.trim().parse::<f64>())) {
        Some((Ok(one), Ok(run))) => (one / run).atan(),
        _ => section.number("inclination", Dimension::Angle)?,
    };
    if angle.abs() < STEEPEST {
        return Ok(angle);
    }
    let expected = "an angle below 0.5 rad, as a number in rad or a string such as \"1:40\" or \"1.4 deg\"";
    Err(section.error("inclination", format!("found {angle:?} rad, expected {expected}")))
}

fn read_contact(section: Section) -> Result<ContactSpec, SettingsError> {
    let (formulation_name, formulation) = formulation::parse(&section)?;
    let material = section.section("material")?;
    let poisson_ratio = material.not_negative("poisson_ratio", Dimension::None)?;
    if poisson_ratio > 0.5 {
        return Err(material.error("poisson_ratio", format!("found {poisson_ratio}, expected 0 to 0.5")));
    }
    let constants = Material { youngs_modulus: material.at_least("youngs_modulus", Dimension::Pressure, SMALLEST_MODULUS)?, poisson_ratio };
    material.finish()?;
    let normal_section = section.section("normal")?;
    let normal = normal::parse(&normal_section)?;
    let normal_name = normal_section.text("law")?;
    normal_section.finish()?;
    let creep_section = section.section("creep")?;
    let creep = creep::parse(&creep_section)?;
    let creep_name = creep_section.text("law")?;
    creep_section.finish()?;
    let (damping, damping_law) = normal::damping::parse(&section)?;
    let spec = ContactSpec {
        formulation_name,
        formulation,
        friction: section.not_negative("friction", Dimension::None)?,
        points: read_points(&section)?,
        damping,
        damping_law,
        material: constants,
        normal_name,
        normal,
        creep_name,
        creep,
        transient: TransientSettings::parse(&section)?,
    };
    section.finish()?;
    Ok(spec)
}

/// `contact.points`: 2 when absent.
fn read_points(section: &Section) -> Result<usize, SettingsError> {
    let points = section.number_or("points", Dimension::None, 2.0)?;
    if points.fract() == 0.0 && (1.0..=MOST_POINTS as f64).contains(&points) {
        return Ok(points as usize);
    }
    Err(section.error("points", format!("found {points:?}, expected a whole number from 1 to {MOST_POINTS}")))
}

/// All groups that cost nothing.
fn default_inputs() -> Vec<&'static str> {
    INPUT_GROUPS.iter().copied().filter(|group| *group != RAIL_MOTION).collect()
}

/// The same of outputs; forces on the rails belong to rails that move.
fn default_outputs(inputs: &[&str]) -> Vec<&'static str> {
    let moving = inputs.contains(&RAIL_MOTION);
    OUTPUT_GROUPS.iter().copied().filter(|group| *group != SLIDING_MEANS && (moving || *group != RAIL_FORCES)).collect()
}

fn read_interface(section: Section, vehicle: &VehicleSpec) -> Result<InterfaceSpec, SettingsError> {
    let only = section.optional_texts("only")?;
    let parts = vehicle.part_names();
    for name in only.iter().flatten() {
        let within = |part: &&str| part.strip_prefix(name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        if !parts.iter().any(within) {
            let problem = format!("found \"{name}\"{}, expected parts of the vehicle: {}", did_you_mean(name, &parts), parts.join(", "));
            return Err(section.error("only", problem));
        }
    }
    let inputs = if section.has("inputs") { section.words_or_all("inputs", INPUT_GROUPS)? } else { default_inputs() };
    let spec = InterfaceSpec {
        outputs: if section.has("outputs") { section.words_or_all("outputs", OUTPUT_GROUPS)? } else { default_outputs(&inputs) },
        inputs,
        parameters: section.words_or_all("parameters", PARAMETER_GROUPS)?,
        only,
    };
    section.finish()?;
    Ok(spec)
}

/// `solver.load_tolerance`.
fn read_load_tolerance(solver: &Section) -> Result<f64, SettingsError> {
    const RANGE: std::ops::RangeInclusive<f64> = 1e-9..=0.5;
    let value = solver.number_or("load_tolerance", Dimension::None, LOAD_TOLERANCE)?;
    if RANGE.contains(&value) {
        return Ok(value);
    }
    Err(solver.error(
        "load_tolerance",
        format!("found {value:?}, expected {:?} to {:?} (parts of the static wheel load)", RANGE.start(), RANGE.end()),
    ))
}
