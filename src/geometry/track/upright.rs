//! Boxes on axles: they do not spin, and stay upright on the track.
//!
//! An axle's direction y leaves open how its boxes are turned about it. On a vehicle, links to a frame hold them; here they stand so that
//! their x axis lies in the plane of the track beside them, with the normal N. From the axes x, y, z of `Rz Rx`, whose x is level in the world:
//!
//! ```text
//! box = (x, y, z) Ry(beta),   a = x . N,  b = z . N,  c = y . N,   tan beta = a / b
//! ```
//!
//! With o the angular velocity of `Rz Rx`, v that of the centre, N' = X . v / stretch dN/ds, the box turns about the axle by
//!
//! ```text
//! y . o + beta' = g . o + h . v
//! g = c (a x + b z) / (a^2 + b^2),   h = X / stretch (b x - a z) . dN/ds / (a^2 + b^2)
//! ```
//!
//! On straight level track `g = z tan(roll)`, and h vanishes where the track is plane.

use super::frame::TrackFrame;
use nalgebra::{Matrix3, Vector3};

/// How a box stands on its axle.
#[derive(Clone, Copy, Debug)]
pub struct Upright {
    /// Columns: the box's axes in the world; y is the axle.
    pub axes: Matrix3<f64>,
    /// g and h [1/m]: its turning about the axle by the angular velocity of `Rz Rx` and by the velocity of its centre.
    pub by_rotation: Vector3<f64>,
    pub by_velocity: Vector3<f64>,
}

impl Upright {
    /// On an axle whose frame `Rz Rx` has these axes; `stretch` as in [`TrackFrame::stretch`]. `None` where the axle stands upright.
    #[inline]
    pub fn new(axes: &Matrix3<f64>, track: &TrackFrame, stretch: f64) -> Option<Upright> {
        let up = track.axes.column(2);
        let [x, y, z] = [0, 1, 2].map(|k| axes.column(k).into_owned());
        let [a, b, c] = [x.dot(&up), z.dot(&up), y.dot(&up)];
        let square = a * a + b * b;
        if square < LEAST || !(stretch > 0.0) {
            return None;
        }
        let size = square.sqrt();
        let [sin, cos] = [a / size, b / size];
        let swing = track.swing(&Vector3::z());
        Some(Upright {
            axes: Matrix3::from_columns(&[x * cos - z * sin, y, x * sin + z * cos]),
            by_rotation: (x * a + z * b) * (c / square),
            by_velocity: track.along() * ((x * b - z * a).dot(&swing) / (square * stretch)),
        })
    }

    /// Angular velocity of the box, rad/s, where `Rz Rx` has `rotation` and the centre `velocity`.
    #[inline]
    pub fn rotation(&self, rotation: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
        let axle = self.axes.column(1);
        rotation + axle * (self.by_rotation.dot(rotation) + self.by_velocity.dot(velocity) - axle.dot(rotation))
    }
}

/// Square of the cosine of an axle's slope across the track from which on boxes can stand upright.
const LEAST: f64 = 1e-6;
