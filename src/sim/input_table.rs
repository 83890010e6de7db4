//! Inputs by a table over time, set as a master would set them that knows it: straight lines between rows, told with their slopes, so that nothing but a bend restarts
//! the integration. Before the first row and behind the last one inputs are held; two rows of one time are a jump, where the second one holds.

use super::{Simulation, SimulationError};

/// Values of inputs at times that do not decrease; no more than two rows have the same.
#[derive(Clone, Debug, PartialEq)]
pub struct InputTable {
    times: Vec<f64>,
    /// Input of the model, and its values by row.
    columns: Vec<(usize, Vec<f64>)>,
}

/// Why there is no table of these numbers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InputTableError {
    #[error("expected at least one row")]
    Empty,
    #[error("found {value} s after {before} s, expected times that do not decrease")]
    Order { row: usize, before: f64, value: f64 },
    #[error("found three rows at {value} s, expected at most two (a jump)")]
    Thrice { row: usize, value: f64 },
}

impl InputTableError {
    /// Number of the row that is wrong, if one is.
    pub fn row(&self) -> Option<usize> {
        match self {
            InputTableError::Empty => None,
            InputTableError::Order { row, .. } | InputTableError::Thrice { row, .. } => Some(*row),
        }
    }
}

impl InputTable {
    /// Of finite numbers: `times` [s], and per input its place in the model's input vector and a value for each of them.
    ///
    /// # Errors
    /// [`InputTableError`].
    pub fn new(times: Vec<f64>, columns: Vec<(usize, Vec<f64>)>) -> Result<InputTable, InputTableError> {
        if times.is_empty() {
            return Err(InputTableError::Empty);
        }
        for (row, pair) in times.windows(2).enumerate() {
            if pair[1] < pair[0] {
                return Err(InputTableError::Order { row: row + 1, before: pair[0], value: pair[1] });
            }
        }
        for (row, three) in times.windows(3).enumerate() {
            if three[0] == three[2] {
                return Err(InputTableError::Thrice { row: row + 2, value: three[0] });
            }
        }
        Ok(InputTable { times, columns })
    }

    /// The value and slope of a column from time `t` [s] on.
    fn from(&self, values: &[f64], t: f64) -> [f64; 2] {
        match self.times.partition_point(|time| *time <= t) {
            0 => [values[0], 0.0],
            behind if behind == self.times.len() => [values[behind - 1], 0.0],
            behind => {
                let (time, value) = (self.times[behind - 1], values[behind - 1]);
                let slope = (values[behind] - value) / (self.times[behind] - time);
                [value + slope * (t - time), slope]
            }
        }
    }

    /// Time of the first of several rows, s.
    pub fn begin(&self) -> Option<f64> {
        self.times.first().copied().filter(|_| self.times.len() > 1)
    }

    /// Value of an input at time `t` [s]; `None` where the table has no such input.
    pub fn value(&self, input: usize, t: f64) -> Option<f64> {
        self.columns.iter().find(|column| column.0 == input).map(|column| self.from(&column.1, t)[0])
    }

    /// Sets the inputs as they go on from the present time.
    pub fn set(&self, simulation: &mut Simulation) {
        let now = simulation.time();
        for (input, values) in &self.columns {
            let [value, slope] = self.from(values, now);
            simulation.set_input(*input, value, slope, 0.0);
        }
    }

    /// Advances to time `to` [s] with inputs set anew at each row on the way, also at that of `to`.
    ///
    /// # Errors
    /// When the simulation cannot go on.
    pub fn advance(&self, simulation: &mut Simulation, to: f64) -> Result<(), SimulationError> {
        loop {
            let behind = self.times.partition_point(|time| *time <= simulation.time());
            match self.times.get(behind) {
                Some(row) if *row <= to => {
                    simulation.advance(*row)?;
                    self.set(simulation);
                }
                _ => return simulation.advance(to),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_lines_jumps_and_ends() {
        let table = InputTable::new(vec![1.0, 2.0, 2.0, 4.0], vec![(3, vec![1.0, 3.0, -1.0, 5.0])]).unwrap();
        let at = |t: f64| table.from(&table.columns[0].1, t);
        assert_eq!(
            [at(0.0), at(1.0), at(1.5), at(2.0), at(3.0), at(4.0), at(9.0)],
            [[1.0, 0.0], [1.0, 2.0], [2.0, 2.0], [-1.0, 3.0], [2.0, 3.0], [5.0, 0.0], [5.0, 0.0]]
        );
        assert_eq!([table.value(3, 2.0), table.value(2, 2.0)], [Some(-1.0), None]);
    }

    #[test]
    fn prop_what_is_no_table_is_refused() {
        let of = |times: &[f64]| InputTable::new(times.to_vec(), vec![]).unwrap_err();
        assert_eq!(of(&[]), InputTableError::Empty);
        assert_eq!(of(&[0.0, 1.0, 0.5]), InputTableError::Order { row: 2, before: 1.0, value: 0.5 });
        assert_eq!(of(&[0.0, 1.0, 1.0, 1.0]).row(), Some(3));
    }
}
