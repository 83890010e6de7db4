//! How a contact's wrench on its wheelset changes with the wheelset's motion.
//!
//! The wheelset is displaced by d and turned by w, its velocity changes by dv and its angular velocity by dW (world axes, about the
//! centre). With rho from the centre to the wheel's point, v_P = v + W x rho its velocity, and d rho, dn, de1 from
//! [`crate::contact::search::wander`] (the contact wanders over wheel and rail while the wheelset moves):
//!
//! ```text
//! d delta = -n . (d + w x rho)                         the place makes delta stationary
//! dv_P    = dv + dW x rho + W x d rho
//! d delta' = -n . dv_P - v_P . dn
//! dN      = N_delta d delta + N_delta' d delta'        0 where the contact is a constraint
//! d slip  = (e1 . dv_P + v_P . de1,  e2 . dv_P + v_P . de2,  n . dW + W . dn),   d creepage = d slip / |V| - creepage dV / V
//! dT      = dT/d creepage . d creepage + dT/dN dN
//! dF      = n dN + N dn + sum(e_i dT_i + T_i de_i),    dM = d rho x F + rho x dF + n dM_z + M_z dn
//! ```
//!
//! Rolling radius and conicity are in W x d rho, yaw to lateral creepage in the turning of W that the multibody system adds by way of
//! dM/dW. A turn about the axle moves nothing.
//!
//! N_delta is that of the normal law, whose stiffness may depend on the penetration (`curvature = "patch"`): one secant of the law
//! over 1e-3 of delta, error about 3e-4. A contact that shares its patch also changes with its share (see [`super`]).
//!
//! Left out:
//! - how K_h and the patch's shape change where the contact wanders to other curvatures. On S1002 and 60E1 it leaves 2 to 9 % of the
//!   smaller rows (y, yaw, pitch by position) and 3 % of the height's. Found by differences of the law along both profiles
//!   it made the linearised contacts three times as dear, and a coach took as many steps as without
//! - that damping changes N without the patch: 1 % of the lateral row by velocity
//! - how creep forces of constrained contacts follow their multiplier.

use crate::contact::creep::slopes::CreepSlopes;
use crate::contact::normal::NormalLaw;
use crate::contact::normal::damping::{Approach, DampingLaw, damped_force};
use crate::contact::search::wander::{ByPose, Wander};
use crate::formulation::ContactReport;
use crate::geometry::surface::Wheel;
use crate::geometry::track::Rail;
use crate::mbs::body::BodyMotion;
use crate::mbs::tangent::WrenchTangent;
use nalgebra::{Matrix2, Matrix3, RowSVector, SMatrix, Vector3};

pub(super) type Row = RowSVector<f64, 6>;

/// Something linear in displacement and velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByMotion<const N: usize> {
    pub position: SMatrix<f64, N, 6>,
    pub velocity: SMatrix<f64, N, 6>,
}

/// dN/d delta and dN/d delta'.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NormalSlopes {
    pub by_penetration: f64,
    pub by_rate: f64,
}

/// A contact's geometry with derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touching {
    pub wander: Wander,
    lateral_by_pose: ByPose,
    /// Of the slip along e1, e2 and about n.
    pub slip: ByMotion<3>,
    penetration: Row,
    rate: ByMotion<1>,
}

/// Change of a contact's penetration with displacement and rotation: `-n . (d + w x rho)`.
pub(super) fn penetration_by_pose(wander: &Wander) -> Row {
    let normal = wander.location.normal;
    let moment = wander.arm.cross(&normal);
    -Row::from([normal.x, normal.y, normal.z, moment.x, moment.y, moment.z])
}

/// Step of the penetration for the normal law's secant, relative.
const SECANT: f64 = 1e-3;

/// Slopes of the normal force of an elastic contact that carries some force.
pub(super) fn normal_slopes(
    (normal, damping): (&dyn NormalLaw, &dyn DampingLaw),
    report: &ContactReport,
    wander: &Wander,
    (wheel, rail): (&Wheel, &Rail),
) -> NormalSlopes {
    let (delta, rate) = (report.penetration, report.penetration_rate);
    let elastic = report.stiffness * delta * delta.sqrt();
    let undivided = damped_force(damping, elastic, delta, rate);
    if !(delta > 0.0 && undivided > 0.0) {
        return NormalSlopes::default();
    }
    let deeper = normal.contact(&wander.location.shape(wheel, rail), (1.0 + SECANT) * delta);
    let stiffness = deeper.map_or(1.5 * elastic / delta, |deeper| (deeper.force - elastic) / (SECANT * delta));
    let slopes = damping.slopes(&Approach { elastic, penetration: delta, rate });
    let share = report.normal_force / undivided;
    NormalSlopes {
        by_penetration: share * ((1.0 + slopes.by_elastic) * stiffness + slopes.by_penetration),
        by_rate: share * slopes.by_rate,
    }
}

