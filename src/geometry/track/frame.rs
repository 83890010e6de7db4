//! The track frame at one place of the centre line, and how it moves along it.
//!
//! Axes `A = Rz(heading) Ry(-climb) Rx(cant)`: X along the centre line, Y to the left in the track's plane, Z up from it. Along
//! the arc length s (a dash below) the origin moves with X and the axes turn with omega, `A' = A [omega x]`, which is kept with two
//! derivatives in the frame's own axes. With heading psi, climb g, cant f:
//!
//! ```text
//! a = psi' sin g,  c = psi' cos g,   omega = (f' + a,  -g' cos f + c sin f,  g' sin f + c cos f)
//! ```
//!
//! A point that rests or moves as w(s) in the frame has in the world the position C + A w and the derivatives
//!
//! ```text
//! A p1, A p2, A p3   with   p1 = e_x + w' + omega x w,   p2 = p1' + omega x p1,   p3 = p2' + omega x p2
//! ```

use nalgebra::{Matrix3, Vector3};

/// The track frame at one distance.
#[derive(Clone, Copy, Debug)]
pub struct TrackFrame {
    /// s, m.
    pub distance: f64,
    /// C in the world, m.
    pub origin: Vector3<f64>,
    /// A: columns are the frame's axes in the world.
    pub axes: Matrix3<f64>,
    /// psi, rad, counted through (a full circle adds 2 pi).
    pub heading: f64,
    /// omega in the frame's own axes, 1/m, and its first two derivatives along s.
    pub turn: Vector3<f64>,
    pub turn1: Vector3<f64>,
    pub turn2: Vector3<f64>,
}

impl Default for TrackFrame {
    /// That of straight level track at s = 0.
    fn default() -> Self {
        let zero = Vector3::zeros();
        TrackFrame { distance: 0.0, origin: zero, axes: Matrix3::identity(), heading: 0.0, turn: zero, turn1: zero, turn2: zero }
    }
}

/// Value and three derivatives along s of a vector in the track frame.
pub(in super::super) type Jet = [Vector3<f64>; 4];

/// An angle, rad, with three derivatives along s, 1/m and so on, its sine and its cosine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Angle {
    jet: [f64; 4],
    sin: f64,
    cos: f64,
}

impl Angle {
    #[inline]
    pub fn new(jet: [f64; 4]) -> Angle {
        let (sin, cos) = jet[0].sin_cos();
        Angle { jet, sin, cos }
    }
}

impl TrackFrame {
    /// From heading, climb and cant.
    #[inline]
    pub(super) fn new(distance: f64, origin: Vector3<f64>, heading: &Angle, climb: &Angle, cant: &Angle) -> Self {
        let Angle { jet: psi, sin: sin_h, cos: cos_h } = *heading;
        let Angle { jet: g, sin: sin_g, cos: cos_g } = *climb;
        let Angle { jet: f, sin: sin_f, cos: cos_f } = *cant;
        let along = Vector3::new(cos_g * cos_h, cos_g * sin_h, sin_g);
        let left = Vector3::new(-sin_h, cos_h, 0.0);
        let up = Vector3::new(-sin_g * cos_h, -sin_g * sin_h, cos_g);
        let axes = Matrix3::from_columns(&[along, left * cos_f + up * sin_f, up * cos_f - left * sin_f]);
        // psi' about the vertical in the axes before canting: (a, -g', c), with derivatives.
        let [_, k, k1, k2] = psi;
        let [a, c] = [k * sin_g, k * cos_g];
        let [a1, c1] = [k1 * sin_g + g[1] * c, k1 * cos_g - g[1] * a];
        let a2 = k2 * sin_g + k1 * g[1] * cos_g + g[2] * c + g[1] * c1;
        let c2 = k2 * cos_g - k1 * g[1] * sin_g - g[2] * a - g[1] * a1;
        let [b, b1, b2] = [-g[1], -g[2], -g[3]];
        // Canting turns (b, c) about X.
        let turned = |b: f64, c: f64| [b * cos_f + c * sin_f, c * cos_f - b * sin_f];
        let [y, z] = turned(b, c);
        let [own_y, own_z] = turned(b1, c1);
        let [y1, z1] = [own_y + f[1] * z, own_z - f[1] * y];
        let [far_y, far_z] = turned(b2, c2);
        let y2 = far_y + f[1] * own_z + f[2] * z + f[1] * z1;
        let z2 = far_z - f[1] * own_y - f[2] * y - f[1] * y1;
        TrackFrame {
            distance,
            origin,
            axes,
            heading: psi[0],
            turn: Vector3::new(f[1] + a, y, z),
            turn1: Vector3::new(f[2] + a1, y1, z1),
            turn2: Vector3::new(f[3] + a2, y2, z2),
        }
    }

