//! The table of a sweep: rows as runs end, found again by the next call, in order at the end.

use crate::cli::Failure;
use crate::cli::output::Target;
use crate::cli::sweep::numbers::Number;
use crate::study::variation::parameter::{Parameter, number};
use crate::study::variation::single::{Outcome, State};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What the columns are.
pub(super) struct Columns {
    /// Keys that vary, with their unit where all values are numbers of one.
    pub keys: Vec<(String, Option<String>)>,
    /// Scalars as written, and units.
    pub scalars: Vec<(String, String)>,
    /// Of scene and times.
    fingerprint: String,
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub run: usize,
    /// Of the keys that vary; numbers without their unit.
    pub values: Vec<String>,
    pub state: State,
    pub time: Option<f64>,
    pub reason: String,
    pub scalars: Vec<Option<f64>>,
}

/// Values as the table has them.
fn cells(parameters: &[Parameter], point: &[String]) -> Vec<String> {
    let varying = parameters.iter().zip(point).filter(|(parameter, _)| parameter.varies());
    varying
        .map(|(parameter, value)| match (parameter.unit(), number(value)) {
            (Some(unit), Some(_)) => value.trim().strip_suffix(unit).unwrap_or(value).trim().into(),
            _ => value.clone(),
        })
        .collect()
}

impl Row {
    pub(super) fn new(run: usize, parameters: &[Parameter], point: &[String], outcome: Outcome) -> Row {
        let Outcome { state, time, reason, scalars } = outcome;
        // One line each.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        Row { run, values: cells(parameters, point), state, time, reason, scalars }
    }
}

/// A name, and its unit where it has one.
pub(super) fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.into() } else { format!("{name} [{unit}]") }
}

impl Columns {
    pub(super) fn new(parameters: &[Parameter], numbers: &[Number], fingerprint: String) -> Columns {
        let varying = parameters.iter().filter(|parameter| parameter.varies());
        Columns {
            keys: varying.map(|parameter| (parameter.key.clone(), parameter.unit().map(str::to_string))).collect(),
            scalars: numbers.iter().map(|number| (number.name.clone(), number.unit.clone())).collect(),
            fingerprint,
        }
    }

    /// A key with its unit.
    pub(super) fn key(&self, index: usize) -> String {
        match &self.keys[index] {
            (key, Some(unit)) if !unit.is_empty() => format!("{key} [{unit}]"),
            (key, _) => key.clone(),
        }
    }

    fn head(&self) -> Vec<String> {
        let keys = (0..self.keys.len()).map(|index| self.key(index));
        let scalars = self.scalars.iter().map(|(text, unit)| with_unit(text, unit));
        let own = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        [own(&["run"]), keys.collect(), own(&["state", "time [s]"]), scalars.collect(), own(&["reason", "scene"])].concat()
    }

    fn record(&self, row: &Row) -> Vec<String> {
        let number = |value: &Option<f64>| value.map_or(String::new(), |value| zmij::Buffer::new().format(value).to_string());
        let scalars = row.scalars.iter().map(number).collect();
        let ends = vec![row.state.word().to_string(), number(&row.time)];
        [vec![row.run.to_string()], row.values.clone(), ends, scalars, vec![row.reason.clone(), self.fingerprint.clone()]].concat()
    }

    /// The row of a record; `None` where it is none.
    fn row(&self, record: &csv::StringRecord) -> Option<Row> {
        let number = |text: &str| -> Option<Option<f64>> { if text.is_empty() { Some(None) } else { text.parse().ok().map(Some) } };
        let (keys, scalars) = (self.keys.len(), self.scalars.len());
        (record.len() == keys + scalars + 5).then_some(())?;
        let word = &record[keys + 1];
        Some(Row {
            run: record[0].parse().ok()?,
            values: (1..=keys).map(|at| record[at].to_string()).collect(),
            state: State::ALL.into_iter().find(|state| state.word() == word)?,
            time: number(&record[keys + 2])?,
            scalars: (0..scalars).map(|at| number(&record[keys + 3 + at])).collect::<Option<_>>()?,
            reason: record[keys + 3 + scalars].to_string(),
        })
    }

