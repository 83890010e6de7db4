//! Files of every format, against the profiles that they were made from.

use super::*;
use crate::settings::Source;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// Calls `read` with the settings of `text`.
pub(super) fn with_section<T>(text: &str, read: impl FnOnce(&Section) -> T) -> T {
    in_folder(None, text, read)
}

/// Calls `read` with the settings of `text`, whose files are in `folder`.
pub(super) fn in_folder<T>(folder: Option<&Path>, text: &str, read: impl FnOnce(&Section) -> T) -> T {
    let source = Source { file: "t.toml".into(), text: text.into(), overridden: vec![], folder: folder.map(Path::to_path_buf) };
    let document = toml_edit::Document::parse(text.to_string()).unwrap();
    read(&Section::root(document.as_table(), &source))
}

/// Each derivative agrees with differences of the one before, away from the joints.
pub(super) fn check_derivatives(profile: &dyn Profile) {
    let (first, last) = profile.range();
    let joints = profile.joints();
    let h = 1e-8;
    for i in 0..1000 {
        let x = first + (last - first) * (f64::from(i) + 0.5) / 1000.0;
        if joints.iter().any(|joint| (joint - x).abs() < 2.0 * h) {
            continue;
        }
        let (p, ahead, behind) = (profile.at(x), profile.at(x + h), profile.at(x - h));
        // Rounding of the difference, and the term that the central difference leaves out, from the curvature's scale.
        let scale = 1.0 + p.d1 * p.d1;
        let near = |name: &str, found: f64, wanted: f64, tolerance: f64| {
            assert!((found - wanted).abs() < tolerance, "{name} at {x}: {found}, difference {wanted}");
        };
        near("d1", p.d1, (ahead.value - behind.value) / (2.0 * h), 3e-8 * scale);
        near("d2", p.d2, (ahead.d1 - behind.d1) / (2.0 * h), 1e-6 * scale * (1.0 + p.d2.abs()));
        near("d3", p.d3, (ahead.d2 - behind.d2) / (2.0 * h), 1e-5 * scale * (1.0 + p.d2.abs() + p.d3.abs()));
    }
    for (x, end) in [(first - 1e-3, first), (last + 1e-3, last)] {
        let (p, edge) = (profile.at(x), profile.at(end));
        assert!((p.value - edge.value - edge.d1 * (x - end)).abs() < 1e-12 && (p.d1 - edge.d1).abs() < 1e-9);
        assert!(profile.at(1e3 * x).value.is_finite());
    }
}

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/profiles")
}

/// Reads `{ text }`, files being in `folder`.
fn read_in(folder: &Path, text: &str, part: Part) -> Result<ProfileChoice, SettingsError> {
    in_folder(Some(folder), text, |section| (choose(REGISTRY, section, "kind")?.parse)(section, part))
}

fn read(text: &str, part: Part) -> ProfileChoice {
    read_in(&samples(), text, part).unwrap()
}

/// Largest and root-mean-square distance across the surface between two profiles, m; and of their curvatures, 1/m.
fn distances(found: &ProfileChoice, wanted: &ProfileChoice, from: f64, to: f64) -> (f64, f64, f64) {
    let (mut largest, mut squares, mut curvature) = (0.0f64, 0.0, 0.0);
    let n = 4000;
    for i in 0..n {
        let x = from + (to - from) * (f64::from(i) + 0.5) / f64::from(n);
        let (a, b) = (found.profile.at(x), wanted.profile.at(x));
        let steep = 1.0 + b.d1 * b.d1;
        let off = (a.value - b.value).abs() / steep.sqrt();
        largest = largest.max(off);
        squares += off * off;
        curvature += (a.d2 / (1.0 + a.d1 * a.d1).powf(1.5) - b.d2 / steep.powf(1.5)).powi(2);
    }
    (largest, (squares / f64::from(n)).sqrt(), (curvature / f64::from(n)).sqrt())
}

