//! `wheelrail assess` as a program.

use std::path::Path;
use std::process::Command;

fn wheelrail(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

/// The curve of the paper's vehicle, long enough for sections of 100 m.
const CURVE: [&str; 3] = ["vehicle_curve", "--set", "track.node[4].distance=1500 ft"];

fn assess(extra: &[&str]) -> (serde_json::Value, i32) {
    let (json, said, code) = wheelrail(&[&["assess"], extra, &["--json"]].concat());
    (serde_json::from_str(&json).unwrap_or_else(|error| panic!("{error}: {json}{said}")), code)
}

fn rows<'a>(found: &'a serde_json::Value, key: &str) -> Vec<&'a serde_json::Value> {
    found["assessment"]["rows"].as_array().unwrap().iter().filter(|row| row["key"] == key).collect()
}

fn value(found: &serde_json::Value, key: &str) -> f64 {
    rows(found, key)[0]["value"].as_f64().unwrap_or_else(|| panic!("{key}"))
}

#[test]
fn equiv_a_scene_and_its_results_are_assessed_alike() {
    let folder = tempfile::tempdir().unwrap();
    let (file, page) = (folder.path().join("run.csv"), folder.path().join("page.html"));
    let (file, page) = (file.to_str().unwrap(), page.to_str().unwrap());
    let (of_run, code) = assess(&[&CURVE[..], &["--stop", "14", "-o", file, "--html", page]].concat());
    assert_eq!(code, 0);
    let (of_file, code) = assess(&[file, "--scene", CURVE[0], CURVE[1], CURVE[2]]);
    assert_eq!((code, &of_run["assessment"]["rows"]), (0, &of_file["assessment"]["rows"]));
    let said = |arguments: &[&str]| wheelrail(&[&["assess", file, "--scene"], arguments].concat()).1;
    assert_eq!(said(&CURVE), "");
    assert!(
        said(&["bogie"]).contains("may come from another scene: the scene has no wheelset \"truck[1].wheelset[1]\""),
        "{}",
        said(&["bogie"])
    );
    // Without the scene: no limits by loads, no curves, no Nadal.
    let (alone, code) = assess(&[file]);
    assert_eq!((code, rows(&alone, "nadal")[0]["verdict"].as_str()), (0, Some("not_assessable")));
    assert!(rows(&alone, "sum_y")[0]["limit"].is_null() && value(&alone, "y_over_q") > 0.1);
    // Physics of the curve: a static wheel load of 54.55 kN (P0 = 109.1 kN), v^2/R/g = 0.07 less 0.051 of cant are 0.02 g of lateral acceleration.
    let limit = rows(&of_run, "sum_y")[0]["limit"].as_f64().unwrap();
    assert!((limit - (10e3 + 109.1e3 / 3.0)).abs() < 50.0, "{limit}");
    assert!((value(&of_run, "acc_y_qst") - (20.0_f64.powi(2) / 582.2 - 9.81 * 0.0508)).abs() < 0.05, "{}", value(&of_run, "acc_y_qst"));
    assert!(value(&of_run, "q_qst") > 54.55e3 && value(&of_run, "unloading") > 0.1);
    let page = std::fs::read_to_string(page).unwrap();
    for part in ["<!DOCTYPE html>", "Nadal", "<svg", "zone 3, R 400-600 m", "EN 12299"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.matches("<svg").count() == 5 && !page.contains("<script") && !page.contains("src="));
}

#[test]
fn prop_exit_codes_say_whether_limits_hold() {
    let stop = ["--stop", "8"];
    let (words, _, code) = wheelrail(&[&["assess"], &CURVE[..], &stop, &["--limit", "y_qst=1 kN"]].concat());
    assert!(code == 3 && words.contains("FAIL") && words.contains("1 exceeded: quasi-static guiding force Y"), "{code} {words}");
    let (words, _, code) = wheelrail(&[&["assess"], &CURVE[..], &stop, &["--vehicle", "freight"]].concat());
    assert!(code == 0 && words.contains("limits of a freight wagon") && words.contains("none exceeded"), "{words}");
    assert!(words.contains("in 5 s windows") || words.contains("8.0 s are too short"), "{words}");
}

/// A flange that climbs: the run ends, and that is the first line of the table.
#[test]
fn hard_a_derailment_is_a_limit_exceeded() {
    let folder = tempfile::tempdir().unwrap();
    let flanged = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenes/apta_flange.toml");
    // The right rail goes away from under its wheel.
    let gap = "[[track.deviation]]\nrail = \"right\"\ndirection = \"lateral\"\nshape = \"cosine\"\namplitude = \"-150 mm\"\nfrom = 110.0\nto = 130.0\n";
    let text = std::fs::read_to_string(flanged).unwrap().replace("[contact]\n", &format!("{gap}\n[contact]\n"));
    let scene = folder.path().join("gap.toml");
    std::fs::write(&scene, text).unwrap();
    let (found, code) = assess(&[scene.to_str().unwrap()]);
    let first = &found["assessment"]["rows"][0];
    assert!(code == 3 && first["key"] == "completed" && first["verdict"] == "fail", "{code} {first}");
    assert!(first["note"].as_str().unwrap().contains("derailed") && first["value"].as_f64() < first["limit"].as_f64(), "{first}");
}

