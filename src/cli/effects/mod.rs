//! `wheelrail effects SCENE`: what each effect of a scene contributes, and what it costs.

mod picture;
mod words;

use super::interrupt::Interrupt;
use super::{Failure, SceneArguments, TimeArguments, check_picture, print, say, seconds};
use crate::sim::recording::Times;
use crate::study::effects::{self, Request};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;

#[derive(Args)]
#[command(after_long_help = "\
The scene runs with its own tolerance and with one 100 times tighter (a fourth of a fixed step), the reference: their distance is the integration's own error. \
Then it runs once per effect that it holds, with this effect off or with a simpler or a fuller one in its place. A change is the distance to the reference at \
common times, of the worst wheelset, wheel or car body; one that is less than twice the integration's error is called \"below\" and gets no number. \
--overrides prints the --set of each row, for `wheelrail run`. The neighbour ECCF goes on elastically where a constraint ceases (contact.on_lift = \"elastic\").

Evaluations of the right-hand side are counted and the same in each run; CPU time is measured (without outputs, the shorter of two short runs) and is not, \
least of all with --parallel.

Runs that fail or are refused are reported with their reason. What is not run when the budget is spent, or after Ctrl-C, is named; the rest is printed.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    times: TimeArguments,
    /// Only effects whose name contains one of these, e.g. "damper,creep law"
    #[arg(long, value_name = "WORD[,WORD]", value_delimiter = ',')]
    only: Vec<String>,
    /// Runs at the same time
    #[arg(long, value_name = "N", default_value_t = 1)]
    parallel: usize,
    /// Time for all runs together, s or with a unit, e.g. "60s"
    #[arg(long, value_name = "T", default_value = "100s", value_parser = seconds)]
    budget: f64,
    /// Print root mean squares of the changes instead of their largest values
    #[arg(long)]
    rms: bool,
    /// Print the overrides of each row
    #[arg(long = "overrides")]
    sets: bool,
    /// Draw changes over cost
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Print all as JSON (SI units)
    #[arg(long)]
    json: bool,
}

/// Distance of the times at which runs are compared, s: so dense that no peak of a force hides between them.
const DENSE: f64 = 0.73e-3;

pub(super) fn effects(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let (stop, step) = arguments.times.read(&scene)?;
    let step = if arguments.times.step.is_some() { step } else { step.min(DENSE) };
    if !(stop >= step) {
        return Err(Failure::Input(format!("--stop {stop}: expected a time of at least one output step, {step} s")));
    }
    if !(1..=256).contains(&arguments.parallel) {
        return Err(Failure::Input(format!("--parallel {}: expected 1 to 256", arguments.parallel)));
    }
    if !(arguments.budget > 0.0 && arguments.budget.is_finite()) {
        return Err(Failure::Input(format!("--budget {}: expected a time greater than 0 s", arguments.budget)));
    }
    check_picture(&arguments.plot)?;
    let interrupt = Interrupt::watch();
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg:30!}").unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(1).with_style(style);
    let report = effects::effects(
        &scene,
        &Request {
            scene: &arguments.scene.scene,
            overrides: &arguments.scene.overrides,
            span: Times { stop, step },
            only: &arguments.only,
            parallel: arguments.parallel,
            budget: arguments.budget,
            interrupted: &|| interrupt.code().is_some(),
            progress: &|ready, all, what| {
                bar.set_length(all as u64);
                bar.set_position(ready as u64);
                bar.set_message(what.to_string());
            },
        },
    );
    bar.finish_and_clear();
    let report = report.map_err(|reason| match interrupt.code() {
        Some(code) => Failure::Interrupted("interrupted before the reference was ready".into(), code),
        None if reason.starts_with("--only") => Failure::Input(reason),
        None => Failure::Run(reason),
    })?;
    match arguments.json {
        true => print(&format!("{}\n", serde_json::json!({"effects": report, "advice": words::advice(&report)})))?,
        false => print(&words::text(&report, arguments.rms, arguments.sets.then_some(&arguments.scene)))?,
    }
    if let Some(file) = &arguments.plot {
        picture::draw(file, &report).map_err(Failure::Run)?;
        say(&format!("wrote {}", file.display()));
    }
    match interrupt.code() {
        Some(code) => Err(Failure::Interrupted("interrupted: effects that had not run are named".into(), code)),
        None => Ok(()),
    }
}
