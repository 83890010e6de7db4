//! Continuation: from one balance to another through those between, in steps that grow while they go well and are halved where they don't.

use super::search::{Configuration, Search};
use crate::scene::equilibrium::EquilibriumError;

/// The balance before the last one: its parameter and configuration.
pub(super) struct Before(pub f64, pub Configuration);

impl Before {
    /// How far ahead of the last balance, at `done`, the next one lies, in parts of the way between the last two.
    pub fn ahead(&self, done: f64, next: f64) -> f64 {
        (next - done) / (done - self.0)
    }
}

/// Steps of a parameter, up or down.
pub(super) struct Steps {
    pub from: f64,
    pub to: f64,
    /// Length of the first one; by what it grows after a step that went well; a shorter one is given up.
    pub first: f64,
    pub growth: f64,
    pub shortest: f64,
}

impl Steps {
    /// Follows the balance, which `search` has at `from`. `balance` finds that at `next` from the last one, at `done`, and the one before.
    ///
    /// # Errors
    /// Where it went no further, and why; the last balance that was found is in place.
    pub fn follow(
        &self,
        search: &mut Search,
        mut balance: impl FnMut(&mut Search, f64, f64, Option<&Before>) -> Result<(), EquilibriumError>,
    ) -> Result<(), (f64, EquilibriumError)> {
        let up = self.to > self.from;
        let (mut done, mut step) = (self.from, self.first);
        let mut last = search.configuration();
        let mut before: Option<Before> = None;
        while done != self.to {
            let next = if up { f64::min(done + step, self.to) } else { f64::max(done - step, self.to) };
            match balance(search, done, next, before.as_ref()) {
                Ok(()) => {
                    let here = search.configuration();
                    before = Some(Before(done, std::mem::replace(&mut last, here)));
                    (done, step) = (next, self.growth * step);
                }
                Err(cause) => {
                    search.put(&last);
                    step = 0.5 * (next - done).abs();
                    if step < self.shortest || search.exhausted() {
                        return Err((next, cause));
                    }
                }
            }
        }
        Ok(())
    }
}
