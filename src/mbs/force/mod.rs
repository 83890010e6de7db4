//! Force elements: each states its law, its potential energy and the power it dissipates.

mod gravity;
mod guided_spring;
mod load;

pub use gravity::Gravity;
pub use guided_spring::{GuidedSpring, TrackAxis};
pub use load::VerticalLoad;

use super::body::{BodyMotion, Wrench};
use crate::geometry::track::station::Station;

/// A force that depends on position and velocity of bodies.
pub trait ForceElement: Send + Sync + std::fmt::Debug {
    /// Name in reports.
    fn name(&self) -> &str;

    /// Adds the element's wrenches to those of the bodies, in the track frame.
    fn apply(&self, bodies: &[BodyMotion], wrenches: &mut [Wrench]);

    /// The element's scalar force [N], for elements that act along one line; `None` otherwise.
    fn scalar_force(&self, bodies: &[BodyMotion]) -> Option<f64>;

    /// The fixed number (0 to 99) of the element's scalar force among the outputs of its body; `None`: it has none.
    fn output_number(&self) -> Option<u32> {
        None
    }

    /// The body whose place on a curved track the element needs, for elements that follow the track frame.
    fn follows(&self) -> Option<usize> {
        None
    }

    /// [`ForceElement::apply`] on a curved track, with the stations by body.
    fn apply_on_track(&self, bodies: &[BodyMotion], _stations: &[Station], wrenches: &mut [Wrench]) {
        self.apply(bodies, wrenches);
    }

    /// [`ForceElement::scalar_force`] on a curved track.
    fn scalar_force_on_track(&self, bodies: &[BodyMotion], _stations: &[Station]) -> Option<f64> {
        self.scalar_force(bodies)
    }

    /// [`ForceElement::potential_energy`] on a curved track.
    fn potential_energy_on_track(&self, bodies: &[BodyMotion], _stations: &[Station]) -> f64 {
        self.potential_energy(bodies)
    }

    /// [`ForceElement::dissipated_power`] on a curved track.
    fn dissipated_power_on_track(&self, bodies: &[BodyMotion], _stations: &[Station]) -> f64 {
        self.dissipated_power(bodies)
    }

    /// A copy behind a pointer.
    fn clone_box(&self) -> Box<dyn ForceElement>;

    /// Stored energy, J, up to a constant.
    fn potential_energy(&self, bodies: &[BodyMotion]) -> f64;

    /// Power that turns into heat, W, never negative.
    fn dissipated_power(&self, bodies: &[BodyMotion]) -> f64;
}

/// The kinds of force element, for `wheelrail list`.
pub static KINDS: &[(&str, &str)] = &[
    ("gravity", "weight of a body"),
    ("vertical_load", "constant vertical force on a body's centre"),
    ("guided_spring", "linear spring and damper along one track axis, to a frame that travels on the centre line"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// For each element: power of its wrench = -d(potential)/dt - dissipated power.
    #[test]
    fn prop_each_element_pays_its_energy_bill() {
        let spring = |axis, side: f64| GuidedSpring {
            name: "s".into(),
            output_number: 0,
            body: 0,
            axis,
            attachment: Vector3::new(0.0, side * 0.45, 0.0),
            stiffness: 1.3e5,
            damping: 2.0e4,
        };
        let elements: Vec<Box<dyn ForceElement>> = vec![
            Box::new(Gravity { body: 0, mass: 12.0, acceleration: 9.81, grade: 0.03 }),
            Box::new(VerticalLoad { body: 0, force: 500.0 }),
            Box::new(spring(TrackAxis::Longitudinal, 1.0)),
            Box::new(spring(TrackAxis::Lateral, -1.0)),
        ];
        let q = [0.0, 0.003, 0.46, 0.02, -0.01, 0.0];
        let v = [0.0, 0.2, -0.1, 0.3, 0.4, 80.0];
        let motion = |h: f64| {
            let q: Vec<f64> = (0..6).map(|i| q[i] + h * v[i]).collect();
            [BodyMotion::new(&q, &v)]
        };
        for element in &elements {
            let mut wrench = [Wrench::default()];
            element.apply(&motion(0.0), &mut wrench);
            let state = motion(0.0)[0];
            let power = wrench[0].force.dot(&state.velocity) + wrench[0].moment.dot(&state.rotation);
            let h = 1e-6;
            let stored = (element.potential_energy(&motion(h)) - element.potential_energy(&motion(-h))) / (2.0 * h);
            let dissipated = element.dissipated_power(&motion(0.0));
            assert!(dissipated >= 0.0);
            assert!((power + stored + dissipated).abs() < 1e-5 * (1.0 + power.abs()), "{element:?}: {power} {stored} {dissipated}");
        }
    }
}