    /// X: unit tangent of the centre line.
    #[inline]
    pub fn along(&self) -> Vector3<f64> {
        self.axes.column(0).into_owned()
    }

    /// A vector of the world in the frame's axes.
    #[inline]
    pub fn components(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        self.axes.tr_mul(vector)
    }

    /// Derivative of the unit tangent along s: the centre line's curvature vector, 1/m.
    #[inline]
    pub fn bend(&self) -> Vector3<f64> {
        self.axes.column(1) * self.turn.z - self.axes.column(2) * self.turn.y
    }

    /// By how much less a point at an offset [m] from the origin travels than the frame, -: inside a curve below 1.
    #[inline]
    pub fn stretch(&self, offset: &Vector3<f64>) -> f64 {
        1.0 - offset.dot(&self.bend())
    }

    /// Does it neither turn here nor begin to, as all along a straight piece?
    #[inline]
    fn is_still(&self) -> bool {
        self.turn == Vector3::zeros() && self.turn1 == Vector3::zeros() && self.turn2 == Vector3::zeros()
    }

    /// Position in the world and first two derivatives along s of a point of the frame.
    #[inline]
    pub(in super::super) fn carry(&self, w: &Jet) -> [Vector3<f64>; 3] {
        if self.is_still() {
            return [self.origin + self.axes * w[0], self.axes * (Vector3::x() + w[1]), self.axes * w[2]];
        }
        let p1 = Vector3::x() + w[1] + self.turn.cross(&w[0]);
        let p1_rate = w[2] + self.turn1.cross(&w[0]) + self.turn.cross(&w[1]);
        [self.origin + self.axes * w[0], self.axes * p1, self.axes * (p1_rate + self.turn.cross(&p1))]
    }

    /// Third derivative of the same.
    #[inline]
    pub(in super::super) fn carry3(&self, w: &Jet) -> Vector3<f64> {
        if self.is_still() {
            return self.axes * w[3];
        }
        let (o, o1, o2) = (&self.turn, &self.turn1, &self.turn2);
        let p1 = Vector3::x() + w[1] + o.cross(&w[0]);
        let p1_rate = w[2] + o1.cross(&w[0]) + o.cross(&w[1]);
        let p1_rate2 = w[3] + o2.cross(&w[0]) + o1.cross(&w[1]) * 2.0 + o.cross(&w[2]);
        let p2 = p1_rate + o.cross(&p1);
        let p2_rate = p1_rate2 + o1.cross(&p1) + o.cross(&p1_rate);
        self.axes * (p2_rate + o.cross(&p2))
    }

    /// First derivative along s of a direction that is fixed in the frame, in the world.
    #[inline]
    pub(in super::super) fn swing(&self, u: &Vector3<f64>) -> Vector3<f64> {
        self.axes * self.turn.cross(u)
    }

    /// Its second derivative.
    #[inline]
    pub(in super::super) fn swing2(&self, u: &Vector3<f64>) -> Vector3<f64> {
        self.axes * (self.turn1.cross(u) + self.turn.cross(&self.turn.cross(u)))
    }
}
