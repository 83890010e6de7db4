//! Outputs of a vehicle beyond those of its wheelsets' motion and wheels: axles (sums over both wheels), bodies, sensors, force elements.
//!
//! Numbers: axle 1000 k + 31 (k from 1, the leading wheelset first), body b 1000000 + 100 b, force f 2000000 + 100 f, sensor s
//! 3000000 + 100 s (from 0, in the order of names): they belong to the vehicle, whatever of it is shown. A wheelset's own springs
//! (`[vehicle.suspension]`) have its numbers, 1000 k + 300.

use super::Snapshot;
use super::adhesion::adhesion_outputs;
use super::energy::energy_outputs;
use super::feedthrough::{Depends, FRICTION_INPUTS, Feedthrough, Ties};
use super::outputs::{Needs, Output, on_track, outputs};
use crate::formulation::{Model, contact_index};
use crate::geometry::Side;
use crate::geometry::track::centre_line::CentreLine;
use crate::mbs::body::COORDINATES;
use crate::mbs::force::{Attachment, QuantityKind};
use crate::scene::spec::{ADHESION, Scene};
use crate::scene::vehicle::{Sensor, VehicleSpec};
use crate::units::Unit;
use nalgebra::Vector3;

/// First number of bodies, forces and sensors, and the distance from one to the next.
pub const BODY: u32 = 1_000_000;
pub const FORCE: u32 = 2_000_000;
pub const SENSOR: u32 = 3_000_000;
pub const STRIDE: u32 = 100;
/// First number of the inputs of forces.
pub const FORCE_INPUT: u32 = 4_000_000;
/// First number of the forces of a wheelset's own springs among its outputs.
const SUSPENSION_FORCES: u32 = 300;
/// Number of the sum of lateral forces among a wheelset's outputs.
const TRACK_SHIFTING_FORCE: u32 = 31;

/// Where the numbers of what the vehicle's force element of this number reports begin.
fn number_of_element(element: usize) -> u32 {
    FORCE + STRIDE * element as u32
}

/// All outputs that a scene shows.
pub fn scene_outputs(scene: &Scene, model: &Model) -> Vec<Output> {
    let groups = &scene.interface.outputs;
    let mut all = outputs(model, groups);
    if groups.contains(&ADHESION) {
        all.extend(adhesion_outputs(model));
    }
    let vehicle = &scene.vehicle;
    let mut parts = Collector { groups, model, ties: Ties::of(model), outputs: Vec::new() };
    parts.forces(vehicle, true);
    parts.axles();
    parts.bodies(vehicle);
    for (index, sensor) in vehicle.sensors.iter().enumerate() {
        parts.sensor(index, sensor, gravity(scene));
    }
    parts.forces(vehicle, false);
    all.extend(parts.outputs);
    all.extend(energy_outputs(scene, model, number_of_element));
    all.retain(|output| scene.interface.shows(&output.name));
    all
}

struct Collector<'a> {
    groups: &'a [&'static str],
    model: &'a Model,
    ties: Ties,
    outputs: Vec<Output>,
}

/// What an output shows, beside its value.
struct Label {
    reference: u32,
    name: String,
    group: &'static str,
    unit: Unit,
    feedthrough: Feedthrough,
}

