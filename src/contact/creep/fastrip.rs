//! FaStrip: strip theory with an elliptic bound, made to fit Kalker's coefficients; FASTSIM gives the direction of slip.
//!
//! With `X = 4/(3 pi) (1 - nu) x - s y b/a`, `E = 4/(3 pi) (1 - nu) y_demand`, psi = s (x, y_demand, s: linear forces over mu N, see
//! [`super::demand`]; y in units of b), the half length h = sqrt(1 - y^2) of a strip and lengths in units of a:
//!
//! ```text
//! half length of slip at the trailing end    w = (X^2 + E^2) / ((sqrt(E^2 + (1 - psi^2) X^2) - E psi) (1 - nu)),  at most h
//! direction where stick ends                 (k, l) = (X, E + psi w) / |(X, E + psi w)|
//! stick, x > 2 w - h                         q = mu p0 [ (k, l) sqrt(h^2 - x^2) - (k, l - psi) sqrt((h - w)^2 - (x - w)^2) ]
//! slip                                       |q| = mu p0 sqrt(h^2 - x^2),   p0 = 3 N/(2 pi a b),   direction of FASTSIM
//! flexibilities of that FASTSIM              L1, L2, L3 (see [`super::fastsim`]) in a strip that sticks at its leading edge, where slip begins at once one,
//!                                            L = (|xi_x| L1 + |xi_y| L2 + c |phi| L3) / sqrt(xi_x^2 + xi_y^2 + c^2 phi^2),   c = sqrt(a b)
//! ```
//!
//! Why one: where all slips the traction points against the rigid slip, which three flexibilities turn (`L1 : L2 : L3` is 1 : 1.29 : 0.79 at
//! a/b = 0.3). Against the exact theory, 60 contacts with all three creepages, a/b 0.16 to 6 (tests/data/creep_forces_mixed.csv): force off by 0.022 mu N
//! on average, 0.083 at worst; with three flexibilities everywhere 0.031 and 0.161, as published (see below) 0.022 and 0.096.
//!
//! Source: M. S. Sichani, R. Enblom, M. Berg, Vehicle System Dynamics 54 (2016), 807-827, in the form that the open program
//! CONTACT uses (factors of 1 - nu in the direction included, which matter for spin in stick only); L: J. J. Kalker, Vehicle System Dynamics 11
//! (1982), 1-13. Slopes at zero creepage are those of the linear theory, the moment's excepted. Differences to the published algorithm:
//! - FASTSIM's direction starts from the strip theory's traction where slip begins, not from its own stick area.
//! - The published theory changes from three flexibilities to one with a jump. Here the inverse flexibilities are mixed, the single one with the weight
//!   `g^2 / (g^2 + 4 h^2)`, g the growth of FASTSIM's traction at the leading edge, 2 h that of its bound.
//! - For |psi| >= 1 the published theory lets the whole patch slip at once, with a jump. Here the stick length fades out from
//!   |psi| = 1 to 1.2, and where the root above becomes imaginary.
//!
//! Numerics: `strips` (default 20, see [`super::strips`]); stick is integrated in closed form; the slip area has `cells` steps
//! (default 20), denser at both ends, and only the deviation of the direction from (k, l) is integrated numerically.

use super::demand::Demand;
use super::falling_friction::FallingFriction;
use super::kalker::{Coefficients, LinearTheory};
use super::strips::{Bundle, FEWEST, LANES, Lanes, Strips, count, sum};
use super::{Build, CreepLaw, RollingContact};
use crate::contact::creepage::CreepForce;
use crate::math::smooth_step::cubic_step;
use crate::settings::{Entry, Section, SettingsError};
use std::f64::consts::PI;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "fastrip",
    summary: "FaStrip: strip theory with elliptic bound, close to the exact theory; strips = 20, cells = 20, falling friction",
    reference: "Sichani, Enblom, Berg, Vehicle System Dynamics 54 (2016), 807-827",
    parse,
};

/// Strip theory with Kalker's coefficients.
#[derive(Debug, Clone)]
pub struct Fastrip {
    linear: LinearTheory,
    strips: Strips,
    /// Ends of the cells of a slip area, from its leading end, over its length; and weights there.
    cells: Vec<(f64, f64)>,
    poisson_ratio: f64,
    friction: FallingFriction,
}

