//! The scene as data: what a TOML file says, in SI units, checked piece by piece.
//!
//! FMU parameters are fields of this data; a model is assembled from it anew when they are set.

use crate::contact::transient::TransientSettings;
use crate::contact::{Material, creep, normal};
use crate::formulation::{self, points::MOST_POINTS};
use crate::geometry::profile::{self, Part, ProfileChoice};
use crate::geometry::track::centre_line::{Alignment, CentreLine};
use crate::geometry::track::{self, Deviation, gauge, node};
use crate::settings::{Section, SettingsError, Source};
use crate::solve::{self, Integrator};
use crate::units::Dimension;
use nalgebra::{Vector3, vector};
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
}

/// `[vehicle]`, template `suspended_wheelset`.
#[derive(Clone, Debug)]
pub struct VehicleSpec {
    pub template: &'static str,
    /// V, m/s; negative rolls backward.
    pub speed: f64,
    /// Is the speed imposed? Otherwise it is that at the start.
    pub speed_imposed: bool,
    /// g, m/s2.
    pub gravity: f64,
    pub wheelset: WheelsetSpec,
    pub suspension: Option<SuspensionSpec>,
    pub initial: Initial,
}

/// `[vehicle.wheelset]`.
#[derive(Clone, Debug)]
pub struct WheelsetSpec {
    pub name: String,
    /// kg.
    pub mass: f64,
    /// Ixx = Izz, kg m2.
    pub transverse_inertia: f64,
    /// Iyy, kg m2.
    pub axial_inertia: f64,
    /// N, downward.
    pub vertical_load: f64,
    /// Half the distance between the tread circles, m.
    pub half_tread_circle_distance: f64,
    /// Of the left and the right wheel.
    pub profiles: [ProfileChoice; 2],
}

/// `[vehicle.suspension]`: two elements in each direction.
#[derive(Clone, Debug, PartialEq)]
pub struct SuspensionSpec {
    /// Between the attachment points, m.
    pub distance: f64,
    /// N/m and N s/m of each element.
    pub longitudinal_stiffness: f64,
    pub longitudinal_damping: f64,
    pub lateral_stiffness: f64,
    pub lateral_damping: f64,
    /// Does the scene call for elements in that direction? (parameters do not change it)
    pub longitudinal: bool,
    pub lateral: bool,
}

/// Initial coordinates and velocities that a scene or a master may choose, in this order.
pub const INITIAL: [(&str, Dimension); 10] = [
    ("distance", Dimension::Length),
    ("y", Dimension::Length),
    ("z", Dimension::Length),
    ("roll", Dimension::Angle),
    ("yaw", Dimension::Angle),
    ("vy", Dimension::Speed),
    ("vz", Dimension::Speed),
    ("roll_rate", Dimension::AngularSpeed),
    ("yaw_rate", Dimension::AngularSpeed),
    ("pitch_rate", Dimension::AngularSpeed),
];

/// `[vehicle.initial]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// Are `values` added to the steady rolling equilibrium? Otherwise they are absolute.
    pub from_equilibrium: bool,
    /// In the order of [`INITIAL`].
    pub values: [f64; 10],
    /// What the scene file gives, absolute; kept until [`super::load`] has resolved it into `values`.
    pub given: [Option<f64>; 10],
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
    pub deviations: Vec<Deviation>,
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
    pub name: &'static str,
    pub integrator: Arc<dyn Integrator>,
}

/// Groups of inputs, outputs and parameters that an FMU may show.
pub const INPUT_GROUPS: &[&str] = &["drive_torque", "centre_forces", "friction"];
pub const OUTPUT_GROUPS: &[&str] = &["motion", "wheels", "contacts", "suspension"];
pub const PARAMETER_GROUPS: &[&str] = &["vehicle", "suspension", "contact", "solver", "initial"];

/// `[interface]`: names of groups; all when absent.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceSpec {
    pub inputs: Vec<&'static str>,
    pub outputs: Vec<&'static str>,
    pub parameters: Vec<&'static str>,
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
        let vehicle = read_vehicle(root.section("vehicle")?)?;
        let track = read_track(root.section("track")?)?;
        let contact = read_contact(root.section("contact")?)?;
        let solver = root.section("solver")?;
        let (solver_name, integrator) = solve::parse(&solver)?;
        solver.finish()?;
        let interface = match root.optional_section("interface")? {
            Some(section) => read_interface(section)?,
            None => InterfaceSpec { inputs: INPUT_GROUPS.to_vec(), outputs: OUTPUT_GROUPS.to_vec(), parameters: PARAMETER_GROUPS.to_vec() },
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
            solver: SolverSpec { name: solver_name, integrator },
            interface,
            run: spec,
        })
    }

    /// Files that the scene refers to.
    pub fn files(&self) -> impl Iterator<Item = &profile::ProfileFile> {
        let [left_wheel, right_wheel] = &self.vehicle.wheelset.profiles;
        let [left_rail, right_rail] = &self.track.rails;
        let choices = [(left_wheel, None), (right_wheel, Some(left_wheel)), (left_rail, None), (right_rail, Some(left_rail))];
        // Both sides may share one table.
        let key = |choice: &ProfileChoice| choice.file.as_ref().map(|file| file.key.clone());
        let own = choices.into_iter().filter(move |(choice, other)| other.is_none_or(|other| key(other) != key(choice)));
        own.filter_map(|(choice, _)| choice.file.as_ref())
    }
}

/// Templates that `vehicle.template` can name.
pub static TEMPLATES: &[(&str, &str)] =
    &[("suspended_wheelset", "one wheelset on springs to a frame that travels with it (paper, section 3.4)")];

