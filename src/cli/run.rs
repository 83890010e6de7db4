//! `wheelrail run SCENE`: a native simulation with CSV, SVG and a summary.

use super::interrupt::Interrupt;
use super::output::Target;
use super::progress::Progress;
use super::{Failure, SceneArguments, TimeArguments, WheelsetArgument, csv_target, overview, print, table};
use crate::scene::spec::Scene;
use crate::settings::did_you_mean;
use crate::sim::Simulation;
use crate::sim::outputs::Output;
use crate::sim::pattern::matches;
use crate::sim::recording::{self, CsvRows, Recording, Times};
use crate::sim::statics;
use crate::sim::vehicle_outputs::scene_outputs;
use crate::solve::Doubts;
use crate::study::digits::rounded;
use clap::Args;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args)]
#[command(after_long_help = "\
Ctrl-C (or SIGTERM) ends the run in order: the rows so far are written, pictures and summary are made of them, the exit code is 130 \
(143); a second one ends the program at once. Rows are written to FILE.csv.XXXXXX.part beside FILE.csv, which keeps what it has until \
the end; after a kill what was computed is in that file.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Write outputs as CSV ("-" for stdout); a file must end in .csv
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Write only outputs of these names: * stands for any letters, ? for one, e.g. "*.verticalForce,wheelset.y" [default: all]
    #[arg(long, value_name = "PATTERN[,PATTERN]", value_delimiter = ',')]
    columns: Vec<String>,
    /// Draw lateral displacement, yaw and wheel loads over distance as SVG into a folder
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    wheelset: WheelsetArgument,
    #[command(flatten)]
    times: TimeArguments,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

/// Most lift-offs and landings that are printed.
const EVENTS_SHOWN: usize = 20;

