//! What moves in a mode, in words.
//!
//! A part is one coordinate of one body, the rotor of a motor or the twist of an axle; its share is that of the mode's kinetic energy, `m |v|^2` or `I |w|^2`. Parts that move alike in several bodies
//! (the leading and the trailing truck) are named together. A body that sways and rolls about a pole below its centre does the lower sway, about one
//! above it the upper sway.
//!
//! *Hunting* is rolling along a wave: the axle's lateral velocity is that of its yaw times the travelling speed, but for slip. A mode counts as one of hunting
//! where it is lateral (sway, roll, yaw have most of the energy), swings, wheelsets have at least a twentieth of the energy in their sway and yaw, and the one that moves
//! most slips less than half of what its yaw would make.

use crate::formulation::{Model, Wheelset};
use crate::mbs::body::{COORDINATES, LATERAL, ROLL, YAW};
use crate::mbs::inertia::Inertia;
use faer::c64;
use serde::Serialize;

/// One coordinate of one body.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// Or the element that has a mass of its own.
    pub body: String,
    /// "x", "y", "z", "yaw", "roll" or "pitch"; "rotor" or "twist".
    pub coordinate: &'static str,
    /// Of the kinetic energy, -.
    pub share: f64,
    /// Before the largest part, rad.
    pub phase: f64,
}

/// A mode in words, with its shape turned to the phase of the largest part.
pub(super) struct Described {
    pub name: String,
    pub parts: Vec<Part>,
    pub hunting: bool,
    pub shape: Vec<c64>,
}

const COORDINATE_NAMES: [&str; COORDINATES] = ["x", "y", "z", "yaw", "roll", "pitch"];
const MOTIONS: [&str; COORDINATES] = ["longitudinal", "lateral", "bounce", "yaw", "roll", "pitch"];
/// Shares below this are not told; a body whose part of a motion is this part of the largest is named with it; what makes a mode lateral.
const TOLD: f64 = 0.01;
const WITH: f64 = 0.3;
const MOSTLY: f64 = 0.5;
/// A roll or sway with this share belongs to a combined sway.
const SWAYS: f64 = 0.03;
/// Slip in parts of yaw times speed up to which a wheelset rolls along its wave.
const ROLLS: f64 = 0.5;
/// Squares of velocities that are none, in parts of those of displacements, 1/s2.
const AT_REST: f64 = 1e-6;
/// Bodies that move by this part of a state, SI, only do so by rounding: states are lengths and forces (up to 1e7 times a motion).
const ROUNDING: f64 = 1e-10;
/// What swings less than this part of its eigenvalue dies away or grows before it has gone along any wave.
const SWINGS: f64 = 0.03;
/// Share of the wheelsets' sway and yaw, taken together, from which on they hunt and are not only shaken.
const TAKES_PART: f64 = 0.05;

/// Masses and moments of inertia of all coordinates, kg and kg m2.
fn inertias(model: &Model) -> Vec<f64> {
    let of = |body: &crate::mbs::body::Body| {
        let [roll, pitch, yaw] = match &body.inertia {
            Inertia::Revolution { transverse, axial } | Inertia::NotGyroscopic { transverse, axial } => [*transverse, *axial, *transverse],
            Inertia::General { principal } => [principal.x, principal.y, principal.z],
        };
        [body.mass, body.mass, body.mass, yaw, roll, pitch]
    };
    model.system.bodies.iter().flat_map(of).collect()
}

/// An element with a mass of its own: its name, what its velocity is called, that state, and the inertia that goes with it (SI).
struct OwnMass<'a> {
    element: &'a str,
    word: &'static str,
    state: usize,
    inertia: f64,
}

fn own_masses(model: &Model) -> Vec<OwnMass<'_>> {
    let system = &model.system;
    let of = |number: usize| {
        let element = system.forces[number].as_ref();
        let (state, word, inertia) = element.own_inertia()?;
        Some(OwnMass { element: element.name(), word, state: system.states_of_force(number).start + state, inertia })
    };
    (0..system.forces.len()).filter_map(of).collect()
}

