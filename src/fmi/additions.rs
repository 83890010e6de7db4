//! What FMI 3.0 can say beyond the table that both versions share: time, discrete outputs, and arrays over wheelsets and wheels.
//!
//! An array shows outputs that are there one by one too, so that who wants one wheel and who wants all have a name each. References: time 0; of
//! wheelset k, contacts under its wheels 1000 k + 36 and 37; an array 5000000 + the number of its outputs among a wheelset's.

use super::variable::{Kind, Role, Variable, WHEELSET};
use crate::formulation::contact_index;
use crate::geometry::Side;
use crate::scene::spec::Scene;
use crate::sim::outputs::Output;
use crate::units::Unit;
use std::collections::HashMap;

/// First reference of the arrays.
const ARRAYS: u32 = 5_000_000;
const LEFT_CONTACTS: u32 = 36;

/// Outputs of one name of all wheelsets or wheels.
pub struct Array {
    pub reference: u32,
    pub name: String,
    pub description: String,
    pub unit: Unit,
    /// Wheelsets; then 2 where it is one of wheels, the left one first.
    pub dimensions: Vec<usize>,
    /// References of its elements, the last dimension running fastest.
    pub elements: Vec<u32>,
}

/// All that only FMI 3.0 shows.
#[derive(Default)]
pub struct Additions {
    /// Time, then the discrete outputs.
    pub variables: Vec<Variable>,
    pub arrays: Vec<Array>,
    /// Index of each array by reference.
    index: HashMap<u32, usize>,
}

impl Additions {
    pub(super) fn new(scene: &Scene, outputs: &[Output]) -> Self {
        let mut variables = vec![time()];
        let groups = &scene.interface.outputs;
        let asked = groups.contains(&"wheels") || groups.contains(&"contacts");
        for (index, (wheelset, _)) in scene.vehicle.axles().iter().copied().enumerate() {
            if asked && scene.interface.shows(wheelset) {
                variables.extend(Side::BOTH.map(|side| contacts(index, wheelset, side)));
            }
        }
        let shown: Vec<(u32, &str)> = (1..).zip(scene.vehicle.axles().iter().map(|axle| axle.0)).collect();
        let shown: Vec<(u32, &str)> = shown.into_iter().filter(|(_, name)| scene.interface.shows(name)).collect();
        let arrays = arrays(&shown, outputs);
        let index = arrays.iter().enumerate().map(|(index, array)| (array.reference, index)).collect();
        Additions { variables, arrays, index }
    }

    pub(super) fn place(&self, reference: u32) -> Option<usize> {
        self.variables.iter().position(|variable| variable.reference == reference)
    }

    /// The array with a reference.
    pub fn array(&self, reference: u32) -> Option<&Array> {
        self.index.get(&reference).map(|index| &self.arrays[*index])
    }
}

fn time() -> Variable {
    Variable {
        reference: 0,
        name: "time".into(),
        description: "simulated time".into(),
        kind: Kind::Real,
        causality: "independent",
        variability: "continuous",
        initial: None,
        unit: Unit::Second,
        start: None,
        min: None,
        max: None,
        role: Role::Time,
    }
}

fn contacts(index: usize, wheelset: &str, side: Side) -> Variable {
    Variable {
        reference: WHEELSET * (index as u32 + 1) + LEFT_CONTACTS + side.index() as u32,
        name: format!("{wheelset}.{}.contacts", side.name()),
        description: "number of the wheel's contacts that carry load: 0 in the air, 2 with tread and flange; a change is an event".into(),
        kind: Kind::Integer,
        causality: "output",
        variability: "discrete",
        initial: Some("calculated"),
        unit: Unit::One,
        start: None,
        min: Some(0.0),
        max: None,
        role: Role::Contacts(contact_index(index, side)),
    }
}

/// Arrays over the wheelsets of these numbers (from 1) and names; none for a lone one.
fn arrays(shown: &[(u32, &str)], outputs: &[Output]) -> Vec<Array> {
    let [first, .., _] = shown else { return Vec::new() };
    let by_name: HashMap<&str, &Output> = outputs.iter().map(|output| (output.name.as_str(), output)).collect();
    let own = |output: &&Output| output.reference / WHEELSET == first.0;
    let mut arrays = Vec::new();
    for output in outputs.iter().filter(own) {
        let Some(rest) = output.name.strip_prefix(first.1).and_then(|rest| rest.strip_prefix('.')) else { continue };
        let (name, sides): (String, &[&str]) = match (rest.strip_prefix("left."), rest.starts_with("right.")) {
            (Some(rest), _) => (rest.into(), &["left.", "right."]),
            (None, true) => continue,
            (None, false) => (rest.into(), &[""]),
        };
        let names = shown.iter().flat_map(|wheelset| sides.iter().map(|side| format!("{}.{side}{name}", wheelset.1)));
        // What not all have is no array.
        let Some(elements) = names.map(|name| by_name.get(name.as_str()).map(|output| output.reference)).collect::<Option<Vec<u32>>>()
        else {
            continue;
        };
        let of_wheels = sides.len() == 2;
        arrays.push(Array {
            reference: ARRAYS + output.reference % WHEELSET,
            name: format!("{}.{name}", if of_wheels { "wheels" } else { "wheelsets" }),
            description: if of_wheels {
                format!("{}; wheelsets, left and right wheel", output.description.replace(" of the left wheel", ""))
            } else {
                format!("{}; wheelsets", output.description)
            },
            unit: output.unit,
            dimensions: if of_wheels { vec![shown.len(), 2] } else { vec![shown.len()] },
            elements,
        });
    }
    arrays
}
