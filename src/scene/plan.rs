//! What a scene makes the program compute, and what not: the list behind `wheelrail plan`.

use super::spec::Scene;
use crate::formulation::Model;
use serde::Serialize;

/// One effect that the program knows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    pub name: &'static str,
    pub included: bool,
    /// The scene's words for it, or why it is not there.
    pub why: String,
    /// First-order states that it adds.
    pub states: usize,
}

/// Sizes and effects of an assembled scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    pub scene: String,
    pub bodies: usize,
    pub contacts: usize,
    pub force_elements: usize,
    pub states: usize,
    pub memory: usize,
    pub effects: Vec<Effect>,
}

/// Lists the effects of a scene and its model.
pub fn plan(scene: &Scene, model: &Model) -> Plan {
    let mut effects = Vec::new();
    let mut effect = |name, included, why: String, states| effects.push(Effect { name, included, why, states });
    let vehicle = &scene.vehicle;
    effect("rigid bodies", true, format!("vehicle.template = \"{}\"", vehicle.template), model.system.dimension());
    let why = match vehicle.speed_imposed {
        true => format!("vehicle.speed = {} m/s: removes the acceleration along the track", vehicle.speed),
        false => "vehicle.travel = \"free\"".into(),
    };
    effect("driving constraint", vehicle.speed_imposed, why, 0);
    effect("gravity", vehicle.gravity != 0.0, format!("vehicle.gravity = {} m/s2", vehicle.gravity), 0);
    let load = vehicle.wheelset.vertical_load;
    effect("vertical load", load != 0.0, format!("vehicle.wheelset.vertical_load = {load} N"), 0);
    for (name, stiffness, damping) in [
        (
            "longitudinal suspension",
            vehicle.suspension.as_ref().map(|s| s.longitudinal_stiffness),
            vehicle.suspension.as_ref().map(|s| s.longitudinal_damping),
        ),
        (
            "lateral suspension",
            vehicle.suspension.as_ref().map(|s| s.lateral_stiffness),
            vehicle.suspension.as_ref().map(|s| s.lateral_damping),
        ),
    ] {
        match (stiffness, damping) {
            (Some(k), Some(c)) => effect(name, k != 0.0 || c != 0.0, format!("2 elements, {k} N/m and {c} N s/m each"), 0),
            _ => effect(name, false, "no [vehicle.suspension]".into(), 0),
        }
    }
    for (name, side) in [("left rail deviations", crate::geometry::Side::Left), ("right rail deviations", crate::geometry::Side::Right)] {
        let shapes: Vec<String> = scene
            .track
            .deviations
            .iter()
            .filter(|d| d.side == side)
            .map(|d| format!("{:?}: {}", d.direction, d.shape.describe()).to_lowercase())
            .collect();
        let why = if shapes.is_empty() { format!("no [[track.deviation]] with rail = \"{}\"", side.name()) } else { shapes.join("; ") };
        effect(name, !shapes.is_empty(), why, 0);
    }
    let contact = &scene.contact;
    let formulation = format!("contact.formulation = \"{}\": {}", contact.formulation_name, model.formulation.describe());
    effect("contact", true, formulation, model.contacts() * model.formulation.states_per_contact());
    for (name, profiles) in [("wheel profile", &vehicle.wheelset.profiles), ("rail profile", &scene.track.rails)] {
        let [left, right] = [0, 1].map(|side| profiles[side].profile.describe());
        let why = if left == right { left } else { format!("left: {left}; right: {right}") };
        effect(name, true, why, 0);
    }
    effect("normal force", true, format!("contact.normal.law = \"{}\"{}", contact.normal_name, model.laws.normal.describe()), 0);
    let elastic = !model.formulation.constrains();
    let why = if elastic { "" } else { " (only for a wheel that has lifted: rigid contact has no penetration)" };
    let damped = elastic && contact.damping_law.name != "none";
    effect("contact damping", damped, format!("contact.damping {}{why}", model.laws.damping.describe()), 0);
    let transient = contact.transient.map(|t| format!("contact.transient.below = {} m/s", t.below));
    let why = transient.clone().unwrap_or("no [contact.transient]: steady creepage only".into());
    let states = model.contacts() * model.points * model.deflection_states();
    effect("transient tangential contact", transient.is_some(), why, states);
    effect("creep forces", true, format!("contact.creep.law = \"{}\", friction {}", contact.creep_name, contact.friction), 0);
    for (name, group) in
        [("drive torque input", "drive_torque"), ("centre force inputs", "centre_forces"), ("friction factor inputs", "friction")]
    {
        let shown = scene.interface.inputs.contains(&group);
        let why =
            if shown { format!("interface.inputs has \"{group}\"") } else { format!("interface.inputs lacks \"{group}\": no variable") };
        effect(name, shown, why, 0);
    }
    let contacts = model.contacts();
    Plan {
        scene: scene.name.clone(),
        bodies: model.system.bodies.len(),
        contacts,
        force_elements: model.system.forces.len(),
        states: model.dimension(),
        memory: model.memory(),
        effects,
    }
}
