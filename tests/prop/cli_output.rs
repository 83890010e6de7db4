//! What the program writes: nothing that was computed is lost, nothing that can't be written is passed over.
#![cfg(unix)]

use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A run that takes longer than any of these tests waits.
const ENDLESS: [&str; 4] = ["run", "suspended_wheelset", "--stop", "100000"];
const BRIEF: [&str; 4] = ["run", "suspended_wheelset", "--stop", "0.1"];

fn wheelrail(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    command.args(arguments).current_dir(env!("CARGO_TARGET_TMPDIR"));
    command
}

fn text(output: &Output) -> (String, String, i32) {
    let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (read(&output.stdout), read(&output.stderr), output.status.code().unwrap_or(-1))
}

fn run(arguments: &[&str]) -> (String, String, i32) {
    text(&wheelrail(arguments).output().unwrap())
}

/// Files of a folder that a run has not finished.
fn parts(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    all.filter(|path| path.extension().is_some_and(|ending| ending == "part")).collect()
}

/// Waits until a run has written rows.
fn wait_for_rows(folder: &Path) {
    let begin = Instant::now();
    while !parts(folder).iter().any(|part| std::fs::metadata(part).is_ok_and(|there| there.len() > 0)) {
        assert!(begin.elapsed() < Duration::from_secs(60), "no rows");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

/// Starts an endless run into `folder`/keep.csv, which holds "old", and sends a signal when rows are written.
fn interrupted(folder: &Path, signal: &str, more: &[&str]) -> (Output, PathBuf) {
    let file = folder.join("keep.csv");
    std::fs::write(&file, "old").unwrap();
    let arguments = [&ENDLESS[..], &["-o", file.to_str().unwrap()], more].concat();
    let child = wheelrail(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_rows(folder);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "old", "the earlier result stands until the end");
    send(signal, &child);
    (child.wait_with_output().unwrap(), file)
}

#[test]
fn hard_a_signal_ends_a_run_in_order_and_keeps_its_rows() {
    for (signal, expected) in [("-INT", 130), ("-TERM", 143)] {
        let folder = tempfile::tempdir().unwrap();
        let (output, file) = interrupted(folder.path(), signal, &["--plot", folder.path().join("plots").to_str().unwrap()]);
        let (stdout, stderr, code) = text(&output);
        assert_eq!(code, expected, "{stderr}");
        let written = std::fs::read_to_string(&file).unwrap();
        let rows = written.lines().count() - 1;
        let said = stderr.lines().find(|line| line.starts_with("interrupted at t = ")).unwrap();
        assert!(rows > 1 && written.ends_with('\n') && said.contains(&format!("{rows} rows until then are in ")), "{said}");
        let width = |line: &str| line.matches(',').count();
        assert!(written.lines().all(|line| width(line) == width(written.lines().next().unwrap())), "whole rows");
        assert!(stdout.contains("lateral displacement [mm]") && folder.path().join("plots/suspended_wheelset.svg").exists());
        assert!(parts(folder.path()).is_empty());
    }
    let folder = tempfile::tempdir().unwrap();
    let (stdout, stderr, code) = text(&interrupted(folder.path(), "-INT", &["--json"]).0);
    let summary: serde_json::Value = serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{error}: {stdout}{stderr}"));
    assert!(code == 130 && summary["error"].as_str().is_some_and(|error| error.starts_with("interrupted at")), "{summary}");
}

#[test]
fn hard_a_kill_leaves_the_earlier_result_and_the_rows_so_far() {
    let folder = tempfile::tempdir().unwrap();
    let (_, file) = interrupted(folder.path(), "-KILL", &[]);
    assert_eq!(std::fs::read_to_string(file).unwrap(), "old");
    let parts = parts(folder.path());
    assert!(parts.len() == 1 && std::fs::read_to_string(&parts[0]).unwrap().lines().count() > 2, "{parts:?}");
}

/// A limit on the size of files stands for a full disk.
#[test]
fn hard_a_full_disk_is_an_error_and_costs_nothing_written_before() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keep.csv");
    std::fs::write(&file, "old").unwrap();
    let script = format!("trap '' XFSZ; ulimit -f 100; exec \"$0\" {} -o \"$1\"", ENDLESS.join(" "));
    let output = Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_wheelrail"), file.to_str().unwrap()]).output().unwrap();
    let (_, stderr, code) = text(&output);
    assert!(
        code == 1 && stderr.contains("keep.csv: can't be written: ") && stderr.contains("what was written until then is in "),
        "{stderr}"
    );
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "old");
    assert_eq!(parts(folder.path()).len(), 1);
}

