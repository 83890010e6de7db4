//! `wheelrail study SCENE`: what accuracy costs in time; CSV, pictures, and in words what to choose.

mod csv;
mod pictures;
mod words;

use super::interrupt::Interrupt;
use super::progress::bar;
use super::{
    Failure, SceneArguments, TimeArguments, WheelsetArgument, chosen, csv_target, file_names, make_folder, names, print, say, seconds,
};
use crate::contact::creep;
use crate::formulation;
use crate::scene::spec::Scene;
use crate::sim::recording::Times;
use crate::solve;
use crate::study::accuracy::{self, Request, Study, StudyError};
use crate::study::shares;
use crate::units::Dimension;
use clap::Args;
use std::path::PathBuf;

/// What is run where nothing is named.
const TOLERANCES: &str = "1e-4,3e-5,1e-5,1e-6,1e-7,1e-8,1e-10";
const STEPS: &str = "5 ms,2 ms,1 ms,0.5 ms,0.2 ms,0.1 ms";

/// Of a list out of which each method takes what is in its range.
fn help(what: &str, standard: &str) -> String {
    format!("{what}; each takes those in its range [default: {standard}]")
}

#[derive(Args)]
#[command(after_long_help = "\
Every chosen formulation runs with every chosen integrator at those of the tolerances (adaptive methods) or steps (fixed ones) that the \
integrator takes. An error is the \
distance to the reference of the same model at the scene's output times: two independent methods at tight tolerance, whose distance is \
the reference's uncertainty. Errors below 100 times that are not told; where no point is above, the study refuses (exit code 1). Lateral \
displacement, wheel loads, normal forces, Y/Q and accelerations count with their largest errors (where forces jump with the state, what the other run has within one sample is none; the CSV of -o has rms and 95 % too); the worst wheelset counts unless --wheelset names one. Costs are CPU time of one thread without outputs, the median of \
repeated runs, one after the other.

--creep-laws, --node-spacing and --smoothing make models of their own with a reference each: their numerical errors and their \
distances from the first model are told apart.

Cheap points come first; what does not fit into the budget is not run and named. A long scene is shortened, which is said.

Pictures: SCENE_time_QUANTITY.svg (error against CPU time) and SCENE_work_QUANTITY.svg (against evaluations of the right-hand side) for y, N, YQ and the \
hunting wavelength, SCENE_best.svg (the points that no other one beats) and SCENE_communication.svg.

Exit code: 0, 1 when the study is refused or a file can't be written to its end, 2 when the scene or an argument makes no sense or names \
a place where nothing can be written.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Formulations, e.g. "ECF-A,ECCF" [default: all]
    #[arg(long, value_name = "NAME[,NAME]", value_delimiter = ',')]
    formulations: Vec<String>,
    /// Integrators, e.g. "dormand_prince,rk4" [default: all]
    #[arg(long, value_name = "NAME[,NAME]", value_delimiter = ',')]
    integrators: Vec<String>,
    #[arg(long, value_name = "TOL[,TOL]", value_delimiter = ',', help = help("Tolerances of adaptive methods", TOLERANCES))]
    tolerances: Vec<String>,
    #[arg(long, value_name = "H[,H]", value_delimiter = ',', help = help("Steps of methods with fixed steps", STEPS))]
    steps: Vec<String>,
    /// Creep laws, e.g. "fastsim,polach" [default: the scene's]
    #[arg(long, value_name = "NAME[,NAME]", value_delimiter = ',')]
    creep_laws: Vec<String>,
    /// Distances of the nodes of ECF-N, e.g. "0.5 mm,0.1 mm" [default: the scene's]
    #[arg(long, value_name = "D[,D]", value_delimiter = ',')]
    node_spacing: Vec<String>,
    /// Smoothing of profiles that are made from points, e.g. "1 um,10 um" [default: the scene's]
    #[arg(long, value_name = "D[,D]", value_delimiter = ',')]
    smoothing: Vec<String>,
    /// Communication steps of a coupled run with the scene's formulation and solver; "none" for no such runs
    #[arg(long, value_name = "H[,H]", value_delimiter = ',', default_value = "1 ms,2 ms,5 ms,10 ms,20 ms,50 ms")]
    communication_steps: Vec<String>,
    #[command(flatten)]
    wheelset: WheelsetArgument,
    /// Stop time, s or with a unit [default: run.stop of the scene, less where the budget asks for it]
    #[arg(long, value_name = "T", value_parser = seconds)]
    stop: Option<f64>,
    /// Distance of the output times, s or with a unit, e.g. "4 ms" [default: 0.73 ms or run.step of the scene, whichever is less]
    #[arg(long, value_name = "H", value_parser = seconds)]
    step: Option<f64>,
    /// Timed runs of each point; the median counts
    #[arg(long, value_name = "N", default_value_t = 3)]
    repeats: usize,
    /// Time for the whole study in s
    #[arg(long, value_name = "SECONDS", default_value_t = 100.0)]
    budget: f64,
    /// Tolerance of the references [default: as tight as the budget allows, at most 1e-13]
    #[arg(long, value_name = "TOL")]
    reference: Option<String>,
    /// Write all points as CSV ("-" for stdout)
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Draw the pictures into a folder; made if it is missing
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// Instead: where the time of one run with the scene's own solver (or that of --set) goes
    #[arg(long = "where", conflicts_with_all = ["formulations", "integrators", "creep_laws", "node_spacing", "smoothing", "reference", "output", "plot"])]
    shares: bool,
    /// Print the study as JSON (SI units)
    #[arg(long)]
    json: bool,
}

