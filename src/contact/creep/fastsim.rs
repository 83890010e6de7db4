//! FASTSIM: Kalker's simplified theory with three flexibilities and a parabolic bound.
//!
//! ```text
//! traction p along a strip at y, x from the leading edge sqrt(1-(y/b)^2) a backward (-x is the direction of a particle):
//!   stick:  dp/d(-x) = -(xi_x/L1 - phi y/L3,  xi_y/L2 + phi x/L3)
//!   slip:   as stick, then shortened to the bound:  |p| = mu p0 (1 - x^2/a^2 - y^2/b^2),   p0 = 2 N/(pi a b)
//!   L1 = 8 a/(3 G c11),   L2 = 8 a/(3 G c22),   L3 = pi a sqrt(a/b)/(4 G c23)
//! ```
//!
//! Source: J. J. Kalker, Vehicle System Dynamics 11 (1982), 1-13. With these L the slopes at zero creepage are those of the
//! linear theory, the moment's excepted: this theory's own moment of spin follows from its tractions. The theory itself is 2 %
//! of mu N (mean) off the exact one, more than 10 % for large spin; the elliptic pressure of Hertz is not its bound.
//!
//! Numerics: `strips` strips (default 20), see [`super::strips`]. In each the stick area that begins at the leading edge and
//! its end are found in closed form (a quadratic equation). The rest has `cells` equal cells (default 20), each a step of implicit
//! Euler for the direction of traction, whose slip is taken three quarters down the cell (measured best); forces are
//! integrated by the trapezoidal rule with end correction, exact where the direction is constant. A return to stick within
//! the slip area (large spin) is resolved by cells. Everything is scaled with a, b and mu N: no allocation, no branches.
//! Error against 300 x 600, random cases of up to five times saturation: mean 0.003 mu N, 95 % 0.015 (20 x 20); with 10 x 10
//! 0.008 and 0.04. Force and its slopes are continuous but for cells that change between stick and slip.
//!
//! `friction_ratio`, `friction_decay`: friction that falls with sliding, see [`super::falling_friction`]; default constant.

use super::demand::Demand;
use super::falling_friction::FallingFriction;
use super::kalker::LinearTheory;
use super::strips::{Bundle, FEWEST, LANES, Lanes, Strips, count, sum};
use super::{Build, CreepLaw, RollingContact};
use crate::contact::Material;
use crate::contact::creepage::CreepForce;
use crate::settings::{Entry, Section, SettingsError};
use std::f64::consts::PI;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "fastsim",
    summary: "Kalker's simplified theory, three flexibilities, parabolic bound; strips = 20, cells = 20, falling friction",
    reference: "Kalker, Vehicle System Dynamics 11 (1982), 1-13",
    parse,
};

/// The simplified theory.
#[derive(Debug, Clone)]
pub struct Fastsim {
    linear: LinearTheory,
    strips: Strips,
    cells: usize,
    friction: FallingFriction,
}

/// Where scenes name none.
const STRIPS: usize = 20;
const CELLS: usize = 20;

/// Slip per bound, scaled with a: growth of traction over x/a, y/b.
#[derive(Clone, Copy)]
struct Growth {
    /// a xi_x / (L1 mu p0), a xi_y / (L2 mu p0), a^2 phi / (L3 mu p0).
    longitudinal: f64,
    lateral: f64,
    spin: f64,
    /// b / a.
    width: f64,
}

/// Smallest length of a slip area, in units of a: keeps quotients finite.
const TINY: f64 = 1e-30;

