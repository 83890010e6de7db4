//! `wheelrail list [KIND]`: what a scene can name, from the registries.

use super::{Failure, print};
use crate::contact::{creep, normal, patch};
use crate::formulation;
use crate::formulation::inputs::GROUPS;
use crate::geometry::{profile, track};
use crate::mbs::{force, joint};
use crate::scene::spec::{OUTPUT_GROUPS, PARAMETER_GROUPS};
use crate::scene::vehicle::templates;
use crate::scene::{embedded, load};
use crate::settings::{Entry, did_you_mean};
use crate::solve;
use clap::Args;

#[derive(Args)]
pub(super) struct Arguments {
    /// Only this kind: scenes, templates, profiles, deviations, irregularities, spectra, formulations, normal-laws, damping-laws, creep-laws, integrators, forces, joints, groups
    kind: Option<String>,
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

/// Name, summary, reference.
type Row = (String, String, String);

fn rows<P>(registry: &[Entry<P>]) -> Vec<Row> {
    registry.iter().map(|entry| (entry.name.into(), entry.summary.into(), entry.reference.into())).collect()
}

fn kinds() -> Vec<(&'static str, &'static str, Vec<Row>)> {
    let scenes = embedded::SCENES.iter().map(|scene| {
        let title = load::open(scene.name, &[]).map(|scene| scene.title).unwrap_or_default();
        (scene.name.to_string(), title, String::new())
    });
    let inputs = GROUPS.map(|group| group.name);
    let groups = [("inputs", &inputs[..]), ("outputs", OUTPUT_GROUPS), ("parameters", PARAMETER_GROUPS)];
    let groups = groups.map(|(key, names)| (format!("interface.{key}"), names.join(", "), String::new()));
    vec![
        ("scenes", "SCENE of every command", scenes.collect()),
        ("templates", "vehicle.template", rows(templates::REGISTRY)),
        ("profiles", "kind of [vehicle.wheelset.profile] and [track.rail]", rows(profile::REGISTRY)),
        ("deviations", "shape of [[track.deviation]]", rows(track::REGISTRY)),
        ("irregularities", "kind of [[track.irregularity]]", rows(track::irregularity::REGISTRY)),
        ("spectra", "spectrum of [[track.irregularity]]", rows(track::irregularity::spectrum::REGISTRY)),
        ("formulations", "contact.formulation", rows(formulation::REGISTRY)),
        ("normal-laws", "contact.normal.law", rows(normal::REGISTRY)),
        ("patches", "contact.patch", rows(patch::REGISTRY)),
        ("damping-laws", "contact.damping.law", rows(normal::damping::REGISTRY)),
        ("creep-laws", "contact.creep.law", rows(creep::REGISTRY)),
        ("integrators", "solver.integrator", rows(solve::REGISTRY)),
        ("forces", "kind of [[vehicle.force]]", rows(force::REGISTRY)),
        ("joints", "kind of [[vehicle.joint]]", rows(joint::REGISTRY)),
        ("groups", "interface", groups.to_vec()),
    ]
}

pub(super) fn list(arguments: &Arguments) -> Result<(), Failure> {
    let mut kinds = kinds();
    if let Some(wanted) = &arguments.kind {
        let names: Vec<&str> = kinds.iter().map(|kind| kind.0).collect();
        if !names.contains(&wanted.as_str()) {
            return Err(Failure::Input(format!(
                "nothing of kind \"{wanted}\"{}; kinds: {}",
                did_you_mean(wanted, &names),
                names.join(", ")
            )));
        }
        kinds.retain(|kind| kind.0 == wanted);
    }
    if arguments.json {
        let object: serde_json::Map<String, serde_json::Value> = kinds
            .into_iter()
            .map(|(kind, _, rows)| {
                let rows = rows
                    .into_iter()
                    .map(|(name, summary, reference)| serde_json::json!({"name": name, "summary": summary, "reference": reference}));
                (kind.to_string(), rows.collect())
            })
            .collect();
        print(&format!("{}\n", serde_json::Value::Object(object)))?;
        return Ok(());
    }
    for (kind, place, rows) in kinds {
        print(&format!("{kind} ({place})\n"))?;
        let width = rows.iter().map(|row| row.0.len()).max().unwrap_or(0);
        for (name, summary, reference) in rows {
            print(&format!("  {name:width$}  {summary}\n"))?;
            if !reference.is_empty() {
                print(&format!("  {:width$}  [{reference}]\n", ""))?;
            }
        }
        print("\n")?;
    }
    Ok(())
}
