//! What a scene makes the program compute, and what not: the list behind `wheelrail plan`.

use super::cautions::cautions;
use super::guards::guard;
use super::patch_choice;
use super::profile_notes::profile_notes;
use super::remarks::remarks;
use super::rough_track;
use super::solver_choice;
use super::spec::{Scene, VehicleSpec};
use super::start::{self, Start};
use crate::contact::patch::PatchLaw;
use crate::formulation::flexibility::Flexibility;
use crate::formulation::inputs::{CENTRE_FORCES, ELEMENT_INPUTS, GROUPS, InputGroup, RAIL_MOTION};
use crate::formulation::sliding_mean::CUT_OFF;
use crate::formulation::sliding_mean::SlidingMean;
use crate::formulation::travelling_track::RAIL_STATES;
use crate::formulation::{Model, contact_index};
use crate::geometry::Side;
use crate::geometry::track::centre_line::{LEAST_ROUNDING, Node, Pivot};
use crate::mbs::joint::Joint;
use serde::Serialize;

/// One effect that the program knows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    pub name: &'static str,
    pub included: bool,
    /// Where it is looked at only where it may act: where or when that is, and by what bound (`effects.mode = "auto"`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guarded: Option<String>,
    /// The scene's words for it, or why it is not there.
    pub why: String,
    /// First-order states that it adds.
    pub states: usize,
}

impl Effect {
    /// Is it computed?
    pub fn mark(&self) -> &'static str {
        match (self.included, &self.guarded) {
            (false, _) => "out",
            (true, None) => "in",
            (true, Some(_)) => "guarded",
        }
    }

    /// Why it is there or not, and what holds it back.
    pub fn words(&self) -> String {
        self.guarded.as_ref().map_or(self.why.clone(), |guard| format!("{}; {guard}", self.why))
    }
}

/// Sizes and effects of an assembled scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    pub scene: String,
    pub bodies: usize,
    /// Wheels on rails, and how many contacts each may have at the same time.
    pub contacts: usize,
    pub points: usize,
    pub force_elements: usize,
    pub states: usize,
    pub effects: Vec<Effect>,
    /// What was assumed where the scene leaves something open, e.g. in reading profile files.
    pub notes: Vec<String>,
}

/// Effects in the order in which they are listed.
#[derive(Default)]
struct Effects(Vec<Effect>);

impl Effects {
    fn add(&mut self, name: &'static str, included: bool, why: String, states: usize) {
        self.0.push(Effect { name, included, guarded: None, why, states });
    }
}

/// Lists the effects of a scene and its model.
pub fn plan(scene: &Scene, model: &Model) -> Plan {
    let mut all = Effects::default();
    vehicle_effects(scene, model, &mut all);
    track_under_effects(scene, model, &mut all);
    contact_effects(scene, model, &mut all);
    input_effects(scene, model, &mut all);
    for (name, why) in scene.effects.describe() {
        all.add(name, false, why, 0);
    }
    let mut effects = all.0;
    for effect in effects.iter_mut().filter(|effect| effect.included) {
        effect.guarded = guard(effect.name, scene, model);
    }
    Plan {
        scene: scene.name.clone(),
        bodies: model.system.bodies.len(),
        contacts: model.contacts(),
        points: model.points,
        force_elements: scene.vehicle.forces.len(),
        states: model.dimension(),
        effects,
        notes: profile_notes(scene)
            .into_iter()
            .chain(remarks(scene))
            .chain(cautions(scene, model))
            .chain(rough_track::note(scene, model))
            .chain(solver_choice::notes(scene, model))
            .collect(),
    }
}