fn read_vehicle(section: Section) -> Result<VehicleSpec, SettingsError> {
    let names: Vec<&'static str> = TEMPLATES.iter().map(|template| template.0).collect();
    let template = section.word("template", &names)?;
    let speed = section.number("speed", Dimension::Speed)?;
    let speed_imposed = section.word_or("travel", &["imposed", "free"], "imposed")? == "imposed";
    if speed == 0.0 && speed_imposed {
        return Err(section.error("speed", "found 0, but creepages are relative to the travelling speed; expected any other number"));
    }
    let gravity = section.not_negative("gravity", Dimension::Acceleration)?;
    let wheelset = read_wheelset(section.section("wheelset")?)?;
    let suspension = section.optional_section("suspension")?.map(read_suspension).transpose()?;
    let initial = match section.optional_section("initial")? {
        Some(section) => read_initial(section)?,
        None => Initial { from_equilibrium: true, values: [0.0; 10], given: [None; 10] },
    };
    section.finish()?;
    Ok(VehicleSpec { template, speed, speed_imposed, gravity, wheelset, suspension, initial })
}

fn read_wheelset(section: Section) -> Result<WheelsetSpec, SettingsError> {
    let transverse_inertia = section.at_least("inertia_xx", Dimension::Inertia, SMALLEST)?;
    let zz = section.at_least("inertia_zz", Dimension::Inertia, SMALLEST)?;
    if zz != transverse_inertia {
        return Err(section
            .error("inertia_zz", format!("found {zz}, expected inertia_xx = {transverse_inertia}: a wheelset is a body of revolution")));
    }
    let spec = WheelsetSpec {
        name: "wheelset".into(),
        mass: section.at_least("mass", Dimension::Mass, SMALLEST)?,
        transverse_inertia,
        axial_inertia: section.at_least("inertia_yy", Dimension::Inertia, SMALLEST)?,
        vertical_load: section.number("vertical_load", Dimension::Force)?,
        half_tread_circle_distance: 0.5 * section.positive("tread_circle_distance", Dimension::Length)?,
        profiles: read_profiles(&section, ["profile", "left_profile", "right_profile"], Part::Wheel)?,
    };
    section.finish()?;
    Ok(spec)
}

/// One table for both sides, or one for each.
fn read_profiles(section: &Section, [both, left, right]: [&'static str; 3], part: Part) -> Result<[ProfileChoice; 2], SettingsError> {
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

fn read_suspension(section: Section) -> Result<SuspensionSpec, SettingsError> {
    let mut spec = SuspensionSpec {
        distance: section.not_negative("distance", Dimension::Length)?,
        longitudinal_stiffness: section.not_negative("longitudinal_stiffness", Dimension::Stiffness)?,
        longitudinal_damping: section.not_negative("longitudinal_damping", Dimension::Damping)?,
        lateral_stiffness: section.not_negative("lateral_stiffness", Dimension::Stiffness)?,
        lateral_damping: section.not_negative("lateral_damping", Dimension::Damping)?,
        longitudinal: false,
        lateral: false,
    };
    spec.longitudinal = spec.longitudinal_stiffness != 0.0 || spec.longitudinal_damping != 0.0;
    spec.lateral = spec.lateral_stiffness != 0.0 || spec.lateral_damping != 0.0;
    section.finish()?;
    Ok(spec)
}

impl SuspensionSpec {
    /// Attachment points on the axle, left and right, in axle axes [m].
    pub fn attachments(&self) -> [Vector3<f64>; 2] {
        [vector![0.0, 0.5 * self.distance, 0.0], vector![0.0, -0.5 * self.distance, 0.0]]
    }
}

fn read_initial(section: Section) -> Result<Initial, SettingsError> {
    let from_equilibrium = section.flag_or("from_equilibrium", true)?;
    let mut given = [None; 10];
    for (value, (key, dimension)) in given.iter_mut().zip(INITIAL) {
        *value = section.optional(key, dimension)?;
    }
    section.finish()?;
    Ok(Initial { from_equilibrium, values: [0.0; 10], given })
}

fn read_track(section: Section) -> Result<TrackSpec, SettingsError> {
    let inclination = read_inclination(&section)?;
    let grade = section.number_or("grade", Dimension::Angle, 0.0)?;
    let rails = read_profiles(&section, ["rail", "left_rail", "right_rail"], Part::Rail)?;
    let half_rail_distance = read_half_distance(&section, &rails, inclination)?;
    let alignment = node::parse(&section, 2.0 * half_rail_distance)?;
    if alignment.is_some() && section.has("grade") {
        return Err(section.error("grade", "stands beside [[track.node]]; expected the nodes' own grade"));
    }
    let line = alignment.as_ref().and_then(|alignment| CentreLine::new(alignment, Vector3::zeros(), 0.0)).map(Arc::new);
    let deviations = section.sections("deviation")?.into_iter().map(track::parse_deviation).collect::<Result<_, _>>()?;
    section.finish()?;
    Ok(TrackSpec { half_rail_distance, inclination, grade, alignment, line, rails, deviations })
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

fn read_interface(section: Section) -> Result<InterfaceSpec, SettingsError> {
    let spec = InterfaceSpec {
        inputs: section.words_or_all("inputs", INPUT_GROUPS)?,
        outputs: section.words_or_all("outputs", OUTPUT_GROUPS)?,
        parameters: section.words_or_all("parameters", PARAMETER_GROUPS)?,
    };
    section.finish()?;
    Ok(spec)
}
