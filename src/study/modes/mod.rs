//! Small motions about steady running: eigenvalues and shapes of the linearised equations, and how they change with speed.
//!
//! The steady state is that of the scene's start on undisturbed track, straight or a constant curve ([`turning`]), without what the scene adds to it. About it the whole model, with contact
//! search, normal and creep laws as they are, is differenced ([`slopes`]), put onto its constraints and freed of what has no influence ([`reduction`]):
//!
//! ```text
//! y = y0 + D Q u,   u' = A u,   A u = lambda u
//! ```
//!
//! A pair `lambda = a +- i w` is a mode of frequency `w / 2 pi`, growth rate `a` and damping `-a / |lambda|` of critical. Shares of a shape are those
//! of the kinetic energy ([`shape`]). Eigenvalues along a sweep of speeds and the speeds from which on motions grow stand in [`locus`].

mod across;
mod harmonic;
pub mod locus;
mod reduction;
pub mod rest;
pub mod shape;
mod slopes;
mod turning;

use crate::contact::patch::PatchLaw;
use crate::formulation::flexibility::Flexibility;
use crate::formulation::{self, EvaluationError, Model};
use crate::geometry::track::centre_line::{Alignment, CentreLine};
use crate::mbs::body::COORDINATES;
use crate::scene::spec::Scene;
use crate::scene::start::{self, Start};
use crate::sim::statics::{ElementForce, statics};
use crate::sim::{Simulation, SimulationError};
use faer::{Mat, c64};
use nalgebra::Vector3;
use reduction::Reduction;
use serde::Serialize;
use shape::Part;
use slopes::Neighbourhood;
use std::f64::consts::TAU;
use std::sync::Arc;
use turning::Turning;

/// Why there are no modes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModesError {
    #[error(
        "at {speed} m/s: the vehicle starts {place}; expected {expected}: choose vehicle.initial.distance so that all of it stands there, or --set track.node=[]"
    )]
    Place { speed: f64, place: &'static str, expected: &'static str },
    #[error("at {speed} m/s in a curve: {why}")]
    InCurve { speed: f64, why: &'static str },
    #[error("at {speed} m/s: {cause}")]
    NoStart { speed: f64, cause: SimulationError },
    #[error("at {speed} m/s, beside the steady state: {cause}")]
    Beside { speed: f64, cause: EvaluationError },
    #[error("at {speed} m/s: wheels of a wheelset that swings across by {} mm don't keep their loads (off by {:.0} %): a flange or the end of a profile carries; expected a smaller amplitude", 1e3 * amplitude, 100.0 * off)]
    TooWide { speed: f64, amplitude: f64, off: f64 },
    #[error(
        "an amplitude needs elastic contact (contact.formulation = \"ECF-A\" or \"ECF-N\"): a rigid contact jumps from place to place on the way across; expected none"
    )]
    Rigid,
    #[error(
        "contact.patch = \"exact\" has no slopes: on its grid forces scatter by some thousandths of friction times load, more than small motions change them; expected contact.patch = \"strips\" \
         with another creep law"
    )]
    OnGrid,
    #[error("at {speed} m/s: the eigenvalues of {size} equations were not found")]
    NoEigenvalues { speed: f64, size: usize },
}

/// One mode, or an aperiodic motion.
#[derive(Clone, Debug, Serialize)]
pub struct Mode {
    /// What moves, in words.
    pub name: String,
    /// Hz; 0 of an aperiodic motion.
    pub frequency: f64,
    /// Real part of the eigenvalue, 1/s; below 0 the motion dies away.
    pub growth: f64,
    /// Imaginary part, rad/s; 0 of an aperiodic motion.
    pub angular_frequency: f64,
    /// Damping in parts of the critical one, -.
    pub damping: f64,
    /// By how much the eigenvalue changes with differences of twice the length, 1/s.
    pub uncertainty: f64,
    /// Do wheelsets roll along their wave with less slip than their yaw would make?
    pub hunting: bool,
    /// Does it neither grow nor die away, nor swing: a neighbouring steady state?
    pub neutral: bool,
    /// Largest first.
    pub parts: Vec<Part>,
    /// The state's share in the motion at time 0, m, rad, m/s, rad/s, as real and imaginary parts; the largest kinetic part has the phase 0.
    #[serde(skip)]
    pub shape: Vec<[f64; 2]>,
}