#[test]
fn equiv_simpack_files_are_the_built_in_profiles() {
    let wheel = read("kind = \"simpack\"\nfile = \"wheel_s1002.prw\"\nradius = 0.46\n", Part::Wheel);
    let (largest, rms, _) = distances(&wheel, &read("kind = \"s1002\"\nradius = 0.46\n", Part::Wheel), -0.0695, 0.0595);
    println!("wheel: largest {:.3} um, rms {:.3} um", 1e6 * largest, 1e6 * rms);
    assert!(largest < 1.5e-6 && rms < 2e-7);
    assert!((wheel.profile.at(0.0).value - 0.46).abs() < 1e-15);
    assert!(wheel.notes.is_empty(), "{:?}", wheel.notes);
    let rail = read("kind = \"simpack\"\nfile = \"rail_60e1.prr\"\n", Part::Rail);
    let (largest, rms, _) = distances(&rail, &read("kind = \"60e1\"\n", Part::Rail), -0.0355, 0.0355);
    println!("rail: largest {:.3} um, rms {:.3} um; {:?}", 1e6 * largest, 1e6 * rms, rail.notes);
    assert!(largest < 2e-6 && rms < 3e-7);
    assert_eq!(rail.notes, vec!["heights were downward positive (seen from the shape)"]);
    assert_eq!(rail.file.unwrap().path, PathBuf::from("rail_60e1.prr"));
}

#[test]
fn equiv_noisy_miniprof_rail_follows_60e1_and_smoothing_helps() {
    let wanted = read("kind = \"60e1\"\n", Part::Rail);
    let text = "kind = \"miniprof\"\nfile = \"rail_60e1.ban\"\n";
    let raw = read(text, Part::Rail);
    let smooth = read(&format!("{text}smoothing = \"0.003 mm\"\n"), Part::Rail);
    let (plain, better) = (distances(&raw, &wanted, -0.033, 0.033), distances(&smooth, &wanted, -0.033, 0.033));
    println!("60E1, noise 4 um: largest {:.2} um, rms {:.2} um, curvature {:.1} 1/m", 1e6 * plain.0, 1e6 * plain.1, plain.2);
    println!("smoothed by 3 um: largest {:.2} um, rms {:.2} um, curvature {:.1} 1/m", 1e6 * better.0, 1e6 * better.1, better.2);
    println!("{:?}\n{:?}", raw.notes, smooth.notes);
    assert!(plain.0 < 8e-6 && plain.1 < 3.5e-6);
    assert!(better.1 < 0.8 * plain.1 && better.2 < 0.2 * plain.2, "{plain:?} {better:?}");
    assert!(raw.notes.iter().any(|note| note.contains("overhang")));
    let (first, last) = raw.profile.range();
    assert!((-0.0366..-0.0355).contains(&first) && (0.0355..0.0361).contains(&last), "{first} {last}");
}

#[test]
fn equiv_points_of_a_wheel_may_count_from_the_flange_back() {
    let wanted = read("kind = \"s1002\"\nradius = 0.46\n", Part::Wheel);
    let folder = tempfile::tempdir().unwrap();
    for (columns, datum) in [("u,radius", 0.0), ("u,height", 0.46)] {
        let rows: String = (0..1000)
            .map(|k| -0.068 + 1.26e-4 * f64::from(k))
            .map(|u| {
                let radius = wanted.profile.at(u).value;
                format!("{:.7},{:.9}\n", u + 0.07, if datum == 0.0 { radius } else { radius - datum })
            })
            .collect();
        std::fs::write(folder.path().join("w.csv"), format!("{columns}\n{rows}")).unwrap();
        let text = "kind = \"points\"\nfile = \"w.csv\"\nradius = 0.46\ntread_circle = \"70 mm\"\n";
        let found = read_in(folder.path(), text, Part::Wheel).unwrap();
        let (largest, ..) = distances(&found, &wanted, -0.06, 0.05);
        assert!(largest < 2e-6, "{columns}: {largest}");
        // The file's own coordinate, whichever way its axis goes.
        let back: String = rows.lines().map(|line| format!("-{line}\n")).collect();
        std::fs::write(folder.path().join("w.csv"), format!("{columns}\n{back}")).unwrap();
        let text = text.replace("70 mm", "-70 mm") + "mirror = true\n";
        let found = read_in(folder.path(), &text, Part::Wheel).unwrap();
        let (largest, ..) = distances(&found, &wanted, -0.06, 0.05);
        assert!(largest < 2e-6, "{columns}, mirrored: {largest}");
    }
}

