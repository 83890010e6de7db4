//! The node table `[[track.node]]` of a scene.
//!
//! A curvature in degrees is the US degree of curvature by chord: the angle D under which a chord of 100 ft is seen from the centre of
//! the curve, `R = 50 ft / sin(D / 2)` (3 degrees: 582.192 m). A superelevation that is a length h becomes the
//! angle `asin(h / base)`, base = distance of the rails' nominal contact points. What a node does not say is zero.

use super::centre_line::{Alignment, Node, Pivot};
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// Smallest radius of a curve, m: rails must not come near the curve's centre.
const TIGHTEST: f64 = 10.0;
/// Smallest radius of a vertical curve, m: some times a wheel's, or it would stand in a sag with two places at once.
const TIGHTEST_UPRIGHT: f64 = 2.0;
/// Greatest angles of cant and grade, rad.
const STEEPEST_TRACK: f64 = 0.3;
/// Most that a line may turn in all, rad: 4000 circles. The line is cut into pieces of a quarter of a radian.
const MOST_TURN: f64 = 2.5e4;

/// Reads `node`, `smoothing` and `superelevation_about` of `[track]`; `None` without nodes. `base` [m] is the distance of the
/// rails' nominal contact points.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn parse(track: &Section, base: f64) -> Result<Option<Alignment>, SettingsError> {
    let smoothing = match track.has("smoothing") {
        true => track.not_negative("smoothing", Dimension::Length)?,
        false => 0.0,
    };
    let pivot = match track.word_or("superelevation_about", &["centre", "low_rail"], "centre")? {
        "low_rail" => Pivot::LowRail { base },
        _ => Pivot::Centre,
    };
    let sections = track.sections("node")?;
    if sections.is_empty() {
        let lonely = ["smoothing", "superelevation_about"].into_iter().find(|key| track.has(key));
        return lonely.map_or(Ok(None), |key| Err(track.error(key, "serves nothing without [[track.node]]")));
    }
    let mut nodes: Vec<Node> = Vec::with_capacity(sections.len());
    let mut turn = 0.0;
    for section in sections {
        let distance = section.number("distance", Dimension::Length)?;
        if let Some(before) = nodes.last().filter(|before| before.distance >= distance) {
            let problem = format!("found {distance:?} m behind {:?} m, expected ascending distances", before.distance);
            return Err(section.error("distance", problem));
        }
        let (curvature, grade) = (curvature(&section)?, grade(&section)?);
        if let Some(before) = nodes.last() {
            turn += (distance - before.distance) * curvature.abs().max(before.curvature.abs());
            let (change, length) = ((grade - before.grade).abs(), (distance - before.distance).max(smoothing));
            if change * TIGHTEST_UPRIGHT > length {
                let problem = format!(
                    "the grade changes by {change:.4} rad within {length:.4} m, a vertical curve of {:.2} m; expected a radius of at least {TIGHTEST_UPRIGHT} m: nodes that are farther apart, or track.smoothing",
                    length / change
                );
                return Err(section.error("grade", problem));
            }
        }
        if turn > MOST_TURN {
            let problem =
                format!("until here the track turns by more than {MOST_TURN:?} rad; expected a shorter curve or a greater radius");
            return Err(section.error("distance", problem));
        }
        nodes.push(Node { distance, curvature, superelevation: superelevation(&section, base)?, grade });
        section.finish()?;
    }
    Ok(Some(Alignment { nodes, smoothing, pivot }))
}

/// `curvature` or `radius`, 1/m.
fn curvature(section: &Section) -> Result<f64, SettingsError> {
    let (key, curvature) = match (section.has("curvature"), section.has("radius")) {
        (true, true) => return Err(section.error("radius", "stands beside curvature; expected one of them")),
        (_, true) => ("radius", 1.0 / section.number_or_infinity("radius", Dimension::Length)?),
        _ => ("curvature", section.number_or("curvature", Dimension::Curvature, 0.0)?),
    };
    if curvature.abs() <= 1.0 / TIGHTEST {
        return Ok(curvature);
    }
    Err(section.error(key, format!("found a radius of {:.3} m, expected at least {TIGHTEST} m", 1.0 / curvature)))
}

