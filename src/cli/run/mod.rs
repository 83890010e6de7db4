//! `wheelrail run SCENE`: a native simulation with CSV, Parquet or MAT, pictures, a summary, and checkpoints to go on from.

mod checkpoints;
mod inputs;
pub(super) mod words;

use super::interrupt::Interrupt;
use super::output::{Kind, Target, same_file};
use super::progress::Progress;
use super::results::{Format, Layout, Precision, Results, Thinned};
use super::{Failure, SceneArguments, TimeArguments, WheelsetArgument, overview, print, seconds};
use crate::scene::improbable::improbable;
use crate::scene::spec::{PatchSpec, Scene};
use crate::settings::did_you_mean;
use crate::sim::Simulation;
use crate::sim::balance::{is_booked, open_books};
use crate::sim::checkpoint::Origin;
use crate::sim::outputs::Output;
use crate::sim::pattern::matches;
use crate::sim::recording::{Recording, Run, Times};
use crate::sim::statics;
use crate::sim::vehicle_outputs::scene_outputs;
use crate::study::digits::rounded;
use crate::study::modes::rest::unstable_rest;
use checkpoints::{CheckpointArguments, Keeper};
use clap::{Args, ValueEnum};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use words::{messages, summary, work};

#[derive(Args)]
#[command(after_long_help = "\
Ctrl-C (or SIGTERM) ends the run in order: the rows so far are written, pictures and summary are made of them, the exit code is 130 \
(143); a second one ends the program at once. Rows of CSV are written to FILE.csv.XXXXXX.part beside FILE.csv, which keeps what it has until \
the end; after a kill what was computed is in that file. Parquet and MAT are written at the end.

A run with --checkpoint can go on after a kill: the same command with --resume FILE gives the same results, bit for bit.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Inputs over time: a CSV with a column "time" (s) and columns of the FMU's inputs by name, straight between rows, held before and after;
    /// two rows of one time are a jump
    #[arg(long, value_name = "FILE.csv")]
    inputs: Option<PathBuf>,
    #[command(flatten)]
    results: ResultArguments,
    /// Draw the run over distance as SVG into a folder: motions, forces, bodies, contact places, spectra
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// Lay another run over the pictures, dashed: a CSV with outputs of the same names
    #[arg(long, value_name = "FILE.csv", requires = "plot")]
    against: Option<PathBuf>,
    #[command(flatten)]
    wheelset: WheelsetArgument,
    #[command(flatten)]
    times: TimeArguments,
    #[command(flatten)]
    checkpoints: CheckpointArguments,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

/// What of the rows goes into a file.
#[derive(Args)]
struct ResultArguments {
    /// Write outputs as .csv, .parquet or .mat ("-": CSV to stdout)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write only outputs of these names: * stands for any letters, ? for one, e.g. "*.verticalForce,wheelset.y" [default: all]
    #[arg(long, value_name = "PATTERN[,PATTERN]", value_delimiter = ',')]
    columns: Vec<String>,
    /// Precision of the numbers; times and distances are float64 (in .mat all numbers have one precision)
    #[arg(long, value_enum, default_value_t)]
    precision: Precision,
    /// Write a row every so often, s or with a unit: a multiple of the output step, low-pass filtered without delay so that nothing folds
    #[arg(long, value_name = "T", value_parser = seconds, requires = "output")]
    every: Option<f64>,
    /// First column, and the index that pandas takes from Parquet: time, or distance of the shown wheelset
    #[arg(long, value_enum, default_value_t)]
    index: Index,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, ValueEnum)]
enum Index {
    #[default]
    Time,
    Distance,
}

/// Outputs of the shown wheelset that the summary needs: name, label, unit, factor.
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

/// Results do not go over the table of inputs that made them.
fn not_over_inputs(arguments: &Arguments) -> Result<(), Failure> {
    match arguments.inputs.as_ref().zip(arguments.results.output.as_ref()).filter(|(given, output)| same_file(given, output)) {
        None => Ok(()),
        Some((given, output)) => {
            Err(Failure::Input(format!("-o {}: --inputs reads {}; expected another file", output.display(), given.display())))
        }
    }
}

