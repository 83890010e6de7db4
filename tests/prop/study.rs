//! `wheelrail study` as a user meets it: files, words, refusals, exit codes.

use std::process::{Command, Output};

fn wheelrail(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).current_dir(env!("CARGO_TARGET_TMPDIR")).output().unwrap()
}

fn text(output: &Output) -> (String, String, i32) {
    let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (read(&output.stdout), read(&output.stderr), output.status.code().unwrap())
}

/// A study that takes a second or so.
const SMALL: [&str; 14] = [
    "study",
    "suspended_wheelset",
    "--formulations",
    "ECCF,ECF-A",
    "--integrators",
    "rk43,rk4",
    "--tolerances",
    "3e-5,1e-5",
    "--steps",
    "5 ms,2 ms",
    "--stop",
    "800 ms",
    "--repeats",
    "2",
];

#[test]
fn prop_study_writes_csv_pictures_and_words() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, pictures) = (folder.path().join("s.csv"), folder.path().join("new/pictures"));
    let arguments =
        [&SMALL[..], &["--communication-steps", "20 ms,50 ms", "-o", csv.to_str().unwrap(), "--plot", pictures.to_str().unwrap()]];
    let (stdout, stderr, code) = text(&wheelrail(&arguments.concat()));
    assert_eq!(code, 0, "{stderr}");
    for words in [
        "rigid contact (ECCF)",
        "elastic contact (ECF-A)",
        "1 mm, 0.1 mm",
        "s per simulated second",
        "times real time",
        "Differences of models",
        "hunting wavelength",
        "input held",
        "ECF-A, rk4, step 5 ms: failed: t = ",
        "note: rk43: tolerance 3e-5 left out, it takes ",
    ] {
        assert!(stdout.contains(words), "{words}:\n{stdout}");
    }
    let written = std::fs::read_to_string(&csv).unwrap();
    for words in
        ["# machine: ", "# program: wheelrail ", "# scene: suspended_wheelset", "# reference: rigid: ECCF with dormand_prince and rk43"]
    {
        assert!(written.contains(words), "{words}:\n{written}");
    }
    let rows: Vec<Vec<&str>> = written.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect()).collect();
    let columns =
        "formulation,integrator,tolerance,step,error_y [m],error_N [N],cpu_per_simulated_second,realtime_factor,rhs,newton,rejected";
    assert_eq!(rows[0][..11].join(","), columns);
    for column in ["error_YQ", "error_wavelength [m]", "y_told", "N_told", "YQ_told", "wavelength_told"] {
        assert!(rows[0].contains(&column), "{column}");
    }
    assert_eq!(rows.len(), 1 + 6 + 6, "a row for each point and each coupled run");
    let done: Vec<&Vec<&str>> = rows[1..7].iter().filter(|row| row[11] == "ok").collect();
    // Steps of 5 ms are too long for both models: their errors are judged, and these runs end.
    assert!(done.len() == 4 && done.iter().all(|row| row.len() == rows[0].len()));
    for row in &done {
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        assert!(
            number(4) > 0.0 && number(4) < 1e-2 && number(6) > 0.0 && (number(6) * number(7) - 1.0).abs() < 1e-9 && number(8) > 100.0,
            "{row:?}"
        );
        assert!(row[2].is_empty() != row[3].is_empty(), "a tolerance or a step: {row:?}");
    }
    for (name, words) in [
        ("time_y", "CPU time per simulated second"),
        ("work_y", "evaluations of the right-hand side"),
        ("time_N", "Normal force"),
        ("communication", "communication step"),
        ("best", "What to choose"),
    ] {
        let svg = std::fs::read_to_string(pictures.join(format!("suspended_wheelset_{name}.svg"))).unwrap();
        assert!(svg.contains(words) && (svg.contains("<poly") || svg.contains("<circle")), "{name}");
        assert_eq!(svg.contains("bars: spread of up to 2 runs"), name.starts_with("time"), "{name}");
    }
    assert_eq!(stderr.lines().count(), std::fs::read_dir(&pictures).unwrap().count(), "one message per picture: {stderr}");
}

#[test]
fn hard_a_reference_that_is_no_better_than_the_points_is_refused() {
    let arguments = ["study", "suspended_wheelset", "--formulations", "ECF-A", "--integrators", "dormand_prince", "--tolerances", "1e-9"];
    let loose = ["--reference", "1e-5", "--stop", "0.6", "--communication-steps", "none"];
    let (stdout, stderr, code) = text(&wheelrail(&[&arguments[..], &loose].concat()));
    assert_eq!((code, stdout.as_str()), (1, ""), "{stderr}");
    assert!(stderr.starts_with("error: refused") && stderr.contains("100 times") && stderr.contains("--tolerances"), "{stderr}");
}

