//! `wheelrail plan SCENE`: effects in and out, sizes, and where the work of one evaluation goes.

use super::{Failure, SceneArguments, print, table};
use crate::mbs::body::COORDINATES;
use crate::scene::improbable::improbable;
use crate::scene::plan::{self, Effect};
use crate::scene::spec::Scene;
use crate::sim::statics::{self, ElementForce, Statics};
use crate::sim::tables::LeftTables;
use crate::study::effects::neglect;
use crate::study::shares::Part;
use crate::study::shares::anatomy::Sample;
use crate::study::shares::counted::Counted;
use clap::Args;

#[derive(Args)]
#[command(after_long_help = "\
One line per effect: in (computed), out (the scene does not name it, or it is switched off) or guarded (looked at only where it may act, by a bound \
that is named), its states, its share of the work of one evaluation at the initial state, and the line of the scene or the reason.

Below: the work of that evaluation by parts, from counted operations (an estimate of instructions, not a time), and what leaving an effect out would \
neglect, by formulas with this scene's numbers. `wheelrail effects` runs the scene without each of them instead.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Print how the vehicle stands at its start: heights of bodies, wheel loads, forces of elements and travel used
    #[arg(long = "static")]
    statics: bool,
    /// Print the plan (or what --static shows) as JSON
    #[arg(long)]
    json: bool,
}

/// The effects of the plan to which a part of an evaluation's work belongs: the one of them that is in.
const SHARES: [(Part, &str); 8] = [
    (Part::NormalLaw, "non-elliptic patches"),
    (Part::ContactSearch, "contact"),
    (Part::ContactAndEquations, "contact"),
    (Part::NormalLaw, "normal force"),
    (Part::CreepLaw, "creep forces"),
    (Part::Track, "curves"),
    (Part::Forces, "force elements"),
    (Part::EquationsOfMotion, "rigid bodies"),
];

pub(super) fn plan(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let mut simulation = super::start(&scene)?;
    let found = statics::statics(&scene, &mut simulation).map_err(|error| Failure::Run(error.to_string()))?;
    let mut notes = found.notes(&scene);
    if arguments.statics {
        notes.splice(0..0, improbable(&scene, simulation.model()));
        print(&match arguments.json {
            true => format!("{}\n", serde_json::json!({"static": found, "notes": notes})),
            false => report(&scene, &found) + &super::notes(notes),
        })?;
        return Ok(());
    }
    let mut left = LeftTables::new(simulation.model());
    if let Ok(snapshot) = simulation.snapshot() {
        left.look(snapshot);
    }
    notes.extend(left.notes());
    let mut plan = plan::plan(&scene, simulation.model());
    plan.notes.extend(notes);
    let coordinates = COORDINATES * simulation.model().system.bodies.len();
    let sample = simulation.snapshot().ok().map(|snapshot| Sample::behind(snapshot, coordinates, 0.0));
    let neglected = match simulation.snapshot().is_ok() {
        true => neglect::neglected(&scene, simulation.model(), simulation.last_snapshot()),
        false => Vec::new(),
    };
    let counted = sample.and_then(|sample| Counted::of(simulation.model(), &sample, &scene.contact.creep_name));
    let search = if simulation.model().formulation.constrains() { Part::ContactAndEquations } else { Part::ContactSearch };
    let whole = counted.as_ref().map_or(0.0, Counted::whole);
    let parts = counted.map_or(Vec::new(), |counted| counted.parts);
    let share = |effect: &str| {
        let own = SHARES.iter().filter(|one| one.1 == effect).flat_map(|one| parts.iter().filter(move |part| part.0 == one.0));
        own.map(|part| part.1 / whole).reduce(|a, b| a + b).filter(|part| *part > 0.0)
    };
    let shown = parts.iter().filter(|(part, count)| *count > 0.0 || *part == search);
    let costs: Vec<(&str, f64)> = shown.map(|(part, count)| (part.words(), *count)).collect();
    if arguments.json {
        let shares: serde_json::Map<String, serde_json::Value> =
            costs.iter().map(|(name, count)| (name.to_string(), (*count).into())).collect();
        print(&format!("{}\n", serde_json::json!({"plan": plan, "neglected": neglected, "instructions": shares})))?;
        return Ok(());
    }
    print(&format!(
        "{}: {}\n  {} states ({} bodies), {} wheels with up to {} contacts each, {} force elements\n\n",
        plan.scene, scene.title, plan.states, plan.bodies, plan.contacts, plan.points, plan.force_elements
    ))?;
    let width = plan.effects.iter().map(|effect| effect.name.len()).max().unwrap_or(0);
    let marks = plan.effects.iter().map(|effect| effect.mark().len()).max().unwrap_or(0);
    let states = |effect: &Effect| if effect.states > 0 { format!("{} states", effect.states) } else { String::new() };
    let wide = plan.effects.iter().map(|effect| states(effect).len()).max().unwrap_or(0);
    for effect in &plan.effects {
        let part = share(effect.name).filter(|_| effect.included).map_or(String::new(), |part| format!("{:.0} %", 100.0 * part));
        print(&format!("  {:marks$}  {:width$}  {:wide$}  {part:>5}  {}\n", effect.mark(), effect.name, states(effect), effect.words()))?;
    }
    for note in &plan.notes {
        print(&format!("  note: {note}\n"))?;
    }
    print(&format!(
        "\nOne evaluation of the right-hand side at the initial state: {} thousand instructions, from what it does\n",
        thousands(whole)
    ))?;
    for (name, count) in &costs {
        print(&format!("  {:4.0} %  {name}\n", 100.0 * count / whole))?;
    }
    if !neglected.is_empty() {
        print("\nWhat leaving an effect out neglects, by formulas with this scene's numbers (`wheelrail effects` runs them)\n")?;
        let width = neglected.iter().map(|one| one.effect.len()).max().unwrap_or(0);
        for one in &neglected {
            print(&format!("  {:width$}  {}\n", one.effect, one.words))?;
        }
    }
    Ok(())
}

