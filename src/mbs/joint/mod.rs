//! Joints between two bodies, or a body and the ground, as scalar constraints.
//!
//! A joint holds two places together, one on each body. Where a place's third axis (Z) matters it is the joint's
//! axis. On a body of revolution places do not spin: a revolute joint there is a bearing's housing, and a rigid one
//! leaves the body its spin.

mod attachment;
mod cylindrical;
mod drive;
mod held;
mod prescribed;
mod primitive;
mod prismatic;
mod revolute;
mod rigid;
mod spherical;
#[cfg(test)]
mod tests;
mod universal;

pub use cylindrical::cylindrical;
pub use drive::driven;
pub use prescribed::Prescribed;
pub use primitive::Level;
pub use prismatic::prismatic;
pub use revolute::revolute;
pub use rigid::rigid;
pub use spherical::spherical;
pub use universal::universal;

use super::body::BodyMotion;
use super::kkt::{Coefficients, RowBodies};
use crate::settings::Entry;
use attachment::Attachment;
use nalgebra::{Matrix3, Rotation3, Vector3};
use primitive::{Direction, Primitive, Sides};

/// Makes a joint of a kind between two places.
pub type Build = fn(&str, RowBodies, &Place, &Place) -> Joint;

/// What a kind of joint needs besides bodies and a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    None,
    /// Of both places.
    One,
    /// One of each place, at a right angle.
    Crossed,
}

/// The kinds of joint that a scene can name.
pub static REGISTRY: &[Entry<(Axes, Build)>] = &[
    entry("revolute", "rotation about one axis", (Axes::One, revolute)),
    entry("spherical", "rotation about a point", (Axes::None, spherical)),
    entry("universal", "rotation about two crossed axes, one on each body (Hooke's joint)", (Axes::Crossed, universal)),
    entry("cylindrical", "rotation about one axis and displacement along it", (Axes::One, cylindrical)),
    entry("prismatic", "displacement along one axis", (Axes::One, prismatic)),
    entry("rigid", "no relative motion", (Axes::None, rigid)),
];

const fn entry(name: &'static str, summary: &'static str, parse: (Axes, Build)) -> Entry<(Axes, Build)> {
    Entry { name, summary, reference: "", parse }
}

/// Point and axes of a joint on one of its bodies, in the axes of the body's attachments; track frame on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// m.
    pub point: Vector3<f64>,
    /// Columns; orthonormal.
    pub axes: Matrix3<f64>,
}

impl Place {
    /// Axes parallel to those of the attachments.
    pub fn at(point: Vector3<f64>) -> Self {
        Place { point, axes: Matrix3::identity() }
    }

    /// Z along `axis` (not zero); X and Y are some pair across it.
    pub fn along(point: Vector3<f64>, axis: &Vector3<f64>) -> Self {
        let z = axis.normalize();
        let helper = if z.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let y = z.cross(&helper).normalize();
        Place { point, axes: Matrix3::from_columns(&[y.cross(&z), y, z]) }
    }

    /// The same place seen from a body that moves as `motion` (`None`: the ground); `self` is in the track frame.
    pub fn seen_from(&self, motion: Option<&BodyMotion>) -> Self {
        match motion {
            Some(motion) => {
                let axes = motion.frame.axes;
                Place { point: axes.tr_mul(&(self.point - motion.position)), axes: axes.tr_mul(&self.axes) }
            }
            None => *self,
        }
    }

    /// Turned about its own Z by an angle, rad.
    pub fn turned(&self, angle: f64) -> Self {
        Place { axes: self.axes * Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix(), ..*self }
    }

    fn axis(&self, index: usize) -> Vector3<f64> {
        self.axes.column(index).into_owned()
    }
}

/// One scalar constraint `phi(q, t) = 0` at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowValues {
    /// phi, in m, rad or (angles between axes) as a cosine.
    pub residual: f64,
    /// phi', per second.
    pub rate: f64,
    /// Coefficients of phi' on the velocities of the first and second body.
    pub first: Coefficients,
    pub second: Coefficients,
    /// Right-hand side of `J q'' = gamma`.
    pub gamma: f64,
}

/// A joint's scalar constraints between two bodies.
#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    pub bodies: RowBodies,
    rows: Vec<(&'static str, Primitive)>,
}

impl Joint {
    fn new(name: &str, bodies: RowBodies, rows: Vec<(&'static str, Primitive)>) -> Self {
        Joint { name: name.into(), bodies, rows }
    }

    /// Does it matter to the joint how a body's attachments are turned about their y axis?
    pub fn feels_turn_about_y(&self, body: usize) -> bool {
        let sides = [(Some(self.bodies.first), true), (self.bodies.second, false)];
        sides
            .iter()
            .filter(|(side, _)| *side == Some(body))
            .any(|(_, first)| self.rows.iter().any(|(_, row)| row.feels_turn_about_y(*first)))
    }

    /// Does it hold a body's attachments against turning about their y axis, by angles or by places further than `off` [m] from it?
    pub fn holds_about_y(&self, body: usize, off: f64) -> bool {
        let first = self.bodies.first == body;
        (first || self.bodies.second == Some(body)) && self.rows.iter().any(|(_, row)| row.holds_about_y(first, off))
    }

    /// Where it holds on to its bodies, in their attachment axes from their centres of mass (track frame on the ground), m; `None` of one that drives a coordinate.
    pub fn points(&self) -> Option<[Vector3<f64>; 2]> {
        self.rows.iter().find_map(|(_, row)| row.points())
    }

    /// Number of scalar constraints.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Name of a scalar constraint, such as `pivot.y`.
    pub fn row_name(&self, row: usize) -> String {
        format!("{}.{}", self.name, self.rows[row].0)
    }

    /// Values of all rows, in order, at time t [s].
    pub fn evaluate(&self, t: f64, motions: &[BodyMotion]) -> impl Iterator<Item = RowValues> {
        let motions = (&motions[self.bodies.first], self.bodies.second.map(|second| &motions[second]));
        let second = motions.1.map_or_else(Attachment::ground, Attachment::of);
        let sides = Sides { motions, first: Attachment::of(motions.0), second };
        self.rows.iter().map(move |(_, primitive)| primitive.values(t, &sides))
    }
}

/// The second point stays on the first: three rows along the track's axes.
fn same_point(first: &Place, second: &Place) -> Vec<(&'static str, Primitive)> {
    [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())]
        .map(|(name, d)| (name, Primitive::Displacement { first: first.point, second: second.point, direction: Direction::Track(d) }))
        .into()
}

/// The second point stays on the Z axis of the first place.
fn on_axis(first: &Place, second: &Place) -> [(&'static str, Primitive); 2] {
    [("x", 0), ("y", 1)].map(|(name, axis)| {
        let direction = Direction::First(first.axis(axis));
        (name, Primitive::Displacement { first: first.point, second: second.point, direction })
    })
}

/// Both Z axes stay parallel.
fn parallel(first: &Place, second: &Place) -> [(&'static str, Primitive); 2] {
    [("tilt_x", 0), ("tilt_y", 1)].map(|(name, axis)| (name, right_angle(first, axis, second, 2)))
}

/// One axis of the first place stays across one of the second.
fn right_angle(first: &Place, axis: usize, second: &Place, other: usize) -> Primitive {
    Primitive::Angle { first: first.axis(axis), second: second.axis(other) }
}