/// All of a steady state.
#[derive(Clone, Debug, Serialize)]
pub struct Modes {
    /// V, m/s.
    pub speed: f64,
    /// By which wheelsets swing across for equivalent slopes, m; 0: slopes at the steady state.
    pub amplitude: f64,
    /// Modes by frequency, then aperiodic motions, the slowest first.
    pub modes: Vec<Mode>,
    /// What was left out because nothing depends on it or it is imposed, in words.
    pub left_out: Vec<String>,
    /// States of the model, and those of free motion.
    pub states: usize,
    pub free: usize,
    /// Largest acceleration in the steady state that should be none, m/s2 or rad/s2.
    pub unbalanced: f64,
    /// Do inputs of elements begin with values that have no steady state, so that modes are those of a vehicle that coasts?
    pub coasts: bool,
    /// What stands for a track that is a beam, in words.
    pub track: Option<String>,
    /// Where contact forces have no slopes that add up: by how much at most that changed a growth, 1/s ([`harmonic`]).
    pub kinked: Option<f64>,
    /// Stops that stand at an end of their free travel: motions on both sides of it are others.
    pub at_ends: Vec<String>,
}

impl Mode {
    /// Takes an eigenvalue, 1/s.
    fn put(&mut self, value: c64) {
        let size = value.norm();
        (self.growth, self.angular_frequency, self.frequency) = (value.re, value.im, value.im / TAU);
        self.damping = if size > 0.0 { -value.re / size } else { 0.0 };
    }

    /// Does it grow, by more than it may be off?
    pub fn grows(&self) -> bool {
        self.growth > self.uncertainty && !self.neutral
    }
}

impl Modes {
    /// Those that grow.
    pub fn growing(&self) -> impl Iterator<Item = &Mode> {
        self.modes.iter().filter(|mode| mode.grows())
    }

    /// The swinging mode that has just begun to grow with this frequency [Hz]; without one that of hunting.
    pub fn begins(&self, frequency: Option<f64>) -> Option<&Mode> {
        let swinging = || self.growing().filter(|mode| mode.frequency > 0.0);
        let nearest = |wanted: f64| swinging().min_by(|a, b| (a.frequency - wanted).abs().total_cmp(&(b.frequency - wanted).abs()));
        frequency.and_then(nearest).or_else(|| self.hunting())
    }

    /// The swinging mode that grows most; where none does, that of hunting.
    pub fn leads(&self) -> Option<&Mode> {
        self.growing().filter(|mode| mode.frequency > 0.0).max_by(|a, b| a.growth.total_cmp(&b.growth)).or_else(|| self.hunting())
    }

    /// The mode that grows most, or dies away most slowly, among those of hunting.
    pub fn hunting(&self) -> Option<&Mode> {
        self.modes.iter().filter(|mode| mode.hunting).max_by(|a, b| a.growth.total_cmp(&b.growth))
    }

    /// Swinging modes, the least damped first.
    pub fn by_damping(&self) -> Vec<&Mode> {
        let mut modes: Vec<&Mode> = self.modes.iter().filter(|mode| mode.frequency > 0.0).collect();
        modes.sort_by(|a, b| a.damping.total_cmp(&b.damping));
        modes
    }
}

/// Below this, 1/s, an eigenvalue is none; and the part of an eigenvalue that its imaginary part must be, or it is a double real one apart by
/// rounding.
const NEUTRAL: f64 = 1e-3;
const SWINGS: f64 = 1e-3;

/// Accelerations of a steady state, m/s2 or rad/s2.
pub const STEADY: f64 = 1e-3;
/// Part of their loads to which wheels must keep them where wheelsets swing.
const KEPT: f64 = 0.01;

