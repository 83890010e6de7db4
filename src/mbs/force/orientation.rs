//! How far one body's axes are turned from another's, and the moments that go with it.
//!
//! With the axes A and B of two bodies, `R = A^T B` turns by the rotation vector t (axis times angle, in A's axes;
//! in the design configuration R is the identity and t vanishes). With the relative angular velocity w in A's axes,
//! `R' = [w] R`, the rotation vector moves as
//!
//! ```text
//! t' = G(t) w,   G = I - [t]/2 + c [t]^2,   c = (1 - (|t|/2) cot(|t|/2)) / |t|^2
//! ```
//!
//! so that a stored energy V(t) does the power `-dV/dt = m . w` with the couple `m = -G^T dV/dt` on B, and -m on A:
//! exactly conservative at every angle below 180 degrees, for any stiffness. To first order t is (roll, pitch, yaw) of
//! B in A, and m = -K t; the second-order part of m is |t|/2 times K t, for instance 0.05 of it at 0.1 rad.

use crate::mbs::pair_tangent::PairTangent;
use nalgebra::{Matrix3, Vector3};

/// The rotation vector t of R [rad], in the axes that R starts from.
#[inline]
pub(super) fn rotation_vector(r: &Matrix3<f64>) -> Vector3<f64> {
    // Axis times the sine of the angle.
    let w = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) * 0.5;
    let square = w.norm_squared();
    let cos = 0.5 * (r.trace() - 1.0);
    if square < 1e-6 && cos > 0.0 {
        // asin(s)/s; the next term is 5/112 s^6 < 1e-19.
        return w * (1.0 + square * (1.0 / 6.0 + square * 0.075));
    }
    let sin = square.sqrt();
    if sin == 0.0 { Vector3::zeros() } else { w * (sin.atan2(cos) / sin) }
}

/// c and its derivative by |t|^2.
#[inline]
fn coefficient(square: f64) -> (f64, f64) {
    if square < 1e-4 {
        // The next terms are square^2 / 30240 < 4e-13 and square^2 / 403200.
        return (1.0 / 12.0 + square / 720.0, 1.0 / 720.0 + square / 15120.0);
    }
    let half = 0.5 * square.sqrt();
    let (sin, cos) = half.sin_cos();
    let c = (1.0 - half * cos / sin) / square;
    (c, ((half / sin - cos) / (8.0 * half * sin) - c) / square)
}

/// `G^T v = v + t x v / 2 + c t x (t x v)`.
#[inline]
pub(super) fn transposed_rate_map(t: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let cross = t.cross(v);
    v + cross * 0.5 + t.cross(&cross) * coefficient(t.norm_squared()).0
}

/// Change of `G^T K t` with the turning that changes t by `G w`, for a diagonal K: the matrix on w.
fn couple_by_turn(t: &Vector3<f64>, stiffness: &Vector3<f64>) -> Matrix3<f64> {
    let (c, c1) = coefficient(t.norm_squared());
    let (cross, k) = (t.cross_matrix(), Matrix3::from_diagonal(stiffness));
    let v = stiffness.component_mul(t);
    let (v_cross, moved) = (v.cross_matrix(), t.cross(&v));
    // dt x v = -v x dt.
    let first = k + (cross * k - v_cross) * 0.5;
    let second = (cross * cross * k - cross * v_cross - moved.cross_matrix()) * c;
    let by_turn = first + second + t.cross(&moved) * t.transpose() * (2.0 * c1);
    by_turn * (Matrix3::identity() - cross * 0.5 + cross * cross * c)
}

/// What holds `to` against turning in `from`: K [N m/rad] and C [N m s/rad] in the axes A, the rotation vector t [rad], and the couple
/// `G^T K t + C w` [N m] that all of them make on `from`, in A.
pub(super) struct Couple {
    pub axes: Matrix3<f64>,
    pub turn: Vector3<f64>,
    pub stiffness: Vector3<f64>,
    pub damping: Vector3<f64>,
    pub couple: Vector3<f64>,
}

impl Couple {
    /// Adds its changes.
    pub fn tangent(&self, sum: &mut PairTangent) {
        let (axes, back) = (&self.axes, self.axes.transpose());
        let stiffness = axes * couple_by_turn(&self.turn, &self.stiffness) * back;
        sum.add_turning(&stiffness, &(axes * Matrix3::from_diagonal(&self.damping) * back));
        sum.add_couple(&(axes * self.couple));
    }
}
