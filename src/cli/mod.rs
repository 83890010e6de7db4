//! The command line: results on stdout, messages on stderr, exit code 0, 1 (run failed), 2 (bad input) or 3 (a limit is exceeded).

mod assess;
mod compare;
mod contact;
mod creep;
mod effects;
mod export;
mod hard;
mod interrupt;
mod list;
mod modes;
mod output;
mod overview;
mod plan;
mod plot;
mod profile;
mod progress;
mod results;
mod run;
mod scene;
mod study;
mod sweep;
mod table;

use crate::scene::assemble;
use crate::scene::improbable::improbable;
use crate::scene::load::{self, SceneError};
use crate::scene::patch_choice;
use crate::scene::profile_notes::profile_doubts;
use crate::scene::spec::{MOST_STEPS, Scene};
use crate::settings::{Entry, did_you_mean};
use crate::sim::Simulation;
use crate::units::Dimension;
use clap::{Args, Parser, Subcommand};
use output::{Kind, OutputError, Target, print};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Vehicles on real wheel/rail contact: from a scene file to a co-simulation FMU (FMI 2.0 or 3.0).
#[derive(Parser)]
#[command(name = "wheelrail", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a scene as an FMU and check it by loading and stepping it
    Export(export::Arguments),
    /// Simulate a scene natively: CSV, Parquet, MAT, SVG, summary; checkpoints of long runs
    Run(run::Arguments),
    /// Hold a run against EN 14363, comfort standards, Nadal's limit: limit table, HTML page
    Assess(assess::Arguments),
    /// Run a scene with every contact formulation: cost, differences, pictures
    Compare(compare::Arguments),
    /// Contact geometry of a wheelset over its lateral shift, equivalent conicity
    Contact(contact::Arguments),
    /// Compute creep forces of a table of contacts with one or several laws, or compare laws on random contacts
    Creep(creep::Arguments),
    /// Run a scene once per effect that it holds, without it or with a neighbour: what each contributes and costs
    Effects(effects::Arguments),
    /// Show what a scene makes the program compute, and what not
    Plan(plan::Arguments),
    /// Show a wheel or rail profile: table, CSV, diagram
    Profile(profile::Arguments),
    /// Run the hard cases: held, refused or broken, with numbers
    Hard(hard::Arguments),
    /// List scenes, profiles, laws, formulations, integrators ...
    List(list::Arguments),
    /// Eigenvalues and shapes of small motions about steady running; root locus over speed and critical speed
    Modes(modes::Arguments),
    /// Print an embedded scene, to start an own one from
    Scene(scene::Arguments),
    /// Measure what accuracy costs in time: formulations, integrators and tolerances against references
    Study(study::Arguments),
    /// Run a scene with many values: grids, lists, Latin hypercubes, in parallel; one row of numbers per run
    Sweep(sweep::Arguments),
    /// Compute the creep-force table of the creep law `usetab`
    Table(table::Arguments),
}

/// A scene and changes to it.
#[derive(Args)]
struct SceneArguments {
    /// A scene file, or the name of an embedded scene (see `wheelrail list scenes`)
    scene: String,
    /// Change a value of the scene, e.g. --set vehicle.speed=30 or --set "track.deviation[1].amplitude=5 mm"
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

impl SceneArguments {
    fn open(&self) -> Result<Scene, SceneError> {
        load::open(&self.scene, &self.overrides)
    }

    /// The overrides with which all of these formulations have the same patch, and words where that is another one than the scene's.
    fn alike(&self, scene: &Scene, formulations: &[&str]) -> (Vec<String>, Option<String>) {
        let change = patch_choice::alike(scene, formulations);
        let words = change.as_ref().map(|change| {
            format!("{change} for all, so that formulations differ in nothing else: not the contact that `run` has, which takes longer; name contact.patch to have another one")
        });
        (self.overrides.iter().cloned().chain(change).collect(), words)
    }
}

/// Which wheelset of a vehicle is shown.
#[derive(Args)]
struct WheelsetArgument {
    /// Wheelset to show, e.g. "truck[2].wheelset[2]" [default: the leading one]
    #[arg(long, value_name = "NAME")]
    wheelset: Option<String>,
}

impl WheelsetArgument {
    /// Its name.
    fn choose<'a>(&self, scene: &'a Scene) -> Result<&'a str, Failure> {
        let names: Vec<&str> = scene.vehicle.axles().into_iter().map(|axle| axle.0).collect();
        let Some(wanted) = &self.wheelset else { return Ok(&scene.vehicle.leading().name) };
        let unknown = || {
            let hint = did_you_mean(wanted, &names);
            Failure::Input(format!("--wheelset {wanted}{hint}: expected one of {}", names.join(", ")))
        };
        names.iter().find(|name| *name == wanted).copied().ok_or_else(unknown)
    }
}

