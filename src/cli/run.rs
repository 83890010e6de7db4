//! `wheelrail run SCENE`: a native simulation with CSV, SVG and a summary.

use super::progress::Progress;
use super::{Failure, SceneArguments, TimeArguments, WheelsetArgument, plot, print, table};
use crate::sim::recording::{self, Recording};
use crate::sim::statics;
use crate::sim::vehicle_outputs::scene_outputs;
use crate::study::digits::rounded;
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Write all outputs as CSV ("-" for stdout)
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
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

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let (stop, step) = arguments.times.read(&scene)?;
    let wheelset = arguments.wheelset.choose(&scene)?;
    let to_stdout = arguments.output.as_deref() == Some(Path::new("-"));
    if to_stdout && arguments.json {
        return Err(Failure::Input("-o - and --json both write to stdout; choose one".into()));
    }
    let mut simulation = super::start(&scene)?;
    // Whatever can't be written is better known before the run.
    let mut csv = arguments.output.as_deref().map(open_csv).transpose()?;
    if let Some(folder) = &arguments.plot {
        plot::prepare(folder, &scene.interface.outputs).map_err(Failure::Input)?;
    }
    let outputs = scene_outputs(&scene, simulation.model());
    let mut notes = statics::statics(&scene, &mut simulation).map(|found| found.notes()).unwrap_or_default();
    let progress = Progress::new(stop);
    let clock = Instant::now();
    let done = recording::record(&mut simulation, &outputs, stop, step, |time| progress.at(time));
    let elapsed = clock.elapsed().as_secs_f64();
    progress.finish();
    // What was computed before a failure is written too.
    let (recording, mut failure) = match done {
        Ok(recording) => (recording, None),
        Err(interrupted) => (interrupted.recording, Some(interrupted.error.to_string())),
    };
    if let (Some(csv), Some(path)) = (&mut csv, &arguments.output) {
        match recording.write_csv(csv) {
            Err(error) if !closed_pipe(&error) => failure = failure.or(Some(format!("{}: can't be written: {error}", path.display()))),
            _ => {}
        }
    }
    if let Some(folder) = &arguments.plot {
        match plot::overview(folder, &scene.name, &scene.title, wheelset, &recording) {
            Ok(file) => super::say(&format!("wrote {}", file.display())),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    notes.extend(recording.notes.iter().cloned());
    for note in &notes {
        super::say(&format!("note: {note}"));
    }
    let events: Vec<String> = simulation.take_events().iter().map(ToString::to_string).collect();
    for event in events.iter().take(EVENTS_SHOWN) {
        super::say(event);
    }
    if events.len() > EVENTS_SHOWN {
        super::say(&format!("... and {} more events (--json lists all)", events.len() - EVENTS_SHOWN));
    }
    let doubts = simulation.doubts();
    if doubts.steps > 0 {
        super::say(&format!("warning: {doubts}"));
    }
    let statistics = simulation.statistics();
    let simulated = simulation.time();
    if arguments.json {
        let extremes: serde_json::Map<String, serde_json::Value> = extremes(&recording)
            .into_iter()
            .map(|extreme| (extreme.name, serde_json::json!({"min": extreme.min, "max": extreme.max, "end": extreme.end})))
            .collect();
        let value = serde_json::json!({
            "scene": scene.name, "simulated": simulated, "seconds": elapsed, "statistics": statistics,
            "extremes": extremes, "events": events, "doubtful_steps": doubts, "notes": notes, "error": failure,
        });
        print(&format!("{value}\n"));
    } else if !to_stdout {
        print(&summary(&scene.title, wheelset, &recording));
        print(&format!(
            "\n  {} s simulated in {elapsed:.3} s ({} times real time with outputs every {} ms):\n  {} steps, {} rejected, {} evaluations of the right-hand side\n",
            rounded(simulated),
            times(simulated / elapsed.max(1e-9)),
            rounded(1e3 * step),
            statistics.steps,
            statistics.rejected,
            statistics.evaluations
        ));
        if scene.solver.integrator.linearises() {
            print(&format!(
                "  {} Jacobians, {} factorisations, {} Newton iterations of the integrator\n",
                statistics.linearisations, statistics.factorisations, statistics.iterations
            ));
        }
        if simulation.model().formulation.constrains() {
            let work = simulation.state().work;
            print(&format!(
                "  {} ends of steps projected, {:.1} evaluations of the creep law per right-hand side, {} lift-offs and landings\n",
                statistics.projections,
                work.force_iterations as f64 / statistics.evaluations.max(1) as f64,
                statistics.events
            ));
        }
    }
    match failure {
        Some(error) => Err(Failure::Run(error)),
        None => Ok(()),
    }
}

pub(super) fn open_csv(path: &Path) -> Result<Box<dyn Write>, Failure> {
    if path == Path::new("-") {
        return Ok(Box::new(std::io::stdout().lock()));
    }
    let file = std::fs::File::create(path).map_err(|error| Failure::Input(super::unwritable(path, &error)))?;
    Ok(Box::new(std::io::BufWriter::new(file)))
}

/// A reader that has seen enough (`| head`) is no error.
pub(super) fn closed_pipe(error: &csv::Error) -> bool {
    matches!(error.kind(), csv::ErrorKind::Io(error) if error.kind() == std::io::ErrorKind::BrokenPipe)
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
    const SHOWN: [(&str, &str, &str, f64); 9] = [
        ("y", "lateral displacement", "mm", 1e3),
        ("yaw", "yaw", "mrad", 1e3),
        ("roll", "roll", "mrad", 1e3),
        ("left.verticalForce", "Q left", "kN", 1e-3),
        ("right.verticalForce", "Q right", "kN", 1e-3),
        ("left.lateralForce", "Y left", "kN", 1e-3),
        ("right.lateralForce", "Y right", "kN", 1e-3),
        ("left.derailmentQuotient", "Y/Q left", "-", 1.0),
        ("right.derailmentQuotient", "Y/Q right", "-", 1.0),
    ];
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
    let head = ["", "smallest", "largest", "at the end"].map(String::from);
    format!("{title}\n\n{}", table(&head, &rows))
}
