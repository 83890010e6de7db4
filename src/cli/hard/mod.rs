//! `wheelrail hard`: the hard cases, each with what must hold, and what every formulation and integrator makes of it.

mod scenes;
mod words;

use super::output::{Kind, Target};
use super::{Failure, print, refused, say};
use crate::formulation;
use crate::settings::did_you_mean;
use crate::solve;
use crate::study::hard::{self, Case, Judged, Method};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_long_help = "\
Each case runs with every formulation and integrator that applies. \"held\": every number is within its bound, those of the case and those \
of the audit of every run (energy, momentum, gaps of rigid contacts, no pull, creep forces within friction, a state saved in the middle \
leads to the same bits). \"refused\": the program says that it can't, and what to do. \"broken\": neither. All are read on a dense grid \
of times that no step knows of.

Exit code: 0, 1 when a case is broken, 2 when there is no such case or a file can't be written.")]
pub(super) struct Arguments {
    /// Cases to run, e.g. "steady_curve" [default: all]
    #[arg(value_name = "CASE")]
    cases: Vec<String>,
    /// Only name the cases, what makes them hard and what must hold
    #[arg(long)]
    list: bool,
    /// The part that runs in the tests
    #[arg(long)]
    quick: bool,
    /// Only these formulations, e.g. "ECF-A,ECCF"
    #[arg(long = "formulation", value_name = "NAME[,NAME]", value_delimiter = ',')]
    formulations: Vec<String>,
    /// Only integrators with this in their name or setting, e.g. "rosenbrock" or "1e-5"
    #[arg(long, value_name = "TEXT")]
    method: Option<String>,
    /// Run with this method instead of those of the cases, e.g. "dormand_prince:tolerance=1e-9"
    #[arg(long, value_name = "METHOD:KEY=VALUE", conflicts_with = "method")]
    with: Option<String>,
    /// Print every row and the commands that show what is broken
    #[arg(long)]
    all: bool,
    /// Judge so many random scenes instead
    #[arg(long, value_name = "N", conflicts_with_all = ["cases", "markdown"])]
    random: Option<u64>,
    /// Seed of the first random scene; the others follow
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Print the random scene of a seed as TOML
    #[arg(long, value_name = "SEED", conflicts_with_all = ["cases", "random"])]
    random_scene: Option<u64>,
    /// Write the table as a page
    #[arg(long, value_name = "FILE.md")]
    markdown: Option<PathBuf>,
    /// Print the table as JSON (SI units)
    #[arg(long)]
    json: bool,
}

pub(super) fn hard(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(seed) = arguments.random_scene {
        print(&hard::random::RandomScene::draw(seed).text)?;
        return Ok(());
    }
    if let Some(count) = arguments.random {
        return scenes::scenes(count, arguments);
    }
    let cases = chosen(arguments)?;
    if arguments.list {
        print(&words::list(&cases))?;
        return Ok(());
    }
    let page =
        arguments.markdown.as_ref().map(|path| Target::find(path, Kind::Text).map(|target| (path, target))).transpose().map_err(refused)?;
    let begin = std::time::Instant::now();
    let rows = run(&cases, arguments)?;
    let seconds = begin.elapsed().as_secs_f64();
    if arguments.json {
        print(&format!("{}\n", serde_json::json!({"rows": rows, "seconds": seconds})))?;
    } else {
        print(&words::text(&cases, &rows, arguments.all, seconds))?;
    }
    if let Some((path, target)) = page {
        target.write(words::page(&cases, &rows).as_bytes())?;
        say(&format!("wrote {}", path.display()));
    }
    match rows.iter().filter(|row| row.outcome.is_broken()).count() {
        0 => Ok(()),
        count => Err(Failure::Run(format!("{count} of {} broken", rows.len()))),
    }
}

/// The cases that are asked for, with the formulations and methods that are.
fn chosen(arguments: &Arguments) -> Result<Vec<Case>, Failure> {
    let all = hard::all();
    let names: Vec<&str> = all.iter().map(|case| case.name).collect();
    if let Some(name) = arguments.cases.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(Failure::Input(format!(
            "no case is called \"{name}\"{}; `wheelrail hard --list` names all",
            did_you_mean(name, &names)
        )));
    }
    let known: Vec<&str> = formulation::REGISTRY.iter().map(|entry| entry.name).collect();
    if let Some(name) = arguments.formulations.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Failure::Input(format!("--formulation {name}{}: expected some of {}", did_you_mean(name, &known), known.join(", "))));
    }
    let wanted = |case: &Case| match arguments.cases.is_empty() {
        true => case.quick || !arguments.quick,
        false => arguments.cases.iter().any(|name| name == case.name),
    };
    Ok(all.into_iter().filter(wanted).collect())
}

/// Reads "dormand_prince:tolerance=1e-9".
fn method(text: &str) -> Result<Method, Failure> {
    let wrong = || Failure::Input(format!("--with {text}: expected a method and its setting, e.g. \"dormand_prince:tolerance=1e-9\""));
    let (name, setting) = text.split_once(':').ok_or_else(wrong)?;
    let known: Vec<&'static str> = solve::REGISTRY.iter().map(|entry| entry.name).collect();
    let integrator = known.into_iter().find(|known| *known == name).ok_or_else(wrong)?;
    if !(setting.starts_with("tolerance=") || setting.starts_with("step=")) {
        return Err(wrong());
    }
    // Said once per process; the tables of cases are constants.
    Ok(Method { integrator, setting: setting.to_string().leak() })
}

/// Runs them on all cores; longest first, so that none is left alone at the end.
fn run(cases: &[Case], arguments: &Arguments) -> Result<Vec<Judged>, Failure> {
    let mut jobs = Vec::new();
    let with = arguments.with.as_deref().map(method).transpose()?;
    for (index, case) in cases.iter().enumerate() {
        let methods = match with {
            Some(with) => vec![with],
            None => case.methods_with(arguments.method.as_deref().unwrap_or_default()),
        };
        for formulation in case.formulations {
            if arguments.formulations.is_empty() || arguments.formulations.iter().any(|name| name == formulation) {
                jobs.push((index, case, *formulation, methods.clone()));
            }
        }
    }
    if jobs.is_empty() {
        return Err(Failure::Input("no case is left with these formulations".into()));
    }
    jobs.sort_by(|a, b| b.1.stop.total_cmp(&a.1.stop));
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg:30!}").unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(jobs.len() as u64).with_style(style);
    // Panics are rows of the table.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| ()));
    let mut rows: Vec<(usize, Vec<Judged>)> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(index, case, formulation, methods)| {
            bar.set_message(case.name);
            let rows = hard::judge(case, formulation, methods);
            bar.inc(1);
            (*index, rows)
        })
        .collect();
    std::panic::set_hook(hook);
    bar.finish_and_clear();
    rows.sort_by_key(|(index, _)| *index);
    Ok(rows.into_iter().flat_map(|(_, rows)| rows).collect())
}
