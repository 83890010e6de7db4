//! What a table holds: lattice, shapes, slopes.

use super::coordinates::{RATIOS, Triple, size};

/// Sizes of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Lattice steps from the middle of the ball to its surface.
    pub steps: usize,
    /// Number of a/b, from 0.1 to 10.
    pub shapes: usize,
    /// Cells across each axis of the exact theory's grid.
    pub cells: usize,
    /// Poisson's ratio.
    pub nu: f64,
}

impl Layout {
    /// Lattice points stored along X or Z (0 to n + 1: one beyond the surface for the interpolation).
    fn half(&self) -> usize {
        self.steps + 2
    }

    fn full(&self) -> usize {
        2 * self.steps + 3
    }

    /// Points of one shape, stored in the order X, Y, Z (Z fastest).
    pub(crate) fn points(&self) -> usize {
        self.half() * self.full() * self.half()
    }

    /// Place in the ball of a stored point.
    pub(crate) fn place(&self, index: usize) -> Triple {
        let (half, full) = (self.half(), self.full());
        let [i, j, k] = [index / (half * full), index / half % full, index % half];
        [i as f64, j as f64 - (self.steps + 1) as f64, k as f64].map(|i| i / self.steps as f64)
    }

    /// Is the point close enough to the ball to be used?
    pub(crate) fn used(&self, u: Triple) -> bool {
        size(u) < 1.0 + 3.5 / self.steps as f64
    }

    pub(crate) fn ratio(&self, shape: usize) -> f64 {
        let (first, last) = RATIOS;
        first * (last / first).powf(shape as f64 / (self.shapes - 1) as f64)
    }
}

/// Slopes of the force over (X, Y, Z), all positive: Fx = -xx X, Fy = -yy Y - yz Z, Mz = zy Y - zz Z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Slopes(pub [f64; 5]);

impl Slopes {
    #[inline]
    pub(crate) fn force(&self, u: Triple) -> Triple {
        let [xx, yy, yz, zy, zz] = self.0;
        [-xx * u[0], -yy * u[1] - yz * u[2], zy * u[1] - zz * u[2]]
    }
}