#[test]
fn hard_a_full_standard_output_is_an_error_of_every_command() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let cases: &[&[&str]] = &[
        &["list"],
        &["list", "scenes", "--json"],
        &["scene", "bogie"],
        &["plan", "suspended_wheelset"],
        &["plan", "suspended_wheelset", "--json"],
        &BRIEF,
        &["run", "suspended_wheelset", "--stop", "0.1", "--json"],
        &["run", "suspended_wheelset", "--stop", "0.1", "-o", "-"],
        &["profile", "60e1"],
        &["profile", "60e1", "-o", "-"],
        &["contact", "suspended_wheelset", "--range", "1 mm", "--amplitude", "0.5 mm"],
        &["contact", "suspended_wheelset", "--patch", "--cells", "8"],
        &["compare", "suspended_wheelset", "--stop", "0.05", "--formulations", "ECF-A", "-o", "compared"],
        &["export", "suspended_wheelset", "-o", "full.fmu", "--check", "none"],
        &["modes", "suspended_wheelset"],
        &["modes", "suspended_wheelset", "--sweep", "vehicle.speed=20..30:5", "--json"],
        &["hard", "--list"],
        &["hard", "--random-scene", "1"],
        &["--help"],
        &["run", "--help"],
        &["--version"],
    ];
    for arguments in cases {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let (_, stderr, code) = text(&wheelrail(arguments).stdout(full).output().unwrap());
        assert!(code == 1 && stderr.contains("error: standard output: can't be written: "), "{arguments:?}: {code} {stderr}");
    }
    let (_, stderr, code) = run(&[&BRIEF[..], &["-o", "/dev/full"]].concat());
    assert!(code == 1 && stderr.contains("/dev/full: can't be written: "), "{code} {stderr}");
}

#[test]
fn prop_a_reader_that_has_seen_enough_is_no_error() {
    for arguments in [&["list"][..], &["scene", "bogie"], &[&ENDLESS[..], &["-o", "-"]].concat()] {
        let mut child = wheelrail(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        // Nobody reads on: an endless run ends.
        drop(child.stdout.take());
        let (_, stderr, code) = text(&child.wait_with_output().unwrap());
        assert!(code == 0 && stderr.is_empty(), "{arguments:?}: {code} {stderr}");
    }
}

#[test]
fn prop_export_writes_through_links_and_refuses_what_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let export = |name: &str| run(&["export", "suspended_wheelset", "--check", "none", "-o", path(name).to_str().unwrap()]);
    std::fs::write(path("real.fmu"), "old").unwrap();
    symlink("real.fmu", path("link.fmu")).unwrap();
    let (stdout, stderr, code) = export("link.fmu");
    assert!(code == 0 && stdout.contains("Not checked"), "{stderr}");
    assert!(std::fs::symlink_metadata(path("link.fmu")).unwrap().is_symlink(), "the link stays");
    assert!(std::fs::metadata(path("real.fmu")).unwrap().len() > 100_000, "its file is the FMU");
    assert!(Command::new("mkfifo").arg(path("pipe")).status().unwrap().success());
    std::fs::create_dir(path("folder.fmu")).unwrap();
    for (name, words) in [("pipe", "a device, a pipe or a socket"), ("folder.fmu", "a folder"), ("x.csv", "ends in .fmu")] {
        let (_, stderr, code) = export(name);
        assert!(code == 2 && stderr.contains(words), "{name}: {stderr}");
    }
    assert!(std::fs::symlink_metadata(path("pipe")).unwrap().file_type().is_fifo());
    assert!(parts(folder.path()).is_empty());
}

/// The FMU is there before it is checked; by default half a second of it is.
#[test]
fn prop_export_checks_what_it_wrote_as_far_as_it_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.fmu");
    let export = |more: &[&str]| {
        let fixed = ["export", "suspended_wheelset", "-o", file.to_str().unwrap(), "--json"];
        let (stdout, stderr, code) = run(&[&fixed[..], more].concat());
        let report: serde_json::Value = serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{error}: {stdout}{stderr}"));
        (report, stderr, code)
    };
    for (more, checked) in
        [(&[][..], Some(0.5)), (&["--check", "none"], None), (&["--check", "full", "--set", "run.stop=0.75"], Some(0.75))]
    {
        let (report, stderr, code) = export(more);
        assert!(code == 0 && report["checked"].as_f64() == checked && report["error"].is_null(), "{more:?}: {report} {stderr}");
        assert_eq!(report["rows"].as_array().unwrap().len(), if checked.is_some() { 11 } else { 0 });
    }
    std::fs::remove_file(&file).unwrap();
    // Thrown sideways on a slippery rail it leaves its profile.
    let (report, stderr, code) = export(&["--set", "vehicle.initial.vy=2.5", "--set", "contact.friction=0.01"]);
    assert!(code == 1 && stderr.contains("failed its check") && stderr.contains("was written before the check"), "{stderr}");
    assert!(report["error"].is_string() && std::fs::metadata(&file).unwrap().len() > 100_000);
}

