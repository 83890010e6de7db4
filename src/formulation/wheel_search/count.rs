//! How many places of one wheel can be near its rail at once: what `contact.points` is where a scene does not say.
//!
//! A wheel that presses at more places than are followed loses the force of the shallowest, and its force jumps where two are equally deep
//! (S1002 on 60E2 on its flange's root: 29 %, APTA340 on 60E1: 17 %). The wheel is led across its rail, resting on its deepest place, and the
//! places are counted that are not much less deep.

use super::{FAR, MOST_POINTS, PreparedSearches, WheelSearch};
use crate::contact::search::algebraic::Pair;
use crate::contact::search::global::Minima;
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Rail, Track};
use crate::math::rotation::AxleFrame;
use nalgebra::Vector3;

/// Fewest that are asked for, so that scenes whose profiles differ little have the same variables.
pub const FEWEST: usize = 2;
/// How far to each side [m], and in which steps.
const WIDEST: f64 = 15e-3;
const STEP: f64 = 0.1e-3;
/// Places that are less deep than the deepest by no more than this count, m: twice what wheels are pressed into rails.
const WITHIN: f64 = 0.3e-3;
/// The wheel rests when its deepest place is this near, m; and attempts.
const RESTS: f64 = 1e-3;
const ATTEMPTS: usize = 6;

/// Most places of any of these wheels that can carry at once, from 2 to [`MOST_POINTS`].
pub fn needed(wheels: &[Wheel], track: &Track, prepared: &PreparedSearches) -> usize {
    let mut most = FEWEST;
    for (i, wheel) in wheels.iter().enumerate() {
        let rail = track.rail(wheel.side);
        // Wheelsets that are alike count once.
        if wheels[..i].iter().any(|other| other.side == wheel.side && other.is_like(wheel)) {
            continue;
        }
        if let Some(search) = prepared.of(&wheel.profile, &rail.profile) {
            most = most.max(places_across(&search, wheel, rail));
        }
    }
    most.min(MOST_POINTS)
}

/// Most places near each other in depth while the wheel rests on its deepest.
fn places_across(search: &WheelSearch, wheel: &Wheel, rail: &Rail) -> usize {
    let frame = AxleFrame::new(0.0, 0.0);
    let mut height = wheel.profile.at(0.0).value;
    let mut most = 0;
    for i in 0..=(2.0 * WIDEST / STEP) as i32 {
        let mut minima = Minima::default();
        for _ in 0..ATTEMPTS {
            let centre = Vector3::new(0.0, f64::from(i) * STEP - WIDEST, height);
            let pair = Pair { wheel, rail, centre: &centre, axes: &frame.axes, distance: 0.0 };
            search.search.find(&pair, FAR, &mut minima);
            let Some(deepest) = minima.deepest() else { break };
            height -= deepest.distance;
            if deepest.distance.abs() < RESTS {
                break;
            }
        }
        let Some(deepest) = minima.deepest().map(|deepest| deepest.distance) else { continue };
        most = most.max(minima.iter().filter(|minimum| minimum.distance <= deepest + WITHIN).count());
    }
    most
}