/// What the run has shown, judged by books that are `books` to be closed and where the run is a `whole` one.
fn last_notes(scene: &Scene, simulation: &mut Simulation, recording: &Recording, [books, whole]: [bool; 2]) -> Vec<String> {
    let mut notes = recording.all_notes(simulation);
    notes.extend(books.then(|| open_books(recording)).flatten());
    notes.extend(whole.then(|| unstable_rest(scene, simulation)).flatten());
    notes
}

/// What is known of scene and start before the run.
fn first_notes(scene: &Scene, simulation: &mut Simulation, of_inputs: Option<String>) -> Vec<String> {
    let mut notes = improbable(scene, simulation.model());
    notes.extend(of_inputs);
    notes.extend(statics::statics(scene, simulation).map(|found| found.notes(scene)).unwrap_or_default());
    // A patch that an effect's absence has chosen is part of what changes.
    let PatchSpec { law, why } = scene.contact.patch;
    notes.extend(why.filter(|why| why.starts_with("effects.")).map(|why| format!("contact.patch is {}: {why}", law.name())));
    notes.extend(scene.effects.describe().into_iter().map(|(name, why)| format!("left out: {name}, {why}")));
    notes
}

/// Do the books of energy close by themselves: are all parts shown, and is there nothing that curves turn without a book (`formulation::energy`), such as supported loads and
/// suspensions whose frame travels with the wheelset?
fn books_close(scene: &Scene) -> bool {
    let vehicle = &scene.vehicle;
    let supported = vehicle.wheelsets.iter().any(|wheelset| wheelset.spec.vertical_load != 0.0);
    let suspended = vehicle.forces.iter().any(|element| vehicle.suspended_by(element.0.name()).is_some());
    scene.interface.only.is_none() && !(scene.track.alignment.is_some() && (supported || suspended))
}

