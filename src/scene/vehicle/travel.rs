//! How fast a vehicle travels, and what holds its speed: `vehicle.speed`, `travel`, `gravity`.
//!
//! `speed` is a number, or a list of nodes `{time = ..., speed = ...}` or `{distance = ..., speed = ...}`: a table that the imposed speed follows
//! ([`SpeedProfile`]), or a table `{start = ..., time_constant = ..., largest_acceleration = ...}`: a speed that an input gives and the vehicle follows
//! ([`SpeedInput`]). A run that begins from equilibrium begins where the table's slope is zero, because steady running knows no acceleration.

use super::VehicleSpec;
use crate::mbs::driving::Course;
use crate::mbs::speed_input::SpeedInput;
use crate::mbs::speed_profile::{Over, SpeedProfile};
use crate::scene::equilibrium::EquilibriumError;
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

/// `vehicle.gravity` where the scene does not say it, m/s2.
const GRAVITY: f64 = 9.81;

/// Greatest travelling speed, m/s: contact stresses are those of bodies at rest, which holds as long as the speed is small against that of waves along
/// steel's surface (2900 m/s). At a sixth of it stresses of inertia, in the square of that ratio, reach 3 %; the fastest train so far
/// did 160 m/s.
pub const FASTEST: f64 = 500.0;
/// The same in words.
const FASTEST_WHY: &str = "contact is computed as at rest, which holds far below the speed of waves along steel's surface (2900 m/s)";

/// Of a speed that is an input, where the scene does not say it: T [s] and A [m/s2]. The second is beyond what rails hold of most brakes.
const TIME_CONSTANT: f64 = 0.5;
const LARGEST_ACCELERATION: f64 = 3.0;
/// Their ranges: a time constant of a few steps of a wheelset and longer; an acceleration that is not 0, up to what stops no train.
const TIME_CONSTANTS: (f64, f64) = (0.02, 1000.0);
const ACCELERATIONS: (f64, f64) = (1e-6, 20.0);

/// What all vehicles have in common.
pub(super) struct Travel {
    pub speed: f64,
    pub speed_imposed: bool,
    pub course: Course,
    pub gravity: f64,
}

impl Travel {
    pub fn read(section: &Section) -> Result<Self, SettingsError> {
        let nodes = section.sections("speed").unwrap_or_default();
        let speed_imposed = section.word_or("travel", &["imposed", "free"], "imposed")? == "imposed";
        if !nodes.is_empty() && !speed_imposed {
            let problem = "found a list of nodes, but with travel = \"free\" forces along the track change the speed; expected one number, that at the start, or travel = \"imposed\"";
            return Err(section.error("speed", problem));
        }
        let follows = if section.has_table("speed") { section.optional_section("speed")? } else { None };
        if follows.is_some() && !speed_imposed {
            let problem = "found a table (a speed that is an input), but with travel = \"free\" forces along the track change the speed; expected one number, that at the start, or travel = \"imposed\"";
            return Err(section.error("speed", problem));
        }
        let gravity = section.not_negative_or("gravity", Dimension::Acceleration, GRAVITY)?;
        if !nodes.is_empty() {
            let profile = Arc::new(read_profile(section, nodes)?);
            return Ok(Travel { speed: profile.nodes()[0][1], speed_imposed, course: Course::Profile(profile), gravity });
        }
        if let Some(own) = follows {
            let (speed, input) = read_input(&own)?;
            own.finish()?;
            return Ok(Travel { speed, speed_imposed, course: Course::Input(input), gravity });
        }
        section.refuse_beyond("speed", Dimension::Speed, FASTEST, FASTEST_WHY)?;
        let speed = section.number("speed", Dimension::Speed)?;
        if speed == 0.0 && speed_imposed {
            return Err(section.error("speed", STANDING));
        }
        Ok(Travel { speed, speed_imposed, course: Course::Constant, gravity })
    }
}

/// Why an imposed speed is not 0.
const STANDING: &str = "found 0, but creepages are relative to the travelling speed; expected any other number (a vehicle that stands, or stops, takes travel = \"free\" and [contact.transient])";

/// A speed that is an input: that at the start, and how it is followed.
fn read_input(section: &Section) -> Result<(f64, SpeedInput), SettingsError> {
    section.refuse_beyond("start", Dimension::Speed, FASTEST, FASTEST_WHY)?;
    let speed = section.number("start", Dimension::Speed)?;
    if speed == 0.0 {
        return Err(section.error("start", STANDING));
    }
    let or = |key, dimension, default, range| if section.has(key) { section.within(key, dimension, range) } else { Ok(default) };
    let input = SpeedInput {
        time_constant: or("time_constant", Dimension::Time, TIME_CONSTANT, TIME_CONSTANTS)?,
        largest_acceleration: or("largest_acceleration", Dimension::Acceleration, LARGEST_ACCELERATION, ACCELERATIONS)?,
        fastest: FASTEST,
    };
    Ok((speed, input))
}

