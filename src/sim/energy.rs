//! Outputs of power (group `power`) and of energy (group `energy`, which costs states: `formulation::energy`), each shown where a scene names it.
//!
//! Numbers: of a wheelset 38 (`inputPower`), 39 (`inputWork`), 40 (`drivingPower`), 41 (`drivingWork`); of a wheel 15 (`frictionPower`) and 16 (`frictionHeat`); of a force
//! element 60 (`work`), 61 (`heat`); of the vehicle as a whole 6000000 and what follows.

use super::Snapshot;
use super::feedthrough::{DRIVING, Depends, Feedthrough, Ties, of_wheel};
use super::outputs::{Needs, Output};
use crate::formulation::energy::{driving_power, friction_power, input_power};
use crate::formulation::energy_books::{CONTACT, EnergyBooks, SUSPENSION};
use crate::formulation::{DRIVE_TORQUE, LATERAL_FORCE, LONGITUDINAL_FORCE, Model, VERTICAL_FORCE, contact_index};
use crate::geometry::Side;
use crate::mbs::force::ForceElement;
use crate::mbs::system::kinetic_energy;
use crate::scene::spec::{ENERGY, POWER, Scene};
use crate::units::Unit;
use std::ops::Range;

/// First number of the outputs of the vehicle as a whole.
pub const VEHICLE: u32 = 6_000_000;
/// Numbers of an element's work and heat.
const ELEMENT: [u32; 2] = [60, 61];

/// Powers and energies of a scene's groups; `number` is where those of a force element of the vehicle begin.
pub(super) fn energy_outputs(scene: &Scene, model: &Model, number: impl Fn(usize) -> u32) -> Vec<Output> {
    let groups = &scene.interface.outputs;
    let mut all = Vec::new();
    if groups.contains(&POWER) {
        powers(model, &mut all);
    }
    if groups.contains(&ENERGY) {
        stored(scene, model, &mut all);
        if let Some(books) = &model.books {
            booked(scene, model, books, number, &mut all);
        }
    }
    all
}

fn powers(model: &Model, all: &mut Vec<Output>) {
    let ties = Ties::of(model);
    let mut add = |label, text: &str, feedthrough, needs, read: Box<dyn Fn(&Snapshot) -> f64 + Send + Sync>| {
        let mut output = Output::new(label, POWER, Unit::Watt, text, feedthrough, read);
        output.needs = needs;
        all.push(output);
    };
    for (index, wheelset) in model.wheelsets.iter().enumerate() {
        let (base, body, name) = ((index as u32 + 1) * 1000, wheelset.body, &wheelset.name);
        let on = |depends| Feedthrough::of_wheelset(model, &ties, body, depends);
        for (side, number) in Side::BOTH.into_iter().zip([115, 215]) {
            let text = "power that slip takes at all contacts of the wheel: heat and wear (with contact.transient also what the patch stores and gives back)";
            let contact = contact_index(index, side);
            let read = Box::new(move |s: &Snapshot| friction_power(&s.workspace, contact));
            let label = (base + number, format!("{name}.{}.frictionPower", side.name()));
            add(label, text, on(of_wheel(side).friction), Needs::Contacts, read);
        }
        let own = Depends::Only(&[DRIVE_TORQUE, LATERAL_FORCE, VERTICAL_FORCE, LONGITUDINAL_FORCE]);
        let read = Box::new(move |s: &Snapshot| input_power(&s.workspace, s.inputs(), index, body));
        let text = "power of the inputs of the wheelset: forces on its centre and driveTorque";
        add((base + 38, format!("{name}.inputPower")), text, on(own), Needs::Motion, read);
        if let Some(drive) = model.system.drives.iter().position(|drive| drive.body == body) {
            let read = Box::new(move |s: &Snapshot| driving_power(&s.workspace, drive, body));
            let text = "power of the driving constraint: what a locomotive must supply to keep the imposed speed";
            add((base + 40, format!("{name}.drivingPower")), text, on(DRIVING), Needs::Contacts, read);
        }
    }
    let passive = elements(model, 0..model.system.forces.len(), |force| force.inputs().is_empty() && force.is_dissipative());
    if !passive.is_empty() {
        let text = "power that all force elements without inputs turn into heat: dampers, friction of suspensions";
        let read =
            Box::new(move |s: &Snapshot| sum(&passive, |force, states| force.dissipated_power(&s.workspace.system.moving(), &s.y[states])));
        add((VEHICLE, "power.suspension".into()), text, Feedthrough::none(), Needs::Motion, read);
    }
}