#[test]
fn equiv_noisy_miniprof_wheel_follows_s1002() {
    let wanted = read("kind = \"s1002\"\nradius = 0.46\n", Part::Wheel);
    let text = "kind = \"miniprof\"\nfile = \"wheel_s1002.whl\"\nradius = 0.46\n";
    let raw = read(text, Part::Wheel);
    let smooth = read(&format!("{text}smoothing = \"0.003 mm\"\n"), Part::Wheel);
    let (plain, better) = (distances(&raw, &wanted, -0.068, 0.058), distances(&smooth, &wanted, -0.068, 0.058));
    println!("S1002, noise 4 um: largest {:.2} um, rms {:.2} um, curvature {:.1} 1/m", 1e6 * plain.0, 1e6 * plain.1, plain.2);
    println!("smoothed by 3 um: largest {:.2} um, rms {:.2} um, curvature {:.1} 1/m", 1e6 * better.0, 1e6 * better.1, better.2);
    println!("{:?}", smooth.notes);
    // The height at the tread circle, which the radius replaces, is noisy too.
    assert!(plain.0 < 12e-6 && plain.1 < 6e-6, "{plain:?}");
    assert!(better.2 < 0.35 * plain.2);
    assert!((raw.profile.at(0.0).value - 0.46).abs() < 1e-15 && (smooth.profile.at(0.0).value - 0.46).abs() < 1e-15);
    let mirrored = read_in(&samples(), &format!("{text}mirror = true\n"), Part::Wheel).unwrap_err().to_string();
    assert!(mirrored.contains("not over the origin; see tread_circle, shift_y or mirror"), "{mirrored}");
}

#[test]
fn equiv_csv_heights_in_millimetres_in_any_order() {
    let wanted = read("kind = \"s1002\"\nradius = 0.46\n", Part::Wheel);
    let found = read("kind = \"points\"\nfile = \"wheel_s1002.csv\"\nradius = 0.46\n", Part::Wheel);
    let (largest, rms, _) = distances(&found, &wanted, -0.068, 0.058);
    println!("largest {:.2} um, rms {:.2} um", 1e6 * largest, 1e6 * rms);
    assert!(largest < 12e-6 && rms < 6e-6);
    let lifted =
        read("kind = \"points\"\nfile = \"wheel_s1002.csv\"\nradius = 0.46\nshift_y = \"1 mm\"\nshift_z = \"2 mm\"\n", Part::Wheel);
    let slope = wanted.profile.at(-0.001).d1;
    assert!((lifted.profile.at(0.0).value - 0.462).abs() < 5e-6 && (lifted.profile.at(0.0).d1 - slope).abs() < 0.02);
}

/// Message for a file of that name and content.
fn refusal(name: &str, content: &str, more: &str, part: Part) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), content).unwrap();
    let kind = match name.rsplit_once('.').unwrap().1 {
        "csv" => "points",
        "prw" | "prr" => "simpack",
        _ => "miniprof",
    };
    let error = read_in(folder.path(), &format!("kind = \"{kind}\"\nfile = \"{name}\"\n{more}"), part).unwrap_err();
    error.to_string().rsplit_once(std::path::MAIN_SEPARATOR).map_or(error.to_string(), |(_, tail)| tail.to_string())
}

