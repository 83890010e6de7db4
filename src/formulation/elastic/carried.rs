//! What the patches of one wheel carry.

use super::super::ContactReport;
use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters};
use crate::contact::strips::{Creep, MOST, Part};
use crate::mbs::body::{BodyMotion, Wrench};
use nalgebra::Vector3;

/// What the parts of a wheel carry, in the order of the strips.
#[derive(Default)]
pub(in crate::formulation) struct Carried {
    /// Parts; reports beyond them are empty.
    pub count: usize,
    pub reports: [ContactReport; MOST],
    pub(super) creeps: [Creep; MOST],
    /// Sizes of the normal forces, N: the normal force of a report is the sum of pressures, which is more where a patch bends.
    pub(super) forces: [f64; MOST],
    /// Moments of these forces about the centres of the parts, N m.
    pub(super) couples: [Vector3<f64>; MOST],
}

impl Carried {
    /// Completes the reports of the parts and adds their forces to the wheelset's wrench about its centre, which is there.
    pub fn add_to(&mut self, wrench: &mut Wrench, centre: &Vector3<f64>) {
        let carries = |all: &(&mut ContactReport, (&Creep, &f64))| all.0.normal_force > 0.0;
        let parts = self.reports.iter_mut().zip(self.creeps.iter().zip(&self.forces)).zip(&self.couples);
        for ((report, (creep, force)), couple) in parts.filter(|(part, _)| carries(part)) {
            report.couple = *couple;
            report.force = report.axes.normal * *force + creep.force;
            let along = |axis: &Vector3<f64>| creep.force.dot(axis);
            (report.creep_force.longitudinal, report.creep_force.lateral) = (along(&report.axes.e1), along(&report.axes.e2));
            report.creep_force.spin_moment = creep.moment;
            report.friction_bound = Some(creep.bound);
            report.add_to(wrench, report.force, centre);
        }
    }
}

/// A part as a place where wheel and rail touch.
pub(in crate::formulation) fn location(part: &Part, motion: &BodyMotion) -> ContactLocation {
    let axes = &motion.frame.axes;
    let angle = part.arm.dot(&axes.column(0)).atan2(-part.arm.dot(&axes.column(2)));
    let [wheel, rail] = part.coordinates;
    ContactLocation {
        parameters: SurfaceParameters { wheel, angle, lead: part.lead, rail },
        wheel_point: motion.position + part.arm,
        normal: part.normal,
        forward: part.forward,
        penetration: part.overlap,
        wheel_profile: part.profiles[0],
        rail_profile: part.profiles[1],
        iterations: 0,
    }
}

pub(super) fn creep_of(report: &ContactReport, friction: f64) -> Creep {
    let (axes, creep) = (&report.axes, &report.creep_force);
    Creep {
        force: axes.e1 * creep.longitudinal + axes.e2 * creep.lateral,
        moment: creep.spin_moment,
        bound: friction * report.normal_force,
    }
}
