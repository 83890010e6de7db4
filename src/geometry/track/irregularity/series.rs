//! Measured irregularities from a CSV file.
//!
//! The header names the columns, each with its unit: `distance [m],alignment [mm],gauge [mm]`; without a unit it is in metres. `distance` and
//! at least one more: `alignment`, `longitudinal_level`, `cross_level`, `gauge` (signs as in the parent module; all are deviations
//! from the design, the gauge too), or, instead of the first and the last, `left_lateral`, `right_lateral` (left positive) and, instead
//! of the two in the middle, `left_vertical`, `right_vertical` (up positive). Positions may be uneven and must increase. `#` begins a
//! comment line; a header with `;` or tabs separates by these, and decimals may then follow a comma.
//!
//! Natural cubic splines carry the rails' displacements: value, slope and second derivative are continuous, the third jumps at the
//! points. Where they would leave the points too far the series is refused (`overshoot`); with `interpolation = "monotone"` lines go from point to point
//! ([`MonotoneSpline`]), for tables made by hand. A [`Window`] takes them to zero at both ends. `smoothing` is the root-mean-square distance by which a cubic smoothing
//! spline may move the values of each column; without it they are interpolated. Lookup takes constant time where positions are
//! about even (an index table with a cell for each point, up to 65536).

use super::super::deviation::STEEPEST_RAIL;
use super::doubts;
use super::overshoot::{self, Overshoot};
use super::resolved::resolved;
use super::window::{Spline, Window, Windowed};
use super::{Irregularity, Quantity, deviations};
use crate::geometry::file::OpenFile;
use crate::geometry::track::DeviationShape;
use crate::math::monotone_spline::MonotoneSpline;
use crate::math::smoothing::{Reach, smooth};
use crate::math::spline::{CubicSpline, SplineError};
use crate::settings::{CsvText, Entry, Section, SettingsError, did_you_mean, length_title, line_of};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "series",
    summary: "measured: columns of a CSV `file` (distance and alignment, longitudinal_level, cross_level, gauge, or left/right_lateral/vertical)",
    reference: "quantities of EN 13848-1, as deviations from the design",
    parse,
};

/// Folder of an FMU's resources in which measured series lie.
const FOLDER: &str = "irregularities";
/// Names that a header may have; the four of [`Quantity::NAMES`] come first after the distance, in their order.
const COLUMNS: [&str; 9] = [
    "distance",
    "alignment",
    "longitudinal_level",
    "cross_level",
    "gauge",
    "left_lateral",
    "right_lateral",
    "left_vertical",
    "right_vertical",
];
/// Columns of the left and the right rail, and the quantities of their mean and difference, that exclude each other.
const RAILS: [([usize; 2], [usize; 2]); 2] = [([5, 6], [1, 4]), ([7, 8], [2, 3])];
/// Fewest points.
const LEAST_POINTS: usize = 4;
/// No irregularity is larger, m: another unit, or the gauge itself.
const LARGEST: f64 = 0.5;
/// Length over which a series begins and ends unless the scene says otherwise, m.
const FADE: f64 = 10.0;

/// The columns of a file, SI; in the order of [`COLUMNS`].
struct Table {
    columns: [Option<Vec<f64>>; 9],
}

impl Table {
    /// Those that the file has, with their names.
    fn named(&self) -> impl Iterator<Item = (&'static str, &Vec<f64>)> {
        COLUMNS.into_iter().zip(&self.columns).filter_map(|(name, values)| Some((name, values.as_ref()?)))
    }
}

