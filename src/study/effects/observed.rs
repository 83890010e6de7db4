//! What is looked at in a run, on a dense grid of times.

use crate::formulation::Model;
use crate::scene::spec::Scene;
use crate::scene::vehicle::Sensor;
use crate::sim::outputs::Output;
use crate::sim::recording::Recording;
use crate::sim::vehicle_outputs::scene_outputs;
use nalgebra::Vector3;
use serde::Serialize;

/// What an effect may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Lateral displacement of wheelsets, m.
    Displacement,
    /// Yaw of wheelsets, rad.
    Yaw,
    /// Q, N.
    WheelLoad,
    /// Y, N.
    GuidingForce,
    /// Y/Q.
    Quotient,
    /// Sum of Y of a wheelset, N.
    TrackShifting,
    /// Of the centre of the heaviest bodies, across and up, m/s2.
    Acceleration,
    /// T gamma, N.
    Wear,
}

impl Quantity {
    pub const ALL: [Quantity; 8] = [
        Quantity::Displacement,
        Quantity::Yaw,
        Quantity::WheelLoad,
        Quantity::GuidingForce,
        Quantity::Quotient,
        Quantity::TrackShifting,
        Quantity::Acceleration,
        Quantity::Wear,
    ];

    /// Symbol, and in words.
    pub fn words(self) -> (&'static str, &'static str) {
        [
            ("y", "lateral displacement"),
            ("yaw", "yaw"),
            ("Q", "wheel load Q"),
            ("Y", "guiding force Y"),
            ("Y/Q", "Y/Q"),
            ("sum Y", "track shifting force"),
            ("a", "acceleration of bodies"),
            ("Tg", "T gamma"),
        ][self as usize]
    }

    /// Unit in which people say it, and its size in SI.
    pub fn unit(self) -> (&'static str, f64) {
        [("mm", 1e-3), ("mrad", 1e-3), ("kN", 1e3), ("kN", 1e3), ("", 1.0), ("kN", 1e3), ("m/s2", 1.0), ("N", 1.0)][self as usize]
    }

    /// SI unit.
    pub fn si(self) -> &'static str {
        ["m", "rad", "N", "N", "", "N", "m/s2", "N"][self as usize]
    }

    /// A change below this is rounding: 1 nm, 1 nrad, 1 mN, 1e-8, 1 um/s2, 1 mN.
    pub fn rounding(self) -> f64 {
        [1e-9, 1e-9, 1e-3, 1e-3, 1e-8, 1e-3, 1e-6, 1e-3][self as usize]
    }

    /// Does it jump where rigid contacts change their place?
    pub fn jumps(self) -> bool {
        !matches!(self, Quantity::Displacement | Quantity::Yaw)
    }
}

/// Ending of the names of points that are watched.
const WATCHED: &str = ".watched centre";
/// A body with this share of the heaviest one's mass is a car body.
const HEAVY: f64 = 0.5;

/// The scene with points at the centres of its heaviest bodies, and with the groups of outputs that are looked at.
pub(super) fn watched(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let wheelsets = scene.vehicle.wheelsets.len();
    let heaviest = scene.vehicle.bodies.iter().map(|placed| placed.body.mass).fold(0.0, f64::max);
    let heavy = scene.vehicle.bodies.iter().enumerate().filter(|(_, placed)| placed.body.mass > HEAVY * heaviest);
    let sensors: Vec<Sensor> = heavy
        .map(|(index, placed)| Sensor {
            name: format!("{}{WATCHED}", placed.body.name),
            body: wheelsets + index,
            point: Vector3::zeros(),
            measured: false,
        })
        .collect();
    scene.vehicle.sensors = sensors;
    scene.interface.only = None;
    // Sliding means are states: they stay.
    for group in ["motion", "wheels", "axles", "sensors"] {
        if !scene.interface.outputs.contains(&group) {
            scene.interface.outputs.push(group);
        }
    }
    scene
}

/// The quantity that an output of some name shows.
fn quantity(model: &Model, name: &str) -> Option<Quantity> {
    if let Some((_, axis)) = name.split_once(WATCHED) {
        return matches!(axis, ".ay" | ".az").then_some(Quantity::Acceleration);
    }
    let own = model.wheelsets.iter().find_map(|wheelset| name.strip_prefix(wheelset.name.as_str())?.strip_prefix('.'))?;
    Some(match own {
        "y" => Quantity::Displacement,
        "yaw" => Quantity::Yaw,
        "left.verticalForce" | "right.verticalForce" => Quantity::WheelLoad,
        "left.lateralForce" | "right.lateralForce" => Quantity::GuidingForce,
        "left.derailmentQuotient" | "right.derailmentQuotient" => Quantity::Quotient,
        "trackShiftingForce" => Quantity::TrackShifting,
        "left.wearNumber" | "right.wearNumber" => Quantity::Wear,
        _ => return None,
    })
}

/// The outputs that are looked at.
pub(super) fn outputs(scene: &Scene, model: &Model) -> Vec<Output> {
    scene_outputs(scene, model).into_iter().filter(|output| quantity(model, &output.name).is_some()).collect()
}

/// A run on its times, SI.
#[derive(Clone, Debug, Default)]
pub(super) struct Observed {
    pub time: Vec<f64>,
    /// Per quantity, in their order, one series for each wheelset, wheel or body.
    pub series: [Vec<Vec<f64>>; Quantity::ALL.len()],
    /// Their names: a changed scene may have fewer wheelsets.
    pub names: [Vec<String>; Quantity::ALL.len()],
    /// Do forces jump with the state?
    pub rigid: bool,
}

impl Observed {
    pub fn new(recording: &Recording, model: &Model) -> Observed {
        let mut observed =
            Observed { time: recording.column("time").unwrap_or_default(), rigid: model.formulation.constrains(), ..Observed::default() };
        for (index, (name, _)) in recording.columns.iter().enumerate() {
            if let Some(quantity) = quantity(model, name) {
                observed.names[quantity as usize].push(name.clone());
                observed.series[quantity as usize].push(recording.rows.iter().map(|row| row[index]).collect());
            }
        }
        observed
    }

    /// Largest size of a quantity; `None` where there is none.
    pub fn largest(&self, quantity: Quantity) -> Option<f64> {
        self.series[quantity as usize].iter().flatten().map(|value| value.abs()).reduce(f64::max)
    }

    /// Lateral displacement of the leading wheelset.
    pub fn leading(&self) -> &[f64] {
        self.series[0].first().map_or(&[], Vec::as_slice)
    }
}
