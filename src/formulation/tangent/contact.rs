//! How a contact's wrench on its wheelset changes with the wheelset's motion.
//!
//! The wheelset is displaced by d and turned by w, its velocity changes by dv and its angular velocity by dW (world axes, about the
//! centre). With rho from the centre to the wheel's point, v_P = v + W x rho its velocity, and d rho and the rotation theta of the
//! contact's axes from [`crate::contact::search::migration`] (the contact migrates over wheel and rail while the wheelset moves):
//!
//! ```text
//! d delta = -n . (d + w x rho)                         the place makes delta stationary
//! dv_P    = dv + dW x rho + W x d rho
//! dn      = theta x n,  de1 = theta x e1
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
//! All of it is found in the contact's axes, where a force that turns with them changes by theta x F and a velocity seen from them by
//! -theta x v_P. Forces depend on p . e1, p . e2, p . n and w . n alone (p = d + w x rho, likewise for velocities), and the wrench has
//! no other parts: those four rows are also the columns that carry T_1, T_2, N and M_z to the centre.
//!
//! N_delta is that of the normal law, whose stiffness may depend on the penetration (`curvature = "patch"`). A contact that shares its
//! patch also changes with its share (see [`super`]).
//!
//! Left out:
//! - how K_h and the patch's shape change where the contact migrates to other curvatures. On S1002 and 60E1 it leaves 2 to 9 % of the
//!   smaller rows (y, yaw, pitch by position) and 3 % of the height's. Found by differences of the law along both profiles
//!   it made the linearised contacts three times as dear, and a coach took as many steps as without
//! - that damping changes N without the patch: 1 % of the lateral row by velocity
//! - how creep forces of constrained contacts follow their multiplier.

use crate::contact::creep::slopes::CreepSlopes;
use crate::contact::creepage::ContactAxes;
use crate::contact::normal::damping::{Approach, DampingLaw};
use crate::contact::search::algebraic::Pair;
use crate::contact::search::migration::{Migration, Row, Touch, add, material, row, sum};
use crate::contact::transient::slopes::TransientSlopes;
use crate::formulation::ContactReport;
use crate::mbs::body::BodyMotion;
use crate::mbs::tangent::WrenchTangent;
use nalgebra::{Matrix3, Vector3, Vector6};

/// Something linear in displacement and velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByMotion<const N: usize> {
    pub position: [Row; N],
    pub velocity: [Row; N],
}

impl<const N: usize> ByMotion<N> {
    pub fn times(mut self, factor: f64) -> Self {
        let rows = self.position.iter_mut().chain(&mut self.velocity);
        rows.flatten().for_each(|value| *value *= factor);
        self
    }
}

/// dN/d delta and dN/d delta'.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::formulation) struct NormalSlopes {
    pub by_penetration: f64,
    pub by_rate: f64,
    /// dN by the elastic force, which `by_penetration` has taken in.
    pub by_elastic: f64,
}

/// A contact's geometry with derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touching<'a> {
    axes: &'a ContactAxes,
    migration: Migration,
    /// w . n.
    turn: Row,
    /// Of the slip along e1 and e2, about n, and of v_P . n.
    slip: [Row; 3],
    parting: Row,
}

/// Change of a contact's penetration with displacement and rotation: `-n . (d + w x rho)`.
pub(super) fn penetration_by_pose(arm: &Vector3<f64>, normal: &Vector3<f64>) -> Row {
    material(arm, &-normal)
}

/// Slopes of the normal force of an elastic contact that carries some force.
pub(in crate::formulation) fn normal_slopes(damping: &dyn DampingLaw, report: &ContactReport) -> NormalSlopes {
    let (penetration, rate) = (report.penetration, report.penetration_rate);
    let elastic = report.stiffness * penetration * penetration.sqrt();
    let slopes = damping.slopes(&Approach { elastic, penetration, rate });
    NormalSlopes {
        by_penetration: report.share * ((1.0 + slopes.by_elastic) * report.elastic_slope + slopes.by_penetration),
        by_rate: report.share * slopes.by_rate,
        by_elastic: 1.0 + slopes.by_elastic,
    }
}

