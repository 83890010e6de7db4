//! `wheelrail run --checkpoint` and `--resume`: a run that was ended goes on with the same bits.
#![cfg(unix)]

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    command.arg("run").args(arguments);
    command
}

fn run(arguments: &[&str]) -> (String, String, i32) {
    let Output { stdout, stderr, status } = command(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(stdout), text(stderr), status.code().unwrap_or(-1))
}

/// Runs and returns the rows and the summary without the wall time.
fn results(file: &Path, arguments: &[&str]) -> (Vec<u8>, serde_json::Value) {
    let (stdout, stderr, code) = run(&[arguments, &["-o", file.to_str().unwrap(), "--json"]].concat());
    assert_eq!(code, 0, "{arguments:?}: {stderr}");
    let mut summary: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert!(summary["seconds"].take().is_number());
    (std::fs::read(file).unwrap(), summary)
}

/// Every formulation with an implicit and an explicit integrator, and a vehicle with wheels that lift: rows, events, notes and all counts of work are those of the run
/// that nobody ended.
#[test]
fn equiv_a_run_that_goes_on_is_the_one_that_was_not_ended() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let mut cases: Vec<Vec<String>> = Vec::new();
    for formulation in ["ECF-A", "ECF-N", "ECCF", "ACCF"] {
        for integrator in ["rosenbrock", "dormand_prince"] {
            let sets = [format!("contact.formulation={formulation}"), format!("solver.integrator={integrator}")];
            cases.push(
                ["suspended_wheelset".to_string()].into_iter().chain(sets.into_iter().flat_map(|set| ["--set".into(), set])).collect(),
            );
        }
    }
    cases.push(vec!["vehicle_bumps".into(), "--set".into(), "interface.outputs=[\"motion\", \"wheels\", \"sliding_means\"]".into()]);
    // Bends between rows and checkpoints, a jump at one.
    let table = file("inputs.csv");
    std::fs::write(&table, "time,wheelset.driveTorque [kN m],wheelset.left.frictionFactor\n0.05,0,1\n0.6,2,0.7\n0.6,-1,0.7\n0.9713,0,1\n")
        .unwrap();
    cases.push(vec!["suspended_wheelset".into(), "--inputs".into(), table.to_str().unwrap().into()]);
    for case in &cases {
        let scene: Vec<&str> = case.iter().map(String::as_str).collect();
        let kept = file("kept.checkpoints");
        let _ = std::fs::remove_file(&kept);
        let whole = results(&file("whole.csv"), &[&scene[..], &["--stop", "1.5"]].concat());
        let path = kept.to_str().unwrap();
        let first =
            results(&file("first.csv"), &[&scene[..], &["--stop", "0.9", "--checkpoint", "0.3 s", "--checkpoint-file", path]].concat());
        assert!(whole.0.starts_with(&first.0) && whole.0.len() > first.0.len(), "checkpoints change nothing: {case:?}");
        let on = results(&file("on.csv"), &[&scene[..], &["--stop", "1.5", "--resume", path, "--checkpoint", "0.2 s"]].concat());
        assert!(on.0 == whole.0, "{case:?}: other rows");
        assert_eq!(on.1, whole.1, "{case:?}");
        // From the checkpoints that the second part made.
        let again = results(&file("again.csv"), &[&scene[..], &["--stop", "1.5", "--resume", path]].concat());
        assert!(again == whole, "{case:?}");
    }
}