/// Angle of the cant, rad, from a height or an angle, under either of its names. A number other than zero must say which of both it is: 0.08
/// is 80 mm (3.06 deg on a base of 1.5 m) or 0.08 rad (4.58 deg).
fn superelevation(section: &Section, base: f64) -> Result<f64, SettingsError> {
    const KEYS: [&str; 2] = ["superelevation", "cant"];
    let key = match KEYS.map(|key| section.has(key)) {
        [true, true] => {
            return Err(section.error("cant", "is another name of superelevation, which stands beside it; expected one of them"));
        }
        [_, true] => KEYS[1],
        _ => KEYS[0],
    };
    let given = section.text(key);
    let is_angle = |text: &str| Dimension::Length.parse(text).is_none() && Dimension::Angle.parse(text).is_some();
    let angle = if given.as_ref().is_ok_and(|text| is_angle(text)) {
        section.number(key, Dimension::Angle)?
    } else {
        let height = section.number_or(key, Dimension::Length, 0.0)?;
        let bare = given.map_or(true, |text| text.trim().parse::<f64>().is_ok());
        if bare && height != 0.0 {
            let (millimetres, degrees) = ((1e9 * height).round() / 1e6, height.to_degrees());
            let problem = format!(
                "found {height:?} without a unit, which may be a height or an angle; expected one of \"{millimetres} mm\" (of one rail over the other) and \"{height:?} rad\" ({degrees:.2} deg)"
            );
            return Err(section.error(key, problem));
        }
        (height / base).asin()
    };
    if angle.abs() <= STEEPEST_TRACK {
        return Ok(angle);
    }
    let expected = format!("at most {:.3} m or {STEEPEST_TRACK} rad either way", base * STEEPEST_TRACK.sin());
    Err(section.error(key, format!("one rail would stand too high over the other; expected {expected}, a height or an angle (\"2 deg\")")))
}

