//! Reading a table.
//!
//! *Yaw.* Seen along the rail, a wheel that is turned by psi about the vertical shows an outline that is deeper by `psi^2 (R R'^2 + R' u) / 2` at the
//! coordinate u: 0.06 um on a tread at 10 mrad. Depth and tilt of that at the patch are added to the wheel's height and lean (a tilt about the place itself);
//! what it bends is left out (1e-4 of the relative curvature on treads).
//!
//! *A rail that is bent along the track* by k (1/m, upwards) takes from the wheel's curvature 1/R along the track: as in Hertz's nearly circular contact N goes as
//! `(1 - k R)^(-1/4)` and half lengths as `(1 - k R)^(-1/2)`; first order, 1e-3 of N for a rail bent at 100 m.

use super::super::fifths::{FIFTHS, Fifth, Fifths};
use super::super::parts::Part;
use super::super::strip::Section;
use super::{Axis, EXCESS, LEVELS, NUMBERS, OWN, PLACE, PatchTable, STEEL, Standing, load_of};
use crate::contact::search::algebraic::Pair;
use crate::contact::{Material, Patch};
use crate::geometry::profile::ProfilePoint;
use crate::math::smooth_step::cubic_step;

/// Levels over which the table's weight grows above the lowest and falls below the highest.
const FADE: f64 = 1.0;
/// Yaw beyond which outlines are not those of the table, rad, and where that begins.
const YAWED: (f64, f64) = (0.015, 0.02);
/// Where the ellipse of its moments is larger than a patch by such a part of it, or numbers bend so much from node to node ([`super::trust`]), the strips begin to be asked, and are
/// asked alone, -.
const HOLLOW: (f64, f64) = (0.3, 0.6);
/// Iterations for the load; three are enough.
const ITERATIONS: usize = 8;

/// What a table says of a pose.
#[derive(Clone, Copy, Debug)]
pub struct Looked {
    /// 1 inside the table, falling to 0 at its border, where the strips must be asked.
    pub weight: f64,
    pub part: Part,
    pub fifths: Fifths,
}

/// Four nodes along an axis and their weights.
struct Four {
    first: usize,
    weights: [f64; 4],
    /// The two in the middle, for what needs no more.
    between: f64,
}

impl Axis {
    #[inline]
    fn four(&self, at: f64) -> Option<Four> {
        let place = (at - self.first) / self.step;
        if !(place >= 1.0 && place < (self.count - 2) as f64) {
            return None;
        }
        let first = place as usize - 1;
        let between = place - (first + 1) as f64;
        Some(Four { first, weights: convolution(between), between })
    }
}

/// Weights of the nodes at -1, 0, 1, 2 for a place t from 0 to 1, and their slopes.
#[inline]
fn convolution(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-0.5 * t * s * s, 1.0 + t * t * (1.5 * t - 2.5), 1.0 + s * s * (1.5 * s - 2.5), -0.5 * s * t * t]
}

#[inline]
fn slopes(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-0.5 * s * (s - 2.0 * t), t * (4.5 * t - 5.0), -s * (4.5 * s - 5.0), -0.5 * t * (2.0 * s - t)]
}

impl PatchTable {
    /// What it says of a pair whose rail has this section; `None` where the strips must be asked alone.
    pub fn look(&self, pair: &Pair, section: &Section, material: Material) -> Option<Looked> {
        let standing = Standing::new(pair, section);
        let yawed = cubic_step((YAWED.1 - standing.yaw.abs()) / (YAWED.1 - YAWED.0));
        if !(yawed > 0.0) {
            return None;
        }
        let (place, lean, high) = self.unyawed(&standing)?;
        let (across, lean) = (self.across.four(place)?, self.lean.four(lean)?);
        let top = self.between(&self.tops, &across, &lean);
        let (level, within) = self.level(&across, &lean, high, top)?;
        let at = level as f64 + within;
        let weight = yawed * cubic_step((at - 1.0) / FADE) * cubic_step((top - at) / FADE);
        if !(weight > 0.0) {
            return None;
        }
        let patch = self.patch(&across, &lean, level - 1, &convolution(within));
        let weight = weight * cubic_step((HOLLOW.1 - patch.fields[EXCESS]) / (HOLLOW.1 - HOLLOW.0));
        if !(weight > 0.0) {
            return None;
        }
        Some(patch.placed(&standing, load_of(at), weight, section, material))
    }

    /// Bilinear.
    #[inline]
    fn between(&self, values: &[f32], across: &Four, lean: &Four) -> f64 {
        let at = |i: usize, j: usize| f64::from(values[(across.first + i) * self.lean.count + lean.first + j]);
        let row = |i: usize| at(i, 1) + lean.between * (at(i, 2) - at(i, 1));
        row(1) + across.between * (row(2) - row(1))
    }

    /// v, phi and h of the wheel without yaw whose outline is nearest to that which is seen.
    #[inline]
    fn unyawed(&self, standing: &Standing) -> Option<(f64, f64, f64)> {
        let Standing { across, lean, high, yaw, .. } = *standing;
        if yaw == 0.0 {
            return Some((across, lean, high));
        }
        let (i, j) = (self.across.four(across)?, self.lean.four(lean)?);
        let [place, angle, bend] = self.middles.each_ref().map(|values| self.between(values, &i, &j));
        let slope = (angle + lean).tan();
        let (radius, square) = (self.radius, 0.5 * yaw * yaw);
        let u = place - across - radius * lean;
        let deeper = square * (radius * slope * slope + slope * u);
        let tilt = square * (slope * (slope * slope + 2.0 * radius * bend + 1.0) + bend * u);
        Some((across + radius * tilt, lean - tilt, high - deeper + (u + radius * lean) * tilt))
    }

