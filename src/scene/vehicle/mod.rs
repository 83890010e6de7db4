//! `[vehicle]`: what moves on the track.
//!
//! Every vehicle consists of bodies, wheelsets, joints, forces and sensors by name. Groups of them that occur several times stand in
//! `[vehicle.module.NAME]` and are put into place by `[[vehicle.place]]`; modules may place modules (a train places vehicles, a vehicle
//! trucks). A template is such a table that the program carries ([`templates`]); what the scene says about an entry of the same name replaces
//! single keys of it. A module may lie over a template too (`template = "..."` in it): that is a vehicle of a train. A vehicle of one
//! wheelset may write `[vehicle.wheelset]` and, for its springs to a frame that travels with it, `[vehicle.suspension]`.
//!
//! *Design frame:* x forward, y left, z up, origin at rail height at the vehicle's middle (any point will do); every position in
//! the scene is one in it, in the design configuration, in which all bodies' axes are parallel to it. A module has its own
//! design frame at the `position` where it is placed.
//!
//! *Names:* what stands in a module placed as `truck[1]` is called `truck[1].frame`. An entry with `mirrored = true` stands for
//! two, `.left` as written and `.right` with y turned to -y. A name that an entry refers to is looked for in its own module
//! first (for one of a mirrored pair with the side's ending first), then in what surrounds it.
//!
//! *Order:* the order in the file has no meaning. Wheelsets are ordered from the front to the rear (equal places: by name),
//! other bodies, joints, forces and sensors by name, numbers in names by value; bodies come after wheelsets.

pub mod assemble;
mod bearings;
mod design;
mod expand;
pub mod extent;
pub mod graph;
mod joints;
mod kept;
pub mod outline;
mod places;
mod read;
pub mod stability;
mod static_preload;
pub mod templates;
#[cfg(test)]
mod tests;
mod travel;
pub mod wheelset;

use crate::geometry::file::SceneFile;
use crate::geometry::profile::ProfileChoice;
use crate::mbs::body::Body;
use crate::mbs::driving::Course;
use crate::mbs::force::ForceElement;
use crate::mbs::joint::Joint;
use crate::settings::{Section, SettingsError, choose};
use extent::{Away, Extent, Level};
use nalgebra::Vector3;
pub use travel::FASTEST;
pub use wheelset::LARGEST_ANGLE;
use wheelset::{Initial, WheelsetSpec};

/// `[vehicle]`.
#[derive(Clone, Debug)]
pub struct VehicleSpec {
    pub template: &'static str,
    /// V, m/s; negative rolls backward. That of the start where it changes.
    pub speed: f64,
    /// Is the speed imposed? Otherwise it is that at the start.
    pub speed_imposed: bool,
    /// How the imposed speed goes on.
    pub course: Course,
    /// g, m/s2.
    pub gravity: f64,
    pub initial: Initial,
    /// Leading first; they are the first bodies of the model. Never empty.
    pub wheelsets: Vec<PlacedWheelset>,
    pub bodies: Vec<PlacedBody>,
    pub joints: Vec<Joint>,
    pub forces: Vec<Element>,
    pub sensors: Vec<Sensor>,
    /// How much of what the scene describes it is.
    pub extent: Extent,
    /// Its level of detail, and the next one, which leaves something out.
    pub coarser: Option<[Level; 2]>,
    /// The heaviest body of each vehicle of a train but that of the leading wheelset, where all are detailed.
    pub followers: Vec<String>,
    /// Names of the elements that couple its vehicles, where it is a train.
    pub couplings: Vec<String>,
}

/// A wheelset in its vehicle.
#[derive(Clone, Debug)]
pub struct PlacedWheelset {
    pub spec: WheelsetSpec,
    /// Of its centre in the design frame, m.
    pub x: f64,
    /// Does the imposed speed act on it?
    pub driven: bool,
    /// Added to the equilibrium at the start: y [m], yaw [rad].
    pub offset: [f64; 2],
}

/// A body that is no wheelset.
#[derive(Clone, Debug)]
pub struct PlacedBody {
    pub body: Body,
    /// Of the centre of mass in the design frame, m.
    pub position: Vector3<f64>,
}

/// A force element as a scene names it.
#[derive(Debug)]
pub struct Element(pub Box<dyn ForceElement>);

impl Clone for Element {
    fn clone(&self) -> Self {
        Element(self.0.clone_box())
    }
}

