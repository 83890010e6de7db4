//! `wheelrail export SCENE`: writes the FMU, then loads its own library and steps it.

use super::output::{Kind, Target};
use super::{Failure, SceneArguments, print, refused, table};
use crate::fmi::package::{self, PackageError, PackedScene};
use crate::fmi::version::Version;
use crate::study::digits::rounded;
use crate::units::Unit;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
#[command(after_long_help = "\
The FMU is written first and checked then, as a host would use it: its own library is loaded and stepped through the C interface by run.step. \
If that fails, the exit code is 1, and the message says that the FMU stands where it was written. It replaces an older one, also behind \
a symbolic link; what is no file (a folder, a device) is refused.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The FMU to write [default: NAME.fmu]
    #[arg(short, long, value_name = "FILE.fmu")]
    output: Option<PathBuf>,
    /// Version of FMI: 2 for the widest choice of tools, 3 for events, early return, updates within steps and arrays (docs/fmu.md)
    #[arg(long, value_name = "VERSION", default_value = "2")]
    fmi: Fmi,
    /// The FMU's library, when it is not next to this program
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// How much of the scene the finished FMU is stepped through
    #[arg(long, value_name = "HOW", default_value = "short")]
    check: Check,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Fmi {
    /// FMI 2.0 co-simulation: nearly every simulation tool reads it
    #[value(name = "2", alias = "2.0")]
    Two,
    /// FMI 3.0 co-simulation: the same model, with event mode, early return, intermediate update and arrays
    #[value(name = "3", alias = "3.0")]
    Three,
}

impl From<Fmi> for Version {
    fn from(fmi: Fmi) -> Version {
        match fmi {
            Fmi::Two => Version::Two,
            Fmi::Three => Version::Three,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Check {
    /// Not at all
    None,
    /// The first 0.5 s
    Short,
    /// All of run.stop
    Full,
}

impl Check {
    fn name(self) -> &'static str {
        match self {
            Check::None => "none",
            Check::Short => "short",
            Check::Full => "full",
        }
    }

    /// Until when the FMU is stepped, s; `None`: it is not even loaded.
    fn stop(self, run_stop: f64) -> Option<f64> {
        const SHORT: f64 = 0.5;
        match self {
            Check::None => None,
            Check::Short => Some(run_stop.min(SHORT)),
            Check::Full => Some(run_stop),
        }
    }
}

/// Rows of the table that shows what happened.
const ROWS: usize = 10;

/// Outputs that the table shows where the FMU has them: name below the wheelset, heading, factor.
const COLUMNS: [(&str, &str, f64); 6] = [
    ("distance", "distance m", 1.0),
    ("y", "y mm", 1e3),
    ("yaw", "yaw mrad", 1e3),
    ("left.verticalForce", "Q left kN", 1e-3),
    ("right.verticalForce", "Q right kN", 1e-3),
    ("drivingForce", "drive N", 1.0),
];

impl From<PackageError> for Failure {
    fn from(error: PackageError) -> Self {
        match error {
            PackageError::Check(_) | PackageError::Archive(_) => Failure::Run(error.to_string()),
            _ => Failure::Input(error.to_string()),
        }
    }
}

pub(super) fn export(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let path = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.fmu", scene.name)));
    // Known before the work.
    let target = Target::find(&path, Kind::Fmu).map_err(refused)?;
    let library = package::find_library(arguments.library.as_deref())?;
    let packed = package::pack_scene_as(&scene, arguments.fmi.into())?;
    let files = package::files(&packed, &library);
    let bytes = package::archive(&files)?;
    super::start(&packed.scene)?;

    let name = &packed.scene.vehicle.leading().name;
    let shown: Vec<_> = COLUMNS
        .iter()
        .filter_map(|column| {
            let full = format!("{name}.{}", column.0);
            packed.table.outputs.iter().find(|output| output.name == full).map(|output| (output, column))
        })
        .collect();
    let references: Vec<u32> = shown.iter().map(|(output, _)| output.reference).collect();
    target.write(&bytes)?;

    let start = Instant::now();
    let run = packed.scene.run;
    let stop = arguments.check.stop(run.stop);
    let (rows, failure) = match stop.map(|stop| package::check(&files, &packed, &references, stop, run.step, ROWS)) {
        None => (Vec::new(), None),
        Some(Ok(rows)) => (rows, None),
        Some(Err(error)) => {
            let place = path.display();
            (Vec::new(), Some(format!("{error}; {place} was written before the check and stands there as it is: don't rely on it")))
        }
    };
    let elapsed = start.elapsed().as_secs_f64();
    if arguments.json {
        let columns: Vec<_> = shown.iter().map(|(output, _)| &output.name).collect();
        let value = serde_json::json!({
            "fmu": path, "bytes": bytes.len(), "fmi": packed.table.version.name(), "guid": packed.description.guid, "platform": packed.table.version.platform(),
            "variables": packed.table.variables.len(), "seconds": elapsed, "columns": columns, "rows": rows,
            "check": arguments.check.name(), "checked": stop, "error": failure,
        });
        print(&format!("{value}\n"))?;
        return failure.map_or(Ok(()), |error| Err(Failure::Run(error)));
    }
    print(&summary(&packed, &path, bytes.len()))?;
    if let Some(error) = failure {
        return Err(Failure::Run(error));
    }
    let Some(stop) = stop else {
        print("\nNot checked (--check none).\n")?;
        return Ok(());
    };
    let mut head = vec!["time s".to_string()];
    head.extend(shown.iter().map(|(_, column)| column.1.to_string()));
    let body: Vec<Vec<String>> = rows
        .iter()
        .map(|(time, values)| {
            let mut row = vec![format!("{time:.2}")];
            row.extend(values.iter().zip(&shown).map(|(value, (output, column))| {
                let digits = if output.unit == Unit::Distance { 1 } else { 3 };
                format!("{:.digits$}", value * column.2)
            }));
            row
        })
        .collect();
    print(&format!("\nIts own library, stepped by {} ms through the C interface:\n\n", rounded(1e3 * run.step)))?;
    print(&table(&head, &body))?;
    if stop > 0.0 {
        let part = if stop < run.stop { format!(" of {} s (--check full: all)", rounded(run.stop)) } else { String::new() };
        print(&format!("\n  {} s{part} simulated in {elapsed:.3} s, start and outputs included.\n", rounded(stop)))?;
    }
    Ok(())
}

fn summary(packed: &PackedScene, path: &Path, bytes: usize) -> String {
    let count = |causality: &str| packed.table.variables.iter().filter(|variable| variable.causality == causality).count();
    format!(
        "{}: FMI {} co-simulation, {} kB\n  {}\n  {} inputs, {} outputs, {} parameters; platform {}; {} {}\n",
        path.display(),
        packed.table.version.name(),
        bytes / 1000,
        packed.scene.title,
        count("input"),
        count("output"),
        count("parameter"),
        packed.table.version.platform(),
        if packed.table.version == Version::Two { "GUID" } else { "instantiation token" },
        packed.description.guid
    )
}
