//! ECF-A: elastic contact located by algebraic equations (Eqs. 24-28 of the paper).
//!
//! The wheel has six degrees of freedom relative to the rail. Per contact, four equations give the surface
//! parameters; they are solved to rounding at each evaluation and are not integrated. There is no multiplier. The
//! penetration `delta` (positive in contact) gives the normal force `N = K_h delta^1.5 + C delta delta'`, never
//! tensile; `delta' = -v . n` with the velocity v of the wheel's material point, which is exact because the located
//! points make delta stationary. At lift-off (delta <= 0) all forces vanish and the search goes on, so landing needs
//! nothing special. Forces act at the wheel's undeformed material point; creepage is taken there too.
//!
//! Memory per contact: the four surface parameters of the last evaluation, as warm start.

use super::{
    ContactFailure, ContactReport, EvaluationError, Formulation, LEFT_FRICTION, Model, RIGHT_FRICTION, WHEELSET_INPUTS, Wheelset,
    Workspace, contact_index,
};
use crate::contact::creepage::{ContactAxes, in_rolling_direction};
use crate::contact::normal::damped_force;
use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters, locate};
use crate::geometry::Side;
use crate::mbs::body::{BodyMotion, Wrench};
use crate::settings::Entry;
use nalgebra::Vector3;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "ECF-A",
    summary: "elastic contact, points located by four algebraic equations per wheel",
    reference: "paper, section 4.1, Eqs. 24-28",
    parse: |_| Ok(&EcfA),
};

/// The formulation has no settings of its own.
#[derive(Debug)]
pub struct EcfA;

const MEMORY: usize = 4;

/// Deeper than this, half-space elasticity has long ended: the initial position is wrong.
const DEEPEST: f64 = 5e-3;

impl Formulation for EcfA {
    fn memory_per_contact(&self) -> usize {
        MEMORY
    }

    fn lead(&self, memory: &[f64]) -> f64 {
        memory[2]
    }

    #[inline]
    fn derivative(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        t: f64,
        inputs: &[f64],
        y: &[f64],
        memory: &mut [f64],
        dy: &mut [f64],
    ) -> Result<(), EvaluationError> {
        model.system.apply_forces(y, &mut workspace.system);
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            let motion = workspace.system.motions[wheelset.body];
            let inputs = &inputs[index * WHEELSET_INPUTS..(index + 1) * WHEELSET_INPUTS];
            let wrench = &mut workspace.system.wrenches[wheelset.body];
            *wrench += external_wrench(&motion, inputs);
            for (side, friction) in [(Side::Left, inputs[LEFT_FRICTION]), (Side::Right, inputs[RIGHT_FRICTION])] {
                let contact = contact_index(index, side);
                let memory = &mut memory[contact * MEMORY..(contact + 1) * MEMORY];
                let report = wheel_contact(model, wheelset, side, &motion, friction, memory, wrench).map_err(|cause| EvaluationError {
                    time: t,
                    wheelset: wheelset.name.clone(),
                    side,
                    cause,
                })?;
                workspace.search_iterations += report.iterations as u64;
                workspace.contacts[contact] = report;
            }
        }
        model.system.derivative(y, &mut workspace.system, dy);
        Ok(())
    }
}

/// Torque about the axle and forces at the centre that a master applies.
#[inline]
fn external_wrench(motion: &BodyMotion, inputs: &[f64]) -> Wrench {
    Wrench {
        force: Vector3::new(0.0, inputs[super::LATERAL_FORCE], inputs[super::VERTICAL_FORCE]),
        moment: motion.axle() * inputs[super::DRIVE_TORQUE],
    }
}

/// Locates one wheel's contact, loads it and adds its forces to the wheelset's wrench.
#[inline]
fn wheel_contact(
    model: &Model,
    wheelset: &Wheelset,
    side: Side,
    motion: &BodyMotion,
    friction_factor: f64,
    memory: &mut [f64],
    wrench: &mut Wrench,
) -> Result<ContactReport, ContactFailure> {
    let wheel = wheelset.wheel(side);
    let rail = model.track.rail(side);
    let start = SurfaceParameters { wheel: memory[0], angle: memory[1], lead: memory[2], rail: memory[3] };
    let distance = motion.position.x;
    let search = |start: &SurfaceParameters| locate(wheel, rail, &motion.position, &motion.frame.axes, distance, start);
    // A warm start that has gone stale (a jump of state) must not fail where a cold start succeeds.
    let found = search(&start).or_else(|_| search(&SurfaceParameters::default())).map_err(|failure| ContactFailure::NotFound {
        iterations: failure.iterations,
        residual: failure.residual,
        y: motion.position.y,
    })?;
    let p = found.parameters;
    memory.copy_from_slice(&[p.wheel, p.angle, p.lead, p.rail]);

    let axes = ContactAxes::new(found.normal, found.forward);
    let velocity = motion.material_velocity(&found.wheel_point);
    let penetration_rate = -velocity.dot(&found.normal);
    let mut report = ContactReport {
        parameters: p,
        penetration: found.penetration,
        penetration_rate,
        axes,
        iterations: found.iterations,
        ..ContactReport::default()
    };
    if found.penetration > 0.0 {
        check_validity(&found, wheel.profile.range(), rail.profile.range(), motion)?;
        let (rolling, across) = found.half_curvatures();
        let elastic = model.laws.normal.contact(rolling, across, found.penetration)?;
        let speed = wheelset.imposed_speed.unwrap_or(motion.velocity.x);
        report.stiffness = elastic.stiffness;
        report.patch = elastic.patch;
        report.normal_force = damped_force(elastic.force, model.laws.damping, found.penetration, penetration_rate);
        report.creepage = axes.creepage(&velocity, &motion.rotation, speed);
        // A polynomial input may pass below zero between communication points.
        let friction = model.laws.friction * friction_factor.max(0.0);
        report.creep_force = in_rolling_direction(speed, report.creepage, |creepage| {
            model.laws.creep.force(elastic.patch, report.normal_force, friction, creepage)
        });
        let creep = report.creep_force;
        report.force = axes.normal * report.normal_force + axes.e1 * creep.longitudinal + axes.e2 * creep.lateral;
        wrench.add_at(report.force, &found.wheel_point, &motion.position);
        wrench.moment += axes.normal * creep.spin_moment;
    }
    Ok(report)
}

/// A loaded contact must lie on both profiles and be shallow.
#[inline]
fn check_validity(found: &ContactLocation, wheel: (f64, f64), rail: (f64, f64), motion: &BodyMotion) -> Result<(), ContactFailure> {
    let y = motion.position.y;
    for (part, found, (first, last)) in [("wheel", found.parameters.wheel, wheel), ("rail", found.parameters.rail, rail)] {
        if !(found >= first && found <= last) {
            return Err(ContactFailure::OffProfile { part, found, first, last, y });
        }
    }
    if found.penetration > DEEPEST {
        return Err(ContactFailure::TooDeep { penetration: found.penetration, z: motion.position.z });
    }
    Ok(())
}
