//! `wheelrail sweep` as a program.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    command.arg("sweep").args(arguments);
    command
}

fn sweep(arguments: &[&str]) -> (String, String, i32) {
    let output = command(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap()
}

/// Rows as name -> text.
fn rows(file: &Path) -> Vec<std::collections::HashMap<String, String>> {
    csv::Reader::from_path(file).unwrap().deserialize().map(|row| row.unwrap()).collect()
}

const SCENE: [&str; 5] = ["suspended_wheelset", "--stop", "0.2", "--step", "0.01"];
const GRID: [&str; 4] = ["--set", "vehicle.speed=72..108:18 km/h", "--set", "contact.friction=0.3,0.5"];

#[test]
fn prop_a_grid_is_the_same_table_whatever_runs_beside_what() {
    let folder = tempfile::tempdir().unwrap();
    let [one, four, plot] = ["one.csv", "four.csv", "map.svg"].map(|name| folder.path().join(name));
    let scalars = ["--scalar", "max:*.verticalForce", "--scalar", "end:wheelset.distance", "--scalar", "p50:wheelset.vx"];
    let call = |file: &Path, more: &[&str]| sweep(&[&SCENE[..], &GRID, &scalars, &["-o", file.to_str().unwrap()], more].concat());
    let (words, said, code) = call(&one, &["--parallel", "1"]);
    assert!(code == 0 && words.contains("6 runs: 6 ok"), "{words}{said}");
    let (json, _, _) = call(&four, &["--parallel", "4", "--json", "--plot", plot.to_str().unwrap()]);
    assert_eq!(read(&one), read(&four));
    let rows = rows(&one);
    assert_eq!(
        read(&one).lines().next().unwrap().split(',').take(5).collect::<Vec<_>>(),
        ["run", "vehicle.speed [km/h]", "contact.friction", "state", "time [s]"]
    );
    for (run, row) in rows.iter().enumerate() {
        let speed: f64 = row["vehicle.speed [km/h]"].parse().unwrap();
        assert_eq!((row["run"].parse::<usize>().unwrap(), row["state"].as_str(), row["time [s]"].as_str()), (run, "ok", "0.2"));
        let distance: f64 = row["end:wheelset.distance [m]"].parse().unwrap();
        assert!(
            (distance - 0.2 * speed / 3.6).abs() < 1e-9
                && (row["p50:wheelset.vx [m/s]"].parse::<f64>().unwrap() - speed / 3.6).abs() < 1e-9
        );
    }
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (found["runs"].as_u64(), found["states"]["ok"].as_u64(), found["scalars"][1]["highest"]["run"].as_u64()),
        (Some(6), Some(6), Some(5))
    );
    assert!(read(&plot).contains("contact.friction") && read(&plot).contains("dark: low"));
    // The same numbers as a run of its own.
    let own = Command::new(env!("CARGO_BIN_EXE_wheelrail"))
        .args(["run", SCENE[0], "--stop", "0.2", "--step", "0.01", "--set", "vehicle.speed=25", "--set", "contact.friction=0.5", "--json"])
        .output()
        .unwrap();
    let own: serde_json::Value = serde_json::from_slice(&own.stdout).unwrap();
    let extremes = ["left", "right"].map(|side| own["extremes"][format!("wheelset.{side}.verticalForce")]["max"].as_f64().unwrap());
    assert_eq!(rows[3]["max:*.verticalForce [N]"].parse::<f64>().unwrap(), extremes[0].max(extremes[1]));
}

/// A table with some of its rows and half a line goes on to the same bytes, without the rows that are there.
#[test]
fn prop_own_expressions_are_columns() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("table.csv");
    let call = |scalars: &[&str]| {
        let scalars: Vec<&str> = scalars.iter().flat_map(|text| ["--scalar", *text]).collect();
        sweep(&[&SCENE[..], &GRID, &scalars, &["-o", file.to_str().unwrap()]].concat())
    };
    let spread = "spread [kN] = ({max:*.verticalForce} - {min:*.verticalForce}) / 1000";
    let asked = [
        "max:*.verticalForce",
        spread,
        "least = {min:*.verticalForce}",
        "nothing = 1 / ({end:wheelset.distance} - {end:wheelset.distance})",
    ];
    let (words, said, code) = call(&asked);
    assert!(code == 0 && words.contains("spread [kN]"), "{words}{said}");
    for row in rows(&file) {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        assert_eq!(number("spread [kN]"), (number("max:*.verticalForce [N]") - number("least")) / 1000.0);
        assert!(number("least") > 5e4 && row["nothing"].is_empty());
    }
    // The same names for other expressions are another sweep.
    let other = spread.replace("1000", "1e6");
    let (_, said, code) = call(&[asked[0], other.as_str(), asked[2], asked[3]]);
    assert!(code == 2 && said.contains("a run of another scene, or with other files, times or expressions"), "{said}");
    for (wrong, why) in [
        ("x = {max:*.verticalForce", "braces do not pair"),
        ("x = verticalForce + 1", "verticalForce is no number; expected scalars in braces"),
        ("x = {most:*.verticalForce}", "expected KIND:OUTPUT"),
        ("= {max:*.verticalForce}", "the expression has no name"),
        ("x = {max:*.verticalForce} +", "the last element cannot be an operator"),
        ("max:*.verticalForce", "is there twice"),
    ] {
        let (_, said, code) = call(&["max:*.verticalForce", wrong]);
        assert!(code == 2 && said.contains(why), "{wrong}: {said}");
    }
}

