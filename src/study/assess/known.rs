//! What is known of vehicle and track beside the signals: from the scene.

use super::quantity::VehicleKind;
use super::sections::Track;
use crate::geometry::Side;
use crate::geometry::profile::Profile;
use crate::scene::spec::Scene;
use crate::scene::vehicle::PlacedBody;
use crate::sim::statics::statics;
use crate::sim::{Simulation, SimulationError};

/// A wheelset.
#[derive(Clone, Debug)]
pub struct Axle {
    pub name: String,
    /// P0 at the start, N.
    pub load: f64,
    /// Largest angle of its flanks against the axle on the flange, left and right, rad.
    pub flange: [f64; 2],
    /// Largest friction coefficient on the side's rail, left and right.
    pub friction: [f64; 2],
}

/// A sensor on a bogie frame.
#[derive(Clone, Debug)]
pub struct FrameSensor {
    pub name: String,
    /// Of the frame alone, kg.
    pub mass: f64,
}

/// All of it.
#[derive(Clone, Debug, Default)]
pub struct Known {
    pub kind: VehicleKind,
    /// Admissible speed, m/s; `None`: the highest of the run.
    pub admissible_speed: Option<f64>,
    /// `None`: there is no scene.
    pub vehicle: Option<Vehicle>,
    /// Limits that take the place of the table's: key, SI value.
    pub limits: Vec<(String, f64)>,
}

/// Least part of the heaviest body's mass that a car body has.
const CAR: f64 = 0.5;

/// What a scene says.
#[derive(Clone, Debug)]
pub struct Vehicle {
    /// Name of the heaviest body that is no wheelset.
    pub car: Option<String>,
    pub axles: Vec<Axle>,
    /// Sensors on car bodies: the heaviest body, and others of at least half its mass.
    pub body_sensors: Vec<String>,
    pub frame_sensors: Vec<FrameSensor>,
    /// Does a car body rest on wheelsets directly?
    pub single_level: bool,
    pub track: Track,
}

impl Vehicle {
    /// Of a scene; its simulation is asked for the static loads.
    ///
    /// # Errors
    /// When the model can't be evaluated at its start.
    pub fn of(scene: &Scene, simulation: &mut Simulation) -> Result<Vehicle, SimulationError> {
        let loads = statics(scene, simulation)?.wheels;
        let vehicle = &scene.vehicle;
        let axles = vehicle.wheelsets.iter().zip(loads).map(|(wheelset, load)| Axle {
            name: wheelset.spec.name.clone(),
            load: load.left + load.right,
            flange: [0, 1].map(|side| flange_angle(wheelset.spec.profiles[side].profile.as_ref())),
            friction: Side::BOTH.map(|side| friction(scene, side)),
        });
        let axles = axles.collect();
        let wheelsets = vehicle.wheelsets.len();
        let mass = |body: usize| body.checked_sub(wheelsets).map_or(0.0, |other| vehicle.bodies[other].body.mass);
        let heaviest = (0..vehicle.body_count()).map(mass).fold(0.0, f64::max);
        let heavier = |body: &&PlacedBody| body.body.mass >= heaviest;
        let car = vehicle.bodies.iter().find(heavier).map(|body| body.body.name.clone());
        let is_car = |body: usize| heaviest > 0.0 && mass(body) >= CAR * heaviest;
        let joins = |ends: [Option<usize>; 2]| {
            let [a, b] = ends.map(|end| end.map(|body| (body < wheelsets, is_car(body))));
            matches!((a, b), (Some((true, _)), Some((_, true))) | (Some((_, true)), Some((true, _))))
        };
        let single_level = vehicle.forces.iter().any(|force| joins(force.0.bodies()));
        let (mut body_sensors, mut frame_sensors) = (Vec::new(), Vec::new());
        for sensor in vehicle.sensors.iter().filter(|sensor| sensor.body >= wheelsets) {
            if is_car(sensor.body) {
                body_sensors.push(sensor.name.clone());
            } else {
                frame_sensors.push(FrameSensor { name: sensor.name.clone(), mass: mass(sensor.body) });
            }
        }
        let track =
            Track { line: scene.track.line.clone(), base: 2.0 * scene.track.half_rail_distance, gravity: vehicle.gravity.max(1e-3) };
        Ok(Vehicle { car, axles, body_sensors, frame_sensors, single_level, track })
    }
}

/// Largest lean of a wheel profile on its flange's side, rad: the flank that faces the rail, not the flange's back.
pub fn flange_angle(profile: &dyn Profile) -> f64 {
    const LOOKS: usize = 20_000;
    let flank = profile.range().0.min(0.0);
    let slope = |k: usize| -profile.at(flank * k as f64 / LOOKS as f64).d1;
    let steepest = (0..=LOOKS).map(slope).filter(|slope| slope.is_finite()).fold(0.0, f64::max);
    steepest.atan()
}

/// The largest coefficient that the scene has on a rail: on its top or its gauge face, anywhere.
fn friction(scene: &Scene, side: Side) -> f64 {
    let Some(map) = &scene.contact.friction_map else { return scene.contact.friction };
    let places = map.waves(side).flat_map(|stretch| [stretch.from - 1.0, stretch.to + 1.0]).chain([-1e9, 1e9]);
    let slopes = [0.0, 1e3];
    let factors = places.flat_map(|s| slopes.map(|slope| map.at(side, s, slope).value));
    scene.contact.friction * factors.fold(0.0, f64::max)
}
