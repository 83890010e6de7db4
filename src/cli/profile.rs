//! `wheelrail profile WHAT`: any profile that a scene could name, as a table, CSV or diagram.

use super::output::{Kind, Target};
use super::plot::{BLUE, Ink, Panel, Series, Sheet};
use super::{Failure, check_picture, print, refused, say, table};
use crate::geometry::profile::{self, Part, Profile, ProfileChoice, ProfilePoint};
use crate::settings::{Section, SettingsError, Source};
use clap::{Args, ValueEnum};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(super) struct Arguments {
    /// A kind ("60e1"), a file (.csv, .whl, .ban, .mpt, .prw, .prr), or settings ('{ kind = "s1002", radius = 0.46 }')
    profile: String,
    /// Wheel or rail [default: what the profile can be]
    #[arg(long)]
    part: Option<PartName>,
    /// Number of points, equally spaced along the surface
    #[arg(long, default_value_t = 501, value_name = "N")]
    points: usize,
    /// Write coordinate, value, slope and curvature as CSV, which kind = "points" reads ("-" for stdout)
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Only the two columns coordinate and value
    #[arg(long)]
    bare: bool,
    /// Draw section and curvature as SVG
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum PartName {
    Wheel,
    Rail,
}

impl From<PartName> for Part {
    fn from(name: PartName) -> Self {
        match name {
            PartName::Wheel => Part::Wheel,
            PartName::Rail => Part::Rail,
        }
    }
}

/// Fewest and most points.
const POINTS: (usize, usize) = (5, 1_000_000);
/// Rows of the printed table.
const ROWS: usize = 15;

pub(super) fn profile(arguments: &Arguments) -> Result<(), Failure> {
    if !(POINTS.0..=POINTS.1).contains(&arguments.points) {
        return Err(Failure::Input(format!("--points {}: expected {} to {}", arguments.points, POINTS.0, POINTS.1)));
    }
    let (part, choice) = open(arguments)?;
    check_picture(&arguments.plot)?;
    let samples = sample(choice.profile.as_ref(), arguments.points);
    if let Some(path) = &arguments.output {
        Target::find(path, Kind::Csv).map_err(refused)?.write(csv(&samples, part, arguments.bare).as_bytes())?;
    }
    if let Some(path) = &arguments.plot {
        draw(path, &choice.profile.describe(), part, &samples).map_err(Failure::Run)?;
        say(&format!("wrote {}", path.display()));
    }
    choice.notes.iter().chain(&choice.doubt).for_each(|note| say(&format!("note: {note}")));
    if arguments.output.as_deref() != Some(Path::new("-")) {
        print(&summary(part, choice.profile.as_ref()))?;
    }
    Ok(())
}

/// The settings that the argument stands for, as TOML.
fn settings(argument: &str) -> String {
    if argument.trim_start().starts_with('{') {
        return argument.trim().into();
    }
    let file_kind = Path::new(argument).extension().and_then(|extension| match extension.to_string_lossy().to_lowercase().as_str() {
        "csv" => Some("points"),
        "whl" | "ban" | "mpt" => Some("miniprof"),
        "prw" | "prr" => Some("simpack"),
        _ => None,
    });
    // Literal strings: backslashes of paths are no escapes.
    match file_kind {
        Some(kind) => format!("{{ kind = \"{kind}\", file = '{argument}' }}"),
        None => format!("{{ kind = '{argument}' }}"),
    }
}

fn open(arguments: &Arguments) -> Result<(Part, ProfileChoice), Failure> {
    let text = format!("profile = {}\n", settings(&arguments.profile));
    let source = Source { file: "command line".into(), text, overridden: vec![], folder: Some(".".into()) };
    let document = toml_edit::Document::parse(source.text.clone())
        .map_err(|error| Failure::Input(format!("{}: {}", arguments.profile, error.message().trim())))?;
    let read = |part: Part| -> Result<(Part, ProfileChoice), SettingsError> {
        let root = Section::root(document.as_table(), &source);
        Ok((part, profile::parse(root.section("profile")?, part)?))
    };
    // The command line has no lines, a profile file has.
    let plain = |error: SettingsError| if error.file == source.file { SettingsError { line: 0, ..error } } else { error };
    let words = |error: SettingsError| Failure::Input(error.to_string());
    if let Some(part) = arguments.part {
        return read(part.into()).map_err(plain).map_err(words);
    }
    let (wheel, rail) = (read(Part::Wheel).map_err(plain), read(Part::Rail).map_err(plain));
    match (wheel, rail) {
        (Ok(_), Ok(_)) => Err(Failure::Input("this may be a wheel or a rail; say --part wheel or --part rail".into())),
        (Ok(found), _) | (_, Ok(found)) => Ok(found),
        (Err(wheel), Err(rail)) if wheel == rail => Err(words(wheel)),
        (Err(wheel), Err(rail)) => Err(Failure::Input(format!("as a wheel: {wheel}\n       as a rail: {rail}"))),
    }
}

/// Points of the profile, equally spaced along its surface between the ends of its range.
fn sample(profile: &dyn Profile, count: usize) -> Vec<(f64, ProfilePoint)> {
    let (first, last) = profile.range();
    // Length along the surface at equally spaced coordinates, then inverted.
    let fine = 20 * count.max(1000);
    let at = |i: usize| if i == fine { last } else { first + (last - first) * i as f64 / fine as f64 };
    let mut length = vec![0.0; fine + 1];
    for i in 1..=fine {
        length[i] = length[i - 1] + (at(i) - at(i - 1)).hypot(profile.at(at(i)).value - profile.at(at(i - 1)).value);
    }
    let mut cell = 1;
    (0..count)
        .map(|k| {
            let wanted = length[fine] * k as f64 / (count - 1) as f64;
            while cell < fine && length[cell] < wanted {
                cell += 1;
            }
            let share = ((wanted - length[cell - 1]) / (length[cell] - length[cell - 1])).clamp(0.0, 1.0);
            let x = if k + 1 == count { last } else { at(cell - 1) + share * (at(cell) - at(cell - 1)) };
            (x, profile.at(x))
        })
        .collect()
}

/// Curvature of the section, 1/m; negative where the surface is convex.
fn curvature(point: &ProfilePoint) -> f64 {
    point.d2 / (1.0 + point.d1 * point.d1).powf(1.5)
}

/// Names of coordinate and value.
fn names(part: Part) -> (&'static str, &'static str) {
    match part {
        Part::Wheel => ("u", "radius"),
        Part::Rail => ("eta", "height"),
    }
}

fn csv(samples: &[(f64, ProfilePoint)], part: Part, bare: bool) -> String {
    let (coordinate, value) = names(part);
    let mut text = format!("{coordinate},{value}{}\n", if bare { "" } else { ",slope,curvature" });
    for (x, point) in samples {
        // `{}` writes the shortest number that reads back as the same.
        let _ = match bare {
            true => writeln!(text, "{x},{}", point.value),
            false => writeln!(text, "{x},{},{},{}", point.value, point.d1, curvature(point)),
        };
    }
    text
}

/// Section and curvature, one above the other.
fn draw(path: &Path, title: &str, part: Part, samples: &[(f64, ProfilePoint)]) -> Result<(), String> {
    let (coordinate, value) = names(part);
    let along = format!("{coordinate} [mm], outward");
    let panel = |title: &str, axis: &str, of: &dyn Fn(&ProfilePoint) -> f64| {
        let points = samples.iter().map(|(x, point)| (1e3 * x, of(point))).collect();
        Panel::new(title, [&along, axis], vec![Series::line("", Ink::line(BLUE), points)])
    };
    let section = panel("Section", &format!("{value} [mm]"), &|point| 1e3 * point.value);
    let panels = vec![section, panel("Curvature", "curvature [1/m]", &curvature)];
    Sheet { title: title.into(), subtitles: vec![], columns: 1, panels }.draw(path)
}

/// A number with a fixed count of decimals; what rounds to zero has no sign.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|letter| "0.".contains(letter)) { text.trim_start_matches('-').into() } else { text }
}

fn summary(part: Part, profile: &dyn Profile) -> String {
    let (coordinate, value) = names(part);
    let (first, last) = profile.range();
    let joints: Vec<String> = profile.joints().iter().map(|joint| format!("{:.3}", 1e3 * joint)).collect();
    let mut text = format!("{}\n", profile.describe());
    let _ = writeln!(text, "  range {coordinate} = {:.3} .. {:.3} mm", 1e3 * first, 1e3 * last);
    if !joints.is_empty() {
        let _ = writeln!(text, "  curvature jumps at {} mm", joints.join(", "));
    }
    text.push('\n');
    let head = [format!("{coordinate} [mm]"), format!("{value} [mm]"), "slope".into(), "angle [deg]".into(), "curvature [1/m]".into()];
    let rows = sample(profile, ROWS);
    let rows: Vec<Vec<String>> = rows
        .iter()
        .map(|(x, point)| {
            vec![
                fixed(1e3 * x, 3),
                fixed(1e3 * point.value, 4),
                fixed(point.d1, 5),
                fixed(point.d1.atan().to_degrees(), 2),
                fixed(curvature(point), 3),
            ]
        })
        .collect();
    text + &table(&head, &rows)
}
