//! What a scene says about one wheelset, and how a lone one starts.

use crate::geometry::out_of_round::OutOfRound;
use crate::geometry::profile::ProfileChoice;
use crate::scene::limits::{SMALLEST, WIDEST};
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// `[vehicle.wheelset]`, or one of `[[vehicle.wheelset]]`.
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
    /// Does its spin make gyroscopic moments? (`effects.gyroscopic`)
    pub gyroscopic: bool,
    /// Of the left and the right wheel.
    pub out_of_round: [Option<OutOfRound>; 2],
}

/// Where a wheel's radius can't be read, m.
const USUAL_RADIUS: f64 = 0.46;

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

/// `[vehicle.initial]`: the distance of the vehicle's design origin, and what a lone wheelset has besides.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// Are `values` added to the steady state? Otherwise they are absolute.
    pub from_equilibrium: bool,
    /// Does the steady state balance what elements begin with (torques of motors and brakes)? That of small motions does; a run begins without and takes them up.
    pub driven: bool,
    /// In the order of [`INITIAL`]; of a vehicle of several bodies the distance alone counts.
    pub values: [f64; 10],
    /// What the scene file gives, until [`crate::scene::load`] has resolved it into `values`.
    pub given: [Option<f64>; 10],
}

impl Default for Initial {
    fn default() -> Self {
        Initial { from_equilibrium: true, driven: false, values: [0.0; 10], given: [None; 10] }
    }
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
        section.refuse_beyond("tread_circle_distance", Dimension::Length, WIDEST, "a distance in millimetres is written \"1500 mm\"")?;
        let half_tread_circle_distance = 0.5 * section.positive("tread_circle_distance", Dimension::Length)?;
        let transverse_inertia = section.at_least("inertia_xx", Dimension::Inertia, SMALLEST)?;
        let zz = section.at_least("inertia_zz", Dimension::Inertia, SMALLEST)?;
        if zz != transverse_inertia {
            return Err(section.error(
                "inertia_zz",
                format!("found {zz}, expected inertia_xx = {transverse_inertia}: a wheelset is a body of revolution"),
            ));
        }
        let radii = profiles.as_ref().map(|profiles| profiles.each_ref().map(|choice| choice.profile.at(0.0).value));
        let out_of_round = section.keep(OutOfRound::parse(section, radii.unwrap_or([USUAL_RADIUS; 2])))?;
        let (Some(profiles), Some(out_of_round)) = (profiles, out_of_round) else { return Err(section.stop()) };
        Ok(WheelsetSpec {
            name,
            mass,
            transverse_inertia,
            axial_inertia,
            vertical_load,
            half_tread_circle_distance,
            profiles,
            gyroscopic: true,
            out_of_round,
        })
    }
}

/// Most that a height is added to that of the equilibrium, m: a wheel's radius is meant to be absolute.
const FARTHEST: f64 = 0.2;

/// Most that a wheelset is turned at the start, rad.
pub const LARGEST_ANGLE: f64 = 0.5;

/// An angle of a wheelset on its track [rad]; a plain number that is too large for one was probably meant in degrees.
pub(super) fn not_degrees(section: &Section, key: &'static str, angle: f64) -> Result<(), SettingsError> {
    if angle.abs() <= LARGEST_ANGLE {
        return Ok(());
    }
    let degrees = if section.has_unit(key, Dimension::Angle) { String::new() } else { format!("; degrees are written \"{angle:?} deg\"") };
    Err(section.error(key, format!("found {angle:?} rad, expected at most {LARGEST_ANGLE} rad either way{degrees}")))
}

/// Reads `[vehicle.initial]` of a lone wheelset, or of a vehicle of several bodies.
pub(super) fn read_initial(section: Section, lone: bool) -> Result<Initial, SettingsError> {
    let mut initial = Initial::default();
    if !lone {
        initial.given[0] = section.optional(INITIAL[0].0, INITIAL[0].1)?;
        section.finish()?;
        return Ok(initial);
    }
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
    Ok(Initial { from_equilibrium, given, ..initial })
}
