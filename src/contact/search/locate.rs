//! Finds one contact: in the rail's section, and where that does not converge at once by the four equations.

use super::algebraic::{Candidate, ContactLocation, Pair, SurfaceParameters};
use super::section;
use crate::math::newton::NewtonFailure;
use nalgebra::Vector4;

impl Pair<'_> {
    /// Finds the contact and what the surfaces are like there, from a warm start.
    ///
    /// # Errors
    /// [`NewtonFailure`] when the iteration finds no solution.
    #[inline]
    pub(super) fn solve(&self, start: &SurfaceParameters) -> Result<(ContactLocation, Candidate), NewtonFailure> {
        let Some(location) = section::locate(self, start) else { return self.solve_four(start) };
        let p = &location.parameters;
        let (_, found) = self.residual(&Vector4::new(p.wheel, p.angle, p.lead, p.rail));
        Ok((location, found))
    }

    /// Finds the contact from a warm start.
    ///
    /// # Errors
    /// [`NewtonFailure`] when the iteration finds no solution.
    #[inline]
    pub fn locate(&self, start: &SurfaceParameters) -> Result<ContactLocation, NewtonFailure> {
        section::locate(self, start).map_or_else(|| self.solve_four(start).map(|(location, _)| location), Ok)
    }
}