/// Angle of the `grade` of a section, rad, from a slope or an angle.
///
/// # Errors
/// [`SettingsError`] with file and line.
pub fn grade(section: &Section) -> Result<f64, SettingsError> {
    const KEY: &str = "grade";
    let is_angle = |text: &str| Dimension::None.parse(text).is_none() && Dimension::Angle.parse(text).is_some();
    let angle = match section.text(KEY) {
        Ok(text) if is_angle(&text) => section.number(KEY, Dimension::Angle)?,
        _ => section.number_or(KEY, Dimension::None, 0.0)?.atan(),
    };
    if angle.abs() <= STEEPEST_TRACK {
        return Ok(angle);
    }
    Err(section.error(
        KEY,
        format!(
            "found {:.3} % ({angle:.4} rad), expected at most {STEEPEST_TRACK} rad ({:.0} %), a slope (0.01, \"1 %\") or an angle (\"0.5 deg\")",
            100.0 * angle.tan(),
            100.0 * STEEPEST_TRACK.tan()
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Source;

    fn read(text: &str) -> Result<Option<Alignment>, SettingsError> {
        let source = Source { file: "a.toml".into(), text: text.into(), overridden: vec![], folder: None };
        let document = toml_edit::Document::parse(text.to_string()).unwrap();
        parse(&Section::root(document.as_table(), &source), 1.5)
    }

    #[test]
    fn analytic_units_of_nodes() {
        let read = read(concat!(
            "smoothing = \"30 ft\"\nsuperelevation_about = \"low_rail\"\n",
            "[[node]]\ndistance = 0\n",
            "[[node]]\ndistance = \"100 ft\"\ncurvature = \"3 deg\"\nsuperelevation = \"-3 in\"\ngrade = \"1 %\"\n",
            "[[node]]\ndistance = \"1 km\"\nradius = \"-500 m\"\ncant = \"2 deg\"\ngrade = \"0.5 deg\"\n",
            "[[node]]\ndistance = 2000.0\nradius = inf\ngrade = 0.01\n",
            "[[node]]\ndistance = 3000.0\ncurvature = \"0.001 1/m\"\n",
        ));
        let alignment = read.unwrap().unwrap();
        assert!((alignment.smoothing - 9.144).abs() < 1e-12 && alignment.pivot == Pivot::LowRail { base: 1.5 });
        let expected = [
            (0.0, 0.0, 0.0, 0.0),
            (30.48, 1.0 / 582.192, (-0.0762f64 / 1.5).asin(), 0.01f64.atan()),
            (1000.0, -0.002, 2f64.to_radians(), 0.5f64.to_radians()),
            (2000.0, 0.0, 0.0, 0.01f64.atan()),
            (3000.0, 0.001, 0.0, 0.0),
        ];
        for (node, (distance, curvature, cant, grade)) in alignment.nodes.iter().zip(expected) {
            assert!((node.distance - distance).abs() < 1e-12, "{node:?}");
            assert!((node.curvature - curvature).abs() <= 1e-6 * curvature.abs(), "{node:?}");
            assert!((node.superelevation - cant).abs() < 1e-15 && (node.grade - grade).abs() < 1e-15, "{node:?}");
        }
        assert_eq!(alignment.nodes.len(), 5);
    }

    /// The chord definition: 50 ft / sin(1.5 degrees) = 582.192 m (published: 1910.08 ft).
    #[test]
    fn validate_three_degrees_of_curvature() {
        let radius = 1.0 / Dimension::Curvature.parse("3 deg").unwrap();
        assert!((radius - 582.192).abs() < 5e-4 && (radius / 0.3048 - 1910.08).abs() < 5e-3, "{radius}");
    }

    #[test]
    fn prop_messages_name_file_and_line() {
        let message = |text: &str| read(text).unwrap_err().to_string();
        let found = message("[[node]]\ndistance = 10\n[[node]]\ndistance = 10\n");
        assert_eq!(found, "a.toml:4: node[2].distance: found 10.0 m behind 10.0 m, expected ascending distances");
        assert!(message("[[node]]\ndistance = 0\nradius = 5\n").starts_with("a.toml:3: node[1].radius: found a radius of 5.000 m"));
        assert!(message("[[node]]\ndistance = 0\nradius = 0\n").starts_with("a.toml:3: node[1].radius"));
        assert!(message("[[node]]\ndistance = 0\ngrade = \"50 %\"\n").starts_with("a.toml:3: node[1].grade"));
        // A sag that is sharper than a wheel; a mean over 0.1 m rounds it to 10 m.
        let kink = "[[node]]\ndistance = 0\n[[node]]\ndistance = 0.01\ngrade = 0.01\n";
        assert!(message(kink).contains("a vertical curve of 1.00 m"), "{}", message(kink));
        assert!(read(&format!("smoothing = 0.1\n{kink}")).is_ok());
        // 0.08 alone has two meanings, and both are shown; zero has one.
        for key in ["superelevation", "cant"] {
            for (number, both) in [("0.08", ["\"80 mm\"", "\"0.08 rad\""]), ("\"-0.053\"", ["\"-53 mm\"", "\"-0.053 rad\""])] {
                let found = message(&format!("[[node]]\ndistance = 0\n{key} = {number}\n"));
                assert!(
                    found.starts_with(&format!("a.toml:3: node[1].{key}: found")) && both.iter().all(|way| found.contains(way)),
                    "{found}"
                );
            }
            assert!(read(&format!("[[node]]\ndistance = 0\n{key} = 0\n[[node]]\ndistance = 1\n{key} = 0.0\n")).is_ok());
        }
        assert!(message("[[node]]\ndistance = 0\ncant = \"1 deg\"\nsuperelevation = \"1 deg\"\n").contains("cant: is another name"));
        assert!(message("[[node]]\ndistance = 0\nsuperelevation = \"2 m\"\n").starts_with("a.toml:3: node[1].superelevation"));
        assert!(
            message("[[node]]\ndistance = 0\ncurvature = \"3 ft\"\n").contains("expected a number in 1/m; a string may carry 1/km, deg")
        );
        assert!(message("smoothing = 3\n").starts_with("a.toml:1: smoothing: serves nothing"));
        assert!(
            message("[[node]]\ndistance = 0\ncurvature = 0.001\nradius = 1000\n").starts_with("a.toml:4: node[1].radius: stands beside")
        );
    }
}
