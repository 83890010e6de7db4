//! Cuts a vehicle to the level of detail that its scene calls for (`vehicle.detail`).
//!
//! The whole vehicle's steady running on ideal straight track says where each body is that will not be there. What stays is held by that: force elements by guides
//! ([`Held`]), joints by the ground but for the direction along the track ([`Joint::held`]). In steady running on straight track the part therefore does what it does in
//! the whole: same places, same wheel loads. Preloads that balance asks for are those of the whole. Where the speed is free or changes, the mass of what was cut away, so far as the
//! kept wheels carry it, goes along the track with the heaviest kept body. What rolls freely does so in that steady state too, with the common acceleration a of the whole: the
//! mass M that goes along has it already ([`CarriedPull`]). What joints across the cut pull with, which hold no more along the track, is a force of its own: the rest of the vehicle
//! that the kept wheelset pulls by an imposed speed, or its part of a vehicle that rolls. (In the state of an imposed speed the driven wheelsets push the others uphill, and a part that rolls freely from it went with
//! twice the acceleration or none.)
//!
//! A vehicle that is a point mass stays as its heaviest body, with all mass, that moves along the track alone; wheels that turn are inertia beside it.

use super::error::SceneError;
use super::spec::{InterfaceSpec, Scene};
use super::steady_state::steady_state;
use super::vehicle::extent::{Asked, Away, Extent, KeptElement};
use super::vehicle::{Element, PlacedBody, PlacedWheelset, Sensor, VehicleSpec, assemble};
use crate::mbs::body::{BodyMotion, COORDINATES};
use crate::mbs::force::{CarriedPull, ForceElement, Held, HeldGuide, Holder};
use crate::mbs::joint::Joint;
use crate::mbs::kkt::RowBodies;
use crate::mbs::supported::SupportedMass;
use crate::settings::SettingsError;

/// Steady running is that of at least this speed, m/s.
const LEAST_SPEED: f64 = 1.0;