impl Collector<'_> {
    /// The same; it needs positions, velocities and forces of elements alone.
    fn add_of_motion(&mut self, label: Label, text: &str, read: impl Fn(&Snapshot) -> f64 + Send + Sync + 'static) {
        let before = self.outputs.len();
        self.add(label, text, read);
        self.outputs[before..].iter_mut().for_each(|output| output.needs = Needs::Motion);
    }

    fn add(&mut self, label: Label, text: &str, read: impl Fn(&Snapshot) -> f64 + Send + Sync + 'static) {
        if self.groups.contains(&label.group) {
            let Label { reference, name, group, unit, feedthrough } = label;
            self.outputs.push(Output::new((reference, name), group, unit, text, feedthrough, Box::new(read)));
        }
    }

    fn axles(&mut self) {
        for (index, wheelset) in self.model.wheelsets.iter().enumerate() {
            let label = Label {
                reference: (index as u32 + 1) * 1000 + TRACK_SHIFTING_FORCE,
                name: format!("{}.trackShiftingForce", wheelset.name),
                group: "axles",
                unit: Unit::Newton,
                feedthrough: Feedthrough::of_wheelset(self.model, &self.ties, wheelset.body, Depends::Contact(FRICTION_INPUTS)),
            };
            let body = wheelset.body;
            let text = "sum of Y: lateral force of both wheels on the track, left positive";
            self.add(label, text, move |s| {
                -Side::BOTH.map(|side| s.workspace.wheel_force(contact_index(index, side), body).y).iter().sum::<f64>()
            });
        }
    }

    fn bodies(&mut self, vehicle: &VehicleSpec) {
        let lines: [(u32, &str, Unit, usize, &str); 6] = [
            (0, "distance", Unit::Distance, 0, "distance of the centre of mass along the track"),
            (1, "y", Unit::Metre, 1, "lateral displacement of the centre of mass, left positive"),
            (2, "z", Unit::Distance, 2, "height of the centre of mass over the nominal contact height"),
            (3, "roll", Unit::Radian, 4, "roll angle, left side up positive"),
            (4, "pitch", Unit::Radian, 5, "pitch angle, nose down positive"),
            (5, "yaw", Unit::Radian, 3, "yaw angle, nose left positive"),
        ];
        for (index, placed) in vehicle.bodies.iter().enumerate() {
            let q = COORDINATES * (vehicle.wheelsets.len() + index);
            for (id, name, unit, coordinate, text) in lines {
                let reference = BODY + STRIDE * index as u32 + id;
                let label = Label {
                    reference,
                    name: format!("{}.{name}", placed.body.name),
                    group: "bodies",
                    unit,
                    feedthrough: Feedthrough::none(),
                };
                let body = vehicle.wheelsets.len() + index;
                self.add_of_motion(label, text, move |s| {
                    on_track(s, body).map_or(s.y[q + coordinate], |(motion, _)| motion.coordinates[coordinate])
                });
            }
        }
    }

    fn sensor(&mut self, index: usize, sensor: &Sensor, gravity: Vector3<f64>) {
        let base = SENSOR + STRIDE * index as u32;
        let feedthrough = Feedthrough::of_acceleration(self.model, &self.ties, sensor.body);
        let rolls = |body: &usize| *body < self.model.wheelsets.len();
        let apart = !self.model.formulation.constrains() && !self.ties.group(sensor.body).iter().any(rolls);
        let (body, point) = (sensor.body, sensor.point);
        let line = self.model.track.rail(Side::Left).shared_line();
        for (id, name, unit, axis, text) in [
            (0, "distance", Unit::Distance, 0, "distance of the point along the track"),
            (1, "y", Unit::Metre, 1, "lateral position of the point, left positive"),
            (2, "z", Unit::Distance, 2, "height of the point over the nominal contact height"),
        ] {
            let name = format!("{}.{name}", sensor.name);
            let label = Label { reference: base + id, name, group: "sensors", unit, feedthrough: Feedthrough::none() };
            let line = line.clone();
            self.add_of_motion(label, text, move |s| place_of(s, body, &point, line.as_deref())[axis]);
        }
        let measured = [
            (
                6,
                "measuredAx",
                0,
                "what an accelerometer at the point shows along the body's x axis, forward positive: acceleration less gravity",
            ),
            (
                7,
                "measuredAy",
                1,
                "what an accelerometer at the point shows along the body's y axis, left positive: acceleration less gravity",
            ),
            (
                8,
                "measuredAz",
                2,
                "what an accelerometer at the point shows along the body's z axis, up positive: acceleration less gravity (g at rest)",
            ),
        ];
        let kinematic = [
            (3, "ax", 0, "acceleration of the point along the body's x axis, forward positive (kinematic, without gravity's part)"),
            (4, "ay", 1, "acceleration of the point along the body's y axis, left positive (kinematic, without gravity's part)"),
            (5, "az", 2, "acceleration of the point along the body's z axis, up positive (kinematic, without gravity's part)"),
        ];
        let with = |gravity| move |line: (u32, &'static str, usize, &'static str)| (line, gravity);
        let shown = kinematic.into_iter().map(with(Vector3::zeros()));
        let asked = sensor.measured.then_some(measured.into_iter().map(with(gravity)));
        for ((id, name, axis, text), gravity) in shown.chain(asked.into_iter().flatten()) {
            let unit = Unit::MetrePerSecond2;
            let name = format!("{}.{name}", sensor.name);
            let label = Label { reference: base + id, name, group: "sensors", unit, feedthrough: feedthrough.clone() };
            let before = self.outputs.len();
            self.add(label, text, move |s| acceleration(s, body, &point, &gravity)[axis]);
            let needs = if apart { Needs::Bodies } else { Needs::Contacts };
            self.outputs[before..].iter_mut().for_each(|output| output.needs = needs);
        }
    }

    /// What force elements report: wheelsets' own springs, or all others.
    fn forces(&mut self, vehicle: &VehicleSpec, own: bool) {
        let first = self.model.system.forces.len() - vehicle.forces.len();
        for (index, element) in vehicle.forces.iter().enumerate() {
            let wheelset = vehicle.suspended_by(element.0.name());
            if wheelset.is_some() != own {
                continue;
            }
            let (base, group) = match wheelset {
                Some(wheelset) => ((wheelset as u32 + 1) * 1000 + SUSPENSION_FORCES, "suspension"),
                None => (number_of_element(index), "forces"),
            };
            for (place, quantity) in element.0.quantities().iter().enumerate() {
                let unit = match quantity.kind {
                    QuantityKind::Force => Unit::Newton,
                    QuantityKind::Moment => Unit::NewtonMetre,
                    QuantityKind::Displacement => Unit::Metre,
                    QuantityKind::Angle => Unit::Radian,
                    QuantityKind::Speed => Unit::MetrePerSecond,
                    QuantityKind::AngularSpeed => Unit::RadianPerSecond,
                    QuantityKind::Power => Unit::Watt,
                };
                let (reference, name) = (base + quantity.number, format!("{}.{}", element.0.name(), quantity.name));
                let label = Label { reference, name, group, unit, feedthrough: Feedthrough::of_element(index) };
                let before = self.outputs.len();
                let read = quantity_of(self.model, first + index, place);
                self.add_of_motion(label, quantity.description, read);
                self.outputs[before..].iter_mut().for_each(|output| output.quantity = Some((index, place)));
            }
        }
    }
}

