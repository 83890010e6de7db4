//! Elements and joints that hold on to a place where their body does not reach.
//!
//! A wrong sign, or a length in millimetres, puts a place onto another part of the vehicle: forces are handed over there all the same, with levers of metres.
//! Bodies are known by mass and inertia alone; a bar of the radius of gyration i is 3.5 i long, so that no part of it is further than 1.7 i from its middle.

use crate::formulation::Model;
use crate::mbs::body::Body;
use nalgebra::Vector3;

/// No part of a body is further from its centre of mass, in radii of gyration ...
const REACH: f64 = 2.5;
/// ... unless it is nearer than this, m: brackets, arms.
const NEAR: f64 = 2.0;

/// The first of them, and how many more.
pub(super) fn far_places(model: &Model) -> Option<String> {
    let bodies = &model.system.bodies;
    let forces = model.system.forces.iter().map(|force| {
        let places = force.holds().into_iter().flatten().map(|place| (place.body, place.local));
        (force.name(), places.collect::<Vec<_>>())
    });
    let joints = model.system.joints.iter().map(|joint| {
        let sides = [Some(joint.bodies.first), joint.bodies.second];
        let places = joint.points().into_iter().flat_map(|points| sides.into_iter().zip(points));
        (joint.name.as_str(), places.collect::<Vec<_>>())
    });
    let mut all = forces.chain(joints).filter_map(|(name, places)| {
        let far = places.into_iter().find_map(|(body, place)| beyond(bodies.get(body?)?, &place))?;
        Some(format!("{name}: {far}"))
    });
    let first = all.next()?;
    match all.count() {
        0 => Some(first),
        more => Some(format!("{first} (and {more} more)")),
    }
}

/// Of a place from a body's centre of mass.
fn beyond(body: &Body, place: &Vector3<f64>) -> Option<String> {
    let gyration = (body.inertia.moments().into_iter().fold(0.0, f64::max) / body.mass).sqrt();
    let away = place.norm();
    (away > NEAR.max(REACH * gyration)).then(|| {
        format!(
            "holds on to {} {away:.2} m from its centre of mass (radius of gyration {gyration:.2} m): does it reach so far? A sign, a unit or the wheelset may be meant otherwise",
            body.name
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mbs::inertia::Inertia;

    #[test]
    fn analytic_a_body_reaches_no_further_than_its_radius_of_gyration_allows() {
        // A car of 25 m and 40 t, a truck's frame, a casting of 0.3 m.
        let car = |length: f64| 40e3 * length * length / 12.0;
        let body = |mass: f64, most: f64| Body {
            name: "b".into(),
            mass,
            inertia: Inertia::General { principal: Vector3::new(0.3 * most, most, most) },
        };
        let far = |body: &Body, x: f64| beyond(body, &Vector3::new(x, 0.0, 0.5)).is_some();
        let (car, frame, casting) = (body(40e3, car(25.0)), body(3e3, 3500.0), body(100.0, 1.5));
        assert_eq!([9.5, 12.8, 19.0, 25.0].map(|x| far(&car, x)), [false, false, true, true]);
        assert_eq!([1.3, 2.5, 3.8, 9.5].map(|x| far(&frame, x)), [false, false, true, true]);
        assert_eq!([0.4, 1.5, 2.5].map(|x| far(&casting, x)), [false, false, true]);
    }
}