#[test]
fn hard_what_can_not_be_assessed_is_said_with_the_scenes_lines() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        file.to_str().unwrap().to_string()
    };
    let coarse: String = (0..600).map(|k| format!("{},{},-5,50,4,50\n", 0.02 * f64::from(k), f64::from(k))).collect();
    let head =
        "time [s],w.distance [m],w.left.lateralForce [kN],w.left.verticalForce [kN],w.right.lateralForce [kN],w.right.verticalForce [kN]\n";
    let (words, said, code) = wheelrail(&["assess", &write("coarse.csv", &format!("{head}{coarse}"))]);
    assert!(
        code == 2 && words.contains("rows every 20 ms are too coarse for the low pass of 20 Hz: run.step = \"5 ms\" or less"),
        "{words}{said}"
    );
    let fine = coarse.replace(",-5,", ",-5.5,");
    let fine: String = fine.lines().map(|line| format!("{}\n", line)).collect();
    let half = write("back.csv", &format!("{head}{}", fine.replacen("0.2,10,", "0.2,7,", 1)));
    let (_, said, code) = wheelrail(&["assess", &half]);
    assert!(code == 2 && said.contains("w.distance falls from 9 m to 7 m at 0.2 s"), "{said}");
    let cases: &[(&[&str], &str)] = &[
        (&["no.csv"], "no.csv"),
        (&[&write("a.csv", "time [s],x [m]\n0,1\n1,2\n2,3\n3,4\n")], "no column NAME.distance"),
        (&["suspended_wheelset", "--scene", "bogie"], "--scene belongs to a RESULT.csv"),
        (&[&half, "--stop", "3"], "that is for a SCENE"),
        (&[&half, "--set", "vehicle.speed=3"], "name it with --scene"),
        (&["bogie", "--limit", "qmax=3"], "expected one of"),
        (&["bogie", "--limit", "q_max=3 m"], "expected a number in N"),
        (&["bogie", "--html", "/no/such/folder/x.html"], "can't be written"),
        (&["bogie", "--admissible-speed", "0"], "greater than 0"),
    ];
    for (arguments, expected) in cases {
        let (_, said, code) = wheelrail(&[&["assess"], *arguments].concat());
        assert!(code == 2 && said.contains(expected), "{arguments:?}: {code} {said}");
    }
    let (words, _, _) = wheelrail(&["assess", "bogie", "--stop", "0.5"]);
    for part in ["too short for one section (zone 1, straight:", "[[vehicle.sensor]] name = \"floor\", body = \""] {
        assert!(words.contains(part), "{words}");
    }
}

/// Wheels that strike from flange to flange: peaks of 2 ms between rows every 5 ms had the unloading 94 % too large.
#[test]
fn hard_impacts_between_rows_are_not_assessed_by_chance() {
    let found = |extra: &[&str]| {
        let arguments = [&["assess", "wheelset_s1002", "--set", "vehicle.speed=60", "--stop", "4", "--json"], extra].concat();
        let (json, words, _) = wheelrail(&arguments);
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let rows = json["assessment"]["rows"].as_array().unwrap();
        let of = |key: &str| rows.iter().find(|row| row["key"] == key).and_then(|row| row["value"].as_f64()).unwrap();
        (["y_over_q", "unloading", "q_max", "sum_y"].map(of), words)
    };
    let (own, words) = found(&[]);
    assert!(words.contains("run again with rows every 0.4 ms") && words.contains("strikes it"), "{words}");
    let (dense, _) = found(&["--step", "0.1ms"]);
    let (sparse, words) = found(&["--step", "5ms"]);
    println!("{own:?}, every 0.1 ms {dense:?}, every 5 ms {sparse:?}");
    assert!(own.iter().zip(dense).all(|(own, dense)| (own / dense - 1.0).abs() < 0.03));
    assert!(words.contains("too far apart") && (sparse[3] / dense[3] - 1.0).abs() > 0.1, "{words}");
}

/// Accelerations are judged by what an accelerometer shows alone: under cant the kinematic acceleration has passed a limit that is not held, and failed one that is.
#[test]
fn hard_sensors_that_are_not_measured_are_not_judged() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    assess(&[&CURVE[..], &["--stop", "14", "-o", &path("all.csv")]].concat());
    let text = std::fs::read_to_string(path("all.csv")).unwrap();
    let without = |name: &str, gone: &dyn Fn(&str) -> bool| {
        let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let kept =
            |line: &str| line.split(',').zip(&names).filter(|(_, name)| !gone(name)).map(|(cell, _)| cell).collect::<Vec<_>>().join(",");
        std::fs::write(path(name), text.lines().map(|line| kept(line) + "\n").collect::<String>()).unwrap();
        assess(&[&[path(name).as_str(), "--scene"], &CURVE[..]].concat()).0
    };
    let none = without("none.csv", &|name| name.contains(".measured"));
    for key in ["acc_y_safety", "acc_y_ride", "rms_y_ride", "acc_y_qst", "acc_z_ride", "iso_y", "wz_z"] {
        let row = rows(&none, key)[0];
        assert!(row["verdict"] == "not_assessable" && row["note"].as_str().unwrap().contains("measured = true"), "{row}");
    }
    let one = without("one.csv", &|name| name.starts_with("floor[2].measured"));
    let safety = rows(&one, "acc_y_safety");
    let told = |row: &&serde_json::Value| row["note"].as_str().is_some_and(|note| note.contains("floor[2] is left out"));
    assert!(safety.iter().any(told) && safety[0]["place"] == "floor[1]" && rows(&one, "acc_y_qst")[0]["place"] == "floor[1]", "{safety:?}");
}