fn parse(section: &Section) -> Result<Irregularity, SettingsError> {
    let file = OpenFile::open(section, FOLDER)?;
    let offset = section.number_or("offset", Dimension::Length, 0.0)?;
    let scale = section.number_or("scale", Dimension::None, 1.0)?;
    let mut table = read(&file)?;
    let mut positions = table.columns[0].take().unwrap_or_default();
    positions.iter_mut().for_each(|position| *position += offset);
    let (mut smoothed, mut doubts) = (String::new(), Vec::new());
    for (name, values) in table.named() {
        doubts.extend(doubts::of_size(name, values, scale, &positions));
    }
    if section.has("smoothing") {
        let rms = section.positive("smoothing", Dimension::Length)?;
        for (name, column) in COLUMNS.iter().zip(&mut table.columns).filter_map(|(name, column)| Some((name, column.as_mut()?))) {
            let points: Vec<(f64, f64)> = positions.iter().copied().zip(column.iter().copied()).collect();
            let found = smooth(&points, Reach::RootMeanSquare(rms)).ok_or_else(|| section.error("smoothing", "needs 4 points or more"))?;
            let left: Vec<f64> = found.points.iter().map(|point| point.1).collect();
            doubts.extend(doubts::of_smoothing(name, column, &left));
            // Along the track points move by the slope's share of what they move across: nothing.
            *column = left;
        }
        smoothed = format!(", smoothed by {:.4} mm rms", 1e3 * rms);
    }

    let (first, last) = (positions[0], positions[positions.len() - 1]);
    let furthest = Dimension::Length.largest();
    if !(first >= -furthest && last <= furthest) {
        let problem =
            format!("the file reaches from {first:e} m to {last:e} m (`offset` counted), expected at most {furthest:e} m either way");
        return Err(file.error(0, COLUMNS[0], problem));
    }
    let from = section.number_or("from", Dimension::Length, first)?;
    let to = section.number_or("to", Dimension::Length, last)?;
    for (key, value) in [("from", from), ("to", to)] {
        if !(first..=last).contains(&value) {
            return Err(section.error(key, format!("found {value} m, but the file reaches from {first} m to {last} m (`offset` counted)")));
        }
    }
    let window = Window::read(section, from, to, FADE)?;
    let name = file.kept.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let description = format!("series of {} points in {name}{smoothed}, {}", positions.len(), window.describe());
    let monotone = section.has("interpolation") && section.word("interpolation", &["spline", "monotone"])? == "monotone";
    let description = if monotone { format!("{description}, monotone between points") } else { description };
    if !monotone {
        no_inventions(&file, &positions, &table, &window)?;
    }
    doubts.extend(doubts::of_spacing(&positions, !monotone));
    doubts.iter_mut().for_each(|doubt| *doubt = format!("{name}: {doubt}"));
    let quantities = quantities(table);
    let deviations = deviations(&quantities, |_, _, values| {
        let points: Vec<(f64, f64)> = positions.iter().zip(values).map(|(&position, value)| (position, scale * value)).collect();
        let wrong = |error: SplineError| file.error(0, COLUMNS[0], error.to_string());
        let laid = (window, description.clone());
        Ok(if monotone {
            // A quintic does more between two points than a cubic.
            let finer: Vec<f64> = positions
                .windows(2)
                .flat_map(|pair| [0.0, 0.25, 0.5, 0.75].map(|x| pair[0] + x * (pair[1] - pair[0])))
                .chain([last])
                .collect();
            lay(MonotoneSpline::new(&points).map_err(wrong)?, laid, &finer)
        } else {
            lay(CubicSpline::natural(&points).map_err(wrong)?, laid, &positions)
        })
    })?;
    Ok(Irregularity { deviations, file: Some(file.kept), doubts })
}

/// Does the spline of each column stay near its points?
fn no_inventions(file: &OpenFile, positions: &[f64], table: &Table, window: &Window) -> Result<(), SettingsError> {
    for (name, values) in table.named() {
        let points: Vec<(f64, f64)> = positions.iter().copied().zip(values.iter().copied()).collect();
        let spline = CubicSpline::natural(&points).map_err(|error| file.error(0, COLUMNS[0], error.to_string()))?;
        if let Some(found) = overshoot::worst(&spline, &points, (window.from, window.to)).filter(|found| found.part > 1.0) {
            return Err(file.error(0, name, invented(&found)));
        }
    }
    Ok(())
}

/// A line under its window.
fn lay<S: Spline + 'static>(spline: S, (window, description): (Window, String), knots: &[f64]) -> Arc<dyn DeviationShape> {
    let mut shape = Windowed { spline, window, description, waves: Vec::new() };
    shape.waves = resolved(&shape, window.from, window.to, knots);
    Arc::new(shape)
}

/// Why a series is refused between whose points a spline makes something else.
fn invented(found: &Overshoot) -> String {
    let Overshoot { from, to, invented, measured, .. } = found;
    format!(
        "a cubic spline would make {:.2} mm between the points at {from} m and {to} m, where those around reach {:.2} mm; expected points that stand more evenly, or interpolation = \"monotone\", \
         which goes from point to point, or the parts before and behind as a series each (`from`, `to`)",
        1e3 * invented,
        1e3 * measured
    )
}