/// Draws the overview and says which files it wrote.
fn draw(folder: &Path, drawn: &overview::Drawn) -> Result<(), String> {
    let files = overview::draw(folder, drawn)?;
    files.iter().for_each(|file| super::say(&format!("wrote {}", file.display())));
    Ok(())
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut scene = arguments.scene.open()?;
    let inputs = arguments.inputs.as_deref().map(|path| inputs::read(path, &mut scene)).transpose()?;
    let origin = Origin::of(&scene).with_inputs(inputs.as_ref().map(|inputs| inputs.text.as_str()));
    let (stop, step) = arguments.times.read(&scene)?;
    let times = Times { stop, step };
    scene.run.stop = stop;
    let wheelset = arguments.wheelset.choose(&scene)?;
    // Whatever can't be written or go on is better known before the run.
    let asked = &arguments.results;
    let target = super::target(&asked.output, Kind::Results, arguments.json)?;
    let to_stdout = target.as_ref().is_some_and(Target::is_stdout);
    asked.check(times).and_then(|()| not_over_inputs(arguments))?;
    let found = arguments.checkpoints.found(&origin, times)?;
    let mut simulation = super::start(&scene)?;
    if let Some(folder) = &arguments.plot {
        overview::prepare(folder, &scene.interface.outputs)?;
    }
    let all = scene_outputs(&scene, simulation.model());
    check_columns(&asked.columns, &all)?;
    // What nobody reads is not computed.
    let read = target.is_some() || arguments.json;
    let against = arguments.against.as_deref().map(|path| overview::Reference::read(path, &all, wheelset)).transpose()?;
    let wanted = |name: &str| read && asked.wants(name);
    let shown = |name: &str| name.strip_prefix(wheelset).is_some_and(|rest| SHOWN.iter().any(|one| rest.strip_prefix('.') == Some(one.0)));
    let drawn = |output: &Output| arguments.plot.is_some() && overview::needs(output, wheelset);
    let index = |name: &str| asked.index == Index::Distance && name.strip_prefix(wheelset) == Some(".distance");
    // Books are judged whole.
    let books = books_close(&scene) && all.iter().any(|output| is_booked(&output.name) && wanted(&output.name));
    let named = |name: &str| wanted(name) || shown(name) || index(name) || books && is_booked(name);
    let needed = |output: &Output| named(&output.name) || drawn(output);
    let outputs: Vec<Output> = match &found {
        None => all.into_iter().filter(needed).collect(),
        Some(found) => checkpoints::columns(found, all, needed)?,
    };
    let layout = asked.layout(&outputs, wanted, wheelset, times)?;
    let of_inputs = inputs.as_ref().and_then(|inputs| inputs.note(stop));
    let mut notes = first_notes(&scene, &mut simulation, of_inputs);
    notes.extend(asked.unread(arguments.json));
    let mut run = Run::new(&simulation, &outputs);
    run.inputs = inputs.map(|inputs| inputs.table);
    let mut keeper = arguments.checkpoints.keeper((&scene.name, &origin), times, (&outputs, asked.output.as_deref()), found.as_ref())?;
    if let Some(found) = &found {
        checkpoints::go_on(found, &mut simulation, &mut run)?;
    }
    let interrupt = Interrupt::watch();
    let (written, mut failure) =
        integrate(&mut simulation, &mut run, (&outputs, times), &interrupt, (target.as_ref(), layout), &mut keeper)?;
    let elapsed = keeper.elapsed();
    let simulated = simulation.time();
    run.events.extend(simulation.take_events());
    let events: Vec<String> = run.events.iter().map(ToString::to_string).collect();
    let recording = run.end();
    let ended = interrupt.code().filter(|_| failure.is_none() && simulated < times.stop).map(|code| {
        let kept = match &asked.output {
            Some(path) if !to_stdout => format!("{written} rows until then are in {}", path.display()),
            _ => format!("{} rows until then", recording.rows.len()),
        };
        (format!("interrupted at t = {} s of {} s: {kept}{}", rounded(simulated), rounded(times.stop), keeper.words()), code)
    });
    if let Some(folder) = &arguments.plot {
        let drawn =
            overview::Drawn { scene: &scene, model: simulation.model(), wheelset, recording: &recording, against: against.as_ref() };
        failure = failure.or(draw(folder, &drawn).err());
    }
    let whole = failure.is_none() && ended.is_none();
    notes.extend(last_notes(&scene, &mut simulation, &recording, [books, whole]));
    messages(&notes, &events, simulation.doubts());
    if arguments.json {
        let error = failure.as_ref().or(ended.as_ref().map(|ended| &ended.0));
        let shown = |name: &str| name == "time" || wanted(name);
        let value = words::json(&scene.name, (&simulation, elapsed), (&recording, &shown), (&events, &notes), error);
        print(&format!("{value}\n"))?;
    } else if !to_stdout {
        print(&summary(&scene.title, (wheelset, scene.vehicle.axles().len() == 1), &recording))?;
        print(&work(&scene, &simulation, elapsed, times.step))?;
    }
    match (failure, ended) {
        (Some(error), _) => Err(Failure::Run(error)),
        (None, Some((words, code))) => Err(Failure::Interrupted(words, code)),
        (None, None) => Ok(()),
    }
}

