//! A patch as a linear function of how its wheel stands: the first order of what the strips make of a pair of profiles ([`super::Standing`] has the coordinates).
//!
//! *About* the middle of the track (v0, phi0) under the load Q0. Height of the wheel, place and direction of the patch are, with dv = v - v0 and dphi = phi - phi0,
//!
//! ```text
//! H(dv, dphi)   = h0 + h_v dv + h_phi dphi + (h_vv dv^2 + 2 h_vphi dv dphi + h_phiphi dphi^2) / 2      height under which it carries Q0
//! delta         = delta0 + H - h,     Q = Q0 (delta / delta0)^1.5,     delta0 = 1.5 Q0 / (dQ / d(-h))
//! place, angle  = p0 + p_v dv + p_phi dphi + p_Q (Q - Q0)                                              outward, up; angle of the force
//! a, b          = (a0, b0) (Q / Q0)^(1/3)
//! ```
//!
//! Rolling radius, conicity, contact angle and roll parameter of the linear theory (Klingel 1883; Wickens 2003, Fundamentals of Rail Vehicle Dynamics, 2.4;
//! Knothe & Stichel 2017, Rail Vehicle Dynamics, 3) are numbers of this expansion. Second derivatives of H are those that
//! its gradient, the direction and the arm of the force, has by the first ones of place and angle: the force of a wheel that is displaced far is still that of
//! a potential but for what the strips' own is off (1 %). Q0 is Hertz's power of the depth with the strips' slope.
//!
//! Derivatives are central differences of pressed strips, 0.1 mm and 0.25 mrad to both sides: over the way from strip to strip, not within one.
//!
//! *Left out*: everything of higher order in the place (the patch's curvatures change, a second place or the flange touches), what yaw does to outlines (second order).

use super::super::parts::Part;
use super::super::press::Scratch;
use super::super::strip::Section;
use super::look::{Looked, Read};
use super::make::{Flat, ToTabulate};
use super::{NUMBERS, PLACE, STEEL, Standing};
use crate::contact::search::algebraic::Pair;
use crate::contact::{Material, Patch};
use nalgebra::{Matrix2, Vector2};

/// Differences across, m, of lean, rad, and of the load, in parts of it.
const ACROSS: f64 = 1e-4;
const LEAN: f64 = 2.5e-4;
const LOAD: f64 = 0.02;
/// How well loads are met for them.
const MET: f64 = 1e-9;
const ROUGHLY: f64 = 1e-5;
/// A depth to begin with, m.
const ABOUT: f64 = 5e-5;
/// Places at which [`LinearPatch::range`] compares, m apart, and the farthest.
const LOOKED: f64 = 2.5e-4;
const FARTHEST: f64 = 10e-3;
/// Change of the rolling radius that is told from nothing, m.
const ROUNDING: f64 = 1e-6;

/// The first order of a patch.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearPatch {
    /// v0, m, phi0, rad, and Q0, N on steel.
    about: Vector2<f64>,
    load: f64,
    /// delta0, m.
    depth: f64,
    /// h0, m; its slopes and bends by (v, phi).
    height: f64,
    slopes: Vector2<f64>,
    bends: Matrix2<f64>,
    /// Place outward and up, m, and angle, rad; by v, phi and Q.
    place: [f64; PLACE],
    by: [[f64; 3]; PLACE],
    /// Of the patch there, and of those a step inward, outward, leaning in and out.
    fields: [f32; NUMBERS],
    around: [[f32; NUMBERS]; 4],
}

/// What the patch is in a pose.
#[derive(Clone, Copy, Debug)]
pub struct Expanded {
    /// Displaced across by, m, and leaning by, rad.
    pub moved: Vector2<f64>,
    /// delta / delta0, -: not above 0 where the wheel is off its rail.
    pub pressed: f64,
    pub part: Part,
}

/// How far the expansion is that of the strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Displacements inward and outward [m] beyond which the change of the rolling radius is off by more than a part of itself.
    pub holds: [f64; 2],
    /// ... and beyond which something as steep as a flange carries; `None`: nowhere within 10 mm.
    pub flange: [Option<f64>; 2],
}