#[test]
fn hard_bad_csv_files_are_refused_with_file_and_line() {
    let message = |text: &str| refusal("w.csv", text, "", Part::Wheel);
    assert!(message("x,y\n1,2\n").starts_with("w.csv:1: u,radius: found the header \"x,y\""));
    assert!(message("u [kg],radius\n1,2\n").starts_with("w.csv:1: u,radius: found the header"));
    assert!(message("u,radius\n0,0.46\n0.01,abc\n").starts_with("w.csv:3: u,radius: found \"abc\""));
    assert!(message("u,radius\n0,0.46\n0.01,nan\n").starts_with("w.csv:3: "));
    assert!(message("u,radius\n0,0.46\n0.01,0.46,1\n").starts_with("w.csv:3: u,radius: found 3 columns, expected 2"));
    assert!(message("u,radius\n0,0.46\n0.01,0.46\n0,0.45\n").starts_with("w.csv:4: u,radius: u = 0 was given before in line 2"));
    assert!(message("u,radius\n0,0.46\n").contains("found 1 points, expected at least 3"));
    assert!(message("u,radius\n-0.01,0.46\n0,-0.46\n0.02,0.4\n").starts_with("w.csv:3: u,radius: found radius -0.46"));
    assert!(message("u,radius\n-50,460\n0,460\n50,458\n").contains("100000.000 mm wide, expected 10 to 500 mm: another unit"));
    assert!(message("u,radius\n0.01,0.46\n0.02,0.46\n0.05,0.46\n").contains("from 10.00 mm to 50.00 mm: not over the origin"));
    assert!(message("u,height\n-0.01,0\n0,0\n0.05,0\n").contains("radius: is missing"));
    let wheel = "u,radius\n-0.05,0.46\n0,0.46\n0.03,0.46\n0.05,0.487\n";
    assert!(message(wheel).starts_with("w.csv:5: u,radius: the flange stands at u = 50.0 mm, on the outer side"));
    let inverted = "u,radius\n-0.06,0.45\n-0.045,0.433\n-0.03,0.46\n0,0.46\n0.05,0.461\n";
    assert!(
        message(inverted).starts_with("w.csv:3: u,radius: falls 27.0 mm below the tread where a flange rises"),
        "{}",
        message(inverted)
    );
    assert!(refusal("r.csv", "eta,height\n-0.05,0.027\n0,0\n0.05,0\n", "", Part::Rail).starts_with("r.csv:2: eta,height: rises 27.0 mm"));
}

#[test]
fn hard_bad_instrument_files_are_refused_with_file_and_line() {
    let rail = |text: &str| refusal("r.ban", text, "", Part::Rail);
    assert_eq!(refusal("r.ban", "", "", Part::Wheel), "r.ban: type: this is the file of a rail, expected that of a wheel");
    assert!(rail("ColumnDef=X,Z\n\n1 2\n").starts_with("r.ban:1: ColumnDef: found \"X,Z\""));
    assert!(rail("XOffset=a\n").starts_with("r.ban:1: XOffset: found \"a\", expected a number"));
    assert!(rail("ColumnDef=X,Y,A\n\n1 2 3\n1 2\n").starts_with("r.ban:4: X,Y: found 2 columns, expected 3"));
    assert!(rail("ColumnDef=X,Y\n\n1 2\n1 two\n").starts_with("r.ban:4: X,Y: found \"1 two\", expected a row of numbers"));
    assert!(rail("ColumnDef=X,Y\n\n1 2\n2 NaN\n").starts_with("r.ban:4: X,Y: found \"2 NaN\""));
    assert!(rail("a=b\n\n").contains("found 0 points"));
    assert!(refusal("r.mpt", "MPD1=A 1 2 3\n", "", Part::Rail).starts_with("r.mpt:1: MPD1: found \"A 1 2 3\"; only lines"));

    let simpack = |text: &str| refusal("r.prr", text, "", Part::Rail);
    assert!(simpack("header.begin\ntype = 1\n").starts_with("r.prr:2: type: this is the file of a wheel"));
    assert!(simpack("spline.begin\nrotate = 0.1\npoint.begin\n0 0\npoint.end\nspline.end\n").starts_with("r.prr:2: rotate: a rotation"));
    assert!(simpack("spline.begin\npoint.begin\n0 0 0 0\n").starts_with("r.prr:3: y,z: found \"0 0 0 0\""));
    assert!(simpack("spline.begin\npoint.begin\n0 0\n").starts_with("r.prr:2: y,z: the section point has no end"));
    assert!(simpack("point.begin\n").starts_with("r.prr:1: y,z: found \"point.begin\""));
    assert!(simpack("spline.begin\npoint.end\n").starts_with("r.prr:2: y,z: found \"point.end\" inside \"spline\""));
    assert!(simpack("header.begin\nheader.end\n").contains("is this a SIMPACK profile?"));
    assert!(simpack("spline.begin\nshift.y = a\n").starts_with("r.prr:2: shift.y: found \"a\""));
}