/// Simulated time and its sampling.
#[derive(Args)]
struct TimeArguments {
    /// Stop time, s or with a unit [default: run.stop of the scene]
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = seconds)]
    stop: Option<f64>,
    /// Output step, s or with a unit, e.g. "4 ms" [default: run.step of the scene]
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = seconds)]
    step: Option<f64>,
}

impl TimeArguments {
    /// Stop time and output step, s.
    fn read(&self, scene: &Scene) -> Result<(f64, f64), Failure> {
        let stop = self.stop.unwrap_or(scene.run.stop);
        let step = self.step.unwrap_or(scene.run.step);
        if !(stop.is_finite() && stop >= 0.0) {
            return Err(Failure::Input(format!("--stop {stop}: expected a time of 0 s or more")));
        }
        if !(step.is_finite() && step > 0.0) {
            return Err(Failure::Input(format!("--step {step}: expected a time greater than 0 s")));
        }
        // A scene's own step may be longer than a short piece of it that is asked for.
        if self.step.is_some() && stop > 0.0 && step > stop {
            let whose = if self.stop.is_some() { "--stop" } else { "run.stop" };
            return Err(Failure::Input(format!("--step {step:?}: expected at most {whose} = {stop:?} s")));
        }
        if stop / step > MOST_STEPS {
            return Err(Failure::Input(format!("--step {step:?}: that would be {:.1e} output rows", stop / step)));
        }
        Ok((stop, step))
    }
}

/// Reads a time: "0.004" or "4 ms".
fn seconds(text: &str) -> Result<f64, String> {
    let plain = text.trim().parse::<f64>().ok();
    plain.or_else(|| Dimension::Time.parse(text)).ok_or_else(|| format!("expected {}", Dimension::Time.expectation()))
}

/// How a command failed: the exit code says whose turn it is.
enum Failure {
    /// The simulation could not be finished, or its results not be written (1).
    Run(String),
    /// What was asked for makes no sense (2).
    Input(String),
    /// What was assessed exceeds a limit (3); the table has said so.
    Exceeded,
    /// A signal asked for the end: words and exit code.
    Interrupted(String, u8),
}

/// What was computed could not be kept. An output that can't even begin is bad input: [`refused`].
impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Failure::Run(error.to_string())
    }
}

/// Of an output that is known to be impossible before the work.
fn refused(error: OutputError) -> Failure {
    Failure::Input(error.to_string())
}

/// Can a picture be written there?
fn check_picture(plot: &Option<PathBuf>) -> Result<(), Failure> {
    plot.as_ref().map_or(Ok(()), |file| Target::find(file, Kind::Svg).map(|_| ()).map_err(refused))
}

/// Where a table goes, if anywhere; known before the work.
fn csv_target(path: &Option<PathBuf>, json: bool) -> Result<Option<Target>, Failure> {
    target(path, Kind::Csv, json)
}

/// The same of results of a kind that may go to stdout.
fn target(path: &Option<PathBuf>, kind: Kind, json: bool) -> Result<Option<Target>, Failure> {
    let target = path.as_deref().map(|path| Target::find(path, kind)).transpose().map_err(refused)?;
    match json && target.as_ref().is_some_and(Target::is_stdout) {
        true => Err(Failure::Input("-o - and --json both write to stdout; choose one".into())),
        false => Ok(target),
    }
}

/// Makes a folder for results if there is none.
fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::Input(format!("{}: can't be made: {error}", folder.display())))
}

/// Names of files, for JSON.
fn file_names(files: &[PathBuf]) -> Vec<String> {
    files.iter().map(|file| file.display().to_string()).collect()
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Failure::Input(error.to_string())
    }
}

