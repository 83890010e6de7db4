//! `wheelrail compare SCENE`: every formulation on one scene; what each costs, how far they are apart, and pictures of pairs.

mod measure;
mod quantity;
mod report;

use super::plot::{BLUE, DARK, Ink, ORANGE, Panel, Series, Sheet};
use super::progress::Progress;
use super::{Failure, SceneArguments, TimeArguments, WheelsetArgument, chosen, make_folder, names, print, say};
use crate::formulation;
use crate::scene::load;
use crate::sim::recording::Times;
use crate::study::digits::{prefix, sized};
use clap::Args;
use measure::{ROUNDS, Run};
use quantity::{QUANTITIES, Quantity};
use report::Comparison;
use std::path::{Path, PathBuf};

/// Formulations that are drawn together: those of the paper's figures, and a rigid one against an elastic one.
const PAIRS: [[&str; 2]; 3] = [["ACCF", "ECCF"], ["ECF-A", "ECF-N"], ["ECF-A", "ECCF"]];

/// The formulation that all others are compared with, if it runs.
const REFERENCE: &str = "ECCF";

#[derive(Args)]
#[command(after_long_help = "\
Each formulation runs five times: once sampled every --step, once more like that with a finer integration (which shows how large its \
numerical error is), and three times without outputs for the cost (median, CPU time of one core). contact.formulation of the scene \
does not matter; everything else is the same for all (contact.patch = \"auto\" is \"ellipse\" for all where a constraint formulation is among \
them).

Pictures: SCENE_QUANTITY_FIRST_SECOND.svg for the pairs ACCF and ECCF, ECF-A and ECF-N, ECF-A and ECCF, as far as this program has \
them; QUANTITY is lateral_displacement, yaw, height, normal_force_right, normal_force_left and, where a wheel ever stands on two places, \
second_contact_right. Of a vehicle the wheelset's name stands before it.

A formulation that can't run the scene does not stop the others: the table says why, and it is compared and drawn as far as it came. \
Exit code: 0 when at least one formulation ran to the end, 1 when none did or a picture can't be written, 2 when the scene or an \
argument makes no sense.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Folder for the pictures; made if it is missing [default: current folder]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Formulations to compare, e.g. "ECF-A,ECCF" [default: all]
    #[arg(long, value_name = "NAME[,NAME]", value_delimiter = ',')]
    formulations: Vec<String>,
    #[command(flatten)]
    wheelset: WheelsetArgument,
    #[command(flatten)]
    times: TimeArguments,
    /// Print the comparison as JSON (SI units)
    #[arg(long)]
    json: bool,
}

pub(super) fn compare(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let (stop, step) = arguments.times.read(&scene)?;
    let wheelset = arguments.wheelset.choose(&scene)?;
    if stop == 0.0 {
        return Err(Failure::Input("--stop 0: there is nothing to compare; expected a time greater than 0 s".into()));
    }
    let folder = arguments.output.as_deref().unwrap_or(Path::new("."));
    make_folder(folder)?;
    let formulations = chosen("--formulations", &arguments.formulations, names(formulation::REGISTRY))?;
    let (overrides, alike) = arguments.scene.alike(&scene, &formulations);
    if let Some(words) = alike {
        say(&words);
    }
    let runs = run_all(&arguments.scene.scene, &overrides, &formulations, Times { stop, step });
    let comparison = Comparison {
        scene: &scene,
        wheelset,
        times: Times { stop, step },
        finer: measure::finer(&scene).map(|(_, words)| words),
        reference: runs.iter().find(|run| run.name == REFERENCE && run.finished()).or_else(|| runs.iter().find(|run| run.finished())),
        runs: &runs,
    };
    let drawn = pictures(folder, &comparison);
    let (files, failure) = match &drawn {
        Ok(files) => (files.as_slice(), None),
        Err(error) => (&[][..], Some(error)),
    };
    if arguments.json {
        print(&format!("{}\n", report::json(&comparison, files)))?;
    } else {
        print(&report::text(&comparison))?;
        for file in files {
            say(&format!("wrote {}", file.display()));
        }
    }
    if let Some(error) = failure {
        return Err(Failure::Run(error.clone()));
    }
    if comparison.reference.is_none() {
        return Err(Failure::Run(format!("{}: no formulation ran to the end", scene.source.file)));
    }
    Ok(())
}

