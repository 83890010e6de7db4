//! A wheel whose patch is read from a table (`contact.patch = "table"`, [`crate::contact::strips`]).
//!
//! The table knows treads. Where a flange comes near its rail, or the pose is not in the table, the strips are asked; on the way both are, and mixed by a weight
//! that goes smoothly from one to the other: the table's own, times that of the flange's clearance.

use super::super::loading::{Contact, WheelAt};
use super::super::{ContactFailure, ContactReport};
use super::carried::{Carried, creep_of, location};
use crate::contact::normal::damping::damped_force;
use crate::contact::search::algebraic::Pair;
use crate::contact::strips::{Cells, FLANK, Looked, Section};
use crate::math::smooth_step::cubic_step;

/// Clearances of a flange [m] below which the strips are asked alone, and above which the table alone.
const CLEARANCES: (f64, f64) = (3e-6, 2.5e-5);

/// What the table says of a wheel.
pub(in crate::formulation) struct TabledWheel<'a> {
    pub wheel: &'a WheelAt<'a>,
    pub looked: Looked,
}

impl<'a> TabledWheel<'a> {
    /// `None` where it says nothing; from slopes of the rail and penetrations [m] at the places where the surfaces are nearest.
    pub fn find(wheel: &'a WheelAt<'a>, pair: &Pair, flanks: impl Iterator<Item = (f64, f64)>) -> Option<TabledWheel<'a>> {
        let table = wheel.model.tables.get(wheel.contact)?;
        let clear = |(_, penetration): (f64, f64)| cubic_step((-penetration - CLEARANCES.0) / (CLEARANCES.1 - CLEARANCES.0));
        let clear: f64 = flanks.filter(|(slope, _)| slope.abs() > FLANK).map(clear).product();
        if !(clear > 0.0) {
            return None;
        }
        let mut looked = table.look(pair, &Section::new(pair), wheel.model.laws.material)?;
        looked.weight *= clear;
        Some(TabledWheel { wheel, looked })
    }

    /// Its patch under load.
    ///
    /// # Errors
    /// [`ContactFailure`] where the wheel is not on its rail.
    pub fn load(&self) -> Result<Carried, ContactFailure> {
        let (wheel, part) = (self.wheel, &self.looked.part);
        let found = location(part, wheel.motion);
        let contact = Contact { wheel, found: &found, slot: 0, share: 1.0 };
        contact.check_depth()?;
        let mut report: ContactReport = contact.report();
        report.stiffness = part.force / (part.overlap * part.overlap.sqrt());
        (report.elastic_slope, report.patch) = (1.5 * part.force / part.overlap, part.patch);
        report.normal_force = damped_force(wheel.model.laws.damping.as_ref(), part.load, part.overlap, report.penetration_rate);
        let uneven = wheel.uneven(Cells::Fifths(&self.looked.fifths), part, &report.axes);
        contact.creep_as(&mut report, |law, rolling| uneven.force(law, rolling));
        let mut carried = Carried { count: 1, ..Carried::default() };
        carried.creeps[0] = creep_of(&report, wheel.friction_at(&report));
        carried.forces[0] = part.force * (report.normal_force / part.load);
        carried.reports[0] = report;
        Ok(carried)
    }
}
