//! Bodies of a vehicle, and what is between them: which of them are one vehicle of a train, which are car bodies, and what makes a truck.

use super::VehicleSpec;
use super::expand::Entry;
use super::extent::Level;

/// A body that stands on wheelsets and has this share of the mass of the heaviest one of its vehicle, which does so too, is a car body ...
const HEAVY: f64 = 0.5;
/// ... and so is one with this share that nothing holds to wheelsets or to what joints hold to them: a car on trucks, the middle of an articulated vehicle.
const MIDDLE: f64 = 0.2;

/// Names of the elements that couple vehicles: couplers, and those from one copy of a module to the next.
pub(super) fn couplings(vehicle: &VehicleSpec, elements: &[Entry]) -> Vec<String> {
    let couples = |name: &str| {
        let entry = elements.iter().find(|entry| entry.name == name);
        entry.is_some_and(|entry| entry.next.is_some() || entry.section.text("kind").is_ok_and(|kind| kind == "coupler"))
    };
    vehicle.forces.iter().map(|element| element.0.name()).filter(|name| couples(name)).map(str::to_string).collect()
}

/// Bodies by their numbers, wheelsets first.
pub struct Graph {
    wheelsets: usize,
    /// kg.
    masses: Vec<f64>,
    joints: Vec<[usize; 2]>,
    /// Bodies of each force element.
    pub(super) elements: Vec<Vec<usize>>,
    /// Does it couple vehicles?
    couples: Vec<bool>,
    cars: Vec<bool>,
}

impl Graph {
    pub fn of(vehicle: &VehicleSpec) -> Graph {
        let wheelsets = vehicle.wheelsets.iter().map(|wheelset| wheelset.spec.mass);
        let masses: Vec<f64> = wheelsets.chain(vehicle.bodies.iter().map(|placed| placed.body.mass)).collect();
        let cars = vec![false; masses.len()];
        let mut graph = Graph {
            wheelsets: vehicle.wheelsets.len(),
            masses,
            joints: vehicle.joints.iter().filter_map(|joint| Some([joint.bodies.first, joint.bodies.second?])).collect(),
            elements: vehicle.forces.iter().map(|element| element.0.reach().into_iter().flatten().collect()).collect(),
            couples: vehicle.forces.iter().map(|element| vehicle.couplings.iter().any(|name| name == element.0.name())).collect(),
            cars,
        };
        // A truck alone has no car body, nor has a wheelset.
        let cut = vehicle.away().is_some_and(|away| matches!(away.level, Level::Truck | Level::Wheelset));
        graph.cars = (0..graph.masses.len()).map(|body| !cut && graph.looks_like_a_car(body)).collect();
        graph
    }

    /// All links but those between vehicles.
    fn links(&self) -> Vec<&[usize]> {
        let inside = self.elements.iter().zip(&self.couples).filter(|(_, couples)| !**couples).map(|(element, _)| element.as_slice());
        self.joints.iter().map(<[usize; 2]>::as_slice).chain(inside).collect()
    }

    /// What is connected with a body by these links, among those that may be.
    fn connected(&self, seed: usize, may: &[bool], links: &[&[usize]]) -> Vec<bool> {
        let mut found = vec![false; self.masses.len()];
        found[seed] = true;
        loop {
            let before = found.iter().filter(|body| **body).count();
            for link in links {
                if link.iter().any(|body| found[*body]) {
                    link.iter().filter(|body| may[**body]).for_each(|body| found[*body] = true);
                }
            }
            if found.iter().filter(|body| **body).count() == before {
                return found;
            }
        }
    }

    fn vehicle(&self, seed: usize) -> Vec<bool> {
        self.connected(seed, &vec![true; self.masses.len()], &self.links())
    }

    fn looks_like_a_car(&self, body: usize) -> bool {
        if body < self.wheelsets {
            return false;
        }
        let most = self.heaviest(&self.vehicle(body));
        let heaviest = most.map_or(0.0, |most| self.masses[most]);
        if !self.stands_on_wheelsets(body) {
            return self.masses[body] >= MIDDLE * heaviest;
        }
        // A heavy frame under a light car is none.
        self.masses[body] >= HEAVY * heaviest && most.is_none_or(|most| self.stands_on_wheelsets(most))
    }

