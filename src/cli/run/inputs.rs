//! `--inputs FILE.csv`: inputs over time from a table, by the names that the FMU has for them.

use super::super::Failure;
use crate::fmi::variables::{Role, Variable, VariableTable};
use crate::scene::spec::Scene;
use crate::settings::{CsvText, did_you_mean, line_of, title};
use crate::sim::input_table::InputTable;
use crate::units::{Dimension, Unit};
use std::path::Path;

const TIME: &str = "time";

/// What a file says: the table, and its text (a run goes on with the same one alone).
pub(super) struct Inputs {
    pub table: InputTable,
    pub text: String,
}

impl Inputs {
    /// Of a table that nothing is read of before the run ends at `stop` [s], but its first row.
    pub fn note(&self, stop: f64) -> Option<String> {
        self.table.begin().filter(|begin| *begin >= stop).map(|begin| {
            format!(
                "--inputs: its rows begin at {begin} s, and the run ends at {stop} s: the first row is held all the time (times are in s where the title \
                 says nothing else, such as \"time [ms]\")"
            )
        })
    }
}

/// A column: the input, and what its numbers are multiplied by.
struct Column<'a> {
    variable: &'a Variable,
    place: usize,
    factor: f64,
}

/// Reads and checks a file. Where the speed is an input the scene begins with that of the file.
pub(super) fn read(path: &Path, scene: &mut Scene) -> Result<Inputs, Failure> {
    let shown = path.display();
    let text = std::fs::read_to_string(path).map_err(|error| Failure::Input(format!("--inputs {shown}: {error}")))?;
    let variables = VariableTable::new(scene).map_err(|error| Failure::Input(format!("{}: {error}", scene.source.file)))?;
    let table = parse(&text, &variables, scene).map_err(|(line, problem)| {
        let place = if line == 0 { String::new() } else { format!(":{line}") };
        Failure::Input(format!("{shown}{place}: {problem}"))
    })?;
    if let Some(speed) = variables.speed_input.and_then(|speed| table.value(speed, 0.0)) {
        if speed == 0.0 {
            let problem = "speed: found 0 m/s at time 0, expected another one: a run begins with steady running";
            return Err(Failure::Input(format!("{shown}: {problem}")));
        }
        scene.vehicle.speed = speed;
    }
    Ok(Inputs { table, text })
}

/// Errors with the line, 0 for the file.
fn parse(text: &str, variables: &VariableTable, scene: &Scene) -> Result<InputTable, (usize, String)> {
    let mut csv = CsvText::new(text);
    let header = csv.header()?;
    let wrong_header = |problem: String| (line_of(text, &header), problem);
    let inputs: Vec<(usize, &Variable)> = variables
        .variables
        .iter()
        .filter_map(|variable| match variable.role {
            Role::Input(place) => Some((place, variable)),
            _ => None,
        })
        .collect();
    let (time, columns) = titles(&header, &inputs).map_err(wrong_header)?;
    let mut times = Vec::new();
    let mut lines = Vec::new();
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
    for row in csv.rows(header.len()) {
        let row = row?;
        let line = row.line;
        let number = |column: usize| row.number(column).map_err(|problem| (line, format!("{}: {problem}", &header[column])));
        times.push(time * number(0)?);
        lines.push(line);
        for (index, (column, values)) in columns.iter().zip(&mut values).enumerate() {
            let value = column.factor * number(index + 1)?;
            column.variable.check(value).map_err(|problem| (line, format!("{}: {problem}", column.variable.name)))?;
            if value == 0.0 && variables.speed_input == Some(column.place) && scene.contact.transient.is_none() {
                return Err((
                    line,
                    "speed: found 0 m/s, which needs [contact.transient]: creepages are relative to the travelling speed".into(),
                ));
            }
            values.push(value);
        }
    }
    let columns = columns.iter().map(|column| column.place).zip(values).collect();
    InputTable::new(times, columns).map_err(|error| (error.row().map_or(0, |row| lines[row]), format!("{TIME}: {error}")))
}

/// Factor of the times, and the columns behind them.
fn titles<'a>(header: &csv::StringRecord, inputs: &[(usize, &'a Variable)]) -> Result<(f64, Vec<Column<'a>>), String> {
    let mut names = header.iter();
    let (first, unit) = title(names.next().unwrap_or_default());
    if first != TIME {
        return Err(format!("found \"{first}\" as the first column, expected \"{TIME}\" in s"));
    }
    let time = match unit {
        None => 1.0,
        Some(unit) => factor(Unit::Second, unit).ok_or_else(|| format!("{TIME}: found the unit \"{unit}\", expected s"))?,
    };
    let mut columns: Vec<Column> = Vec::new();
    for text in names {
        let (name, unit) = title(text);
        let Some(&(place, variable)) = inputs.iter().find(|(_, input)| input.name == name) else {
            let known: Vec<&str> = inputs.iter().map(|(_, input)| input.name.as_str()).collect();
            let hint = did_you_mean(name, &known);
            let expected = match known.len() {
                0 => "the scene has none (interface.inputs)".to_string(),
                1..=12 => format!("expected some of {}", known.join(", ")),
                count => format!("the scene has {count}, such as {}", known[..3].join(", ")),
            };
            return Err(format!("found the column \"{name}\"{hint}, no input of that name: {expected}"));
        };
        if columns.iter().any(|column| column.variable.name == name) {
            return Err(format!("found the column \"{name}\" twice"));
        }
        let factor = match unit {
            None => 1.0,
            Some(unit) => factor(variable.unit, unit)
                .ok_or_else(|| format!("{name}: found the unit \"{unit}\", expected {}", variable.unit.name()))?,
        };
        columns.push(Column { variable, place, factor });
    }
    if columns.is_empty() {
        return Err(format!("expected the column \"{TIME}\" and at least one input"));
    }
    Ok((time, columns))
}

