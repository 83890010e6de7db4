//! `wheelrail export SCENE`: writes the FMU, then loads its own library and steps it.

use super::{Failure, SceneArguments, print, table};
use crate::fmi::package::{self, PackageError, PackedScene};
use crate::sim::unit::Unit;
use crate::study::digits::rounded;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The FMU to write [default: NAME.fmu]
    #[arg(short, long, value_name = "FILE.fmu")]
    output: Option<PathBuf>,
    /// The FMU's library, when it is not next to this program
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
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
    let library = package::find_library(arguments.library.as_deref())?;
    let packed = package::pack_scene(&scene)?;
    let files = package::files(&packed, &library);
    let bytes = package::archive(&files)?;
    let path = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.fmu", packed.scene.name)));
    super::start(&packed.scene)?;

    let name = &packed.scene.vehicle.wheelset.name;
    let shown: Vec<_> = COLUMNS
        .iter()
        .filter_map(|column| {
            let full = format!("{name}.{}", column.0);
            packed.table.outputs.iter().find(|output| output.name == full).map(|output| (output, column))
        })
        .collect();
    let references: Vec<u32> = shown.iter().map(|(output, _)| output.reference).collect();
    let start = Instant::now();
    let run = packed.scene.run;
    let rows = package::check(&files, &packed, &references, run.stop, run.step, ROWS)?;
    let elapsed = start.elapsed().as_secs_f64();
    // Only an FMU that has passed its check takes the place of an older one.
    package::write_whole(&path, &bytes)?;

    if arguments.json {
        let columns: Vec<_> = shown.iter().map(|(output, _)| &output.name).collect();
        let value = serde_json::json!({
            "fmu": path, "bytes": bytes.len(), "guid": packed.description.guid, "platform": package::platform(),
            "variables": packed.table.variables.len(), "seconds": elapsed, "columns": columns, "rows": rows,
        });
        print(&format!("{value}\n"));
        return Ok(());
    }
    print(&summary(&packed, &path, bytes.len()));
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
    print(&format!("\nIts own library, stepped by {} ms through the C interface:\n\n", rounded(1e3 * run.step)));
    print(&table(&head, &body));
    if run.stop > 0.0 {
        print(&format!("\n  {} s simulated in {elapsed:.3} s, start and outputs included.\n", run.stop));
    }
    Ok(())
}

fn summary(packed: &PackedScene, path: &Path, bytes: usize) -> String {
    let count = |causality: &str| packed.table.variables.iter().filter(|variable| variable.causality == causality).count();
    format!(
        "{}: FMI 2.0 co-simulation, {} kB\n  {}\n  {} inputs, {} outputs, {} parameters; platform {}; GUID {}\n",
        path.display(),
        bytes / 1000,
        packed.scene.title,
        count("input"),
        count("output"),
        count("parameter"),
        package::platform(),
        packed.description.guid
    )
}
