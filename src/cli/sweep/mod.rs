//! `wheelrail sweep SCENE --set KEY=FROM..TO:STEP ... -o FILE.csv`: many runs of a scene, one row each.

mod numbers;
mod parquet;
mod picture;
mod report;
mod table;

use super::interrupt::Interrupt;
use super::output::{Kind, Target};
use super::progress::bar;
use super::{Failure, TimeArguments, check_picture, print, refused, say};
use crate::scene::load;
use crate::scene::spec::Scene;
use crate::sim::vehicle_outputs::scene_outputs;
use crate::study::variation::design::{self, Points};
use crate::study::variation::parameter::Parameter;
use crate::study::variation::single::{self, Asked};
use clap::Args;
use numbers::Numbers;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use table::{Columns, Results, Row};

#[derive(Args)]
#[command(after_long_help = "\
VALUES: a list (x,y,z), a range with a step (20..40:5, \"72..144:18 km/h\"), with --latin a range without one (0.1..0.5), or one value for all runs. \
Seeds of irregularities are values like others: --set \"track.irregularity[1].seed=1..20:1\".

FILE.csv gets a row as each run ends: the values, how it ended (ok, derailed, failed, refused, with time and reason; of runs that are ok what they note, such as a wheel that unloads), the scalars of its rows. What goes \
wrong in a run is its row. The same command goes on where an interrupted or killed one ended: runs that have a row are not run again; at the end rows stand in order. \
A file of another scene, other values or other scalars is refused.

KIND:OUTPUT of --scalar: min, max, absmax, mean, rms, end, or a percentile (p0.15, p50, p99.85) of all outputs of that name (* any letters, ? one) together. \
Own expressions have a name, a unit if you like, and such numbers in braces: --scalar \"unloading = 1 - {min:*.verticalForce} / {mean:*.verticalForce}\".

Exit code: 0 at least one run is ok, 1 none is, 2 bad input.")]
pub(super) struct Arguments {
    /// A scene file, or the name of an embedded scene (see `wheelrail list scenes`)
    scene: String,
    /// Values of a key of the scene: a list, a range, or one value
    #[arg(long = "set", value_name = "KEY=VALUES", required = true)]
    parameters: Vec<String>,
    /// Draw N runs from the ranges (Latin hypercube) instead of every combination
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    latin: Option<u32>,
    /// Seed of --latin
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// A number of each run, e.g. "max:*.verticalForce" [default: extremes of Q, Y/Q, sum of Y, displacement, wear, accelerations]
    #[arg(long = "scalar", value_name = "[NAME=]KIND:OUTPUT")]
    scalars: Vec<String>,
    /// Table of the runs
    #[arg(short, long, value_name = "FILE.csv")]
    output: PathBuf,
    /// Write the table as Parquet too, once all runs have ended
    #[arg(long, value_name = "FILE.parquet")]
    parquet: Option<PathBuf>,
    /// Runs at the same time [default: the number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    parallel: Option<u16>,
    /// Draw the scalars over the values as SVG: lines for one key, heat maps for two, points for more
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    times: TimeArguments,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

/// What is to be run.
struct Sweep {
    scene: String,
    title: String,
    parameters: Vec<Parameter>,
    points: Points,
    numbers: Numbers,
    asked: Asked,
}

pub(super) fn sweep(arguments: &Arguments) -> Result<(), Failure> {
    let input = |error: &dyn std::fmt::Display| Failure::Input(error.to_string());
    let parameters: Vec<Parameter> =
        arguments.parameters.iter().map(|text| Parameter::parse(text)).collect::<Result<_, _>>().map_err(|error| input(&error))?;
    for (key, given) in [("run.stop", &arguments.times.stop), ("run.step", &arguments.times.step)] {
        if given.is_some() && parameters.iter().any(|parameter| parameter.key == key) {
            return Err(Failure::Input(format!("--set {key}: --{} goes before it; expected one of them", key.trim_start_matches("run."))));
        }
    }
    if !parameters.iter().any(Parameter::varies) {
        return Err(Failure::Input("--set: nothing varies; give a key a list (x,y) or a range (20..40:5)".into()));
    }
    let points = match arguments.latin {
        Some(runs) => design::latin(&parameters, runs as usize, arguments.seed),
        None => design::grid(&parameters),
    };
    let points = points.map_err(|error| input(&error))?;
    // Whatever can't be written is better known before the work.
    let target = Target::find(&arguments.output, Kind::Csv).map_err(refused)?;
    if !target.is_plain_file() {
        return Err(Failure::Input(format!("{}: a sweep is written to a file, in which it can go on", arguments.output.display())));
    }
    let columnar = arguments.parquet.as_ref().map(|file| Target::find(file, Kind::Parquet)).transpose().map_err(refused)?;
    check_picture(&arguments.plot)?;
    let fixed: Vec<String> = changes(&parameters, &points[0], |parameter| !parameter.varies());
    // Keys that vary may belong to the scene: a file of a kind of profile.
    let base = load::open(&arguments.scene, &fixed).or_else(|error| {
        let whole = points.iter().find_map(|point| load::open(&arguments.scene, &changes(&parameters, point, |_| true)).ok());
        whole.ok_or(error)
    })?;
    arguments.times.read(&base)?;
    refuse_if_all_are(arguments, &parameters, &points)?;
    let numbers = {
        let simulation = super::start(&base)?;
        Numbers::new(&arguments.scalars, &base.vehicle.leading().name, &scene_outputs(&base, simulation.model()))?
    };
    let asked = Asked { stop: arguments.times.stop, step: arguments.times.step };
    let columns = Columns::new(&parameters, &numbers.shown, fingerprint(&base, asked, &arguments.scalars, &points));
    let results = Results::open(&arguments.output, columns, &table::all_cells(&parameters, &points)).map_err(Failure::Input)?;
    let sweep = Sweep { scene: arguments.scene.clone(), title: base.title.clone(), parameters, points, numbers, asked };
    let interrupt = Interrupt::watch();
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let results = run(&sweep, results, arguments.parallel.map_or_else(cores, usize::from), &interrupt)?;
    if let Some(code) = interrupt.code() {
        let (done, all, file) = (results.rows.len(), sweep.points.len(), arguments.output.display());
        return Err(Failure::Interrupted(format!("interrupted: {done} of {all} runs are in {file}; the same command goes on"), code));
    }
    let (columns, rows) = results.finish(&target)?;
    if let Some(target) = columnar {
        let mut pending = target.begin()?;
        match parquet::write(&mut pending, &columns, &rows) {
            Ok(()) => pending.finish(),
            Err(problem) => pending.fail(problem),
        }?;
    }
    if let Some(file) = &arguments.plot {
        picture::sheet(&sweep, &columns, &rows, arguments.latin.is_some()).draw(file).map_err(Failure::Run)?;
    }
    let summary = report::summary(&columns, &rows);
    if arguments.json {
        print(&format!("{}\n", report::json(&sweep.scene, &arguments.output, &summary)))?;
    } else {
        print(&report::text(&sweep.scene, &sweep.title, &summary))?;
        [Some(&arguments.output), arguments.parquet.as_ref(), arguments.plot.as_ref()]
            .into_iter()
            .flatten()
            .for_each(|file| say(&format!("wrote {}", file.display())));
    }
    if summary.states[0].1 == 0 { Err(Failure::Run("no run is ok; the table says why".into())) } else { Ok(()) }
}

/// Changes of a scene: those parameters' values of one run.
fn changes(parameters: &[Parameter], point: &[String], wanted: impl Fn(&Parameter) -> bool) -> Vec<String> {
    let both = parameters.iter().zip(point);
    both.filter(|(parameter, _)| wanted(parameter)).map(|(parameter, value)| format!("{}={value}", parameter.key)).collect()
}

/// Eight digits that tell one scene from another: its text with the changes for all runs, its files and those that values of single runs name, times, and expressions, of
/// which columns have the name alone.
fn fingerprint(base: &Scene, asked: Asked, scalars: &[String], points: &Points) -> String {
    let mut hash = Sha256::new();
    hash.update(&base.source.text);
    base.files().for_each(|file| hash.update(&file.content));
    let values: BTreeSet<&str> = points.iter().flatten().map(String::as_str).collect();
    let folder = base.source.folder.as_deref().unwrap_or(Path::new(""));
    // A file's name alone, or quoted in a table or a list.
    let names = values.iter().flat_map(|value| std::iter::once(*value).chain(value.split('"').skip(1).step_by(2)));
    let files: BTreeSet<PathBuf> = names.filter(|name| !name.is_empty()).map(|name| folder.join(name)).collect();
    files.iter().filter(|file| file.is_file()).filter_map(|file| std::fs::read(file).ok()).for_each(|content| hash.update(content));
    for time in [asked.stop.unwrap_or(base.run.stop), asked.step.unwrap_or(base.run.step)] {
        hash.update(time.to_bits().to_le_bytes());
    }
    scalars.iter().filter(|text| text.contains('=')).for_each(|text| hash.update(text));
    hash.finalize()[..4].iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Makes the runs that have no row yet.
fn run(sweep: &Sweep, results: Results, parallel: usize, interrupt: &Interrupt) -> Result<Results, Failure> {
    let pending: Vec<usize> = (0..sweep.points.len()).filter(|run| !results.rows.contains_key(run)).collect();
    if !results.rows.is_empty() {
        say(&format!("{} of {} runs have a row already", results.rows.len(), sweep.points.len()));
    }
    let bar = bar(pending.len() as u64, "{pos}/{len} {eta}");
    let (next, results, broken) = (AtomicUsize::new(0), Mutex::new(results), Mutex::new(None));
    let ends = || interrupt.code().is_some() || broken.lock().map_or(true, |broken| broken.is_some());
    let work = || {
        while let Some(index) = pending.get(next.fetch_add(1, Ordering::Relaxed)).copied().filter(|_| !ends()) {
            let point = &sweep.points[index];
            let changes = changes(&sweep.parameters, point, |_| true);
            let outcome = single::run(&sweep.scene, &changes, sweep.asked, &sweep.numbers.scalars, || interrupt.code().is_none());
            let Some(mut outcome) = outcome else { return };
            outcome.scalars = sweep.numbers.of(&outcome.scalars);
            let written = results.lock().map_err(|_| "a run broke off".to_string()).and_then(|mut results| {
                let row = Row::new(index, &sweep.parameters, point, outcome);
                results.add(row).map_err(|error| error.to_string())
            });
            if let (Err(error), Ok(mut broken)) = (written, broken.lock()) {
                *broken = Some(error);
                return;
            }
            bar.inc(1);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..parallel.min(pending.len()).max(1) {
            scope.spawn(work);
        }
    });
    bar.finish_and_clear();
    match broken.into_inner() {
        Ok(Some(error)) => Err(Failure::Run(error)),
        _ => results.into_inner().map_err(|_| Failure::Run("a run broke off".into())),
    }
}

/// The first refusal, where no point of the sweep makes a scene: a key that does not exist is told once, before the sweep.
fn refuse_if_all_are(arguments: &Arguments, parameters: &[Parameter], points: &Points) -> Result<(), Failure> {
    let mut first = None;
    for point in points {
        match load::open(&arguments.scene, &changes(parameters, point, |_| true)) {
            Ok(_) => return Ok(()),
            Err(error) => first = first.or(Some(error)),
        }
    }
    first.map_or(Ok(()), |error| Err(error.into()))
}
