//! Rows and results of the constraints of a system.
//!
//! The rows are those of the joints, in order, then one per contact (on one body each), which the formulation fills.

use super::body::COORDINATES;
use super::kkt::{Kkt, RowBodies};

/// Rows and results of the constraints at one instant; all vectors are empty when there are none.
#[derive(Clone, Debug)]
pub struct Constraints {
    pub kkt: Kkt,
    /// Number of rows that belong to joints; those of contacts follow.
    pub joint_rows: usize,
    /// Per row: the constraint phi and its rate phi'.
    pub residual: Vec<f64>,
    pub rate: Vec<f64>,
    /// Right-hand side of `J q'' = gamma`, per row.
    pub gamma: Vec<f64>,
    /// Accelerations without constraints, six per body.
    pub free: Vec<f64>,
    pub accelerations: Vec<f64>,
    /// lambda of `M q'' + J^T lambda = Q`, per row.
    pub multipliers: Vec<f64>,
}

impl Constraints {
    /// Of so many bodies with the rows of their joints, of which some are redundant, and one row per contact.
    pub(super) fn new(bodies: usize, mut rows: Vec<RowBodies>, redundant: &[usize], contact_bodies: &[usize]) -> Self {
        let joint_rows = rows.len();
        rows.extend(contact_bodies.iter().map(|body| RowBodies { first: *body, second: None }));
        let per_row = vec![0.0; rows.len()];
        let per_coordinate = vec![0.0; if rows.is_empty() { 0 } else { COORDINATES * bodies }];
        let mut kkt = Kkt::new(bodies, &rows);
        for row in redundant {
            kkt.set_active(*row, false);
        }
        Constraints {
            kkt,
            joint_rows,
            residual: per_row.clone(),
            rate: per_row.clone(),
            gamma: per_row.clone(),
            free: per_coordinate.clone(),
            accelerations: per_coordinate,
            multipliers: per_row,
        }
    }

    /// Accelerations and multipliers from `free` and `gamma`. Needs a factorisation.
    #[inline]
    pub fn solve(&mut self) {
        self.kkt.solve(&self.free, &self.gamma, &mut self.accelerations, &mut self.multipliers);
    }

    /// Largest absolute value of one number per row (residuals, rates) over the active rows, and its row.
    pub fn largest(&self, values: &[f64]) -> (f64, usize) {
        let active = values.iter().enumerate().filter(|(row, _)| self.kkt.is_active(*row));
        active.fold((0.0, 0), |largest, (row, value)| if value.abs() > largest.0 || value.is_nan() { (value.abs(), row) } else { largest })
    }
}