/// The four quantities, of the rails' own columns where these are given; a rail without a column stays where it is.
fn quantities(mut table: Table) -> [Option<Vec<f64>>; 4] {
    for ([left, right], [mean, difference]) in RAILS {
        let (left, right) = (table.columns[left].take(), table.columns[right].take());
        let Some(length) = left.as_ref().or(right.as_ref()).map(Vec::len) else { continue };
        let (left, right) = (left.unwrap_or(vec![0.0; length]), right.unwrap_or(vec![0.0; length]));
        table.columns[mean] = Some(left.iter().zip(&right).map(|(l, r)| 0.5 * (l + r)).collect());
        table.columns[difference] = Some(left.iter().zip(&right).map(|(l, r)| l - r).collect());
    }
    Quantity::ALL.map(|quantity| table.columns[1 + quantity.index()].take())
}

/// Which column of [`COLUMNS`] a title names, and its unit, m.
fn title(text: &str) -> Result<(usize, f64), String> {
    let name = text.split_once('[').map_or(text, |title| title.0).trim();
    let Some(column) = COLUMNS.iter().position(|known| *known == name) else {
        let names = COLUMNS.join(", ");
        return Err(format!("found the column \"{name}\"{}, expected some of {names}", did_you_mean(name, &COLUMNS)));
    };
    Ok((column, length_title(text)?.1))
}

/// Reads and checks the columns; each message names file and line.
fn read(file: &OpenFile) -> Result<Table, SettingsError> {
    let mut table = CsvText::new(&file.text);
    let wrong = |(line, problem): (usize, String)| file.error(line, COLUMNS[0], problem);
    let header = table.header().map_err(wrong)?;
    let wrong_header = |problem: String| file.error(line_of(&file.text, &header), "header", problem);
    let titles = header.iter().map(title).collect::<Result<Vec<_>, _>>().map_err(wrong_header)?;
    check_titles(&titles).map_err(wrong_header)?;

    let mut columns: [Option<Vec<f64>>; 9] = Default::default();
    titles.iter().for_each(|title| columns[title.0] = Some(Vec::new()));
    let mut count = 0;
    for row in table.rows(titles.len()) {
        let row = row.map_err(wrong)?;
        for (place, (column, unit)) in titles.iter().enumerate() {
            let value = row.number(place).map_err(|problem| file.error(row.line, COLUMNS[*column], problem))?;
            columns[*column].get_or_insert_default().push(unit * value);
        }
        check_row(&columns, count).map_err(|(column, problem)| file.error(row.line, COLUMNS[column], problem))?;
        count += 1;
    }
    if count < LEAST_POINTS {
        return Err(file.error(0, COLUMNS[0], format!("found {count} points, expected at least {LEAST_POINTS}")));
    }
    Ok(Table { columns })
}

/// A distance, something else, nothing twice, and no quantity in two ways.
fn check_titles(titles: &[(usize, f64)]) -> Result<(), String> {
    let has = |column: usize| titles.iter().any(|title| title.0 == column);
    if let Some(twice) = (0..COLUMNS.len()).find(|column| titles.iter().filter(|title| title.0 == *column).count() > 1) {
        return Err(format!("found the column \"{}\" twice", COLUMNS[twice]));
    }
    if !has(0) || titles.len() < 2 {
        return Err("expected a column \"distance\" and at least one more".into());
    }
    for (rails, quantities) in RAILS {
        if let (Some(rail), Some(quantity)) = (rails.into_iter().find(|c| has(*c)), quantities.into_iter().find(|c| has(*c))) {
            return Err(format!("found \"{}\" beside \"{}\", which say the same; expected one of them", COLUMNS[rail], COLUMNS[quantity]));
        }
    }
    Ok(())
}

