//! Points of a MiniProf instrument: `.whl` (wheel), `.ban` (rail), `.mpt` (either; points or line segments).
//!
//! Lines `Key=value`, an empty line, then rows of numbers in the order that `ColumnDef` gives (default X, Y), mm.
//! `XOffset` and `YOffset` are added. A line that begins with `"`, `!`, `%` or `#` is a comment. Older files have
//! a head of free text instead of keys. `DiameterTaperline` or, in its absence, `WheelDiameterTaperline` is the
//! wheel's diameter at its taping line, which is taken for the tread circle; in mm, as all lengths there; 0 means none. A template may give its outline as `MPD1=L x0 y0 x1 y1`, ... The formats
//! were learned from sample files and from how the open program CONTACT reads them.
//!
//! Wheels: X from the flange back outward, so the tread circle is taken at 70 mm (`tread_circle`). Rails: X grows
//! toward the gauge face, as in the samples seen (`mirror` for the others); the file does not say.

use super::super::file::OpenFile;
use super::cleaning::Sample;
use super::measured::{self, FileRadius, Level, Order, Reading};
use super::{FOLDER, Part, ProfileChoice};
use crate::settings::{Entry, Section, SettingsError};

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "miniprof",
    summary: "points measured by a MiniProf instrument, file = \"....whl\" (needs radius, unless the file has a diameter) or \"....ban\"",
    reference: "sample files; reader of the open program CONTACT",
    parse,
};

const COLUMNS: &str = "X,Y";
const MM: f64 = super::drawing::MM;

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    let file = OpenFile::open(section, FOLDER)?;
    let reading = read(&file, part)?;
    measured::profile(section, part, file, reading)
}

/// Refuses the file of a wheel for a rail, and the other way round.
pub(super) fn check_part(file: &OpenFile, line: usize, found: Part, wanted: Part) -> Result<(), SettingsError> {
    let name = |part| if part == Part::Wheel { "wheel" } else { "rail" };
    if found == wanted {
        return Ok(());
    }
    Err(file.error(line, "type", format!("this is the file of a {}, expected that of a {}", name(found), name(wanted))))
}

/// The numbers of a row; `None` when a word is not a number.
pub(super) fn numbers(row: &str) -> Option<Vec<f64>> {
    row.split(|c: char| c.is_whitespace() || c == ',' || c == ';').filter(|word| !word.is_empty()).map(|word| word.parse().ok()).collect()
}

#[derive(Default)]
struct Head {
    columns: Option<Vec<String>>,
    offset: (f64, f64),
    points: Option<usize>,
    outline: Vec<Sample>,
    radius: Option<FileRadius>,
}

impl Head {
    /// Reads `key=value` of a line.
    fn take(&mut self, file: &OpenFile, line: usize, key: &str, value: &str) -> Result<(), SettingsError> {
        let number = || value.parse::<f64>().map_err(|_| file.error(line, key, format!("found \"{value}\", expected a number")));
        match key.to_lowercase().as_str() {
            "columndef" => {
                let columns: Vec<String> = value.split(',').map(|name| name.trim().to_uppercase()).collect();
                if !["X", "Y"].iter().all(|wanted| columns.iter().any(|column| column == wanted)) {
                    return Err(file.error(line, key, format!("found \"{value}\", expected a list with X and Y")));
                }
                self.columns = Some(columns);
            }
            "xoffset" if !value.is_empty() => self.offset.0 = number()?,
            "yoffset" if !value.is_empty() => self.offset.1 = number()?,
            "wheeldiametertaperline" | "diametertaperline" if !value.is_empty() => {
                let radius = 0.5 * number()? * MM;
                if radius > 0.0 && (self.radius.is_none() || key.eq_ignore_ascii_case("DiameterTaperline")) {
                    self.radius = Some(FileRadius { radius, key: key.into(), line });
                }
            }
            "xypoints" if !value.is_empty() => self.points = Some(number()? as usize),
            name if name.starts_with("mpd") && name[3..].chars().all(|c| c.is_ascii_digit()) => self.segment(file, line, key, value)?,
            _ => {}
        }
        Ok(())
    }

    /// A segment of a template's outline.
    fn segment(&mut self, file: &OpenFile, line: usize, key: &str, value: &str) -> Result<(), SettingsError> {
        let ends = value.strip_prefix('L').and_then(numbers).filter(|ends| ends.len() == 4);
        let ends = ends.ok_or_else(|| file.error(line, key, format!("found \"{value}\"; only lines, \"L x0 y0 x1 y1\", can be read")))?;
        let (from, to) = ((ends[0] * MM, ends[1] * MM), (ends[2] * MM, ends[3] * MM));
        if self.outline.last().is_none_or(|last| (last.x, last.z) != from) {
            self.outline.push(Sample { x: from.0, z: from.1, line });
        }
        self.outline.push(Sample { x: to.0, z: to.1, line });
        Ok(())
    }
}

fn read(file: &OpenFile, part: Part) -> Result<Reading, SettingsError> {
    match file.extension().as_str() {
        "whl" => check_part(file, 0, Part::Wheel, part)?,
        "ban" => check_part(file, 0, Part::Rail, part)?,
        _ => {}
    }
    let mut head = Head::default();
    let mut samples: Vec<Sample> = Vec::new();
    for (index, row) in file.text.lines().enumerate() {
        let (line, row) = (index + 1, row.trim());
        if row.is_empty() || row.starts_with(['"', '!', '%', '#']) {
            continue;
        }
        match (numbers(row), row.split_once('=')) {
            (Some(values), _) => {
                // An old head may hold a row with one number.
                let columns = head.columns.as_ref().map_or(2, Vec::len);
                if values.len() < columns {
                    if samples.is_empty() && head.columns.is_none() {
                        continue;
                    }
                    return Err(file.error(line, COLUMNS, format!("found {} columns, expected {columns}", values.len())));
                }
                let place =
                    |name: &str, other| head.columns.as_ref().and_then(|all| all.iter().position(|column| column == name)).unwrap_or(other);
                let (x, z) = (values[place("X", 0)], values[place("Y", 1)]);
                if !(x.is_finite() && z.is_finite()) {
                    return Err(file.error(line, COLUMNS, format!("found \"{row}\", expected finite numbers")));
                }
                samples.push(Sample { x: (x + head.offset.0) * MM, z: (z + head.offset.1) * MM, line });
            }
            (None, Some((key, value))) if samples.is_empty() => head.take(file, line, key.trim(), value.trim())?,
            (None, None) if samples.is_empty() => {}
            _ => return Err(file.error(line, COLUMNS, format!("found \"{row}\", expected a row of numbers"))),
        }
    }
    let mut notes = Vec::new();
    if let Some(announced) = head.points.filter(|announced| *announced != samples.len()) {
        notes.push(format!("the file announces {announced} points and holds {}", samples.len()));
    }
    if samples.is_empty() {
        samples = head.outline;
    }
    if part == Part::Rail {
        notes.push("X taken to grow toward the gauge face, as MiniProf rail files mostly have it (mirror = true for the other way)".into());
    }
    Ok(Reading {
        samples,
        order: Order::Along,
        level: Level::EitherWay,
        tread_circle: 0.07,
        radius: head.radius,
        inward: part == Part::Rail,
        columns: COLUMNS,
        notes,
    })
}