    /// The level of the load under which the wheel stands so high, as a whole number and what is left.
    #[inline]
    fn level(&self, across: &Four, lean: &Four, high: f64, top: f64) -> Option<(usize, f64)> {
        if !(top > 1.0) {
            return None;
        }
        let last = (top as usize + 2).min(LEVELS - 1);
        let mut heights = [0.0; LEVELS];
        for (i, by_across) in across.weights.iter().enumerate() {
            let row = (across.first + i) * self.lean.count + lean.first;
            for (column, by_lean) in self.heights[row..row + 4].iter().zip(&lean.weights) {
                add(&mut heights, column, by_across * by_lean);
            }
        }
        // They fall.
        let below = heights[..=last].iter().take_while(|height| **height >= high).count();
        if below < 2 || below + 1 > last {
            return None;
        }
        let level = below - 1;
        let four: [f64; 4] = std::array::from_fn(|k| heights[level - 1 + k]);
        let sum = |weights: [f64; 4]| weights.iter().zip(&four).map(|(weight, height)| weight * height).sum::<f64>();
        let mut within = (four[1] - high) / (four[1] - four[2]);
        for _ in 0..ITERATIONS {
            let step = (sum(convolution(within)) - high) / sum(slopes(within));
            within = (within - step).clamp(0.0, 1.0);
            if step.abs() < NEXT {
                break;
            }
        }
        Some((level, within))
    }

    #[inline]
    fn patch(&self, across: &Four, lean: &Four, level: usize, by_level: &[f64; 4]) -> Read {
        let (mut place, mut sums) = ([0.0; PLACE], [0.0; NUMBERS]);
        for (i, by_across) in across.weights.iter().enumerate() {
            let row = (across.first + i) * self.lean.count + lean.first;
            for (j, by_lean) in lean.weights.iter().enumerate() {
                let node = (row + j) * LEVELS + level;
                let (places, fields): (&[[f64; PLACE]], &[[f32; NUMBERS]]) = (&self.places[node..node + 4], &self.fields[node..node + 4]);
                let by_column = by_across * by_lean;
                for k in 0..4 {
                    let weight = by_column * by_level[k];
                    add(&mut place, &places[k], weight);
                    add(&mut sums, &fields[k], weight);
                }
            }
        }
        Read { place, fields: sums }
    }
}

/// Sums of arrays whose length is known: in vectors. In double precision, whatever the values': rounding of sums in single precision made creep forces scatter by 1e-7, and their
/// derivatives by time by a tenth.
#[inline(always)]
fn add<T: Copy + Into<f64>, const N: usize>(sums: &mut [f64; N], values: &[T; N], weight: f64) {
    for k in 0..N {
        sums[k] += weight * values[k].into();
    }
}

/// Change of a level after which the next iteration would change it by rounding.
const NEXT: f64 = 1e-8;
/// Mean overlap by load over the largest, -: what the rail's surface lies above the wheel's at the load's centre.
const MEAN_OVERLAP: f64 = 0.67;

/// A patch as the table has it, in the rail's section.
pub(super) struct Read {
    pub place: [f64; PLACE],
    pub fields: [f64; NUMBERS],
}

impl Read {
    /// The part that it is.
    #[inline]
    pub fn placed(&self, standing: &Standing, load: f64, weight: f64, section: &Section, material: Material) -> Looked {
        let [across, high, angle] = self.place;
        let [less, a, b, overlap, wheel_bend, rail_bend] = std::array::from_fn(|k| self.fields[k]);
        let (sin, cos) = angle.sin_cos();
        let (normal, outward) = (standing.outward * sin + standing.up * cos, standing.outward * cos - standing.up * sin);
        let slope = (angle + standing.lean).tan();
        let (leaning, upright) = standing.lean.sin_cos();
        let (out, rise) = (across - standing.across, high - standing.high);
        let turned = standing.yaw.hypot(1.0).recip();
        let round = slope * standing.yaw;
        let radius = (out * leaning - rise * upright) / (1.0 - round * round).sqrt();
        let sideways = standing.yaw * turned;
        let u = (out * upright + rise * leaning + radius * round * sideways) / turned;
        let ahead = standing.ahead + u * sideways + radius * round * turned;
        let sharper = 1.0 - section.bend().dot(&normal) * radius;
        let load = load * (material.contact_modulus() / STEEL.contact_modulus()) * sharper.powf(-0.25);
        let a = a * sharper.powf(-0.5);
        let part = Part {
            load,
            force: load * (1.0 - less),
            normal,
            forward: standing.along * standing.stretch,
            arm: standing.origin + standing.outward * across + standing.up * high + standing.along * ahead,
            lead: standing.station + (ahead - across * standing.shear[0] - high * standing.shear[1]) / standing.stretch,
            overlap,
            coordinates: [u, across + MEAN_OVERLAP * overlap * sin],
            profiles: [
                ProfilePoint { value: radius, d1: slope, d2: wheel_bend, d3: 0.0 },
                ProfilePoint { value: high + MEAN_OVERLAP * overlap * cos, d1: -sin / cos, d2: rail_bend, d3: 0.0 },
            ],
            patch: Patch { a, b },
            mean_square: 0.8 * a * a,
            couple: nalgebra::Vector3::zeros(),
        };
        let cell = |k: usize| {
            let [across, above, size] = std::array::from_fn(|i| self.fields[OWN + i * FIFTHS + k]);
            Fifth { across, above, size }
        };
        Looked { weight, part, fifths: Fifths { each: std::array::from_fn(cell), outward } }
    }
}
