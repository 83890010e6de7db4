//! The table of contacts that is read, and the table of forces that is written.

use crate::contact::creep::RollingContact;
use crate::contact::creepage::{CreepForce, Creepage};
use crate::contact::{Material, Patch};
use crate::settings::{CsvText, did_you_mean};

/// Column, unit, smallest and largest value, value if the column is absent.
struct Column {
    name: &'static str,
    unit: &'static str,
    range: (f64, f64),
    default: Option<f64>,
}

const fn column(name: &'static str, unit: &'static str, least: f64, most: f64) -> Column {
    Column { name, unit, range: (least, most), default: None }
}

const COLUMNS: [Column; 10] = [
    column("a", "m", 0.0, f64::MAX),
    column("b", "m", 0.0, f64::MAX),
    column("nu", "-", 0.0, 0.5),
    column("G", "Pa", f64::MIN_POSITIVE, f64::MAX),
    column("N", "N", 0.0, f64::MAX),
    column("mu", "-", 0.0, f64::MAX),
    column("xi", "-", f64::MIN, f64::MAX),
    column("eta", "-", f64::MIN, f64::MAX),
    column("phi", "1/m", f64::MIN, f64::MAX),
    Column { default: Some(1.0), ..column("V", "m/s", 0.0, f64::MAX) },
];

/// One contact.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Case {
    /// In the order of `COLUMNS`.
    values: [f64; 10],
    pub material: Material,
    pub contact: RollingContact,
}

impl Case {
    fn new(values: [f64; 10]) -> Self {
        let [a, b, nu, shear_modulus, normal_force, friction, longitudinal, lateral, spin, speed] = values;
        Case {
            values,
            material: Material { youngs_modulus: 2.0 * shear_modulus * (1.0 + nu), poisson_ratio: nu },
            contact: RollingContact {
                patch: Patch { a, b },
                normal_force,
                friction,
                creepage: Creepage { longitudinal, lateral, spin },
                speed,
            },
        }
    }
}

/// For each of `COLUMNS` its place in the table. A heading may carry its unit, `a [m]`.
fn places(heads: &csv::StringRecord, file: &str) -> Result<[Option<usize>; 10], String> {
    let names = COLUMNS.map(|column| column.name);
    let mut places = [None; 10];
    for (place, head) in heads.iter().enumerate() {
        let (name, unit) = match head.split_once('[') {
            Some((name, unit)) => (name.trim(), Some(unit.trim_end_matches(']').trim())),
            None => (head.trim(), None),
        };
        let Some(index) = names.iter().position(|known| *known == name) else {
            return Err(format!("{file}:1: column \"{name}\" is unknown{}; columns: {}", did_you_mean(name, &names), names.join(", ")));
        };
        if let Some(unit) = unit.filter(|unit| *unit != COLUMNS[index].unit) {
            return Err(format!("{file}:1: column \"{name}\" has the unit \"{unit}\", expected \"{}\"", COLUMNS[index].unit));
        }
        if places[index].replace(place).is_some() {
            return Err(format!("{file}:1: column \"{name}\" stands twice"));
        }
    }
    for (column, place) in COLUMNS.iter().zip(&places) {
        if place.is_none() && column.default.is_none() {
            return Err(format!("{file}:1: column \"{}\" is missing; columns: {}", column.name, names.join(", ")));
        }
    }
    Ok(places)
}

/// Reads a table of contacts; messages name file, line and column.
pub(super) fn read(text: &str, file: &str) -> Result<Vec<Case>, String> {
    let mut table = CsvText::new(text);
    let wrong = |(line, problem): (usize, String)| format!("{file}:{line}: {problem}");
    let heads = table.header().map_err(wrong)?;
    let places = places(&heads, file)?;
    let mut cases = Vec::new();
    for row in table.rows(heads.len()) {
        let row = row.map_err(wrong)?;
        let line = row.line;
        let mut values = [0.0; 10];
        for ((value, column), place) in values.iter_mut().zip(&COLUMNS).zip(&places) {
            let Some(place) = place else {
                *value = column.default.unwrap_or_default();
                continue;
            };
            let cell = row.cell(*place);
            let (least, most) = column.range;
            *value = row.number(*place).ok().filter(|number| (least..=most).contains(number)).ok_or_else(|| {
                let expected = match (least, most) {
                    (f64::MIN, _) => "a finite number".to_string(),
                    (_, f64::MAX) if least > 0.0 => "a finite number above 0".into(),
                    (_, f64::MAX) => "a finite number, 0 or more".into(),
                    _ => format!("a number from {least} to {most}"),
                };
                format!("{file}:{line}: column \"{}\": found \"{cell}\", expected {expected}", column.name)
            })?;
        }
        cases.push(Case::new(values));
    }
    if cases.is_empty() {
        return Err(format!("{file}: holds no contacts"));
    }
    Ok(cases)
}

