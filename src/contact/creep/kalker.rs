//! Kalker's linear theory: creep coefficients and the forces of vanishing slip.
//!
//! ```text
//! Fx = -G a b c11 xi_x
//! Fy = -G (a b c22 xi_y + (a b)^1.5 c23 phi)
//! Mz = -G (-(a b)^1.5 c23 xi_y + (a b)^2 c33 phi)          (c32 = -c23)
//! ```
//!
//! The coefficients depend on a/b and Poisson's ratio nu. Kalker's table has nu = 0, 0.25 and 0.5; a parabola in
//! nu through the three values serves other nu (between 0.25 and 0.5 it differs by up to 1 % from a parabola
//! through the reciprocals, which CONTACT uses). Over a/b a natural cubic spline in ln(a/b) is used. Outside the
//! table (a/b below 0.1 or above 10) Kalker's asymptotes go on, scaled by up to 6 % so that the value is continuous,
//! less so the shorter the ellipse.
//!
//! Error of the table itself against a spectral solution (tests/reference/adhesion.py): 0.3 % rms, at worst 1.2 %; beyond it, down to b/a or
//! a/b = 30, 2 %.

use super::slopes::CreepSlopes;
use crate::contact::creepage::{CreepForce, Creepage};
use crate::contact::{Material, Patch};
use crate::math::spline::CubicSpline;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// c11, c22, c23, c33.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    pub c11: f64,
    pub c22: f64,
    pub c23: f64,
    pub c33: f64,
}

impl Coefficients {
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Coefficients { c11: f(self.c11, other.c11), c22: f(self.c22, other.c22), c23: f(self.c23, other.c23), c33: f(self.c33, other.c33) }
    }
}

/// One row of the published table: nu, a/b and the coefficients.
#[derive(Clone, Copy, Debug)]
pub struct TableRow {
    pub poisson_ratio: f64,
    pub a_over_b: f64,
    pub coefficients: Coefficients,
}

/// A number or a fraction.
fn number(cell: &str) -> Option<f64> {
    match cell.split_once('/') {
        Some((above, below)) => Some(above.parse::<f64>().ok()? / below.parse::<f64>().ok()?),
        None => cell.parse().ok(),
    }
}

/// The published table.
pub fn published_table() -> Vec<TableRow> {
    include_str!("kalker_coefficients.csv")
        .lines()
        .filter(|line| !line.starts_with('#') && !line.starts_with("nu"))
        .filter_map(|line| {
            let numbers: Vec<f64> = line.split(',').filter_map(number).collect();
            let [poisson_ratio, a_over_b, c11, c22, c23, c33] = numbers[..] else { return None };
            Some(TableRow { poisson_ratio, a_over_b, coefficients: Coefficients { c11, c22, c23, c33 } })
        })
        .collect()
}

/// Limits for slender ellipses; `g` is the smaller of a/b and b/a. Source: Kalker 1990, Table E.3, as coded in CONTACT; for c33 of
/// long ellipses no source could be confirmed, and the form here was found from numbers: it is that of
/// tests/reference/adhesion.py to 1e-5 at a/b = 1000 for nu from 0 to 0.5.
fn asymptote(a_over_b: f64, nu: f64) -> Coefficients {
    if a_over_b < 1.0 {
        let g = a_over_b;
        Coefficients {
            c11: PI * PI / (4.0 * (1.0 - nu)),
            c22: PI * PI / 4.0,
            c23: PI * g.sqrt() / (3.0 * (1.0 - nu)) * (1.0 + nu * ((16.0 / g).ln() - 5.0)),
            c33: PI * PI / (16.0 * (1.0 - nu) * g),
        }
    } else {
        let g = 1.0 / a_over_b;
        let l = (16.0 / (g * g)).ln();
        let bulk = (1.0 - nu) * l - 2.0 + 4.0 * nu;
        let lateral = (1.0 - nu) * l + 2.0 * nu;
        let three = 3.0 - 4f64.ln();
        Coefficients {
            c11: 2.0 * PI / ((l - 2.0 * nu) * g) * (1.0 + three / (l - 2.0 * nu)),
            c22: 2.0 * PI / g * (1.0 + (1.0 - nu) * three / lateral) / lateral,
            c23: 2.0 * PI / (3.0 * g * g.sqrt()) / bulk,
            c33: PI / 4.0 * (((1.0 - 2.0 * nu) * l - 2.0 + 8.0 * nu) / bulk).powi(2),
        }
    }
}

/// Power of a/b with which short ellipses approach their limits (from tests/reference/adhesion.py: 1.5 to 2).
const APPROACH: f64 = 1.6;

/// Coefficients over a/b for one Poisson's ratio.
#[derive(Clone, Debug)]
pub struct KalkerTable {
    nu: f64,
    splines: [CubicSpline; 4],
    ends: (f64, f64),
}

