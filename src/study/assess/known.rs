//! What is known of vehicle and track beside the signals: from the scene.

use super::guiding_angle::{GuidingAngle, guiding_angle};
use super::quantity::VehicleKind;
use super::sections::Track;
use crate::contact::friction::FrictionMap;
use crate::geometry::Side;
use crate::geometry::profile::Profile;
use crate::scene::spec::Scene;
use crate::scene::vehicle::graph::Graph;
use crate::scene::vehicle::wheelset::Initial;
use crate::scene::vehicle::{PlacedBody, Sensor};
use crate::sim::statics::statics;
use crate::sim::{Simulation, SimulationError};
use std::sync::Arc;

/// A wheelset.
#[derive(Clone, Debug)]
pub struct Axle {
    pub name: String,
    /// P0, the static load on straight, level, undisturbed track, N.
    pub load: f64,
    /// What guides it, left and right.
    pub flange: [GuidingAngle; 2],
}

/// A sensor on a car body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySensor {
    pub name: String,
    /// Does that body rest on wheelsets directly?
    pub single_level: bool,
}

/// A sensor on a bogie frame.
#[derive(Clone, Debug)]
pub struct FrameSensor {
    pub name: String,
    /// Of its truck, wheelsets with it, kg.
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

/// What a scene says.
#[derive(Clone, Debug)]
pub struct Vehicle {
    /// Name of the heaviest body that is no wheelset.
    pub car: Option<String>,
    pub axles: Vec<Axle>,
    /// Friction on the rails.
    pub friction: Friction,
    /// Sensors on car bodies ([`Graph::is_car`]).
    pub body_sensors: Vec<BodySensor>,
    pub frame_sensors: Vec<FrameSensor>,
    pub track: Track,
}

impl Vehicle {
    /// Of a scene.
    ///
    /// # Errors
    /// When it has no start on straight, level, undisturbed track.
    pub fn of(scene: &Scene) -> Result<Vehicle, SimulationError> {
        let plain = level(scene);
        let loads = statics(&plain, &mut Simulation::new(&plain, 0.0)?)?.wheels;
        let vehicle = &scene.vehicle;
        let mut angles = Angles { inclination: scene.track.inclination, known: Vec::new() };
        let axles = vehicle.wheelsets.iter().zip(loads).map(|(wheelset, load)| Axle {
            name: wheelset.spec.name.clone(),
            load: load.left + load.right,
            flange: [0, 1].map(|side| angles.of(&wheelset.spec.profiles[side].profile, &scene.track.rails[side].profile)),
        });
        let axles = axles.collect();
        let (wheelsets, graph) = (vehicle.wheelsets.len(), Graph::of(vehicle));
        let heaviest = vehicle.bodies.iter().map(|body| body.body.mass).fold(0.0, f64::max);
        let heavier = |body: &&PlacedBody| body.body.mass >= heaviest;
        let car = vehicle.bodies.iter().find(heavier).map(|body| body.body.name.clone());
        let on_cars = vehicle.sensors.iter().filter(|sensor| graph.is_car(sensor.body));
        let body_sensor = |sensor: &Sensor| BodySensor { name: sensor.name.clone(), single_level: graph.stands_on_wheelsets(sensor.body) };
        let body_sensors = on_cars.map(body_sensor).collect();
        let frames = vehicle.sensors.iter().filter(|sensor| sensor.body >= wheelsets);
        let frame_sensors =
            frames.filter_map(|sensor| Some(FrameSensor { name: sensor.name.clone(), mass: graph.truck_of_frame(sensor.body)? })).collect();
        let track =
            Track { line: scene.track.line.clone(), base: 2.0 * scene.track.half_rail_distance, gravity: vehicle.gravity.max(1e-3) };
        let friction = Friction { coefficient: scene.contact.friction, map: scene.contact.friction_map.clone() };
        Ok(Vehicle { car, axles, friction, body_sensors, frame_sensors, track })
    }
}

/// Guiding angles of wheel and rail profiles, each found once.
struct Angles {
    inclination: f64,
    known: Vec<([Arc<dyn Profile>; 2], GuidingAngle)>,
}

impl Angles {
    fn of(&mut self, wheel: &Arc<dyn Profile>, rail: &Arc<dyn Profile>) -> GuidingAngle {
        let same = |known: &&([Arc<dyn Profile>; 2], GuidingAngle)| Arc::ptr_eq(&known.0[0], wheel) && Arc::ptr_eq(&known.0[1], rail);
        if let Some((_, angle)) = self.known.iter().find(same) {
            return *angle;
        }
        let angle = guiding_angle(wheel.as_ref(), rail.as_ref(), self.inclination);
        self.known.push(([wheel.clone(), rail.clone()], angle));
        angle
    }
}

/// The scene on straight, level, undisturbed track, from its steady state.
fn level(scene: &Scene) -> Scene {
    let mut level = scene.clone();
    level.track.deviations.clear();
    (level.track.line, level.track.grade) = (None, 0.0);
    // Sleepers are not felt by what stands, nor is the air.
    level.track.flexibility = None;
    level.vehicle.forces.retain(|element| !element.0.resists());
    level.vehicle = level.vehicle.steady();
    level.vehicle.initial = Initial::default();
    level.vehicle.wheelsets.iter_mut().for_each(|wheelset| wheelset.offset = [0.0; 2]);
    level
}

/// Coulomb's coefficient, and what changes it along and across the rails.
#[derive(Clone, Debug)]
pub struct Friction {
    pub coefficient: f64,
    pub map: Option<FrictionMap>,
}

impl Friction {
    /// The largest on a rail, on its top or its gauge face, from one distance [m] to another.
    pub fn largest(&self, side: Side, [from, to]: [f64; 2]) -> f64 {
        let Some(map) = &self.map else { return self.coefficient };
        let changes = map.waves(side).flat_map(|stretch| [stretch.from, stretch.to].map(|place| place.clamp(from, to)));
        let slopes = [0.0, 1e3];
        let factors = changes.chain([from, to]).flat_map(|place| slopes.map(|slope| map.at(side, place, slope).value));
        self.coefficient * factors.fold(0.0, f64::max)
    }
}
