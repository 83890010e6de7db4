//! The error of a step as it counts against the tolerance.

use super::Implicit;

/// The stage that holds f at the end of a step, and one for work on it.
pub(super) const END: usize = 7;
pub(super) const WORK: usize = 8;

/// An error of the state as it counts: of controlled components; of forces, and against the motion's own size and strikes to come, in parts of what is allowed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LocalError {
    pub state: f64,
    pub load: f64,
    pub swing: f64,
}

impl LocalError {
    /// Of an error vector; infinite where it is not finite.
    pub fn of(dynamics: &dyn Implicit, error: &[f64]) -> LocalError {
        let mut largest: f64 = 0.0;
        for (i, error) in error.iter().enumerate() {
            if !error.is_finite() {
                return LocalError { state: f64::INFINITY, load: f64::INFINITY, swing: f64::INFINITY };
            }
            largest = largest.max(dynamics.error_weight(i) * error.abs());
        }
        LocalError { state: largest, load: dynamics.load_error(error), swing: dynamics.swing_error(error) }
    }

    /// Of an error vector whose positions all count alike.
    pub fn unweighted(dynamics: &dyn Implicit, error: &[f64]) -> LocalError {
        let weighted = LocalError::of(dynamics, error);
        let plain = error.iter().enumerate().map(|(i, error)| dynamics.plain_weight(i) * error.abs());
        LocalError { state: if weighted.state.is_finite() { plain.fold(0.0, f64::max) } else { weighted.state }, ..weighted }
    }

    /// Is either as large as the other's?
    pub fn reaches(&self, other: &LocalError) -> bool {
        self.state >= other.state || self.load >= other.load
    }

    /// In parts of what is allowed.
    pub fn over(&self, tolerance: f64) -> f64 {
        (self.state / tolerance).max(self.load).max(self.swing)
    }
}
