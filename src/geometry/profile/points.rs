//! Profile given as points in a CSV file.
//!
//! Header `u,radius` or `u,height` (wheel; heights toward the flange tip need the scene's `radius`) or `eta,height`
//! (rail). Metres, or each name followed by its unit: `u [mm],radius [mm]`. Further columns `slope`, `curvature`
//! ... are passed over, so that `wheelrail profile -o` is read back. Points may come in any order; where they run backward in places
//! and yet follow the section (undercut flanks), they are taken along it. `#` starts a
//! comment line.

use super::super::file::OpenFile;
use super::cleaning::{self, Sample};
use super::measured::{self, Level, Order, Reading};
use super::{FOLDER, Part, ProfileChoice};
use crate::settings::{Entry, Section, SettingsError, line_of};

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "points",
    summary: "points of a CSV file (u,radius or u,height for a wheel; eta,height for a rail; metres) through a natural cubic spline",
    reference: "paper, section 3.4: cubic splines interpolate the profile data",
    parse,
};

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    let file = OpenFile::open(section, FOLDER)?;
    let reading = read(&file, part)?;
    measured::profile(section, part, file, reading)
}

/// A column's name and its unit in metres.
fn column(title: &str) -> Option<(&str, f64)> {
    let Some((name, unit)) = title.split_once('[') else { return Some((title, 1.0)) };
    match unit.strip_suffix(']')?.trim() {
        "m" => Some((name.trim(), 1.0)),
        "mm" => Some((name.trim(), 1e-3)),
        _ => None,
    }
}

/// Reads the points; each message names file and line.
fn read(file: &OpenFile, part: Part) -> Result<Reading, SettingsError> {
    let (choices, expected): (&[(&str, &'static str, Level)], _) = match part {
        Part::Wheel => (&[("radius", "u,radius", Level::Absolute), ("height", "u,height", Level::Height)], "\"u,radius\" or \"u,height\""),
        Part::Rail => (&[("height", "eta,height", Level::Absolute)], "\"eta,height\""),
    };
    let coordinate = if part == Part::Wheel { "u" } else { "eta" };
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).flexible(true).from_reader(file.text.as_bytes());
    let header = reader.headers().map_err(|error| file.error(1, choices[0].1, error.to_string()))?.clone();
    let names: Vec<_> = header.iter().map(column).collect();
    let known = match names.as_slice() {
        [Some((first, x_unit)), Some((second, z_unit)), ..] if *first == coordinate => {
            choices.iter().find(|choice| choice.0 == *second).map(|choice| (choice, *x_unit, *z_unit))
        }
        _ => None,
    };
    let Some((&(_, columns, level), x_unit, z_unit)) = known else {
        let found = header.iter().collect::<Vec<_>>().join(",");
        let line = line_of(&file.text, &header);
        let problem = format!("found the header \"{found}\", expected {expected} (metres, or with [mm])");
        return Err(file.error(line, choices[0].1, problem));
    };
    let mut samples = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| file.error(error.position().map_or(0, |p| p.line() as usize), columns, error.to_string()))?;
        let line = line_of(&file.text, &record);
        if record.len() != header.len() {
            return Err(file.error(line, columns, format!("found {} columns, expected {}", record.len(), header.len())));
        }
        let number = |column: usize| match record[column].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(file.error(line, columns, format!("found \"{}\", expected a finite number", &record[column]))),
        };
        samples.push(Sample { x: x_unit * number(0)?, z: z_unit * number(1)?, line });
    }
    let order = if cleaning::come_along(&samples) { Order::Along } else { Order::Any };
    Ok(Reading { samples, order, level, tread_circle: 0.0, radius: None, inward: false, columns, notes: Vec::new() })
}
