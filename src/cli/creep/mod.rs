//! `wheelrail creep`: creep forces of a table of contacts, or a comparison of laws on random contacts.

mod cases;
mod study;

use super::{Failure, csv_target, print, say};
use crate::contact::creep::{Build, inline};
use crate::settings::SettingsError;
use crate::study::shares::anatomy::per_call;
use cases::Case;
use clap::Args;
use std::hint::black_box;
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct Arguments {
    /// Table of contacts with the columns a, b [m], nu, G [Pa], N [N], mu, xi, eta [-], phi [1/m] and perhaps V [m/s] (1 if absent)
    #[arg(required_unless_present = "study", conflicts_with = "study")]
    cases: Option<PathBuf>,
    /// Laws, e.g. fastsim or 'fastsim{strips=10,cells=10},polach' (see `wheelrail list creep-laws`)
    #[arg(long, value_name = "NAME[,NAME...]", required = true)]
    law: Vec<String>,
    /// Where to write: a CSV file ("-" for stdout, the default); with --study a folder
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Compare the laws with --reference on this many random contacts: CSV, Markdown and SVG in the folder of -o
    #[arg(long, value_name = "N", requires = "output", requires = "reference")]
    study: Option<usize>,
    /// Start of the random numbers of --study
    #[arg(long, value_name = "S", default_value_t = 1, requires = "study")]
    seed: u64,
    /// Law that --study takes for the truth
    #[arg(long, value_name = "LAW", requires = "study")]
    reference: Option<String>,
    /// Print the forces as JSON
    #[arg(long, conflicts_with_all = ["output", "study"])]
    json: bool,
}

/// A law as it was written, and what builds it.
struct Named {
    name: String,
    build: Build,
}

fn named(text: &str, place: &str) -> Result<Named, Failure> {
    // A word on the command line has no lines.
    let build = inline::law(text, place).map_err(|error| Failure::Input(SettingsError { line: 0, ..error }.to_string()))?;
    Ok(Named { name: text.into(), build })
}

pub(super) fn creep(arguments: &Arguments) -> Result<(), Failure> {
    let texts: Vec<&str> = arguments.law.iter().flat_map(|list| inline::split(list)).collect();
    let laws = texts.into_iter().map(|text| named(text, "--law")).collect::<Result<Vec<Named>, Failure>>()?;
    if laws.is_empty() {
        return Err(Failure::Input("--law: names no law (see `wheelrail list creep-laws`)".into()));
    }
    if let (Some(count), Some(reference), Some(folder)) = (arguments.study, &arguments.reference, &arguments.output) {
        let reference = named(reference, "--reference")?;
        let found = study::study(count, arguments.seed, &reference, &laws)?;
        for file in study::write(folder, &found)? {
            say(&format!("wrote {}", file.display()));
        }
        print(&study::text(&found))?;
        return Ok(());
    }
    let Some(path) = &arguments.cases else { return Err(Failure::Input("expected a table of contacts, or --study".into())) };
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| Failure::Input(format!("{file}: can't be read: {error}")))?;
    let cases = cases::read(&text, &file).map_err(Failure::Input)?;
    if arguments.json {
        print(&format!("{}\n", cases::json(&results(&cases, &laws))))?;
        return Ok(());
    }
    // What can't be written is better known before the work.
    let target = csv_target(&arguments.output, false)?;
    let table = cases::table(&results(&cases, &laws));
    match (target, &arguments.output) {
        (Some(target), Some(path)) if !target.is_stdout() => {
            target.write(table.as_bytes())?;
            say(&format!("wrote {}", path.display()));
        }
        _ => print(&table)?,
    }
    Ok(())
}

/// Every case with every law.
fn results<'a>(cases: &'a [Case], laws: &'a [Named]) -> Vec<cases::Row<'a>> {
    let mut rows = Vec::new();
    for case in cases {
        for Named { name, build } in laws {
            let law = build(case.material);
            let force = law.force(&case.contact);
            rows.push(cases::Row { case, law: name, force, time: per_call(|| law.force(black_box(&case.contact))) });
        }
    }
    rows
}