impl KalkerTable {
    /// For Poisson's ratio `nu` in [0, 0.5].
    pub fn new(nu: f64) -> Self {
        let table = published_table();
        let row = |a_over_b: f64, node: f64| {
            table.iter().find(|row| row.poisson_ratio == node && row.a_over_b == a_over_b).map(|row| row.coefficients)
        };
        // Lagrange weights of the parabola through nu = 0, 0.25, 0.5.
        let weights = [(nu - 0.25) * (nu - 0.5) / 0.125, -nu * (nu - 0.5) / 0.0625, nu * (nu - 0.25) / 0.125];
        let nodes: Vec<(f64, Coefficients)> = table
            .iter()
            .filter(|row| row.poisson_ratio == 0.0)
            .filter_map(|first| {
                let [c0, c1, c2] = [0.0, 0.25, 0.5].map(|node| row(first.a_over_b, node));
                let scaled = |c: Coefficients, w: f64| c.map2(c, |x, _| w * x);
                let add = |a: Coefficients, b: Coefficients| a.map2(b, |x, y| x + y);
                Some((first.a_over_b, add(add(scaled(c0?, weights[0]), scaled(c1?, weights[1])), scaled(c2?, weights[2]))))
            })
            .collect();
        let spline = |pick: fn(&Coefficients) -> f64| {
            let points: Vec<(f64, f64)> = nodes.iter().map(|(a_over_b, c)| (a_over_b.ln(), pick(c))).collect();
            CubicSpline::natural(&points).unwrap_or_else(|error| unreachable!("Kalker's table: {error}"))
        };
        let splines = [spline(|c| c.c11), spline(|c| c.c22), spline(|c| c.c23), spline(|c| c.c33)];
        KalkerTable { nu, splines, ends: (nodes[0].0, nodes[nodes.len() - 1].0) }
    }

    /// Coefficients at `a_over_b` > 0.
    #[inline]
    pub fn at(&self, a_over_b: f64) -> Coefficients {
        let (first, last) = self.ends;
        let inside = a_over_b.clamp(first, last);
        let [c11, c22, c23, c33] = CubicSpline::values(&self.splines, inside.ln());
        let table = Coefficients { c11, c22, c23, c33 };
        if a_over_b == inside {
            return table;
        }
        // Short ellipses are near their limits soon; long ones approach theirs like a logarithm, so their distance stays.
        let left = if a_over_b < first { (a_over_b / first).powf(APPROACH) } else { 1.0 };
        let scaling = table.map2(asymptote(inside, self.nu), |c, limit| 1.0 + (c / limit - 1.0) * left);
        asymptote(a_over_b, self.nu).map2(scaling, |limit, scaling| limit * scaling)
    }
}

/// The linear theory for one material.
#[derive(Clone, Debug)]
pub struct LinearTheory {
    shear_modulus: f64,
    table: KalkerTable,
}

impl LinearTheory {
    pub fn new(material: Material) -> Self {
        LinearTheory { shear_modulus: material.shear_modulus(), table: KalkerTable::new(material.poisson_ratio) }
    }

    /// G, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    /// Creep coefficients of a patch that is not empty.
    #[inline]
    pub fn coefficients(&self, patch: Patch) -> Coefficients {
        self.table.at(patch.a / patch.b)
    }

    /// Forces without slip, not bounded by friction; zero on an empty patch.
    #[inline]
    pub fn force(&self, patch: Patch, creepage: Creepage) -> CreepForce {
        if !(patch.a > 0.0 && patch.b > 0.0) {
            return CreepForce::default();
        }
        let c = self.table.at(patch.a / patch.b);
        let area = patch.a * patch.b;
        let coupling = area * area.sqrt() * c.c23;
        let g = self.shear_modulus;
        CreepForce {
            longitudinal: -g * area * c.c11 * creepage.longitudinal,
            lateral: -g * (area * c.c22 * creepage.lateral + coupling * creepage.spin),
            spin_moment: -g * (area * area * c.c33 * creepage.spin - coupling * creepage.lateral),
        }
    }

