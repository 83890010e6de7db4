//! A real parameter of a scene.

use crate::scene::spec::Scene;
use crate::scene::vehicle::{PlacedBody, PlacedWheelset, Sensor};
use crate::settings::Constant;

/// A real parameter as a field of the scene.
#[derive(Clone, Copy)]
pub enum RealParameter {
    Scene(&'static Constant<Scene>),
    /// By place in the vehicle.
    Wheelset(usize, &'static Constant<PlacedWheelset>),
    Body(usize, &'static Constant<PlacedBody>),
    Sensor(usize, &'static Constant<Sensor>),
    /// And by its number among the element's.
    Force(usize, u32),
}

impl RealParameter {
    /// Is it a number of a force element?
    pub fn is_of_force(&self) -> bool {
        matches!(self, RealParameter::Force(..))
    }

    pub fn value(&self, scene: &Scene) -> f64 {
        let vehicle = &scene.vehicle;
        let found = match *self {
            RealParameter::Scene(line) => (line.get)(scene),
            RealParameter::Wheelset(place, line) => (line.get)(&vehicle.wheelsets[place]),
            RealParameter::Body(place, line) => (line.get)(&vehicle.bodies[place]),
            RealParameter::Sensor(place, line) => (line.get)(&vehicle.sensors[place]),
            RealParameter::Force(place, number) => {
                let all = vehicle.forces[place].0.constants();
                all.iter().find(|constant| constant.number == number).map(|constant| constant.value)
            }
        };
        found.unwrap_or(0.0)
    }

    pub fn assign(&self, scene: &mut Scene, value: f64) {
        let vehicle = &mut scene.vehicle;
        match *self {
            RealParameter::Scene(line) => (line.set)(scene, value),
            RealParameter::Wheelset(place, line) => (line.set)(&mut vehicle.wheelsets[place], value),
            RealParameter::Body(place, line) => (line.set)(&mut vehicle.bodies[place], value),
            RealParameter::Sensor(place, line) => (line.set)(&mut vehicle.sensors[place], value),
            RealParameter::Force(place, number) => vehicle.forces[place].0.set_constant(number, value),
        }
    }
}
