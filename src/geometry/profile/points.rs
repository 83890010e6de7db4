//! Profile given as points in a CSV file, carried by a natural cubic spline (C2, three derivatives).
//!
//! Wheel files have the header `u,radius`, rail files `eta,height`, both in metres. The points may come in any
//! order; they are sorted. A `#` starts a comment line.

use super::{Part, Profile, ProfileChoice, ProfileFile, ProfilePoint};
use crate::math::spline::{CubicSpline, SplineError};
use crate::settings::{Entry, Section, SettingsError};
use std::path::Path;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "points",
    summary: "points of a CSV file (u,radius for a wheel; eta,height for a rail; metres) through a natural cubic spline",
    reference: "paper, section 3.4: cubic splines interpolate the profile data",
    parse,
};

/// A natural cubic spline through the points of a file.
#[derive(Debug, Clone)]
pub struct SplineProfile {
    spline: CubicSpline,
    points: usize,
}

impl SplineProfile {
    /// A profile through `(coordinate, value)` points [m] with increasing coordinates.
    ///
    /// # Errors
    /// [`SplineError`] for too few, unordered or non-finite points.
    pub fn through(points: &[(f64, f64)]) -> Result<Self, SplineError> {
        Ok(SplineProfile { spline: CubicSpline::natural(points)?, points: points.len() })
    }
}

impl Profile for SplineProfile {
    #[inline]
    fn at(&self, x: f64) -> ProfilePoint {
        let [value, d1, d2, d3] = self.spline.at(x);
        ProfilePoint { value, d1, d2, d3 }
    }

    fn range(&self) -> (f64, f64) {
        self.spline.range()
    }

    fn describe(&self) -> String {
        let (first, last) = self.range();
        format!("{} points from {:.1} mm to {:.1} mm", self.points, 1e3 * first, 1e3 * last)
    }
}

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    let name = section.text("file")?;
    let source = section.source();
    let Some(folder) = &source.folder else {
        return Err(section.error("file", format!("found \"{name}\", but an embedded scene has no folder: save the scene to a file first")));
    };
    let path = folder.join(&name);
    let content = std::fs::read(&path).map_err(|error| section.error("file", format!("can't read \"{}\": {error}", path.display())))?;
    let points = read(&content, &path.display().to_string(), part)?;
    let profile = SplineProfile::through(&points).map_err(|error| section.error("file", format!("\"{name}\": {error}")))?;
    Ok(ProfileChoice {
        profile: Arc::new(profile),
        file: Some(ProfileFile { key: section.full_key("file"), path: Path::new(&name).to_path_buf(), content }),
        notes: Vec::new(),
    })
}

/// Reads and sorts the points; each message names file and line.
fn read(content: &[u8], file: &str, part: Part) -> Result<Vec<(f64, f64)>, SettingsError> {
    let (first, second) = match part {
        Part::Wheel => ("u", "radius"),
        Part::Rail => ("eta", "height"),
    };
    let wrong = |line: usize, problem: String| SettingsError { file: file.into(), line, key: format!("{first},{second}"), problem };
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).flexible(true).from_reader(content);
    let header = reader.headers().map_err(|error| wrong(1, error.to_string()))?.clone();
    if header.iter().collect::<Vec<_>>() != [first, second] {
        let found = header.iter().collect::<Vec<_>>().join(",");
        return Err(wrong(1, format!("found the header \"{found}\", expected \"{first},{second}\" (metres)")));
    }
    let mut points: Vec<(f64, f64, usize)> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| wrong(error.position().map_or(0, |p| p.line() as usize), error.to_string()))?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        if record.len() != 2 {
            return Err(wrong(line, format!("found {} columns, expected 2", record.len())));
        }
        let number = |column: usize| match record[column].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(wrong(line, format!("found \"{}\", expected a finite number", &record[column]))),
        };
        points.push((number(0)?, number(1)?, line));
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some(pair) = points.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(wrong(pair[1].2, format!("{first} = {} was given before in line {}", pair[1].0, pair[0].2)));
    }
    if points.len() < 3 {
        return Err(wrong(0, format!("found {} points, expected at least 3", points.len())));
    }
    if part == Part::Wheel
        && let Some(point) = points.iter().find(|point| point.1 <= 0.0)
    {
        return Err(wrong(point.2, format!("found radius {}, expected more than 0", point.1)));
    }
    Ok(points.into_iter().map(|(x, y, _)| (x, y)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_points_are_sorted_and_comments_skipped() {
        let points = read(b"eta,height\n# head\n0.01, -1e-4\n-0.01,-1e-4\n0,0\n", "r.csv", Part::Rail).unwrap();
        assert_eq!(points, vec![(-0.01, -1e-4), (0.0, 0.0), (0.01, -1e-4)]);
    }

    #[test]
    fn hard_bad_files_are_refused_with_file_and_line() {
        let message = |text: &str| read(text.as_bytes(), "w.csv", Part::Wheel).unwrap_err().to_string();
        assert!(message("x,y\n1,2\n").starts_with("w.csv:1: u,radius: found the header \"x,y\""));
        assert!(message("u,radius\n0,0.46\n0.01,abc\n").starts_with("w.csv:3: u,radius: found \"abc\""));
        assert!(message("u,radius\n0,0.46\n0.01,nan\n").starts_with("w.csv:3: "));
        assert!(message("u,radius\n0,0.46\n0.01,0.46\n0,0.45\n").starts_with("w.csv:4: u,radius: u = 0 was given before in line 2"));
        assert!(message("u,radius\n0,0.46\n").contains("found 1 points"));
        assert!(message("u,radius\n0,0.46\n1,-0.46\n2,0.4\n").starts_with("w.csv:3: "));
    }
}