/// A file that the values of single runs name belongs to the sweep: with another content its rows are another sweep's.
#[test]
fn prop_a_swept_file_with_another_content_is_another_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("a.txt", "one");
    write("b.txt", "two");
    let call = || {
        let arguments = [&SCENE[..], &["--set", "title=a.txt,b.txt", "-o", "runs.csv"]].concat();
        let output = command(&arguments).current_dir(folder.path()).output().unwrap();
        (String::from_utf8(output.stderr).unwrap(), output.status.code().unwrap())
    };
    assert_eq!(call().1, 0);
    let (said, code) = call();
    assert!(code == 0 && said.contains("2 of 2 runs have a row already"), "{said}");
    write("b.txt", "other");
    let (said, code) = call();
    assert!(code == 2 && said.contains("a run of another scene"), "{said}");
}

#[test]
fn prop_a_broken_off_table_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("runs.csv");
    let name = file.to_str().unwrap();
    let call = || sweep(&[&SCENE[..], &GRID, &["-o", name]].concat());
    assert_eq!(call().2, 0);
    let whole = read(&file);
    let lines: Vec<&str> = whole.split_inclusive('\n').collect();
    // A row that was not run by us is kept as it is: it is not run again.
    let marked = lines[4].replacen(",ok,0.2,", ",ok,0.19,", 1);
    assert_ne!(marked, lines[4]);
    std::fs::write(&file, format!("{}{}{}{}", lines[0], marked, lines[2], &lines[1][..30])).unwrap();
    let (_, said, code) = call();
    assert!(code == 0 && said.contains("2 of 6 runs have a row already"), "{said}");
    assert_eq!(read(&file), whole.replace(lines[4], &marked));
    // Another scene, other values, other scalars are refused, and nothing is lost.
    let kept = read(&file);
    let others: [(&[&str], &str); 4] = [
        (&["--set", "vehicle.gravity=9.8"], "a run of another scene"),
        (&["--stop", "0.3"], "a run of another scene"),
        (&["--scalar", "max:*.verticalForce"], "the table of another sweep"),
        (&["--set", "vehicle.initial.y=0,1 mm"], "the table of another sweep"),
    ];
    for (more, expected) in others {
        let mut arguments = [&SCENE[..1], &GRID, &["-o", name, "--step", "0.01"], more].concat();
        if !more.contains(&"--stop") {
            arguments.extend(["--stop", "0.2"]);
        }
        let (_, said, code) = sweep(&arguments);
        assert!(code == 2 && said.contains(expected) && said.contains("choose another file"), "{more:?}: {said}");
    }
    assert_eq!(read(&file), kept);
}

/// A killed process leaves whole rows; the next call makes what is missing.
#[test]
fn hard_a_killed_sweep_loses_the_runs_in_flight_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("runs.csv");
    let arguments =
        ["suspended_wheelset", "--set", "vehicle.speed=20..59:1", "--stop", "1", "-o", file.to_str().unwrap(), "--parallel", "2"];
    let mut child = command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let started = Instant::now();
    let lines = || std::fs::read_to_string(&file).unwrap_or_default().lines().count();
    while lines() < 6 && started.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = lines() - 1;
    assert!((5..40).contains(&before), "{before} rows");
    let (words, said, code) = sweep(&arguments);
    assert!(code == 0 && words.contains("40 runs: 40 ok") && said.contains("runs have a row already"), "{words}{said}");
    let runs: Vec<usize> = rows(&file).iter().map(|row| row["run"].parse().unwrap()).collect();
    assert_eq!(runs, (0..40).collect::<Vec<_>>());
}