/// One contact with one law.
pub(super) struct Row<'a> {
    pub case: &'a Case,
    pub law: &'a str,
    pub force: CreepForce,
    /// s per call.
    pub time: f64,
}

const RESULTS: [&str; 4] = ["Fx [N]", "Fy [N]", "Mz [N m]", "time [s]"];

impl Row<'_> {
    fn results(&self) -> [f64; 4] {
        [self.force.longitudinal, self.force.lateral, self.force.spin_moment, self.time]
    }
}

/// Input columns, law, forces on the wheel and time per call as CSV.
pub(super) fn table(rows: &[Row]) -> String {
    let mut heads: Vec<String> = COLUMNS.iter().map(|column| format!("{} [{}]", column.name, column.unit)).collect();
    heads.push("law".into());
    heads.extend(RESULTS.map(String::from));
    let mut text = heads.join(",") + "\n";
    for row in rows {
        let numbers = |values: &[f64]| values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(",");
        // A law with several settings holds commas.
        let law = if row.law.contains([',', '"']) { format!("\"{}\"", row.law.replace('"', "\"\"")) } else { row.law.into() };
        text += &format!("{},{law},{}\n", numbers(&row.case.values), numbers(&row.results()));
    }
    text
}

/// The same as a list of objects.
pub(super) fn json(rows: &[Row]) -> serde_json::Value {
    let object = |row: &Row| {
        let mut object = serde_json::Map::new();
        for (column, value) in COLUMNS.iter().zip(row.case.values) {
            object.insert(column.name.into(), value.into());
        }
        object.insert("law".into(), row.law.into());
        for (name, value) in ["Fx", "Fy", "Mz", "time"].into_iter().zip(row.results()) {
            object.insert(name.into(), value.into());
        }
        serde_json::Value::Object(object)
    };
    rows.iter().map(object).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "b [m],a,nu,G,N,mu,xi,eta,phi\n";

    #[test]
    fn prop_columns_in_any_order_and_messages_with_line_and_column() {
        let cases = read(&format!("# note\n{HEAD}0.004,0.006,0.28,8.2e10,8e4,0.3,1e-3,-2e-3,0.1\n"), "t.csv").unwrap();
        let contact = cases[0].contact;
        assert!(contact.patch == Patch { a: 0.006, b: 0.004 } && contact.speed == 1.0 && contact.creepage.spin == 0.1);
        assert!((cases[0].material.shear_modulus() - 8.2e10).abs() < 1e-3);
        let problem = |text: &str| read(text, "t.csv").unwrap_err();
        let row = |cells: &str| problem(&format!("{HEAD}0.004,0.006,0.28,8.2e10,8e4,0.3,1e-3,0,0\n{cells}\n"));
        assert_eq!(row("0.004,0.006,0.28,8.2e10,-1,0.3,0,0,0"), "t.csv:3: column \"N\": found \"-1\", expected a finite number, 0 or more");
        assert!(row("0.004,nan,0.28,8.2e10,1,0.3,0,0,0").starts_with("t.csv:3: column \"a\": found \"nan\""));
        assert!(row("0.004,0.006,0.28,8.2e10,1,0.3,inf,0,0").starts_with("t.csv:3: column \"xi\": found \"inf\""));
        assert!(row("0.004,0.006,0.6,8.2e10,1,0.3,0,0,0").ends_with("expected a number from 0 to 0.5"));
        assert!(problem("aa,b\n").contains("column \"aa\" is unknown"), "{}", problem("aa,b\n"));
        assert!(problem("a,b,nuu\n").contains("did you mean \"nu\""), "{}", problem("a,b,nuu\n"));
        assert!(problem("a,b\n").contains("column \"nu\" is missing"));
        assert!(problem("a [mm],b\n").contains("unit \"mm\", expected \"m\""));
        assert!(problem("a,a\n").contains("stands twice"));
        assert!(problem(HEAD).contains("no contacts"));
    }
}
