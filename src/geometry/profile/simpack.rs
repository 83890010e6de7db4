//! Points of a SIMPACK profile file: `.prw` (wheel), `.prr` (rail).
//!
//! Sections `header.begin ... header.end` (`type` 0 rail, 1 wheel) and `spline.begin ... spline.end` with keys and,
//! between `point.begin` and `point.end`, rows of y, z and an optional weight. `!` starts a comment. What the keys
//! ask for is done in the order that the files number it: points nearer than `point.dist.min` merged, `shift.y`,
//! `shift.z`, bounds where min < max (points outside are left out), `mirror.y`, `mirror.z`, lengths divided by
//! `units.len.f` (user units per metre). `inversion` only reverses the order and is not needed. `rotate` other
//! than 0 is refused (its sense is not confirmed by a public source), `approx.smooth` and weights are noted and
//! not used: see `smoothing`. The format was learned from sample files and from how the open program CONTACT reads
//! them.
//!
//! y grows outward; a wheel's y = 0 is its tread circle (`tread_circle` for files with another datum).

use super::super::file::OpenFile;
use super::cleaning::Sample;
use super::measured::{self, Level, Order, Reading};
use super::miniprof::{check_part, numbers};
use super::{FOLDER, Part, ProfileChoice};
use crate::settings::{Entry, Section, SettingsError};
use std::collections::BTreeMap;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "simpack",
    summary: "points of a SIMPACK file, file = \"....prw\" (wheel, needs radius) or \"....prr\"",
    reference: "sample files; reader of the open program CONTACT",
    parse,
};

const COLUMNS: &str = "y,z";

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    let file = OpenFile::open(section, FOLDER)?;
    let reading = read(&file, part)?;
    measured::profile(section, part, file, reading)
}

/// Numbers of the spline section, with their lines.
#[derive(Default)]
struct Keys(BTreeMap<String, (f64, usize)>);

impl Keys {
    fn get(&self, key: &str, other: f64) -> f64 {
        self.0.get(key).map_or(other, |found| found.0)
    }

    /// Are these bounds in use, and is `value` outside?
    fn outside(&self, axis: &str, value: f64) -> bool {
        let (low, high) = (self.get(&format!("bound.{axis}.min"), 1.0), self.get(&format!("bound.{axis}.max"), 0.0));
        low < high && !(low..=high).contains(&value)
    }
}

/// Keys with text values, or of no use here.
const PASSED_OVER: &[&str] = &["file", "comment", "units.len", "units.ang"];

fn read(file: &OpenFile, part: Part) -> Result<Reading, SettingsError> {
    match file.extension().as_str() {
        "prw" => check_part(file, 0, Part::Wheel, part)?,
        "prr" => check_part(file, 0, Part::Rail, part)?,
        _ => {}
    }
    let (mut keys, mut samples, mut notes) = (Keys::default(), Vec::new(), Vec::new());
    let mut sections: Vec<(&str, usize)> = Vec::new();
    let (mut weighted, mut points_seen) = (false, false);
    for (index, row) in file.text.lines().enumerate() {
        let line = index + 1;
        let row = row.split(['!', '%']).next().unwrap_or_default().trim();
        if row.is_empty() {
            continue;
        }
        let wrong = |problem: String| Err(file.error(line, COLUMNS, problem));
        let inside = sections.last().map_or("", |section| section.0);
        if let Some(name) = row.strip_suffix(".begin") {
            let allowed = matches!((inside, name), ("", "header" | "spline") | ("spline", "point"));
            if !allowed {
                return wrong(format!("found \"{row}\" inside \"{inside}\", expected header, spline, or point within spline"));
            }
            points_seen |= name == "point";
            sections.push((name, line));
        } else if let Some(name) = row.strip_suffix(".end") {
            if inside != name {
                return wrong(format!("found \"{row}\" inside \"{inside}\""));
            }
            sections.pop();
        } else if inside == "point" {
            let values = numbers(row).filter(|values| (2..=3).contains(&values.len()) && values.iter().all(|value| value.is_finite()));
            let Some(values) = values else { return wrong(format!("found \"{row}\", expected two or three finite numbers")) };
            weighted |= values.get(2).is_some_and(|weight| *weight != 1.0 && *weight != 0.0);
            samples.push(Sample { x: values[0], z: values[1], line });
        } else if let Some((key, value)) = row.split_once('=') {
            let (key, value) = (key.trim(), value.trim());
            if PASSED_OVER.contains(&key) {
                continue;
            }
            let Ok(number) = value.parse::<f64>() else {
                return Err(file.error(line, key, format!("found \"{value}\", expected a number")));
            };
            if inside == "header" && key == "type" {
                check_part(file, line, if number == 1.0 { Part::Wheel } else { Part::Rail }, part)?;
            } else if inside == "spline" {
                keys.0.insert(key.to_string(), (number, line));
            }
        } else {
            return wrong(format!("found \"{row}\", expected key = value"));
        }
    }
    if let Some((name, line)) = sections.last() {
        return Err(file.error(*line, COLUMNS, format!("the section {name} has no end")));
    }
    if !points_seen {
        return Err(file.error(0, COLUMNS, "no section point.begin ... point.end: is this a SIMPACK profile?"));
    }
    if let Some((_, line)) = keys.0.get("rotate").filter(|found| found.0 != 0.0) {
        return Err(file.error(*line, "rotate", "a rotation other than 0 can't be read; rotate the points, or use track.inclination"));
    }
    let unit = keys.get("units.len.f", 1.0);
    if !(unit > 0.0) {
        return Err(file.error(
            keys.0.get("units.len.f").map_or(0, |found| found.1),
            "units.len.f",
            format!("found {unit}, expected more than 0"),
        ));
    }
    if keys.get("approx.smooth", 0.0) != 0.0 {
        notes.push("approx.smooth of the file is not used; see smoothing".into());
    }
    if weighted {
        notes.push("weights of the file are not used".into());
    }
    place(&mut samples, &keys, unit, &mut notes);
    Ok(reading(samples, notes))
}

fn reading(samples: Vec<Sample>, notes: Vec<String>) -> Reading {
    Reading {
        samples,
        order: Order::Along,
        level: Level::EitherWay,
        tread_circle: 0.0,
        radius: None,
        inward: false,
        columns: COLUMNS,
        notes,
    }
}

/// Does what the keys ask for, in their order.
fn place(samples: &mut Vec<Sample>, keys: &Keys, unit: f64, notes: &mut Vec<String>) {
    let (before, near) = (samples.len(), keys.get("point.dist.min", 0.0));
    samples.dedup_by(|next, kept| (next.x - kept.x).hypot(next.z - kept.z) < near);
    for sample in samples.iter_mut() {
        sample.x += keys.get("shift.y", 0.0);
        sample.z += keys.get("shift.z", 0.0);
    }
    samples.retain(|sample| !keys.outside("y", sample.x) && !keys.outside("z", sample.z));
    if samples.len() < before {
        notes.push(format!("{} points left out as point.dist.min and bound.* of the file ask", before - samples.len()));
    }
    let sign = |key: &str| if keys.get(key, 0.0) == 1.0 { -1.0 } else { 1.0 };
    for sample in samples.iter_mut() {
        sample.x *= sign("mirror.y") / unit;
        sample.z *= sign("mirror.z") / unit;
    }
}