pub(super) fn study(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    if arguments.wheelset.wheelset.is_some() {
        arguments.wheelset.choose(&scene)?;
    }
    let formulations = chosen("--formulations", &arguments.formulations, names(formulation::REGISTRY))?;
    if arguments.shares {
        return where_time_goes(arguments, &scene);
    }
    let (overrides, alike) = arguments.scene.alike(&scene, &formulations);
    let interrupt = Interrupt::watch();
    let interrupted = || interrupt.code().is_some();
    let request = Request { interrupted: &interrupted, ..request(arguments, scene.run.step, formulations, &overrides)? };
    if let Some(stop) = arguments.stop.or((scene.run.stop == 0.0).then_some(0.0))
        && !(stop.is_finite() && stop >= request.step)
    {
        return Err(Failure::Input(format!("--stop {stop}: expected a time of at least one output step, {} s", request.step)));
    }
    // Whatever can't be written is better known before the runs.
    let target = csv_target(&arguments.output, arguments.json)?;
    if let Some(folder) = &arguments.plot {
        make_folder(folder)?;
    }
    let mut study = run(&request).map_err(|failure| match interrupt.code() {
        Some(code) => Failure::Interrupted("interrupted before a point was ready".into(), code),
        None => failure,
    })?;
    study.notes.splice(0..0, alike);
    if let Some(target) = &target {
        let mut text = Vec::new();
        csv::write(&mut text, &study).map_err(|error| Failure::Run(error.to_string()))?;
        target.write(&text)?;
    }
    let files = match &arguments.plot {
        Some(folder) => pictures::draw(folder, &study).map_err(Failure::Run)?,
        None => Vec::new(),
    };
    if arguments.json {
        let json = serde_json::json!({"study": study, "best": words::json(&study), "pictures": file_names(&files)});
        print(&format!("{json}\n"))?;
    } else if !target.is_some_and(|target| target.is_stdout()) {
        print(&words::text(&study))?;
    }
    for file in files {
        say(&format!("wrote {}", file.display()));
    }
    match interrupt.code() {
        Some(code) => Err(Failure::Interrupted("interrupted: points that had not run are named".into(), code)),
        None => Ok(()),
    }
}

fn where_time_goes(arguments: &Arguments, scene: &Scene) -> Result<(), Failure> {
    let (stop, step) = TimeArguments { stop: arguments.stop, step: arguments.step }.read(scene)?;
    if !(stop >= step) {
        return Err(Failure::Input(format!("--stop {stop}: expected a time of at least one output step, {step} s")));
    }
    let found = shares::shares(scene, Times { stop, step }, arguments.repeats).map_err(Failure::Run)?;
    print(&if arguments.json { format!("{}\n", serde_json::json!(found)) } else { found.to_string() })?;
    Ok(())
}