/// Runs to the stop time, a failure or a signal; writes the chosen columns of each row to a target, those of a run that goes on again. Returns how many
/// rows were written, and what failed.
fn integrate(
    simulation: &mut Simulation,
    run: &mut Run,
    (outputs, times): (&[Output], Times),
    interrupt: &Interrupt,
    (target, layout): (Option<&Target>, Layout),
    keeper: &mut Keeper,
) -> Result<(usize, Option<String>), Failure> {
    let mut results = target.map(|target| Results::begin(target, &Recording::new(outputs), layout)).transpose()?;
    let mut broken = results.as_mut().and_then(|results| run.recording.rows.iter().find_map(|row| results.write(row).err()));
    let progress = Progress::new(times.stop);
    let mut lost = None;
    let done = match broken {
        Some(_) => Ok(()),
        None => run.go_on(simulation, outputs, times, |simulation, run| {
            let Some(row) = run.recording.rows.last() else { return ControlFlow::Continue(()) };
            progress.at(row[0]);
            broken = results.as_mut().and_then(|results| results.write(row).err());
            lost = keeper.look(simulation, run).err();
            let ends = broken.is_some() || lost.is_some() || interrupt.code().is_some();
            if ends { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }),
    };
    progress.finish();
    if done.is_ok() && lost.is_none() {
        lost = keeper.end(simulation, run).err();
    }
    // What was computed before a failure is written too.
    let written = match (results, broken) {
        (Some(results), Some(error)) => results.fail(error).map(|()| 0),
        (Some(results), None) => results.finish(),
        (None, _) => Ok(0),
    };
    let failure = done.err().map(|error| error.to_string()).or(lost.map(|error| error.to_string()));
    Ok(match written {
        Ok(rows) => (rows, failure),
        Err(error) => (0, failure.or(Some(error.to_string()))),
    })
}

impl ResultArguments {
    fn wants(&self, name: &str) -> bool {
        self.columns.is_empty() || self.columns.iter().any(|pattern| matches(pattern, name))
    }

    /// Options about a file where none is written.
    fn unread(&self, json: bool) -> Option<String> {
        let given = [
            ("--columns", !self.columns.is_empty() && !json),
            ("--precision", self.precision != Precision::default()),
            ("--index", self.index != Index::default()),
        ];
        let names: Vec<&str> = given.iter().filter(|(_, given)| *given && self.output.is_none()).map(|(name, _)| *name).collect();
        (!names.is_empty()).then(|| format!("{}: about rows that are written; -o FILE writes them", names.join(", ")))
    }

    /// How many output steps lie between two rows of the file.
    fn factor(&self, step: f64) -> Option<usize> {
        self.every.map(|every| (every / step).round() as usize)
    }

    fn check(&self, Times { stop, step }: Times) -> Result<(), Failure> {
        if let (Some(every), Some(factor)) = (self.every, self.factor(step)) {
            let multiple = factor >= 1 && (every / step - factor as f64).abs() < 1e-6;
            if !(every.is_finite() && multiple && (every <= stop || factor == 1)) {
                return Err(Failure::Input(format!(
                    "--every {every:?}: expected a multiple of the output step of {step:?} s, up to the stop at {stop:?} s"
                )));
            }
        }
        let mat = self.output.as_deref().is_some_and(|path| Format::of(path) == Format::Mat);
        match self.index == Index::Distance && mat {
            true => Err(Failure::Input("--index distance: rows of a MAT file stand over time; distances are among its outputs".into())),
            false => Ok(()),
        }
    }

    /// Which columns of a row go into the file: the index, then those of the chosen names.
    fn layout(&self, outputs: &[Output], wanted: impl Fn(&str) -> bool, wheelset: &str, times: Times) -> Result<Layout, Failure> {
        let mut chosen: Vec<usize> =
            [0].into_iter().chain((0..outputs.len()).filter(|index| wanted(&outputs[*index].name)).map(|index| index + 1)).collect();
        if self.index == Index::Distance {
            let name = format!("{wheelset}.distance");
            let place = outputs.iter().position(|output| output.name == name);
            let place =
                place.ok_or_else(|| Failure::Input(format!("--index distance needs {name}; add \"motion\" to interface.outputs")))?;
            chosen.retain(|column| *column != place + 1);
            chosen.insert(0, place + 1);
        }
        let time = chosen.iter().position(|column| *column == 0).unwrap_or(0);
        // The last row of a run may stand nearer than the others.
        let even = (times.stop / times.step + 1e-9) as usize + 1;
        let thinned = self.factor(times.step).map(|factor| Thinned::new(factor, vec![time], even));
        Ok(Layout { chosen, precision: self.precision, thinned })
    }
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