/// What all strips of a contact share.
#[derive(Clone, Copy)]
struct Shared {
    /// X without spin, E, psi, b/a.
    x: f64,
    e: f64,
    psi: f64,
    width: f64,
    /// Growth of FASTSIM's traction with x, y and spin, in units of 4/3 mu p0, by three flexibilities.
    growth: [f64; 3],
    /// The same by one flexibility, less that.
    turned: [f64; 3],
    /// 1 / (1 - nu).
    lateral: f64,
    /// Share of the stick length that is left beyond |psi| = 1.
    fade: f64,
}

/// Height of the elliptic bound over the parabolic one's at the centre, `p0 / (2 N/(pi a b))`.
const HEIGHT: f64 = 0.75;

/// Part of the stick length that is kept: 1 up to |psi| = 1, 0 from 1.2 on.
fn fade(psi: f64) -> f64 {
    1.0 - cubic_step((psi.abs() - 1.0) / 0.2)
}

/// Share of E^2 in which the root of w fades out.
const ROOT_FADES: f64 = 0.2;

/// L1 / L - 1, L2 / L - 1, L3 / L - 1.
fn turned(c: Coefficients, demand: &Demand) -> [f64; 3] {
    // In units of a / G; creepages in one unit, spin times sqrt(a b).
    let flexibilities = [8.0 / (3.0 * c.c11), 8.0 / (3.0 * c.c22), PI / (4.0 * c.c23 * demand.width.sqrt())];
    let creepages = [demand.longitudinal / c.c11, demand.lateral / c.c22, demand.spin / c.c23];
    let size = creepages[0].hypot(creepages[1]).hypot(creepages[2]);
    if !(size > 0.0) {
        return [0.0; 3];
    }
    let single: f64 = creepages.iter().zip(flexibilities).map(|(creepage, l)| creepage.abs() / size * l).sum();
    flexibilities.map(|l| l / single - 1.0)
}

/// Ends and weights of `count` cells: over u = 1 ... 0 they end at u^2 (3 - 2 u), trapezoidal rule in u.
fn cells(count: usize) -> Vec<(f64, f64)> {
    let part = |k: usize| k as f64 / count as f64;
    (1..count).rev().map(part).map(|u| (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / count as f64)).collect()
}