impl LinearPatch {
    /// Of a pair whose wheel carries a load [N] in the middle of the track; `None` where it can't there (a flange carries, no rail is below it).
    pub fn new(pair: &ToTabulate, load: f64, material: Material) -> Option<LinearPatch> {
        let steel = load * (STEEL.contact_modulus() / material.contact_modulus());
        let (mut scratch, flat) = (Scratch::new(pair.strips.len()), Flat::new(pair));
        let (v, phi) = pair.middle;
        let mut under = |v: f64, phi: f64, load: f64| flat.under_load(load, (v, phi), MET, ABOUT, &mut scratch);
        let (height, node) = under(v, phi, steel)?;
        let mut slope = |ends: [(f64, f64, f64); 2], apart: f64| -> Option<(f64, [f64; PLACE])> {
            let [(low, before), (high, behind)] = [under(ends[0].0, ends[0].1, ends[0].2)?, under(ends[1].0, ends[1].1, ends[1].2)?];
            Some(((high - low) / apart, std::array::from_fn(|k| (behind.0[k] - before.0[k]) / apart)))
        };
        let across = slope([(v - ACROSS, phi, steel), (v + ACROSS, phi, steel)], 2.0 * ACROSS)?;
        let lean = slope([(v, phi - LEAN, steel), (v, phi + LEAN, steel)], 2.0 * LEAN)?;
        let heavier = slope([(v, phi, (1.0 - LOAD) * steel), (v, phi, (1.0 + LOAD) * steel)], 2.0 * LOAD * steel)?;
        let (place, fields) = node;
        let by: [[f64; 3]; PLACE] = std::array::from_fn(|k| [across.1[k], lean.1[k], heavier.1[k]]);
        let slopes = Vector2::new(across.0, lean.0);
        let beside = [(v - ACROSS, phi), (v + ACROSS, phi), (v, phi - LEAN), (v, phi + LEAN)];
        let mut around = [fields; 4];
        for (fields, (v, phi)) in around.iter_mut().zip(beside) {
            *fields = under(v, phi, steel)?.1.1;
        }
        Some(LinearPatch {
            about: Vector2::new(v, phi),
            load: steel,
            depth: 1.5 * steel * -heavier.0,
            height,
            slopes,
            bends: bends(&place, &by, height, &slopes),
            place,
            by,
            fields,
            around,
        })
    }

    /// Height [m] of the wheel under a load [N] in the middle of the track.
    pub fn height(pair: &ToTabulate, load: f64, material: Material) -> Option<f64> {
        let steel = load * (STEEL.contact_modulus() / material.contact_modulus());
        Some(Flat::new(pair).under_load(steel, pair.middle, MET, ABOUT, &mut Scratch::new(pair.strips.len()))?.0)
    }

    /// What it is in the pose of a pair whose rail has this section.
    #[inline]
    pub fn at(&self, pair: &Pair, section: &Section, material: Material) -> Expanded {
        let standing = Standing::new(pair, section);
        let moved = Vector2::new(standing.across, standing.lean) - self.about;
        let height = self.height + self.slopes.dot(&moved) + 0.5 * moved.dot(&(self.bends * moved));
        let pressed = 1.0 + (height - standing.high) / self.depth;
        let m = pressed.max(0.0);
        let load = self.load * m * m.sqrt();
        let place = std::array::from_fn(|k| {
            let [by_v, by_phi, by_load] = self.by[k];
            self.place[k] + by_v * moved.x + by_phi * moved.y + by_load * (load - self.load)
        });
        let mut part = Read { place, fields: self.fields.map(f64::from) }.placed(&standing, load, 1.0, section, material).part;
        let size = m.sqrt();
        part.patch = Patch { a: part.patch.a * size, b: part.patch.b * size };
        part.mean_square *= m;
        part.overlap *= pressed;
        Expanded { moved, pressed, part }
    }

