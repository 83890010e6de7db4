//! `wheelrail export SCENE`: writes the FMU, then loads its own library and steps it.

use super::output::{Kind, Target};
use super::{Failure, SceneArguments, print, refused, say, table};
use crate::fmi::check::{CheckRow, check};
use crate::fmi::libraries::{self, LibraryError, Named};
use crate::fmi::package::{self, PackageError, PackedScene};
use crate::fmi::version::Version;
use crate::fmi::{reference_results, system_structure};
use crate::sim::outputs::Output;
use crate::study::digits::rounded;
use crate::study::modes::rest::unstable_rest;
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
    /// The file to write [default: NAME.fmu, or NAME.ssp]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// A system (SSP 1.0) in place of an FMU: the FMU wired to placeholders for models of traction, brakes, control and track
    #[arg(long)]
    ssp: bool,
    /// Version of FMI: 2 for the widest choice of tools, 3 for events, early return, updates within steps and arrays (docs/fmu.md)
    #[arg(long, value_name = "VERSION", default_value = "2")]
    fmi: Fmi,
    /// A library that goes into the FMU: of another platform (repeat it for several), or this host's where it is not next to this program; PLATFORM is win64,
    /// aarch64-linux, x86_64-darwin ... and may be left out (docs/fmu.md)
    #[arg(long, value_name = "[PLATFORM=]FILE")]
    library: Vec<Named>,
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
            PackageError::Archive(_) => Failure::Run(error.to_string()),
            _ => Failure::Input(error.to_string()),
        }
    }
}

impl From<LibraryError> for Failure {
    fn from(error: LibraryError) -> Self {
        Failure::Input(error.to_string())
    }
}

pub(super) fn export(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    if arguments.ssp && arguments.fmi != Fmi::Two {
        return Err(Failure::Input("--ssp writes SSP 1.0, which knows FMUs of FMI 2.0 alone: leave --fmi 3 out".into()));
    }
    let (kind, ending) = if arguments.ssp { (Kind::Ssp, "ssp") } else { (Kind::Fmu, "fmu") };
    let path = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.{ending}", scene.name)));
    // Known before the work.
    let target = Target::find(&path, kind).map_err(refused)?;
    let libraries = libraries::find(&arguments.library)?;
    let packed = package::pack_scene_as(&scene, arguments.fmi.into())?;
    let mut files = package::files(&packed, &libraries);
    let mut simulation = super::start_of(&packed.scene, &scene.source.file)?;
    if let Some(words) = unstable_rest(&packed.scene, &mut simulation) {
        say(&format!("note: {words}"));
    }
    let stop = arguments.check.stop(packed.scene.run.stop);
    files.extend(stop.map(|stop| reference_results::files(&packed, stop)).unwrap_or_default());
    let mut bytes = package::archive(&files)?;
    if arguments.ssp {
        bytes = package::archive(&system_structure::files(&packed, bytes))?;
    }

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
    let (rows, failure) = match stop.map(|stop| check(&files, &packed, &references, stop, run.step, ROWS)) {
        None => (Vec::new(), None),
        Some(Ok(rows)) => (rows, None),
        Some(Err(error)) => {
            let place = path.display();
            (Vec::new(), Some(format!("{error}; {place} was written before the check and stands there as it is: don't rely on it")))
        }
    };
    let elapsed = start.elapsed().as_secs_f64();
    let platforms: Vec<String> = libraries.iter().map(|library| library.platform.folder(packed.table.version)).collect();
    if arguments.json {
        let columns: Vec<_> = shown.iter().map(|(output, _)| &output.name).collect();
        let value = serde_json::json!({
            "fmu": path, "bytes": bytes.len(), "fmi": packed.table.version.name(), "guid": packed.description.guid, "platforms": platforms,
            "variables": packed.table.variables.len(), "seconds": elapsed, "columns": columns, "rows": rows,
            "check": arguments.check.name(), "checked": stop, "error": failure,
        });
        print(&format!("{value}\n"))?;
        return failure.map_or(Ok(()), |error| Err(Failure::Run(error)));
    }
    print(&summary(&packed, &path, bytes.len(), &platforms))?;
    if let Some(error) = failure {
        return Err(Failure::Run(error));
    }
    let Some(stop) = stop else {
        print("\nNot checked (--check none).\n")?;
        return Ok(());
    };
    print(&format!("\nIts own library, stepped by {} ms through the C interface:\n\n", rounded(1e3 * run.step)))?;
    print(&steps(&shown, &rows))?;
    if stop > 0.0 {
        let part = if stop < run.stop { format!(" of {} s (--check full: all)", rounded(run.stop)) } else { String::new() };
        print(&format!("\n  {} s{part} simulated in {elapsed:.3} s, start and outputs included.\n", rounded(stop)))?;
    }
    Ok(())
}

/// The table of what happened.
fn steps(shown: &[(&Output, &(&str, &str, f64))], rows: &[CheckRow]) -> String {
    let mut head = vec!["time s".to_string()];
    head.extend(shown.iter().map(|(_, column)| column.1.to_string()));
    let body: Vec<Vec<String>> = rows
        .iter()
        .map(|(time, values)| {
            let mut row = vec![format!("{time:.2}")];
            row.extend(values.iter().zip(shown).map(|(value, (output, column))| {
                let digits = if output.unit == Unit::Distance { 1 } else { 3 };
                format!("{:.digits$}", value * column.2)
            }));
            row
        })
        .collect();
    table(&head, &body)
}

fn summary(packed: &PackedScene, path: &Path, bytes: usize, platforms: &[String]) -> String {
    let count = |causality: &str| packed.table.variables.iter().filter(|variable| variable.causality == causality).count();
    let what = if path.extension().is_some_and(|ending| ending == "ssp") { "SSP 1.0 of an FMU, " } else { "" };
    format!(
        "{}: {what}FMI {} co-simulation, {} kB\n  {}\n  {} inputs, {} outputs, {} parameters; {} {}; {} {}\n",
        path.display(),
        packed.table.version.name(),
        bytes / 1000,
        packed.scene.title,
        count("input"),
        count("output"),
        count("parameter"),
        if platforms.len() == 1 { "platform" } else { "platforms" },
        platforms.join(", "),
        if packed.table.version == Version::Two { "GUID" } else { "instantiation token" },
        packed.description.guid
    )
}