/// The scene at a speed [m/s] on straight, undisturbed track (rails that lie aside for good stay so), without what it adds to the steady state at its start.
///
/// # Errors
/// [`ModesError::Place`].
pub fn undisturbed(scene: &Scene, speed: f64) -> Result<Scene, ModesError> {
    straight(scene, speed)?;
    with_stand_in(scene, speed).map(|(scene, _)| scene)
}

/// Does the vehicle start on a straight?
fn straight(scene: &Scene, speed: f64) -> Result<(), ModesError> {
    let place = match start::start(scene) {
        Start::Straight => return Ok(()),
        Start::Curve(node) if node.curvature == 0.0 => "on superelevated or climbing track",
        Start::Curve(_) => "in a curve",
        Start::Transition { .. } => "on a transition",
    };
    Err(ModesError::Place { speed, place, expected: "a straight without superelevation" })
}

/// The same on the track of its start, straight or a constant curve, and what stands for a track that is a beam, in words.
fn with_stand_in(scene: &Scene, speed: f64) -> Result<(Scene, Option<String>), ModesError> {
    let curve = match start::start(scene) {
        Start::Straight => None,
        Start::Curve(node) if node.curvature == 0.0 && node.grade != 0.0 => {
            return Err(ModesError::Place { speed, place: "on a straight climb", expected: "level track or a constant curve" });
        }
        Start::Curve(node) => Some(node),
        Start::Transition { .. } => {
            return Err(ModesError::Place { speed, place: "on a transition", expected: "a straight or a constant curve" });
        }
    };
    let mut scene = scene.clone();
    scene.vehicle = scene.vehicle.steady();
    scene.vehicle.speed = speed;
    let alignment = scene.track.alignment.take().zip(curve).map(|(alignment, node)| Alignment { nodes: vec![node], ..alignment });
    scene.track.line = alignment.as_ref().and_then(|alignment| CentreLine::new(alignment, Vector3::zeros(), 0.0)).map(Arc::new);
    // In a curve the balance on displaced rails is not exact enough.
    scene.track.deviations = if curve.is_none() { start::constant_displacements(&scene).unwrap_or_default() } else { Vec::new() };
    (scene.track.alignment, scene.track.start_fade) = (alignment, None);
    let (flexibility, words) = stand_in(&scene, speed).unzip();
    scene.track.flexibility = flexibility;
    // Friction that changes along the track is what it is at the start; else differences are more exact near the origin.
    let distance = if scene.contact.friction_map.is_some() { start::origin(&scene) } else { 0.0 };
    scene.vehicle.initial.from_equilibrium = true;
    scene.vehicle.initial.values = [0.0; 10];
    scene.vehicle.initial.values[0] = distance;
    scene.vehicle.wheelsets.iter_mut().for_each(|wheelset| wheelset.offset = [0.0; 2]);
    Ok((scene, words.flatten()))
}

/// Over sleepers nothing is steady: a track that is a beam has a stand-in, with its words.
fn stand_in(scene: &Scene, speed: f64) -> Option<(Flexibility, Option<String>)> {
    let wheelsets = &scene.vehicle.wheelsets;
    let places: Vec<f64> = wheelsets.iter().map(|placed| placed.x).collect();
    let unsprung = wheelsets.iter().map(|placed| 0.5 * placed.spec.mass).sum::<f64>() / wheelsets.len().max(1) as f64;
    scene.track.flexibility.map(|track| track.in_modes(&places, speed, unsprung))
}

/// A simulation in the steady state of an undisturbed scene: that in which what elements begin with (torques of motors and brakes) is balanced too; where there is none, without.
///
/// # Errors
/// [`ModesError::NoStart`].
pub fn steady(scene: &Scene, speed: f64) -> Result<Simulation, ModesError> {
    let start = |scene: &Scene| Simulation::new(scene, 0.0).map_err(|cause| ModesError::NoStart { speed, cause });
    let mut driven = scene.clone();
    driven.vehicle.initial.driven = true;
    if let Ok(mut simulation) = start(&driven)
        && (is_neutral(&simulation) || remaining(&mut simulation) < STEADY)
    {
        return Ok(simulation);
    }
    let mut coasting = start(scene)?;
    for (index, value) in coasting.model().neutral_inputs().into_iter().enumerate() {
        coasting.set_input(index, value, 0.0, 0.0);
    }
    Ok(coasting)
}

