//! The steady problem of one ellipse, made dimensionless: it depends on a/b, nu and three numbers.
//!
//! With lengths in `c = sqrt(a b)` and tractions in `mu p0`, the creepages enter as `G xi / (mu p0)` and
//! `G c phi / (mu p0)`, and the force comes out in mu N, the moment in mu N c. Slip over the rolled distance, for a
//! traction that stands still in the moving patch: `s = (xi - phi y, eta + phi x) - du/dx`, the derivative taken
//! over one cell, from the cell's middle to the next middle ahead. (Taking x at the cell's middle, not half way to the
//! next one, keeps c32 = -c23 on every grid to four digits; CONTACT takes it a sixth of a cell ahead.)

use super::influence::{Convolver, Influence, Kernel, Pair, rectangle};
use super::normal::{LOAD, Pressure};
use super::tangential::{Limits, Outcome, Tangential, Workspace};

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

/// Displacement difference `shift` ahead of a cell i columns and j rows away from a loaded one.
pub(crate) fn influence(size: Pair, nu: f64, shift: f64, (i, j): (i32, i32)) -> Influence {
    let [xx, yy, xy, _] = rectangle(i as f64 * size[0] + shift, j as f64 * size[1], size, nu);
    [xx, yy, xy]
}

impl SteadyPatch {
    pub(crate) fn new(a_over_b: f64, nu: f64, convolver: &Convolver) -> Self {
        Self::on(Pressure::new(a_over_b, convolver.n), nu, convolver)
    }

    /// On given cells and pressures.
    pub(crate) fn on(pressure: Pressure, nu: f64, convolver: &Convolver) -> Self {
        let n = convolver.n;
        let size = pressure.size;
        // Each influence is needed for its own place and as the one ahead of another; xy is odd across the strips.
        let width = 2 * n as i32;
        let all: Vec<Influence> =
            (0..n as i32).flat_map(|j| (1 - n as i32..=n as i32).map(move |i| influence(size, nu, 0.0, (i, j)))).collect();
        let at = |i: i32, j: i32| {
            let [xx, yy, xy] = all[(j.abs() * width + i + n as i32 - 1) as usize];
            [xx, yy, xy * f64::from(j.signum())]
        };
        let kernel = convolver.kernel(|i, j| {
            let (here, ahead) = (at(i, j), at(i + 1, j));
            std::array::from_fn(|k| (here[k] - ahead[k]) / size[0])
        });
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
