//! `wheelrail assess RESULT.csv|SCENE`: limits of EN 14363, comfort, derailment and wear of a run, as a table and a page.

mod html;
mod pictures;
mod report;

use super::interrupt::Interrupt;
use super::output::{Kind, Target, write_whole};
use super::progress::Progress;
use super::run::words;
use super::{Failure, TimeArguments, print, refused, say};
use crate::scene::improbable::improbable;
use crate::scene::load;
use crate::scene::spec::Scene;
use crate::settings::did_you_mean;
use crate::sim::recording::{self, Recording, Times};
use crate::sim::vehicle_outputs::scene_outputs;
use crate::solve::Doubts;
use crate::study::assess::aliased::aliased;
use crate::study::assess::known::{Known, Vehicle};
use crate::study::assess::origin::{left_out, misfits};
use crate::study::assess::quantity::{self, VehicleKind};
use crate::study::assess::signals::Signals;
use crate::study::assess::{Assessment, Row, Verdict};
use crate::study::digits::rounded;
use crate::units::Dimension;
use clap::{Args, ValueEnum};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(after_long_help = "\
A SCENE is run with the outputs that are needed (motion, wheels, sensors; every 2 ms, and once more every 0.4 ms where forces of every other row say \
something else: impacts between rows). What a run notes (wheels that unload or strike their rail) is on stderr. Of a RESULT.csv \
the limits that depend on axle loads, curves, profiles or friction need its scene, --scene SCENE. What can't be assessed says why and what to record.

Exit code: 0 no limit is exceeded, 1 the run failed, 2 bad input or nothing to assess, 3 a limit is exceeded (or the vehicle derailed). What \
is not assessable does not change it. docs/assess.md has definitions and sources.")]
pub(super) struct Arguments {
    /// Results of `wheelrail run -o` (a name that ends in .csv), or a scene file or the name of an embedded scene
    #[arg(value_name = "RESULT.csv|SCENE")]
    input: String,
    /// The scene that a RESULT.csv comes from
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    /// Change a value of the scene, e.g. --set vehicle.speed=30
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    times: TimeArguments,
    /// Limits of this kind of vehicle
    #[arg(long, value_enum, default_value = "passenger")]
    vehicle: Kinds,
    /// Admissible speed, for the limit of Q; m/s or with a unit [default: the highest of the run]
    #[arg(long, value_name = "V", value_parser = speed)]
    admissible_speed: Option<f64>,
    /// Limit that takes the place of the standard's, SI or with a unit, e.g. --limit "y_qst=72 kN" (keys: --json)
    #[arg(long = "limit", value_name = "KEY=VALUE")]
    limits: Vec<String>,
    /// Write the outputs of the run of a SCENE as CSV
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Write table and pictures as one HTML page
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// Print the result as JSON (SI units)
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kinds {
    Passenger,
    Locomotive,
    Freight,
}

impl From<Kinds> for VehicleKind {
    fn from(kind: Kinds) -> Self {
        match kind {
            Kinds::Passenger => VehicleKind::Passenger,
            Kinds::Locomotive => VehicleKind::Locomotive,
            Kinds::Freight => VehicleKind::Freight,
        }
    }
}

/// Output intervals of a run, s (comfort reaches to 100 Hz), and where forces hang on them.
const STEPS: [f64; 2] = [2e-3, 0.4e-3];
/// Values that hang on the rows that are told.
const HANGING_SHOWN: usize = 3;
/// Parts that a result lacks that are named.
const LEFT_OUT_SHOWN: usize = 4;
/// Outputs that a run records.
const GROUPS: [&str; 3] = ["motion", "wheels", "sensors"];

/// What is assessed, and what is known of it.
struct Subject {
    title: String,
    signals: Signals,
    vehicle: Option<Vehicle>,
    /// Why a run ended early.
    ended: Option<Ended>,
    /// What a run says beside its results.
    notes: Vec<String>,
    doubts: Doubts,
    /// Of a run, whose rows may be made nearer.
    recording: Option<Recording>,
}

struct Ended {
    reason: String,
    time: f64,
    stop: f64,
    derailed: bool,
}

pub(super) fn assess(arguments: &Arguments) -> Result<(), Failure> {
    let limits = arguments.limits.iter().map(|text| limit(text)).collect::<Result<Vec<_>, _>>()?;
    // Whatever can't be written is better known before the work.
    if let Some(file) = &arguments.html {
        Target::find(file, Kind::Html).map_err(refused)?;
    }
    let target = super::csv_target(&arguments.output, arguments.json)?;
    let is_result = Path::new(&arguments.input).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    let mut subject = if is_result { result(arguments)? } else { run(arguments, STEPS[0])? };
    let (mut known, mut found) = of(&subject, arguments, &limits)?;
    let mut hanging = aliased(&subject.signals, &known, &found);
    if !hanging.is_empty() && subject.recording.is_some() && arguments.times.step.is_none() {
        say(&format!("note: forces hang on the rows ({}): run again with rows every {} ms", hanging[0], rounded(1e3 * STEPS[1])));
        subject = run(arguments, STEPS[1])?;
        (known, found) = of(&subject, arguments, &limits)?;
        hanging = aliased(&subject.signals, &known, &found);
    }
    if let (Some(target), Some(recording)) = (&target, &subject.recording) {
        write(target, recording)?;
    }
    words::messages(&subject.notes, &[], subject.doubts);
    for one in hanging.iter().take(HANGING_SHOWN) {
        let how = if subject.recording.is_some() { "--step" } else { "run.step" };
        say(&format!("warning: {one}: rows every {} ms are too far apart for it, {how} makes them nearer", rounded(1e3 * found.interval)));
    }
    if let Some(ended) = &subject.ended {
        found.rows.insert(0, early(ended));
    }
    if let Some(file) = &arguments.html {
        let page = html::page(&subject.title, &arguments.input, &found).map_err(Failure::Run)?;
        write_whole(file, page.as_bytes())?;
    }
    if arguments.json {
        print(&format!("{}\n", serde_json::json!({"input": arguments.input, "title": subject.title, "assessment": found})))?;
    } else {
        print(&report::text(&subject.title, &arguments.input, &found))?;
        if let Some(file) = &arguments.html {
            say(&format!("wrote {}", file.display()));
        }
    }
    match subject.ended {
        Some(ended) if !ended.derailed => Err(Failure::Run(ended.reason)),
        _ if found.fails() => Err(Failure::Exceeded),
        _ if !found.says_something() => Err(Failure::Input(format!("{}: nothing could be assessed; the table says why", arguments.input))),
        _ => Ok(()),
    }
}

/// What is known of a subject, and its assessment.
fn of(subject: &Subject, arguments: &Arguments, limits: &[(String, f64)]) -> Result<(Known, Assessment), Failure> {
    let (kind, admissible_speed) = (VehicleKind::from(arguments.vehicle), arguments.admissible_speed);
    let known = Known { kind, admissible_speed, vehicle: subject.vehicle.clone(), limits: limits.into() };
    let found = Assessment::of(&subject.signals, &known).map_err(|error| Failure::Input(format!("{}: {error}", arguments.input)))?;
    Ok((known, found))
}

/// The row of a run that did not come to its end.
fn early(ended: &Ended) -> Row {
    let quantity = &quantity::COMPLETED;
    let (value, limit) = (Some(ended.time), Some(ended.stop));
    Row { key: quantity.key, quantity, zone: None, place: String::new(), value, limit, verdict: Verdict::Fail, note: ended.reason.clone() }
}

fn open(name: &str, overrides: &[String]) -> Result<Scene, Failure> {
    let mut scene = load::open(name, overrides)?;
    scene.interface.outputs = GROUPS.into();
    scene.interface.only = None;
    scene.vehicle.sensors.iter_mut().for_each(|sensor| sensor.measured = true);
    Ok(scene)
}

fn vehicle_of(scene: &Scene) -> Result<Vehicle, Failure> {
    Vehicle::of(scene).map_err(|error| Failure::Run(format!("static loads, of straight, level, undisturbed track: {error}")))
}

fn result(arguments: &Arguments) -> Result<Subject, Failure> {
    for (given, name) in
        [(arguments.output.is_some(), "-o"), (arguments.times.stop.is_some() || arguments.times.step.is_some(), "--stop and --step")]
    {
        if given {
            return Err(Failure::Input(format!("{name}: that is for a SCENE that is run; {} has been run", arguments.input)));
        }
    }
    if arguments.scene.is_none() && !arguments.overrides.is_empty() {
        return Err(Failure::Input("--set changes a scene: name it with --scene".into()));
    }
    let failed = |error: &dyn std::fmt::Display| Failure::Input(format!("{}: {error}", arguments.input));
    let file = std::fs::File::open(&arguments.input).map_err(|error| failed(&error))?;
    let signals = Signals::read(std::io::BufReader::new(file)).map_err(|error| failed(&error))?;
    let opened = arguments.scene.as_deref().map(|name| open(name, &arguments.overrides)).transpose()?;
    let (title, vehicle) = match opened {
        Some(scene) => (scene.title.clone(), Some(vehicle_of(&scene)?)),
        None => (arguments.input.clone(), None),
    };
    let notes = vehicle.iter().flat_map(|vehicle| misfits(&signals, vehicle));
    let mut notes: Vec<String> = notes
        .map(|what| format!("{} may come from another scene: {what}; limits and sections are those of --scene", arguments.input))
        .collect();
    let lacking = vehicle.as_ref().map(|vehicle| left_out(&signals, vehicle)).unwrap_or_default();
    if !lacking.is_empty() {
        let count = lacking.len();
        let shown = lacking.into_iter().take(LEFT_OUT_SHOWN).collect::<Vec<_>>().join(", ");
        let more = if count > LEFT_OUT_SHOWN { format!(" and {} more", count - LEFT_OUT_SHOWN) } else { String::new() };
        notes.push(format!(
            "{} lacks columns of {shown}{more}: not looked at, wholly or in parts, and the table speaks of the rest alone; expected distance, forces and wearNumber of both wheels, measuredAx, measuredAy and measuredAz",
            arguments.input
        ));
    }
    Ok(Subject { title, signals, vehicle, ended: None, notes, doubts: Doubts::default(), recording: None })
}

fn run(arguments: &Arguments, step: f64) -> Result<Subject, Failure> {
    if arguments.scene.is_some() {
        return Err(Failure::Input("--scene belongs to a RESULT.csv; found a scene to run".into()));
    }
    let mut scene = open(&arguments.input, &arguments.overrides)?;
    let mut simulation = super::start(&scene)?;
    let vehicle = vehicle_of(&scene)?;
    scene.run.step = step;
    let (stop, step) = arguments.times.read(&scene)?;
    scene.run.stop = stop;
    let outputs = scene_outputs(&scene, simulation.model());
    let (progress, interrupt) = (Progress::new(stop), Interrupt::watch());
    let done = recording::record_while(&mut simulation, &outputs, Times { stop, step }, |row| {
        progress.at(row[0]);
        if interrupt.code().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    progress.finish();
    if let Some(code) = interrupt.code() {
        return Err(Failure::Interrupted(format!("interrupted at t = {} s; nothing was assessed", rounded(simulation.time())), code));
    }
    let (recording, ended) = match done {
        Ok(recording) => (recording, None),
        Err(early) => {
            let (reason, derailed) = (early.error.to_string(), early.error.is_derailed());
            (early.recording, Some(Ended { reason, time: simulation.time(), stop, derailed }))
        }
    };
    let words = |error: &dyn std::fmt::Display| match &ended {
        Some(ended) => format!("{}: {}; {error}", arguments.input, ended.reason),
        None => format!("{}: {error}", arguments.input),
    };
    let signals = Signals::of(&recording).map_err(|error| match &ended {
        Some(_) => Failure::Run(words(&error)),
        None => Failure::Input(words(&error)),
    })?;
    let mut notes = improbable(&scene, simulation.model());
    notes.extend(recording.all_notes(&simulation));
    Ok(Subject {
        title: scene.title,
        signals,
        vehicle: Some(vehicle),
        ended,
        notes,
        doubts: simulation.doubts(),
        recording: Some(recording),
    })
}

fn write(target: &Target, recording: &Recording) -> Result<(), Failure> {
    let mut text = Vec::new();
    recording.write_csv(&mut text).map_err(|error| Failure::Run(error.to_string()))?;
    Ok(target.write(&text)?)
}

/// Reads `KEY=VALUE` of `--limit`.
fn limit(text: &str) -> Result<(String, f64), Failure> {
    let wrong = |problem: String| Failure::Input(format!("--limit {text}: {problem}"));
    let (key, value) = text.split_once('=').ok_or_else(|| wrong("expected KEY=VALUE, such as y_qst=\"72 kN\"".into()))?;
    let keys = quantity::keys();
    let known = keys.iter().find(|known| **known == key.trim()).and_then(|key| quantity::by_key(key));
    let found = known.ok_or_else(|| wrong(format!("{key}{}: expected one of {}", did_you_mean(key, &keys), keys.join(", "))))?;
    let dimension = match found.unit {
        "kN" => Dimension::Force,
        "m/s2" => Dimension::Acceleration,
        _ => Dimension::None,
    };
    let number = dimension.parse(value).filter(|number| number.is_finite() && *number > 0.0);
    Ok((found.key.into(), number.ok_or_else(|| wrong(format!("{value}: expected {}, greater than 0", dimension.expectation())))?))
}

/// Reads a speed above 0.
fn speed(text: &str) -> Result<f64, String> {
    let found = Dimension::Speed.parse(text).filter(|speed| speed.is_finite() && *speed > 0.0);
    found.ok_or_else(|| format!("expected {}, greater than 0", Dimension::Speed.expectation()))
}