impl<'a> Touching<'a> {
    #[inline]
    pub fn new(report: &'a ContactReport, motion: &BodyMotion, pair: &Pair) -> Self {
        let (axes, arm) = (&report.axes, report.wheel_point - motion.position);
        let ContactReport { parameters, penetration, profiles, .. } = report;
        let migration = pair.migration(&Touch { parameters, axes, arm, penetration: *penetration, profiles });
        Self::of(report, motion, migration)
    }

    /// A contact that stays where it is on both bodies.
    pub fn staying(report: &'a ContactReport, motion: &BodyMotion) -> Self {
        let (axes, arm) = (&report.axes, report.wheel_point - motion.position);
        let none = [[0.0; 6]; 3];
        Self::of(
            report,
            motion,
            Migration { material: [&axes.e1, &axes.e2, &axes.normal].map(|axis| material(&arm, axis)), arm: none, turn: none },
        )
    }

    #[inline]
    fn of(report: &'a ContactReport, motion: &BodyMotion, migration: Migration) -> Self {
        let (axes, arm) = (&report.axes, report.wheel_point - motion.position);
        let spin = [motion.rotation.dot(&axes.e1), motion.rotation.dot(&axes.e2), report.slip.spin];
        let off = (motion.velocity + motion.rotation.cross(&arm)).dot(&axes.normal);
        let velocity = [report.slip.longitudinal, report.slip.lateral, off];
        let Migration { arm, turn, .. } = &migration;
        // W x d rho - theta x v_P
        let seen = |i: usize, j: usize| sum([spin[i], -spin[j], -velocity[j], velocity[i]], [&arm[j], &arm[i], &turn[i], &turn[j]]);
        let slip = [seen(1, 2), seen(2, 0), sum([spin[0], -spin[1]], [&turn[1], &turn[0]])];
        Touching { axes, turn: row(&Vector3::zeros(), &axes.normal), slip, parting: seen(0, 1), migration }
    }

    /// Change of the normal force, with that by the contact's share.
    pub fn normal_force(&self, slopes: NormalSlopes, shared: Row) -> ByMotion<1> {
        let normal = &self.migration.material[2];
        let mut position = shared;
        add(&mut position, -slopes.by_penetration, normal);
        add(&mut position, -slopes.by_rate, &self.parting);
        ByMotion { position: [position], velocity: [sum([-slopes.by_rate], [normal])] }
    }

    /// Change of the creep force with slip and normal force.
    #[inline]
    pub fn creep(&self, by_slip: &Matrix3<f64>, by_normal: &Vector3<f64>, normal: &ByMotion<1>) -> ByMotion<3> {
        let ([one, two, _], [along, across, spin]) = (&self.migration.material, &self.slip);
        let mut force = ByMotion { position: [[0.0; 6]; 3], velocity: [[0.0; 6]; 3] };
        for i in 0..3 {
            let factors = [by_slip[(i, 0)], by_slip[(i, 1)], by_slip[(i, 2)], by_normal[i]];
            force.position[i] = sum(factors, [along, across, spin, &normal.position[0]]);
            force.velocity[i] = sum(factors, [one, two, &self.turn, &normal.velocity[0]]);
        }
        force
    }

    /// Change of the creep force of steady rolling with the travelling speed V [m/s]; `travel` is the change of V with the centre's
    /// velocity, if that is free.
    #[inline]
    pub fn steady(
        &self,
        report: &ContactReport,
        slopes: &CreepSlopes,
        normal: &ByMotion<1>,
        (speed, travel): (f64, Option<Vector3<f64>>),
    ) -> ByMotion<3> {
        // The law is stated in axes turned into the rolling direction.
        let sign = Vector3::new(speed.signum(), speed.signum(), 1.0);
        let per_speed = 1.0 / speed.abs();
        let by_slip = slopes.by_creepage.map_with_location(|i, j, slope| sign[i] * sign[j] * slope * per_speed);
        let mut force = self.creep(&by_slip, &slopes.by_normal_force.component_mul(&sign), normal);
        if let Some(travel) = travel {
            let creepage = Vector3::new(report.creepage.longitudinal, report.creepage.lateral, report.creepage.spin);
            let by_speed = by_slip * creepage * speed.signum();
            for (row, by_speed) in force.velocity.iter_mut().zip(&by_speed) {
                for (value, travel) in row.iter_mut().zip(&travel) {
                    *value -= by_speed * travel;
                }
            }
        }
        force
    }

