//! Files of profiles and measured tracks, through their readers and through a scene.

use super::mutate::{self, Random};
use super::run::{self, Case};
use super::scenes::{READING, try_scene};
use std::path::{Path, PathBuf};
use wheelrail::geometry::profile::{self, Part, Profile};
use wheelrail::geometry::track::irregularity;
use wheelrail::settings::{Section, SettingsError, Source};

/// Key of a scene, its table but for the file, and the seed.
struct Seed {
    key: &'static str,
    table: &'static str,
    file: PathBuf,
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn seeds() -> Vec<Seed> {
    let seed = |key, table, file| Seed { key, table, file: data(file) };
    vec![
        seed("vehicle.wheelset.profile", "kind = \"points\", radius = 0.46", "profiles/wheel_s1002.csv"),
        seed("vehicle.wheelset.profile", "kind = \"miniprof\", radius = 0.46", "profiles/wheel_s1002.whl"),
        seed("vehicle.wheelset.profile", "kind = \"simpack\", radius = 0.46", "profiles/wheel_s1002.prw"),
        seed(
            "vehicle.wheelset.profile",
            "kind = \"points\", radius = 0.46, drop_outliers = true, smoothing = 1e-5",
            "profiles/wheel_s1002.csv",
        ),
        seed("track.rail", "kind = \"miniprof\"", "profiles/rail_60e1.ban"),
        seed("track.rail", "kind = \"simpack\"", "profiles/rail_60e1.prr"),
        seed("track.rail", "kind = \"points\"", "fuzz/rail.csv"),
        seed("track.rail", "kind = \"miniprof\"", "fuzz/template.mpt"),
        seed("track.irregularity", "kind = \"series\"", "fuzz/series.csv"),
        seed("track.irregularity", "kind = \"series\", fade = 2, offset = 20, smoothing = \"0.1 mm\", scale = 0.5", "fuzz/series.csv"),
        seed("track.irregularity", "kind = \"series\"", "fuzz/rails.csv"),
    ]
}

fn with_section<T>(text: &str, folder: &Path, read: impl FnOnce(Section) -> Result<T, SettingsError>) -> Result<T, SettingsError> {
    let source = Source { file: "scene.toml".into(), text: text.into(), overridden: vec![], folder: Some(folder.into()) };
    let Ok(document) = toml_edit::Document::parse(source.text.clone()) else {
        return Err(SettingsError { file: "scene.toml".into(), line: 1, key: "x".into(), problem: "no TOML".into() });
    };
    read(Section::root(document.as_table(), &source))
}

/// A profile is finite wherever an iteration may stray.
fn check_profile(profile: &dyn Profile) {
    let (first, last) = profile.range();
    assert!(first < last && last - first < 1.0, "range {first} to {last}");
    for i in -100..=300 {
        let x = first + (last - first) * f64::from(i) / 200.0;
        let p = profile.at(x);
        assert!([p.value, p.d1, p.d2, p.d3].iter().all(|v| v.is_finite()), "{x}: {p:?}");
    }
}

/// Reads the file by its reader alone.
fn read_alone(case: &mut Case, seed: &Seed, table: &str, folder: &Path) -> bool {
    case.begin();
    let text = table.replace(", ", "\n");
    let result = if seed.key == "track.irregularity" {
        with_section(&text, folder, irregularity::parse).map(|track| {
            for deviation in &track.deviations {
                for i in -20..=220 {
                    let at = deviation.shape.at(f64::from(i));
                    assert!(at.iter().all(|v| v.is_finite()), "{i} m: {at:?}");
                }
            }
        })
    } else {
        let part = if seed.key == "track.rail" { Part::Rail } else { Part::Wheel };
        with_section(&text, folder, |section| profile::parse(section, part)).map(|choice| check_profile(choice.profile.as_ref()))
    };
    if let Err(error) = &result {
        let words = error.to_string();
        assert!(!error.file.is_empty() && !error.problem.is_empty() && words.len() > 15, "SPEECHLESS: {words}");
    }
    case.within(READING, "reading the file");
    result.is_ok()
}

#[test]
fn prop_any_file_of_a_profile_or_a_measured_track_is_read_or_refused() {
    let seeds = seeds();
    let folder = tempfile::tempdir().unwrap();
    let mut counts = [0; 3];
    run::each("files", 500, |random: &mut Random, case| {
        let seed = random.of(&seeds);
        let mut text = String::from_utf8_lossy(&std::fs::read(&seed.file).unwrap()).into_owned();
        for _ in 0..random.below(5) {
            text = mutate::text(random, &text);
        }
        let name = format!("a.{}", seed.file.extension().unwrap().to_string_lossy());
        let mut table = format!("{}, file = \"{name}\"", seed.table);
        if random.once_in(4) {
            table = mutate::text(random, &table);
        }
        std::fs::write(folder.path().join(&name), &text).unwrap();
        case.text = format!("{table}\n\n{text}");
        run::now("files", &case.text);
        let good = read_alone(case, seed, &table, folder.path());
        counts[usize::from(good)] += 1;
        if good && random.once_in(4) {
            let scene = wheelrail::scene::embedded::find("wheelset_s1002").unwrap();
            let change =
                if seed.key == "track.irregularity" { format!("{}=[{{{table}}}]", seed.key) } else { format!("{}={{{table}}}", seed.key) };
            let came = try_scene(case, "wheelset_s1002", scene.text, Some(folder.path().into()), &[change]);
            counts[2] += usize::from(came == "ran");
        }
    });
    println!("{counts:?} refused, read, run");
}