#[test]
fn prop_columns_are_chosen_by_pattern_and_hold_the_same_numbers() {
    let all = run(&[&BRIEF[..], &["-o", "-"]].concat()).0;
    let (few, stderr, code) = run(&[&BRIEF[..], &["-o", "-", "--columns", "*.verticalForce,wheelset.y?w"]].concat());
    assert_eq!(code, 0, "{stderr}");
    let head: Vec<&str> = few.lines().next().unwrap().split(',').collect();
    assert_eq!(head, ["time [s]", "wheelset.yaw [rad]", "wheelset.left.verticalForce [N]", "wheelset.right.verticalForce [N]"]);
    let whole: Vec<Vec<&str>> = all.lines().map(|line| line.split(',').collect()).collect();
    let places: Vec<usize> = head.iter().map(|name| whole[0].iter().position(|other| other == name).unwrap()).collect();
    for (line, row) in few.lines().zip(&whole) {
        assert_eq!(line.split(',').collect::<Vec<_>>(), places.iter().map(|place| row[*place]).collect::<Vec<_>>());
    }
    assert_eq!(few.lines().count(), all.lines().count());
    // The summary does not depend on what is written.
    let (stdout, stderr, _) = run(&[&BRIEF[..], &["--columns", "*.ay"]].concat());
    assert!(stdout.contains("Q left [kN]") && stderr.contains("--columns: about rows that are written"), "{stdout}{stderr}");
    let (_, stderr, code) = run(&[&BRIEF[..], &["--columns", "whelset.y"]].concat());
    assert!(code == 2 && stderr.contains("--columns whelset.y (did you mean \"wheelset.y\"?): no output of that name"), "{stderr}");
}

/// Numbers in a CSV file are the recorded ones to the last bit.
#[test]
fn prop_rows_lose_no_bit() {
    use wheelrail::sim::recording::{CsvRows, Recording};
    let recording = Recording { columns: vec![("time".into(), "s"), ("x".into(), "m")], rows: vec![], notes: vec![] };
    let mut rows = CsvRows::begin(Vec::new(), &recording, vec![0, 1]).unwrap();
    let mut bits = 0x9e37_79b9_7f4a_7c15u64;
    let mut values = vec![0.0, -0.0, 1.0, 1e-5, 0.1, 1e16, 1e21, f64::MIN_POSITIVE, 5e-324, f64::MAX, f64::INFINITY, f64::NEG_INFINITY];
    for _ in 0..20_000 {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        values.push(f64::from_bits(bits));
        values.push(1e-3 * (bits >> 12) as f64 / 2f64.powi(52));
    }
    values.retain(|value| !value.is_nan());
    for value in &values {
        rows.write(&[*value, f64::NAN]).unwrap();
    }
    let text = String::from_utf8(rows.writer).unwrap();
    for (line, value) in text.lines().skip(1).zip(&values) {
        let (first, second) = line.split_once(',').unwrap();
        assert_eq!(first.parse::<f64>().unwrap().to_bits(), value.to_bits(), "{first}");
        assert_eq!(second, "NaN");
    }
    assert_eq!(text.lines().count(), values.len() + 1);
}

#[test]
fn prop_other_endings_are_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    for (command, name) in [("run", "x.xlsx"), ("contact", "x.parquet"), ("run", "x.fmu")] {
        let path = folder.path().join(name);
        let (_, stderr, code) = run(&[command, "suspended_wheelset", "-o", path.to_str().unwrap()]);
        assert!(code == 2 && stderr.contains("expected a name that ends in .csv") && !path.exists(), "{command} {name}: {stderr}");
    }
    let capitals = folder.path().join("X.CSV");
    assert_eq!(run(&[&BRIEF[..], &["-o", capitals.to_str().unwrap()]].concat()).2, 0);
}

/// Every embedded scene is a file to start from, which says the same.
#[test]
fn equiv_printed_scenes_are_the_embedded_ones() {
    use wheelrail::scene::{embedded, load};
    let folder = tempfile::tempdir().unwrap();
    for scene in embedded::SCENES {
        let (stdout, stderr, code) = run(&["scene", scene.name]);
        assert!(code == 0 && stdout == scene.text, "{stderr}");
        let file = folder.path().join(format!("{}.toml", scene.name));
        std::fs::write(&file, stdout).unwrap();
        let opened = load::open(file.to_str().unwrap(), &[]).unwrap();
        assert_eq!((opened.name.as_str(), opened.run), (scene.name, load::open(scene.name, &[]).unwrap().run));
    }
    let (_, stderr, code) = run(&["scene", "bogies"]);
    assert!(code == 2 && stderr.contains("did you mean \"bogie\"?") && stderr.contains("vehicle_curve"), "{stderr}");
    // The FMU is called as the file is, as far as C allows it.
    let text = embedded::find("suspended_wheelset").unwrap().text;
    let unnamed: String = text.lines().filter(|line| !line.starts_with("name")).map(|line| format!("{line}\n")).collect();
    let file = folder.path().join("\u{dc}bung 1.toml");
    std::fs::write(&file, unnamed).unwrap();
    assert_eq!(load::open(file.to_str().unwrap(), &[]).unwrap().name, "Uebung_1");
}
