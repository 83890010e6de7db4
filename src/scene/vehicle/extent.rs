//! How much of the vehicle that a scene describes is computed: `vehicle.detail`.

use super::{Element, VehicleSpec};
use crate::mbs::force::CarriedPull;
use crate::mbs::supported::SupportedMass;
use crate::settings::SettingsError;

/// Levels of detail, from the least on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    Wheelset,
    Truck,
    Vehicle,
    Train,
}

impl Level {
    /// Every level and its word.
    pub const ALL: [(Level, &str); 4] =
        [(Level::Wheelset, "wheelset"), (Level::Truck, "truck"), (Level::Vehicle, "vehicle"), (Level::Train, "train")];

    /// As `vehicle.detail` says it.
    pub fn word(self) -> &'static str {
        Level::ALL[self as usize].1
    }
}

/// How much of what the scene describes a vehicle is.
#[derive(Clone, Debug)]
pub enum Extent {
    /// All of it.
    Whole,
    /// All of it, until its steady running is known; then it will be cut.
    Asked(Box<Asked>),
    /// A part.
    Cut(Box<Away>),
}

/// What will be left of a vehicle.
#[derive(Clone, Debug)]
pub struct Asked {
    pub level: Level,
    /// Does a body of the whole stay?
    pub kept: Vec<bool>,
    pub elements: Vec<KeptElement>,
    pub masses: Vec<PointMass>,
    /// The place of the key in the scene, for messages.
    pub key: SettingsError,
}

/// An element that stays, between bodies of numbers of its own.
#[derive(Clone, Debug)]
pub struct KeptElement {
    pub element: Element,
    /// Bodies of the whole by these numbers; empty where all are kept: then the numbers are those of the cut vehicle.
    pub bodies: Vec<usize>,
}

/// A vehicle that is a point mass.
#[derive(Clone, Debug)]
pub struct PointMass {
    /// Its heaviest body, which stands for it.
    pub body: usize,
    /// Is a body of the whole one of its own?
    pub own: Vec<bool>,
}

/// What was cut away, and what takes its place.
#[derive(Clone, Debug)]
pub struct Away {
    pub level: Level,
    /// Names of the wheelsets and other bodies that are not there.
    pub bodies: Vec<String>,
    /// Those of them that stay as guides, because something kept is held by them.
    pub guides: Vec<String>,
    /// Elements and sensors that went with them, inputs of elements among them.
    pub lost: Vec<String>,
    /// Elements that went with them and would drive, brake or resist: by a value in the scene of one of their inputs, or by what holds on to the world.
    pub acting: Vec<String>,
    /// Elements that went with them and resist without being told: they do in the steady running that guides keep.
    pub kept_constant: Vec<String>,
    /// Part of their weight that the wheels carry in steady running, N.
    pub weight: f64,
    /// The mass of that, kg, which goes along the track with the heaviest kept body where the speed is free.
    pub carried: f64,
    /// Masses that go along the track with bodies, beside their own: what is carried, and what turns in point masses.
    pub along: Vec<SupportedMass>,
    /// What that mass takes of the whole vehicle's acceleration, where that rolls freely, and what joints across the cut pull with.
    pub pulls: Vec<CarriedPull>,
    /// Point masses: name, mass, and what its wheels add by turning, kg.
    pub masses: Vec<(String, f64, f64)>,
}

impl Away {
    /// In a sentence, for the plan.
    pub fn describe(&self, vehicle: &VehicleSpec) -> String {
        let held = match self.guides.len() {
            0 => String::new(),
            _ => format!(
                "; held in the place of steady running, beside what it holds: {}, with {:.3} kN on the wheels",
                list(&self.guides),
                1e-3 * self.weight
            ),
        };
        let along = match vehicle.keeps_speed() {
            true => String::new(),
            false if self.carried == 0.0 => String::new(),
            false => format!("; {:.0} kg of it go along the track", self.carried),
        };
        let mass =
            |(name, mass, turning): &(String, f64, f64)| format!("{name} {mass:.0} kg (and {turning:.0} kg of what turns with the wheels)");
        let masses: Vec<String> = self.masses.iter().map(mass).collect();
        let masses = if masses.is_empty() { String::new() } else { format!("; point masses along the track: {}", list(&masses)) };
        let lost = if self.lost.is_empty() { String::new() } else { format!("; gone with them: {}", list(&self.lost)) };
        format!("{}: without {}{held}{along}{masses}{lost}", self.key(), list(&self.bodies))
    }

    /// What of the forces along the track is missed, in a sentence; `None` where nothing is.
    pub fn missed(&self) -> Option<String> {
        let acting = (!self.acting.is_empty()).then(|| {
            format!(
                "{} went with what is cut away: they drive, brake or resist no more, and the rest of the vehicle does so alone. kind = \"external_load\" on a body that stays can take their place",
                list(&self.acting)
            )
        });
        let constant = (!self.kept_constant.is_empty()).then(|| {
            format!(
                "of {} stays what the kept wheels carry of it in steady running at the start's speed, as a constant force along the track, whatever the speed is later (it does not turn round)",
                list(&self.kept_constant)
            )
        });
        let said = acting.into_iter().chain(constant).reduce(|all, more| format!("{all}; {more}"))?;
        Some(format!("{}: {said}", self.key()))
    }

    /// The key that asks for it.
    fn key(&self) -> String {
        if self.masses.is_empty() { format!("vehicle.detail = \"{}\"", self.level.word()) } else { "vehicle.point_masses".into() }
    }
}

/// The first few names.
fn list(names: &[String]) -> String {
    const NAMED: usize = 4;
    let more = names.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", names.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", "))
}
