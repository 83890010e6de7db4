//! What a run says: notes and events while it goes, extremes and work at its end.

use super::super::{say, table};
use super::SHOWN;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::recording::Recording;
use crate::solve::Doubts;
use crate::study::digits::rounded;

/// Most lift-offs and landings that are printed.
const EVENTS_SHOWN: usize = 20;

/// Says what the results of a run do not show.
pub(in crate::cli) fn messages(notes: &[String], events: &[String], doubts: Doubts) {
    for note in notes {
        say(&format!("note: {note}"));
    }
    for event in events.iter().take(EVENTS_SHOWN) {
        say(event);
    }
    if events.len() > EVENTS_SHOWN {
        say(&format!("... and {} more events (--json lists all)", events.len() - EVENTS_SHOWN));
    }
    if doubts.steps > 0 {
        say(&format!("warning: {doubts}"));
    }
}

/// What a run took.
pub(super) fn work(scene: &Scene, simulation: &Simulation, elapsed: f64, step: f64) -> String {
    let (statistics, simulated) = (simulation.statistics(), simulation.time());
    let mut text = format!(
        "\n  {} s simulated in {elapsed:.3} s ({} times real time with outputs every {} ms):\n  {} steps, {} rejected, {} evaluations of the right-hand side\n",
        rounded(simulated),
        times(simulated / elapsed.max(1e-9)),
        rounded(1e3 * step),
        statistics.steps,
        statistics.rejected,
        statistics.evaluations
    );
    if scene.solver.integrator.linearises() {
        text += &format!(
            "  {} Jacobians, {} factorisations, {} Newton iterations of the integrator\n",
            statistics.linearisations, statistics.factorisations, statistics.iterations
        );
    }
    if simulation.model().formulation.constrains() {
        text += &format!(
            "  {} ends of steps projected, {:.1} evaluations of the creep law per right-hand side, {} lift-offs and landings\n",
            statistics.projections,
            simulation.state().work.force_iterations as f64 / statistics.evaluations.max(1) as f64,
            statistics.events
        );
    }
    text
}

/// The summary for programs; extremes of the columns that `shown` names.
pub(super) fn json(
    scene: &str,
    (simulation, elapsed): (&Simulation, f64),
    (recording, shown): (&Recording, &dyn Fn(&str) -> bool),
    (events, notes): (&[String], &[String]),
    error: Option<&String>,
) -> serde_json::Value {
    let extremes: serde_json::Map<String, serde_json::Value> = extremes(recording)
        .into_iter()
        .filter(|extreme| shown(&extreme.name))
        .map(|extreme| (extreme.name, serde_json::json!({"min": extreme.min, "max": extreme.max, "end": extreme.end})))
        .collect();
    serde_json::json!({
        "scene": scene, "simulated": simulation.time(), "seconds": elapsed, "statistics": simulation.statistics(),
        "extremes": extremes, "events": events, "doubtful_steps": simulation.doubts(), "notes": notes, "error": error,
    })
}

/// Least, greatest and last value of a column.
struct Extreme {
    name: String,
    min: f64,
    max: f64,
    end: f64,
}

fn extremes(recording: &Recording) -> Vec<Extreme> {
    let column = |(index, (name, _)): (usize, &(String, &'static str))| {
        let values = recording.rows.iter().map(|row| row[index]);
        Extreme {
            name: name.clone(),
            min: values.clone().fold(f64::INFINITY, f64::min),
            max: values.clone().fold(f64::NEG_INFINITY, f64::max),
            end: values.clone().next_back().unwrap_or(f64::NAN),
        }
    };
    recording.columns.iter().enumerate().map(column).collect()
}

/// Two digits where it matters whether it is more or less than one.
fn times(factor: f64) -> String {
    if factor < 10.0 { format!("{factor:.2}") } else { format!("{factor:.0}") }
}

/// Extremes, over the rows, of the outputs that people look at first; of several wheelsets it names the one.
pub(super) fn summary(title: &str, (wheelset, alone): (&str, bool), recording: &Recording) -> String {
    let found = extremes(recording);
    let rows: Vec<Vec<String>> = SHOWN
        .iter()
        .filter_map(|(name, label, unit, factor)| {
            let full = format!("{wheelset}.{name}");
            let extreme = found.iter().find(|extreme| extreme.name == full)?;
            let cell = |value: f64| format!("{:.4}", value * factor);
            Some(vec![format!("{label} [{unit}]"), cell(extreme.min), cell(extreme.max), cell(extreme.end)])
        })
        .collect();
    let head = [if alone { "" } else { wheelset }, "smallest", "largest", "at the end"].map(String::from);
    format!("{title}\n\n{}", table(&head, &rows))
}