/// The largest acceleration of a simulation as it stands, beside that of a steady curve, m/s2 or rad/s2; infinite where it can't be evaluated.
fn remaining(simulation: &mut Simulation) -> f64 {
    let bodies = simulation.model().system.bodies.len();
    let Ok(snapshot) = simulation.snapshot() else { return f64::INFINITY };
    let mut rates = snapshot.dy.clone();
    if let Some(turning) = Turning::of(bodies, &snapshot.y) {
        turning.take_off(&snapshot.y, &mut rates);
    }
    unbalanced(bodies, &rates)
}

/// Does nothing begin with an input?
fn is_neutral(simulation: &Simulation) -> bool {
    simulation.model().start_inputs() == simulation.model().neutral_inputs()
}

/// States on which nothing depends in a simulation's present state: the turn of wheelsets about their axles, states that only count.
///
/// # Errors
/// Where the model can't be evaluated.
pub fn indifferent(simulation: &Simulation) -> Result<Vec<usize>, EvaluationError> {
    let state = simulation.state();
    reduction::indifferent(&mut Neighbourhood::new(
        simulation.model(),
        &state.integration.y,
        &state.memories.accepted,
        simulation.model().start_inputs(),
    ))
}

/// Modes of a scene's vehicle at a speed [m/s].
///
/// # Errors
/// [`ModesError`].
pub fn modes(scene: &Scene, speed: f64) -> Result<Modes, ModesError> {
    modes_over(scene, speed, 0.0)
}

/// The same where wheelsets swing across by an `amplitude` [m]: equivalent slopes, by harmonic linearisation.
///
/// # Errors
/// [`ModesError`].
pub fn modes_over(scene: &Scene, speed: f64, amplitude: f64) -> Result<Modes, ModesError> {
    if scene.contact.patch.law == PatchLaw::Exact {
        return Err(ModesError::OnGrid);
    }
    if amplitude > 0.0 {
        straight(scene, speed)?;
    }
    let (scene, track) = with_stand_in(scene, speed)?;
    let no_start = |cause| ModesError::NoStart { speed, cause };
    let mut simulation = steady(&scene, speed)?;
    let held = simulation.snapshot().map_err(no_start)?.inputs().to_vec();
    let coasts = !is_neutral(&simulation) && held == simulation.model().neutral_inputs();
    let at_ends = at_ends(&scene, &mut simulation).map_err(no_start)?;
    let model = simulation.model();
    if amplitude > 0.0 && model.formulation.constrains() {
        return Err(ModesError::Rigid);
    }
    let state = simulation.state();
    let beside = |cause| ModesError::Beside { speed, cause };
    let mut here = Neighbourhood::new(model, &state.integration.y, &state.memories.accepted, held).turning_with_it();
    if let Some(why) = no_modes_in_curves(&scene, model).filter(|_| here.turning.is_some()) {
        return Err(ModesError::InCurve { speed, why });
    }
    let mut slopes = |length: f64| {
        let mut linear = here.linear(length)?;
        if amplitude > 0.0 {
            here.swing((length, amplitude), &mut linear)?;
        }
        Ok(linear)
    };
    let (linear, coarse) = (slopes(1.0).map_err(beside)?, slopes(2.0).map_err(beside)?);
    if !(linear.off < KEPT) {
        return Err(ModesError::TooWide { speed, amplitude, off: linear.off });
    }
    let reduction = Reduction::new(&mut here, &linear).ok_or(ModesError::NoEigenvalues { speed, size: linear.size() })?;
    let matrix = reduction.matrix(&linear);
    let size = matrix.nrows();
    let no_values = |_| ModesError::NoEigenvalues { speed, size };
    let eigen = matrix.eigen().map_err(no_values)?;
    let others: Vec<c64> = reduction.matrix(&coarse).eigenvalues().map_err(no_values)?;
    let values = eigen.S().column_vector();
    let mut modes = Vec::new();
    for k in 0..size {
        let value = values[k];
        let swings = value.norm() > NEUTRAL && value.im.abs() > SWINGS * value.norm();
        if value.im >= 0.0 || !swings {
            let mut shape = reduction.full(|row| eigen.U()[(row, k)]);
            here.turning.iter().for_each(|turning| turning.onto_courses(&mut shape));
            modes.push((k, mode(model, speed, if swings { value } else { c64::new(value.re, 0.0) }, &others, shape)));
        }
    }
    let kinked = match amplitude {
        0.0 => harmonic::add_what_slopes_leave_out(&mut here, (&matrix, &reduction), eigen.U(), &mut modes).map_err(beside)?,
        _ => None,
    };
    let mut modes: Vec<Mode> = modes.into_iter().map(|(_, mode)| mode).collect();
    modes.sort_by(|a, b| {
        let aperiodic = |mode: &Mode| mode.angular_frequency == 0.0;
        aperiodic(a).cmp(&aperiodic(b)).then(a.frequency.total_cmp(&b.frequency)).then(b.growth.total_cmp(&a.growth))
    });
    Ok(Modes {
        speed,
        amplitude,
        modes,
        states: linear.size(),
        free: size,
        unbalanced: unbalanced(model.system.bodies.len(), &linear.rates),
        coasts,
        track,
        kinked,
        at_ends,
        left_out: reduction.left_out,
    })
}

