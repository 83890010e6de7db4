//! What the parts of a right-hand side take, without a clock: pieces of work that one evaluation does, counted, times the instructions that each takes.
//!
//! Counts are the model's own ([`crate::formulation::work::Work`], what its contacts report, strips that are pressed, elements, bodies, rows of joints): the same on every machine and in every run. The
//! instructions of a piece were counted by callgrind on x86-64 (rustc 1.95), as means over the embedded scenes; `tests/instructions.rs` holds their sums against counts of whole
//! evaluations. They are what `wheelrail plan` shows; times by the clock, of whole runs too, are `wheelrail study --where`'s.

use super::Part;
use super::anatomy::Sample;
use crate::contact::patch::PatchLaw;
use crate::formulation::step::WheelRef;
use crate::formulation::{Evaluation, Model, Workspace};
use serde::Serialize;

/// Instructions of a creep law's force, by its name in scenes.
const CREEP: [(&str, f64); 6] = [
    ("kalker_linear", 260.0),
    ("shen_hedrick_elkins", 290.0),
    ("polach", 480.0),
    ("usetab", 2100.0),
    ("fastsim", 9600.0),
    ("fastrip", 15_500.0),
];
/// ... of `exact`, which solves a half space on a grid.
const EXACT: f64 = 2e7;
/// Of the normal problem of half-spaces on its grid.
const HALF_SPACES: f64 = 2e7;
/// Of the normal law at one place: where the law says that it takes the curvature over the patch, and else.
const OVER_PATCH: f64 = 3700.0;
const AT_POINT: f64 = 260.0;
/// Of a patch of n strips: each is laid under the wheel, and feels all others.
const STRIP: f64 = 1150.0;
const STRIPS: f64 = 197.0;
/// Of n strips as one part: its sums, and what its slip adds to the creep law.
const SUMS: f64 = 330.0;
const UNEVEN: f64 = 1700.0;
/// Of reading a table, and of linear contact.
const TABLE: f64 = 9800.0;
const LINEAR: f64 = 3600.0;
/// Of a wheel; of one whose places are searched for; of a place; of one that is loaded; of a pair of nodes (ECF-N).
const WHEEL: f64 = 500.0;
const SEARCHED: f64 = 2000.0;
const PLACE: f64 = 2400.0;
const LOADED: f64 = 620.0;
const NODES: f64 = 205.0;
/// Of a constrained wheel's rows, and of one round of its balance beside the laws.
const CONSTRAINED: f64 = 7800.0;
const BALANCE: f64 = 700.0;
/// Of a tangential deflection ([contact.transient]).
const TRANSIENT: f64 = 1500.0;
/// Of a force element, of a body, of a row of joints, and of where something is along a curved centre line.
const ELEMENT: f64 = 440.0;
const BODY: f64 = 200.0;
const JOINT_ROW: f64 = 1700.0;
const STATION: f64 = 1850.0;

/// Instructions of the parts of a right-hand side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Counted {
    pub parts: Vec<(Part, f64)>,
}

impl Counted {
    /// All of it.
    pub fn whole(&self) -> f64 {
        self.parts.iter().map(|part| part.1).sum()
    }

    /// Of one evaluation of a model whose creep law is called `creep` in scenes; `None` where the evaluation has no answer.
    pub fn of(model: &Model, sample: &Sample, creep: &str) -> Option<Counted> {
        let (mut workspace, mut memory, mut dy) = (model.workspace(), sample.memory.clone(), vec![0.0; model.dimension()]);
        let at = Evaluation { t: sample.t, inputs: &sample.inputs, y: &sample.y, memory: &mut memory };
        model.derivative(&mut workspace, at, &mut dy).ok()?;
        let creep = CREEP.iter().find(|law| law.0 == creep).map_or(EXACT, |law| law.1);
        let normal = if model.laws.normal.describe().contains("over the patch") { OVER_PATCH } else { AT_POINT };
        let mut all = Wheels { search: 0.0, normal: 0.0, creep: 0.0 };
        for wheel in model.wheels() {
            all.add(model, &workspace, &wheel, (normal, creep));
        }
        if model.formulation.points_per_wheel() > 1 {
            all.search += NODES * workspace.work.search_iterations as f64;
        }
        let (bodies, constrains) = (model.system.bodies.len() as f64, model.formulation.constrains());
        if constrains {
            // Each round of the balance calls both laws; what was added for each contact is one of them.
            let rounds = workspace.work.force_iterations as f64;
            let constrained = model.contacts() as f64;
            (all.normal, all.creep) = (all.normal * (rounds / constrained).max(1.0), all.creep * (rounds / constrained).max(1.0));
            all.search += CONSTRAINED * constrained + BALANCE * rounds;
        }
        let rows = workspace.system.constraints.joint_rows as f64;
        let stations = if model.track.line().is_some() { bodies + model.contacts() as f64 } else { 0.0 };
        let equations = BODY * bodies + JOINT_ROW * rows;
        let parts = vec![
            (Part::ContactSearch, if constrains { 0.0 } else { all.search }),
            (Part::NormalLaw, all.normal),
            (Part::CreepLaw, all.creep),
            (Part::Track, STATION * stations),
            (Part::Forces, ELEMENT * model.system.forces.len() as f64),
            (Part::EquationsOfMotion, if constrains { 0.0 } else { equations }),
            (Part::ContactAndEquations, if constrains { all.search + equations } else { 0.0 }),
        ];
        Some(Counted { parts })
    }
}

/// What wheels take.
struct Wheels {
    search: f64,
    normal: f64,
    creep: f64,
}

impl Wheels {
    fn add(&mut self, model: &Model, workspace: &Workspace, wheel: &WheelRef, (normal, creep): (f64, f64)) {
        let of = || workspace.reports(wheel.contact);
        let loaded = of().filter(|report| report.normal_force > 0.0).count() as f64;
        self.search += WHEEL;
        if model.laws.patch == PatchLaw::Linear {
            self.normal += LINEAR;
            return;
        }
        if model.laws.patch == PatchLaw::Exact {
            self.normal += HALF_SPACES;
            self.creep += creep;
            return;
        }
        let constrained = of().any(|report| report.constrained);
        // A report without iterations belongs to no place.
        let places = of().filter(|report| report.iterations > 0 || report.penetration != 0.0).count() as f64;
        if model.formulation.points_per_wheel() == 1 && !constrained {
            self.search += PLACE * places + if model.searches_contacts(wheel.contact) { SEARCHED } else { 0.0 };
        }
        if !constrained {
            self.search += LOADED * loaded;
        }
        if model.deflection_states() > 0 {
            self.creep += TRANSIENT * loaded;
        }
        if !model.laws.patch.forms() {
            self.normal += normal * loaded;
            self.creep += creep * loaded;
            return;
        }
        if !(loaded > 0.0) {
            return;
        }
        let pair = wheel.pair(model, &workspace.system.motions[wheel.wheelset.turning[wheel.side.index()]]);
        let Some(strips) = workspace.pressed_strips(wheel.contact, &pair) else {
            self.normal += TABLE;
            self.creep += creep + UNEVEN / 2.0;
            return;
        };
        let strips = strips as f64;
        // Parts, and where there are several what they make together.
        let mixed = 2.0 * loaded - 1.0;
        self.normal += STRIP * strips + STRIPS * strips * strips + SUMS * strips * mixed;
        self.creep += (creep + UNEVEN) * mixed;
    }
}