#[test]
fn prop_keys_of_a_simpack_file_are_followed() {
    // Shifted, mirrored, in inches, with a bound and an order of its own: still the parabola z = -x^2.
    let mut text = "spline.begin\nshift.y = 1.0\nshift.z = -2.0\nmirror.y = 1\nmirror.z = 1\nunits.len.f = 39.37007874015748\nbound.y.min = -5.0\nbound.y.max = 1.2\npoint.begin\n".to_string();
    for i in -10..=10 {
        let x = 0.003 * f64::from(i);
        text += &format!("{} {}\n", (-x) / 0.0254 - 1.0, x * x / 0.0254 + 2.0);
    }
    text += "point.end\nspline.end\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("r.prr"), text).unwrap();
    let found = read_in(folder.path(), "kind = \"simpack\"\nfile = \"r.prr\"\n", Part::Rail).unwrap();
    for x in [-0.03, -0.006, 0.0, 0.009, 0.03] {
        assert!((found.profile.at(x).value + x * x).abs() < 1e-12, "{x}: {:?}", found.profile.at(x));
    }
    let bounded = "bound.y.max = 1.2";
    assert!(found.notes.is_empty(), "{bounded}: nothing is outside: {:?}", found.notes);
}

#[test]
fn hard_outliers_are_named_or_left_out() {
    let text = std::fs::read_to_string(samples().join("rail_60e1.ban")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let row = lines.len() - 60;
    let numbers: Vec<f64> = lines[row].split_whitespace().map(|word| word.parse().unwrap()).collect();
    lines[row] = format!("{} {} 0", numbers[0], numbers[1] + 0.5);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("r.ban"), lines.join("\r\n")).unwrap();
    let settings = "kind = \"miniprof\"\nfile = \"r.ban\"\n";
    let error = read_in(folder.path(), settings, Part::Rail).unwrap_err();
    assert_eq!(error.line, row + 1);
    assert!(error.problem.starts_with(&format!("found outliers in lines {}; mend them", row + 1)), "{error}");
    let found = read_in(folder.path(), &format!("{settings}drop_outliers = true\n"), Part::Rail).unwrap();
    assert!(found.notes.contains(&format!("1 outliers left out: lines {}", row + 1)), "{:?}", found.notes);
    let (largest, ..) = distances(&found, &read("kind = \"60e1\"\n", Part::Rail), -0.033, 0.033);
    assert!(largest < 8e-6, "{largest}");
}

#[test]
fn prop_old_miniprof_heads_and_templates_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let points: Vec<(f64, f64)> =
        (0..=130).map(f64::from).map(|x| (x, if x < 40.0 { 27.0 - (x - 15.0).abs() } else { (70.0 - x) / 20.0 })).collect();
    let mut old = "#MINIWHEELPROF\r\na_wheel.whl\r\nStock.......:\r\n\" 32.58 37.11 14.71\r\n(Sd/Sh/qR)\r\n\r\n".to_string();
    let mut template = "[FileInfo]\nProgramName=x\n[Profile1Info]\n".to_string();
    for (i, pair) in points.windows(2).enumerate() {
        old += &format!("{} {}\r\n", pair[0].0, pair[0].1);
        template += &format!("MPD{}=L {} {} {} {}\n", i + 1, pair[0].0, pair[0].1, pair[1].0, pair[1].1);
    }
    std::fs::write(folder.path().join("old.whl"), old + "130 -3\r\n").unwrap();
    std::fs::write(folder.path().join("t.mpt"), template).unwrap();
    let profile = |name: &str| {
        let settings = format!("kind = \"miniprof\"\nfile = \"{name}\"\nradius = 0.5\ndrop_outliers = true\n");
        read_in(folder.path(), &settings, Part::Wheel).unwrap()
    };
    let (old, template) = (profile("old.whl"), profile("t.mpt"));
    assert_eq!(old.profile.range(), template.profile.range());
    for x in [-0.06, -0.02, 0.0, 0.03] {
        assert_eq!(old.profile.at(x), template.profile.at(x));
    }
    assert!((old.profile.at(0.02).value - 0.499).abs() < 1e-6, "{:?}", old.profile.at(0.02));
}