/// What the vehicle has stored now.
fn stored(scene: &Scene, model: &Model, all: &mut Vec<Output>) {
    let (bodies, supported) = (model.system.bodies.clone(), model.system.supported.clone());
    let read = Box::new(move |s: &Snapshot| kinetic_energy(&bodies, &supported, &s.workspace.system.motions));
    let mut add = |number: u32, name: &str, text: &str, read: Box<dyn Fn(&Snapshot) -> f64 + Send + Sync>| {
        let mut output = Output::new((VEHICLE + number, name.into()), ENERGY, Unit::Joule, text, Feedthrough::none(), read);
        output.needs = Needs::Motion;
        all.push(output);
    };
    add(1, "energy.kinetic", "kinetic energy of all bodies, and of the loads that wheelsets support", read);
    let first = model.system.forces.len() - scene.vehicle.forces.len();
    let potential = |range| {
        let held = elements(model, range, |_| true);
        Box::new(move |s: &Snapshot| sum(&held, |force, states| force.potential_energy(&s.workspace.system.moving(), &s.y[states])))
    };
    add(2, "energy.height", "energy of weight, up to a constant: it rises uphill", potential(0..first));
    let text = "energy stored in force elements, up to a constant, with that of rotors that turn behind their drives";
    add(3, "energy.elements", text, potential(first..first + scene.vehicle.forces.len()));
}

/// What has gone in and out since the start.
fn booked(scene: &Scene, model: &Model, books: &EnergyBooks, begin: impl Fn(usize) -> u32, all: &mut Vec<Output>) {
    let first = model.books_begin();
    let mut add = |number: u32, name: String, text: &str, place: usize| {
        let place = first + place;
        let read = Box::new(move |s: &Snapshot| s.y[place]);
        let mut output = Output::new((number, name), ENERGY, Unit::Joule, text, Feedthrough::none(), read);
        output.needs = Needs::Motion;
        all.push(output);
    };
    for (index, wheelset) in model.wheelsets.iter().enumerate() {
        let (base, name) = ((index as u32 + 1) * 1000, &wheelset.name);
        for (side, number) in Side::BOTH.into_iter().zip([116, 216]) {
            let label = format!("{name}.{}.frictionHeat", side.name());
            add(base + number, label, "what slip has taken at the wheel since the start", books.friction(index, side));
        }
        add(base + 39, format!("{name}.inputWork"), "work of the inputs of the wheelset since the start", books.inputs(index));
        if let Some(drive) = model.system.drives.iter().position(|drive| drive.body == wheelset.body) {
            add(base + 41, format!("{name}.drivingWork"), "work of the driving constraint since the start", books.drive(drive));
        }
    }
    let text = "what all force elements without inputs have turned into heat since the start: dampers, friction of suspensions";
    add(VEHICLE + 4, "energy.suspensionHeat".into(), text, SUSPENSION);
    let text =
        "work of contacts on the wheels since the start beside friction: elastic compression and damping (negative), rails that move";
    add(VEHICLE + 5, "energy.contactWork".into(), text, CONTACT);
    if let Some(guides) = books.guides {
        let text = "work since the start of what stands for parts that `vehicle.detail` cuts away: gravity pulls them down a grade";
        add(VEHICLE + 6, "energy.guideWork".into(), text, guides);
    }
    let elements = model.system.forces.len() - scene.vehicle.forces.len();
    for (index, element) in scene.vehicle.forces.iter().enumerate() {
        let texts = ["work that its inputs have brought in since the start", "what it has turned into heat since the start"];
        let labels = ["work", "heat"].map(|name| format!("{}.{name}", element.0.name()));
        for (((number, name), text), place) in ELEMENT.into_iter().zip(labels).zip(texts).zip(books.element(elements + index)) {
            if let Some(place) = place {
                add(begin(index) + number, name, text, place);
            }
        }
    }
}

type Held = (Box<dyn ForceElement>, Range<usize>);

/// Copies of elements of a model with the places of their states.
fn elements(model: &Model, range: Range<usize>, keep: impl Fn(&dyn ForceElement) -> bool) -> Vec<Held> {
    let kept = range.filter(|element| keep(model.system.forces[*element].as_ref()));
    kept.map(|element| (model.system.forces[element].clone_box(), model.system.states_of_force(element))).collect()
}

fn sum(elements: &[Held], of: impl Fn(&dyn ForceElement, Range<usize>) -> f64) -> f64 {
    elements.iter().map(|(element, states)| of(element.as_ref(), states.clone())).sum()
}