/// Runs the scene with each of the formulations.
fn run_all(scene: &str, overrides: &[String], formulations: &[&str], times: Times) -> Vec<Run> {
    let progress = Progress::new(times.stop * ((2 + ROUNDS) * formulations.len()) as f64);
    let entries = formulation::REGISTRY.iter().filter(|entry| formulations.contains(&entry.name));
    let run = |entry: &crate::settings::Entry<_>| {
        let mut overrides = overrides.to_vec();
        overrides.push(format!("contact.formulation=\"{}\"", entry.name));
        let scene = load::open(scene, &overrides).map_err(|error| error.to_string());
        Run::new(entry.name, entry.summary, scene, times, &progress)
    };
    let mut runs: Vec<Run> = entries.map(run).collect();
    measure::time(&mut runs, times.stop, &progress);
    progress.finish();
    runs
}

/// The pairs of which both formulations can be compared.
fn pairs(runs: &[Run]) -> Vec<[&Run; 2]> {
    let find = |name: &str| runs.iter().find(|run| run.name == name && run.samples.len() > 1);
    PAIRS.iter().filter_map(|[first, second]| Some([find(first)?, find(second)?])).collect()
}

/// Draws every pair; returns the files.
fn pictures(folder: &Path, comparison: &Comparison) -> Result<Vec<PathBuf>, String> {
    let all = pairs(comparison.runs).into_iter().flat_map(|runs| QUANTITIES.iter().map(move |quantity| (runs, quantity)));
    all.filter_map(|(runs, quantity)| picture(folder, comparison, runs, quantity).transpose()).collect()
}

/// Part of the largest value below which two runs are equal: integration rounds by more.
const ROUNDING: f64 = 1e-11;

/// Two runs over distance, a broad pale line and a thin dashed one on it, and below it their difference with a unit of its own, which says
/// how small it is. Nothing where there is nothing to see.
fn picture(folder: &Path, comparison: &Comparison, runs: [&Run; 2], quantity: &Quantity) -> Result<Option<PathBuf>, String> {
    let Comparison { scene, wheelset, .. } = comparison;
    let [first, second] = runs.map(|run| run.samples.trace(wheelset, quantity));
    if first.is_idle() && second.is_idle() {
        return Ok(None);
    }
    let names = runs.map(|run| run.name);
    // Pictures of several wheelsets may stand in one folder: truck[1].wheelset[2] becomes truck1_wheelset2.
    let plain = wheelset.replace(['[', ']'], "").replace('.', "_");
    let place = if scene.vehicle.axles().len() > 1 { format!("_{plain}") } else { String::new() };
    let file = folder.join(format!("{}{place}_{}_{}_{}.svg", scene.name, quantity.key, names[0], names[1]));
    let mut difference = first.minus(&second);
    let (place, largest) = difference.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or_default();
    // What rounding makes of equal runs is no difference of models.
    let reach = first.points().iter().map(|point| point.1.abs()).fold(0.0, f64::max);
    let largest = if largest.abs() > ROUNDING * reach { largest } else { 0.0 };
    if largest == 0.0 {
        difference.iter_mut().for_each(|point| point.1 = 0.0);
    }
    let (letter, size) = prefix(largest.abs());
    let [letter, most] = [letter.into(), sized(largest.abs(), quantity.unit, 3)].map(|words: String| words.replace('u', "\u{b5}"));
    let aside = if largest == 0.0 {
        format!("none: equal to {ROUNDING:e} of the largest value")
    } else {
        format!("at most {most}, at {place:.1} m")
    };
    let scaled = |points: Vec<(f64, f64)>, factor: f64| points.into_iter().map(|(x, value)| (x, factor * value)).collect::<Vec<_>>();
    let (axis, factor) = quantity.axis;
    let both = vec![
        Series::line(names[0], Ink::broad(BLUE), scaled(first.points(), factor)),
        Series::line(names[1], Ink::dashed(ORANGE), scaled(second.points(), factor)),
    ];
    let apart = vec![Series::line("", Ink { width: 1.25, ..Ink::line(DARK) }, scaled(difference, 1.0 / size))];
    let unit = format!("difference [{letter}{}]", quantity.unit);
    let panels = vec![
        Panel::new("", ["distance [m]", axis], both),
        Panel { aside, height: 260.0, ..Panel::new(&format!("{} minus {}", names[0], names[1]), ["distance [m]", &unit], apart) },
    ];
    let title = format!("{}: {} and {}", quantity.title, names[0], names[1]);
    let subtitles = std::iter::once(scene.title.clone()).chain(runs.iter().filter_map(|run| run.broken_off())).collect();
    Sheet { title, subtitles, columns: 1, panels }.draw(&file)?;
    Ok(Some(file))
}