/// Two digits, of thousands.
fn thousands(count: f64) -> String {
    let value: f64 = format!("{:.1e}", 1e-3 * count).parse().unwrap_or(count);
    format!("{value}")
}

/// The static report as tables.
fn report(scene: &Scene, found: &Statics) -> String {
    let head = |cells: &[&str]| cells.iter().map(ToString::to_string).collect::<Vec<_>>();
    let bodies = found.bodies.iter().map(|body| {
        let metres = [body.drawn_height, body.height].map(|height| format!("{height:.4}"));
        let others = [body.settles, body.roll, body.pitch].map(|value| shown(1e3 * value, 2));
        std::iter::once(body.name.clone()).chain(metres).chain(others).collect::<Vec<_>>()
    });
    let wheels = found.wheels.iter().map(|wheels| {
        let loads = [wheels.left, wheels.right, wheels.left + wheels.right].map(|load| shown(1e-3 * load, 3));
        std::iter::once(wheels.wheelset.clone()).chain(loads).collect::<Vec<_>>()
    });
    let total: f64 = found.wheels.iter().map(|wheels| wheels.left + wheels.right).sum();
    // What neither carries nor gives way says nothing.
    let works = |row: &&ElementForce| row.force.abs() > 0.5 || row.displacement.abs() > 5e-6 || row.free_travel.is_some();
    let rows: Vec<Vec<String>> = (found.elements.iter().filter(works))
        .map(|row| {
            let [force, way] = if row.turns { ["kN m", "mrad"] } else { ["kN", "mm"] };
            let limit = |limit: Option<f64>, sign: &str| limit.map_or(format!("{sign}free"), |limit| shown(1e3 * limit, 1));
            let free =
                row.free_travel.map_or(String::new(), |[shorter, longer]| format!("{} .. {}", limit(shorter, "-"), limit(longer, "+")));
            let used = row.travel_used.map_or(String::new(), |used| format!("{:.0} %", 100.0 * used));
            vec![row.name.clone(), shown(1e-3 * row.force, 3), force.into(), shown(1e3 * row.displacement, 2), way.into(), free, used]
        })
        .collect();
    let hidden = found.elements.len() - rows.len();
    let mut text = format!(
        "{}: {}\n\nHow it stands at the start{}, along the track's vertical.\n\nCentres of mass: height over the nominal contact height\n\n",
        scene.name,
        scene.title,
        if scene.vehicle.speed == 0.0 { "" } else { " (running steadily)" }
    );
    text += &table(&head(&["body", "drawn [m]", "now [m]", "settles [mm]", "roll [mrad]", "pitch [mrad]"]), &bodies.collect::<Vec<_>>());
    text += "\nWheel loads Q\n\n";
    text += &table(&head(&["wheelset", "left [kN]", "right [kN]", "both [kN]"]), &wheels.collect::<Vec<_>>());
    text += &format!("  all wheels: {:.3} kN\n", 1e-3 * total);
    if !rows.is_empty() {
        text += "\nForce elements: along a line tension and elongation positive; along an axis displacements of \"to\" against \"from\" and what pulls it back\n\
             (a compressed spring that goes down to its axle is positive along z); from the drawn configuration\n\n";
        text += &table(&head(&["element", "force", "", "displacement", "", "free travel [mm]", "used"]), &rows);
    }
    if hidden > 0 {
        text += &format!("  {hidden} forces without load and displacement are left out (--json has them)\n");
    }
    for note in found.notes(scene) {
        text += &format!("\n  note: {note}\n");
    }
    text
}

/// A number without the sign of a rounded zero.
fn shown(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { text.trim_start_matches('-').into() } else { text }
}