#[test]
fn prop_bad_arguments_are_named() {
    for (arguments, words) in [
        (&["--integrators", "rk44"][..], "--integrators rk44 (did you mean \"rk4\"?): expected some of "),
        (&["--steps", "5 kg"], "--steps 5 kg: expected a number in s"),
        (&["--step", "5 kg"], "expected a number in s; a string may carry ms"),
        (&["--integrators", "dormand_prince", "--tolerances", "1e-4"], "dormand_prince: tolerance 1e-4 left out, it takes 1e-15 to 1e-5"),
        (&["-o", "no/such/folder/x.csv"], "there is no folder no/such/folder; make the folder first"),
        (&["--tolerances=-1"], "--tolerances -1: expected a number in m"),
        (&["--budget", "0"], "--budget 0: expected a number greater than 0"),
        (&["--stop", "0"], "--stop 0: expected a time of at least one output step"),
        (&["--wheelset", "truck"], "--wheelset truck: expected one of wheelset"),
        (&["--smoothing", "1 um", "--formulations", "ECF-A"], "smoothing"),
    ] {
        let (_, stderr, code) = text(&wheelrail(&[&["study", "suspended_wheelset"], arguments].concat()));
        assert!(code == 2 && stderr.contains(words), "{arguments:?}: {code} {stderr}");
    }
}

#[test]
fn prop_json_holds_points_references_and_choices() {
    let (stdout, stderr, code) = text(&wheelrail(&[&SMALL[..], &["--communication-steps", "none", "--json"]].concat()));
    assert_eq!(code, 0, "{stderr}");
    let found: serde_json::Value = serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{error}\n{stdout}"));
    assert_eq!(found["study"]["points"].as_array().unwrap().len(), 6);
    assert!(found["study"]["models"][0]["reference"]["Ok"]["uncertainty"]["y"]["largest"].as_f64().unwrap() < 1e-9, "{stdout}");
    assert!(found["best"].as_array().unwrap().iter().any(|best| best["quantity"] == "displacement"));
}

#[path = "../../benches/common/aims.rs"]
mod aims;

/// What `cargo bench` says of its aims: the fastest setting that is exact enough, and straight lines between settings.
#[test]
fn analytic_aims_are_judged_at_their_accuracy() {
    use aims::{Aim, Measured};
    let point = |integrator: &str, error: f64, factor: f64| Measured {
        integrator: integrator.into(),
        setting: "1e-5".into(),
        error,
        factor,
        spread: 1.25,
    };
    let points = [point("a", 1e-4, 80.0), point("a", 1e-6, 20.0), point("b", 1e-5, 30.0), point("b", 1e-7, 3.0)];
    let aim = |factor: f64, error: f64| Aim { what: "scene", factor, error };
    assert_eq!(aim(50.0, 1e-5).nearest(&points).unwrap().factor, 30.0);
    let (factor, name) = aim(50.0, 1e-5).between(&points).unwrap();
    assert!((factor - 40.0).abs() < 1e-9 && name == "a", "halfway between 20 and 80 over logarithmic axes: {factor}");
    assert!(
        aim(50.0, 1e-5)
            .words(&points)
            .contains("at 1e-5 m: missed; measured 30.0 times at 1.0e-5 m (b 1e-5; the slowest run took 25 % longer)")
    );
    assert!(
        aim(35.0, 1e-5).words(&points).contains("reached between two settings") && aim(30.0, 1e-5).words(&points).contains("m: reached; ")
    );
    let far = aim(1.0, 1e-8).words(&points);
    assert!(far.ends_with("missed; no setting is that exact"), "{far}");
}

/// `--where`: shares of a whole run, in words and as JSON, and no mixing with what belongs to a study.
#[test]
fn prop_where_the_time_goes() {
    let run = [
        "study",
        "suspended_wheelset",
        "--where",
        "--stop",
        "0.3",
        "--set",
        "solver.integrator=rosenbrock",
        "--set",
        "solver.tolerance=1e-11",
    ];
    // So many steps that no clock tells nothing.
    let (stdout, stderr, code) = text(&wheelrail(&run));
    assert_eq!(code, 0, "{stderr}");
    for words in ["contact search", "creep law", "multibody", "integrator", "Jacobians", "factorisations", "solving with them", "outputs"] {
        assert!(stdout.contains(words), "{words}:\n{stdout}");
    }
    let (stdout, _, _) = text(&wheelrail(&[&run[..], &["--json"]].concat()));
    let found: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let shares: Vec<f64> = found["shares"].as_array().unwrap().iter().map(|share| share["share"].as_f64().unwrap()).collect();
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9 && shares.len() == 15, "{stdout}");
    let (_, stderr, code) = text(&wheelrail(&[&run[..], &["--integrators", "rk4"]].concat()));
    assert!(code == 2 && stderr.contains("--where"), "{code} {stderr}");
    let (_, stderr, code) = text(&wheelrail(&["study", "suspended_wheelset", "--where", "--stop", "0"]));
    assert!(code == 2 && stderr.contains("--stop 0"), "{code} {stderr}");
}