/// The row read last: distance ahead of the one before, values and slopes as irregularities have.
fn check_row(columns: &[Option<Vec<f64>>; 9], row: usize) -> Result<(), (usize, String)> {
    let values = |column: usize| columns[column].as_deref().unwrap_or_default();
    let position = values(0)[row];
    let before = row.checked_sub(1).map(|row| (row, values(0)[row]));
    if let Some((_, previous)) = before
        && !(position > previous)
    {
        return Err((0, format!("found {position} m after {previous} m, expected increasing distances")));
    }
    for column in (1..COLUMNS.len()).filter(|column| columns[*column].is_some()) {
        let value = values(column)[row];
        if value.abs() > LARGEST {
            let hint = if column == 4 { "another unit, or the gauge itself in place of its deviation?" } else { "another unit?" };
            return Err((column, format!("found {value} m, expected at most {LARGEST} m: {hint}")));
        }
        if let Some((row, previous)) = before {
            let slope = (value - values(column)[row]) / (position - previous);
            if slope.abs() > STEEPEST_RAIL {
                return Err((column, format!("rises by {slope:.2} m per metre; expected at most {STEEPEST_RAIL}: an outlier?")));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Side;
    use crate::geometry::track::Direction;
    use crate::settings::Source;

    /// Reads a series with these settings and this file.
    fn read_series(settings: &str, content: &str) -> Result<Irregularity, SettingsError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.csv"), content).unwrap();
        let text = format!("kind = \"series\"\nfile = \"m.csv\"\n{settings}");
        let source = Source { file: "a.toml".into(), text: text.clone(), overridden: vec![], folder: Some(folder.path().into()) };
        let document = toml_edit::Document::parse(text).unwrap();
        super::super::parse(Section::root(document.as_table(), &source))
    }

    fn at(irregularity: &Irregularity, side: Side, direction: Direction, s: f64) -> [f64; 4] {
        irregularity.deviations.iter().find(|d| d.side == side && d.direction == direction).unwrap().shape.at(s)
    }

    #[test]
    fn hard_a_table_made_by_hand_is_refused_or_goes_from_point_to_point() {
        let content = "distance [m],gauge [mm]\n0,0\n30,0\n60,0\n60.5,8\n70,8\n70.5,0\n100,0\n130,0\n";
        let refused = read_series("", content).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(
            refused.contains("m.csv: gauge: a cubic spline would make") && refused.contains("interpolation = \"monotone\""),
            "{refused}"
        );
        let track = read_series("interpolation = \"monotone\"\n", content).unwrap();
        let left = |s: f64| at(&track, Side::Left, Direction::Lateral, s)[0];
        assert!(
            (0..1300).all(|k| (-1e-15..4e-3 + 1e-15).contains(&left(0.1 * f64::from(k))))
                && (left(65.0) - 4e-3).abs() < 1e-15
                && left(50.0) == 0.0
        );
        // Steps see the half metre over which it widens.
        let shape = &track.deviations[0].shape;
        let waves = crate::geometry::track::waves::Waves::new(shape.waves());
        assert!(waves.reach(40.0, 1.0) < 20.5 && waves.reach(60.1, 1.0) < 0.3, "{} {}", waves.reach(40.0, 1.0), waves.reach(60.1, 1.0));
    }

    #[test]
    fn prop_other_units_and_smoothing_that_flattens_are_doubted() {
        let with = |settings: &str, apart: f64, size: f64, title: &str| {
            let rows = (0..100).map(|k| format!("{},{:e}\n", apart * f64::from(k), size * (0.4 * f64::from(k)).sin()));
            read_series(settings, &format!("distance [m],{title}\n{}", rows.collect::<String>())).unwrap().doubts
        };
        let named = |found: Vec<String>, words: &str| assert!(found.len() == 1 && found[0].contains(words), "{found:?}");
        assert_eq!(with("", 0.25, 3.0, "cross_level [mm]"), Vec::<String>::new());
        assert_eq!(with("smoothing = \"0.2 mm\"\n", 0.25, 3.0, "cross_level [mm]"), Vec::<String>::new());
        // Roughness.
        assert_eq!(with("", 1e-3, 1e-3, "left_vertical [mm]"), Vec::<String>::new());
        named(with("", 250.0, 3.0, "cross_level [mm]"), "m.csv: its points stand 250 m apart");
        named(with("", 0.25, 3e-3, "cross_level [mm]"), "cross_level moves by 6.00e-3 mm");
        assert_eq!(with("scale = 1000\n", 0.25, 3e-3, "cross_level [mm]"), Vec::<String>::new());
        named(with("smoothing = \"1.5 mm\"\n", 0.25, 3.0, "cross_level [mm]"), "it flattens what was measured");
    }

    #[test]
    fn hard_a_series_with_a_hole_is_refused_unless_it_lies_outside() {
        let rows = (0..400).map(|k| 0.25 * f64::from(k)).filter(|s| !(40.1..70.1).contains(s));
        let lines = rows.map(|s| format!("{s},{}\n", 2.0 * (0.9 * s).sin() + (0.31 * s).cos()));
        let content = format!("distance [m],cross_level [mm]\n{}", lines.collect::<String>());
        let refused = read_series("", &content).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("between the points at 40 m and 70.25 m") && refused.contains("cross_level"), "{refused}");
        assert!(read_series("to = 39.0\n", &content).is_ok());
    }

    /// Uneven positions between 0 and 100 m.
    fn position(i: usize, n: usize) -> f64 {
        let t = i as f64 / n as f64;
        100.0 * (t + 0.02 * (40.0 * t).sin() * t * (1.0 - t))
    }

    fn alignment(s: f64) -> f64 {
        3e-3 * (0.35 * s).sin()
    }

    fn gauge(s: f64) -> f64 {
        2e-3 * (0.5 * s).cos()
    }

    fn file(n: usize) -> String {
        let rows = (0..=n).map(|i| position(i, n)).map(|s| format!("{},{s:.12},{:.12}\n", 1e3 * gauge(s), 1e3 * alignment(s)));
        format!("# car 7\ngauge [mm], distance [m], alignment [mm]\n{}", rows.collect::<String>())
    }

    #[test]
    fn analytic_rails_from_alignment_and_gauge() {
        let error = |n: usize| {
            let track = read_series("fade = 5\noffset = 1000\n", &file(n)).unwrap();
            assert_eq!(track.deviations.len(), 2);
            assert_eq!(track.file.as_ref().unwrap().folder, "irregularities");
            let at_place = |i: i32, side: Side| {
                let s = 6.0 + 88.0 * f64::from(i) / 999.0;
                let exact = alignment(s) + 0.5 * side.sign() * gauge(s);
                (at(&track, side, Direction::Lateral, s + 1000.0)[0] - exact).abs()
            };
            (0..1000).flat_map(|i| Side::BOTH.map(|side| at_place(i, side))).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(100), error(400));
        println!("largest error {coarse:.2e} m with 1 m, {fine:.2e} m with 0.25 m between points");
        assert!(coarse < 2e-6 && (coarse / fine).log2() / 2.0 > 3.7);
    }

    #[test]
    fn prop_two_derivatives_are_continuous_at_points_and_ends() {
        let n = 100;
        let track = read_series("", &file(n)).unwrap();
        for deviation in &track.deviations {
            let near = |s: f64| (deviation.shape.at(s - 1e-8), deviation.shape.at(s + 1e-8));
            for i in 0..=n {
                let (before, after) = near(position(i, n));
                for d in 0..3 {
                    assert!((before[d] - after[d]).abs() < 1e-9, "{i} {d}: {before:?} {after:?}");
                }
            }
            for s in [-1.0, 0.0, 100.0, 101.0] {
                assert_eq!(deviation.shape.at(s), [0.0; 4]);
            }
            let h = 1e-4;
            for s in [3.3, 9.99, 44.4, 95.0] {
                for d in 0..3 {
                    let slope = (deviation.shape.at(s + h)[d] - deviation.shape.at(s - h)[d]) / (2.0 * h);
                    assert!((slope - deviation.shape.at(s)[d + 1]).abs() < 1e-7, "{s} {d}");
                }
            }
            assert!(deviation.shape.breaks().is_empty());
        }
    }

    #[test]
    fn equiv_columns_of_rails_and_columns_of_quantities() {
        let rows = |row: &dyn Fn(f64) -> [f64; 2]| -> String {
            (0..50).map(f64::from).map(|s| (s, row(s))).map(|(s, [a, b])| format!("{s};{a};{b}\n")).collect()
        };
        let level = |s: f64| 4e-3 * (0.2 * s).sin();
        let cross = |s: f64| 3e-3 * (0.3 * s).cos();
        let rails = read_series(
            "",
            &format!("distance;left_vertical;right_vertical\n{}", rows(&|s| { [level(s) + 0.5 * cross(s), level(s) - 0.5 * cross(s)] })),
        )
        .unwrap();
        let quantities = read_series("", &format!("distance;longitudinal_level;cross_level\n{}", rows(&|s| [level(s), cross(s)]))).unwrap();
        for side in Side::BOTH {
            for s in [4.0, 20.3, 45.0] {
                let pair = [&rails, &quantities].map(|track| at(track, side, Direction::Vertical, s));
                assert!((0..4).all(|d| (pair[0][d] - pair[1][d]).abs() < 1e-14), "{pair:?}");
            }
        }
        // One rail alone: the other stays.
        let one = read_series("", &format!("distance;left_vertical;left_lateral\n{}", rows(&|s| [level(s), cross(s)]))).unwrap();
        assert!((at(&one, Side::Left, Direction::Lateral, 20.0)[0] - cross(20.0)).abs() < 1e-15);
        assert!(at(&one, Side::Right, Direction::Vertical, 20.0)[0].abs() < 1e-15);
    }

    #[test]
    fn prop_smoothing_takes_noise_away() {
        let noise = |i: u32| 2e-4 * (f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1u32 << 24) - 0.5);
        let rows: String =
            (0..800).map(|i| (0.25 * f64::from(i), noise(i * i + 7))).map(|(s, e)| format!("{s},{}\n", alignment(s) + e)).collect();
        let content = format!("distance,alignment\n{rows}");
        let error = |settings: &str| {
            let track = read_series(settings, &content).unwrap();
            let squares = (0..700)
                .map(|i| 12.0 + 0.25 * f64::from(i))
                .map(|s| (at(&track, Side::Left, Direction::Lateral, s)[0] - alignment(s)).powi(2));
            (squares.sum::<f64>() / 700.0).sqrt()
        };
        let (raw, smooth) = (error(""), error("smoothing = \"0.055 mm\"\n"));
        println!("rms error {:.4} mm as measured, {:.4} mm smoothed", 1e3 * raw, 1e3 * smooth);
        assert!(raw > 5e-5 && smooth < 0.5 * raw);
    }

    #[test]
    fn hard_bad_files_are_named_with_their_line() {
        let good = "distance [m],alignment [mm],gauge [mm]\n0,1,0\n1,1,0\n2,1,0\n3,1,0\n4,1,0\n";
        assert!(read_series("", good).is_ok());
        for (from, to, message) in [
            ("distance [m]", "distanse [m]", "m.csv:1: header: found the column \"distanse\" (did you mean \"distance\"?)"),
            ("alignment [mm]", "alignment [kg]", "m.csv:1: header: found \"alignment [kg]\", expected a unit"),
            ("alignment [mm]", "alignment mm", "found the column \"alignment mm\" (did you mean \"alignment\"?)"),
            ("alignment [mm]", "gauge [mm]", "found the column \"gauge\" twice"),
            ("alignment [mm]", "left_lateral [mm]", "found \"left_lateral\" beside \"gauge\""),
            ("distance [m]", "cross_level", "expected a column \"distance\""),
            ("2,1,0", "0.5,1,0", "m.csv:4: distance: found 0.5 m after 1 m"),
            ("2,1,0", "2,x,0", "m.csv:4: alignment: found \"x\", expected a finite number"),
            ("2,1,0", "2,1", "m.csv:4: distance: found 2 columns, expected 3"),
            ("2,1,0", "2,900,0", "m.csv:4: alignment: found 0.9 m, expected at most 0.5 m: another unit?"),
            ("2,1,0", "2,1,1435", "m.csv:4: gauge: found 1.435 m, expected at most 0.5 m: another unit, or the gauge itself"),
            ("0,1,0\n1,1,0", "0,1,0\n0.001,2,0", "m.csv:3: alignment: rises by 1.00 m per metre"),
            ("3,1,0\n4,1,0\n", "", "found 3 points, expected at least 4"),
        ] {
            let error = read_series("", &good.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(message), "{error}\n{message}");
        }
        let error = |settings: &str| read_series(settings, good).unwrap_err().to_string();
        assert!(error("to = 5\n").contains("a.toml:3: to: found 5 m, but the file reaches from 0 m to 4 m"));
        assert!(error("fade = 3\n").contains("expected at most half of the 4 m"));
        assert!(error("columns = 3\n").contains("unknown key"));
        assert!(error("smoothing = 0\n").contains("greater than 0"));
    }
}
