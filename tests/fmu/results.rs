//! Result files of `wheelrail run`, read back by other programs.

use super::{ROOT, python, run};
use std::path::Path;
use std::process::Command;

/// CSV, Parquet and MAT of one run hold the same numbers, bit for bit; units, indices and names are where readers look for them; single precision is the nearest one; fewer rows are those
/// that scipy's filter makes.
#[test]
fn validate_results_read_back_by_pyarrow_pandas_and_scipy() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, more: &[&str]| {
        let file = folder.path().join(name);
        let begin = ["run", "bogie", "--stop", "2.001", "--step", "2 ms", "--json", "-o", file.to_str().unwrap()];
        run(Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(begin).args(more));
    };
    for name in ["double.csv", "double.parquet", "double.mat"] {
        write(name, &[]);
    }
    for name in ["single.csv", "single.parquet", "single.mat"] {
        write(name, &["--precision", "float32"]);
    }
    write("distance.parquet", &["--index", "distance", "--columns", "*.y,*.distance"]);
    write("thin.parquet", &["--every", "20 ms"]);
    write("thin.csv", &["--every", "20 ms"]);
    // One of these runs is refused (no friction coefficient is negative), and one key has words.
    let sweep = [
        "sweep",
        "suspended_wheelset",
        "--stop",
        "0.05",
        "--step",
        "0.01",
        "--set",
        "contact.friction=0.3,0.4,-1",
        "--set",
        "contact.creep.law=kalker_linear,usetab",
    ];
    let [csv, columns] = ["sweep.csv", "sweep.parquet"].map(|name| folder.path().join(name));
    run(Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(sweep).arg("-o").arg(&csv).arg("--parquet").arg(&columns));
    run(Command::new(python()).arg(Path::new(ROOT).join("tests/fmu/results.py")).arg(folder.path()));
}