/// Integrals over a bundle: longitudinal, lateral, moment of the lateral traction; in units of mu p0, a, b.
#[inline]
fn bundle(strips: &Bundle, shared: Shared, cells: &[(f64, f64)]) -> [f64; 3] {
    let zero: Lanes = [0.0; LANES];
    let (mut fx, mut fy, mut mz) = (zero, zero, zero);
    let (mut slip, mut v, mut px, mut py) = (zero, zero, zero, zero);
    let (mut k, mut l, mut sx, mut gy, mut gs) = (zero, zero, zero, zero, zero);
    let size = 1.0 - shared.psi * shared.psi;
    let ([gx_three, gy_three, gs_three], [tx, ty, ts]) = (shared.growth, shared.turned);
    for i in 0..LANES {
        let half = strips.half[i];
        let x = shared.x - shared.psi * shared.width * strips.y[i];
        let square = shared.e * shared.e + size * x * x;
        let fall = square.max(0.0).sqrt() - shared.e * shared.psi;
        let w = (x * x + shared.e * shared.e) / if fall > 1e-300 { fall } else { 1e-300 } * shared.lateral;
        let w = if w < half { w } else { half };
        let real = square / (ROOT_FADES * shared.e * shared.e + 1e-300);
        let real = if real > 0.0 { real } else { 0.0 };
        let real = if real < 1.0 { real } else { 1.0 };
        let stick = (half - w) * shared.fade * real * real * (3.0 - 2.0 * real);
        let w = half - stick;
        let y = shared.e + shared.psi * w;
        let norm = (x * x + y * y).sqrt();
        let scale = 1.0 / if norm > 1e-300 { norm } else { 1e-300 };
        (k[i], l[i]) = (x * scale, y * scale);
        let shifted = l[i] - shared.psi;
        let (whole, part) = (0.5 * PI * half * half, 0.5 * PI * stick * stick);
        fx[i] = k[i] * (whole - part);
        fy[i] = l[i] * whole - shifted * part;
        mz[i] = -shifted * w * part;
        let bound = HEIGHT * (2.0 * w * (2.0 * half - 2.0 * w)).max(0.0).sqrt();
        (slip[i], v[i], px[i], py[i]) = (2.0 * w, 2.0 * w, bound * k[i], bound * l[i]);
        let (lead_x, lead_y) = (gx_three - gs_three * shared.width * strips.y[i], gy_three + gs_three * half);
        let lead = lead_x * lead_x + lead_y * lead_y;
        let single = lead / (lead + 4.0 * half * half);
        gs[i] = gs_three * (1.0 + single * ts);
        gy[i] = gy_three * (1.0 + single * ty);
        sx[i] = gx_three * (1.0 + single * tx) - gs[i] * shared.width * strips.y[i];
    }
    for &(end, weight) in cells {
        for i in 0..LANES {
            let half = strips.half[i];
            let at = slip[i] * end;
            let step = v[i] - at;
            let sy = gy[i] + gs[i] * (at + 0.25 * step - half);
            let (ax, ay) = (px[i] + sx[i] * step, py[i] + sy * step);
            let norm = (ax * ax + ay * ay).sqrt();
            let inverse = 1.0 / if norm > 1e-300 { norm } else { 1e-300 };
            let pressure = (at * (2.0 * half - at)).max(0.0).sqrt();
            let shorten = HEIGHT * pressure * inverse;
            let shorten = if shorten < 1.0 { shorten } else { 1.0 };
            let share = pressure * slip[i] * weight;
            let (dx, dy) = (share * (ax * inverse - k[i]), share * (ay * inverse - l[i]));
            fx[i] += dx;
            fy[i] += dy;
            mz[i] += (at - half) * dy;
            (px[i], py[i], v[i]) = (ax * shorten, ay * shorten, at);
        }
    }
    for i in 0..LANES {
        mz[i] -= shared.width * strips.y[i] * fx[i];
    }
    [sum(&strips.weight, &fx), sum(&strips.weight, &fy), sum(&strips.weight, &mz)]
}

impl CreepLaw for Fastrip {
    fn force(&self, contact: &RollingContact) -> CreepForce {
        let bound = self.friction.at(contact.friction, contact.sliding_speed()) * contact.normal_force;
        let Some(demand) = Demand::new(&self.linear, contact.patch, contact.creepage, bound) else {
            return CreepForce::default();
        };
        let strip = 4.0 / (3.0 * PI) * (1.0 - self.poisson_ratio);
        let shared = Shared {
            x: strip * demand.longitudinal,
            e: strip * demand.lateral,
            psi: demand.spin,
            width: demand.width,
            growth: [3.0 * PI / 16.0 * demand.longitudinal, 3.0 * PI / 16.0 * demand.lateral, 2.0 * demand.spin],
            turned: turned(self.linear.coefficients(contact.patch), &demand),
            lateral: 1.0 / (1.0 - self.poisson_ratio),
            fade: fade(demand.spin),
        };
        let mut total = [0.0; 3];
        for strips in &self.strips.0 {
            let part = bundle(strips, shared, &self.cells);
            total = [total[0] + part[0], total[1] + part[1], total[2] + part[2]];
        }
        // Full sliding has the integral 2 pi/3.
        let resultant = (total[0] * total[0] + total[1] * total[1]).sqrt();
        let unit = -bound / resultant.max(2.0 * PI / 3.0);
        CreepForce { longitudinal: unit * total[0], lateral: unit * total[1], spin_moment: unit * contact.patch.a * total[2] }
    }
}

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let strips = Strips::new(count(section, "strips", 20, FEWEST)?);
    let steps = cells(count(section, "cells", 20, 2)?);
    let friction = FallingFriction::parse(section, FallingFriction::CONSTANT)?;
    Ok(Arc::new(move |material| {
        Box::new(Fastrip {
            linear: LinearTheory::new(material),
            strips: strips.clone(),
            cells: steps.clone(),
            poisson_ratio: material.poisson_ratio,
            friction,
        })
    }))
}