/// Bodies, what drives and holds them, and how they start.
fn vehicle_effects(scene: &Scene, model: &Model, all: &mut Effects) {
    let vehicle = &scene.vehicle;
    all.add("rigid bodies", true, format!("vehicle.template = \"{}\"", vehicle.template), model.system.force_states().start);
    if let Some(away) = vehicle.away() {
        all.add("level of detail", true, away.describe(vehicle), 0);
    }
    let why = match vehicle.speed_imposed {
        true if !vehicle.keeps_speed() => format!("{}: sets the acceleration along the track{}", vehicle.speed_in_words(), driven(scene)),
        true => format!("vehicle.speed = {} m/s: removes the acceleration along the track{}", vehicle.speed, driven(scene)),
        false => format!("vehicle.travel = \"free\": starts with {} m/s", vehicle.speed),
    };
    all.add("driving constraint", vehicle.speed_imposed, why, 0);
    all.add("gravity", vehicle.gravity != 0.0, format!("vehicle.gravity = {} m/s2", vehicle.gravity), 0);
    let grade = scene.track.grade;
    let why = if grade == 0.0 {
        "no track.grade".into()
    } else {
        format!("track.grade = {:.2} %: gravity pulls along the track too", 1e2 * grade.tan())
    };
    all.add("grade", grade != 0.0, why, 0);
    if let Some(mean) = &model.means {
        let why =
            format!("interface.outputs names \"sliding_means\": over {} m, also behind a low-pass filter of {CUT_OFF} Hz", mean.window);
        all.add("sliding means", true, why, SlidingMean::STATES * model.wheelsets.len());
    }
    if let Some(books) = &model.books {
        let why = "interface.outputs names \"energy\": work and heat since the start, without a part in the error control";
        all.add("books of energy", true, why.into(), books.states());
    }
    for (name, why) in track_effects(scene) {
        all.add(name, true, why, 0);
    }
    if let Some((included, why)) = curved_start(scene) {
        all.add("steady curving start", included, why, 0);
    }
    if let Some(why) = displaced_start(scene) {
        all.add("start on displaced rails", true, why, 0);
    }
    for (name, included, why, states) in parts(vehicle, model) {
        all.add(name, included, why, states);
    }
}

/// What displaces the rails.
fn track_under_effects(scene: &Scene, model: &Model, all: &mut Effects) {
    for (name, side) in [("left rail deviations", Side::Left), ("right rail deviations", Side::Right)] {
        let shapes: Vec<String> = start::deviations(scene)
            .iter()
            .filter(|d| d.side == side)
            .map(|d| format!("{:?}: {}", d.direction, d.shape.describe()).to_lowercase())
            .collect();
        let why = if shapes.is_empty() { format!("no [[track.deviation]] with rail = \"{}\"", side.name()) } else { shapes.join("; ") };
        all.add(name, !shapes.is_empty(), why, 0);
    }
    for (contact, wheel) in model.wheels_out_of_round() {
        let of = model.wheel(contact);
        all.add("wheel out of round", true, format!("{}, {} wheel: {}", of.wheelset.name, of.side.name(), wheel.describe()), 0);
    }
    if let Some(track) = &model.travelling_track {
        let why = format!("track.flexibility = \"travelling\": {}", track.describe());
        all.add("track that gives way", true, why, model.contacts() * RAIL_STATES);
    }
    if let (Some(rails), Some(Flexibility::Beam(beam))) = (&model.beam, &scene.track.flexibility) {
        let (ring, groups, [round, next]) = (&rails.ring, rails.groups.len(), rails.left_of_waves());
        let why = format!(
            "track.flexibility = \"beam\": {}; {} modes up to {} Hz in each rail of {groups} piece{} of {} bays (a wave that has gone round has {:.1} % left{})",
            beam.describe(),
            ring.modes(),
            beam.highest,
            if groups == 1 { "" } else { "s" },
            ring.bays(),
            100.0 * round,
            if groups == 1 { String::new() } else { format!(", one that does not reach the next piece {:.1} %", 100.0 * next) }
        );
        all.add("track that gives way", true, why, model.contacts() * RAIL_STATES + 4 * groups * ring.modes());
    }
}

