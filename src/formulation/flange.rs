//! Flanges that a scene leaves out (`effects.flange = "off"`): when they would have reached their rails, and by how much.
//!
//! At the end of each step the part of the whole profile that is left out is laid beside the rail: points of the wheel where its surface and the rail's would
//! touch, ahead or behind by the slope times the yaw over the rail, and their distance to the rail along its normal. Points stand 0.5 mm apart or nearer: an overlap is told
//! to some micrometres.

use super::step::WheelRef;
use super::{Model, Workspace};
use crate::geometry::surface::Wheel;
use crate::geometry::track::Rail;
use crate::mbs::body::BodyMotion;
use serde::{Deserialize, Serialize};

/// Points along the left-out part.
const POINTS: usize = 96;

/// What a wheel's flange would have done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Reach {
    /// Wheel, and since when, s.
    contact: usize,
    since: f64,
    /// Largest overlap, m, and when, s.
    deepest: (f64, f64),
}

/// Wheels whose flanges are left out, and those of them that would have reached the rail.
#[derive(Clone, Debug, Default)]
pub(super) struct Flanges {
    /// By contact, the whole wheel and where its flange begins, m.
    wheels: Vec<(usize, Wheel, f64)>,
    reached: Vec<Reach>,
}

/// Overlap of a left-out flange with its rail, m, negative where they are apart.
fn overlap(whole: &Wheel, from: f64, rail: &Rail, motion: &BodyMotion) -> f64 {
    let (first, _) = whole.profile.range();
    let section = rail.section(motion.distance);
    let along = section.d1.normalize();
    let axes = &motion.frame.axes;
    let yaw = axes.column(1).dot(&along);
    let mut deepest = f64::NEG_INFINITY;
    for k in 0..=POINTS {
        let u = first + (from - first) * k as f64 / POINTS as f64;
        let slope = whole.profile.at(u).d1;
        for angle in [slope * yaw, -slope * yaw] {
            let (point, _) = whole.point(&motion.position, axes, u, angle);
            let ahead = (point.position - section.origin).dot(&along);
            let there = section.continued(ahead);
            let off = point.position - there.origin;
            let (eta, height) = (off.dot(&there.outward), off.dot(&there.up));
            let surface = rail.profile.at(eta);
            deepest = deepest.max((surface.value - height) / surface.d1.hypot(1.0));
        }
    }
    deepest
}

impl Flanges {
    /// Of a model; `None` where no flange is left out.
    pub fn of(model: &Model) -> Option<Flanges> {
        let whole = |WheelRef { wheelset, side, contact }: WheelRef| {
            let wheel = wheelset.wheel(side);
            let (profile, from) = wheel.profile.left_out()?;
            Some((contact, Wheel { profile: profile.clone(), ..wheel.clone() }, from))
        };
        let wheels: Vec<_> = model.wheels().filter_map(whole).collect();
        (!wheels.is_empty()).then_some(Flanges { wheels, reached: Vec::new() })
    }

    /// Looks at the motion of an evaluation at `t` [s].
    pub fn look(&mut self, model: &Model, workspace: &Workspace, t: f64) {
        for WheelRef { wheelset, side, contact } in model.wheels() {
            let Some((_, whole, from)) = self.wheels.iter().find(|wheel| wheel.0 == contact) else { continue };
            let overlap = overlap(whole, *from, model.track.rail(side), &workspace.system.motions[wheelset.body]);
            if !(overlap > 0.0) {
                continue;
            }
            match self.reached.iter_mut().find(|reach| reach.contact == contact) {
                Some(reach) if overlap > reach.deepest.0 => reach.deepest = (overlap, t),
                Some(_) => {}
                None => self.reached.push(Reach { contact, since: t, deepest: (overlap, t) }),
            }
        }
    }

    /// Forgets what came after `time` [s].
    pub fn take_back(&mut self, time: f64) {
        self.reached.retain(|reach| reach.since <= time);
        for reach in self.reached.iter_mut().filter(|reach| reach.deepest.1 > time) {
            reach.deepest = (0.0, reach.since);
        }
    }

    /// Wheels that would have reached the rail.
    pub fn reached(&self) -> &[Reach] {
        &self.reached
    }

    /// Goes on with what was found before. Returns false and changes nothing when a wheel is none of these.
    pub fn go_on(&mut self, reached: Vec<Reach>) -> bool {
        let known = reached.iter().all(|reach| self.wheels.iter().any(|wheel| wheel.0 == reach.contact));
        if known {
            self.reached = reached;
        }
        known
    }

    /// The first wheel in words, and how many others.
    pub fn note(&self, named: impl Fn(usize) -> String) -> Option<String> {
        let first = self.reached.iter().min_by(|a, b| a.since.total_cmp(&b.since))?;
        let others = match self.reached.len() {
            1 => String::new(),
            more => format!("; others too ({} wheels in all)", more),
        };
        Some(format!(
            "{}: effects.flange = \"off\" leaves out a flange that would have reached the rail at {:.4} s, by up to {:.2} mm (at {:.4} s): from there on the run is that of a \
             wheel without flange{others}",
            named(first.contact),
            first.since,
            1e3 * first.deepest.0,
            first.deepest.1
        ))
    }
}
