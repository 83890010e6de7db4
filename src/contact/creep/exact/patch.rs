//! The steady problem of one ellipse, made dimensionless: it depends on a/b, nu and three numbers.
//!
//! With lengths in `c = sqrt(a b)` and tractions in `mu p0`, the creepages enter as `G xi / (mu p0)` and
//! `G c phi / (mu p0)`, and the force comes out in mu N, the moment in mu N c. Slip over the rolled distance:
//! `s = (xi - phi y, eta + phi x) - du/dx` (see [`rolling`]).

use super::normal::LOAD;
use crate::contact::half_space::cells::Pressure;
use crate::contact::half_space::influence::{Convolver, Kernel, Pair};
use crate::contact::half_space::rolling;
use crate::contact::half_space::tangential::{Limits, Outcome, Tangential, Workspace};

/// Grid and influence of steady rolling for one a/b.
#[derive(Clone, Debug)]
pub(crate) struct SteadyPatch {
    pub pressure: Pressure,
    pub convolver: Convolver,
    kernel: Kernel,
}

/// Force along e1, e2 in mu N and moment in mu N c.
pub(crate) fn resultant(pressure: &Pressure, tractions: &[Pair]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (p, at) in tractions.iter().zip(&pressure.places) {
        sum = [sum[0] + p[0], sum[1] + p[1], sum[2] + at[0] * p[1] - at[1] * p[0]];
    }
    sum.map(|sum| sum * pressure.size[0] * pressure.size[1] / LOAD)
}

/// Limit of fine grids from one grid and one with half as many cells; force in mu N, never above 1.
pub(crate) fn extrapolated(fine: [f64; 3], coarse: [f64; 3]) -> [f64; 3] {
    let [x, y, spin]: [f64; 3] = std::array::from_fn(|k| 2.0 * fine[k] - coarse[k]);
    let cut = 1.0 / x.hypot(y).max(1.0);
    [x * cut, y * cut, spin]
}

impl SteadyPatch {
    pub(crate) fn new(a_over_b: f64, nu: f64, convolver: &Convolver) -> Self {
        Self::on(Pressure::ellipsoid(a_over_b, convolver.columns), nu, convolver)
    }

    /// On given cells and pressures.
    pub(crate) fn on(pressure: Pressure, nu: f64, convolver: &Convolver) -> Self {
        let kernel = rolling::kernel(pressure.size, nu, convolver);
        SteadyPatch { pressure, convolver: convolver.clone(), kernel }
    }

    /// Slip per distance rolled, without tractions, for dimensionless creepages.
    pub(crate) fn rigid(&self, [xi, eta, phi]: [f64; 3]) -> Vec<Pair> {
        self.pressure.places.iter().map(|at| [xi - phi * at[1], eta + phi * at[0]]).collect()
    }

    pub(crate) fn tangential(&self) -> Tangential<'_> {
        Tangential { pressure: &self.pressure, convolver: &self.convolver, kernel: &self.kernel }
    }

    /// Force and moment for dimensionless creepages; `p` is where to start (resized if need be) and the solution.
    pub(crate) fn solve(&self, creepage: [f64; 3], p: &mut Vec<Pair>, limits: Limits, workspace: &mut Workspace) -> ([f64; 3], Outcome) {
        p.resize(self.pressure.cells.len(), [0.0; 2]);
        let outcome = self.tangential().solve(&self.rigid(creepage), p, limits, workspace);
        (resultant(&self.pressure, p), outcome)
    }
}
