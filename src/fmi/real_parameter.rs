//! A real parameter of a scene.

use crate::scene::spec::Scene;
use crate::scene::vehicle::{PlacedBody, PlacedWheelset, Sensor};
use crate::settings::Constant;

/// A real parameter as a field of the scene.
#[derive(Clone, Copy)]
pub enum RealParameter {
    OfScene(&'static Constant<Scene>),
    /// By place in the vehicle.
    OfWheelset(usize, &'static Constant<PlacedWheelset>),
    OfBody(usize, &'static Constant<PlacedBody>),
    OfSensor(usize, &'static Constant<Sensor>),
    /// And by its number among the element's.
    OfForce(usize, u32),
}

impl RealParameter {
    pub fn value(&self, scene: &Scene) -> f64 {
        let vehicle = &scene.vehicle;
        let found = match *self {
            RealParameter::OfScene(line) => (line.get)(scene),
            RealParameter::OfWheelset(place, line) => (line.get)(&vehicle.wheelsets[place]),
            RealParameter::OfBody(place, line) => (line.get)(&vehicle.bodies[place]),
            RealParameter::OfSensor(place, line) => (line.get)(&vehicle.sensors[place]),
            RealParameter::OfForce(place, number) => {
                let all = vehicle.forces[place].0.constants();
                all.iter().find(|constant| constant.number == number).map(|constant| constant.value)
            }
        };
        found.unwrap_or(0.0)
    }

    pub fn assign(&self, scene: &mut Scene, value: f64) {
        let vehicle = &mut scene.vehicle;
        match *self {
            RealParameter::OfScene(line) => (line.set)(scene, value),
            RealParameter::OfWheelset(place, line) => (line.set)(&mut vehicle.wheelsets[place], value),
            RealParameter::OfBody(place, line) => (line.set)(&mut vehicle.bodies[place], value),
            RealParameter::OfSensor(place, line) => (line.set)(&mut vehicle.sensors[place], value),
            RealParameter::OfForce(place, number) => vehicle.forces[place].0.set_constant(number, value),
        }
    }
}
