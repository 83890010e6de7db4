//! Runs a scene natively and keeps its outputs at equal intervals.

use super::outputs::Output;
use super::tables::LeftTables;
use super::{Simulation, SimulationError};
use std::fmt::Write as _;
use std::io::Write;

/// Outputs over time.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Name and unit of each column, time first.
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
        let snapshot = simulation.snapshot()?;
        let mut row = Vec::with_capacity(outputs.len() + 1);
        row.push(snapshot.time);
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
        let mut csv = csv::Writer::from_writer(writer);
        csv.write_record(self.columns.iter().map(|(name, unit)| format!("{name} [{unit}]")))?;
        // Text is most of what outputs cost: one buffer serves all numbers.
        let mut text = String::new();
        for row in &self.rows {
            for value in row {
                text.clear();
                write!(text, "{value:?}").map_err(std::io::Error::other)?;
                csv.write_field(&text)?;
            }
            csv.write_record(None::<&[u8]>)?;
        }
        csv.flush()?;
        Ok(())
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
    let mut recording = Recording::new(outputs);
    let start = simulation.time();
    let mut left = LeftTables::new(simulation.model());
    let mut run = || -> Result<(), SimulationError> {
        recording.sample(simulation, outputs)?;
        left.look(simulation.snapshot()?);
        for time in communication_points(start, stop, step) {
            simulation.advance(time)?;
            recording.sample(simulation, outputs)?;
            left.look(simulation.snapshot()?);
            progress(time);
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
