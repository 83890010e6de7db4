//! What a right-hand side and a Jacobian consist of: evaluations made again in parts, each part by itself.
//!
//! The whole; the laws of contact with the contacts' own arguments, as often as the evaluation calls them (counters of the workspace tell);
//! places on a curved track; the bodies' motion with the force elements; the equations of motion. The normal law of a patch of strips is what presses
//! them. Contact search is what is left: places, surfaces' geometry, slip (of each strip too), summing up of wrenches. Constraint formulations solve the equations of motion together with the contacts, so both
//! stay together there. Of several times the shortest counts: others on the machine make some calls longer, none shorter.

use super::Part;
use crate::contact::creep::RollingContact;
use crate::contact::creepage::in_rolling_direction;
use crate::contact::normal::damping::damped_force;
use crate::contact::patch::PatchLaw;
use crate::contact::search::algebraic::Pair;
use crate::contact::strips::{RailStrips, Scratch, press};
use crate::formulation::memory::ModelMemory;
use crate::formulation::step::WheelRef;
use crate::formulation::{ContactReport, Evaluation, Model, Workspace};
use crate::sim::Snapshot;
use std::hint::black_box;
use std::time::Instant;

/// An evaluation: where a step may look, from the state with whose warm starts it begins.
#[derive(Clone, Debug)]
pub struct Sample {
    pub t: f64,
    pub y: Vec<f64>,
    pub memory: ModelMemory,
    pub inputs: Vec<f64>,
}

impl Sample {
    /// Half a step [s] behind a snapshot, and as far off as rounding never is: warm starts must not be exact.
    pub fn behind(snapshot: &Snapshot, coordinates: usize, step: f64) -> Sample {
        const OFF: f64 = 1e-6;
        let moved = |(i, (y, rate)): (usize, (&f64, &f64))| y + 0.5 * step * rate + if i < coordinates { OFF } else { 0.0 };
        let y = snapshot.y.iter().zip(&snapshot.dy).enumerate().map(moved).collect();
        Sample { t: snapshot.time, y, memory: snapshot.memory().clone(), inputs: snapshot.inputs().to_vec() }
    }
}

/// Times of the parts, s; of several evaluations their sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anatomy {
    /// Of all of a right-hand side.
    pub whole: f64,
    pub normal: f64,
    pub creep: f64,
    pub track: f64,
    pub forces: f64,
    /// 0 where contacts are constraints.
    pub equations: f64,
    /// Of all of a Jacobian, and of its contacts alone; 0 where none is asked for.
    pub jacobian: f64,
    pub jacobian_contacts: f64,
}

/// No further evaluation after so long, s: the creep law `exact` takes milliseconds.
const LONG: f64 = 2.0;

impl Anatomy {
    /// Of evaluations of a model; with Jacobians where `linearises`.
    pub fn of(model: &Model, samples: &[Sample], linearises: bool) -> Anatomy {
        let mut workspace = model.workspace();
        if linearises {
            model.prepare_tangent(&mut workspace);
        }
        let clock = Instant::now();
        let mut sum = Anatomy::default();
        for (place, sample) in samples.iter().enumerate() {
            if place > 0 && clock.elapsed().as_secs_f64() > LONG {
                break;
            }
            // Not all that is asked for has an answer.
            if let Some(one) = one(model, &mut workspace, sample, linearises) {
                sum.whole += one.whole;
                sum.normal += one.normal;
                sum.creep += one.creep;
                sum.track += one.track;
                sum.forces += one.forces;
                sum.equations += one.equations;
                sum.jacobian += one.jacobian;
                sum.jacobian_contacts += one.jacobian_contacts;
            }
        }
        sum
    }

    /// Of the right-hand side, what the parts by themselves leave, s; less than nothing where they were measured as more than the whole.
    fn rest(&self) -> f64 {
        self.whole - (self.normal + self.creep + self.track + self.forces + self.equations)
    }

    /// Parts of the right-hand side, s; none less than nothing, and their sum is the whole (of what was measured apart, where that is more).
    pub fn right_hand_side(&self) -> [(Part, f64); 7] {
        let rest = self.rest().max(0.0);
        let (search, together) = if self.equations > 0.0 { (rest, 0.0) } else { (0.0, rest) };
        [
            (Part::ContactSearch, search),
            (Part::NormalLaw, self.normal),
            (Part::CreepLaw, self.creep),
            (Part::Track, self.track),
            (Part::Forces, self.forces),
            (Part::EquationsOfMotion, self.equations),
            (Part::ContactAndEquations, together),
        ]
    }