pub(super) fn describe(model: &Model, speed: f64, value: c64, mut shape: Vec<c64>) -> Described {
    let count = COORDINATES * model.system.bodies.len();
    let own = largest_beside(&shape[2 * count..], shape[..2 * count].iter().map(|part| part.norm()).fold(0.0, f64::max));
    if let Some(state) = own {
        return Described { name: owner(model, 2 * count + state), parts: Vec::new(), hunting: false, shape };
    }
    let (inertias, masses) = (inertias(model), own_masses(model));
    let weighed =
        |begin: usize| -> Vec<f64> { inertias.iter().zip(&shape[begin..]).map(|(inertia, part)| inertia * part.norm_sqr()).collect() };
    let sum = |parts: &[f64]| parts.iter().sum::<f64>();
    let (displaced, mut moving) = (weighed(0), weighed(count));
    moving.extend(masses.iter().map(|own| own.inertia * shape[own.state].norm_sqr()));
    // A neighbouring place of rest has displacements and no velocities.
    let (begin, energies) = if sum(&moving) > AT_REST * sum(&displaced) { (count, moving) } else { (0, displaced) };
    let total = sum(&energies);
    let shares: Vec<f64> = energies.iter().map(|energy| energy / total).collect();
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|a, b| shares[*b].total_cmp(&shares[*a]));
    let largest = order[0];
    let state = |i: usize| i.checked_sub(count).map_or(begin + i, |own| masses[own].state);
    let scale = shape[state(largest)].norm();
    if scale > 0.0 {
        let turn = shape[state(largest)].conj() / (scale * scale);
        shape.iter_mut().for_each(|part| *part *= turn);
    }
    let moves = &shape[begin..begin + count];
    let part = |i: usize| {
        let (body, coordinate) = match i.checked_sub(count) {
            None => (model.system.bodies[i / COORDINATES].name.clone(), COORDINATE_NAMES[i % COORDINATES]),
            Some(own) => (masses[own].element.to_string(), masses[own].word),
        };
        Part { body, coordinate, share: shares[i], phase: shape[state(i)].arg() }
    };
    let parts = order.iter().copied().take_while(|i| shares[*i] > TOLD).map(part).collect();
    let lateral =
        [LATERAL, YAW, ROLL].iter().flat_map(|axis| shares[..count].iter().skip(*axis).step_by(COORDINATES)).sum::<f64>() > MOSTLY;
    let part_of = |wheelset: &Wheelset| [LATERAL, YAW].map(|axis| shares[COORDINATES * wheelset.body + axis]).iter().sum::<f64>();
    let takes_part = model.wheelsets.iter().map(part_of).sum::<f64>() > TAKES_PART;
    let hunting = value.im > SWINGS * value.norm() && lateral && takes_part && rolls_along(model, speed, moves, value);
    let name = if let Some(own) = largest.checked_sub(count) {
        format!("{}: {}", masses[own].element, masses[own].word)
    } else if total > 0.0 {
        name(model, &shares, moves, largest)
    } else {
        "states beside the bodies".into()
    };
    Described { name: if hunting { format!("hunting, {name}") } else { name }, parts, hunting, shape }
}

/// The largest of the states beside the bodies, where bodies' displacements and velocities (at most `moves`) are rounding beside it.
fn largest_beside(states: &[c64], moves: f64) -> Option<usize> {
    let largest = (0..states.len()).max_by(|a, b| states[*a].norm().total_cmp(&states[*b].norm()))?;
    (moves < ROUNDING * states[largest].norm()).then_some(largest)
}

/// What has a state that no body has.
pub(super) fn owner(model: &Model, state: usize) -> String {
    let system = &model.system;
    let element = (0..system.forces.len()).find(|element| system.states_of_force(*element).contains(&state));
    element.map_or("contacts or track: own state".into(), |element| format!("{}: own state", system.forces[element].name()))
}

/// Does the wheelset that moves most roll along its wave? `v` are velocities, of which yaw angles are the `value`th part.
fn rolls_along(model: &Model, speed: f64, v: &[c64], value: c64) -> bool {
    let sway = |body: usize| v[COORDINATES * body + LATERAL];
    let bodies = model.wheelsets.iter().map(|wheelset| wheelset.body);
    let Some(most) = bodies.max_by(|a, b| sway(*a).norm().total_cmp(&sway(*b).norm())) else { return false };
    let steered = v[COORDINATES * most + YAW] / value * speed;
    (sway(most) - steered).norm() < ROLLS * sway(most).norm().max(steered.norm())
}

/// The motion with the largest share: coordinate, and the bodies that take part in it.
fn name(model: &Model, shares: &[f64], v: &[c64], largest: usize) -> String {
    let axis = largest % COORDINATES;
    let bodies = 0..model.system.bodies.len();
    let with: Vec<usize> = bodies.filter(|body| shares[COORDINATES * body + axis] >= WITH * shares[largest]).collect();
    let bodies = bodies_in_words(&with.iter().map(|body| model.system.bodies[*body].name.as_str()).collect::<Vec<_>>());
    let phases = match with.as_slice() {
        [a, b] => {
            let together = v[COORDINATES * a + axis] * v[COORDINATES * b + axis].conj();
            match together.re / together.norm() {
                part if part > MOSTLY => ", in phase",
                part if part < -MOSTLY => ", against each other",
                _ => "",
            }
        }
        _ => "",
    };
    format!("{bodies}: {}{phases}", sway(shares, v, largest / COORDINATES, axis).unwrap_or(MOTIONS[axis]))
}

/// One or two by name; of more those of a kind by their number.
fn bodies_in_words(names: &[&str]) -> String {
    if names.len() <= 2 {
        return names.join(" + ");
    }
    let kind = |name: &str| name.rsplit('.').next().and_then(|own| own.split('[').next()).unwrap_or_default().to_string();
    let mut words: Vec<String> = Vec::new();
    for name in names {
        let own = kind(name);
        let count = names.iter().filter(|other| kind(other) == own).count();
        let said = if count == 1 { name.to_string() } else { format!("{count} {own}s") };
        if !words.contains(&said) {
            words.push(said);
        }
    }
    words.join(" + ")
}

/// Of a body that sways and rolls: the sway about a pole below or above its centre.
fn sway(shares: &[f64], v: &[c64], body: usize, axis: usize) -> Option<&'static str> {
    let at = |axis: usize| COORDINATES * body + axis;
    let combined = [LATERAL, ROLL].contains(&axis) && shares[at(LATERAL)].min(shares[at(ROLL)]) > SWAYS;
    // The point at height h above the centre moves by y - h roll: it stands still at h = y / roll.
    let pole = (v[at(LATERAL)] / v[at(ROLL)]).re;
    combined.then_some(if pole < 0.0 { "lower sway" } else { "upper sway" })
}