    /// Adds what a friction coefficient that changes along the rail and, with the turn of the axes about e1, across it makes of the creep force.
    pub fn add_friction(&self, by_friction: &Vector3<f64>, (along, across): (f64, f64), force: &mut ByMotion<3>) {
        let e1 = self.axes.e1;
        // The contact goes along the rail with the wheelset and beside it.
        let way = sum([1.0, 1.0], [&row(&e1, &Vector3::zeros()), &self.migration.arm[0]]);
        let friction = sum([along, across], [&way, &self.migration.turn[0]]);
        for (own, by_friction) in force.position.iter_mut().zip(by_friction) {
            add(own, *by_friction, &friction);
        }
    }

    /// Adds the wrench's change from those of normal and creep force.
    pub fn add_wrench(&self, report: &ContactReport, normal: &ByMotion<1>, creep: &ByMotion<3>, wrench: &mut WrenchTangent) {
        let moment = report.creep_force.spin_moment;
        let force = [report.creep_force.longitudinal, report.creep_force.lateral, report.normal_force];
        let Migration { arm, turn, .. } = &self.migration;
        // theta x F, and d rho x F + M_z theta x n
        let across = |rows: &[Row; 3], i: usize, j: usize| sum([force[j], -force[i]], [&rows[i], &rows[j]]);
        let mut forces = [across(turn, 1, 2), across(turn, 2, 0), across(turn, 0, 1)];
        for (own, change) in forces.iter_mut().zip([&creep.position[0], &creep.position[1], &normal.position[0]]) {
            add(own, 1.0, change);
        }
        let mut moments = [across(arm, 1, 2), across(arm, 2, 0), across(arm, 0, 1)];
        add(&mut moments[0], moment, &turn[1]);
        add(&mut moments[1], -moment, &turn[0]);
        add(&mut moments[2], 1.0, &creep.position[2]);
        let [one, two, off] = &self.migration.material;
        let ContactAxes { e1, e2, .. } = self.axes;
        for (j, column) in wrench.by_position.data.0.iter_mut().enumerate() {
            add(column, forces[0][j], one);
            add(column, forces[1][j], two);
            add(column, forces[2][j], off);
            add(column, moments[2][j], &self.turn);
            for i in 0..3 {
                column[3 + i] += e1[i] * moments[0][j] + e2[i] * moments[1][j];
            }
        }
        for (j, column) in wrench.by_velocity.data.0.iter_mut().enumerate() {
            add(column, creep.velocity[0][j], one);
            add(column, creep.velocity[1][j], two);
            add(column, normal.velocity[0][j], off);
            add(column, creep.velocity[2][j], &self.turn);
        }
    }

    /// The wrench of a change of the creep force alone: longitudinal, lateral, moment.
    pub fn wrench_of(&self, creep: [f64; 3]) -> Vector6<f64> {
        let [one, two, _] = &self.migration.material;
        sum(creep, [one, two, &self.turn]).into()
    }

    /// Rates of the deflections and of the rolled-in spin by displacement and velocity.
    pub fn state_rates(&self, slopes: &TransientSlopes) -> ByMotion<3> {
        let [one, two, _] = &self.migration.material;
        let [along, across, spin] = &self.slip;
        let (by_slip, by_spin) = (&slopes.rate_by_slip, slopes.spin_rate_by_spin);
        let part = |i: usize, rows: [&Row; 2]| sum([by_slip[(i, 0)], by_slip[(i, 1)]], rows);
        ByMotion {
            position: [part(0, [along, across]), part(1, [along, across]), sum([by_spin], [spin])],
            velocity: [part(0, [one, two]), part(1, [one, two]), sum([by_spin], [&self.turn])],
        }
    }
}