    /// Of a Jacobian, that which force elements take.
    pub fn of_forces(&self) -> f64 {
        if self.jacobian > 0.0 { (1.0 - self.jacobian_contacts / self.jacobian).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// What speaks against the parts: on a busy machine they may be more than the whole.
    pub fn doubt(&self) -> Option<String> {
        (self.rest() < 0.0).then(|| {
            let sum = 100.0 * (1.0 - self.rest() / self.whole);
            format!("the parts of a right-hand side were measured as {sum:.0} % of it")
        })
    }
}

/// Seconds per call, the least of several batches that are long against the clock's steps; a slow call is made once.
pub fn per_call<T>(mut call: impl FnMut() -> T) -> f64 {
    const BATCH: f64 = 20e-6;
    const BATCHES: usize = 7;
    const SLOW: f64 = 5e-3;
    let mut batch = |calls: u32| {
        let clock = Instant::now();
        (0..calls).for_each(|_| drop(black_box(call())));
        clock.elapsed().as_secs_f64() / f64::from(calls)
    };
    let first = batch(1);
    if first > SLOW {
        return first;
    }
    let calls = (BATCH / batch(4).max(1e-9)).ceil() as u32;
    (0..BATCHES).map(|_| batch(calls)).fold(f64::INFINITY, f64::min)
}

/// The parts of one evaluation; `None` where it has no answer.
fn one(model: &Model, workspace: &mut Workspace, sample: &Sample, linearises: bool) -> Option<Anatomy> {
    let (y, inputs) = (sample.y.as_slice(), sample.inputs.as_slice());
    let (mut memory, mut moved, mut dy) = (sample.memory.clone(), sample.memory.clone(), vec![0.0; model.dimension()]);
    let mut derivative = |workspace: &mut Workspace| {
        memory.clone_from(&sample.memory);
        let at = Evaluation { t: sample.t, inputs, y: black_box(y), memory: &mut memory };
        model.derivative(workspace, at, &mut dy).is_ok()
    };
    let before = workspace.work.force_iterations;
    if !derivative(workspace) {
        return None;
    }
    // Constraints call the laws again and again for the balance of normal and creep forces.
    let loops = workspace.work.force_iterations - before;
    let whole = per_call(|| derivative(workspace));
    let (normal, creep) = laws(model, workspace, loops);
    let mut jacobian = |forces: bool| match linearises {
        true => per_call(|| model.linearise(workspace, (black_box(y), &sample.memory), inputs, forces)),
        false => 0.0,
    };
    let (jacobian, jacobian_contacts) = (jacobian(true), jacobian(false));
    let system = &model.system;
    let equations = per_call(|| system.constrained_derivative(sample.t, black_box(y), &mut workspace.system, &mut dy).is_ok());
    let motion = per_call(|| system.move_bodies(black_box(y), &mut workspace.system));
    let stations = per_call(|| model.move_bodies(black_box(y), &mut moved, &mut workspace.system));
    let track = if model.track.line().is_some() { (stations - motion).max(0.0) } else { 0.0 };
    let forces = (per_call(|| model.apply_forces(black_box(y), &mut moved, &mut workspace.system)) - track).max(0.0);
    let equations = if model.formulation.constrains() { 0.0 } else { equations };
    Some(Anatomy { whole, normal, creep, track, forces, equations, jacobian, jacobian_contacts })
}

/// What the normal and the creep law take in an evaluation that was just made, s; of constraints in so many `loops`.
fn laws(model: &Model, workspace: &Workspace, loops: u64) -> (f64, f64) {
    let reports = |contact: usize| workspace.reports(contact).filter(|report| report.normal_force > 0.0);
    let constrained = model.wheels().flat_map(|wheel| reports(wheel.contact)).filter(|report| report.constrained).count();
    let again = loops as f64 / constrained.max(1) as f64;
    let (mut normal, mut creep) = (0.0, 0.0);
    let material = model.laws.material;
    for WheelRef { wheelset, side, contact } in model.wheels() {
        let motion = &workspace.system.motions[wheelset.body];
        let (wheel, rail, speed) = (wheelset.wheel(side), model.track.rail(side), wheelset.speed(motion));
        let pair = Pair { wheel, rail, centre: &motion.position, axes: &motion.frame.axes, distance: motion.distance };
        if model.laws.patch == PatchLaw::Linear {
            // One formula from pose to force: contact as a whole.
            continue;
        }
        if model.laws.patch.forms() {
            let rail = RailStrips::new(rail, model.wheelsets.iter().map(|wheelset| wheelset.wheel(side)));
            let mut scratch = Scratch::new(rail.len());
            let places = || reports(contact).map(ContactReport::near);
            normal += per_call(|| press(black_box(&pair), &rail, places(), material, &mut scratch).len());
        }
        for report in reports(contact) {
            let times = if report.constrained { again } else { 1.0 };
            creep += times * per_call(|| creep_force(model, report, speed));
            if model.laws.patch.forms() {
                continue;
            }
            let Ok(found) = pair.locate(&report.parameters) else { continue };
            let shape = found.shape(wheel, rail);
            let penetration = match report.constrained {
                true => model.laws.normal.contact_under(&shape, report.normal_force).map_or(0.0, |found| found.0),
                false => report.penetration,
            };
            let force = || {
                let elastic = model.laws.normal.contact(black_box(&shape), penetration).ok()?;
                Some(damped_force(model.laws.damping.as_ref(), elastic.force, penetration, report.penetration_rate))
            };
            normal += times * per_call(force);
        }
    }
    (normal, creep)
}

fn creep_force(model: &Model, report: &ContactReport, speed: f64) -> f64 {
    let ContactReport { patch, normal_force, .. } = *report;
    let (friction, speed) = (model.laws.friction, speed.abs());
    let law = |creepage| model.laws.creep.force(&RollingContact { patch, normal_force, friction, creepage, speed });
    in_rolling_direction(1.0, black_box(report.creepage), law).longitudinal
}