/// Points that a file gives to a micrometre go to and fro by half of it, at a spacing of 0.05 mm with curvatures of hundreds of 1/m.
#[test]
fn prop_rounded_points_carry_a_smooth_curve_within_their_last_digit() {
    let folder = tempfile::tempdir().unwrap();
    let exact = read("kind = \"60e1\"\n", Part::Rail);
    for (spacing, digits) in [(1e-4, 3), (5e-5, 3), (5e-5, 4)] {
        let last = (0.035 / spacing) as i32;
        let points: Vec<(f64, f64)> = (-last..=last).map(|k| spacing * f64::from(k)).map(|x| (x, exact.profile.at(x).value)).collect();
        let rows: String = points.iter().map(|(x, z)| format!("{:.4},{:.digits$}\n", 1e3 * x, 1e3 * z)).collect();
        std::fs::write(folder.path().join("r.csv"), format!("eta [mm],height [mm]\n{rows}")).unwrap();
        let rail = read_in(folder.path(), "kind = \"points\"\nfile = \"r.csv\"\n", Part::Rail).unwrap();
        let digit = 10f64.powi(-3 - digits as i32);
        assert!(rail.notes.iter().any(|note| note.contains(&format!("rounded to {:.1} um", 1e6 * digit))), "{:?}", rail.notes);
        let (mut off, mut bends) = (0.0_f64, 0.0_f64);
        for x in (-250..=250).map(|k| 1e-4 * f64::from(k)) {
            let (found, true_one) = (rail.profile.at(x), exact.profile.at(x));
            off = off.max((found.value - true_one.value).abs() / 1f64.hypot(true_one.d1));
            bends += (found.d2 - true_one.d2).powi(2) / 501.0;
        }
        println!("{spacing} m, {digit} m: off by {off:.1e} m, curvatures by {:.1} 1/m (rms)", bends.sqrt());
        // Rounding alone bends a spline through the points by 100 1/m and more.
        assert!(off < 2.0 * digit && bends.sqrt() < 15.0, "{off} {}", bends.sqrt());
    }
}

#[test]
fn prop_a_fit_stays_within_what_is_asked_of_all_points() {
    let folder = tempfile::tempdir().unwrap();
    let exact = read("kind = \"60e1\"\n", Part::Rail);
    let points: Vec<(f64, f64)> = (-68..=68)
        .map(|k| 5e-4 * f64::from(k))
        .map(|x| (x, exact.profile.at(x).value + 5e-7 * (4375.85 * (9.7e5 * x).sin()).fract()))
        .collect();
    let rows: String = points.iter().map(|(x, z)| format!("{x},{z}\n")).collect();
    std::fs::write(folder.path().join("r.csv"), format!("eta,height\n{rows}")).unwrap();
    let rail = |more: &str| read_in(folder.path(), &format!("kind = \"points\"\nfile = \"r.csv\"\n{more}"), Part::Rail);
    let (through, fitted) = (rail("").unwrap(), rail("fit_within = \"3 um\"\n").unwrap());
    assert!(through.doubt.as_ref().is_some_and(|doubt| doubt.contains("swings")) && fitted.doubt.is_none(), "{:?}", fitted.doubt);
    assert!(fitted.notes.iter().any(|note| note.ends_with("at most 0.0030 mm")), "{:?}", fitted.notes);
    let across = |(x, z): &(f64, f64)| {
        let fit = fitted.profile.at(*x);
        (fit.value - z).abs() / 1f64.hypot(fit.d1)
    };
    let furthest = points.iter().map(across).fold(0.0, f64::max);
    assert!((1e-6..3.2e-6).contains(&furthest), "{furthest}");
    let off = |choice: &ProfileChoice| {
        let places = (-200..=80).map(|k| 1e-4 * f64::from(k));
        places.map(|x| (choice.profile.at(x).d2 - exact.profile.at(x).d2).powi(2)).sum::<f64>().sqrt()
    };
    assert!(off(&fitted) < 0.4 * off(&through), "{} {}", off(&fitted), off(&through));
    let both = rail("fit_within = \"3 um\"\nsmoothing = \"3 um\"\n").unwrap_err().to_string();
    assert!(both.contains("fit_within: stands beside smoothing"), "{both}");
}