/// Why a vehicle has no modes in a curve.
fn no_modes_in_curves(scene: &Scene, model: &Model) -> Option<&'static str> {
    if model.system.drives.is_empty() {
        return Some(
            "what rolls freely slows down there, so that nothing is steady; expected an imposed speed (vehicle.travel = \"imposed\")",
        );
    }
    (scene.contact.formulation_name == formulation::CONSTRAINTS[0]).then_some(
        "places of contact of ACCF go along the rail as states, which the turning axes don't know; expected contact.formulation = \"ECCF\", whose motion is the same",
    )
}

fn mode(model: &Model, speed: f64, value: c64, others: &[c64], shape: Vec<c64>) -> Mode {
    let uncertainty = others.iter().map(|other| (other - value).norm()).fold(f64::INFINITY, f64::min);
    let neutral = value.norm() < NEUTRAL;
    let found = shape::describe(model, speed, value, shape);
    let mut mode = Mode {
        frequency: 0.0,
        growth: 0.0,
        angular_frequency: 0.0,
        damping: 0.0,
        uncertainty,
        hunting: found.hunting,
        neutral,
        name: if neutral { format!("{} (neutral)", found.name) } else { found.name },
        parts: found.parts,
        shape: found.shape.iter().map(|part| [part.re, part.im]).collect(),
    };
    mode.put(value);
    mode
}

/// Nearer than this to an end of its free travel a stop is at it, m: some lengths of differences.
const AT_END: f64 = 1e-6;

/// Names of the stops that stand at an end of their free travel.
fn at_ends(scene: &Scene, simulation: &mut Simulation) -> Result<Vec<String>, SimulationError> {
    let found = statics(scene, simulation)?;
    let stands = |element: &&ElementForce| {
        let ends = element.free_travel.iter().flatten().flatten();
        !element.turns && ends.into_iter().any(|end| (element.displacement - end).abs() < AT_END)
    };
    Ok(found.elements.iter().filter(stands).map(|element| element.name.clone()).collect())
}

/// Largest acceleration of a body at the steady state.
fn unbalanced(bodies: usize, rates: &[f64]) -> f64 {
    let count = COORDINATES * bodies;
    rates[count..2 * count].iter().fold(0.0, |most, rate| f64::max(most, rate.abs()))
}

/// A dense matrix.
type Dense = Mat<f64>;
