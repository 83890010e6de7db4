//! Rows of a run as a file: CSV, Parquet or MAT by its ending; of each row the chosen columns, with the precision asked for, thinned out if that is asked for.
//!
//! CSV is written row by row. The other two keep columns, which are written at the end.

mod mat;
pub(super) mod parquet;
mod thin;

use super::Failure;
use super::output::{OutputError, Pending, Target};
use crate::sim::recording::{CsvRows, Recording};
use clap::ValueEnum;
use std::path::Path;
pub(super) use thin::Thinned;

/// Of the numbers in a file; times and distances keep double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, ValueEnum)]
pub(super) enum Precision {
    Float32,
    #[default]
    Float64,
}

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    Csv,
    Parquet,
    Mat,
}

impl Format {
    /// By its ending; CSV where it has none of these.
    pub fn of(path: &Path) -> Format {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("parquet") => Format::Parquet,
            Some("mat") => Format::Mat,
            _ => Format::Csv,
        }
    }
}

/// Values of a column as they are written.
#[derive(Clone, Debug, PartialEq)]
enum Values {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

/// A column of a table.
#[derive(Clone, Debug)]
struct Column {
    name: String,
    unit: &'static str,
    values: Values,
}

impl Column {
    fn len(&self) -> usize {
        match &self.values {
            Values::Single(values) => values.len(),
            Values::Double(values) => values.len(),
        }
    }

    fn at(&self, row: usize) -> f64 {
        match &self.values {
            Values::Single(values) => values[row].into(),
            Values::Double(values) => values[row],
        }
    }
}

/// Columns of equal length, the index first.
#[derive(Clone, Debug)]
struct Table {
    columns: Vec<Column>,
}

/// Which columns go into a file, and how.
pub(super) struct Layout {
    /// Of a recording's columns, in their order in the file.
    pub chosen: Vec<usize>,
    pub precision: Precision,
    pub thinned: Option<Thinned>,
}

enum Sink {
    Csv(CsvRows<Pending>),
    Columns(Pending, Table, fn(&mut Pending, &Table) -> std::io::Result<()>),
}

/// A file of results that is being written.
pub(super) struct Results {
    sink: Sink,
    chosen: Vec<usize>,
    thinned: Option<Thinned>,
    row: Vec<f64>,
    written: usize,
}

impl Results {
    /// Begins to write what `layout` chooses of a recording's columns.
    ///
    /// # Errors
    /// When the file can't be begun.
    pub fn begin(target: &Target, recording: &Recording, layout: Layout) -> Result<Results, Failure> {
        let columns: Vec<(String, &'static str)> = layout.chosen.iter().map(|column| recording.columns[*column].clone()).collect();
        let exact = |name: &str| name == "time" || name.ends_with(".distance");
        let single: Vec<bool> = columns.iter().map(|(name, _)| layout.precision == Precision::Float32 && !exact(name)).collect();
        let pending = target.begin()?;
        let sink = match Format::of(target.path()) {
            Format::Csv => {
                let all = (0..columns.len()).collect();
                let rows = CsvRows::begin(pending, &Recording { columns, ..Recording::default() }, all);
                Sink::Csv(rows.map_err(|error| Failure::Run(error.to_string()))?.with_single(&single))
            }
            format => {
                let column = |((name, unit), single): ((String, &'static str), &bool)| {
                    let values = if *single { Values::Single(vec![]) } else { Values::Double(vec![]) };
                    Column { name, unit, values }
                };
                let table = Table { columns: columns.into_iter().zip(&single).map(column).collect() };
                Sink::Columns(pending, table, if format == Format::Parquet { parquet::write } else { mat::write })
            }
        };
        Ok(Results { sink, chosen: layout.chosen, thinned: layout.thinned, row: Vec::new(), written: 0 })
    }

    /// Takes a row of the recording.
    ///
    /// # Errors
    /// When the file can't take it.
    pub fn write(&mut self, row: &[f64]) -> std::io::Result<()> {
        self.row.clear();
        self.row.extend(self.chosen.iter().map(|column| row[*column]));
        let Some(thinned) = &mut self.thinned else {
            self.written += 1;
            return self.sink.write(&self.row);
        };
        thinned.take(&self.row);
        while let Some(row) = thinned.next_row() {
            self.written += 1;
            self.sink.write(&row)?;
        }
        Ok(())
    }

    /// Writes what is left; the file takes its place. Returns how many rows it has.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn finish(mut self) -> Result<usize, OutputError> {
        for row in self.thinned.take().map(Thinned::rest).unwrap_or_default() {
            self.written += 1;
            if let Err(error) = self.sink.write(&row) {
                return self.fail(error).map(|()| 0);
            }
        }
        let done = match self.sink {
            Sink::Csv(rows) => rows.writer.finish(),
            Sink::Columns(mut pending, table, write) => match write(&mut pending, &table) {
                Ok(()) => pending.finish(),
                Err(error) => pending.fail(error),
            },
        };
        done.map(|()| self.written)
    }

    /// Ends after a failure to write.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn fail(self, problem: std::io::Error) -> Result<(), OutputError> {
        match self.sink {
            Sink::Csv(rows) => rows.writer.fail(problem),
            Sink::Columns(pending, ..) => pending.fail(problem),
        }
    }
}

impl Sink {
    fn write(&mut self, row: &[f64]) -> std::io::Result<()> {
        match self {
            Sink::Csv(rows) => rows.write(row),
            Sink::Columns(_, table, _) => {
                for (column, value) in table.columns.iter_mut().zip(row) {
                    match &mut column.values {
                        Values::Single(values) => values.push(*value as f32),
                        Values::Double(values) => values.push(*value),
                    }
                }
                Ok(())
            }
        }
    }
}