#[test]
fn prop_a_wheel_takes_the_radius_of_its_file_unless_the_scene_names_one() {
    let folder = tempfile::tempdir().unwrap();
    let miniprof = std::fs::read_to_string(samples().join("wheel_s1002.whl")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let with = |lines: &str| miniprof.replacen("ColumnDef=X,Y", &format!("ColumnDef=X,Y\n{lines}"), 1);
    write("w.whl", &with("WheelDiameterTaperline=900.0\nDiameterTaperline=903.0"));
    write("stated.whl", &with("WheelDiameterTaperline=900.0\nDiameterTaperline=0"));
    write("inches.whl", &with("DiameterTaperline=33"));
    let wheel = |settings: &str| read_in(folder.path(), settings, Part::Wheel);
    let at = |choice: &ProfileChoice| choice.profile.at(0.0).value;
    let of_file = wheel("kind = \"miniprof\"\nfile = \"w.whl\"\n").unwrap();
    assert!((at(&of_file) - 0.4515).abs() < 1e-12, "{}", at(&of_file));
    assert!(of_file.notes.iter().any(|note| note == "radius 451.500 mm of the file (DiameterTaperline, line 7)"), "{:?}", of_file.notes);
    assert!((at(&wheel("kind = \"miniprof\"\nfile = \"stated.whl\"\n").unwrap()) - 0.45).abs() < 1e-12);
    let of_scene = wheel("kind = \"miniprof\"\nfile = \"w.whl\"\nradius = 0.46\n").unwrap();
    assert!((at(&of_scene) - 0.46).abs() < 1e-12);
    let wanted = "radius 460.000 mm of the scene instead of the file's 451.500 mm";
    assert!(of_scene.notes.iter().any(|note| note.starts_with(wanted)), "{:?}", of_scene.notes);
    // Only the level differs.
    for x in [-0.06, -0.03, 0.02] {
        assert!((of_scene.profile.at(x).value - of_file.profile.at(x).value - 8.5e-3).abs() < 1e-12);
    }
    let refused = wheel("kind = \"miniprof\"\nfile = \"inches.whl\"\n").unwrap_err().to_string();
    assert!(refused.contains("inches.whl:6: DiameterTaperline: found a wheel radius of 16.500 mm"), "{refused}");
    // Points with radii: the scene's radius goes before them.
    write("w.csv", "u,radius\n-0.05,0.48\n-0.03,0.461\n0,0.46\n0.03,0.459\n0.05,0.458\n");
    let points = |more: &str| wheel(&format!("kind = \"points\"\nfile = \"w.csv\"\n{more}")).unwrap();
    let (own, named) = (points(""), points("radius = \"455 mm\"\n"));
    assert!((at(&own) - 0.46).abs() < 1e-15 && (at(&named) - 0.455).abs() < 1e-12 && own.notes.is_empty());
    assert!((own.profile.at(0.02).value - named.profile.at(0.02).value - 5e-3).abs() < 1e-12);
    assert!(named.notes[0].starts_with("radius 455.000 mm of the scene instead of the file's 460.000 mm"), "{:?}", named.notes);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn prop_direction_of_the_points_does_not_matter(down in any::<bool>(), reversed in any::<bool>(), mirror in any::<bool>()) {
        let mut rows: Vec<(f64, f64)> = (-40..=44).map(|i| f64::from(i) * 0.7).map(|x| (x, -x * x / 160.0 - (x / 40.0).powi(3))).collect();
        if reversed {
            rows.reverse();
        }
        let sign = |flag| if flag { -1.0 } else { 1.0 };
        // X toward the gauge face unless mirrored.
        let text: String = rows.iter().map(|(x, z)| format!("{} {}\n", -sign(mirror) * x, sign(down) * z)).collect();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("r.ban"), text).unwrap();
        let found = read_in(folder.path(), &format!("kind = \"miniprof\"\nfile = \"r.ban\"\nmirror = {mirror}\n"), Part::Rail).unwrap();
        for (x, z) in rows {
            prop_assert!((1e3 * found.profile.at(1e-3 * x).value - z).abs() < 1e-9);
        }
    }
}