/// Reads what a force element of the model reports. The element's constants are copied, so that outputs do not borrow the model.
fn quantity_of(model: &Model, element: usize, place: usize) -> impl Fn(&Snapshot) -> f64 + Send + Sync + 'static {
    let (states, inputs) = (model.system.states_of_force(element), model.system.inputs_of_force(element));
    let element = model.system.forces[element].clone_box();
    move |s| {
        let system = &s.workspace.system;
        element.quantity(place, &system.with_inputs(inputs.clone()), &s.y[states.clone()])
    }
}

/// Outputs follow the numbers that are now in force in the model: those of the vehicle's force elements with these numbers, and all that hold numbers of contact or
/// of every element.
pub fn follow_constants(outputs: &mut [Output], scene: &Scene, model: &Model, elements: &[usize]) {
    let first = model.system.forces.len() - scene.vehicle.forces.len();
    for output in &mut *outputs {
        if let Some((element, place)) = output.quantity.filter(|(element, _)| elements.contains(element)) {
            output.read_by(Box::new(quantity_of(model, first + element, place)));
        }
    }
    let adhesion = if scene.interface.outputs.contains(&ADHESION) { adhesion_outputs(model) } else { Vec::new() };
    for fresh in adhesion.into_iter().chain(energy_outputs(scene, model, number_of_element)) {
        if let Some(shown) = outputs.iter_mut().find(|output| output.reference == fresh.reference) {
            shown.read_as(fresh);
        }
    }
}

/// Where a point of a body is in the track frame beside that point, with the distance along the track first.
fn place_of(s: &Snapshot, body: usize, point: &Vector3<f64>, line: Option<&CentreLine>) -> Vector3<f64> {
    let place = Attachment::on(body, *point).point(&s.workspace.system.moving());
    let Some(line) = line else { return place };
    let beside = s.workspace.system.stations.get(body).map_or(place.x, |station| station.frame.distance);
    let frame = line.project(&place, beside);
    frame.components(&(place - frame.origin)) + Vector3::x() * frame.distance
}

/// What gravity does to a free body, in the world, m/s2.
fn gravity(scene: &Scene) -> Vector3<f64> {
    let (sin, cos) = scene.track.grade.sin_cos();
    Vector3::new(-sin, 0.0, -cos) * scene.vehicle.gravity
}