/// Runs it under a progress bar, which shows where stderr is a terminal.
fn run(request: &Request) -> Result<Study, Failure> {
    let bar = bar(1000, "{msg:40!}");
    let done = accuracy::study(request, &mut |share, what| {
        bar.set_position((1e3 * share.clamp(0.0, 1.0)) as u64);
        bar.set_message(what.to_string());
    });
    bar.finish_and_clear();
    done.map_err(|error| match error {
        StudyError::Refused(reason) => Failure::Run(reason),
        other => Failure::Input(other.to_string()),
    })
}

/// Distance of output times by default, s: a grid so dense that no error of a force hides between its times, and that no step of the lists divides.
const DENSE: f64 = 0.73e-3;

fn request<'a>(
    arguments: &'a Arguments,
    scene_step: f64,
    formulations: Vec<&'static str>,
    overrides: &'a [String],
) -> Result<Request<'a>, Failure> {
    let step = arguments.step.unwrap_or(scene_step.min(DENSE));
    let positive = |what: &str, value: f64| match value > 0.0 && value.is_finite() {
        true => Ok(value),
        false => Err(Failure::Input(format!("{what} {value}: expected a number greater than 0"))),
    };
    if arguments.repeats == 0 {
        return Err(Failure::Input("--repeats 0: expected 1 or more".into()));
    }
    // "auto" stands for another one of the list.
    let methods = solve::REGISTRY.iter().map(|entry| entry.name).filter(|name| *name != solve::AUTO.name);
    let communication = match arguments.communication_steps.as_slice() {
        [only] if only == "none" => Vec::new(),
        steps => numbers("--communication-steps", steps, Dimension::Time)?,
    };
    let laws = match arguments.creep_laws.is_empty() {
        true => Vec::new(),
        false => chosen("--creep-laws", &arguments.creep_laws, names(creep::REGISTRY))?,
    };
    Ok(Request {
        scene: &arguments.scene.scene,
        overrides,
        formulations,
        integrators: chosen("--integrators", &arguments.integrators, methods.collect())?,
        tolerances: numbers("--tolerances", &or_standard(&arguments.tolerances, TOLERANCES), Dimension::Length)?,
        steps: numbers("--steps", &or_standard(&arguments.steps, STEPS), Dimension::Time)?,
        own_lists: [!arguments.tolerances.is_empty(), !arguments.steps.is_empty()],
        creep_laws: laws,
        node_spacings: numbers("--node-spacing", &arguments.node_spacing, Dimension::Length)?,
        smoothings: numbers("--smoothing", &arguments.smoothing, Dimension::Length)?,
        communication_steps: communication,
        stop: arguments.stop,
        step: positive("--step", step)?,
        wheelset: arguments.wheelset.wheelset.as_deref(),
        repeats: arguments.repeats,
        budget: positive("--budget", arguments.budget)?,
        reference: match &arguments.reference {
            Some(text) => numbers("--reference", std::slice::from_ref(text), Dimension::Length)?.first().copied(),
            None => None,
        },
        interrupted: &|| false,
    })
}

fn or_standard(given: &[String], standard: &str) -> Vec<String> {
    if given.is_empty() { standard.split(',').map(String::from).collect() } else { given.to_vec() }
}

/// Numbers greater than 0 with or without a unit, in the order of size, largest first, none twice.
fn numbers(flag: &str, texts: &[String], dimension: Dimension) -> Result<Vec<f64>, Failure> {
    let read = |text: &String| {
        let number = text.trim().parse::<f64>().ok().or_else(|| dimension.parse(text.trim()));
        let refused = || Failure::Input(format!("{flag} {text}: expected {}, greater than 0", dimension.expectation()));
        number.filter(|number| number.is_finite() && *number > 0.0).ok_or_else(refused)
    };
    let mut all = texts.iter().map(read).collect::<Result<Vec<f64>, Failure>>()?;
    all.sort_by(|a, b| b.total_cmp(a));
    all.dedup();
    Ok(all)
}
