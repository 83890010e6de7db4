//! Rolling and shifting step by step: the tractions of the last step are remembered.
//!
//! A particle that is at x now was at `x + dq` (dq: distance rolled) before the step, so it has slipped by
//! `S = W + u(x) - u'(x + dq)` with the rigid shift W = wheel minus rail over the step and u' the displacement
//! difference before; a turn of the wheel counts at the cell's middle, as in [`super::patch`]. Coulomb's law holds for S. `dq = 0` is a shift without rolling (Cattaneo's problem).
//! The patch is taken as the same ellipse during a step: tractions are handed on as values at (x/a, y/b). Friction
//! bound and load may change from step to step.

use super::{Exact, Solution};
use crate::contact::Patch;
use crate::contact::creep::RollingContact;
use crate::contact::half_space::cells::Pressure;
use crate::contact::half_space::influence::Pair;
use crate::contact::half_space::rolling::influence;
use crate::contact::half_space::tangential::{Tangential, Workspace};

/// What happens in a step; creepages of the contact are not used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Increment {
    /// Distance rolled along +e1, m, not negative.
    pub rolled: f64,
    /// Rigid shift of the wheel relative to the rail at the middle of the patch along e1, e2, m.
    pub shift: [f64; 2],
    /// Rigid turn of the wheel relative to the rail about the normal, rad.
    pub turn: f64,
}

impl Increment {
    /// Rolling over `rolled` [m] with the creepages of `contact`.
    pub fn rolling(contact: &RollingContact, rolled: f64) -> Self {
        let creepage = contact.creepage;
        Increment { rolled, shift: [creepage.longitudinal * rolled, creepage.lateral * rolled], turn: creepage.spin * rolled }
    }
}

impl Exact {
    /// Tractions after one more step; `previous` is the end of the last one, or `None` for an unloaded start.
    /// Zero where the friction bound is zero.
    pub fn advance(&self, contact: &RollingContact, previous: Option<&Solution>, increment: Increment) -> Solution {
        let Some(scale) = self.scale(contact) else { return Solution::default() };
        let pressure = Pressure::ellipsoid(scale.a_over_b, self.convolver.columns);
        let (size, nu) = (pressure.size, self.nu);
        let rolled = increment.rolled / scale.length;
        let now = self.convolver.kernel(|i, j| influence(size, nu, 0.0, (i, j)));
        let tangential = Tangential { pressure: &pressure, convolver: &self.convolver, kernel: &now };
        let mut workspace = Workspace::new(&self.convolver);
        let to_shift = scale.creep / scale.length;
        let (shift, turn) = (increment.shift.map(|w| w * to_shift), increment.turn * scale.creep);
        let mut rigid: Vec<Pair> = pressure.places.iter().map(|at| [shift[0] - turn * at[1], shift[1] + turn * at[0]]).collect();
        let mut p = vec![[0.0; 2]; rigid.len()];
        if let Some(previous) = previous.filter(|previous| previous.cells.len() == p.len()) {
            for (p, cell) in p.iter_mut().zip(&previous.cells) {
                *p = cell.traction.map(|traction| traction / scale.stress);
            }
            let before = self.convolver.kernel(|i, j| influence(size, nu, rolled, (i, j)));
            let mut old = vec![[0.0; 2]; p.len()];
            self.convolver.apply(&before, &pressure.cells, &p, &mut old, &mut self.convolver.buffers());
            for (w, u) in rigid.iter_mut().zip(&old) {
                *w = [w[0] - u[0], w[1] - u[1]];
            }
        }
        let outcome = tangential.solve(&rigid, &mut p, self.limits(), &mut workspace);
        let slip = tangential.slip_of(&rigid, &p, &mut workspace);
        // Slip of a step is a length.
        let slip: Vec<Pair> = slip.iter().map(|s| s.map(|s| s / to_shift)).collect();
        self.solution(&scale, &pressure, &p, &slip, outcome)
    }

    /// Length of a cell along e1, m: a good distance to roll per step.
    pub fn cell_length(&self, patch: Patch) -> f64 {
        let pressure = Pressure::ellipsoid(patch.a / patch.b, self.convolver.columns);
        pressure.size[0] * (patch.a * patch.b).sqrt()
    }
}