/// Acceleration of a point of a body, less `gravity` (in the world), in the body's axes, m/s2. With the axes e of yaw, roll and pitch:
/// `o' = sum (e q'' + o_e x e q')`, where o_e is the part of the angular velocity that turns e; `a = a_c + o' x r + o x (o x r)`. Of boxes on axles that the track
/// keeps upright, products of angular velocities in o' about the axle are left out (1e-3 m/s2 at 0.1 rad/s).
fn acceleration(s: &Snapshot, body: usize, point: &Vector3<f64>, gravity: &Vector3<f64>) -> Vector3<f64> {
    let moving = s.workspace.system.moving();
    let motion = &moving[body];
    let bodies = s.workspace.system.bodies();
    let second = &s.dy[COORDINATES * (bodies + body)..COORDINATES * (bodies + body + 1)];
    let yawing = Vector3::z() * motion.yaw_rate;
    let (roll_axis, axle) = (motion.roll_axis(), motion.axle());
    let rolling = roll_axis * motion.roll_rate;
    let mut turning = Vector3::z() * second[3] + roll_axis * second[4] + yawing.cross(&rolling);
    if motion.turn.is_some() {
        turning += axle * second[5] + (yawing + rolling).cross(&axle) * motion.pitch_rate;
    }
    let of_centre = Vector3::new(second[0], second[1], second[2]);
    let carried = Attachment::on(body, *point);
    let (axes, rate) = (carried.axes(&moving), carried.rotation(&moving));
    if let Some(upright) = moving.station(body).and_then(|station| station.upright) {
        let about = upright.by_rotation.dot(&turning) + upright.by_velocity.dot(&of_centre) - axle.dot(&turning);
        turning += axle * about + (yawing + rolling).cross(&axle) * axle.dot(&(rate - motion.frame_rotation));
    }
    let arm = axes * point;
    let whole = of_centre + turning.cross(&arm) + rate.cross(&rate.cross(&arm));
    axes.tr_mul(&(whole - gravity))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;
    use crate::sim::Simulation;

    /// What needs no contacts is the same to the bit without an evaluation of them.
    #[test]
    fn equiv_outputs_that_need_no_contacts_are_read_without() {
        for (name, stop) in [("wheelset_s1002", 0.6), ("bogie", 0.3), ("vehicle_curve", 2.0), ("wheelset_standstill", 0.2)] {
            let changes =
                ["interface.outputs=[\"motion\",\"wheels\",\"bodies\",\"sensors\",\"forces\",\"suspension\",\"sliding_means\"]"
                    .to_string()];
            let scene = load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"));
            let mut simulation = Simulation::new(&scene, 0.0).unwrap();
            let outputs = scene_outputs(&scene, simulation.model());
            let needing = |needs: Needs| outputs.iter().filter(|output| output.needs == needs).collect::<Vec<&Output>>();
            let (of_motion, of_bodies) = (needing(Needs::Motion), needing(Needs::Bodies));
            assert!(of_motion.len() > 10 && of_motion.len() + of_bodies.len() < outputs.len(), "{name}");
            assert_eq!(
                of_bodies.is_empty(),
                scene.vehicle.sensors.iter().all(|sensor| sensor.body < scene.vehicle.wheelsets.len()),
                "{name}"
            );
            for i in 1..=5 {
                simulation.advance(stop * f64::from(i) / 5.0).unwrap();
                let searched = |simulation: &Simulation| simulation.last_snapshot().workspace.work.search_iterations;
                let before = searched(&simulation);
                let mut short: Vec<f64> = Vec::new();
                for (needs, outputs) in [(Needs::Motion, &of_motion), (Needs::Bodies, &of_bodies)] {
                    short.extend(outputs.iter().map(|output| output.value(simulation.snapshot_with(needs).unwrap())));
                }
                assert_eq!(searched(&simulation), before, "{name}: contacts were searched");
                let whole = simulation.snapshot().unwrap();
                let whole: Vec<f64> = of_motion.iter().chain(&of_bodies).map(|output| output.value(whole)).collect();
                assert!(searched(&simulation) > before);
                for ((short, whole), output) in short.iter().zip(&whole).zip(of_motion.iter().chain(&of_bodies)) {
                    assert_eq!(short.to_bits(), whole.to_bits(), "{name}: {}", output.name);
                }
            }
        }
    }
}
