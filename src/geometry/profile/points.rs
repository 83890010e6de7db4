//! Profile given as points in a CSV file.
//!
//! Header `u,radius` or `u,height` (wheel; heights toward the flange tip need the scene's `radius`) or `eta,height`
//! (rail). Metres, or each name followed by its unit: `u [mm],radius [mm]`; `;` or tabs separate as well, and then decimals may follow a comma. Further columns `slope`, `curvature`
//! ... are passed over, so that `wheelrail profile -o` is read back. Points may come in any order; where they run backward in places
//! and yet follow the section (undercut flanks), they are taken along it. `#` starts a
//! comment line.

use super::super::file::OpenFile;
use super::cleaning::{self, Sample};
use super::measured::{self, Level, Order, Reading};
use super::{FOLDER, Part, ProfileChoice};
use crate::settings::{CsvText, Entry, Section, SettingsError, length_title, line_of};

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

/// Reads the points; each message names file and line.
fn read(file: &OpenFile, part: Part) -> Result<Reading, SettingsError> {
    let (choices, expected): (&[(&str, &'static str, Level)], _) = match part {
        Part::Wheel => (&[("radius", "u,radius", Level::Absolute), ("height", "u,height", Level::Height)], "\"u,radius\" or \"u,height\""),
        Part::Rail => (&[("height", "eta,height", Level::Absolute)], "\"eta,height\""),
    };
    let coordinate = if part == Part::Wheel { "u" } else { "eta" };
    let mut table = CsvText::new(&file.text);
    let header = table.header().map_err(|(line, problem)| file.error(line, choices[0].1, problem))?;
    let names: Vec<_> = header.iter().map(|title| length_title(title).ok()).collect();
    let known = match names.as_slice() {
        [Some((first, x_unit)), Some((second, z_unit)), ..] if *first == coordinate => {
            choices.iter().find(|choice| choice.0 == *second).map(|choice| (choice, *x_unit, *z_unit))
        }
        _ => None,
    };
    let Some((&(_, columns, level), x_unit, z_unit)) = known else {
        let found = header.iter().collect::<Vec<_>>().join(",");
        let line = line_of(&file.text, &header);
        let problem = format!("found the header \"{found}\", expected {expected} (metres, or with their unit: [mm], [in])");
        return Err(file.error(line, choices[0].1, problem));
    };
    let mut samples = Vec::new();
    for row in table.rows(header.len()) {
        let row = row.map_err(|(line, problem)| file.error(line, columns, problem))?;
        let number = |column: usize| row.number(column).map_err(|problem| file.error(row.line, columns, problem));
        samples.push(Sample { x: x_unit * number(0)?, z: z_unit * number(1)?, line: row.line });
    }
    let order = if cleaning::come_along(&samples) { Order::Along } else { Order::Any };
    Ok(Reading { samples, order, level, tread_circle: 0.0, radius: None, inward: false, columns, notes: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::super::tests::in_folder;
    use super::*;

    #[test]
    fn equiv_separators_decimals_and_units_do_not_matter() {
        let folder = tempfile::tempdir().unwrap();
        let rail = |head: &str, row: &dyn Fn(f64, f64) -> String| {
            let rows = (-30..=30).map(|i| 1e-3 * f64::from(i)).map(|x| row(x, -x * x / 0.6));
            let text: String = std::iter::once(head.to_string()).chain(rows).map(|line| line + "\r\n").collect();
            std::fs::write(folder.path().join("rail.csv"), text).unwrap();
            in_folder(Some(folder.path()), "file = \"rail.csv\"", |section| parse(section, Part::Rail)).unwrap().profile
        };
        let plain = rail("eta,height", &|x, z| format!("{x},{z}"));
        let others = [
            rail("eta [mm];height [mm]", &|x, z| format!("{};{}", 1e3 * x, 1e3 * z).replace('.', ",")),
            rail("eta [in]\theight [cm]", &|x, z| format!("{}\t{}", x / 0.0254, 1e2 * z)),
        ];
        for x in [-0.029, -0.0104, 0.0, 0.0263] {
            for other in &others {
                assert!((other.at(x).value - plain.at(x).value).abs() < 1e-14 && (other.at(x).d2 - plain.at(x).d2).abs() < 1e-8);
            }
        }
    }
}