/// Starts a long run with checkpoints, waits until some are there, and kills it.
fn killed(folder: &Path, stop: &str) -> PathBuf {
    let (csv, file) = (folder.join("killed.csv"), folder.join("killed.checkpoints"));
    let mut child =
        command(&["suspended_wheelset", "--stop", stop, "--step", "10 ms", "--checkpoint", "0.5 s", "-o", csv.to_str().unwrap()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
    let begin = Instant::now();
    while !std::fs::metadata(&file).is_ok_and(|there| there.len() > 60_000) {
        assert!(begin.elapsed() < Duration::from_secs(60), "no checkpoints");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    assert_eq!(child.wait().unwrap().signal(), Some(9), "the run ended before it was killed");
    file
}

#[test]
fn hard_a_killed_run_goes_on_with_the_same_bits() {
    const STOP: &str = "400";
    let folder = tempfile::tempdir().unwrap();
    let file = killed(folder.path(), STOP);
    let whole = results(&folder.path().join("whole.csv"), &["suspended_wheelset", "--stop", STOP, "--step", "10 ms"]);
    let resumed = |file: &Path| {
        results(
            &folder.path().join("on.csv"),
            &["suspended_wheelset", "--stop", STOP, "--step", "10 ms", "--resume", file.to_str().unwrap()],
        )
    };
    assert!(resumed(&file) == whole);
    // A block that was being written when the run was killed.
    let bytes = std::fs::read(&file).unwrap();
    for cut in [1, 20, 3000] {
        let torn = folder.path().join("torn.checkpoints");
        std::fs::write(&torn, &bytes[..bytes.len() - cut]).unwrap();
        assert!(resumed(&torn) == whole, "{cut} bytes less");
        let (_, stderr, _) = run(&["suspended_wheelset", "--stop", STOP, "--step", "10 ms", "--resume", torn.to_str().unwrap()]);
        assert!(
            stderr.contains("goes on at t = ") && stderr.contains("bytes of a checkpoint that was not finished are left out"),
            "{stderr}"
        );
    }
}

#[test]
fn prop_a_run_goes_on_from_an_end_that_is_a_row_but_for_rounding() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let steps = ["suspended_wheelset", "--step", "0.0013"];
    let whole = results(Path::new(&path("whole.csv")), &[&steps[..], &["--stop", "1"]].concat());
    let kept = path("kept.checkpoints");
    results(
        Path::new(&path("first.csv")),
        &[&steps[..], &["--stop", "0.78", "--checkpoint", "0.3 s", "--checkpoint-file", &kept]].concat(),
    );
    // The same command as before, with --resume; another file is another place.
    let again = [&steps[..], &["--stop", "1", "--resume", &kept, "--checkpoint", "0.3 s", "--checkpoint-file"]].concat();
    let (_, stderr, code) = run(&[&again[..], &[&path("other.checkpoints")]].concat());
    assert!(code == 2 && stderr.contains("keeps its checkpoints in"), "{stderr}");
    let on = results(Path::new(&path("on.csv")), &[&again[..], &[&kept]].concat());
    let text = |rows: &[u8]| String::from_utf8(rows.to_vec()).unwrap();
    let [whole, on] = [text(&whole.0), text(&on.0)];
    let differ: Vec<usize> = whole.lines().zip(on.lines()).enumerate().filter(|(_, (a, b))| a != b).map(|(row, _)| row).collect();
    assert!(whole.lines().count() == on.lines().count() && differ == [601], "all rows but that end are the same bits: {differ:?}");
}

#[test]
fn prop_checkpoints_of_other_runs_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (csv, kept) = (path("a.csv"), path("a.checkpoints"));
    let begun = ["suspended_wheelset", "--stop", "1", "--checkpoint", "0.5 s", "--columns", "wheelset.y", "-o", &csv];
    assert_eq!(run(&begun).2, 0);
    let refused = |arguments: &[&str], words: &str| {
        let (_, stderr, code) = run(&[&["suspended_wheelset"], arguments].concat());
        assert!(code == 2 && stderr.contains(words), "{arguments:?}: {stderr}");
    };
    let on = ["--resume", &kept, "--stop", "2", "--columns", "wheelset.y"];
    let with = |more: &'static [&'static str]| [&on[..], more].concat();
    refused(&with(&["--set", "vehicle.speed=21"]), "another scene (\"suspended_wheelset\")");
    refused(&with(&["--step", "1 ms"]), "writes a row every 0.0025 s, not every 0.001 s");
    refused(&["--resume", &kept, "--stop", "0.5"], "is at t = 1 s already");
    refused(&["--resume", &kept, "--stop", "2", "-o", &csv], "does not record wheelset.");
    for (text, words) in [("0", "above 0 s"), ("-1 s", "above 0 s"), ("5 kg", "above 0 s"), ("wall", "above 0 s")] {
        refused(&[&format!("--checkpoint={text}")], words);
    }
    // What is no such file, one that was ended too early, one that is damaged.
    let other = path("other");
    for (bytes, words) in [(&b"time [s],y [m]\n"[..], "is no file of checkpoints"), (&[], "is no file of checkpoints")] {
        std::fs::write(&other, bytes).unwrap();
        refused(&["--resume", &other], words);
    }
    let whole = std::fs::read(&kept).unwrap();
    let length = |at: usize| 62 + u64::from_le_bytes(whole[at + 50..at + 58].try_into().unwrap()) as usize;
    let head = length(0);
    std::fs::write(&other, &whole[..head + 10]).unwrap();
    refused(&["--resume", &other], "ended before its first checkpoint");
    let mut damaged = whole.clone();
    damaged[head - 1] ^= 1;
    std::fs::write(&other, &damaged).unwrap();
    refused(&["--resume", &other], "is no file of checkpoints");
    refused(&["--resume", &path("nothing")], "can't be read");
    // A run that has not come to its end is not written over; one that has is.
    assert_eq!(run(&begun).2, 0);
    std::fs::write(&kept, &whole[..head + length(head)]).unwrap();
    refused(&begun[1..], "go on with --resume");
    let (_, stderr, code) = run(&[&["suspended_wheelset"], &on[..], &["-o", &csv]].concat());
    assert!(code == 0 && stderr.contains("goes on at t = 0.5 s"), "{stderr}");
    assert_eq!(std::fs::read_to_string(&csv).unwrap().lines().count(), 2 + 800);
}