#[test]
fn prop_failures_are_rows() {
    let folder = tempfile::tempdir().unwrap();
    let (file, plot) = (folder.path().join("runs.csv"), folder.path().join("lines.svg"));
    let arguments = ["--set", "vehicle.speed=0,30,-600", "-o", file.to_str().unwrap(), "--plot", plot.to_str().unwrap()];
    let (words, _, code) = sweep(&[&SCENE[..], &arguments].concat());
    assert!(code == 0 && words.contains("3 runs: 1 ok, 2 refused"), "{words}");
    let rows = rows(&file);
    let states: Vec<&str> = rows.iter().map(|row| row["state"].as_str()).collect();
    assert_eq!(states, ["refused", "ok", "refused"]);
    assert!(
        rows[0]["reason"].contains("creepages are relative")
            && rows[0]["max:*.verticalForce [N]"].is_empty()
            && rows[1]["reason"].is_empty()
    );
    // A rail that goes away from under its wheel.
    let gap = "[[track.deviation]]\nrail = \"right\"\ndirection = \"lateral\"\nshape = \"cosine\"\namplitude = \"0 mm\"\nfrom = 110.0\nto = 130.0\n";
    let flanged = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenes/apta_flange.toml");
    let scene = folder.path().join("gap.toml");
    std::fs::write(&scene, std::fs::read_to_string(flanged).unwrap().replace("[contact]\n", &format!("{gap}\n[contact]\n"))).unwrap();
    let file = folder.path().join("gap.csv");
    let arguments = [
        scene.to_str().unwrap(),
        "--set",
        "track.deviation[1].amplitude=-1 mm,-150 mm",
        "--scalar",
        "max:*.verticalForce",
        "-o",
        file.to_str().unwrap(),
    ];
    let (words, said, code) = sweep(&arguments);
    assert_eq!(code, 0, "{words}{said}");
    let rows = self::rows(&file);
    let time: f64 = rows[1]["time [s]"].parse().unwrap();
    assert!(rows[1]["state"] == "derailed" && time > 0.5 && time < 1.5 && rows[1]["reason"].contains("derailed"), "{:?}", rows[1]);
    assert!(rows[1]["max:*.verticalForce [N]"].parse::<f64>().unwrap() > 5e4);
}

#[test]
fn prop_a_hypercube_is_drawn_from_a_seed() {
    let folder = tempfile::tempdir().unwrap();
    let table = |name: &str, seed: &str| {
        let file = folder.path().join(name);
        let arguments = ["--latin", "5", "--seed", seed, "--set", "contact.friction=0.1..0.6", "--set", "vehicle.initial.y=-1..1 mm"];
        let (words, said, code) = sweep(&[&SCENE[..], &arguments, &["-o", file.to_str().unwrap()]].concat());
        assert!(code == 0 && words.contains("5 runs: 5 ok"), "{words}{said}");
        read(&file)
    };
    let first = table("a.csv", "7");
    assert_eq!(first, table("b.csv", "7"));
    assert_ne!(first, table("c.csv", "8"));
}

#[test]
fn hard_sweeps_that_make_no_sense_are_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.csv");
    let file = file.to_str().unwrap();
    let speeds = ["--set", "vehicle.speed=20,30"];
    let cases: &[(&[&str], &str)] = &[
        (&["--set", "vehicle.speed=20", "-o", file], "nothing varies"),
        (&["--set", "vehicle.speed=20..30", "-o", file], "has no step"),
        (&["--set", "vehicle.speed=30..20:1", "-o", file], "a range that grows"),
        (&["--set", "vehicle.speed=20..30 m/s:1 km/h", "-o", file], "one unit for all"),
        (&["--set", "a=0..1:1e-4", "--set", "b=0..1:1e-4", "-o", file], "expected at most 1000000"),
        (&[speeds[0], speeds[1], "-o", "-"], "written to a file"),
        (&[speeds[0], speeds[1], "-o", "/no/such/folder/x.csv"], "can't be written"),
        (&[speeds[0], speeds[1], "-o", file, "--scalar", "most:*.y"], "expected KIND:OUTPUT"),
        (&[speeds[0], speeds[1], "-o", file, "--scalar", "max:*.q"], "no output of that name"),
        (&[speeds[0], speeds[1], "-o", file, "--scalar", "max:wheelset.*"], "different units"),
        (&[speeds[0], speeds[1], "-o", file, "--parallel", "0"], "--parallel"),
        (&[speeds[0], speeds[1]], "--output"),
    ];
    for (arguments, expected) in cases {
        let (_, said, code) = sweep(&[&["suspended_wheelset"], *arguments].concat());
        assert!(code == 2 && said.contains(expected), "{arguments:?}: {code} {said}");
    }
    assert!(!Path::new(file).exists(), "what is refused leaves nothing");
}
