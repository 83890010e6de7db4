//! Where a place of contact will be after a small motion of its wheel: where the next iteration begins.
//!
//! In the rail's section, with the tangent's direction theta, curvatures kappa of the wheel's trace and of the rail, arc lengths s along
//! both and the distance d, a place and a ridge keep (to first order)
//!
//! ```text
//! kappa_w s_w + dh = kappa_r s_r,   s_w + tau = s_r (1 - kappa_r d),   tau = t . (dT + dh x rho)
//! ```
//!
//! while the tread's point T moves by dT and the axle rolls by dh (rho leads from T to the contact). So
//!
//! ```text
//! s_r = (kappa_w tau - dh) / (kappa_w (1 - kappa_r d) - kappa_r),   s_w = s_r (1 - kappa_r d) - tau
//! ```
//!
//! With k = a . t, its part k' that is not the rail's own direction and the half spacing b of the tread circles, the lead is about
//! `b k' + (u + R R') k`. That is Newton's first step, without reading the profiles once more. What is left out (k^2, turns of the rail) and
//! what is of second order remains to the iteration: any start gives the same place.

use crate::contact::search::algebraic::{ContactLocation, Pair, SurfaceParameters};
use crate::contact::search::global::WheelPose;

/// Numbers of a pose that a prediction counts from.
pub const POSE: usize = 5;

/// Furthest that a place is thought to go, m: at longer ways second order matters more.
const FURTHEST: f64 = 1e-3;

/// Derivatives of u and of eta by the tread point's place outward and up [-] and by roll [m], then of the lead by k, k' [m] and u [-].
pub type Prediction = [f64; 9];

/// What of a pose a prediction knows.
pub(super) fn pose_of(standing: &WheelPose) -> [f64; POSE] {
    [standing[0], standing[1], standing[2], standing[3], standing[3] - standing[4]]
}

/// The prediction for a contact or ridge that has been located.
#[inline]
pub(super) fn prediction(pair: &Pair, pose: &WheelPose, radius: f64, found: &ContactLocation) -> Prediction {
    let (wheel, rail) = (&found.wheel_profile, &found.rail_profile);
    let (wheel_rise, rail_rise) = (1.0 + wheel.d1 * wheel.d1, 1.0 + rail.d1 * rail.d1);
    let (per_wheel, per_rail) = (1.0 / wheel_rise.sqrt(), 1.0 / rail_rise.sqrt());
    let own = -wheel.d2 / wheel_rise * per_wheel;
    let other = rail.d2 / rail_rise * per_rail;
    let open = 1.0 + other * found.penetration;
    let per_bend = 1.0 / (own * open - other);
    let (u, lower, roll) = (found.parameters.wheel, wheel.value - radius, pose[2]);
    let arm = [u + lower * roll, u * roll - lower];
    let along = [per_rail, rail.d1 * per_rail];
    let shift = [along[0], along[1], along[1] * arm[0] - along[0] * arm[1]];
    // s_r and s_w by the three motions.
    let on_rail = [0, 1, 2].map(|i| (own * shift[i] - if i == 2 { 1.0 } else { 0.0 }) * per_bend);
    let on_wheel = [0, 1, 2].map(|i| on_rail[i] * open - shift[i]);
    let ahead = [u + wheel.value * wheel.d1, pair.wheel.half_spacing, pose[3] * (wheel_rise + wheel.value * wheel.d2)]
        // A pose counts k along outward x up, which points back on the right.
        .map(|ahead| ahead * pair.rail.side.sign());
    let [a, b, c] = on_wheel.map(|s| s * per_wheel);
    let [d, e, f] = on_rail.map(|s| s * per_rail);
    [a, b, c, d, e, f, ahead[0], ahead[1], ahead[2]]
}

/// Where a place will be found about, after a motion.
#[inline]
pub(super) fn after(start: SurfaceParameters, prediction: &Prediction, moved: &[f64; POSE]) -> SurfaceParameters {
    let along = |from: usize| (0..3).map(|i| prediction[from + i] * moved[i]).sum::<f64>();
    let (du, deta) = (along(0), along(3));
    // Not so where a place melts into a ridge.
    if !(du.abs() < FURTHEST && deta.abs() < FURTHEST) {
        return start;
    }
    SurfaceParameters {
        wheel: start.wheel + du,
        rail: start.rail + deta,
        lead: start.lead + prediction[6] * moved[3] + prediction[7] * moved[4] + prediction[8] * du,
        ..start
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::search::global::{GlobalSearch, Minima};
    use crate::geometry::Side;
    use crate::geometry::profile::Part;
    use crate::geometry::profile::test_profiles::built_in;
    use crate::geometry::surface::Wheel;
    use crate::geometry::track::Rail;
    use crate::math::rotation::AxleFrame;
    use nalgebra::Vector3;

    #[test]
    fn order_what_is_left_to_the_iteration_is_of_second_order() {
        for side in Side::BOTH {
            let wheel = Wheel { side, profile: built_in("kind = \"s1002\"\nradius = 0.46\n", Part::Wheel), half_spacing: 0.75 };
            let rail = Rail::new(side, built_in("kind = \"60e1\"\n", Part::Rail), 0.75, 0.025, &[]);
            let search = GlobalSearch::new(wheel.profile.as_ref(), rail.profile.as_ref());
            // Lateral, vertical, yaw, roll.
            for motion in [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 10.0, 0.0], [0.0, 0.0, 0.0, 1.0]] {
                let located = |size: f64, start: &dyn Fn(&WheelPose, &Pair) -> SurfaceParameters| {
                    let frame = AxleFrame::new(2e-3 + size * motion[2], 1e-3 + size * motion[3]);
                    let centre = Vector3::new(0.0, side.sign() * 2e-3 + size * motion[0], 0.46 + size * motion[1]);
                    let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &frame.axes, distance: 0.0 };
                    let pose = search.standing(&pair);
                    let begin = start(&pose, &pair);
                    let found = pair.locate(&begin).unwrap();
                    let q = found.parameters;
                    (
                        found,
                        pose,
                        prediction(&pair, &pose, search.radius(), &found),
                        [begin.wheel - q.wheel, begin.rail - q.rail, begin.lead - q.lead],
                    )
                };
                let (first, pose, known, _) = located(0.0, &|_, pair| {
                    let mut minima = Minima::default();
                    search.find(pair, 5e-3, &mut minima);
                    minima.deepest().unwrap().parameters
                });
                let left = |size: f64| {
                    let forecast = |now: &WheelPose, _: &Pair| {
                        let (from, to) = (pose_of(&pose), pose_of(now));
                        after(first.parameters, &known, &std::array::from_fn(|i| to[i] - from[i]))
                    };
                    let (found, _, _, off) = located(size, &forecast);
                    let (p, q) = (first.parameters, found.parameters);
                    (off.map(f64::abs), [p.wheel - q.wheel, p.rail - q.rail, p.lead - q.lead].map(f64::abs))
                };
                let [(coarse, _), (fine, way)] = [left(2e-5), left(2e-6)];
                println!("{side:?} {motion:?}: {coarse:?}, a tenth of the motion {fine:?} of {way:?}");
                for i in 0..3 {
                    // Squares of k are left out: k dk times a metre or so, here twice that.
                    let least = 2.0 * 2e-3 * (2e-6 * motion[2]) + 1e-4 * way[i] + 1e-11;
                    assert!(fine[i] < 0.02 * coarse[i] + least, "{side:?} {motion:?} {i}: {coarse:?} {fine:?} of {way:?}");
                }
            }
        }
    }
}