/// Runs the command of `std::env::args`.
pub fn main() -> ExitCode {
    let parsed = match Cli::try_parse() {
        Ok(parsed) => parsed,
        Err(words) => return said(&words),
    };
    crate::scene::table_store::tell();
    let done = match parsed.command {
        Command::Export(arguments) => export::export(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Assess(arguments) => assess::assess(&arguments),
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Contact(arguments) => contact::contact(&arguments),
        Command::Creep(arguments) => creep::creep(&arguments),
        Command::Effects(arguments) => effects::effects(&arguments),
        Command::Plan(arguments) => plan::plan(&arguments),
        Command::Profile(arguments) => profile::profile(&arguments),
        Command::Hard(arguments) => hard::hard(&arguments),
        Command::List(arguments) => list::list(&arguments),
        Command::Modes(arguments) => modes::modes(&arguments),
        Command::Scene(arguments) => scene::scene(&arguments),
        Command::Study(arguments) => study::study(&arguments),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Table(arguments) => table::table(&arguments),
    };
    let (message, code) = match done {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Run(message)) => (message, 1),
        Err(Failure::Input(message)) => (message, 2),
        Err(Failure::Exceeded) => return ExitCode::from(3),
        Err(Failure::Interrupted(message, code)) => {
            say(&message);
            return ExitCode::from(code);
        }
    };
    say(&format!("error: {message}"));
    ExitCode::from(code)
}

/// Prints what is asked for or wrong on the command line itself.
fn said(words: &clap::Error) -> ExitCode {
    use std::io::{ErrorKind, Write};
    match words.print().and_then(|()| std::io::stdout().flush()) {
        Err(problem) if !words.use_stderr() && problem.kind() != ErrorKind::BrokenPipe => {
            say(&format!("error: {}", OutputError::Stdout { problem }));
            ExitCode::from(1)
        }
        _ => ExitCode::from(words.exit_code() as u8),
    }
}

/// Prints a message to stderr, if anybody listens.
fn say(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// What a user should know, below a table.
fn notes(doubts: Vec<String>) -> String {
    doubts.into_iter().map(|doubt| format!("\n  note: {doubt}\n")).collect()
}

/// Starts a simulation; a scene without equilibrium is bad input, and what is doubtful in it may be why. Where it takes long, it says so, and what in the profiles may be why.
fn start(scene: &Scene) -> Result<Simulation, Failure> {
    start_of(scene, &scene.source.file)
}

/// The same of a scene that its user knows by another file.
fn start_of(scene: &Scene, file: &str) -> Result<Simulation, Failure> {
    const LONG: Duration = Duration::from_secs(3);
    let (done, waits) = channel::<()>();
    let started = std::thread::scope(|scope| {
        scope.spawn(move || {
            if waits.recv_timeout(LONG) == Err(RecvTimeoutError::Timeout) {
                say(
                    "the balance in which the run begins is looked for, which may take a minute in tight curves, minutes on profiles that are not smooth",
                );
                profile_doubts(scene).iter().for_each(|doubt| say(&format!("note: {doubt}")));
            }
        });
        let started = Simulation::new(scene, 0.0);
        drop(done);
        started
    });
    started.map_err(|error| {
        let doubts = assemble::model(scene).map(|model| improbable(scene, &model)).unwrap_or_default();
        doubts.iter().for_each(|doubt| say(&format!("note: {doubt}")));
        Failure::Input(format!("{file}: {error}"))
    })
}

fn names<P>(registry: &'static [Entry<P>]) -> Vec<&'static str> {
    registry.iter().map(|entry| entry.name).collect()
}

/// Those that are named out of the known ones, in the order of these; all where none is named.
fn chosen(flag: &str, names: &[String], known: Vec<&'static str>) -> Result<Vec<&'static str>, Failure> {
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        let hint = did_you_mean(name, &known);
        return Err(Failure::Input(format!("{flag} {name}{hint}: expected some of {}", known.join(", "))));
    }
    Ok(known.into_iter().filter(|known| names.is_empty() || names.iter().any(|name| name == known)).collect())
}

/// Columns of text, the first one left-aligned, the others right-aligned.
fn table(head: &[String], rows: &[Vec<String>]) -> String {
    let width = |column: usize| rows.iter().chain([&head.to_vec()]).map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let line = |row: &[String]| {
        let cells = row.iter().zip(&widths).enumerate().map(|(i, (cell, width))| {
            let pad = " ".repeat(width - cell.chars().count());
            if i == 0 { format!("{cell}{pad}") } else { format!("{pad}{cell}") }
        });
        format!("  {}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    let mut text = line(head);
    for row in rows {
        text += &line(row);
    }
    text
}
