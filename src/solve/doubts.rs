//! What methods with a fixed step doubt of their own steps.

use serde::{Deserialize, Serialize};

/// Steps whose estimated error is no longer small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Doubts {
    /// How many.
    pub steps: u64,
    /// The largest error of forces, in parts of what the system allows, and of positions, m and rad.
    pub load: f64,
    pub position: f64,
    /// The largest that errors of forces of one step and of those shortly before came to.
    pub lasting_load: f64,
    /// End of the first of them, s.
    pub first: f64,
    /// How many of the last steps on end.
    pub(super) run: u64,
    /// What errors of forces of the last steps come to, in parts of what the system allows of one.
    pub(super) together: f64,
}

impl std::fmt::Display for Doubts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Doubts { steps, load, lasting_load, position, first, .. } = *self;
        write!(
            f,
            "{steps} steps, the first to t = {first:.6} s, were doubtful: contact forces off by up to {load:.0} times, together with the steps before by up to {lasting_load:.0} times what a step with error control may be, positions by {position:.1e} m or rad a step; reduce solver.step or choose an integrator with a tolerance"
        )
    }
}
