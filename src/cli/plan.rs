//! `wheelrail plan SCENE`: effects in and out, sizes, and where the time of one evaluation goes.

use super::{Failure, SceneArguments, print};
use crate::contact::creep::RollingContact;
use crate::contact::creepage::in_rolling_direction;
use crate::contact::search::algebraic::{Pair, SurfaceParameters};
use crate::formulation::{ContactReport, Evaluation, contact_index};
use crate::geometry::Side;
use crate::scene::plan;
use crate::sim::Simulation;
use clap::Args;
use std::hint::black_box;
use std::time::Instant;

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn plan(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let mut simulation = super::start(&scene)?;
    let plan = plan::plan(&scene, simulation.model());
    let costs = costs(&mut simulation, scene.contact.formulation_name);
    if arguments.json {
        let shares: serde_json::Map<String, serde_json::Value> =
            costs.iter().map(|(name, time)| (name.to_string(), (1e9 * time).into())).collect();
        print(&format!("{}\n", serde_json::json!({"plan": plan, "nanoseconds": shares})))?;
        return Ok(());
    }
    print(&format!(
        "{}: {}\n  {} states ({} bodies), {} wheels with up to {} contacts each, {} force elements, {} numbers of search memory\n\n",
        plan.scene, scene.title, plan.states, plan.bodies, plan.contacts, plan.points, plan.force_elements, plan.memory
    ))?;
    let width = plan.effects.iter().map(|effect| effect.name.len()).max().unwrap_or(0);
    for effect in &plan.effects {
        let states = if effect.states > 0 { format!("{} states", effect.states) } else { String::new() };
        let mark = if effect.included { "in " } else { "out" };
        print(&format!("  {mark}  {:width$}  {states:9}  {}\n", effect.name, effect.why))?;
    }
    for note in &plan.notes {
        print(&format!("  note: {note}\n"))?;
    }
    let total = costs.iter().map(|cost| cost.1).sum::<f64>();
    print(&format!("\nOne evaluation of the right-hand side, measured at the initial state: {:.2} us\n", 1e6 * total))?;
    for (name, time) in &costs {
        print(&format!("  {:4.0} %  {name}\n", 100.0 * time / total))?;
    }
    Ok(())
}

/// Seconds per call, the best of several rounds; of a slow call (the creep law `exact`) as few as can be.
fn time(mut call: impl FnMut()) -> f64 {
    const CALLS: f64 = 2000.0;
    const ROUNDS: usize = 5;
    /// s.
    const LONG: f64 = 0.1;
    let round = |call: &mut dyn FnMut(), calls: u32| {
        let clock = Instant::now();
        for _ in 0..calls {
            call();
        }
        clock.elapsed().as_secs_f64() / f64::from(calls)
    };
    let first = round(&mut call, 1);
    let calls = (LONG / first.max(1e-9)).clamp(1.0, CALLS) as u32;
    let rounds = if calls == 1 { 1 } else { ROUNDS };
    (0..rounds).map(|_| round(&mut call, calls)).fold(first, f64::min)
}

/// Where the time of one evaluation goes.
fn costs(simulation: &mut Simulation, formulation: &str) -> Vec<(&'static str, f64)> {
    let Ok(snapshot) = simulation.snapshot().cloned() else { return Vec::new() };
    let model = simulation.model();
    let mut search = 0.0;
    let mut normal = 0.0;
    let mut creep = 0.0;
    for (index, wheelset) in model.wheelsets.iter().enumerate() {
        let motion = &snapshot.workspace.system.motions[wheelset.body];
        for side in Side::BOTH {
            let report = &snapshot.workspace.contacts[contact_index(index, side)];
            let (wheel, rail) = (wheelset.wheel(side), model.track.rail(side));
            let (centre, axes) = (&motion.position, &motion.frame.axes);
            let pair = Pair { wheel, rail, centre, axes, distance: centre.x };
            let find = |start: &SurfaceParameters| pair.locate(start);
            // A start as far off as it is from stage to stage of a step.
            let start = SurfaceParameters { rail: report.parameters.rail + 1e-6, ..report.parameters };
            search += time(|| {
                let _ = black_box(find(black_box(&start)));
            });
            let Ok(found) = find(&start) else { continue };
            let shape = found.shape(wheel, rail);
            normal += time(|| {
                let _ = black_box(model.laws.normal.contact(black_box(&shape), found.penetration.max(1e-9)));
            });
            creep += time(|| {
                let ContactReport { patch, normal_force, .. } = *report;
                let friction = model.laws.friction;
                let law = |creepage| model.laws.creep.force(&RollingContact { patch, normal_force, friction, creepage, speed: 1.0 });
                black_box(in_rolling_direction(1.0, black_box(report.creepage), law));
            });
        }
    }
    let mut workspace = model.workspace();
    let (mut memory, mut dy) = (snapshot.memory().to_vec(), snapshot.dy.clone());
    let total = time(|| {
        let at = Evaluation { t: 0.0, inputs: snapshot.inputs(), y: black_box(&snapshot.y), memory: &mut memory };
        let _ = black_box(model.derivative(&mut workspace, at, &mut dy));
    });
    // Other formulations than these find contacts in other ways, and constraints call the laws several times.
    let rest = (total - search - normal - creep).max(0.0);
    match formulation {
        "ECF-A" => {
            let searches = (0..model.contacts()).any(|contact| model.searches_contacts(contact));
            let others =
                if searches { "multibody system, further contacts and the search for them" } else { "multibody system and the rest" };
            vec![("contact search", search), ("normal force and patch", normal), ("creep forces", creep), (others, rest)]
        }
        "ECCF" => vec![("contact search", search), ("kinematics, loop of normal and creep forces, multibody system", total - search)],
        _ => vec![
            ("normal force, patch and creep forces once", normal + creep),
            ("contact search, constraints and the rest", total - normal - creep),
        ],
    }
}
