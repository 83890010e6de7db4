//! Template `suspended_wheelset`: one wheelset on springs to a frame that travels with it.

use super::{Travel, VehicleSpec};
use crate::geometry::profile::{Part, ProfileChoice};
use crate::scene::spec::{SMALLEST, read_profiles};
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use nalgebra::{Vector3, vector};

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
    /// What the scene file gives, until [`super::load`] has resolved it into `values`.
    pub given: [Option<f64>; 10],
}

impl Default for Initial {
    fn default() -> Self {
        Initial { from_equilibrium: true, values: [0.0; 10], given: [None; 10] }
    }
}

/// Reads `[vehicle]` of this template.
pub(super) fn read(section: Section, template: &'static str) -> Result<VehicleSpec, SettingsError> {
    let travel = section.keep(Travel::read(&section))?;
    let wheelset = section.keep(section.section("wheelset").and_then(read_wheelset))?;
    let suspension = section.keep(section.optional_section("suspension").and_then(|found| found.map(read_suspension).transpose()))?;
    let initial = section.keep(section.section_or_empty("initial").and_then(read_initial))?;
    section.clone().finish()?;
    let (Some(travel), Some(wheelset), Some(suspension), Some(initial)) = (travel, wheelset, suspension, initial) else {
        return Err(section.stop());
    };
    let Travel { speed, speed_imposed, gravity } = travel;
    Ok(VehicleSpec { template, speed, speed_imposed, gravity, wheelset, suspension, initial, free: None })
}

fn read_wheelset(section: Section) -> Result<WheelsetSpec, SettingsError> {
    let profiles = section.keep(read_profiles(&section, ["profile", "left_profile", "right_profile"], Part::Wheel))?;
    let load = section.number("vertical_load", Dimension::Force)?;
    let spec = section.keep(WheelsetSpec::read(&section, "wheelset".into(), load, profiles))?;
    section.clone().finish()?;
    spec.ok_or_else(|| section.stop())
}

impl WheelsetSpec {
    /// Reads the keys that every wheelset has; `None`: its profiles could not be read.
    pub(super) fn read(
        section: &Section,
        name: String,
        vertical_load: f64,
        profiles: Option<[ProfileChoice; 2]>,
    ) -> Result<Self, SettingsError> {
        let mass = section.at_least("mass", Dimension::Mass, SMALLEST)?;
        let axial_inertia = section.at_least("inertia_yy", Dimension::Inertia, SMALLEST)?;
        let half_tread_circle_distance = 0.5 * section.positive("tread_circle_distance", Dimension::Length)?;
        let transverse_inertia = section.at_least("inertia_xx", Dimension::Inertia, SMALLEST)?;
        let zz = section.at_least("inertia_zz", Dimension::Inertia, SMALLEST)?;
        if zz != transverse_inertia {
            return Err(section.error(
                "inertia_zz",
                format!("found {zz}, expected inertia_xx = {transverse_inertia}: a wheelset is a body of revolution"),
            ));
        }
        let Some(profiles) = profiles else { return Err(section.stop()) };
        Ok(WheelsetSpec { name, mass, transverse_inertia, axial_inertia, vertical_load, half_tread_circle_distance, profiles })
    }
}

/// Most distance between the suspension's springs, m: further apart, no step would be short enough for their yaw stiffness.
const WIDEST: f64 = 10.0;

fn read_suspension(section: Section) -> Result<SuspensionSpec, SettingsError> {
    let mut spec = SuspensionSpec {
        distance: section.within("distance", Dimension::Length, (0.0, WIDEST))?,
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

/// Most that a height is added to that of the equilibrium, m: a wheel's radius is meant to be absolute.
const FARTHEST: f64 = 0.2;

/// An angle of a wheelset on its track [rad]; a plain number that is too large for one was probably meant in degrees.
pub(super) fn not_degrees(section: &Section, key: &'static str, angle: f64) -> Result<(), SettingsError> {
    const LARGEST: f64 = 0.5;
    if angle.abs() <= LARGEST {
        return Ok(());
    }
    Err(section
        .error(key, format!("found {angle:?} rad, expected at most {LARGEST} rad either way; degrees are written \"{angle:?} deg\"")))
}

fn read_initial(section: Section) -> Result<Initial, SettingsError> {
    let from_equilibrium = section.flag_or("from_equilibrium", true)?;
    let mut given = [None; 10];
    for (value, (key, dimension)) in given.iter_mut().zip(INITIAL) {
        *value = section.optional(key, dimension)?;
        if dimension == Dimension::Angle {
            not_degrees(&section, key, value.unwrap_or(0.0))?;
        }
    }
    if from_equilibrium && let Some(z) = given[2].filter(|z| z.abs() > FARTHEST) {
        let problem = format!(
            "found {z:?} m, which is added to the height in equilibrium; expected {FARTHEST} m or less, or from_equilibrium = false, which makes all of [vehicle.initial] absolute"
        );
        return Err(section.error("z", problem));
    }
    section.finish()?;
    Ok(Initial { from_equilibrium, values: [0.0; 10], given })
}