    fn line(records: &[Vec<String>]) -> csv::Result<Vec<u8>> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        records.iter().try_for_each(|record| csv.write_record(record))?;
        csv.into_inner().map_err(|error| std::io::Error::other(error.to_string()).into())
    }
}

/// The table in the making: rows are appended as they come.
pub(super) struct Results {
    columns: Columns,
    path: PathBuf,
    file: File,
    pub rows: BTreeMap<usize, Row>,
}

impl Results {
    /// Opens a table, and reads the rows that are in it already. What a killed program left of a last line is taken away.
    ///
    /// # Errors
    /// In words: a file of another sweep, or one that can't be read or written.
    pub(super) fn open(path: &Path, columns: Columns, points: &[Vec<String>]) -> Result<Results, String> {
        let shown = path.display();
        let failed = |error: &dyn std::fmt::Display| format!("{shown}: can't be written: {error}");
        let file = OpenOptions::new().create(true).append(true).read(true).open(path).map_err(|error| failed(&error))?;
        // A file system without locks has none to respect.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(format!("{shown}: another sweep is writing it"));
        }
        let text = std::fs::read(path).map_err(|error| failed(&error))?;
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        if whole < text.len() {
            file.set_len(whole as u64).map_err(|error| failed(&error))?;
        }
        let mut results = Results { columns, path: path.into(), file, rows: BTreeMap::new() };
        if whole == 0 {
            let head = Columns::line(&[results.columns.head()]).map_err(|error| failed(&error))?;
            results.file.write_all(&head).map_err(|error| failed(&error))?;
        } else {
            results.read(&text[..whole], points)?;
        }
        Ok(results)
    }

    fn read(&mut self, text: &[u8], points: &[Vec<String>]) -> Result<(), String> {
        let shown = self.path.display();
        let advice = "choose another file, or delete it";
        let mut csv = csv::ReaderBuilder::new().flexible(true).from_reader(text);
        let head = csv.headers().map_err(|error| format!("{shown}: {error}"))?.clone();
        let wanted = self.columns.head();
        if !head.iter().eq(wanted.iter().map(String::as_str)) {
            let at = head.iter().zip(&wanted).position(|(found, wanted)| found != wanted);
            let found = at.map_or("more or fewer columns".into(), |at| format!("a column {:?} instead of {:?}", &head[at], wanted[at]));
            return Err(format!("{shown}: the table of another sweep ({found}); {advice}"));
        }
        let own = |row: &Row| points.get(row.run).is_some_and(|point| point == &row.values);
        for (line, record) in csv.records().enumerate() {
            let record = record.map_err(|error| format!("{shown}: {error}"))?;
            if record.iter().next_back() != Some(self.columns.fingerprint.as_str()) {
                return Err(format!(
                    "{shown}, line {}: a run of another scene, or with other files, times or expressions; {advice}",
                    line + 2
                ));
            }
            match self.columns.row(&record).filter(own) {
                Some(row) => self.rows.insert(row.run, row),
                None => return Err(format!("{shown}, line {}: a run that this sweep does not have; {advice}", line + 2)),
            };
        }
        Ok(())
    }

    /// Appends a row: whole, or not at all but for what a kill cuts off.
    ///
    /// # Errors
    /// When the file can't be written.
    pub(super) fn add(&mut self, row: Row) -> csv::Result<()> {
        let line = Columns::line(&[self.columns.record(&row)])?;
        self.file.write_all(&line)?;
        self.rows.insert(row.run, row);
        Ok(())
    }

    /// Writes all rows anew in their order.
    ///
    /// # Errors
    /// When the file can't be written.
    pub(super) fn finish(self, target: &Target) -> Result<(Columns, Vec<Row>), Failure> {
        let Results { columns, file, rows, .. } = self;
        // It is replaced.
        drop(file);
        let rows: Vec<Row> = rows.into_values().collect();
        let records: Vec<Vec<String>> = std::iter::once(columns.head()).chain(rows.iter().map(|row| columns.record(row))).collect();
        let text = Columns::line(&records).map_err(|error| Failure::Run(error.to_string()))?;
        target.write(&text)?;
        Ok((columns, rows))
    }
}

/// Values of each run as the table has them.
pub(super) fn all_cells(parameters: &[Parameter], points: &[Vec<String>]) -> Vec<Vec<String>> {
    points.iter().map(|point| cells(parameters, point)).collect()
}
