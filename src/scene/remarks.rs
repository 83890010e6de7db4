//! What a reader of a plan should know about numbers that are allowed but perhaps not meant.

use super::spec::Scene;
use crate::geometry::track::centre_line::{Alignment, Node};
use crate::mbs::force::{Beyond, Table};

/// Time constants below this [s] bound an explicit integrator's step before wheels on rails do (about 1 ms).
const SHORT: f64 = 3e-4;
/// An explicit method of fifth order is stable up to so many time constants per step.
const STABLE: f64 = 3.3;

/// All of them.
pub(super) fn remarks(scene: &Scene) -> Vec<String> {
    let alignment = scene.track.alignment.as_ref().and_then(crowded_corners);
    alignment.into_iter().chain(short_times(scene)).chain(tables(scene)).collect()
}

/// Corners of the node table that are nearer to each other than they are rounded.
fn crowded_corners(alignment: &Alignment) -> Option<String> {
    let nodes = &alignment.nodes;
    let of: [fn(&Node) -> f64; 3] = [|node| node.curvature, |node| node.superelevation, |node| node.grade];
    let (mut first, mut pairs) = (None, 0);
    let mut before: Option<f64> = None;
    for (i, node) in nodes.iter().enumerate() {
        // Outside the table values are constant.
        let slope = |a: Option<&Node>, b: Option<&Node>, value: fn(&Node) -> f64| match (a, b) {
            (Some(a), Some(b)) => (value(b) - value(a)) / (b.distance - a.distance),
            _ => 0.0,
        };
        let last = i.checked_sub(1).and_then(|last| nodes.get(last));
        if of.iter().all(|value| slope(last, Some(node), *value) == slope(Some(node), nodes.get(i + 1), *value)) {
            continue;
        }
        if let Some(before) = before.replace(node.distance).filter(|before| node.distance - before < alignment.smoothing) {
            first = first.or(Some((before, node.distance)));
            pairs += 1;
        }
    }
    let (from, to) = first?;
    let more = if pairs > 1 { format!(" and {} more", pairs - 1) } else { String::new() };
    Some(format!(
        "track.smoothing = {} m is longer than the stretch between the corners at {from} m and {to} m{more}: rounded together, they do not reach the values of the table",
        alignment.smoothing
    ))
}

/// Force elements whose own states are faster than anything else.
fn short_times(scene: &Scene) -> impl Iterator<Item = String> {
    let elements = scene.vehicle.forces.iter();
    let short = |element: &super::vehicle::Element| element.0.time_constant().filter(|time| *time < SHORT);
    elements.filter_map(move |element| {
        let time = short(element)?;
        let (step, frequency) = (1e3 * STABLE * time, 1.0 / (std::f64::consts::TAU * time));
        let of_inputs = !element.0.inputs().is_empty();
        if of_inputs || element.0.own_inertia().is_some() {
            return Some(format!(
                "{}: settles or swings of its own within {:.3} ms; explicit integrators can't step further than {step:.3} ms",
                element.0.name(),
                1e3 * time
            ));
        }
        Some(format!(
            "{}: time constant c/k = {:.3} ms; explicit integrators can't step further than {step:.3} ms. A spring_damper with the same damping and no spring differs only above {frequency:.0} Hz",
            element.0.name(),
            1e3 * time
        ))
    })
}

/// How tables of forces go on beyond their points; alike tables together. A stop's is free on the other side and has a sense beyond its end.
fn tables(scene: &Scene) -> Vec<String> {
    let elements = scene.vehicle.forces.iter();
    let mut kinds: Vec<(Table, &str, usize)> = Vec::new();
    for (name, table) in elements.flat_map(|element| element.0.tables().into_iter().map(|table| (element.0.name(), table))) {
        if table.from.is_infinite() {
            continue;
        }
        match kinds.iter_mut().find(|kind| kind.0 == table) {
            Some(kind) => kind.2 += 1,
            None => kinds.push((table, name, 1)),
        }
    }
    let words = |(table, name, count): (Table, &str, usize)| {
        let Table { key, unit, from, to, beyond, one_sided } = table;
        let more = if count > 1 { format!(" (and {} more elements)", count - 1) } else { String::new() };
        let goes_on = match beyond {
            Beyond::Hold => "the force at the end holds (beyond = \"hold\")",
            Beyond::Slope => "the slope at the end goes on (beyond = \"hold\" keeps the force)",
        };
        let other = if one_sided { "; it has points on one side of zero alone: odd = true mirrors it" } else { "" };
        format!("{name}{more}: {key} is known from {from} to {to} {unit}; beyond, {goes_on}{other}")
    };
    kinds.into_iter().map(words).collect()
}
