//! The normal problem on the grid: cells in contact and the pressure that bounds their traction.
//!
//! Wheel and rail of the same material: tangential tractions do not press, so the normal problem stands alone and
//! has Hertz's closed solution, the ellipsoid `p0 sqrt(1 - x^2/a^2 - y^2/b^2)`, `p0 = 3 N / (2 pi a b)`. It is used
//! itself, sampled at the middles of those cells whose middle lies in the ellipse, then scaled so that the cells
//! carry N exactly. The cells are stretched a little (0.5 % at 32 x 32) so that together they have the area of the
//! ellipse: this takes out most of the stairs' effect, and the error left is nearly proportional to the cell size.
//! A pressure solved numerically on the grid differs from Hertz's by the grid's error only.
//!
//! Lengths are divided by sqrt(a b), pressure by p0.

use crate::contact::half_space::cells::Pressure;
use crate::contact::half_space::influence::Cell;
use std::f64::consts::PI;

/// Normal load of the ellipsoid in these units.
pub(crate) const LOAD: f64 = 2.0 * PI / 3.0;

impl Pressure {
    /// `n` cells across each axis of an ellipse with `a/b`.
    pub(crate) fn ellipsoid(a_over_b: f64, n: usize) -> Self {
        let a = a_over_b.sqrt();
        let middle = |k: usize| (2 * k + 1) as f64 / n as f64 - 1.0;
        let mut pressure = Pressure { size: [0.0; 2], cells: Vec::new(), places: Vec::new(), values: Vec::new() };
        for row in 0..n {
            for column in (0..n).rev() {
                let (x, y) = (middle(column), middle(row));
                let height = 1.0 - x * x - y * y;
                if height > 0.0 {
                    pressure.cells.push(Cell { column, row });
                    pressure.places.push([x, y]);
                    pressure.values.push(height.sqrt());
                }
            }
        }
        let stretch = (PI * (n * n) as f64 / (4 * pressure.cells.len()) as f64).sqrt();
        let axes = [a * stretch, stretch / a];
        pressure.size = axes.map(|axis| 2.0 * axis / n as f64);
        for place in &mut pressure.places {
            *place = [place[0] * axes[0], place[1] * axes[1]];
        }
        let size = pressure.size;
        let load: f64 = pressure.values.iter().sum::<f64>() * size[0] * size[1];
        for value in &mut pressure.values {
            *value *= LOAD / load;
        }
        pressure
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::half_space::influence::rectangle;
    use ellip::legendre::{ellipe, ellipk};

    #[test]
    fn analytic_ellipsoid_presses_a_paraboloid_with_hertz_curvatures() {
        // Approach and curvature along the axes from complete elliptic integrals (a > b): u(0) = 2 (1-nu) p0 b K / G.. in
        // these units u(x, 0) = (1 - nu) b [K - (K - E) x^2 / (a^2 e^2)], u(0, y): the sum of both curvatures by E.
        let (nu, ratio, n) = (0.28, 2.0, 64);
        let pressure = Pressure::ellipsoid(ratio, n);
        let (a, b) = (f64::sqrt(ratio), 1.0 / f64::sqrt(ratio));
        let m = 1.0 - 1.0 / (ratio * ratio);
        let (k, e) = (ellipk(m).unwrap(), ellipe(m).unwrap());
        let depth = |x: f64, y: f64| {
            (1.0 - nu) * b * (k - (k - e) / m * (x / a) * (x / a) - (e / (1.0 - m) - k) * (1.0 - m) / m * (y / b) * (y / b))
        };
        let mut worst: f64 = 0.0;
        for at in pressure.places.iter().step_by(7) {
            let found: f64 = pressure
                .places
                .iter()
                .zip(&pressure.values)
                .map(|(from, p)| p * rectangle(at[0] - from[0], at[1] - from[1], pressure.size, nu)[3])
                .sum();
            worst = worst.max((found - depth(at[0], at[1])).abs() / depth(0.0, 0.0));
        }
        println!("ellipsoid on {n} x {n} cells: depth differs by at most {worst:.2e} of the approach");
        assert!(worst < 0.01, "{worst}");
    }

    #[test]
    fn prop_cells_carry_the_load_and_run_backward() {
        let pressure = Pressure::ellipsoid(0.3, 16);
        let load: f64 = pressure.values.iter().sum::<f64>() * pressure.size[0] * pressure.size[1];
        assert!((load / LOAD - 1.0).abs() < 1e-14);
        for k in 1..pressure.cells.len() {
            assert!(!pressure.has_ahead(k) || pressure.cells[k].column + 1 == pressure.cells[k - 1].column);
        }
    }
}