    /// The patch about which it is expanded, and those beside it: their sizes and how they are spread, all in the pose of a pair that stands there; and by how
    /// far they are apart, m and rad.
    pub fn spread(&self, pair: &Pair, section: &Section, material: Material) -> ([Looked; 5], [f64; 2]) {
        let standing = Standing::new(pair, section);
        let [inward, outward, lower, higher] = self.around;
        let of = |fields: [f32; NUMBERS]| {
            Read { place: self.place, fields: fields.map(f64::from) }.placed(&standing, self.load, 1.0, section, material)
        };
        ([self.fields, inward, outward, lower, higher].map(of), [2.0 * ACROSS, 2.0 * LEAN])
    }

    /// Radius on which it rolls, m, and its changes across, -, and by lean, m.
    pub fn radius(&self) -> (f64, [f64; 2]) {
        let ([out, high, _], lean) = (self.place, self.about.y);
        let (sin, cos) = lean.sin_cos();
        let (out, rise) = (out - self.about.x, high - self.height);
        let by = |k: usize| {
            let (out, rise) = (self.by[0][k] - [1.0, 0.0][k], self.by[1][k] - self.slopes[k]);
            out * sin - rise * cos
        };
        (out * sin - rise * cos, [by(0), by(1) + out * cos + rise * sin])
    }

    /// phi0, rad.
    pub fn lean(&self) -> f64 {
        self.about.y
    }

    /// Angle of the force in the rail's section, rad, and its change across, rad/m.
    pub fn angle(&self) -> (f64, f64) {
        (self.place[2], self.by[2][0])
    }

    /// dQ / d delta, N/m.
    pub fn stiffness(&self, material: Material) -> f64 {
        1.5 * self.load / self.depth * (material.contact_modulus() / STEEL.contact_modulus())
    }

    /// Slopes of the height across, -, and by lean, m.
    pub fn slopes(&self) -> [f64; 2] {
        self.slopes.into()
    }

    /// How far its rolling radius changes as that of the strips does, but for a `part` of it.
    pub fn range(&self, pair: &ToTabulate, part: f64) -> Range {
        let (mut scratch, flat) = (Scratch::new(pair.strips.len()), Flat::new(pair));
        let (first, [by_place, _]) = self.radius();
        let (sin, cos) = self.about.y.sin_cos();
        let mut range = Range { holds: [FARTHEST; 2], flange: [None; 2] };
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let mut held = true;
            for k in 1..=(FARTHEST / LOOKED) as usize {
                let moved = sign * k as f64 * LOOKED;
                let v = self.about.x + moved;
                let Some((height, (place, _))) = flat.under_load(self.load, (v, self.about.y), ROUGHLY, ABOUT, &mut scratch) else {
                    range.flange[side] = Some(moved.abs());
                    break;
                };
                let change = (place[0] - v) * sin - (place[1] - height) * cos - first;
                if held && (change - by_place * moved).abs() > part * (by_place * moved).abs() + ROUNDING {
                    (held, range.holds[side]) = (false, moved.abs() - LOOKED);
                }
            }
            range.holds[side] = range.holds[side].min(range.flange[side].unwrap_or(FARTHEST));
        }
        range
    }
}

/// Second derivatives of the height, of which place and angle of the force are the first: `H_v = -tan(angle)`, `H_phi = rise tan(angle) - out`, out and rise from
/// the tread circle's middle to the place.
fn bends(place: &[f64; PLACE], by: &[[f64; 3]; PLACE], height: f64, slopes: &Vector2<f64>) -> Matrix2<f64> {
    let (tan, rise) = (place[2].tan(), place[1] - height);
    let per = 1.0 + tan * tan;
    let turned = |k: usize| {
        let (out, up) = (by[0][k] - [1.0, 0.0][k], by[1][k] - slopes[k]);
        up * tan + rise * per * by[2][k] - out
    };
    let mixed = 0.5 * (turned(0) - per * by[2][1]);
    Matrix2::new(-per * by[2][0], mixed, mixed, turned(1))
}
