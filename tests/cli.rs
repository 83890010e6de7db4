//! The program as a user meets it: output, messages, exit codes.

use std::process::{Command, Output};

fn wheelrail(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).current_dir(env!("CARGO_TARGET_TMPDIR")).output().unwrap()
}

fn text(output: &Output) -> (String, String, i32) {
    let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (read(&output.stdout), read(&output.stderr), output.status.code().unwrap())
}

#[test]
fn prop_run_prints_a_summary_and_writes_csv_and_svg() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, plots) = (folder.path().join("r.csv"), folder.path().join("plots"));
    let output = wheelrail(&["run", "suspended_wheelset", "--stop", "1", "-o", csv.to_str().unwrap(), "--plot", plots.to_str().unwrap()]);
    let (stdout, stderr, code) = text(&output);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("lateral displacement [mm]") && stdout.contains("1 s simulated"), "{stdout}");
    let written = std::fs::read_to_string(&csv).unwrap();
    let mut lines = written.lines();
    let header = lines.next().unwrap();
    assert!(header.starts_with("time [s],wheelset.distance [m],wheelset.y [m]"), "{header}");
    assert_eq!(lines.count(), 401);
    let svg = std::fs::read_to_string(plots.join("suspended_wheelset.svg")).unwrap();
    for word in ["Lateral displacement", "Yaw", "Wheel loads", "distance [m]", "<polyline"] {
        assert!(svg.contains(word), "{word}");
    }
}

#[test]
fn prop_zero_length_run_gives_the_initial_state() {
    let (stdout, _, code) = text(&wheelrail(&["run", "suspended_wheelset", "--stop", "0", "-o", "-"]));
    assert_eq!(code, 0);
    assert_eq!(stdout.lines().count(), 2, "header and one row");
}

#[test]
fn prop_json_is_json() {
    for arguments in
        [&["run", "suspended_wheelset", "--stop", "0.1", "--json"][..], &["plan", "suspended_wheelset", "--json"], &["list", "--json"]]
    {
        let (stdout, stderr, code) = text(&wheelrail(arguments));
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<serde_json::Value>(&stdout).unwrap_or_else(|error| panic!("{arguments:?}: {error}\n{stdout}"));
    }
}

#[test]
fn prop_bad_input_is_exit_code_2_with_a_sentence_that_helps() {
    let cases: &[(&[&str], &str)] = &[
        (&["run", "suspended_wheelsets"], "did you mean \"suspended_wheelset\"?"),
        (&["run", "suspended_wheelset", "--set", "vehicle.sped=30"], "suspended_wheelset.toml:"),
        (&["run", "suspended_wheelset", "--set", "vehicle.sped=30"], "did you mean \"speed\"?"),
        (&["run", "suspended_wheelset", "--set", "vehicle.speed=3 deg"], "expected a number in m/s; a string may carry"),
        (&["run", "suspended_wheelset", "--set", "vehicle.speed=0"], "creepages are relative"),
        (&["run", "suspended_wheelset", "--set", "vehicle.speed"], "expected key=value"),
        (&["run", "suspended_wheelset", "--set", "contact.creep.law=fastsimm"], "expected \"shen_hedrick_elkins\""),
        (&["run", "suspended_wheelset", "--set", "track.deviation[2].rail=left"], "1 entries"),
        (&["run", "suspended_wheelset", "--set", "vehicle.wheelset.inertia_zz=1"], "body of revolution"),
        (&["run", "suspended_wheelset", "--step", "0"], "--step 0"),
        (&["run", "suspended_wheelset", "--stop", "-1"], "--stop"),
        (&["list", "creep-law"], "did you mean \"creep-laws\"?"),
        (&["export", "suspended_wheelset", "-o", "/no/such/folder/x.fmu"], "can't be written"),
        (&["export", "suspended_wheelset", "--library", env!("CARGO_MANIFEST_PATH")], "not an FMU library of wheelrail"),
    ];
    for (arguments, sentence) in cases {
        let (stdout, stderr, code) = text(&wheelrail(arguments));
        assert_eq!(code, 2, "{arguments:?}: {stdout}{stderr}");
        assert!(stderr.contains(sentence), "{arguments:?} said: {stderr}");
        assert!(stdout.is_empty(), "messages belong to stderr");
    }
}

#[test]
fn prop_a_library_of_another_build_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("other.so");
    std::fs::write(&file, b"...wheelrail-build-id:000000000000000000000000:...").unwrap();
    let (_, stderr, code) = text(&wheelrail(&["export", "suspended_wheelset", "--library", file.to_str().unwrap()]));
    assert_eq!(code, 2);
    assert!(stderr.contains("other sources") && stderr.contains("CONTRIBUTING.md"), "{stderr}");
}

#[test]
fn hard_a_failing_run_is_exit_code_1_and_keeps_its_rows() {
    // Thrown sideways on a slippery rail, a cone without flange leaves its profile.
    let (stdout, stderr, code) = text(&wheelrail(&[
        "run",
        "suspended_wheelset",
        "-o",
        "-",
        "--stop",
        "2",
        "--set",
        "vehicle.initial.vy=2.5",
        "--set",
        "contact.friction=0.01",
    ]));
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("wheelset") && stderr.contains("t = "), "{stderr}");
    assert!(stdout.lines().count() > 2, "what was computed is written: {}", stdout.lines().count());
}

#[test]
fn regress_plan_of_the_embedded_scene() {
    let (stdout, _, code) = text(&wheelrail(&["plan", "suspended_wheelset"]));
    assert_eq!(code, 0);
    let effects: Vec<&str> = stdout.lines().filter(|line| line.starts_with("  in ") || line.starts_with("  out ")).collect();
    insta::assert_snapshot!(effects.join("\n"));
    assert!(stdout.contains("%  contact search"));
}

/// docs/names.md is the list of everything a scene can name; `WHEELRAIL_BLESS=1 cargo test` writes it anew.
#[test]
fn regress_docs_list_every_name() {
    let (stdout, _, _) = text(&wheelrail(&["list"]));
    let page = format!(
        "# What a scene can name\n\nThe output of `wheelrail list`, made from the program's registries.\n\n```text\n{}```\n",
        stdout
    );
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/names.md");
    if std::env::var_os("WHEELRAIL_BLESS").is_some() {
        std::fs::write(&file, &page).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap_or_default(), page, "run WHEELRAIL_BLESS=1 cargo test docs_list");
}