/// A point on a body whose motion is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    pub name: String,
    pub body: usize,
    /// In the body's axes, from its centre of mass, m.
    pub point: Vector3<f64>,
    /// Is shown what an accelerometer there measures, too?
    pub measured: bool,
}

impl PlacedWheelset {
    /// Centre in the design configuration, m: as high as the mean radius of both wheels at the tread circle.
    pub fn design_position(&self) -> Vector3<f64> {
        let [left, right] = self.spec.profiles.each_ref().map(|choice| choice.profile.at(0.0).value);
        Vector3::new(self.x, 0.0, 0.5 * (left + right))
    }
}

/// Ending of the name of a wheelset's own springs.
pub(crate) const SUSPENSION: &str = ".suspension";

impl VehicleSpec {
    /// The leading wheelset, which summaries, diagrams and contact geometry show.
    pub fn leading(&self) -> &WheelsetSpec {
        &self.wheelsets[0].spec
    }

    /// Is it one wheelset and nothing else?
    pub fn is_lone(&self) -> bool {
        self.body_count() == 1 && self.away().is_none()
    }

    /// What `vehicle.detail` has cut away.
    pub fn away(&self) -> Option<&Away> {
        if let Extent::Cut(away) = &self.extent { Some(away) } else { None }
    }

    /// The wheelset whose own springs an element is (`[vehicle.suspension]`).
    pub fn suspended_by(&self, element: &str) -> Option<usize> {
        let own = element.strip_suffix(SUSPENSION)?;
        self.wheelsets.iter().position(|wheelset| wheelset.spec.name == own)
    }

    /// Number of bodies of the model: the wheelsets come first.
    pub fn body_count(&self) -> usize {
        self.wheelsets.len() + self.bodies.len()
    }

    /// Weight of the whole vehicle and its constant loads, and of what rests on it and is cut away, N.
    pub fn weight(&self) -> f64 {
        let wheelsets: f64 = self.wheelsets.iter().map(|w| w.spec.mass * self.gravity + w.spec.vertical_load).sum();
        let carried = self.away().map_or(0.0, |away| away.weight);
        wheelsets + self.bodies.iter().map(|body| body.body.mass * self.gravity).sum::<f64>() + carried
    }

    /// Centre of a body in the design configuration, design frame, m.
    pub fn design_position(&self, body: usize) -> Vector3<f64> {
        match body.checked_sub(self.wheelsets.len()) {
            Some(other) => self.bodies[other].position,
            None => self.wheelsets[body].design_position(),
        }
    }

    /// All profiles of wheels, left and right, wheelset by wheelset.
    pub fn wheel_profiles(&self) -> Vec<&[ProfileChoice; 2]> {
        self.wheelsets.iter().map(|wheelset| &wheelset.spec.profiles).collect()
    }

    /// Name of each wheelset, and whether its speed is imposed.
    pub fn axles(&self) -> Vec<(&str, bool)> {
        self.wheelsets.iter().map(|w| (w.spec.name.as_str(), self.speed_imposed && w.driven)).collect()
    }

    /// Names of all parts that have variables.
    pub fn part_names(&self) -> Vec<&str> {
        let wheelsets = self.wheelsets.iter().map(|w| w.spec.name.as_str());
        let bodies = self.bodies.iter().map(|b| b.body.name.as_str());
        let forces = self.forces.iter().map(|force| force.0.name());
        wheelsets.chain(bodies).chain(self.sensors.iter().map(|sensor| sensor.name.as_str())).chain(forces).collect()
    }

    /// Files that profiles of wheels refer to, each once.
    pub fn files(&self) -> Vec<&SceneFile> {
        let mut files: Vec<&SceneFile> = Vec::new();
        for file in self.wheel_profiles().into_iter().flatten().filter_map(|choice| choice.file.as_ref()) {
            if files.iter().all(|other| other.key != file.key) {
                files.push(file);
            }
        }
        files
    }
}

/// Reads `[vehicle]`.
///
/// # Errors
/// [`SettingsError`] with file (the scene's or the template's) and line.
pub(super) fn read(section: Section) -> Result<VehicleSpec, SettingsError> {
    let template = choose(templates::REGISTRY, &section, "template")?;
    let mut vehicle = templates::read(section, template.name)?;
    vehicle.speed = vehicle.speed_at(0.0).unwrap_or(vehicle.speed);
    Ok(vehicle)
}