/// Cuts the scene's vehicle, if its scene asks for it.
///
/// # Errors
/// [`SceneError`]: why that can't be done.
pub(super) fn cut(scene: &mut Scene) -> Result<(), SceneError> {
    let Extent::Asked(asked) = std::mem::replace(&mut scene.vehicle.extent, Extent::Whole) else { return Ok(()) };
    let refuse = |problem: &str| SettingsError { problem: problem.into(), ..asked.key.clone() };
    if scene.track.line.is_some() {
        let problem = "leaves out bodies whose turning and centrifugal forces belong to a curve or cant; expected track without [[track.node]], or the whole vehicle";
        return Err(refuse(problem).into());
    }
    let whole = steady_scene(scene);
    let in_scene = |error| SceneError::Assembly { file: scene.source.file.clone(), error };
    let preloads = assemble::static_preloads(&scene.vehicle).map_err(in_scene)?;
    let steady = steady_state(&whole).map_err(|error| SceneError::Equilibrium { file: scene.source.file.clone(), error })?;
    let acceleration = if whole.vehicle.speed_imposed { 0.0 } else { steady.acceleration };
    let cutting = Cutting {
        whole: &scene.vehicle,
        asked: &asked,
        preloads,
        y: &steady.y,
        loads: &steady.wheel_loads,
        grade: scene.track.grade,
        acceleration,
        pulls: &steady.pulls,
    };
    let vehicle = cutting.vehicle().map_err(|problem| refuse(&problem))?;
    if let Some(only) = &mut scene.interface.only {
        let names = vehicle.part_names();
        let there = |name: &String| {
            names.iter().any(|part| part.strip_prefix(name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.')))
        };
        only.retain(there);
        if only.is_empty() {
            let problem = "leaves none of the parts that interface.only names; expected one that stays, detail_of, or no such list";
            return Err(refuse(problem).into());
        }
    }
    scene.vehicle = vehicle;
    Ok(())
}

/// The whole vehicle as it runs steadily on ideal track: with its speed imposed, or freely as it rolls.
fn steady_scene(scene: &Scene) -> Scene {
    let mut whole = scene.clone();
    whole.track.deviations.clear();
    whole.interface = InterfaceSpec::default();
    whole.vehicle = whole.vehicle.steady();
    let vehicle = &mut whole.vehicle;
    if vehicle.speed.abs() < LEAST_SPEED {
        vehicle.forces.retain(|element| !element.0.resists());
        vehicle.speed = LEAST_SPEED.copysign(vehicle.speed);
    }
    if vehicle.speed_imposed {
        drive(&mut vehicle.wheelsets);
    }
    whole
}

/// An imposed speed acts on the leading wheelset, if on no other.
fn drive(wheelsets: &mut [PlacedWheelset]) {
    if !wheelsets.iter().any(|wheelset| wheelset.driven)
        && let Some(leading) = wheelsets.first_mut()
    {
        leading.driven = true;
    }
}

/// A vehicle that is cut.
struct Cutting<'c> {
    whole: &'c VehicleSpec,
    asked: &'c Asked,
    /// Number of an element of the whole, index and force, N.
    preloads: Vec<(usize, usize, f64)>,
    /// State of steady running.
    y: &'c [f64],
    /// Mean wheel load of each wheelset, N.
    loads: &'c [f64],
    /// rad.
    grade: f64,
    /// Of the whole along the track, where it rolls freely, m/s2.
    acceleration: f64,
    /// What joints and imposed speeds pull each body of the whole with, N.
    pulls: &'c [f64],
}

impl Cutting<'_> {
    fn kept(&self, body: usize) -> bool {
        self.asked.kept[body]
    }

    /// Number of a body that stays.
    fn number(&self, body: usize) -> usize {
        (0..body).filter(|body| self.kept(*body)).count()
    }

    fn name(&self, body: usize) -> String {
        match body.checked_sub(self.whole.wheelsets.len()) {
            Some(other) => self.whole.bodies[other].body.name.clone(),
            None => self.whole.wheelsets[body].spec.name.clone(),
        }
    }

    /// Where a body is in steady running, in the world or beside another body.
    fn place(&self, body: usize, beside: Option<usize>) -> HeldGuide {
        let coordinates = |body: usize| &self.y[COORDINATES * body..COORDINATES * (body + 1)];
        let along = beside.map_or(0.0, |beside| coordinates(beside)[0]);
        HeldGuide::new(coordinates(body), along, body < self.whole.wheelsets.len())
    }

    /// What is left.
    fn vehicle(&self) -> Result<VehicleSpec, String> {
        let whole = self.whole;
        let first = whole.wheelsets.len();
        let mut wheelsets: Vec<PlacedWheelset> =
            whole.wheelsets.iter().enumerate().filter(|(body, _)| self.kept(*body)).map(|(_, wheelset)| wheelset.clone()).collect();
        if whole.speed_imposed {
            drive(&mut wheelsets);
        }
        let mut bodies: Vec<PlacedBody> =
            whole.bodies.iter().enumerate().filter(|(body, _)| self.kept(first + body)).map(|(_, body)| body.clone()).collect();
        let sensors: Vec<Sensor> = whole
            .sensors
            .iter()
            .filter(|sensor| self.kept(sensor.body))
            .map(|sensor| Sensor { body: self.number(sensor.body), ..sensor.clone() })
            .collect();
        let mut guides = Vec::new();
        let (mut joints, held) = self.joints(&mut guides)?;
        let mut point_masses = Vec::new();
        for point in &self.asked.masses {
            let number = self.number(point.body);
            let (mass, turning) = self.mass(&point.own);
            let name = self.name(point.body);
            bodies[number - wheelsets.len()].body.mass = mass;
            joints.push(Joint::along_track(&format!("{name}.track"), number, self.place(point.body, None).motion()));
            point_masses.push((number, (name, mass, turning)));
        }
        let forces = self.forces(&mut guides);
        guides.sort_unstable();
        guides.dedup();
        let stays = |name: &str| forces.iter().any(|force| force.0.name() == name) || sensors.iter().any(|sensor| sensor.name == name);
        let named = whole.sensors.iter().map(|sensor| sensor.name.as_str());
        let with_inputs = whole.forces.iter().filter(|force| !force.0.inputs().is_empty()).map(|force| force.0.name());
        let lost = named.chain(with_inputs).filter(|name| !stays(name)).map(str::to_string).collect();
        let gone = |acts: &dyn Fn(&dyn ForceElement) -> bool| -> Vec<String> {
            let acting = whole.forces.iter().filter(|force| acts(force.0.as_ref()) && !stays(force.0.name()));
            acting.map(|force| force.0.name().to_string()).collect()
        };
        // What is slower than steady running begins without resistance.
        let resists = |force: &dyn ForceElement| force.resists() && whole.speed.abs() >= LEAST_SPEED;
        let begins = |force: &dyn ForceElement| (0..force.inputs().len()).any(|index| force.start_input(index) != 0.0);
        let from_outside = |force: &dyn ForceElement| force.bodies().iter().flatten().count() == 1;
        // Guides keep what resists, but those of a point mass do not hold it along the track.
        let by_guides = |force: &dyn ForceElement| resists(force) && self.asked.masses.is_empty();
        let acting = gone(&|force| begins(force) || from_outside(force) && !by_guides(force));
        let kept_constant = gone(&by_guides);
        let mut vehicle = VehicleSpec { wheelsets, bodies, joints, forces, sensors, extent: Extent::Whole, ..whole.clone() };
        // On the rails, less what is there.
        let loads = self.loads.iter().enumerate().filter(|(body, _)| self.kept(*body)).map(|(_, load)| 2.0 * load).sum::<f64>();
        let weight = loads / self.grade.cos() - vehicle.weight();
        let heaviest = (0..vehicle.bodies.len()).max_by(|a, b| vehicle.bodies[*a].body.mass.total_cmp(&vehicle.bodies[*b].body.mass));
        let mass = if vehicle.gravity > 0.0 { (weight / vehicle.gravity).max(0.0) } else { 0.0 };
        let carried = SupportedMass { body: heaviest.map_or(0, |body| vehicle.wheelsets.len() + body), mass };
        let by_joints = held.iter().map(|body| CarriedPull { body: self.number(*body), force: self.pulled_across(*body) });
        let pulls = [CarriedPull { body: carried.body, force: mass * self.acceleration }].into_iter().chain(by_joints);
        let pulls = pulls.filter(|pull| pull.force != 0.0).collect();
        let turning = point_masses.iter().map(|(body, point)| SupportedMass { body: *body, mass: point.2 });
        let along = Some(carried).filter(|_| mass > 0.0 && !vehicle.keeps_speed()).into_iter().chain(turning).collect();
        let names = |bodies: &mut dyn Iterator<Item = usize>| bodies.map(|body| self.name(body)).collect();
        vehicle.extent = Extent::Cut(Box::new(Away {
            level: self.asked.level,
            bodies: names(&mut (0..whole.body_count()).filter(|body| !self.kept(*body))),
            guides: names(&mut guides.into_iter()),
            lost,
            acting,
            kept_constant,
            weight,
            carried: mass,
            along,
            pulls,
            masses: point_masses.into_iter().map(|(_, point)| point).collect(),
        }));
        Ok(vehicle)
    }

    /// Mass of a point mass, and what its wheels and the rotors of its motors add to it by turning, kg: m and (Iyy + n^2 J) / r^2.
    fn mass(&self, own: &[bool]) -> (f64, f64) {
        let whole = self.whole;
        let wheelsets = whole.wheelsets.iter().zip(own).filter(|(_, own)| **own).map(|(wheelset, _)| &wheelset.spec);
        let load = |force: f64| if whole.gravity > 0.0 { force / whole.gravity } else { 0.0 };
        let (mass, turning) = wheelsets.fold((0.0, 0.0), |(mass, turning), spec| {
            let radius = spec.profiles[0].profile.at(0.0).value;
            (mass + spec.mass + load(spec.vertical_load), turning + spec.axial_inertia / (radius * radius))
        });
        let rotors = whole.forces.iter().filter_map(|force| force.0.rotor_on_axle()).filter(|(axle, _)| own[*axle]);
        let turning = rotors.fold(turning, |turning, (axle, inertia)| {
            let radius = whole.wheelsets[axle].spec.profiles[0].profile.at(0.0).value;
            turning + inertia / (radius * radius)
        });
        let bodies = whole.bodies.iter().zip(&own[whole.wheelsets.len()..]).filter(|(_, own)| **own);
        (mass + bodies.map(|(body, _)| body.body.mass).sum::<f64>(), turning)
    }

    /// What joints across the cut pull those kept bodies with, along the track, that joints link to the kept `body`, N: among themselves they only pull each other. What is left over
    /// of all that are linked, kept or not, is by imposed speeds, whose wheelsets have equal parts of it (exact for one).
    fn pulled_across(&self, body: usize) -> f64 {
        let linked = self.linked(body);
        let pulls = |kept: bool| linked.iter().filter(|body| !kept || self.kept(**body)).map(|body| self.pulls[*body]).sum::<f64>();
        let driven = |body: &&usize| self.whole.speed_imposed && self.whole.wheelsets.get(**body).is_some_and(|wheelset| wheelset.driven);
        let all = linked.iter().filter(driven).count();
        let kept = linked.iter().filter(driven).filter(|body| self.kept(**body)).count();
        pulls(true) - if all > 0 { pulls(false) * kept as f64 / all as f64 } else { 0.0 }
    }

    /// The bodies of the whole that joints link to one, with itself.
    fn linked(&self, body: usize) -> Vec<usize> {
        let mut linked = vec![body];
        let mut next = 0;
        while let Some(&of) = linked.get(next) {
            for joint in &self.whole.joints {
                let RowBodies { first, second: Some(second) } = joint.bodies else { continue };
                for other in [(first, second), (second, first)].into_iter().filter(|ends| ends.0 == of).map(|ends| ends.1) {
                    if !linked.contains(&other) {
                        linked.push(other);
                    }
                }
            }
            next += 1;
        }
        linked
    }

    /// With a body of the whole for each group of linked ones that joints across the cut hold.
    fn joints(&self, guides: &mut Vec<usize>) -> Result<(Vec<Joint>, Vec<usize>), String> {
        let (mut joints, mut groups) = (Vec::new(), Vec::<usize>::new());
        for joint in &self.whole.joints {
            let RowBodies { first, second } = joint.bodies;
            // Inside of a point mass nothing holds.
            if self.asked.masses.iter().any(|mass| mass.own[first]) {
                continue;
            }
            let [one, other] = [self.kept(first), second.is_none_or(|second| self.kept(second))];
            match (one, other, second) {
                (false, _, None) | (false, false, _) => {}
                (true, true, _) => {
                    let bodies = RowBodies { first: self.number(first), second: second.map(|second| self.number(second)) };
                    let mut joint = joint.clone();
                    joint.bodies = bodies;
                    joints.push(joint);
                }
                (_, _, Some(second)) => {
                    let (stays, gone) = if one { (first, second) } else { (second, first) };
                    let held = joint.held(self.number(stays), one, self.place(gone, Some(stays)).motion()).ok_or_else(|| {
                        format!(
                            "cuts the joint {} between {}, which stays, and {}: its rows follow a body's axis, which can't be held beside the track; expected another level, or a joint that holds a point",
                            joint.name,
                            self.name(stays),
                            self.name(gone)
                        )
                    })?;
                    guides.push(gone);
                    if !self.linked(stays).iter().any(|body| groups.contains(body)) {
                        groups.push(stays);
                    }
                    joints.push(held);
                }
                (true, false, None) => {}
            }
        }
        Ok((joints, groups))
    }

    fn forces(&self, guides: &mut Vec<usize>) -> Vec<Element> {
        let mut forces = Vec::new();
        for KeptElement { element, bodies } in &self.asked.elements {
            let name = element.0.name();
            // effects.without has taken some of the whole.
            let Some(number) = self.whole.forces.iter().position(|force| force.0.name() == name) else { continue };
            let mut element = element.0.clone_box();
            for (_, index, force) in self.preloads.iter().filter(|preload| preload.0 == number) {
                element.set_preload(*index, *force);
            }
            let Some(followed) = self.followed(element.as_ref(), bodies) else {
                forces.push(Element(element));
                continue;
            };
            let holder = |body: &usize| match self.kept(*body) {
                true => Holder::Body(self.number(*body)),
                false => {
                    guides.push(*body);
                    Holder::Guide(Box::new(self.place(*body, Some(followed))))
                }
            };
            let holders = bodies.iter().map(holder).collect();
            let at_rest: Vec<BodyMotion> = bodies.iter().map(|body| *self.place(*body, None).motion()).collect();
            forces.push(Element(Box::new(Held::new(element, holders, self.number(followed), &at_rest))));
        }
        forces
    }

    /// The first of an element's bodies that stays, by its number in the whole; `None`: all of them do.
    fn followed(&self, element: &dyn ForceElement, bodies: &[usize]) -> Option<usize> {
        element.reach().into_iter().flatten().filter_map(|own| bodies.get(own).copied()).find(|body| self.kept(*body))
    }
}