/// Contact of wheel and rail.
fn contact_effects(scene: &Scene, model: &Model, all: &mut Effects) {
    let vehicle = &scene.vehicle;
    let contact = &scene.contact;
    let formulation = format!("contact.formulation = \"{}\": {}", contact.formulation_name, model.formulation.describe());
    all.add("contact", true, formulation, model.contacts() * model.formulation.states_per_contact());
    let (several, why) = several_contacts(scene, model);
    all.add("several contacts per wheel", several, why, 0);
    for (name, profiles) in [("wheel profile", &vehicle.leading().profiles), ("rail profile", &scene.track.rails)] {
        let [left, right] = [0, 1].map(|side| profiles[side].profile.describe());
        let why = if left == right { left } else { format!("left: {left}; right: {right}") };
        all.add(name, true, why, 0);
    }
    let strips = contact.patch.law.forms();
    let patch = patch_choice::describe(&contact.patch);
    let why = match strips {
        true if contact.patch.law == PatchLaw::Table => {
            format!("{patch}: treads from a table, flanges and what else lies outside pressed as strips")
        }
        true if contact.patch.law == PatchLaw::Exact => format!("{patch}: {}", model.half_spaces().unwrap_or_default()),
        true if contact.patch.law == PatchLaw::Linear => format!("{patch}: {}", linear_contact(model)),
        true => {
            let faster = if model.formulation.points_per_wheel() == 1 {
                "; \"table\" looks them up: treads five times as fast, flanges as before"
            } else {
                ""
            };
            format!("{patch}; all that overlaps presses, forces at the load's centre{faster}")
        }
        false => patch,
    };
    all.add("non-elliptic patches", strips, why, 0);
    let why = match strips {
        true => "contact.patch takes its place".to_string(),
        false => format!("contact.normal.law = \"{}\"{}", contact.normal_name, model.laws.normal.describe()),
    };
    all.add("normal force", !strips, why, 0);
    let elastic = !model.formulation.constrains();
    let why = match (elastic, several) {
        (true, _) => "",
        (false, true) => " (of contacts beside the first and of a wheel that has lifted: rigid contact has no penetration)",
        (false, false) => " (only for a wheel that has lifted: rigid contact has no penetration)",
    };
    let damped = (elastic || several) && contact.damping_law.name != "none";
    all.add("contact damping", damped, format!("contact.damping {}{why}", model.laws.damping.describe()), 0);
    let transient = contact.transient.map(|t| format!("contact.transient.below = {} m/s", t.below));
    let why = transient.clone().unwrap_or("no [contact.transient]: steady creepage only".into());
    let states = model.contacts() * model.points * model.deflection_states();
    all.add("transient tangential contact", transient.is_some(), why, states);
    all.add(
        "creep forces",
        true,
        format!(
            "contact.creep.law = \"{}\"{}{}, friction {}",
            contact.creep_name,
            model.laws.creep.describe(),
            if contact.patch.law == PatchLaw::Linear { ": its slopes in steady rolling" } else { "" },
            contact.friction
        ),
        0,
    );
    if let Some(map) = &contact.friction_map {
        for (name, why) in ["friction along the track", "friction across the rail"].into_iter().zip(map.describe()) {
            if let Some(why) = why {
                all.add(name, true, why, 0);
            }
        }
    }
}

/// What a master may put in.
fn input_effects(scene: &Scene, model: &Model, all: &mut Effects) {
    let vehicle = &scene.vehicle;
    let asked = |group: &InputGroup| scene.interface.inputs.contains(&group.name);
    let has = |group: &InputGroup| *group != ELEMENT_INPUTS || model.system.force_inputs() > 0;
    for group in GROUPS.into_iter().filter(|group| !group.on_request && has(group)) {
        let (shown, name) = (asked(group), group.name);
        let why =
            if shown { format!("interface.inputs has \"{name}\"") } else { format!("interface.inputs lacks \"{name}\": no variable") };
        all.add(group.effect, shown, why, 0);
    }
    if model.rail_motion {
        let why = "interface.inputs names \"rail_motion\": displacement, velocity and slope of the rail under each wheel, from outside";
        all.add(RAIL_MOTION.effect, true, why.into(), 0);
    }
    let (shown, free) = (asked(&CENTRE_FORCES), vehicle.axles().iter().any(|axle| !axle.1));
    let why = match (shown, free) {
        (true, true) if vehicle.speed_imposed => "interface.inputs has \"centre_forces\"; on wheelsets whose speed is not imposed",
        (true, true) => "interface.inputs has \"centre_forces\", vehicle.travel = \"free\"",
        (true, false) => "the imposed speed leaves no room for a force along the track (vehicle.travel = \"free\" does)",
        (false, _) => "interface.inputs lacks \"centre_forces\": no variable",
    };
    all.add("longitudinal force input", shown && free, why.into(), 0);
}