    /// Derivatives of [`LinearTheory::force`]; a b grows with N^(2/3).
    pub fn slopes(&self, patch: Patch, creepage: Creepage, normal_force: f64) -> CreepSlopes {
        if !(patch.a > 0.0 && patch.b > 0.0 && normal_force > 0.0) {
            return CreepSlopes::default();
        }
        let c = self.table.at(patch.a / patch.b);
        let (g, area) = (-self.shear_modulus, patch.a * patch.b);
        let (coupling, moment) = (g * area * area.sqrt() * c.c23, g * area * area * c.c33);
        let by_creepage = Matrix3::new(g * area * c.c11, 0.0, 0.0, 0.0, g * area * c.c22, coupling, 0.0, -coupling, moment);
        let Creepage { longitudinal: x, lateral: y, spin } = creepage;
        let by_normal_force = Vector3::new(
            2.0 / 3.0 * by_creepage[(0, 0)] * x,
            2.0 / 3.0 * by_creepage[(1, 1)] * y + coupling * spin,
            4.0 / 3.0 * moment * spin - coupling * y,
        ) / normal_force;
        CreepSlopes { by_creepage, by_normal_force }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn validate_published_nodes_are_reproduced() {
        for row in published_table() {
            let found = KalkerTable::new(row.poisson_ratio).at(row.a_over_b);
            let difference = found.map2(row.coefficients, |a, b| (a / b - 1.0).abs());
            assert!([difference.c11, difference.c22, difference.c23, difference.c33].iter().all(|d| *d < 1e-13), "{row:?} {found:?}");
        }
    }

    #[test]
    fn validate_nodes_are_those_of_the_publication() {
        // a/b and b/a = 0.1, 0.2 .. 1 for each nu.
        let table = published_table();
        let mut nodes: Vec<f64> = (1..=10).map(|k| f64::from(k) / 10.0).collect();
        nodes.extend((1..10).rev().map(|k| 10.0 / f64::from(k)));
        for nu in [0.0, 0.25, 0.5] {
            let found: Vec<f64> = table.iter().filter(|row| row.poisson_ratio == nu).map(|row| row.a_over_b).collect();
            assert!(found.len() == nodes.len() && found.iter().zip(&nodes).all(|(f, n)| (f / n - 1.0).abs() < 1e-15), "{found:?}");
        }
    }

    #[test]
    fn validate_against_the_exact_program_between_nodes_of_nu() {
        // a/b, then c11, c22, c23, c33 at nu = 0.28, computed by CONTACT v25.2 with full adhesion on 66 x 66 and
        // 33 x 33 grids, extrapolated: 0.4 to 2.6 % low, because its cells cover more than the ellipse (exact/tests.rs).
        const EXACT: [(f64, [f64; 4]); 7] = [
            (0.1, [3.4285, 2.5140, 0.4871, 8.6089]),
            (0.3, [3.5510, 2.7430, 0.7215, 3.0415]),
            (0.5, [3.7158, 3.0042, 0.9286, 1.9615]),
            (1.0, [4.1624, 3.6493, 1.4484, 1.1564]),
            (2.0, [5.1833, 4.9571, 2.6410, 0.7918]),
            (5.0, [7.8770, 8.2804, 6.6586, 0.5677]),
            (10.0, [11.7962, 13.0600, 14.5242, 0.4695]),
        ];
        let table = KalkerTable::new(0.28);
        let mut worst = [0f64; 4];
        for (a_over_b, exact) in EXACT {
            let c = table.at(a_over_b);
            for (worst, (found, exact)) in worst.iter_mut().zip([c.c11, c.c22, c.c23, c.c33].into_iter().zip(exact)) {
                *worst = worst.max((found / exact - 1.0).abs());
            }
        }
        println!("largest difference from the exact program at nu = 0.28: c11, c22, c23, c33 {worst:.4?}");
        assert!(worst[0] < 0.02 && worst[1] < 0.02 && worst[2] < 0.035 && worst[3] < 0.055, "{worst:?}");
    }

    #[test]
    fn validate_slender_ellipses_against_the_spectral_solution() {
        // nu, a/b, then c11, c22, c23, c33 by tests/reference/adhesion.py. Beyond the table (0.1 to 10) its end is scaled.
        const SPECTRAL: [(f64, f64, [f64; 4]); 8] = [
            (0.28, 1.0 / 30.0, [3.42914, 2.47759, 0.355347, 25.7018]),
            (0.28, 0.05, [3.43228, 2.48755, 0.401185, 17.1517]),
            (0.28, 20.0, [18.9614, 21.9493, 34.4824, 0.450108]),
            (0.28, 30.0, [25.3711, 29.889, 57.2125, 0.432249]),
            (0.5, 1.0 / 30.0, [4.91396, 2.47633, 0.607366, 36.4807]),
            (0.5, 0.05, [4.90043, 2.48678, 0.653203, 24.1027]),
            (0.5, 20.0, [20.2937, 27.4294, 42.7915, 0.163321]),
            (0.5, 30.0, [26.9565, 37.7949, 71.9177, 0.136959]),
        ];
        for (nu, a_over_b, spectral) in SPECTRAL {
            let c = KalkerTable::new(nu).at(a_over_b);
            let off: Vec<f64> = [c.c11, c.c22, c.c23, c.c33].iter().zip(spectral).map(|(c, s)| 100.0 * (c / s - 1.0)).collect();
            println!("nu {nu}, a/b {a_over_b:.3}: off by {off:.2?} %");
            assert!(off.iter().all(|off| off.abs() < 2.0), "{off:?}");
        }
    }

    #[test]
    fn prop_continuous_across_the_ends_of_the_table() {
        for nu in [0.0, 0.25, 0.28, 0.5] {
            let table = KalkerTable::new(nu);
            for end in [0.1, 10.0] {
                let jump = table.at(end * (1.0 - 1e-9)).map2(table.at(end * (1.0 + 1e-9)), |a, b| (a / b - 1.0).abs());
                assert!([jump.c11, jump.c22, jump.c23, jump.c33].iter().all(|j| *j < 1e-7), "{nu} {end} {jump:?}");
            }
            for a_over_b in [1e-3, 0.05, 20.0, 1e3] {
                let c = table.at(a_over_b);
                assert!([c.c11, c.c22, c.c23, c.c33].iter().all(|c| c.is_finite() && *c > 0.0), "{nu} {a_over_b} {c:?}");
            }
        }
    }
}