/// Outputs of the shown wheelset that the summary and the picture need: name, label, unit, factor (no label: the picture alone).
const SHOWN: [(&str, &str, &str, f64); 10] = [
    ("y", "lateral displacement", "mm", 1e3),
    ("yaw", "yaw", "mrad", 1e3),
    ("roll", "roll", "mrad", 1e3),
    ("left.verticalForce", "Q left", "kN", 1e-3),
    ("right.verticalForce", "Q right", "kN", 1e-3),
    ("left.lateralForce", "Y left", "kN", 1e-3),
    ("right.lateralForce", "Y right", "kN", 1e-3),
    ("left.derailmentQuotient", "Y/Q left", "-", 1.0),
    ("right.derailmentQuotient", "Y/Q right", "-", 1.0),
    ("distance", "", "m", 1.0),
];

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let (stop, step) = arguments.times.read(&scene)?;
    let times = Times { stop, step };
    let wheelset = arguments.wheelset.choose(&scene)?;
    // Whatever can't be written is better known before the run.
    let target = csv_target(&arguments.output, arguments.json)?;
    let to_stdout = target.as_ref().is_some_and(Target::is_stdout);
    let mut simulation = super::start(&scene)?;
    if let Some(folder) = &arguments.plot {
        overview::prepare(folder, &scene.interface.outputs)?;
    }
    let mut outputs = scene_outputs(&scene, simulation.model());
    check_columns(&arguments.columns, &outputs)?;
    // What nobody reads is not computed.
    let read = target.is_some() || arguments.json;
    let wanted = |name: &str| read && (arguments.columns.is_empty() || arguments.columns.iter().any(|pattern| matches(pattern, name)));
    let shown = |name: &str| name.strip_prefix(wheelset).is_some_and(|rest| SHOWN.iter().any(|one| rest.strip_prefix('.') == Some(one.0)));
    outputs.retain(|output| wanted(&output.name) || shown(&output.name));
    let chosen: Vec<usize> =
        [0].into_iter().chain((0..outputs.len()).filter(|index| wanted(&outputs[*index].name)).map(|index| index + 1)).collect();
    let mut notes = statics::statics(&scene, &mut simulation).map(|found| found.notes()).unwrap_or_default();
    notes.extend(scene.effects.describe().into_iter().map(|(name, why)| format!("left out: {name}, {why}")));
    let interrupt = Interrupt::watch();
    let clock = Instant::now();
    let (recording, mut failure) = integrate(&mut simulation, &outputs, times, &interrupt, target.as_ref(), &chosen)?;
    let elapsed = clock.elapsed().as_secs_f64();
    let simulated = simulation.time();
    let ended = interrupt.code().filter(|_| failure.is_none() && simulated < times.stop).map(|code| {
        let kept = match &arguments.output {
            Some(path) if !to_stdout => format!("{} rows until then are in {}", recording.rows.len(), path.display()),
            _ => format!("{} rows until then", recording.rows.len()),
        };
        (format!("interrupted at t = {} s of {} s: {kept}", rounded(simulated), rounded(times.stop)), code)
    });
    if let Some(folder) = &arguments.plot {
        match overview::draw(folder, &scene.name, &scene.title, wheelset, &recording) {
            Ok(file) => super::say(&format!("wrote {}", file.display())),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    notes.extend(recording.notes.iter().cloned());
    notes.extend(simulation.notes());
    let events: Vec<String> = simulation.take_events().iter().map(ToString::to_string).collect();
    messages(&notes, &events, simulation.doubts());
    if arguments.json {
        let error = failure.as_ref().or(ended.as_ref().map(|ended| &ended.0));
        let extremes: serde_json::Map<String, serde_json::Value> = extremes(&recording)
            .into_iter()
            .filter(|extreme| extreme.name == "time" || wanted(&extreme.name))
            .map(|extreme| (extreme.name, serde_json::json!({"min": extreme.min, "max": extreme.max, "end": extreme.end})))
            .collect();
        let value = serde_json::json!({
            "scene": scene.name, "simulated": simulated, "seconds": elapsed, "statistics": simulation.statistics(),
            "extremes": extremes, "events": events, "doubtful_steps": simulation.doubts(), "notes": notes, "error": error,
        });
        print(&format!("{value}\n"))?;
    } else if !to_stdout {
        print(&summary(&scene.title, wheelset, &recording))?;
        print(&work(&scene, &simulation, elapsed, times.step))?;
    }
    match (failure, ended) {
        (Some(error), _) => Err(Failure::Run(error)),
        (None, Some((words, code))) => Err(Failure::Interrupted(words, code)),
        (None, None) => Ok(()),
    }
}

/// Runs to the stop time, a failure or a signal; writes the chosen columns of each row to a target. Returns what was recorded until then,
/// and what failed.
fn integrate(
    simulation: &mut Simulation,
    outputs: &[Output],
    times: Times,
    interrupt: &Interrupt,
    target: Option<&Target>,
    chosen: &[usize],
) -> Result<(Recording, Option<String>), Failure> {
    let mut csv = match target {
        Some(target) => {
            let rows = CsvRows::begin(target.begin()?, &Recording::new(outputs), chosen.to_vec());
            Some(rows.map_err(|error| Failure::Run(error.to_string()))?)
        }
        None => None,
    };
    let progress = Progress::new(times.stop);
    let mut broken = None;
    let done = recording::record_while(simulation, outputs, times, |row| {
        progress.at(row[0]);
        broken = csv.as_mut().and_then(|csv| csv.write(row).err());
        if broken.is_some() || interrupt.code().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    progress.finish();
    // What was computed before a failure is written too.
    let (recording, failure) = match done {
        Ok(recording) => (recording, None),
        Err(interrupted) => (interrupted.recording, Some(interrupted.error.to_string())),
    };
    let written = match (csv, broken) {
        (Some(csv), Some(error)) => csv.writer.fail(error),
        (Some(csv), None) => csv.writer.finish(),
        (None, _) => Ok(()),
    };
    Ok((recording, failure.or(written.err().map(|error| error.to_string()))))
}

/// Tells of a run what its results do not show.
fn messages(notes: &[String], events: &[String], doubts: Doubts) {
    for note in notes {
        super::say(&format!("note: {note}"));
    }
    for event in events.iter().take(EVENTS_SHOWN) {
        super::say(event);
    }
    if events.len() > EVENTS_SHOWN {
        super::say(&format!("... and {} more events (--json lists all)", events.len() - EVENTS_SHOWN));
    }
    if doubts.steps > 0 {
        super::say(&format!("warning: {doubts}"));
    }
}

/// What a run took.
fn work(scene: &Scene, simulation: &Simulation, elapsed: f64, step: f64) -> String {
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

/// Refuses a pattern that fits no output.
fn check_columns(patterns: &[String], outputs: &[Output]) -> Result<(), Failure> {
    let names: Vec<&str> = outputs.iter().map(|output| output.name.as_str()).collect();
    match patterns.iter().find(|pattern| !names.iter().any(|name| matches(pattern, name))) {
        None => Ok(()),
        Some(pattern) => {
            let hint = did_you_mean(pattern, &names);
            let some = names.iter().take(3).copied().collect::<Vec<_>>().join(", ");
            let all = names.len();
            Err(Failure::Input(format!("--columns {pattern}{hint}: no output of that name; there are {all}, such as {some}")))
        }
    }
}

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

/// Extremes of the outputs that people look at first.
fn summary(title: &str, wheelset: &str, recording: &Recording) -> String {
    let found = extremes(recording);
    let rows: Vec<Vec<String>> = SHOWN
        .iter()
        .filter(|one| !one.1.is_empty())
        .filter_map(|(name, label, unit, factor)| {
            let full = format!("{wheelset}.{name}");
            let extreme = found.iter().find(|extreme| extreme.name == full)?;
            let cell = |value: f64| format!("{:.4}", value * factor);
            Some(vec![format!("{label} [{unit}]"), cell(extreme.min), cell(extreme.max), cell(extreme.end)])
        })
        .collect();
    let head = ["", "smallest", "largest", "at the end"].map(String::from);
    format!("{title}\n\n{}", table(&head, &rows))
}
