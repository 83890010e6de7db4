//! Which variables of a wheelset are independent (section 3.2 of the paper).
//!
//! Variables are the wheelset's six coordinates and the four surface parameters of each wheel; two contacts make ten constraints.
//! A factorisation of their Jacobian with column pivoting picks ten variables that the constraints determine best; the rest,
//! coordinates or surface parameters, is integrated. The choice holds until the block of the dependent ones has become
//! clearly worse conditioned than it was.

use crate::contact::search::point_contact::{CONSTRAINTS, PARAMETERS};
use crate::mbs::body::COORDINATES;
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

pub const ROWS: usize = 2 * CONSTRAINTS;
pub const VARIABLES: usize = COORDINATES + 2 * PARAMETERS;

/// Constraints by variables.
pub type Jacobian = SMatrix<f64, ROWS, VARIABLES>;
pub type Square = SMatrix<f64, ROWS, ROWS>;
pub type Variables = SVector<f64, VARIABLES>;
pub type Rows = SVector<f64, ROWS>;

/// The dependent variables, in increasing order; saved as a mask with a bit for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u32", try_from = "u32")]
pub struct Partition {
    dependent: [usize; ROWS],
}

impl Partition {
    /// Picks dependent variables by pivoting; `None` when the constraints are not independent. Columns of surface parameters count
    /// `outweigh` times: the more, the sooner they are dependent, and coordinates, which inertia and suspension act on, are integrated.
    pub fn choose(jacobian: &Jacobian, outweigh: f64) -> Option<Partition> {
        const INDEPENDENT: f64 = 1e-9;
        let mut weighted = *jacobian;
        weighted.columns_mut(COORDINATES, VARIABLES - COORDINATES).scale_mut(outweigh);
        let factors = weighted.col_piv_qr();
        let r = factors.r();
        let first = r[(0, 0)].abs();
        if !(0..ROWS).all(|i| r[(i, i)].abs() > INDEPENDENT * first) {
            return None;
        }
        let mut order = SMatrix::<f64, 1, VARIABLES>::from_fn(|_, column| column as f64);
        factors.p().permute_columns(&mut order);
        let mut dependent: [usize; ROWS] = std::array::from_fn(|i| order[i] as usize);
        dependent.sort_unstable();
        Some(Partition { dependent })
    }

    pub fn is_dependent(&self, variable: usize) -> bool {
        self.dependent.contains(&variable)
    }

    /// Columns of the dependent variables.
    pub fn block(&self, jacobian: &Jacobian) -> Square {
        Square::from_fn(|row, column| jacobian[(row, self.dependent[column])])
    }

    /// Adds changes of the dependent variables to all variables.
    pub fn add(&self, variables: &mut Variables, change: &Rows) {
        for (variable, change) in self.dependent.iter().zip(change.iter()) {
            variables[*variable] += change;
        }
    }
}

impl From<Partition> for u32 {
    fn from(partition: Partition) -> u32 {
        partition.dependent.iter().fold(0, |mask, variable| mask | 1 << variable)
    }
}

/// A mask that marks another number of variables than there are constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:#b} is no choice of {ROWS} of {VARIABLES} variables")]
pub struct NoPartition(u32);

impl TryFrom<u32> for Partition {
    type Error = NoPartition;

    fn try_from(mask: u32) -> Result<Self, NoPartition> {
        let mut dependent = [0; ROWS];
        let mut variables = (0..VARIABLES).filter(|variable| mask >> variable & 1 == 1);
        for slot in &mut dependent {
            *slot = variables.next().ok_or(NoPartition(mask))?;
        }
        let all = variables.next().is_none() && mask >> VARIABLES == 0;
        all.then_some(Partition { dependent }).ok_or(NoPartition(mask))
    }
}

/// How well the block of the dependent variables is conditioned: its smallest over its largest pivot.
pub fn conditioning(block: &Square) -> f64 {
    let u = block.lu().u();
    let pivots = (0..ROWS).map(|i| u[(i, i)].abs());
    pivots.clone().fold(f64::INFINITY, f64::min) / pivots.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_pivoting_leaves_out_columns_that_say_nothing() {
        // Column 5 is empty, columns 1 and 7 nearly parallel, 3 and 4 tiny.
        let mut state = 7u32;
        let mut jacobian = Jacobian::from_fn(|_, _| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        });
        jacobian.column_mut(5).fill(0.0);
        let copy = jacobian.column(1) * (1.0 + 1e-6);
        jacobian.set_column(7, &copy);
        for tiny in [3, 4] {
            let scaled = jacobian.column(tiny) * 1e-3;
            jacobian.set_column(tiny, &scaled);
        }
        let partition = Partition::choose(&jacobian, 1.0).unwrap();
        assert!([3, 4, 5].iter().all(|tiny| !partition.is_dependent(*tiny)));
        assert!(!(partition.is_dependent(1) && partition.is_dependent(7)));
        assert!(conditioning(&partition.block(&jacobian)) > 1e-2);
        assert_eq!(Partition::try_from(u32::from(partition)), Ok(partition));
        for wrong in [0, u32::MAX, u32::from(partition) | 1 << VARIABLES] {
            assert_eq!(Partition::try_from(wrong), Err(NoPartition(wrong)));
        }

        let row = jacobian.row(2) + jacobian.row(3);
        jacobian.set_row(4, &row);
        assert_eq!(Partition::choose(&jacobian, 1.0), None, "dependent rows must be noticed");
    }
}
