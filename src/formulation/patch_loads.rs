//! What the patches of one wheel carry, and the places where they do.

use super::contact_report::ContactReport;
use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters};
use crate::contact::strips::{Creep, MOST, Part};
use crate::mbs::body::{BodyMotion, Wrench};
use nalgebra::Vector3;

/// What the parts of a wheel carry, in the order of the strips. It is large and lives in the workspace: what stands beyond the parts is of earlier evaluations.
#[derive(Clone, Debug, Default)]
pub(super) struct Carried {
    /// Number of parts.
    pub(super) count: usize,
    pub(super) all: [ContactReport; MOST],
    pub(super) creeps: [Creep; MOST],
    /// Sizes of the normal forces, N: the normal force of a report is the sum of pressures, which is more where a patch bends.
    pub(super) forces: [f64; MOST],
    /// Moments of these forces about the centres of the parts, N m.
    pub(super) couples: [Vector3<f64>; MOST],
}

/// What a wheel's patch carries.
#[derive(Clone, Debug, Default)]
pub(super) struct Loaded {
    /// What is shown: of the strips where they are pressed, else of the table.
    pub shown: Carried,
    /// Weight of the table, where both are asked.
    pub(super) weight: Option<f64>,
    pub(super) tabled: Carried,
}

impl Loaded {
    /// Of the table, with its weight, where both are asked.
    pub fn beside(&self) -> Option<(f64, &Carried)> {
        self.weight.map(|weight| (weight, &self.tabled))
    }

    /// Completes the reports of the parts and adds their forces to the wheelset's wrench about its centre, which is there.
    pub fn add_to(&mut self, wrench: &mut Wrench, centre: &Vector3<f64>) {
        let Loaded { shown: pressed, tabled, weight: Some(weight) } = self else { return self.shown.add_to(wrench, centre) };
        let (mut of_strips, mut of_table) = (Wrench::default(), Wrench::default());
        pressed.add_to(&mut of_strips, centre);
        tabled.add_to(&mut of_table, centre);
        wrench.force += of_strips.force * (1.0 - *weight) + of_table.force * *weight;
        wrench.moment += of_strips.moment * (1.0 - *weight) + of_table.moment * *weight;
        // What is shown adds up to what acts.
        let load: f64 = pressed.reports().iter().map(|report| report.normal_force).sum();
        if load > 0.0 {
            let more = (of_table.force - of_strips.force) * *weight;
            let grown = 1.0 + *weight * (tabled.all[0].normal_force / load - 1.0);
            for report in pressed.reports_mut().iter_mut().filter(|report| report.normal_force > 0.0) {
                report.force += more * (report.normal_force / load);
                report.normal_force *= grown;
            }
            let acts = of_strips.moment * (1.0 - *weight) + of_table.moment * *weight;
            let mut shown = Wrench::default();
            pressed
                .reports()
                .iter()
                .filter(|report| report.normal_force > 0.0)
                .for_each(|report| report.add_to(&mut shown, report.force, centre));
            if let Some(most) = pressed.reports_mut().iter_mut().max_by(|a, b| a.normal_force.total_cmp(&b.normal_force)) {
                most.couple += acts - shown.moment;
            }
        }
    }
}

impl Carried {
    /// By part.
    pub fn reports(&self) -> &[ContactReport] {
        &self.all[..self.count]
    }

    pub fn reports_mut(&mut self) -> &mut [ContactReport] {
        &mut self.all[..self.count]
    }

    /// Completes the reports of the parts and adds their forces to the wheelset's wrench about its centre, which is there.
    pub fn add_to(&mut self, wrench: &mut Wrench, centre: &Vector3<f64>) {
        let carries = |all: &(&mut ContactReport, (&Creep, &f64))| all.0.normal_force > 0.0;
        let parts = self.all[..self.count].iter_mut().zip(self.creeps.iter().zip(&self.forces)).zip(&self.couples);
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
pub(super) fn location(part: &Part, motion: &BodyMotion) -> ContactLocation {
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
