//! How the wrench of a wheel with linear contact changes with the wheelset's motion: differences of all that it carries, over four motions in the wheelset's axes (see
//! [`super::patch`]; turning about the axle changes nothing, going along with the rail only turns) and six velocities, which cost next to nothing.

use super::Model;
use super::patch::stacked;
use crate::contact::strips::Section;
use crate::formulation::linear_contact::LinearContact;
use crate::formulation::loading::WheelAt;
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::tangent::{Tangent, WrenchTangent};
use nalgebra::{Rotation3, Vector3, Vector6};

/// Differences: m, rad, and velocities in parts of the travelling speed, or rad/m times it.
const STEP: f64 = 1e-8;
const RATE: f64 = 1e-6;

impl Model {
    /// Adds a wheel with linear contact. `travel`: how its travelling speed changes with the velocity of its centre, where that is free.
    pub(super) fn add_linear(&self, wheel: &WheelAt, linear: &LinearContact, travel: Option<Vector3<f64>>, tangent: &mut Tangent) {
        let motion = wheel.motion;
        let carried = |moved: &BodyMotion| -> Option<Vector6<f64>> {
            let there = WheelAt { motion: moved, ..*wheel };
            let (mut wrench, report) = (Wrench::default(), linear.loaded(&there).ok()?);
            report.add_to(&mut wrench, report.force, &moved.position);
            Some(stacked(&wrench))
        };
        let Some(here) = carried(motion) else { return };
        let mut change = WrenchTangent::default();
        let rate = RATE * wheel.speed().abs();
        let axes: [Vector3<f64>; 3] = std::array::from_fn(|k| motion.frame.axes.column(k).into_owned());
        for (k, axis) in axes.iter().enumerate() {
            let mut faster = *motion;
            faster.velocity += axis * rate;
            faster.speed += travel.map_or(0.0, |travel| travel.dot(axis) * rate);
            let mut turning = *motion;
            turning.rotation += axis * rate;
            for (place, moved) in [(0, &faster), (3, &turning)] {
                let Some(there) = carried(moved) else { return };
                let by = (there - here) / rate;
                for i in 0..3 {
                    change.by_velocity.column_mut(place + i).axpy(axis[i], &by, 1.0);
                }
            }
            let mut shifted = *motion;
            shifted.position += axis * STEP;
            let mut turned = *motion;
            turned.frame.axes = Rotation3::new(axis * STEP) * motion.frame.axes;
            let pitch = k == 1;
            for (place, moved) in [(0, Some(&shifted).filter(|_| k > 0)), (3, Some(&turned).filter(|_| !pitch))] {
                let Some(there) = moved.and_then(carried) else { continue };
                let by = (there - here) / STEP;
                for i in 0..3 {
                    change.by_position.column_mut(place + i).axpy(axis[i], &by, 1.0);
                }
            }
        }
        self.go_along(wheel, (&here, &axes), &mut change);
        let body = wheel.wheelset.turning[wheel.side.index()];
        if let Some(wrench) = tangent.wrench_mut(body, body) {
            wrench.by_position += change.by_position;
            wrench.by_velocity += change.by_velocity;
        }
    }

    /// Sets how the wrench changes along the wheelset's first axis, from what is known of the other ways: along the rail it turns with it.
    fn go_along(&self, wheel: &WheelAt, (here, axes): (&Vector6<f64>, &[Vector3<f64>; 3]), change: &mut WrenchTangent) {
        let (along, turning) = Section::new(&wheel.pair()).course();
        let turned = |six: &Vector6<f64>| -> Vector6<f64> {
            let [force, moment] = [0, 3].map(|start| turning.cross(&six.fixed_rows::<3>(start).into_owned()));
            stacked(&Wrench { force, moment })
        };
        let BodyMotion { velocity, rotation, .. } = *wheel.motion;
        let velocities = stacked(&Wrench { force: velocity, moment: rotation });
        let course = stacked(&Wrench { force: along, moment: turning });
        let first = turned(here) - change.by_velocity * turned(&velocities) - change.by_position * course;
        let ahead = axes[0];
        let row = stacked(&Wrench { force: ahead, moment: Vector3::zeros() });
        change.by_position += first / ahead.dot(&along) * row.transpose();
    }
}