/// Integrals over a bundle: longitudinal, lateral, moment of the lateral traction; in units of mu p0, a, b.
#[inline]
fn bundle(strips: &Bundle, growth: Growth, cells: usize) -> [f64; 3] {
    let Growth { longitudinal: gx, lateral: gy, spin: gs, width } = growth;
    let turn = gy * gs;
    let size = 1.0 - 0.25 * gs * gs;
    let per_cell = 1.0 / cells as f64;
    let zero: Lanes = [0.0; LANES];
    // State of the march: distance from the trailing edge, step, traction, sums.
    let (mut v, mut step, mut px, mut py) = (zero, zero, zero, zero);
    let (mut slope_x, mut slope_y) = (zero, zero);
    let (mut sum_x, mut sum_y, mut sum_m) = (zero, zero, zero);
    let (mut fx, mut fy, mut mz) = (zero, zero, zero);
    for i in 0..LANES {
        let half = strips.half[i];
        let length = 2.0 * half;
        let sx = gx - gs * width * strips.y[i];
        let sy = gy + gs * half;
        // Stick ends where sx^2 + (gy + gs v/2)^2 = v^2.
        let constant = sx * sx + gy * gy;
        let root = (turn * turn + 4.0 * size * constant).max(0.0).sqrt();
        let slip = 2.0 * constant / (root - turn + 1e-300);
        let at_once = sx * sx + sy * sy > length * length;
        let slip = if at_once || !(slip < length) { length } else { slip };
        let slip = if slip > TINY { slip } else { TINY };
        let stick = length - slip;
        let half_square = 0.5 * stick * stick;
        let (tx, ty) = (sx, sy - 0.5 * gs * stick);
        fx[i] = sx * half_square;
        fy[i] = half_square * (sy - gs * stick * (1.0 / 3.0));
        mz[i] = half * fy[i] - half_square * stick * (sy * (2.0 / 3.0) - 0.25 * gs * stick);
        // Direction of traction at the end of stick.
        let norm = (tx * tx + ty * ty).sqrt();
        let scale = 1.0 / if norm > slip { norm } else { slip };
        let (ex, ey) = (tx * scale, ty * scale);
        let bound = slip * stick;
        let h = slip * per_cell;
        (px[i], py[i], v[i], step[i]) = (bound * ex, bound * ey, slip, h);
        // First half of the end correction: derivative of the integrand over v.
        let change = (length - 2.0 * slip) * (1.0 / 12.0) * h;
        sum_x[i] = 0.5 * px[i] - change * ex;
        sum_y[i] = 0.5 * py[i] - change * ey;
        sum_m[i] = 0.5 * py[i] * slip - (change * slip + bound * (1.0 / 12.0) * h) * ey;
        slope_x[i] = sx * h;
        // Slip three quarters down the next cell, x = v - 3/4 h - half.
        slope_y[i] = (gy + gs * (slip - 0.75 * h - half)) * h;
    }
    for _ in 1..cells {
        for i in 0..LANES {
            let h = step[i];
            let (ax, ay) = (px[i] + slope_x[i], py[i] + slope_y[i]);
            let at = v[i] - h;
            let bound = at * (2.0 * strips.half[i] - at);
            let norm = (ax * ax + ay * ay).sqrt();
            let scale = bound / if norm > bound { norm } else { bound };
            let (x, y) = (ax * scale, ay * scale);
            sum_x[i] += x;
            sum_y[i] += y;
            sum_m[i] += at * y;
            slope_y[i] -= gs * h * h;
            (px[i], py[i], v[i]) = (x, y, at);
        }
    }
    // The last cell ends at the trailing edge, where the bound is zero; its direction enters the end correction.
    for i in 0..LANES {
        let h = step[i];
        let (ax, ay) = (px[i] + slope_x[i], py[i] + slope_y[i]);
        let norm = (ax * ax + ay * ay).sqrt();
        let change = strips.half[i] * (1.0 / 6.0) * h / if norm > 1e-300 { norm } else { 1e-300 };
        let x = h * (sum_x[i] + change * ax);
        let y = h * (sum_y[i] + change * ay);
        fx[i] += x;
        fy[i] += y;
        mz[i] += h * sum_m[i] - strips.half[i] * y - width * strips.y[i] * fx[i];
    }
    [sum(&strips.weight, &fx), sum(&strips.weight, &fy), sum(&strips.weight, &mz)]
}

impl CreepLaw for Fastsim {
    fn force(&self, contact: &RollingContact) -> CreepForce {
        let bound = self.friction.at(contact.friction, contact.sliding_speed()) * contact.normal_force;
        let Some(demand) = Demand::new(&self.linear, contact.patch, contact.creepage, bound) else {
            return CreepForce::default();
        };
        let growth = Growth {
            longitudinal: 3.0 * PI / 16.0 * demand.longitudinal,
            lateral: 3.0 * PI / 16.0 * demand.lateral,
            spin: 2.0 * demand.spin,
            width: demand.width,
        };
        let mut total = [0.0; 3];
        for strips in &self.strips.0 {
            let part = bundle(strips, growth, self.cells);
            total = [total[0] + part[0], total[1] + part[1], total[2] + part[2]];
        }
        // Full sliding has the integral pi/2.
        let resultant = (total[0] * total[0] + total[1] * total[1]).sqrt();
        let unit = -bound / resultant.max(0.5 * PI);
        CreepForce { longitudinal: unit * total[0], lateral: unit * total[1], spin_moment: unit * contact.patch.a * total[2] }
    }
}

impl Fastsim {
    /// With 20 strips of 20 cells, as scenes have it.
    pub fn new(material: Material) -> Self {
        Fastsim { linear: LinearTheory::new(material), strips: Strips::new(STRIPS), cells: CELLS, friction: FallingFriction::CONSTANT }
    }
}

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let strips = Strips::new(count(section, "strips", STRIPS, FEWEST)?);
    let cells = count(section, "cells", CELLS, 1)?;
    let friction = FallingFriction::parse(section, FallingFriction::CONSTANT)?;
    Ok(Arc::new(move |material| Box::new(Fastsim { linear: LinearTheory::new(material), strips: strips.clone(), cells, friction })))
}
