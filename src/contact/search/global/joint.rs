//! Joints of the rail, where its curvature jumps (60E1: arcs of 300, 80 and 13 mm).
//!
//! Where a wheel's curvature lies between those on both sides of a joint, phi' changes its sign where the joint faces the wheel: a contact
//! and the ridge beside it are born or melt together just when phi = 0 there. How the wheel moves along the rail hardly matters
//! for the rest of the stretch: phi' keeps its sign on each side of the joint. So what must be known is one number, phi at the wheel's point
//! C(u) that faces the joint P, with the tangent T of the rail there:
//!
//! ```text
//! (C(u) - P) . T = 0
//! ```

use super::branch::{Limits, Part, Scan, State};
use super::watch::Extreme;
use nalgebra::Vector2;

/// Place to which the point opposite is driven, m.
const STEP: f64 = 1e-9;
/// Furthest step towards it, m.
const FAR: f64 = 2e-2;

impl Scan<'_> {
    /// The wheel's point opposite a knot of the rail, from one near it; `None` where it is not found at once.
    pub(super) fn opposite(&self, knot: usize, start: f64) -> Option<State> {
        let joint = &self.search.rail.curve.knots[knot];
        let (place, along) = (Vector2::new(joint.x, joint.y), Vector2::new(joint.cos, joint.sin));
        let knots = &self.search.wheel.knots;
        let (first, last) = (knots[0].x, knots[knots.len() - 1].x);
        let mut u = start;
        for _ in 0..8 {
            if !(first..=last).contains(&u) {
                return None;
            }
            let (value, slope) = self.pair.wheel.profile.value_and_slope(u);
            let trace = self.view.trace(u, value, slope);
            let (gap, cos, sin) = (trace.point - place, along.dot(&trace.tangent), along.perp(&trace.tangent));
            // How the trace is drawn together by yaw is left out: the next step makes up for it.
            let step = gap.dot(&along) / cos;
            if !(cos > 0.1 && step.abs() < FAR) {
                return None;
            }
            if step.abs() < STEP {
                let phi = if sin.abs() < cos { sin / cos } else { sin.atan2(cos) };
                return Some(State { u, distance: along.perp(&gap), phi, foot: knot as f64 });
            }
            u -= step;
        }
        None
    }

    /// Decides a part of a stretch that faces one joint of the rail, on both sides of which phi' keeps its sign while the wheel
    /// moves by so much, m, and its feet keep to the stretches from one to another.
    pub(super) fn beside_joint(&mut self, whole: &Part, (motion, from, to): (f64, usize, usize), most: f64, a: &State, b: &State) -> bool {
        let rail = &self.search.rail;
        let Some(knot) = rail.only_joint(from, to) else { return false };
        let wheel = &self.search.wheel.stretches[whole.stretch];
        let signs = [(from, knot - 1), (knot, to)].map(|(from, to)| {
            let rail = rail.over(from, to).curvature;
            let bending = self.bending(wheel, &Limits { phi: (-most, most), rail, ..*whole.limits });
            (bending.0 > 0.0 || bending.1 < 0.0).then_some(bending.0 > 0.0)
        });
        let [Some(before), Some(behind)] = signs else { return false };
        // With equal signs it does not matter where the joint is.
        let joint = if before == behind { Some(*b) } else { self.opposite(knot, a.u + (b.u - a.u) * share(a.foot, b.foot, knot)) };
        let Some(joint) = joint else { return false };
        let inside = before != behind && joint.u > a.u && joint.u < b.u;
        self.certificates.add(motion, (whole.stretch, whole.stretch + 1));
        if before != behind {
            let steady = joint.phi.abs() / Self::turning(whole.limits.rail, whole.limits.distance.0);
            self.certificates.point(steady, Extreme::Joint(knot), joint.phi);
            // Once the joint has passed a place where the wheel's own curvature jumps, phi may be extreme there instead.
            for end in [a, b].into_iter().filter(|end| self.search.joints.contains(&end.u)) {
                let steady = end.phi.abs() / Self::turning(whole.limits.rail, whole.limits.distance.0);
                self.certificates.point(steady, Extreme::Wheel(end.u), end.phi);
            }
        }
        self.bent(if joint.u <= a.u { behind } else { before }, whole.limits, a);
        if inside {
            self.ends(whole.stretch, a, &joint);
            self.ends(whole.stretch, &joint, b);
        } else {
            self.ends(whole.stretch, a, b);
        }
        self.bend = Some(if joint.u >= b.u { before } else { behind });
        true
    }

    /// phi where it is extreme, and how much it changes at most for a motion by one metre; the rail lies opposite the wheel about
    /// where eta - u is `offset` [m].
    pub(super) fn extreme(&self, place: &Extreme, offset: f64) -> Option<(f64, f64)> {
        let rail = &self.search.rail;
        let found = match place {
            Extreme::Joint(knot) => self.opposite(*knot, rail.curve.knots.get(*knot)?.x - offset)?,
            Extreme::Wheel(u) => self.at(*u, rail.place(u + offset)),
        };
        Some((found.phi, self.turning_at(&found)))
    }

    /// How much phi changes at most near a place, 1/m.
    pub(super) fn turning_at(&self, place: &State) -> f64 {
        Self::turning(self.search.rail.facing(place.foot, place.foot, 0.0).curvature, place.distance)
    }
}

/// Where a place lies between two others, 0 to 1.
fn share(from: f64, to: f64, place: usize) -> f64 {
    let share = (place as f64 - from) / (to - from);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }
}
