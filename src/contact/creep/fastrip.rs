//! FaStrip: strip theory with an elliptic bound, made to fit Kalker's coefficients; FASTSIM gives the direction of slip.
//!
//! With `X = 4/(3 pi) (1 - nu) x - s y b/a`, `E = 4/(3 pi) (1 - nu) y_demand`, psi = s (x, y_demand, s: linear forces over mu N, see
//! [`super::demand`]; y in units of b), the half length h = sqrt(1 - y^2) of a strip and lengths in units of a:
//!
//! ```text
//! half length of slip at the trailing end    w = (sqrt(E^2 + (1 - psi^2) X^2) + E psi) / ((1 - psi^2)(1 - nu)),  at most h
//! direction where stick ends                 (k, l) = (X, E + psi w) / |(X, E + psi w)|
//! stick, x > 2 w - h                         q = mu p0 [ (k, l) sqrt(h^2 - x^2) - (k, l - psi) sqrt((h - w)^2 - (x - w)^2) ]
//! slip                                       |q| = mu p0 sqrt(h^2 - x^2),   p0 = 3 N/(2 pi a b),   direction of FASTSIM
//! ```
//!
//! Source: M. S. Sichani, R. Enblom, M. Berg, Vehicle System Dynamics 54 (2016), 807-827, in the form that the open program
//! CONTACT uses (factors of 1 - nu in the direction included, which matter for spin in stick only). Slopes at zero creepage are
//! those of the linear theory, the moment's excepted. Differences to the published algorithm, both small:
//! - FASTSIM's direction starts from the strip theory's traction where slip begins, not from its own stick area. The force
//!   differs by 0.001 mu N (mean over random cases), 95 % 0.003, worst 0.026 where |psi| is near 1.
//! - For |psi| >= 1 the published theory lets the whole patch slip at once, with a jump. Here the stick length fades out from
//!   |psi| = 0.8 to 1.
//!
//! Numerics: `strips` (default 20, see [`super::strips`]); stick is integrated in closed form; the slip area has `cells` steps
//! (default 20), denser at both ends, and only the deviation of the direction from (k, l) is integrated numerically.

use super::demand::Demand;
use super::falling_friction::FallingFriction;
use super::kalker::LinearTheory;
use super::strips::{Bundle, FEWEST, LANES, Lanes, Strips, count, sum};
use super::{Build, CreepLaw, RollingContact};
use crate::contact::creepage::CreepForce;
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
    /// Growth of FASTSIM's traction, in units of 4/3 mu p0.
    growth_x: f64,
    growth_y: f64,
    growth_spin: f64,
    /// 1 / (1 - nu).
    lateral: f64,
    /// Share of the stick length that is left near |psi| = 1.
    fade: f64,
}

/// Height of the elliptic bound over the parabolic one's at the centre, `p0 / (2 N/(pi a b))`.
const HEIGHT: f64 = 0.75;

/// Part of the stick length that is kept: 1 up to |psi| = 0.8, 0 from 1 on.
fn fade(psi: f64) -> f64 {
    let z = ((psi.abs() - 0.8) / 0.2).clamp(0.0, 1.0);
    1.0 - z * z * (3.0 - 2.0 * z)
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
    let (mut k, mut l, mut sx) = (zero, zero, zero);
    let size = (1.0 - shared.psi * shared.psi).max(1e-3);
    for i in 0..LANES {
        let half = strips.half[i];
        let x = shared.x - shared.psi * shared.width * strips.y[i];
        let root = (shared.e * shared.e + size * x * x).sqrt();
        let w = (root + shared.e * shared.psi) / size * shared.lateral;
        let w = if w < half { w } else { half };
        let stick = (half - w) * shared.fade;
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
        sx[i] = shared.growth_x - shared.growth_spin * shared.width * strips.y[i];
    }
    for &(end, weight) in cells {
        for i in 0..LANES {
            let half = strips.half[i];
            let at = slip[i] * end;
            let step = v[i] - at;
            let sy = shared.growth_y + shared.growth_spin * (at + 0.25 * step - half);
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
            growth_x: 3.0 * PI / 16.0 * demand.longitudinal,
            growth_y: 3.0 * PI / 16.0 * demand.lateral,
            growth_spin: 2.0 * demand.spin,
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
