//! Runs a scene natively and keeps its outputs at equal intervals.

use super::input_table::InputTable;
use super::outputs::{Needs, Output, needs};
use super::tables::LeftTables;
use super::{Simulation, SimulationError};
use crate::formulation::events::ContactEvent;
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
    /// When the model cannot be evaluated here, or an output is not a finite number; there is no row then.
    pub fn sample(&mut self, simulation: &mut Simulation, outputs: &[Output]) -> Result<(), SimulationError> {
        let mut row = Vec::with_capacity(outputs.len() + 1);
        row.push(simulation.time());
        let Some(needs) = needs(outputs) else {
            self.rows.push(row);
            return Ok(());
        };
        let snapshot = simulation.snapshot_with(needs)?;
        row.extend(outputs.iter().map(|output| output.value(snapshot)));
        if let Some(column) = row.iter().position(|value| !value.is_finite()) {
            return Err(SimulationError::NotFinite { name: self.columns[column].0.clone(), time: row[0] });
        }
        self.rows.push(row);
        Ok(())
    }

    /// What the rows do not show: its own notes and those of the simulation that made it.
    pub fn all_notes(&self, simulation: &Simulation) -> Vec<String> {
        self.notes.iter().cloned().chain(simulation.notes()).collect()
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
    /// Those of them that are written with single precision.
    single: Vec<bool>,
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
        Ok(CsvRows { writer, single: vec![false; columns.len()], columns, line })
    }

    /// With single precision where `single` has it, by column in their order.
    pub fn with_single(mut self, single: &[bool]) -> Self {
        self.single.iter_mut().zip(single).for_each(|(own, single)| *own = *single);
        self
    }

    /// Writes a row of the recording. Each number is the shortest one that reads back as the same bits, and none needs quotes.
    ///
    /// # Errors
    /// When the writer fails.
    pub fn write(&mut self, row: &[f64]) -> std::io::Result<()> {
        let mut number = zmij::Buffer::new();
        self.line.clear();
        for (column, single) in self.columns.iter().zip(&self.single) {
            let value = row[*column];
            let text = if *single { number.format(value as f32) } else { number.format(value) };
            self.line.extend_from_slice(text.as_bytes());
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
    times: Times,
    mut watch: impl FnMut(&[f64]) -> ControlFlow<()>,
) -> Result<Recording, Interrupted> {
    let mut run = Run::new(simulation, outputs);
    let ended =
        run.go_on(simulation, outputs, times, |_, run| run.recording.rows.last().map_or(ControlFlow::Continue(()), |row| watch(row)));
    let recording = run.end();
    match ended {
        Ok(()) => Ok(recording),
        Err(error) => Err(Interrupted { recording, error: Box::new(error) }),
    }
}

/// A run under way: what it has recorded, and what its notes need.
#[derive(Debug)]
pub struct Run {
    pub recording: Recording,
    /// Lift-offs and landings that were taken from the simulation so far.
    pub events: Vec<ContactEvent>,
    /// By which inputs are set on the way, if any.
    pub inputs: Option<InputTable>,
    pub(super) left: LeftTables,
}

impl Run {
    /// Before its first row.
    pub fn new(simulation: &Simulation, outputs: &[Output]) -> Run {
        Run { recording: Recording::new(outputs), events: Vec::new(), inputs: None, left: LeftTables::new(simulation.model()) }
    }

    /// Goes on from the last row, where the simulation stands (from the first one where there is none), to the stop; each new row is shown to `watch`, which
    /// may end the run early.
    ///
    /// # Errors
    /// When the simulation cannot go on.
    pub fn go_on(
        &mut self,
        simulation: &mut Simulation,
        outputs: &[Output],
        Times { stop, step }: Times,
        mut watch: impl FnMut(&mut Simulation, &mut Run) -> ControlFlow<()>,
    ) -> Result<(), SimulationError> {
        let mut row = |run: &mut Run, simulation: &mut Simulation| -> Result<ControlFlow<()>, SimulationError> {
            run.recording.sample(simulation, outputs)?;
            if !run.left.is_empty() {
                run.left.look(simulation.snapshot_with(Needs::Motion)?);
            }
            Ok(watch(simulation, run))
        };
        if self.recording.rows.is_empty() {
            if let Some(inputs) = &self.inputs {
                inputs.set(simulation);
            }
            if row(self, simulation)?.is_break() {
                return Ok(());
            }
        }
        let start = self.recording.rows.first().map_or(simulation.time(), |row| row[0]);
        for time in communication_points(start, stop, step).skip(self.recording.rows.len() - 1) {
            match &self.inputs {
                Some(inputs) => inputs.advance(simulation, time)?,
                None => simulation.advance(time)?,
            }
            if row(self, simulation)?.is_break() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// What was recorded, with notes.
    pub fn end(self) -> Recording {
        Recording { notes: self.left.notes(), ..self.recording }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::open;
    use crate::sim::vehicle_outputs::scene_outputs;

    #[test]
    fn unit_no_row_holds_what_is_not_a_number() {
        let scene = open("wheelset_s1002", &[]).unwrap();
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        let mut outputs = scene_outputs(&scene, simulation.model());
        outputs[1].read_by(Box::new(|snapshot| if snapshot.time > 0.025 { f64::NAN } else { 0.0 }));
        let Interrupted { recording, error } = record(&mut simulation, &outputs, 0.1, 0.01, |_| ()).unwrap_err();
        assert_eq!(recording.rows.len(), 3);
        let message = error.to_string();
        assert!(message.contains(&outputs[1].name) && message.contains("0.03 s"), "{message}");
    }
}