/// What a number in `unit` is in that of the variable.
fn factor(own: Unit, unit: &str) -> Option<f64> {
    let dimension = match own {
        Unit::Metre | Unit::Distance => Dimension::Length,
        Unit::Radian => Dimension::Angle,
        Unit::Second => Dimension::Time,
        Unit::MetrePerSecond | Unit::TravelSpeed => Dimension::Speed,
        Unit::MetrePerSecond2 => Dimension::Acceleration,
        Unit::Newton => Dimension::Force,
        Unit::NewtonMetre => Dimension::Torque,
        _ => Dimension::None,
    };
    if unit == own.name() { Some(1.0) } else { dimension.parse(&format!("1 {unit}")).filter(|_| !unit.is_empty()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    fn scene(changes: &[&str]) -> Scene {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        load::open("suspended_wheelset", &changes).unwrap_or_else(|error| panic!("{error}"))
    }

    fn read_text(scene: &mut Scene, text: &str) -> Result<Inputs, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("in.csv");
        std::fs::write(&path, text).unwrap();
        read(&path, scene).map_err(|failure| match failure {
            Failure::Input(words) => words.replace(&format!("{}", path.display()), "in.csv"),
            _ => panic!("a fault of the file is bad input"),
        })
    }

    #[test]
    fn prop_units_and_comments_are_read() {
        let mut scene = scene(&["vehicle.speed={start=20}"]);
        let text = "# a run\ntime [ms];speed [km/h];wheelset.driveTorque [kN m]\n\n0;36;1\n# then\n500;72;2\n";
        let found = read_text(&mut scene, text).unwrap_or_else(|words| panic!("{words}"));
        let variables = VariableTable::new(&scene).unwrap();
        let place = |name: &str| match variables.variables.iter().find(|variable| variable.name == name).unwrap().role {
            Role::Input(place) => place,
            _ => panic!("{name} is no input"),
        };
        let at = |name: &str| found.table.value(place(name), 0.25).unwrap();
        assert!((at("speed") - 15.0).abs() < 1e-12 && (at("wheelset.driveTorque") - 1500.0).abs() < 1e-9);
        assert_eq!(scene.vehicle.speed, 10.0);
    }

    #[test]
    fn prop_a_table_that_begins_behind_the_end_is_named() {
        let mut scene = scene(&["vehicle.speed={start=20}"]);
        let mut note = |text: &str| read_text(&mut scene, text).unwrap_or_else(|words| panic!("{words}")).note(2.0);
        assert!(note("time,speed\n500,20\n900,21\n").is_some_and(|words| words.contains("begin at 500 s")));
        assert_eq!([note("time [ms],speed\n500,20\n900,21\n"), note("time,speed\n0,20\n")], [None, None]);
    }

    #[test]
    fn prop_wrong_files_are_refused_with_line_and_reason() {
        let mut scene = scene(&["vehicle.speed={start=20}"]);
        for (text, words) in [
            ("", "in.csv:1: found \"\" as the first column, expected \"time\" in s"),
            ("time\n0\n", "in.csv:1: expected the column \"time\" and at least one input"),
            (
                "time,wheelset.driveTorqe\n0,1\n",
                "in.csv:1: found the column \"wheelset.driveTorqe\" (did you mean \"wheelset.driveTorque\"?), no input",
            ),
            ("time,speed,speed\n0,1,1\n", "in.csv:1: found the column \"speed\" twice"),
            ("time,speed [kN]\n0,1\n", "in.csv:1: speed: found the unit \"kN\", expected m/s"),
            ("time,speed\n", "in.csv: time: expected at least one row"),
            ("# x\n\ntime,speed\n0,1\n\n# y\n1\n", "in.csv:7: found 1 columns, expected 2"),
            ("time,speed\n0,1\n1,fast\n", "in.csv:3: speed: found \"fast\", expected a finite number"),
            ("time,speed\n0,1\n2,2\n1,2\n", "in.csv:4: time: found 1 s after 2 s"),
            ("time,speed\n0,1\n1,2\n1,2\n1,3\n", "in.csv:5: time: found three rows at 1 s"),
            ("time,speed\n0,1\n1,900\n", "in.csv:3: speed: the largest value is 500"),
            ("time,speed\n0,1\n1,0\n", "in.csv:3: speed: found 0 m/s, which needs [contact.transient]"),
            ("time,wheelset.left.frictionFactor\n0,-1\n", "in.csv:2: wheelset.left.frictionFactor: the smallest value is 0"),
            ("time,wheelset.left.frictionFactor\n0,60\n", "in.csv:2: wheelset.left.frictionFactor: the largest value is 10"),
        ] {
            match read_text(&mut scene, text) {
                Err(found) => assert!(found.starts_with(words), "{text:?}: {found}"),
                Ok(_) => panic!("{text:?} was read"),
            }
        }
    }
}
