//! `wheelrail compare SCENE`: every formulation on one scene; what each costs, how far they are apart, and pictures of pairs.

mod measure;
mod quantity;
mod report;

use super::plot::pair::{self, Curve, PairDiagram};
use super::progress::Progress;
use super::{Failure, SceneArguments, TimeArguments, WheelsetArgument, print, say};
use crate::formulation;
use crate::scene::load;
use crate::scene::spec::Scene;
use crate::settings::did_you_mean;
use clap::Args;
use measure::{ROUNDS, Run, Times};
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
does not matter; everything else is the same for all.

Pictures: SCENE_QUANTITY_FIRST_SECOND.svg for the pairs ACCF and ECCF, ECF-A and ECF-N, ECF-A and ECCF, as far as this program has \
them; QUANTITY is lateral_displacement, yaw, height, normal_force_right, normal_force_left and, where a second contact is ever loaded, \
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
    std::fs::create_dir_all(folder).map_err(|error| Failure::Input(format!("{}: can't be made: {error}", folder.display())))?;
    let runs = run_all(&arguments.scene, &chosen(&arguments.formulations)?, Times { stop, step });
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

/// The formulations of these names in the registry's order; all where none is named.
fn chosen(names: &[String]) -> Result<Vec<&'static str>, Failure> {
    let known: Vec<&'static str> = formulation::REGISTRY.iter().map(|entry| entry.name).collect();
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        let hint = did_you_mean(name, &known);
        return Err(Failure::Input(format!("--formulations {name}{hint}: expected some of {}", known.join(", "))));
    }
    Ok(known.into_iter().filter(|known| names.is_empty() || names.iter().any(|name| name == known)).collect())
}

/// Runs the scene with each of the formulations.
fn run_all(scene: &SceneArguments, formulations: &[&str], times: Times) -> Vec<Run> {
    let progress = Progress::new(times.stop * ((2 + ROUNDS) * formulations.len()) as f64);
    let mut runs: Vec<(Run, Option<Scene>)> = formulation::REGISTRY
        .iter()
        .filter(|entry| formulations.contains(&entry.name))
        .map(|entry| {
            let overrides: Vec<String> =
                scene.overrides.iter().cloned().chain([format!("contact.formulation=\"{}\"", entry.name)]).collect();
            match load::open(&scene.scene, &overrides) {
                Ok(scene) => (measure::record(entry.name, entry.summary, &scene, times, &progress), Some(scene)),
                Err(error) => (Run::failed(entry.name, entry.summary, error.to_string()), None),
            }
        })
        .collect();
    measure::time(&mut runs, times.stop, &progress);
    progress.finish();
    runs.into_iter().map(|(run, _)| run).collect()
}

/// The pairs of which both formulations can be compared.
fn pairs(runs: &[Run]) -> Vec<[&Run; 2]> {
    let find = |name: &str| runs.iter().find(|run| run.name == name && run.samples.len() > 1);
    PAIRS.iter().filter_map(|[first, second]| Some([find(first)?, find(second)?])).collect()
}

/// Draws every pair; returns the files.
fn pictures(folder: &Path, comparison: &Comparison) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for runs in pairs(comparison.runs) {
        for quantity in &QUANTITIES {
            files.extend(picture(folder, comparison, runs, quantity)?);
        }
    }
    Ok(files)
}

fn picture(folder: &Path, comparison: &Comparison, runs: [&Run; 2], quantity: &Quantity) -> Result<Option<PathBuf>, String> {
    let Some((axis, factor)) = quantity.axis else { return Ok(None) };
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
    let diagram = PairDiagram {
        title: format!("{}: {} and {}", quantity.title, names[0], names[1]),
        subtitle: &scene.title,
        axis,
        factor,
        unit: quantity.unit,
        difference: first.minus(&second),
        curves: [Curve { label: names[0], points: first.points() }, Curve { label: names[1], points: second.points() }],
    };
    pair::draw(&file, &diagram)?;
    Ok(Some(file))
}