/// What the nodes of the track call for; a scene without nodes has nothing to say.
fn track_effects(scene: &Scene) -> Vec<(&'static str, String)> {
    let Some(alignment) = &scene.track.alignment else { return Vec::new() };
    let nodes = &alignment.nodes;
    let largest = |of: fn(&Node) -> f64| nodes.iter().map(|node| of(node).abs()).fold(0.0, f64::max);
    let count = format!("{} nodes", nodes.len());
    let rounded = match alignment.smoothing {
        0.0 => "corners of the table not rounded".to_string(),
        smoothing => format!("corners rounded over {smoothing} m"),
    };
    let mut effects = Vec::new();
    let curvature = largest(|node| node.curvature);
    if curvature > 0.0 {
        effects.push(("curves", format!("{count}: sharpest radius of a node {:.1} m; {rounded}", 1.0 / curvature)));
    }
    let cant = largest(|node| node.superelevation);
    if cant > 0.0 {
        let about = if alignment.pivot == Pivot::Centre { "the centre line" } else { "the low rail" };
        let height = 2.0 * scene.track.half_rail_distance * cant.sin();
        let rounding = alignment.smoothing.max(LEAST_ROUNDING);
        effects.push(("superelevation", format!("up to {:.1} mm about {about}; corners rounded over {rounding} m", 1e3 * height)));
    }
    let grade = largest(|node| node.grade);
    if grade > 0.0 {
        effects.push(("grades", format!("up to {:.2} %; {rounded}", 1e2 * grade.tan())));
    }
    if effects.is_empty() {
        effects.push(("track nodes", format!("{count}, all straight and level: nothing to compute")));
    }
    effects
}

/// How a vehicle starts that does not stand on straight level track.
fn curved_start(scene: &Scene) -> Option<(bool, String)> {
    match start::start(scene) {
        Start::Straight => None,
        Start::Curve(node) => {
            let curvature = match node.curvature {
                0.0 => "straight".to_string(),
                curvature => format!("radius {:.1} m to the {}", 1.0 / curvature.abs(), if curvature > 0.0 { "left" } else { "right" }),
            };
            let height = 2e3 * scene.track.half_rail_distance * node.superelevation.sin();
            let why =
                format!("the track there, all the way: {curvature}, superelevation {height:.1} mm, grade {:.2} %", 1e2 * node.grade.tan());
            Some((true, why))
        }
        Start::Transition { distance } => {
            let begin = format!("the track changes at {distance:.1} m, under the vehicle:");
            let then = if scene.vehicle.is_lone() { "it starts as on straight level track" } else { "it cannot start there" };
            Some((false, format!("{begin} {then}")))
        }
    }
}

/// How a vehicle starts where rails are displaced, or why they are not.
fn displaced_start(scene: &Scene) -> Option<String> {
    let found = start::displaced(scene)?;
    let (most, steepest) = (1e3 * found.most, 1e3 * found.steepest);
    Some(format!(
        "under the wheels rails are up to {most:.2} mm out of place and {steepest:.2} mm/m out of line: wheels stand on them with their static loads and rise and fall with them from the start (track.start_fade lets displacements begin in front of the vehicle)"
    ))
}

/// Which of several wheelsets the imposed speed acts on.
fn driven(scene: &Scene) -> String {
    if scene.vehicle.wheelsets.len() == 1 {
        return String::new();
    }
    let names: Vec<&str> = scene.vehicle.axles().into_iter().filter(|axle| axle.1).map(|axle| axle.0).collect();
    let curved = track_effects(scene).iter().any(|effect| effect.0 == "curves");
    let strain = if curved && names.len() > 1 { "; in a curve they strain the vehicle, vehicle.drive = \"leading\" does not" } else { "" };
    format!(" of {}{strain}", names.join(", "))
}

