//! `wheelrail creep` as a user meets it.

use std::process::Command;

fn wheelrail(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).output().unwrap();
    let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (read(&output.stdout), read(&output.stderr), output.status.code().unwrap())
}

const CASES: &str = "a,b,nu,G [Pa],N,mu,xi,eta,phi,V\n\
                     0.0065883,0.0065883,0.28,8.2e10,1e5,0.3,0.0011966,0,0,1\n\
                     0.006,0.004,0.28,8.2e10,8e4,0.3,0.2,-0.1,1,20\n";

#[test]
fn prop_forces_of_a_table_go_to_stdout_or_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let cases = folder.path().join("cases.csv");
    std::fs::write(&cases, CASES).unwrap();
    let cases = cases.to_str().unwrap();
    let laws = "fastsim{strips=10,cells=10},fastrip,polach{surface=\"dry\"}";
    let (stdout, stderr, code) = wheelrail(&["creep", cases, "--law", laws]);
    assert_eq!(code, 0, "{stderr}");
    let mut lines = stdout.lines();
    let head = lines.next().unwrap();
    assert!(head.starts_with("a [m],b [m],nu [-],") && head.ends_with(",law,Fx [N],Fy [N],Mz [N m],time [s]"), "{head}");
    let rows: Vec<csv::StringRecord> = csv::Reader::from_reader(stdout.as_bytes()).records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 6);
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    assert_eq!(&rows[1][10], "fastrip");
    // CONTACT's FaStrip, tests/data/creep_forces_exact.csv, case 18: -0.503254 mu N.
    assert!((number(1, 11) / 3e4 + 0.503254).abs() < 2e-3, "{}", number(1, 11));
    assert!(number(0, 14) > 1e-9 && number(0, 14) < 1e-2, "time per call {}", number(0, 14));
    // Falling friction: 0.22 mu N at 0.22 x 20 m/s would be the end; A = 0.4 of it plus what the exponential leaves.
    let dry = number(5, 11).hypot(number(5, 12)) / 2.4e4;
    assert!(dry > 0.4 && dry < 0.55, "{dry}");

    let out = folder.path().join("out.csv");
    let (stdout, stderr, code) = wheelrail(&["creep", cases, "--law", "fastrip", "-o", out.to_str().unwrap()]);
    assert!(code == 0 && stdout.is_empty() && stderr.contains("wrote"), "{stdout} {stderr}");
    assert_eq!(std::fs::read_to_string(&out).unwrap().lines().count(), 3);
    let (stdout, _, code) = wheelrail(&["creep", cases, "--law", "fastrip", "--json"]);
    assert_eq!(code, 0);
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(json[1]["law"], "fastrip");
}

#[test]
fn prop_bad_input_is_named_and_gives_2() {
    let folder = tempfile::tempdir().unwrap();
    let cases = folder.path().join("cases.csv");
    std::fs::write(&cases, CASES.replace(",1e5,", ",-1e5,")).unwrap();
    let cases = cases.to_str().unwrap();
    let (_, stderr, code) = wheelrail(&["creep", cases, "--law", "fastsim"]);
    assert!(code == 2 && stderr.contains("cases.csv:2: column \"N\": found \"-1e5\""), "{code} {stderr}");
    let (_, stderr, code) = wheelrail(&["creep", cases, "--law", "fastsmi"]);
    assert!(code == 2 && stderr.contains("did you mean \"fastsim\""), "{code} {stderr}");
    let (_, stderr, code) = wheelrail(&["creep", cases, "--law", "fastsim{strips=10"]);
    assert!(code == 2 && stderr.contains("the brace is not closed"), "{code} {stderr}");
    let (_, stderr, code) = wheelrail(&["creep", cases, "--law", ","]);
    assert!(code == 2 && stderr.contains("names no law"), "{code} {stderr}");
    let (_, stderr, code) = wheelrail(&["creep", "nowhere.csv", "--law", "fastsim"]);
    assert!(code == 2 && stderr.contains("nowhere.csv"), "{code} {stderr}");
    assert_eq!(wheelrail(&["creep", "--law", "fastsim"]).2, 2);
}

#[test]
fn prop_a_study_writes_table_and_picture() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("study");
    let place = folder.to_str().unwrap();
    let arguments =
        ["creep", "--study", "100", "--seed", "3", "--reference", "fastsim{strips=60,cells=60}", "--law", "fastsim,polach", "-o", place];
    let (stdout, stderr, code) = wheelrail(&arguments);
    assert!(code == 0 && stdout.contains("| `polach` |"), "{stdout} {stderr}");
    let svg = std::fs::read_to_string(folder.join("creep_laws.svg")).unwrap();
    assert!(svg.contains("polach") && svg.contains("time per call"), "{svg}");
    assert_eq!(std::fs::read_to_string(folder.join("creep_laws.csv")).unwrap().lines().count(), 3);
}
