//! Work counters of the formulations.

use serde::{Deserialize, Serialize};

/// What evaluations have done; every evaluation counts up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Newton iterations of contact searches (ECF-A, ECCF), or pairs of nodes looked at (ECF-N).
    pub search_iterations: u64,
    /// Evaluations of the loop between normal forces and creep forces (ACCF, ECCF).
    pub force_iterations: u64,
    /// Newton iterations on the position constraints (ACCF, ECCF).
    pub constraint_iterations: u64,
    /// New choices of independent variables (ACCF).
    pub partitions: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.search_iterations += other.search_iterations;
        self.force_iterations += other.force_iterations;
        self.constraint_iterations += other.constraint_iterations;
        self.partitions += other.partitions;
    }
}
