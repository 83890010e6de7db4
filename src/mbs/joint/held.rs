//! A joint to a body that is not modelled but goes along with the other one ([`crate::mbs::force::Guide`]).

use super::primitive::{Direction, Primitive};
use super::{Joint, RowBodies};
use crate::mbs::body::BodyMotion;
use nalgebra::Vector3;

impl Joint {
    /// Leaves a body displacement along X alone; it keeps height, lateral place and angles of `at`.
    pub fn along_track(name: &str, body: usize, at: &BodyMotion) -> Joint {
        let across = [("y", Vector3::y()), ("z", Vector3::z())].map(|(name, d)| {
            (name, Primitive::Displacement { first: Vector3::zeros(), second: at.position, direction: Direction::Track(d) })
        });
        let axes = &at.frame.axes;
        let level = [("roll", Vector3::y(), 2), ("pitch", Vector3::z(), 0), ("yaw", Vector3::x(), 1)]
            .map(|(name, own, other)| (name, Primitive::Angle { first: own, second: axes.column(other).into_owned() }));
        Joint { name: name.into(), bodies: RowBodies { first: body, second: None }, rows: across.into_iter().chain(level).collect() }
    }

    /// The joint between the body `kept` (its first one, or its second) and what stays where `guide` is but along X, where it goes with `kept`: without the row
    /// along X, against the ground. `None` for kinds whose rows follow a body's axis: they would measure how far it has run.
    pub fn held(&self, kept: usize, kept_is_first: bool, guide: &BodyMotion) -> Option<Joint> {
        let point = |local: &Vector3<f64>| guide.position + guide.frame.axes * local;
        let axis = |local: &Vector3<f64>| guide.frame.axes * local;
        let mut rows = Vec::new();
        for (name, row) in &self.rows {
            let held = match row {
                Primitive::Displacement { direction: Direction::Track(d), .. } if *d == Vector3::x() => continue,
                Primitive::Displacement { first, second, direction: Direction::Track(d) } => {
                    let (own, other) = if kept_is_first { (first, second) } else { (second, first) };
                    Primitive::Displacement { first: *own, second: point(other), direction: Direction::Track(*d) }
                }
                Primitive::Angle { first, second } => {
                    let (own, other) = if kept_is_first { (first, second) } else { (second, first) };
                    Primitive::Angle { first: *own, second: axis(other) }
                }
                Primitive::Displacement { direction: Direction::First(_), .. } | Primitive::Coordinate { .. } => return None,
            };
            rows.push((*name, held));
        }
        Some(Joint { name: self.name.clone(), bodies: RowBodies { first: kept, second: None }, rows })
    }
}