/// The table; never empty.
fn read_profile(section: &Section, nodes: Vec<Section>) -> Result<SpeedProfile, SettingsError> {
    if nodes.len() < 2 {
        return Err(section.error("speed", "found one node; expected two or more, or one number for a constant speed"));
    }
    let over = if nodes[0].has("distance") && !nodes[0].has("time") { Over::Distance } else { Over::Time };
    let (key, other, dimension, unit) = match over {
        Over::Time => ("time", "distance", Dimension::Time, "s"),
        Over::Distance => ("distance", "time", Dimension::Length, "m"),
    };
    let mut table: Vec<[f64; 2]> = Vec::with_capacity(nodes.len());
    for node in nodes {
        if node.has(other) {
            let problem = format!("stands in a list over {key}; expected {key} in all nodes or {other} in all nodes");
            return Err(node.error(other, problem));
        }
        if !node.has(key) {
            return Err(node.error(key, "is missing; expected a time or a distance in each node, the same in all"));
        }
        let place = node.number(key, dimension)?;
        node.refuse_beyond("speed", Dimension::Speed, FASTEST, FASTEST_WHY)?;
        let speed = node.number("speed", Dimension::Speed)?;
        if speed == 0.0 {
            return Err(node.error("speed", STANDING));
        }
        if let Some([before, first]) = table.last() {
            if place <= *before {
                let problem = format!("found {place:?} {unit} behind {before:?} {unit}; expected ascending {key}");
                return Err(node.error(key, problem));
            }
            if speed * first < 0.0 {
                let problem = format!("found {speed:?} m/s behind {first:?} m/s; expected one sign: an imposed speed does not pass 0");
                return Err(node.error("speed", problem));
            }
        }
        table.push([place, speed]);
        node.finish()?;
    }
    Ok(SpeedProfile::new(over, table))
}

impl VehicleSpec {
    /// The table that the imposed speed follows, if there is one.
    pub fn speed_profile(&self) -> Option<&SpeedProfile> {
        if let Course::Profile(profile) = &self.course { Some(profile) } else { None }
    }

    /// How the imposed speed follows an input, if it does.
    pub fn speed_input(&self) -> Option<&SpeedInput> {
        if let Course::Input(input) = &self.course { Some(input) } else { None }
    }

    /// Is the speed imposed, and constant?
    pub fn keeps_speed(&self) -> bool {
        self.speed_imposed && self.course == Course::Constant
    }

    /// What an imposed speed that changes follows, for the plan.
    pub fn speed_in_words(&self) -> String {
        if let Some(SpeedInput { time_constant, largest_acceleration, .. }) = self.speed_input() {
            let begin = self.speed;
            return format!(
                "vehicle.speed is an input: begins with {begin} m/s, followed with a time constant of {time_constant} s and up to {largest_acceleration} m/s2"
            );
        }
        let Some((profile, [[from, first], .., [to, last]])) = self.speed_profile().map(|profile| (profile, profile.nodes())) else {
            return format!("vehicle.speed = {} m/s", self.speed);
        };
        let (over, unit) = if profile.over == Over::Time { ("time", "s") } else { ("distance", "m") };
        let steepest = profile.steepest();
        format!("vehicle.speed over {over}: {first} m/s at {from} {unit} to {last} m/s at {to} {unit}, up to {steepest:.3} m/s2")
    }

    /// The same vehicle with a constant imposed speed.
    pub fn steady(mut self) -> Self {
        self.course = Course::Constant;
        self
    }

    /// The wheelset by whose distance imposed speeds go.
    pub(super) fn leader(&self) -> usize {
        self.wheelsets.iter().position(|wheelset| wheelset.driven).unwrap_or(0)
    }

    /// Where its table a run begins that starts at a time [s]: s or m.
    fn begins(&self, profile: &SpeedProfile, start: f64) -> f64 {
        match profile.over {
            Over::Time => start,
            Over::Distance => {
                let own = if self.is_lone() { 0.0 } else { self.wheelsets[self.leader()].x };
                self.initial.values[0] + own
            }
        }
    }

    /// The speed [m/s] with which a run from `start` [s] begins, where it comes from a table.
    pub fn speed_at(&self, start: f64) -> Option<f64> {
        self.speed_profile().map(|profile| profile.at(self.begins(profile, start))[0])
    }

    /// The same for a run.
    ///
    /// # Errors
    /// [`EquilibriumError::Accelerates`] where it begins from equilibrium within a ramp.
    pub fn starts_with(&self, start: f64) -> Result<Option<f64>, EquilibriumError> {
        let Some(profile) = self.speed_profile() else { return Ok(None) };
        let place = self.begins(profile, start);
        let [speed, slope] = profile.at(place);
        if slope != 0.0 && self.initial.from_equilibrium {
            let place = if profile.over == Over::Time { format!("t = {place} s") } else { format!("{place} m") };
            return Err(EquilibriumError::Accelerates { place });
        }
        Ok(Some(speed))
    }
}