    /// Does something hold a body to wheelsets, or to what joints hold to them?
    pub fn stands_on_wheelsets(&self, body: usize) -> bool {
        let by_wheels = |other: &usize| *other < self.wheelsets || self.held_to_a_wheelset(*other);
        by_wheels(&body) || self.links().iter().any(|link| link.contains(&body) && link.iter().any(by_wheels))
    }

    /// Do joints hold a body to a wheelset, as they hold axle boxes?
    fn held_to_a_wheelset(&self, body: usize) -> bool {
        self.joints.iter().any(|joint| joint.contains(&body) && joint.iter().any(|other| *other < self.wheelsets))
    }

    /// Is it a car body?
    pub fn is_car(&self, body: usize) -> bool {
        self.cars[body]
    }

    /// The bodies of the truck that a body belongs to: what is connected with it when car bodies are taken out.
    fn truck(&self, body: usize) -> Vec<bool> {
        self.connected(body, &self.light(body), &self.links())
    }

    /// The wheelsets of the truck that a wheelset belongs to.
    pub fn wheelsets_of_truck(&self, wheelset: usize) -> Vec<usize> {
        let truck = self.truck(wheelset);
        (0..self.wheelsets).filter(|other| truck[*other]).collect()
    }

    /// The bodies of its vehicle that are no car bodies.
    fn light(&self, body: usize) -> Vec<bool> {
        self.vehicle(body).iter().zip(&self.cars).map(|(own, car)| *own && !car).collect()
    }

    /// Mass of the truck whose frame a body is, kg: the heaviest of it that is no wheelset; `None`: it is no frame.
    pub fn truck_of_frame(&self, body: usize) -> Option<f64> {
        let truck = self.truck(body);
        let frame = !self.cars[body] && !self.held_to_a_wheelset(body) && self.heaviest(&truck) == Some(body);
        frame.then(|| self.masses.iter().zip(&truck).filter(|(_, own)| **own).map(|(mass, _)| mass).sum())
    }

    /// Bodies that stay at a level; `None`: the wheelsets of this vehicle carry its body without a truck between.
    pub(super) fn kept(&self, level: Level, seed: usize) -> Option<Vec<bool>> {
        if level == Level::Train {
            return Some(vec![true; self.masses.len()]);
        }
        let vehicle = self.vehicle(seed);
        if level == Level::Vehicle {
            return Some(vehicle);
        }
        let others = || (self.wheelsets..self.masses.len()).filter(|body| vehicle[*body]);
        let truck = self.truck(seed);
        if level == Level::Truck {
            return (others().next().is_none() || others().any(|body| truck[body])).then_some(truck);
        }
        let joints: Vec<&[usize]> = self.joints.iter().map(<[usize; 2]>::as_slice).collect();
        let held = self.connected(seed, &self.light(seed), &joints);
        let alone = held.iter().take(self.wheelsets).filter(|wheelset| **wheelset).count() == 1;
        Some(if alone { held } else { (0..self.masses.len()).map(|body| body == seed).collect() })
    }

    /// The heaviest body of a vehicle that is no wheelset.
    pub(super) fn heaviest(&self, vehicle: &[bool]) -> Option<usize> {
        let others = (self.wheelsets..self.masses.len()).filter(|body| vehicle[*body]);
        others.reduce(|a, b| if self.masses[b] > self.masses[a] { b } else { a })
    }

    /// The least level that is as much as `level`, and the next one, which is less.
    pub(super) fn coarser(&self, level: Level, seed: usize) -> Option<[Level; 2]> {
        let now = self.kept(level, seed)?;
        let all = || Level::ALL.into_iter().map(|(level, _)| level);
        let own = all().find(|lower| self.kept(*lower, seed).as_ref() == Some(&now))?;
        let next = all().rev().find(|lower| *lower < own && self.kept(*lower, seed).is_some())?;
        Some([own, next])
    }

    /// How many wheelsets there are.
    pub(super) fn wheelsets(&self) -> usize {
        self.wheelsets
    }

    /// Bodies of elements that couple vehicles.
    pub(super) fn coupled(&self) -> impl Iterator<Item = usize> + '_ {
        self.elements.iter().zip(&self.couples).filter(|(_, couples)| **couples).flat_map(|(element, _)| element).copied()
    }
}