impl Touching {
    pub fn new(report: &ContactReport, motion: &BodyMotion, wander: Wander) -> Self {
        let (axes, spin) = (&report.axes, &motion.rotation);
        let velocity = motion.velocity + spin.cross(&wander.arm);
        let lateral_by_pose = axes.normal.cross_matrix() * wander.forward_by_pose - axes.e1.cross_matrix() * wander.normal_by_pose;
        let by_pose = spin.cross_matrix() * wander.arm_by_pose;
        let lever = -wander.arm.cross_matrix();
        let material = |direction: Vector3<f64>| -> Row {
            let mut row = Row::zeros();
            row.fixed_columns_mut::<3>(0).copy_from(&direction.transpose());
            row.fixed_columns_mut::<3>(3).copy_from(&(direction.transpose() * lever));
            row
        };
        let turn = |direction: Vector3<f64>| -> Row {
            let mut row = Row::zeros();
            row.fixed_columns_mut::<3>(3).copy_from(&direction.transpose());
            row
        };
        let slip = |unit: Vector3<f64>, unit_by_pose: &ByPose| -> Row { unit.transpose() * by_pose + velocity.transpose() * unit_by_pose };
        let along_normal = slip(axes.normal, &wander.normal_by_pose);
        Touching {
            lateral_by_pose,
            slip: ByMotion {
                position: SMatrix::from_rows(&[
                    slip(axes.e1, &wander.forward_by_pose),
                    slip(axes.e2, &lateral_by_pose),
                    spin.transpose() * wander.normal_by_pose,
                ]),
                velocity: SMatrix::from_rows(&[material(axes.e1), material(axes.e2), turn(axes.normal)]),
            },
            penetration: -material(axes.normal),
            rate: ByMotion { position: -along_normal, velocity: -material(axes.normal) },
            wander,
        }
    }

    /// Change of the normal force.
    pub fn normal_force(&self, slopes: NormalSlopes) -> ByMotion<1> {
        ByMotion {
            position: self.penetration * slopes.by_penetration + self.rate.position * slopes.by_rate,
            velocity: self.rate.velocity * slopes.by_rate,
        }
    }

    /// Change of the creep force of steady rolling with the travelling speed V [m/s]; `travel` is the change of V with the centre's
    /// velocity, if that is free.
    pub fn steady(
        &self,
        report: &ContactReport,
        slopes: &CreepSlopes,
        normal: &ByMotion<1>,
        (speed, travel): (f64, Option<Vector3<f64>>),
    ) -> ByMotion<3> {
        // The law is stated in axes turned into the rolling direction.
        let turn = Matrix3::from_diagonal(&Vector3::new(speed.signum(), speed.signum(), 1.0));
        let by_creepage = turn * slopes.by_creepage * turn / speed.abs();
        let by_normal = turn * slopes.by_normal_force;
        let mut force = ByMotion {
            position: by_creepage * self.slip.position + by_normal * normal.position,
            velocity: by_creepage * self.slip.velocity + by_normal * normal.velocity,
        };
        if let Some(travel) = travel {
            let creepage = Vector3::new(report.creepage.longitudinal, report.creepage.lateral, report.creepage.spin);
            let by_speed = by_creepage * creepage * speed.signum();
            let mut linear = force.velocity.fixed_columns_mut::<3>(0);
            linear -= by_speed * travel.transpose();
        }
        force
    }

    /// The wrench's change from those of normal and creep force.
    pub fn wrench(&self, report: &ContactReport, normal: &ByMotion<1>, creep: &ByMotion<3>) -> WrenchTangent {
        let (axes, moment) = (&report.axes, report.creep_force.spin_moment);
        let arm = self.wander.arm.cross_matrix();
        let in_space =
            |normal: &Row, creep: &SMatrix<f64, 3, 6>| -> ByPose { axes.normal * normal + axes.e1 * creep.row(0) + axes.e2 * creep.row(1) };
        let force_by_velocity = in_space(&normal.velocity, &creep.velocity);
        let turning = self.wander.normal_by_pose * report.normal_force
            + self.wander.forward_by_pose * report.creep_force.longitudinal
            + self.lateral_by_pose * report.creep_force.lateral;
        let force_by_position = in_space(&normal.position, &creep.position) + turning;
        let moment_by_position = arm * force_by_position - report.force.cross_matrix() * self.wander.arm_by_pose
            + axes.normal * creep.position.row(2)
            + self.wander.normal_by_pose * moment;
        let moment_by_velocity = arm * force_by_velocity + axes.normal * creep.velocity.row(2);
        WrenchTangent {
            by_position: stacked(&force_by_position, &moment_by_position),
            by_velocity: stacked(&force_by_velocity, &moment_by_velocity),
        }
    }

    /// The wrench of a change of the creep force alone: longitudinal, lateral, moment.
    pub fn wrench_of(&self, report: &ContactReport, creep: &Vector3<f64>) -> nalgebra::Vector6<f64> {
        let force = report.axes.e1 * creep.x + report.axes.e2 * creep.y;
        let moment = self.wander.arm.cross(&force) + report.axes.normal * creep.z;
        nalgebra::Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
    }

    /// Rates of the deflections by displacement and velocity.
    pub fn deflection_rates(&self, by_slip: &Matrix2<f64>) -> ByMotion<2> {
        ByMotion { position: by_slip * self.slip.position.fixed_rows::<2>(0), velocity: by_slip * self.slip.velocity.fixed_rows::<2>(0) }
    }
}

fn stacked(upper: &ByPose, lower: &ByPose) -> SMatrix<f64, 6, 6> {
    let mut matrix = SMatrix::<f64, 6, 6>::zeros();
    matrix.fixed_rows_mut::<3>(0).copy_from(upper);
    matrix.fixed_rows_mut::<3>(3).copy_from(lower);
    matrix
}
