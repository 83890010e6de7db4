//! Reads `vehicle.detail`: which bodies of a vehicle stay, and its elements between them.
//!
//! Bodies, joints and force elements are a graph ([`super::graph`]). From a wheelset on (the leading one, or that of `detail_of`) stays
//!
//! - `"vehicle"`: what is connected with it other than by couplers and by elements between the copies of a module;
//! - `"truck"`: of that, what is connected with it when the car bodies are taken out;
//! - `"wheelset"`: of that, the wheelset and what joints hold to it, unless these hold other wheelsets too.
//!
//! In a train, vehicles that `point_masses` names become one body each: of all their mass, on a straight guide along the track, in place of the heaviest one, on which
//! running resistances of its other bodies act.

use super::expand::{Entry, FORCE, Flat, WHEELSET};
use super::extent::{Asked, Extent, KeptElement, Level, PointMass};
use super::graph::Graph;
use super::places::{Bodies, ElementPlaces, Resolver};
use super::{Element, VehicleSpec};
use crate::mbs::force::{Attachment, Places};
use crate::settings::{Section, SettingsError, did_you_mean};
use nalgebra::Vector3;
use std::cell::RefCell;

/// The wheelset that `detail_of` means: its own name, or that of the module in which it is the first.
fn seed(section: &Section, vehicle: &VehicleSpec, flat: &Flat) -> Result<usize, SettingsError> {
    if !section.has("detail_of") {
        return Ok(0);
    }
    let wanted = section.text("detail_of")?;
    let names: Vec<&str> = vehicle.wheelsets.iter().map(|wheelset| wheelset.spec.name.as_str()).collect();
    let within = |name: &&str| name.strip_prefix(wanted.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    names.iter().position(within).ok_or_else(|| {
        let mut known: Vec<&str> = flat.scopes.iter().filter_map(|scope| scope.prefix.strip_suffix('.')).collect();
        known.extend(flat.entries[WHEELSET].iter().map(|entry| entry.name.as_str()));
        let meant = did_you_mean(&wanted, &known);
        section.error("detail_of", format!("found \"{wanted}\"{meant}, expected a wheelset or a module with one: {}", known.join(", ")))
    })
}

/// Reads `point_masses`.
fn point_masses(section: &Section, graph: &Graph, from: &Entries, level: Level) -> Result<Vec<PointMass>, SettingsError> {
    let mut masses: Vec<PointMass> = Vec::new();
    let Some(wanted) = section.optional_texts("point_masses")? else { return Ok(masses) };
    if wanted.is_empty() {
        return Ok(masses);
    }
    let refuse = |problem: String| Err(section.error("point_masses", problem));
    if level != Level::Train {
        return refuse(format!("stands beside detail = \"{}\", which leaves one vehicle at most; expected one of them", level.word()));
    }
    let names = &from.bodies.names;
    for name in &wanted {
        let within = |known: &String| known.strip_prefix(name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        let found: Vec<usize> = (0..names.len()).filter(|body| within(&names[*body])).collect();
        if found.is_empty() {
            let mut known: Vec<&str> = from.flat.scopes.iter().filter_map(|scope| scope.prefix.strip_suffix('.')).collect();
            known.extend(names.iter().map(String::as_str));
            let meant = did_you_mean(name, &known);
            return refuse(format!("found \"{name}\"{meant}, expected vehicles of the train by the names of their modules or bodies"));
        }
        for body in found {
            if masses.iter().any(|mass| mass.own[body]) {
                continue;
            }
            let own = graph.kept(Level::Vehicle, body).unwrap_or_default();
            match graph.heaviest(&own) {
                Some(body) => masses.push(PointMass { body, own }),
                None => {
                    return refuse(format!(
                        "the vehicle of {} has wheelsets alone; expected one with a body that stands for it",
                        names[body]
                    ));
                }
            }
        }
    }
    if (0..graph.wheelsets()).all(|wheelset| masses.iter().any(|mass| mass.own[wheelset])) {
        return refuse("leaves no wheelset on the rails; expected a vehicle less".into());
    }
    let part = |body: &usize| masses.iter().any(|mass| mass.own[*body] && mass.body != *body);
    let link = graph.coupled().find(part);
    match link {
        Some(body) => refuse(format!(
            "a coupler holds on to {}, which is not the heaviest body of its vehicle; expected a coupler on that",
            names[body]
        )),
        None => Ok(masses),
    }
}

/// What was read of the keys here.
pub(super) struct Read {
    pub extent: Extent,
    pub coarser: Option<[Level; 2]>,
    pub followers: Vec<String>,
}

/// What elements are read from.
pub(super) struct Entries<'r, 'a> {
    pub flat: &'r Flat<'a>,
    pub bodies: &'r Bodies,
    /// Reads one element.
    pub parse: &'r dyn Fn(&Entry, &dyn Places) -> Result<Element, SettingsError>,
}

/// Reads `detail` and `detail_of` of a vehicle that was read as a whole. Elements that stay are read a second time, with other numbers of bodies.
pub(super) fn read(section: &Section, vehicle: &VehicleSpec, from: &Entries) -> Result<Read, SettingsError> {
    let graph = Graph::of(vehicle);
    let word = section.word_or("detail", &Level::ALL.map(|level| level.1), Level::Train.word())?;
    let level = Level::ALL.into_iter().find(|level| level.1 == word).map_or(Level::Train, |level| level.0);
    if section.has("detail_of") && !section.has("detail") {
        return Err(section.error("detail_of", "serves nothing without detail, the level to which the vehicle is cut"));
    }
    let seed = seed(section, vehicle, from.flat)?;
    let coarser = graph.coarser(level, seed);
    let masses = point_masses(section, &graph, from, level)?;
    let mut followers = Vec::new();
    let leading = graph.kept(Level::Vehicle, seed).unwrap_or_default();
    if level == Level::Train && masses.is_empty() {
        let mut seen = leading;
        for body in 0..seen.len() {
            if seen[body] {
                continue;
            }
            let own = graph.kept(Level::Vehicle, body).unwrap_or_default();
            followers.extend(graph.heaviest(&own).map(|body| from.bodies.names[body].clone()));
            seen.iter_mut().zip(&own).for_each(|(seen, own)| *seen |= own);
        }
    }
    let Some(mut kept) = graph.kept(level, seed) else {
        let problem = "found \"truck\", but this vehicle's wheelsets carry its heaviest body with nothing between; expected \"wheelset\" or \"vehicle\"";
        return Err(section.error("detail", problem));
    };
    for mass in &masses {
        kept.iter_mut().enumerate().filter(|(body, _)| mass.own[*body] && *body != mass.body).for_each(|(_, kept)| *kept = false);
    }
    if kept.iter().all(|kept| *kept) && masses.is_empty() {
        return Ok(Read { extent: Extent::Whole, coarser, followers });
    }
    let left: Vec<usize> = (0..kept.len()).filter(|body| kept[*body]).collect();
    let mut elements = Vec::new();
    for (element, bodies) in vehicle.forces.iter().zip(&graph.elements) {
        // What resists on a body of a point mass does so on the one that stands for it.
        let moved = bodies.first().filter(|_| bodies.len() == 1 && element.0.resists()).and_then(|body| {
            let mass = masses.iter().find(|mass| mass.own[*body] && !kept[*body])?;
            Some((*body, mass.body))
        });
        let stays = match bodies.first() {
            _ if moved.is_some() => true,
            // What turns an axle goes with it.
            Some(axle) if element.0.turns_axle() => kept[*axle],
            // Inside of a point mass.
            Some(first) if masses.iter().any(|mass| mass.own[*first]) && bodies.iter().any(|body| !kept[*body]) => false,
            _ => bodies.iter().any(|body| kept[*body]),
        };
        let Some(entry) = from.flat.entries[FORCE].iter().find(|entry| stays && entry.name == element.0.name()) else { continue };
        let crosses = moved.is_none() && bodies.iter().any(|body| !kept[*body]);
        let numbers = RefCell::new(if crosses { Vec::new() } else { left.clone() });
        let resolver = Resolver::new(&from.flat.scopes, from.bodies, entry);
        let places = ElementPlaces { resolver: &resolver, name: &entry.name };
        let element = (from.parse)(entry, &Renumbered { places, numbers: &numbers, moved })?;
        elements.push(KeptElement { element, bodies: if crosses { numbers.into_inner() } else { Vec::new() } });
    }
    let key = section.error(if masses.is_empty() { "detail" } else { "point_masses" }, String::new());
    Ok(Read { extent: Extent::Asked(Box::new(Asked { level, kept, elements, masses, key })), coarser, followers })
}

/// The places of an element, with other numbers of bodies than in the whole vehicle.
struct Renumbered<'r> {
    places: ElementPlaces<'r>,
    /// A body's number is its place here; those that are not here come behind.
    numbers: &'r RefCell<Vec<usize>>,
    /// A body, and that which stands for it.
    moved: Option<(usize, usize)>,
}

impl Renumbered<'_> {
    fn number(&self, body: usize) -> usize {
        let body = self.moved.filter(|moved| moved.0 == body).map_or(body, |moved| moved.1);
        let mut numbers = self.numbers.borrow_mut();
        numbers.iter().position(|known| *known == body).unwrap_or_else(|| {
            numbers.push(body);
            numbers.len() - 1
        })
    }

    fn in_whole(&self, place: &Attachment) -> Attachment {
        Attachment { body: place.body.and_then(|number| self.numbers.borrow().get(number).copied()), local: place.local }
    }
}

impl Places for Renumbered<'_> {
    fn attachment(&self, section: &Section, key: &'static str) -> Result<Attachment, SettingsError> {
        let place = self.places.attachment(section, key)?;
        Ok(Attachment { body: place.body.map(|body| self.number(body)), local: place.local })
    }

    fn body(&self, section: &Section, key: &'static str) -> Result<usize, SettingsError> {
        Ok(self.number(self.places.body(section, key)?))
    }

    fn design_vector(&self, from: &Attachment, to: &Attachment) -> Vector3<f64> {
        self.places.design_vector(&self.in_whole(from), &self.in_whole(to))
    }

    fn name(&self, section: &Section) -> Result<String, SettingsError> {
        self.places.name(section)
    }

    fn mirror(&self) -> f64 {
        self.places.mirror()
    }
}
