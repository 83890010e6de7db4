//! Surfaces for tests of normal laws: arcs that follow each other smoothly, S1002 on 60E1, and poses of a wheel on a rail.

use super::{ContactShape, NormalLaw, ProfileSection};
use crate::contact::search::algebraic::{ContactLocation, Pair, SurfaceParameters};
use crate::geometry::Side;
use crate::geometry::profile::{Bend, Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::Rail;
use crate::math::rotation::AxleFrame;
use nalgebra::Vector3;
use std::sync::Arc;

/// Arcs and straight lines that follow each other smoothly.
#[derive(Debug)]
pub struct Shape(Vec<Piece>, Vec<Bend>);

/// A circle of signed curvature (positive bends up) through (from, value) with `slope` there.
#[derive(Debug)]
pub struct Piece {
    from: f64,
    value: f64,
    slope: f64,
    curvature: f64,
}

impl Piece {
    fn at(&self, x: f64) -> ProfilePoint {
        let dx = x - self.from;
        let root = (1.0 + self.slope * self.slope).sqrt();
        // Sine of the slope angle grows by curvature times dx.
        let sin = self.slope / root + self.curvature * dx;
        let cos = (1.0 - sin * sin).max(1e-3).sqrt();
        let start = 1.0 / root;
        let rise = dx * (sin + self.slope / root) / (cos + start);
        ProfilePoint { value: self.value + rise, d1: sin / cos, d2: self.curvature / (cos * cos * cos), d3: 0.0 }
    }
}

impl Shape {
    /// Pieces from their beginnings (the first one reaches back) and curvatures; value and slope are those at the first beginning.
    pub fn new(value: f64, slope: f64, curvatures: &[(f64, f64)]) -> Self {
        let mut pieces: Vec<Piece> = Vec::new();
        for &(from, curvature) in curvatures {
            let (value, slope) = pieces.last().map_or((value, slope), |last| (last.at(from).value, last.at(from).d1));
            pieces.push(Piece { from, value, slope, curvature });
        }
        Shape::of(pieces)
    }

    fn of(pieces: Vec<Piece>) -> Self {
        let bend = |piece: &Piece| Bend { at: piece.from, value: piece.value, slope: piece.slope };
        let bends = pieces.iter().skip(1).map(bend).collect();
        Shape(pieces, bends)
    }
}

impl Profile for Shape {
    fn at(&self, x: f64) -> ProfilePoint {
        let place = self.0.partition_point(|piece| piece.from <= x).max(1) - 1;
        self.0[place].at(x)
    }
    fn bends(&self) -> &[Bend] {
        &self.1
    }
    fn range(&self) -> (f64, f64) {
        (-1.0, 1.0)
    }
    fn describe(&self) -> String {
        "arcs".into()
    }
}

/// A contact at the coordinates 0 of two profiles, whose half curvature across is `across` at the point.
pub fn touching<'a>(wheel: &'a Shape, rail: &'a Shape, rolling: f64) -> ContactShape<'a> {
    let (w, r) = (wheel.at(0.0), rail.at(0.0));
    let curvature = |p: ProfilePoint| p.d2 / (1.0 + p.d1 * p.d1).powf(1.5);
    let section = |profile: &'a Shape, point| ProfileSection { profile, at: 0.0, point };
    ContactShape::new(rolling, -0.5 * (curvature(w) + curvature(r)), section(wheel, w), section(rail, r))
}

/// A wheel on a rail of arcs, pose by pose.
pub struct Stand {
    pub wheel: Wheel,
    pub rail: Rail,
}

impl Stand {
    pub fn new(wheel: Shape, rail: Shape) -> Self {
        let wheel = Wheel { side: Side::Left, profile: Arc::new(wheel), half_spacing: 0.75 };
        Stand { wheel, rail: Rail::new(Side::Left, Arc::new(rail), 0.75, 0.0, &[]) }
    }

    pub fn find(&self, y: f64, z: f64, start: &SurfaceParameters) -> Option<ContactLocation> {
        let (centre, frame) = (Vector3::new(0.0, y, z), AxleFrame::new(0.0, 0.0));
        Pair { wheel: &self.wheel, rail: &self.rail, centre: &centre, axes: &frame.axes, distance: 0.0 }.locate(start).ok()
    }

    /// S1002 (tread circles 1500 mm apart) on 60E1, 1:40.
    pub fn s1002_on_60e1() -> Self {
        let wheel = Wheel { side: Side::Left, profile: Arc::new(S1002), half_spacing: 0.75 };
        Stand { wheel, rail: Rail::new(Side::Left, Arc::new(rail_60e1()), 0.7535, 0.025, &[]) }
    }

    /// The contact at a stated penetration.
    pub fn pressed(&self, y: f64, penetration: f64, start: &SurfaceParameters) -> Option<ContactLocation> {
        let mut z = 0.46;
        for _ in 0..8 {
            let found = self.find(y, z, start)?;
            if (found.penetration / penetration - 1.0).abs() < 1e-6 {
                return Some(found);
            }
            z += (found.penetration - penetration) / found.normal.z;
        }
        None
    }

    pub fn force(&self, law: &dyn NormalLaw, found: &ContactLocation) -> f64 {
        law.contact(&found.shape(&self.wheel, &self.rail), found.penetration).unwrap().force
    }
}

/// 60E1's head: radii 300, 80, 13 mm and the limits of the arcs (EN 13674-1:2017).
pub fn rail_60e1() -> Shape {
    let arcs = [(0.0, 0.3), (10.228e-3, 0.08), (26.0265e-3, 0.013)];
    let limits: Vec<(f64, f64)> = arcs.iter().map(|&(from, radius)| (from, -1.0 / radius)).collect();
    let half = Shape::new(0.0, 0.0, &limits);
    // Mirrored: a piece begins where the next one of the other half ends.
    let ends = [10.228e-3, 26.0265e-3, 35.9998e-3];
    let mut pieces: Vec<Piece> = half
        .0
        .iter()
        .zip(ends)
        .rev()
        .map(|(piece, end)| {
            let at = piece.at(end);
            Piece { from: -end, value: at.value, slope: -at.d1, curvature: piece.curvature }
        })
        .collect();
    pieces.extend(half.0);
    Shape::of(pieces)
}

/// S1002 (EN 13715) from the flange's throat outward: polynomial zones C and B and the throat's arc D, mm, with tread radius 460 mm.
#[derive(Debug)]
pub struct S1002;

impl Profile for S1002 {
    fn at(&self, x: f64) -> ProfilePoint {
        const B: [f64; 9] = [
            0.0,
            -0.03358537058,
            0.001565681624,
            -2.810427944e-05,
            5.844240864e-08,
            -1.562379023e-08,
            5.309217349e-15,
            -5.957839843e-12,
            2.646656573e-13,
        ];
        const C: [f64; 8] =
            [-4320.221063, -1038.384026, -106.5501873, -6.051367875, -0.2054332446, -0.004169739389, -4.687195829e-05, -2.25275554e-07];
        let y = 1e3 * x;
        let polynomial = |c: &[f64]| {
            let sum = |order: usize| {
                let falling = |i: usize| (0..order).map(|k| (i - k) as f64).product::<f64>();
                (order..c.len()).map(|i| c[i] * falling(i) * y.powi((i - order) as i32)).sum::<f64>()
            };
            [sum(0), sum(1), sum(2)]
        };
        let [z, d1, d2] = if y > 32.15796 {
            [1.36432364 - 0.066666667 * y, -0.066666667, 0.0]
        } else if y > -26.0 {
            polynomial(&B)
        } else if y > -35.0 {
            polynomial(&C)
        } else if y > -38.426669071 {
            let s = y + 26.210665;
            let root = (169.0 - s * s).sqrt();
            [16.446 - root, s / root, 169.0 / (root * root * root)]
        } else {
            [-93.576667419 - 2.747477419 * y, -2.747477419, 0.0]
        };
        ProfilePoint { value: 0.46 + 1e-3 * z, d1, d2: 1e3 * d2, d3: 0.0 }
    }
    fn range(&self) -> (f64, f64) {
        (-0.0397, 0.06)
    }
    fn describe(&self) -> String {
        "S1002".into()
    }
}