/// Effects of the vehicle's parts, with their states.
fn parts(vehicle: &VehicleSpec, model: &Model) -> Vec<(&'static str, bool, String, usize)> {
    let load: f64 = vehicle.wheelsets.iter().map(|w| w.spec.vertical_load).sum();
    let rows: usize = model.system.joints.iter().map(Joint::rows).sum();
    let redundant = model.system.redundant.len();
    let joints = match vehicle.joints.len() {
        0 => "no [[vehicle.joint]]".into(),
        count => format!("{count} joints with {} scalar constraints, {redundant} of {rows} left out as redundant", rows - redundant),
    };
    let forces = match vehicle.forces.len() {
        0 => "no [[vehicle.force]]".into(),
        1 => {
            let element = &vehicle.forces[0].0;
            let constants = element.constants().into_iter().map(|c| format!(", {} {} {}", c.name, c.value, c.unit.name()));
            format!("one element, {}{}", element.name(), constants.collect::<String>())
        }
        count => format!("{count} elements between {} wheelsets and {} other bodies", vehicle.wheelsets.len(), vehicle.bodies.len()),
    };
    let loads = if load == 0.0 { "no vertical_load on a wheelset".into() } else { format!("{load} N on wheelsets") };
    let sensors = if vehicle.sensors.is_empty() { "no [[vehicle.sensor]]".into() } else { format!("{} points", vehicle.sensors.len()) };
    vec![
        ("vertical load", load != 0.0, loads, 0),
        ("joints", rows > 0, joints, 0),
        ("force elements", !vehicle.forces.is_empty(), forces, model.system.force_states().len()),
        ("sensors", !vehicle.sensors.is_empty(), sensors, 0),
    ]
}

/// May wheels have several contacts at the same time, and why?
fn several_contacts(scene: &Scene, model: &Model) -> (bool, String) {
    let points = scene.points;
    let own = model.formulation.points_per_wheel();
    if own > 1 {
        return (true, format!("contact.formulation = \"{}\" finds up to {} by itself", scene.contact.formulation_name, model.points));
    }
    if scene.contact.patch.law == PatchLaw::Linear {
        return (false, "contact.patch = \"linear\": one about the middle of the track".into());
    }
    if points == 1 {
        return (false, "contact.points = 1: the deepest place alone".into());
    }
    const CONVEX: &str = "only one place can touch (the profiles are strictly convex against each other)";
    let [left, right] = Side::BOTH.map(|side| model.searches_contacts(contact_index(0, side)));
    if scene.contact.patch.law.forms() {
        return (true, format!("contact.patch = \"{}\": parts of patches, up to {points}", scene.contact.patch.law.name()));
    }
    let points = match scene.contact.points {
        Some(stated) => format!("contact.points = {stated}"),
        None => format!("contact.points, by default as many as these profiles can need, {points}"),
    };
    match (left, right) {
        (true, true) => (true, format!("{points}: searched for")),
        (false, false) => (false, CONVEX.into()),
        (true, false) => (true, format!("{points}: searched for on the left; on the right {CONVEX}")),
        (false, true) => (true, format!("{points}: searched for on the right; on the left {CONVEX}")),
    }
}

/// Numbers of linear contact: of the leading wheelset.
fn linear_contact(model: &Model) -> String {
    let Some(linear) = model.linear_contact(0) else { return "the strips' patch".into() };
    let half = model.wheelsets[0].wheel(Side::Left).half_spacing;
    let (conicity, (angle, by_place)) = (linear.conicity(half), linear.patch.angle());
    format!(
        "the strips' patch about the middle of the track under {:.1} kN, first order: conicity {conicity:.4}, force {:.2} deg from the rail's axis and by {:.3} deg/mm \
         more outward, {:.0} MN/m",
        1e-3 * model.wheelsets[0].static_wheel_load,
        angle.to_degrees(),
        1e-3 * by_place.to_degrees(),
        1e-6 * linear.patch.stiffness(model.laws.material)
    )
}
