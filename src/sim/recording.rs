//! Runs a scene natively and keeps its outputs at equal intervals.

use super::outputs::{Needs, Output, needs};
use super::tables::LeftTables;
use super::{Simulation, SimulationError};
use std::io::Write;
use std::ops::ControlFlow;

/// Outputs over time.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Name and unit of each column, time first. A unit of no letters is not written.
    pub columns: Vec<(String, &'static str)>,
    /// One row per output time, time first.
    pub rows: Vec<Vec<f64>>,
    /// What a reader of the numbers should know: tables of forces that were left.
    pub notes: Vec<String>,
}

impl Recording {
    pub fn new(outputs: &[Output]) -> Self {
        let mut columns = vec![("time".to_string(), "s")];
        columns.extend(outputs.iter().map(|output| (output.name.clone(), output.unit.name())));
        Recording { columns, rows: Vec::new(), notes: Vec::new() }
    }

    /// Adds a row at the simulation's present time.
    ///
    /// # Errors
    /// When the model cannot be evaluated here.
    pub fn sample(&mut self, simulation: &mut Simulation, outputs: &[Output]) -> Result<(), SimulationError> {
        let mut row = Vec::with_capacity(outputs.len() + 1);
        row.push(simulation.time());
        let Some(needs) = needs(outputs) else {
            self.rows.push(row);
            return Ok(());
        };
        let snapshot = simulation.snapshot_with(needs)?;
        row.extend(outputs.iter().map(|output| output.value(snapshot)));
        self.rows.push(row);
        Ok(())
    }

    /// The values of one column; `None` when there is no such column.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|column| column.0 == name)?;
        Some(self.rows.iter().map(|row| row[index]).collect())
    }

    /// Writes a CSV file: a header of names with units, then full-precision numbers.
    ///
    /// # Errors
    /// When the writer fails.
    pub fn write_csv(&self, writer: impl Write) -> csv::Result<()> {
        let all: Vec<usize> = (0..self.columns.len()).collect();
        let mut csv = CsvRows::begin(writer, self, all)?;
        for row in &self.rows {
            csv.write(row)?;
        }
        csv.writer.flush()?;
        Ok(())
    }
}

/// Chosen columns of a recording as rows of CSV, one after the other.
pub struct CsvRows<W> {
    pub writer: W,
    columns: Vec<usize>,
    /// One row: text is most of what outputs cost.
    line: Vec<u8>,
}

impl<W: Write> CsvRows<W> {
    /// Writes the header: names with units.
    ///
    /// # Errors
    /// When the writer fails.
    pub fn begin(mut writer: W, recording: &Recording, columns: Vec<usize>) -> csv::Result<Self> {
        let mut head = csv::Writer::from_writer(Vec::new());
        let heading = |(name, unit): &(String, &'static str)| if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") };
        head.write_record(columns.iter().map(|column| heading(&recording.columns[*column])))?;
        let line = head.into_inner().map_err(|error| std::io::Error::other(error.to_string()))?;
        writer.write_all(&line)?;
        Ok(CsvRows { writer, columns, line })
    }

    /// Writes a row of the recording. Each number is the shortest one that reads back as the same bits, and none needs quotes.
    ///
    /// # Errors
    /// When the writer fails.
    pub fn write(&mut self, row: &[f64]) -> std::io::Result<()> {
        let mut number = zmij::Buffer::new();
        self.line.clear();
        for column in &self.columns {
            self.line.extend_from_slice(number.format(row[*column]).as_bytes());
            self.line.push(b',');
        }
        self.line.pop();
        self.line.push(b'\n');
        self.writer.write_all(&self.line)
    }
}

/// A run that ended early: what was recorded until then, and why.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct Interrupted {
    pub recording: Recording,
    pub error: Box<SimulationError>,
}

/// Communication points from `start` in steps of `step` to `stop`, the last one being `stop` itself.
pub fn communication_points(start: f64, stop: f64, step: f64) -> impl Iterator<Item = f64> {
    let least = if stop > start { 1.0 } else { 0.0 };
    let count = ((stop - start) / step - 1e-9).ceil().max(least) as u64;
    (1..=count).map(move |i| if i == count { stop } else { start + i as f64 * step })
}

/// Advances to `stop` and records every `step`; `progress` is told the time reached.
///
/// # Errors
/// [`Interrupted`] with everything recorded before the failure.
pub fn record(
    simulation: &mut Simulation,
    outputs: &[Output],
    stop: f64,
    step: f64,
    mut progress: impl FnMut(f64),
) -> Result<Recording, Interrupted> {
    let times = Times { stop, step };
    record_while(simulation, outputs, times, |row| {
        progress(row[0]);
        ControlFlow::Continue(())
    })
}

fn look(left: &mut LeftTables, simulation: &mut Simulation) -> Result<(), SimulationError> {
    if !left.is_empty() {
        left.look(simulation.snapshot_with(Needs::Motion)?);
    }
    Ok(())
}

/// When a run ends, and at which distance it is recorded, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    pub stop: f64,
    pub step: f64,
}

/// The same, shown row by row to `watch`, which may end the run early.
///
/// # Errors
/// [`Interrupted`] with everything recorded before the failure.
pub fn record_while(
    simulation: &mut Simulation,
    outputs: &[Output],
    Times { stop, step }: Times,
    mut watch: impl FnMut(&[f64]) -> ControlFlow<()>,
) -> Result<Recording, Interrupted> {
    let mut recording = Recording::new(outputs);
    let start = simulation.time();
    let mut left = LeftTables::new(simulation.model());
    let mut run = || -> Result<(), SimulationError> {
        recording.sample(simulation, outputs)?;
        look(&mut left, simulation)?;
        let mut go_on = |recording: &Recording| recording.rows.last().is_none_or(|row| watch(row).is_continue());
        if !go_on(&recording) {
            return Ok(());
        }
        for time in communication_points(start, stop, step) {
            simulation.advance(time)?;
            recording.sample(simulation, outputs)?;
            look(&mut left, simulation)?;
            if !go_on(&recording) {
                return Ok(());
            }
        }
        Ok(())
    };
    let ended = run();
    recording.notes = left.notes();
    match ended {
        Ok(()) => Ok(recording),
        Err(error) => Err(Interrupted { recording, error: Box::new(error) }),
    }
}
